"""Search the steps of the numbers that photons of a sky of one patch carry (`constants.NUMBER_STEPS`).

    python bench/number_steps.py [--candidates 30000] [--seed 12]

Photon of rank r has the coordinates frac(shift + r a), each with a step a of its own, beside the two of its direction
and the one that decides a rejection. The mean of exp(2 pi i h . x) over N photons has the variance
sin^2(pi N t) / (N sin^2(pi t)) of that of independent ones, t the distance of h . a from a whole number: a mode whose t
is small has up to 0.23 / t times the variance of chance. A set of steps is judged by two figures.

1. Of few photons. The least t over the 811 modes h of the direction and the numbers whose sizes add up to 5 or less,
   each with a number in it, divided by 20, 6, 2.5, 1.4 and 1 for sums of 1, 2, 3, 4 and 5. Two steps, those of the
   direction, are given, and there are more modes than t of 0.03 apart, so that some modes of sums 3 to 5 exceed chance
   at 100 photons: they are printed.
2. Of many photons. The smallest product of max(1, |h_i|) and t (Niederreiter 1992, section 5.1) over all h of products
   up to 2^20, 2^14 and 2^12 for one, two and three steps. It is taken for every set of at most three steps that holds
   one of ours, and divided by that of a good set, the best of ten random ones. Sets that hold a step of the direction
   count double: cells are small, and what happens in them matters less.

A candidate is a continued fraction of random ones, twos and a few threes, so that by itself it is nearly as even as
the golden ratio at every number of photons. Candidates whose figure 2 beside the fixed steps is below 0.7 go. Random
sets of three of the others change one step at a time for the one with the best figure 1. Of the sets whose figure 1 is
0.6 of the best one or more, that with the best figure 2 is taken. The search takes ten minutes.
"""

from __future__ import annotations

import argparse
from fractions import Fraction
from itertools import combinations, product

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT_STEP, NUMBER_STEPS, R2_STEP_U, R2_STEP_V

FIXED = {"u": int(R2_STEP_U), "v": int(R2_STEP_V), "accept": int(ACCEPT_STEP)}
LARGEST = {1: 1 << 20, 2: 1 << 14, 3: 1 << 12}
MIXED, MANY = 2.0, 0.9
SUMS = np.array([1.0, 20.0, 6.0, 2.5, 1.4, 1.0])
"""What t is divided by, for each sum of sizes; 0 does not occur."""
ENOUGH, CLOSE = 0.7, 0.6
"""Figure 2 of a candidate beside the fixed steps; share of the best figure 1 of a set whose figure 2 counts."""


def factors(size: int) -> tuple[list[np.ndarray], np.ndarray]:
    """All h up to the largest product, but 0, of +h and -h one, as columns of uint64; and their products."""
    h = np.arange(LARGEST[size] + 1)[:, None]
    for _ in range(1, size):
        product = np.prod(np.maximum(1, np.abs(h)), axis=1)
        rows = []
        for value in range(LARGEST[size] + 1):
            of = h[product * max(1, value) <= LARGEST[size]]
            rows += [np.column_stack([of, np.full(len(of), sign * value)]) for sign in ((1, -1) if value else (1,))]
        h = np.concatenate(rows)
    h = h[np.any(h != 0, axis=1)]
    product = np.prod(np.maximum(1, np.abs(h)), axis=1).astype(np.float64)
    return [np.ascontiguousarray(column).astype(np.uint64) for column in h.T], product


FACTORS = {size: factors(size) for size in LARGEST}


def figure(steps: tuple[int, ...]) -> float:
    """The smallest product of |h| times the distance from a whole number, in exact 64-bit fractions."""
    h, product = FACTORS[len(steps)]
    word = sum(part * np.uint64(step) for part, step in zip(h, steps, strict=True))
    distance = np.abs(word.view(np.int64).astype(np.float64)) * 2.0**-64
    return float((product * distance).min())


def step_of_fraction(x: float | Fraction) -> int:
    """A fraction in units of 2^-64, rounded to an odd number, whose multiples visit all 2^64."""
    return int(Fraction(x) * 2**64) | 1


def candidate(rng: np.random.Generator) -> int:
    """A step whose continued fraction has ones, twos and a few threes alone."""
    x = Fraction(0)
    for quotient in rng.choice([1, 2, 3], 90, p=[0.5, 0.35, 0.15]).tolist():
        x = 1 / (quotient + x)
    return step_of_fraction(x)


def good_figure(size: int, n: int = 200) -> float:
    """The figure that one in ten sets of random candidates reaches."""
    rng = np.random.default_rng(size)
    return float(np.quantile([figure(tuple(candidate(rng) for _ in range(size))) for _ in range(n)], MANY))


GOOD = {size: good_figure(size) for size in LARGEST}


def worst(step: int, others: dict[str, int], enough: float = -1.0) -> tuple[float, tuple[str, ...]]:
    """The lowest relative figure of the sets of a step with at most two others, and that set; stops below `enough`."""
    lowest, at = np.inf, ()
    for size in (0, 1, 2):
        for names in combinations(others, size):
            value = figure((step, *(others[name] for name in names))) / GOOD[size + 1]
            value *= MIXED if any(name in FIXED for name in names) else 1.0
            if value < lowest:
                lowest, at = value, names
            if lowest < enough:
                return lowest, at
    return lowest, at


def _modes(largest: int, most: int) -> np.ndarray:
    """Coefficients up to `largest` of u, v and the three numbers, with sums up to `most`, one of h and -h; (n, 5)."""
    several = product(range(-largest, largest + 1), repeat=5)
    many = np.array([h for h in several if sum(map(abs, h)) <= most and any(h[2:])])
    first = many[np.arange(len(many)), (many != 0).argmax(axis=1)]
    return many[first > 0]


MODES = _modes(5, 5)
SUM = np.abs(MODES).sum(axis=1)


def distances(steps: np.ndarray, modes: np.ndarray = MODES) -> np.ndarray:
    """The t of modes for sets of three steps, shape (..., n)."""
    t = steps @ modes[:, 2:].T + modes[:, :2] @ np.array([FIXED["u"], FIXED["v"]]) / 2.0**64
    return np.abs(t - np.rint(t))


def figures_of_few(steps: np.ndarray) -> np.ndarray:
    """Figure 1."""
    return (distances(steps) / SUMS[SUM]).min(axis=-1)


def variance(t: float, n: np.ndarray) -> np.ndarray:
    """Variance of a mode over that of independent photons."""
    return np.sin(np.pi * n * t) ** 2 / (n * np.sin(np.pi * t) ** 2)


def least_figure(steps: list[int], enough: float = -1.0) -> float:
    """Figure 2 of a set: that of its worst step beside all others; stops below `enough`."""
    lowest = np.inf
    for k, step in enumerate(steps):
        known = dict(FIXED) | {f"n{j + 1}": other for j, other in enumerate(steps) if j < k}
        lowest = min(lowest, worst(step, known, enough)[0])
        if lowest < enough:
            break
    return lowest


def search(n_candidates: int, seed: int, n_sets: int = 400, sweeps: int = 4) -> list[int]:
    """The three steps."""
    rng = np.random.default_rng(seed)
    pool = [candidate(rng) for _ in range(n_candidates)]
    pool = [step for step in pool if worst(step, dict(FIXED), ENOUGH)[0] >= ENOUGH]
    steps = np.array(pool) / 2.0**64
    sets = rng.integers(len(pool), size=(n_sets, 3))
    figures = figures_of_few(steps[sets])
    for k, one in product(range(sweeps * 3), range(n_sets)):
        others = np.repeat(steps[sets[one]][None], len(pool), axis=0)
        others[:, k % 3] = steps
        found = figures_of_few(others)
        if found.max() > figures[one]:
            sets[one, k % 3], figures[one] = found.argmax(), found.max()
    best, chosen = -1.0, [0, 0, 0]
    for one in np.argsort(-figures):
        if figures[one] < CLOSE * figures.max():
            break
        several = [pool[k] for k in sets[one]]
        value = least_figure(several, best)
        best, chosen = (value, several) if value > best else (best, chosen)
    return chosen


def show(steps: list[int]) -> None:
    """Both figures, and the modes whose variance is largest, for each sum of sizes."""
    known = dict(FIXED)
    for k, step in enumerate(steps, 1):
        value, names = worst(step, known)
        print(
            f"n{k}  0x{step:016X}  {step / 2**64:.16f}  worst figure {value:.3f} of a good one, with {' '.join(names)}"
        )
        known[f"n{k}"] = step
    t = distances(np.array(steps) / 2.0**64)
    numbers = np.unique(np.geomspace(100, 1e6, 20_000).astype(np.int64))
    print(
        "| sum of sizes | modes | above chance at 100 photons or more | worst one | "
        "variance at 100, 300, 1000, 10 000 | largest |"
    )
    print("| --- | --- | --- | --- | --- | --- |")
    for total in range(1, 6):
        some = np.flatnonzero(total == SUM)
        at = some[t[some].argmin()]
        terms = [
            f"{c:+d} {name}" for c, name in zip(MODES[at].tolist(), ("u", "v", "n1", "n2", "n3"), strict=True) if c
        ]
        few = ", ".join(f"{value:.2g}" for value in variance(t[at], np.array([100, 300, 1000, 10_000])))
        n_above = sum(variance(value, numbers).max() > 1 for value in t[some])
        print(
            f"| {total} | {some.size} | {n_above} | {' '.join(terms)} | {few} | {variance(t[at], numbers).max():.2g} |"
        )


def show_more_modes(steps: list[int], shown: int = 10) -> None:
    """The worst of the modes with coefficients up to 3, of any sum: more than a search can keep above chance."""
    modes, numbers = _modes(3, 15), np.unique(np.geomspace(100, 1e6, 20_000).astype(np.int64))
    t = distances(np.array(steps) / 2.0**64, modes)
    largest = np.array([variance(value, numbers).max() for value in t])
    print(f"{len(modes)} modes with coefficients up to 3: {np.sum(largest > 1)} above chance at 100 photons or more")
    for k in np.argsort(-largest)[:shown]:
        print(f"  {modes[k].tolist()} of u, v, n1, n2, n3: {largest[k]:.3g}")


def variance_of_equal_rings(step: int, width_deg: float, rings: int = 90) -> np.ndarray:
    """Variance of the share of photons in half a number's range over that of independent ones, of equal rings.

    The photons of a column (0 degrees) or a sector, one in each patch, of rings of 5 to 400 patches.
    """
    found = []
    for n_columns in range(5, 401):
        n = max(1, round(n_columns * width_deg / 360.0))
        rank = (np.arange(rings)[:, None] * n_columns + np.arange(n)).ravel()
        number = np.mod(rank * (step / 2.0**64), 1.0)
        in_half = np.mod(number[:, None] + np.arange(64) / 64, 1.0) < 0.5
        found.append(in_half.mean(axis=0).var() * rank.size / 0.25)
    return np.array(found)


def show_rings(steps: list[int]) -> None:
    """The worst and the median of equal rings, and the worst numbers of patches in a ring."""
    print("| step | column: worst, median | 10 degrees | 90 degrees | worst rings |")
    print("| --- | --- | --- | --- | --- |")
    for k, step in enumerate(steps, 1):
        found = [variance_of_equal_rings(step, width) for width in (0.0, 10.0, 90.0)]
        shown = " | ".join(f"{one.max():.2g}, {np.median(one):.1g}" for one in found)
        print(f"| n{k} | {shown} | {', '.join(map(str, np.sort(5 + np.argsort(-found[0])[:5])))} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--candidates", type=int, default=30_000)
    parser.add_argument("--seed", type=int, default=12)
    options = parser.parse_args()
    print("figures of good sets of one, two, three:", {size: round(value, 5) for size, value in GOOD.items()})
    print("in the package:")
    for tell in (show, show_more_modes, show_rings):
        tell([int(step) for step in NUMBER_STEPS])
    print("found:", flush=True)
    found = search(options.candidates, options.seed)
    for tell in (show, show_more_modes, show_rings):
        tell(found)


if __name__ == "__main__":
    main()
