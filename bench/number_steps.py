"""Search the steps of the numbers that a photon carries for its host (`constants.NUMBER_STEPS`).

    python bench/number_steps.py [--candidates 4000] [--seed 1]

Photon of rank r has the coordinates frac(shift + r a), each with a step a of its own, beside the two of its direction
and the one that decides a rejection. N such points fill a box evenly if no small whole numbers h make h . a nearly
whole: the figure of a set of steps is the smallest product of max(1, |h_i|) times the distance of h . a from a whole
number (Niederreiter 1992, section 5.1). It is taken for every set of at most three steps that holds one of ours, and
divided by that of Roberts' sequence of as many coordinates: the golden ratio, R2 and R3.

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
LARGEST = {1: 1 << 20, 2: 256, 3: 24}
"""Largest |h_i| for sets of one, two and three steps."""


def factors(size: int) -> tuple[list[np.ndarray], np.ndarray]:
    """All h of one sign each (the first one not negative), but 0, as columns of uint64; and their products."""
    most = LARGEST[size]
    axes = [np.arange(most + 1), *[np.arange(-most, most + 1)] * (size - 1)]
    h = [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]
    kept = np.any(h, axis=0)
    product = np.prod([np.maximum(1, np.abs(part[kept])) for part in h], axis=0).astype(np.float64)
    return [part[kept].astype(np.uint64) for part in h], product


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


def roberts(size: int) -> tuple[int, ...]:
    """Steps of Roberts' sequence (2018): powers of 1 / g, g^(size + 1) = g + 1."""
    g = Fraction(2)
    for _ in range(12):  # Newton
        g -= (g ** (size + 1) - g - 1) / ((size + 1) * g**size - 1)
        g = g.limit_denominator(1 << 80)
    return tuple(of_fraction(1 / g**k) for k in range(1, size + 1))


REFERENCE = {size: figure(roberts(size)) for size in LARGEST}


def worst(step: int, others: dict[str, int], enough: float = -1.0) -> tuple[float, tuple[str, ...]]:
    """The lowest relative figure of the sets of a step with at most two others, and that set; stops below `enough`."""
    lowest, at = figure((step,)) / REFERENCE[1], ()
    for size in (1, 2):
        for names in combinations(others, size):
            value = figure((step, *(others[name] for name in names))) / REFERENCE[size + 1]
            if value < lowest:
                lowest, at = value, names
            if lowest < enough:
                return lowest, at
    return lowest, at


def candidate(rng: np.random.Generator) -> int:
    """A step whose continued fraction has ones and twos alone."""
    x = Fraction(0)
    for quotient in rng.integers(1, 3, 90).tolist():
        x = 1 / (quotient + x)
    return of_fraction(x)


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
        print(f"n{k}  0x{step:016X}  {step / 2**64:.16f}  worst figure {value:.3f} of Roberts', with {' '.join(names)}")
        known[f"n{k}"] = step


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--candidates", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("figures of Roberts' steps:", {size: round(value, 4) for size, value in REFERENCE.items()})
    print("in the package:")
    show([int(step) for step in NUMBER_STEPS])
    print("found:")
    show(search(options.candidates, options.seed))


if __name__ == "__main__":
    main()
