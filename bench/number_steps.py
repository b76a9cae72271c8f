"""Search the steps of the numbers that a photon carries for its host (`constants.NUMBER_STEPS`).

    python bench/number_steps.py [--candidates 4000] [--seed 1]

Photon of rank r has the coordinates frac(shift + r a), each with a step a of its own, beside the two of its direction
and the one that decides a rejection. N such points fill a box evenly if no small whole numbers h make h . a nearly
whole: the figure of a set of steps is the smallest product of max(1, |h_i|) times the distance of h . a from a whole
number (Niederreiter 1992, section 5.1), over all h of products up to 2^20, 2^14 and 2^12 for one, two and three steps.
It is taken for every set of at most three steps that holds one of ours, and divided by that of a good set, the best of
ten random ones. Sets that hold a step of the direction count double: cells are small, and what happens in them matters
less.

A candidate is a continued fraction of random ones and twos, so that by itself it is nearly as even as the golden ratio
at every number of photons. The first step is the candidate whose worst set with the fixed steps is best; then the
second and the third, each beside those before. The search takes some minutes.
"""

from __future__ import annotations

import argparse
from fractions import Fraction
from itertools import combinations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT_STEP, NUMBER_STEPS, R2_STEP_U, R2_STEP_V

FIXED = {"u": int(R2_STEP_U), "v": int(R2_STEP_V), "accept": int(ACCEPT_STEP)}
LARGEST = {1: 1 << 20, 2: 1 << 14, 3: 1 << 12}
MIXED, MANY = 2.0, 0.9


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


def of_fraction(x: float | Fraction) -> int:
    """A fraction in units of 2^-64, rounded to an odd number, whose multiples visit all 2^64."""
    return int(Fraction(x) * 2**64) | 1


def candidate(rng: np.random.Generator) -> int:
    """A step whose continued fraction has ones and twos alone."""
    x = Fraction(0)
    for quotient in rng.integers(1, 3, 90).tolist():
        x = 1 / (quotient + x)
    return of_fraction(x)


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


def search(candidates: int, seed: int) -> list[int]:
    """The three steps."""
    rng, known, found = np.random.default_rng(seed), dict(FIXED), []
    for k in range(1, 4):
        best, chosen = -1.0, 0
        for _ in range(candidates):
            step = candidate(rng)
            value, _ = worst(step, known, best)
            if value > best:
                best, chosen = value, step
        known[f"n{k}"] = chosen
        found.append(chosen)
    return found


def show(steps: list[int]) -> None:
    """Figures of each step beside the ones before it."""
    known = dict(FIXED)
    for k, step in enumerate(steps, 1):
        value, names = worst(step, known)
        print(
            f"n{k}  0x{step:016X}  {step / 2**64:.16f}  worst figure {value:.3f} of a good one, with {' '.join(names)}"
        )
        known[f"n{k}"] = step


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--candidates", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("figures of good sets of one, two, three:", {size: round(value, 5) for size, value in GOOD.items()})
    print("in the package:")
    show([int(step) for step in NUMBER_STEPS])
    print("found:")
    show(search(options.candidates, options.seed))


if __name__ == "__main__":
    main()
