"""The environment of a plain processor: numba compiles for any x86-64, numpy leaves its wide vectors alone.

    env $(python -m tests.support.generic_processor) python -m pytest -q -n auto --dist loadfile

prints both settings; one word, `numba` or `numpy`, that one alone. What a test then finds in the last digits is
what a processor without these instructions finds.
"""

import sys


def dispatch_targets():
    """What numpy was built to choose from when it starts, by its own list."""
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__ as targets
    except ImportError:  # numpy 1
        from numpy.core._multiarray_umath import __cpu_dispatch__ as targets
    return list(targets)


def settings(words):
    """Variables of the environment for these words, all of them for none."""
    known = {
        "numba": ("NUMBA_CPU_NAME", "generic"),
        "numpy": ("NPY_DISABLE_CPU_FEATURES", ",".join(dispatch_targets())),
    }
    return dict(known[word] for word in (words or known))


if __name__ == "__main__":
    print(*(f"{name}={value}" for name, value in settings(sys.argv[1:]).items()), sep="\n")
