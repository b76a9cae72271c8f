"""How many photons come from a sampler's commonest mistakes, by tests of one degree of freedom each."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.report import Check
from aomc_sky.verify.sky.zone_shares import ZoneShares
from aomc_sky.verify.sky.zone_tests import MAX_PER_DEGREE, MIN_EVEN, RESONANCE, untested
from aomc_sky.verify.tails import pool_starts

_LEAST_DIFFERENCE = 1e-6
"""Sum of u^2 / p - 1 below which the sky itself is as good as the mistake."""


class Mistake(enum.Enum):
    """What some of the photons may come from instead of the sky.

    UNIFORM
        Uniform in zenith angle: no sine, no cosine. Looked for in rings of zones.
    LAMBERT
        The same radiance from everywhere, the law of a white wall. Looked for in zones, most of what tells it from a
        sky with a sun being the azimuth.
    """

    UNIFORM = "share uniform in zenith angle"
    LAMBERT = "share of equal radiance from everywhere (Lambert)"

    def of_zones(self, zones: PatchGrid) -> np.ndarray:
        """Share of its photons in each zone, (n_zone,), any scale."""
        if self is Mistake.LAMBERT:
            return zones.projected_solid_angle_sr
        width, turn = (np.diff(x, axis=1)[:, 0] for x in (zones.zenith_bounds_deg, zones.azimuth_bounds_deg))
        return np.outer(width, turn / turn.sum()).ravel()


@dataclass(frozen=True, kw_only=True, slots=True)
class ShareScore:
    """The score of a share s of photons of a mistake, the others as they ought to be.

    With p_c of the photons expected in a group c of zones and u_c of those of the mistake, the derivative of the
    log-likelihood at s = 0 is sum over c of a_c n_c, a_c = u_c / p_c - 1: of all statistics of these counts it has the
    most power against small s (Neyman and Pearson). Its expectation is s N D, D = sum of u_c^2 / p_c - 1.
    """

    #: Which.
    mistake: Mistake
    #: a_c of the zones; 0 where nothing is expected. [shape (n_zone,)]
    per_zone: np.ndarray
    #: Photons, or sums of weights, of each zone. [shape (n_zone,)]
    expected: np.ndarray
    #: D. [>= 0]
    difference: float

    @classmethod
    def of(
        cls, mistake: Mistake, zones: PatchGrid, expected: np.ndarray, photons_per_unit: float = 1.0
    ) -> ShareScore | None:
        """For what zones expect, put together until they expect 1000 photons; None for fewer than two groups.

        With 1000 photons a p-value of 1e-7 from the normal law is within a factor of 1.5 of that of independent
        photons. Rings stay in their order; zones go in the order of u / p, so that those of a group have nearly the
        same a_c and little is lost.
        """
        is_of_rings = mistake is Mistake.UNIFORM
        shape = (zones.n_zenith, zones.n_azimuth) if is_of_rings else (zones.n_patches, 1)
        p_all, u_all = (x.reshape(shape).sum(axis=1) for x in (expected, mistake.of_zones(zones)))
        lit = np.flatnonzero(p_all > 0)
        if not is_of_rings:
            lit = lit[np.argsort(u_all[lit] / p_all[lit], kind="stable")]
        starts = pool_starts(p_all[lit] * photons_per_unit, MIN_EVEN)
        if starts.size < 2:
            return None
        u, p = (np.add.reduceat(x[lit], starts) / x[lit].sum() for x in (u_all, p_all))
        of_cells = np.zeros(p_all.size)
        of_cells[lit] = np.repeat(u / p - 1, np.diff(np.append(starts, lit.size)))
        difference = float(np.sum(u * u / p)) - 1
        if difference < _LEAST_DIFFERENCE:
            return None
        per_zone = np.repeat(of_cells, zones.n_azimuth) if is_of_rings else of_cells
        return cls(mistake=mistake, per_zone=per_zone, expected=expected, difference=difference)

    @property
    def own_variance(self) -> float:
        """Of independent photons, their total fixed: sum of a_c^2 N p_c."""
        return float(self.per_zone**2 @ self.expected)

    def check(self, found: np.ndarray, variance: float, waveband: int) -> Check:
        """Two-sided test: the score of what zones hold, under a variance that is known or known from above."""
        score = float(self.per_zone @ (found - self.expected))
        scale = self.difference * float(self.expected.sum())
        return Check(
            name=self.mistake.value,
            waveband=waveband,
            passed=True,
            found=score / scale,
            p_value=math.erfc(abs(score) / math.sqrt(2 * variance)),
            detail=f"standard deviation {math.sqrt(variance) / scale:.2g}",
        )


def of_independent(zones: PatchGrid, found: np.ndarray, expected: np.ndarray, waveband: int) -> list[Check]:
    """Of photons drawn independently, their total fixed; or of photons that are spread more evenly."""
    return _checks(zones, expected, waveband, lambda score: score.check(found, score.own_variance, waveband))


def of_plan(
    zones: PatchGrid, found: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int
) -> list[Check]:
    """Of photons whose cells the plan fixes: only their places in cells that zones cut are free.

    The variance is at most 1.5 times that of independent places, and a tenth of that of independent photons besides,
    as the chi-square per degree of freedom allows.
    """

    def check(score: ShareScore) -> Check:
        free = shares.variance(of_cells, score.per_zone)
        return score.check(found, RESONANCE * free + MAX_PER_DEGREE * score.own_variance, waveband)

    return _checks(zones, shares.expected(of_cells), waveband, check)


def of_thinned(
    zones: PatchGrid, kept: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int
) -> list[Check]:
    """Of evenly spread photons that a fair coin has thinned: a quarter of both variances.

    `kept` are the photons of zones that the coin kept, `of_cells` those of cells before the coin.
    """

    def check(score: ShareScore) -> Check:
        free = shares.variance(of_cells, score.per_zone)
        return score.check(kept, score.own_variance / 2 + RESONANCE * free / 4, waveband)

    return _checks(zones, shares.expected(of_cells) / 2, waveband, check)


def of_weights(
    zones: PatchGrid, weight: np.ndarray, weight2: np.ndarray, share: np.ndarray, waveband: int
) -> list[Check]:
    """Of sums of weights: the variance is the sum of a_c^2 times the squares of weights."""
    total, total2 = float(weight.sum()), float(weight2.sum())

    def check(score: ShareScore) -> Check:
        variance = float(score.per_zone**2 @ weight2)
        return score.check(weight, variance, waveband) if variance > 0 else untested(score.mistake.value, waveband)

    return _checks(zones, share * total, waveband, check, photons_per_unit=total / total2)


def _checks(
    zones: PatchGrid,
    expected: np.ndarray,
    waveband: int,
    check: Callable[[ShareScore], Check],
    *,
    photons_per_unit: float = 1.0,
) -> list[Check]:
    """One line for each mistake."""
    scores = [(mistake, ShareScore.of(mistake, zones, expected, photons_per_unit)) for mistake in Mistake]
    return [untested(mistake.value, waveband) if score is None else check(score) for mistake, score in scores]
