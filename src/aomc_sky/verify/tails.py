"""Tails of the laws that tests compare with, and neighbouring cells put together until they expect enough."""

from __future__ import annotations

import numpy as np


def sidak_level(family_level: float, n_tests: int) -> float:
    """Level of each of n tests that gives all together the family level.

    1 - (1 - family_level)^(1 / n): exact for independent tests, on the safe side for tests of one kind of data that are
    positively dependent.
    """
    return float(-np.expm1(np.log1p(-family_level) / max(n_tests, 1)))


def chi_square_p(statistic: float, degrees: int) -> float:
    """Two-sided p-value of a chi-square: too even is as wrong as too uneven."""
    return min(1.0, 2 * min(chi_square_tail(statistic, degrees), chi_square_rest(statistic, degrees)))


def chi_square_rest(statistic: float, degrees: int) -> float:
    """Chance of a smaller chi-square, without cancellation."""
    from scipy.special import gammainc

    return float(gammainc(degrees / 2, statistic / 2))


def chi_square_tail(statistic: float, degrees: int) -> float:
    """Chance of a larger chi-square."""
    from scipy.special import gammaincc

    return float(gammaincc(degrees / 2, statistic / 2))


def binomial_tail(found: int, n: int, chance: float) -> float:
    """Chance of at least `found` of n events that have this chance each."""
    from scipy.special import bdtrc

    if found <= 0:
        return 1.0
    return 0.0 if found > n else float(bdtrc(found - 1, n, chance))


def kolmogorov_p(distance: float, n_photons: int) -> float:
    """Chance of a larger Kolmogorov distance among n independent numbers.

    The asymptotic law with Stephens' correction: a relative error of the p-value below 10 % from 1000 numbers.
    """
    from scipy.special import kolmogorov

    root = np.sqrt(n_photons)
    return float(kolmogorov((root + 0.12 + 0.11 / root) * distance))


def pool_starts(expected: np.ndarray, least: float) -> np.ndarray:
    """First cells of groups of neighbours that expect at least `least` each; the last one takes what is left.

    For `numpy.add.reduceat`: one group where all cells together expect too little for two, none for no cells.
    """
    if expected.size == 0:
        return np.zeros(0, dtype=np.int64)
    cumulative = np.cumsum(expected)
    starts = [0]
    while True:
        before = cumulative[starts[-1] - 1] if starts[-1] else 0.0
        end = int(np.searchsorted(cumulative, before + least, side="left")) + 1
        if end >= expected.size or cumulative[-1] - cumulative[end - 1] < least:
            return np.array(starts, dtype=np.int64)
        starts.append(end)


def pooled(counts: np.ndarray, expected: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Counts and expectations of the groups of `pool_starts`, over the cells that expect anything."""
    lit = expected > 0
    starts = pool_starts(expected[lit], least)
    if starts.size == 0:
        return np.zeros(0), np.zeros(0)
    return np.add.reduceat(counts[lit], starts), np.add.reduceat(expected[lit], starts)
