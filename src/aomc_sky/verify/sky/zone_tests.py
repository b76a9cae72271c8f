"""Tests of photons counted by zone: a chi-square for each way in which photons are tied together, and scores."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.counts import MIN_EXPECTED
from aomc_sky.verify.report import Check, chi_square_rest, chi_square_tail, pool_starts, pooled
from aomc_sky.verify.sky.zones import ZoneShares

MIN_EVEN = 1000.0
"""Photons that a cell expects at least where stratified photons are tested for evenness."""

MAX_PER_DEGREE = 0.1
"""Chi-square per degree of freedom that stratified photons stay below in such cells; independent ones have 1."""

MIN_WEIGHTED = 100.0
"""Effective photons that a cell has at least where weights differ: their variance is estimated."""

RESONANCE = 1.5
"""Places by a low-discrepancy sequence spread at most so much more than independent ones (docs/methods.md: 1.01^2)."""

_TOO_FEW = "too few photons"


@dataclass(frozen=True, kw_only=True, slots=True)
class Marginal:
    """One way of putting zones together."""

    #: For a person.
    name: str
    #: Cell of each zone. [shape (n_zone,)]
    group: np.ndarray

    def sums(self, of_zones: np.ndarray) -> np.ndarray:
        """Sums over the zones of each cell."""
        return np.bincount(self.group, of_zones)


def marginals(zones: PatchGrid) -> Iterator[Marginal]:
    """Zones of mu^2, of azimuth, and of both."""
    zone = np.arange(zones.n_patches)
    yield Marginal(name="mu^2", group=zone // zones.n_azimuth)
    yield Marginal(name="azimuth", group=zone % zones.n_azimuth)
    yield Marginal(name="mu^2 x azimuth", group=zone)


def untested(name: str, waveband: int) -> Check:
    """The line of a test that had too few photons."""
    return Check(name=name, waveband=waveband, passed=True, detail=_TOO_FEW)


def independent(
    observed: np.ndarray, expected: np.ndarray, name: str, waveband: int, *, is_mixed: bool = False
) -> Check:
    """Two-sided chi-square of independent photons, cells pooled to an expectation of 20, their total fixed.

    With `is_mixed` some may be spread more evenly, and only too uneven ones fail.
    """
    counted, mean = pooled(observed, expected, MIN_EXPECTED)
    name = f"{name}: chi-square" + ("" if is_mixed else ", two-sided")
    if mean.size < 2:
        return untested(name, waveband)
    statistic = float(np.sum((counted - mean) ** 2 / mean))
    return of_chi_square(statistic, mean.size - 1, name, waveband, is_two_sided=not is_mixed)


def of_chi_square(statistic: float, degrees: int, name: str, waveband: int, *, is_two_sided: bool) -> Check:
    """The line of a chi-square, which knows whether it lies in the lower tail."""
    upper, lower = chi_square_tail(statistic, degrees), chi_square_rest(statistic, degrees)
    return Check(
        name=name,
        waveband=waveband,
        passed=True,
        p_value=min(1.0, 2 * min(upper, lower)) if is_two_sided else upper,
        found=statistic,
        detail=f"{statistic:.5g} for {degrees} degrees of freedom",
        is_even=is_two_sided and lower < upper,
    )


def thinned(kept: np.ndarray, expected: np.ndarray, loose: np.ndarray, name: str, waveband: int) -> Check:
    """Two-sided chi-square of evenly spread photons of which a random half was kept.

    Expectation N p / 2, variance N p / 4, and cells independent: chi-square with as many degrees of freedom as cells.
    Where cells cut patches or lobes the variance may be larger by `loose` / 4; the upper tail then allows for the
    largest share of it.
    """
    lit = expected > 0
    starts = pool_starts(expected[lit] / 2, MIN_EXPECTED)
    name = f"{name}: chi-square of thinned photons"
    if starts.size < 2:
        return untested(name, waveband)
    counted, half, free = (np.add.reduceat(x[lit], starts) for x in (kept, expected / 2, loose / 2))
    statistic = float(np.sum((counted - half) ** 2 / (half / 2)))
    share = float((free / half).max())
    upper = chi_square_tail(statistic / (1 + share), half.size)
    p_value = min(1.0, 2 * min(upper, chi_square_rest(statistic, half.size)))
    detail = f"{statistic:.5g} for {half.size} degrees of freedom"
    return Check(name=name, waveband=waveband, passed=True, p_value=p_value, found=statistic, detail=detail)


def weighted(
    weight: np.ndarray, weight2: np.ndarray, share: np.ndarray, name: str, waveband: int, *, is_mixed: bool = False
) -> Check:
    """Two-sided test of sums of weights against shares, their covariance estimated from the squares of weights.

    Z_c = W_c - p_c W has the covariance S_c (c = d) - p_d S_c - p_c S_d + p_c p_d S, S the sums of squares; Z^T C^-1 Z
    over all cells but one is a chi-square. With `is_mixed` photons may be spread more evenly than independent ones, and
    only too uneven ones fail.
    """
    name = f"{name}: chi-square of weights" + ("" if is_mixed else ", two-sided")
    lit = share > 0
    total2 = weight2.sum()
    effective = weight.sum() ** 2 / total2 if total2 > 0 else 0.0
    starts = pool_starts(share[lit] * effective, MIN_WEIGHTED)
    if starts.size < 2:
        return untested(name, waveband)
    w, s, p = (np.add.reduceat(x[lit], starts) for x in (weight, weight2, share))
    off = w - p * w.sum()
    covariance = np.diag(s) - np.outer(p, s) - np.outer(s, p) + np.outer(p, p) * s.sum()
    statistic = float(off[1:] @ np.linalg.solve(covariance[1:, 1:], off[1:]))
    return of_chi_square(statistic, p.size - 1, name, waveband, is_two_sided=not is_mixed)


def even(observed: np.ndarray, expected: np.ndarray, loose: np.ndarray, name: str, waveband: int) -> Check:
    """Chi-square per degree of freedom of photons whose counts the plan fixes, in cells that expect 1000 or more.

    Where cells are whole patches it must stay below 0.1. A cell that cuts patches or lobes may spread by its `loose`
    variance besides: then the p-value is an upper bound, that of (statistic - 0.1 degrees) over the largest share of
    loose variance.
    """
    lit = expected > 0
    starts = pool_starts(expected[lit], MIN_EVEN)
    name = f"{name}: chi-square per degree of freedom"
    if starts.size < 2:
        return untested(name, waveband)
    counted, mean, free = (np.add.reduceat(x[lit], starts) for x in (observed, expected, loose))
    statistic, degrees = float(np.sum((counted - mean) ** 2 / mean)), mean.size - 1
    per_degree, share = statistic / degrees, RESONANCE * float((free / mean).max())
    detail = f"{mean.size} cells"
    if share < MAX_PER_DEGREE * 1e-3:
        return Check(
            name=name,
            waveband=waveband,
            passed=per_degree < MAX_PER_DEGREE,
            found=per_degree,
            allowed=MAX_PER_DEGREE,
            detail=detail,
            is_of_zones=True,
        )
    excess = max(statistic - MAX_PER_DEGREE * degrees, 0.0) / share
    p_value = chi_square_tail(excess, degrees)
    detail += ", which cut patches: the p-value is an upper bound"
    return Check(name=name, waveband=waveband, passed=True, found=per_degree, p_value=p_value, detail=detail)


def by_marginals(zones: PatchGrid, test: Callable[..., Check], *of_zones: np.ndarray, waveband: int) -> list[Check]:
    """One test for each way of putting zones together; one with a single cell says nothing and is left out."""
    return [
        test(*(marginal.sums(values) for values in of_zones), marginal.name, waveband)
        for marginal in marginals(zones)
        if marginal.group.max() > 0
    ]


_LEAST_DIFFERENCE = 1e-6
"""Sum of u^2 / p - 1 below which the sky itself is as good as the mistake."""


class Mistake(enum.Enum):
    """What some of the photons may come from instead of the sky.

    UNIFORM
        Uniform in zenith angle: no sine, no cosine. Looked for in rings of zones.
    LAMBERT
        The same radiance from everywhere, the law of a white wall. Looked for in zones: it differs most in azimuth from
        a sky with a sun.
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


def scores_of_independent(zones: PatchGrid, found: np.ndarray, expected: np.ndarray, waveband: int) -> list[Check]:
    """Of photons drawn independently, their total fixed; or of photons that are spread more evenly."""
    return _score_checks(zones, expected, waveband, lambda score: score.check(found, score.own_variance, waveband))


def scores_of_plan(
    zones: PatchGrid, found: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int
) -> list[Check]:
    """Of photons whose cells the plan fixes: only their positions in cells that zones cut are free.

    The variance is at most 1.5 times that of independent positions, and a tenth of that of independent photons besides,
    as the chi-square per degree of freedom allows.
    """

    def check(score: ShareScore) -> Check:
        free = shares.variance(of_cells, score.per_zone)
        return score.check(found, RESONANCE * free + MAX_PER_DEGREE * score.own_variance, waveband)

    return _score_checks(zones, shares.expected(of_cells), waveband, check)


def scores_of_thinned(
    zones: PatchGrid, kept: np.ndarray, shares: ZoneShares, of_cells: np.ndarray, waveband: int
) -> list[Check]:
    """Of evenly spread photons of which a random half was kept: a quarter of both variances.

    `kept` are the photons of zones that were kept, `of_cells` those of cells before the thinning.
    """

    def check(score: ShareScore) -> Check:
        free = shares.variance(of_cells, score.per_zone)
        return score.check(kept, score.own_variance / 2 + RESONANCE * free / 4, waveband)

    return _score_checks(zones, shares.expected(of_cells) / 2, waveband, check)


def scores_of_weights(
    zones: PatchGrid, weight: np.ndarray, weight2: np.ndarray, share: np.ndarray, waveband: int
) -> list[Check]:
    """Of sums of weights: the variance is the sum of a_c^2 times the squares of weights."""
    total, total2 = float(weight.sum()), float(weight2.sum())

    def check(score: ShareScore) -> Check:
        variance = float(score.per_zone**2 @ weight2)
        return score.check(weight, variance, waveband) if variance > 0 else untested(score.mistake.value, waveband)

    return _score_checks(zones, share * total, waveband, check, photons_per_unit=total / total2)


def _score_checks(
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
