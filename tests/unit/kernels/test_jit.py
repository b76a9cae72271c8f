"""What the decorator of the kernels asks the compiler for; for its cache see tests/faults/test_machine_faults.py."""

import subprocess
import sys

import numba
import pytest

from tests.support.processes import with_numba

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")


def test_kernels_ask_for_the_widest_vectors():
    from aomc_sky.kernels.jit import _WIDEST_VECTORS, KernelCompiler

    @numba.njit(pipeline_class=KernelCompiler)
    def twice(x):
        return x + x

    assert twice(2) == 4
    (text,) = twice.inspect_llvm().values()
    assert _WIDEST_VECTORS in text


_WITHOUT_BLAS = """
import sys
import numpy as np
import aomc_sky.kernels.emission.emit
assert not [name for name in sys.modules if name.startswith("scipy.linalg")]
import numba
@numba.njit
def product(a, b):
    return a @ b, np.linalg.inv(a)
both = product(2.0 * np.eye(3), np.ones((3, 3)))
assert (both[0] == 2.0).all() and (both[1] == 0.5 * np.eye(3)).all()
"""


def test_kernels_load_no_blas_and_leave_it_to_those_who_multiply_matrices():
    done = subprocess.run(
        [sys.executable, "-c", _WITHOUT_BLAS], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr


def test_code_under_the_name_of_another_is_not_run(tmp_path):
    """What two processes leave that saved at once: the index of one, and the code of the other."""
    from aomc_sky.kernels.jit import _CheckedFile

    file = _CheckedFile(cache_path=str(tmp_path), filename_base="kernel", source_stamp=1)
    file.save("float32", "code of float32")
    name = file._load_index()["float32"]
    file._save_index({"float64": name})
    assert file.load("float64") is None
    file.save("float64", "code of float64")
    assert file.load("float64") == "code of float64"


_VARIANTS = """
from aomc_sky.kernels.jit import inner, kernel

def variant(step):
    def loop(x):
        for _ in range(3):
{lines}
        return x
    return inner(loop)

one, two = variant(1.0), variant(2.0)

@kernel
def first(x):
    return one(x) + one(2.0 * x)

@kernel
def second(x):
    return two(x) + two(2.0 * x)
"""


def test_variants_of_one_text_cached_by_two_processes_keep_apart(tmp_path):
    """Too long to be inlined, they are found by name: with numba's own numbers one takes the place of the other."""
    lines = "\n".join(f"            x = x * 0.5 + step / (x + {k}.0)" for k in range(1, 60))
    (tmp_path / "variants.py").write_text(_VARIANTS.format(lines=lines))

    def printed(*kernels):
        calls = ", ".join(f"variants.{name}(1.0)" for name in kernels)
        where = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
        return with_numba(f"import variants; print({calls})", **where).split()

    alone = printed("first") + printed("second")
    assert alone[0] != alone[1]
    assert printed("first", "second") == alone
