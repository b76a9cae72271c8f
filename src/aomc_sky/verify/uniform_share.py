"""How many photons are uniform in zenith angle, the commonest mistake of a sampler: a test of one degree of freedom."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.report import Check
from aomc_sky.verify.tails import pool_starts
from aomc_sky.verify.zone_shares import ZoneShares
from aomc_sky.verify.zone_tests import MAX_PER_DEGREE, MIN_EVEN, RESONANCE, untested

NAME = "share uniform in zenith angle"

_LEAST_DIFFERENCE = 1e-6
"""Sum of u^2 / p - 1 below which the sky itself is as good as uniform in zenith angle."""


@dataclass(frozen=True, kw_only=True, slots=True)
class UniformScore:
    """The score of a share s of photons that are uniform in zenith angle, the others as they ought to be.

    With p_c of the photons expected in a group c of rings of zones and u_c of those that are uniform in zenith angle,
    the derivative of the log-likelihood at s = 0 is sum over c of a_c n_c, a_c = u_c / p_c - 1: of all statistics it
    has the most power against small s (Neyman and Pearson). Its expectation is s N D, D = sum of u_c^2 / p_c - 1.

    Parameters
    ----------
    per_ring : ndarray, float64, shape (n_ring,)
        a_c of the rings of zones; 0 where nothing is expected.
    expected : ndarray, float64, shape (n_ring,)
        Photons, or sums of weights, of each ring.
    difference : float
        D. [>= 0]
    """

    per_ring: np.ndarray
    expected: np.ndarray
    difference: float

    @classmethod
    def of(cls, zones: PatchGrid, expected: np.ndarray, photons_per_unit: float = 1.0) -> UniformScore | None:
        """For what zones expect, rings put together until they expect 1000 photons; None for fewer than two groups.

        With 1000 photons a p-value of 1e-7 from the normal law is within a factor of 1.5 of that of independent
        photons.
        """
        rings = expected.reshape(zones.n_zenith, zones.n_azimuth).sum(axis=1)
        lit = np.flatnonzero(rings > 0)
        starts = pool_starts(rings[lit] * photons_per_unit, MIN_EVEN)
        if starts.size < 2:
            return None
        width = np.diff(zones.zenith_bounds_deg, axis=1)[lit, 0]
        u, p = (np.add.reduceat(x, starts) / x.sum() for x in (width, rings[lit]))
        per_ring = np.zeros(rings.size)
        per_ring[lit] = np.repeat(u / p - 1, np.diff(np.append(starts, lit.size)))
        difference = float(np.sum(u * u / p)) - 1
        if difference < _LEAST_DIFFERENCE:
            return None
        return cls(per_ring=per_ring, expected=rings, difference=difference)

    def of_zones(self, zones: PatchGrid) -> np.ndarray:
        """a_c of every zone."""
        return np.repeat(self.per_ring, zones.n_azimuth)

    def check(self, found: np.ndarray, variance: float, waveband: int) -> Check:
        """Two-sided test: the score of what zones hold, under a variance that is known or known from above."""
        rings = found.reshape(self.expected.size, -1).sum(axis=1)
        score = float(self.per_ring @ (rings - self.expected))
        scale = self.difference * float(self.expected.sum())
        return Check(
            name=NAME,
            waveband=waveband,
            passed=True,
            found=score / scale,
            p_value=math.erfc(abs(score) / math.sqrt(2 * variance)),
            detail=f"standard deviation {math.sqrt(variance) / scale:.2g}",
        )


def of_independent(zones: PatchGrid, found: np.ndarray, expected: np.ndarray, waveband: int) -> Check:
    """Of photons drawn independently, their total fixed: the variance is sum of a_c^2 N p_c."""
    score = UniformScore.of(zones, expected)
    if score is None:
        return untested(NAME, waveband)
    return score.check(found, _own_variance(score), waveband)


def of_plan(zones: PatchGrid, found: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int) -> Check:
    """Of photons whose cells the plan fixes: only their places in cells that zones cut are free.

    The variance is at most 1.5 times that of independent places, and a tenth of that of independent photons besides,
    as the chi-square per degree of freedom allows.
    """
    score = UniformScore.of(zones, shares.expected(of_cells))
    if score is None:
        return untested(NAME, waveband)
    free = shares.variance(of_cells, score.of_zones(zones))
    return score.check(found, RESONANCE * free + MAX_PER_DEGREE * _own_variance(score), waveband)


def of_thinned(zones: PatchGrid, kept: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int) -> Check:
    """Of evenly spread photons that a fair coin has thinned: a quarter of both variances.

    Parameters
    ----------
    zones : PatchGrid
        The zones.
    kept : ndarray, float64, shape (n_zone,)
        Photons that the coin kept.
    shares : ZoneShares
        How cells spread over zones.
    of_cells : ndarray, float64, shape (n_cell,)
        Photons of cells before the coin.
    waveband : int
        [1-based]
    """
    score = UniformScore.of(zones, shares.expected(of_cells) / 2)
    if score is None:
        return untested(NAME, waveband)
    free = shares.variance(of_cells, score.of_zones(zones))
    return score.check(kept, _own_variance(score) / 2 + RESONANCE * free / 4, waveband)


def of_weights(zones: PatchGrid, weight: np.ndarray, weight2: np.ndarray, share: np.ndarray, waveband: int) -> Check:
    """Of sums of weights: the variance is the sum of a_c^2 times the squares of weights."""
    total, total2 = float(weight.sum()), float(weight2.sum())
    score = UniformScore.of(zones, share * total, photons_per_unit=total / total2)
    if score is None:
        return untested(NAME, waveband)
    variance = float(score.of_zones(zones) ** 2 @ weight2)
    return score.check(weight, variance, waveband) if variance > 0 else untested(NAME, waveband)


def _own_variance(score: UniformScore) -> float:
    return float(score.per_ring**2 @ score.expected)
