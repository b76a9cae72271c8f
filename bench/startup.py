"""What a user waits for: help, a first run, a first run ever; against importing numba.

python bench/startup.py [--repeats 7]
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from harness import in_turns, machine, ratio, run, verdict

SCENE = Path(__file__).resolve().parents[1] / "inputs" / "clear_day" / "amc.inp"
RUN_BAR, FIRST_BAR_S = 2.5, 6.0


@contextmanager
def folder() -> Iterator[Path]:
    """A folder that is gone afterwards."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def sample(photons: int, **environment: str) -> None:
    """`aomc-sky run` on one band of the clear day, photons written."""
    with folder() as out:
        command = [sys.executable, "-m", "aomc_sky", "run", str(SCENE), "--iterations", str(photons)]
        run([*command, "--waveband", "1", "--out", str(out / "run"), "-q"], **environment)


def first_ever(photons: int) -> None:
    """The same with no compiled kernel anywhere."""
    with folder() as cache:
        sample(photons, NUMBA_CACHE_DIR=str(cache))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    contenders = {
        "import numba": lambda: run([sys.executable, "-c", "import numba"]),
        "run, a million photons": lambda: sample(1_000_000),
        "run, 10 million photons": lambda: sample(10_000_000),
        "--help": lambda: run([sys.executable, "-m", "aomc_sky", "--help"]),
        "python -c pass": lambda: run([sys.executable, "-c", "pass"]),
    }
    print(machine())
    times = in_turns(contenders, options.repeats)
    first = in_turns(
        {
            "first ever, a million": lambda: first_ever(1_000_000),
            "first ever, 10 million": lambda: first_ever(10_000_000),
        },
        min(options.repeats, 3),
        warm_up=False,
    )
    print(f"median of {options.repeats} turns ({min(options.repeats, 3)} for a first run ever)")
    for name, taken in {**times, **first}.items():
        print(f"  {name:25s} {statistics.median(taken):7.3f} s")
    cached = ratio(times["run, a million photons"], times["import numba"])
    print(f"  run / import numba      {verdict(cached, RUN_BAR, at_least=False)}")
    for name, taken in first.items():
        print(f"  {name} [s] {verdict(statistics.median(taken), FIRST_BAR_S, at_least=False)}")


if __name__ == "__main__":
    main()
