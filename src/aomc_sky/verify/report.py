"""The report of a verification: checks, maps of pulls, and the distributions behind p-values."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from aomc_sky.grid import PatchGrid

LEAST_EXPECTED = 20.0
"""Fewest expected photons of a cell with a pull."""

MAX_NAMED = 5
"""Most differences that a detail names; the rest are counted."""


def named(wrong: Sequence[str]) -> str:
    """The first few texts, and the number of the others."""
    more = f"; {len(wrong) - MAX_NAMED} more" if len(wrong) > MAX_NAMED else ""
    return "; ".join(wrong[:MAX_NAMED]) + more


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """One check."""

    name: str
    passed: bool = True  #: `judged` decides for tests with a p-value
    waveband: int | None = None  #: if it is of one waveband [1-based]
    found: float | None = None  #: the statistic
    allowed: float | None = None  #: its bound
    p_value: float | None = None  #: of a statistical test
    detail: str = ""  #: the damage, the number of photons, the worst cell
    is_foreign: bool = False  #: whether a failure means that a file belongs to another scene, seed or run
    is_of_zones: bool = False  #: whether a map of pulls shows a failure, as for all tests with a p-value
    is_even: bool = False  #: whether photons are spread more evenly than independent ones


class Against(enum.Enum):
    """The reference of pulls: masses, from which counts are drawn, or the counts of a plan."""

    MASSES = "the masses of the sky"
    PLAN = "the counts of the plan"


@dataclass(frozen=True, kw_only=True, slots=True)
class Pulls:
    """A map of the differences between photons of a waveband and their expectation."""

    waveband: int  #: [1-based]
    zones: PatchGrid  #: the cells of the map
    observed: np.ndarray  #: photons or sums of weights [shape (n_zenith, n_azimuth)]
    expected: np.ndarray
    variance: np.ndarray  #: of the observed ones, if photons are independent
    against: Against = Against.MASSES  #: where `expected` comes from

    @property
    def pull(self) -> np.ndarray:
        """(observed - expected) over the standard deviation: standard normal for independent photons.

        NaN if a cell expects fewer than 20 photons; inf if a cell without expectation has photons.
        """
        is_enough = self.variance >= LEAST_EXPECTED
        deviation = np.sqrt(np.where(is_enough, self.variance, 1.0))
        pull = np.where(is_enough, (self.observed - self.expected) / deviation, np.nan)
        return np.where((self.expected == 0) & (self.observed > 0), np.inf, pull)

    def worst(self, n: int = 10) -> list[tuple[int, int]]:
        """Ring and column of the cells with the largest pulls."""
        pull = self.pull
        size = np.where(np.isnan(pull), -1.0, np.abs(pull))
        order = np.argsort(-size, axis=None, kind="stable")[:n]
        return [divmod(int(k), pull.shape[1]) for k in order if size.ravel()[k] >= 0]


@dataclass(frozen=True, kw_only=True, slots=True)
class VerifyReport:
    """The outcome of a verification."""

    checks: tuple[Check, ...]  #: in the order in which they were made
    family_level: float  #: chance that correct photons fail any of its tests
    level: float  #: of each test (Sidak)
    notes: tuple[str, ...] = ()  #: for example tests that were not possible
    pulls: tuple[Pulls, ...] = field(default=(), repr=False)  #: of the wavebands whose directions were tested

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def is_foreign(self) -> bool:
        """Whether files belong to another scene, seed or run."""
        return any(check.is_foreign for check in self.checks if not check.passed)

    def __bool__(self) -> bool:
        return self.passed

    @property
    def failed_pulls(self) -> tuple[Pulls, ...]:
        """Maps of the wavebands with a failed test."""
        failed = {c.waveband for c in self.checks if not c.passed and (c.is_of_zones or c.p_value is not None)}
        return tuple(p for p in self.pulls if p.waveband in failed)

    def as_json(self) -> dict[str, Any]:
        """The report as JSON values, with maps of failed wavebands only."""
        keys = ("name", "waveband", "passed", "found", "allowed", "p_value", "detail")
        return {
            "passed": self.passed,
            "family_level": self.family_level,
            "level": self.level,
            "tests": sum(check.p_value is not None for check in self.checks),
            "checks": [
                {key: value for key in keys if (value := getattr(check, key)) is not None and value != ""}
                for check in self.checks
            ],
            "notes": list(self.notes),
            "worst": [
                {"waveband": pulls.waveband, "cells": [cell_json(pulls, *cell) for cell in pulls.worst()]}
                for pulls in self.failed_pulls
            ],
        }


def judged(
    checks: Sequence[Check], *, family_level: float, notes: Sequence[str] = (), pulls: Sequence[Pulls] = ()
) -> VerifyReport:
    """Decide the tests (checks with a p-value), so that correct photons fail any of them with this chance."""
    level = sidak_level(family_level, sum(check.p_value is not None for check in checks))
    decided = tuple(c if c.p_value is None else replace(c, passed=bool(c.p_value >= level)) for c in checks)
    return VerifyReport(checks=decided, family_level=family_level, level=level, notes=tuple(notes), pulls=tuple(pulls))


def cell_json(pulls: Pulls, ring: int, column: int) -> dict[str, Any]:
    """One cell of a map as JSON values; an infinite pull is null."""
    pull = float(pulls.pull[ring, column])
    return {
        "zenith_deg": pulls.zones.zenith_bounds_deg[ring].tolist(),
        "azimuth_deg": pulls.zones.azimuth_bounds_deg[column].tolist(),
        "observed": float(pulls.observed[ring, column]),
        "expected": float(pulls.expected[ring, column]),
        "pull": pull if np.isfinite(pull) else None,
    }


def largest_pull(maps: Sequence[Pulls]) -> tuple[Pulls, int, int] | None:
    """The map with the largest pull, and its ring and column, or None if no cell has a pull."""
    worst = [(pulls, *pulls.worst(1)[0]) for pulls in maps if pulls.worst(1)]
    return max(worst, key=lambda w: abs(w[0].pull[w[1], w[2]]), default=None)


def sidak_level(family_level: float, n_tests: int) -> float:
    """Level of each of n tests that together have the family level: 1 - (1 - family_level)^(1 / n).

    Exact for independent tests, and conservative for positively dependent tests.
    """
    return float(-np.expm1(np.log1p(-family_level) / max(n_tests, 1)))


def chi_square_tails(statistic: float, degrees: int) -> tuple[float, float]:
    """Chances of a larger and of a smaller chi-square, without cancellation."""
    from scipy.special import gammainc, gammaincc

    return float(gammaincc(degrees / 2, statistic / 2)), float(gammainc(degrees / 2, statistic / 2))


def two_sided(upper: float, lower: float) -> float:
    """The p-value of both tails: photons can be too uneven or too even."""
    return min(1.0, 2 * min(upper, lower))


def kolmogorov_p(distance: float, n_photons: int) -> float:
    """Chance of a larger Kolmogorov distance among n independent numbers.

    The asymptotic law with Stephens' correction: a relative error of the p-value below 10 % from 1000 numbers.
    """
    from scipy.special import kolmogorov

    root = np.sqrt(n_photons)
    return float(kolmogorov((root + 0.12 + 0.11 / root) * distance))


def pool_starts(expected: np.ndarray, least: float) -> np.ndarray:
    """First cells of groups of neighbours that expect at least `least` each, for `numpy.add.reduceat`.

    The last group takes the rest. There is always one group, except for no cells.
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
