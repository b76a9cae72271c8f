"""Normalisation and allocation of 32 400 patches x 500 bands, every band with a mass of its own.

    python bench/allocation.py [--bands 500] [--repeats 3]

Prints seconds per method, and the ratio to the plain Python integers of tests/reference/allocation.py,
which are timed on a few bands in the same run, turn and turn about with ours.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.sampling.allocation import AllocationMethod, allocate_bands, fixed_point_cumulative
from tests.reference import allocation as plain

N_PATCHES = 32_400
BUDGET_S = 5.0


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def ours(masses: np.ndarray, n: int, method: AllocationMethod) -> None:
    for band, mass in enumerate(masses):
        counts = allocate_bands(mass, [n], [band], method=method, seed=1)
        if int(counts.sum()) != n:
            raise SystemExit(f"{method.value}: band {band} has {int(counts.sum())} of {n} photons")


def plainly(masses: np.ndarray, n: int, method: AllocationMethod) -> None:
    for band, mass in enumerate(masses):
        cumulative = plain.fixed_point(mass.tolist())
        if method is AllocationMethod.SYSTEMATIC:
            counts = plain.systematic(cumulative, n, plain.offset_of(1, band))
        else:
            counts = plain.largest_remainder(cumulative, n)
        if counts != allocate_bands(mass, [n], [band], method=method, seed=1)[0].tolist():
            raise SystemExit(f"{method.value}: band {band} differs from the plain integers")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bands", type=int, default=500)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--photons", type=int, default=10**9)
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    few = rng.lognormal(sigma=2.0, size=(3, N_PATCHES))
    start = rng.lognormal(sigma=2.0, size=N_PATCHES)
    masses = start * np.linspace(0.5, 1.5, options.bands)[:, None] ** np.linspace(-1, 1, N_PATCHES)
    ours(few, options.photons, AllocationMethod.MULTINOMIAL)  # compiles
    print(f"{N_PATCHES} patches x {options.bands} bands, {options.photons:g} photons each, median of {options.repeats}")
    times = [seconds(lambda: [fixed_point_cumulative(mass) for mass in masses]) for _ in range(options.repeats)]
    print(f"{'normalisation alone':22s} {statistics.median(times):6.2f} s")
    for method in (AllocationMethod.SYSTEMATIC, AllocationMethod.LARGEST_REMAINDER, AllocationMethod.MULTINOMIAL):
        mine, theirs = [], []
        for _ in range(options.repeats):
            mine.append(seconds(partial(ours, masses, options.photons, method)))
            if method is not AllocationMethod.MULTINOMIAL:
                theirs.append(seconds(partial(plainly, few, options.photons, method)) / len(few))
        mine_s = statistics.median(mine)
        line = f"{method.value:22s} {mine_s:6.2f} s"
        if theirs:
            line += f"   plain Python integers {statistics.median(theirs) * options.bands / mine_s:5.1f} times as long"
        print(line + ("" if mine_s <= BUDGET_S else f"   ABOVE {BUDGET_S} s"))


if __name__ == "__main__":
    main()
