"""Tests of photons counted by zone: a chi-square for each kind of dependence between photons, and scores."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.counts import MIN_EXPECTED
from aomc_sky.verify.report import Check, chi_square_tails, pool_starts, pooled, two_sided

MIN_EVEN = 1000.0
"""Fewest expected photons of a cell in a test for evenness of stratified photons."""

MAX_PER_DEGREE = 0.1
"""Largest chi-square per degree of freedom of stratified photons in such cells; independent photons have 1."""

MIN_WEIGHTED = 100.0
"""Fewest effective photons of a cell if weights differ, because their variance is estimated."""

RESONANCE = 1.5
"""Largest variance of low-discrepancy positions over that of independent ones (docs/methods.md: 1.01^2)."""


def by_marginals(zones: PatchGrid, test: Callable[..., Check], *zone_sums: np.ndarray, waveband: int) -> list[Check]:
    """A test of zones of mu^2, one of azimuth and one of both; tests with a single cell are left out."""
    checks = []
    for name, axis in (("mu^2", 1), ("azimuth", 0), ("mu^2 x azimuth", ())):
        sums = [x.reshape(zones.n_zenith, zones.n_azimuth).sum(axis=axis).ravel() for x in zone_sums]
        if sums[0].size > 1:
            checks.append(test(*sums, name, waveband))
    return checks


def untested(name: str, waveband: int) -> Check:
    """The check for a test with too few photons."""
    return Check(name=name, waveband=waveband, detail="too few photons")


def chi_square_check(statistic: float, degrees: int, name: str, waveband: int, *, is_two_sided: bool) -> Check:
    """The check for a chi-square, which notes whether it lies in the lower tail."""
    upper, lower = chi_square_tails(statistic, degrees)
    return Check(
        name=name,
        waveband=waveband,
        p_value=two_sided(upper, lower) if is_two_sided else upper,
        found=statistic,
        detail=f"{statistic:.5g} for {degrees} degrees of freedom",
        is_even=is_two_sided and lower < upper,
    )


def independent(
    observed: np.ndarray, expected: np.ndarray, name: str, waveband: int, *, is_mixed: bool = False
) -> Check:
    """Two-sided chi-square of independent photons, cells pooled to an expectation of 20, their total fixed.

    With `is_mixed` only too uneven photons fail, because some may be spread more evenly.
    """
    counted, mean = pooled(observed, expected, MIN_EXPECTED)
    name = f"{name}: chi-square" + ("" if is_mixed else ", two-sided")
    if mean.size < 2:
        return untested(name, waveband)
    statistic = float(np.sum((counted - mean) ** 2 / mean))
    return chi_square_check(statistic, mean.size - 1, name, waveband, is_two_sided=not is_mixed)


def thinned(kept: np.ndarray, expected: np.ndarray, loose: np.ndarray, name: str, waveband: int) -> Check:
    """Two-sided chi-square of evenly spread photons of which a random half was kept.

    Cells are independent with expectation N p / 2 and variance N p / 4, so the chi-square has as many degrees of
    freedom as cells. If cells cut patches or lobes, the variance may be larger by `loose` / 4; the upper tail allows
    for the largest share of it.
    """
    lit = expected > 0
    starts = pool_starts(expected[lit] / 2, MIN_EXPECTED)
    name = f"{name}: chi-square of thinned photons"
    if starts.size < 2:
        return untested(name, waveband)
    counted, half, free = (np.add.reduceat(x[lit], starts) for x in (kept, expected / 2, loose / 2))
    statistic = float(np.sum((counted - half) ** 2 / (half / 2)))
    upper, _ = chi_square_tails(statistic / (1 + float((free / half).max())), half.size)
    p_value = two_sided(upper, chi_square_tails(statistic, half.size)[1])
    detail = f"{statistic:.5g} for {half.size} degrees of freedom"
    return Check(name=name, waveband=waveband, p_value=p_value, found=statistic, detail=detail)


def weighted(
    weight: np.ndarray, weight2: np.ndarray, share: np.ndarray, name: str, waveband: int, *, is_mixed: bool = False
) -> Check:
    """Two-sided test of sums of weights against shares; the covariance is estimated from the squares of weights.

    Z_c = W_c - p_c W has the covariance S_c (c = d) - p_d S_c - p_c S_d + p_c p_d S, with sums of squares S. Z^T C^-1 Z
    over all cells but one is a chi-square. With `is_mixed` only too uneven photons fail.
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
    return chi_square_check(statistic, p.size - 1, name, waveband, is_two_sided=not is_mixed)


def even(observed: np.ndarray, expected: np.ndarray, loose: np.ndarray, name: str, waveband: int) -> Check:
    """Chi-square per degree of freedom of photons with counts from a plan, in cells that expect 1000 or more.

    For cells of whole patches it must stay below 0.1. Cells that cut patches or lobes have in addition their `loose`
    variance; then the p-value is an upper bound, that of (statistic - 0.1 degrees) over the largest share of loose
    variance.
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
    p_value, _ = chi_square_tails(max(statistic - MAX_PER_DEGREE * degrees, 0.0) / share, degrees)
    detail += ", which cut patches: the p-value is an upper bound"
    return Check(name=name, waveband=waveband, found=per_degree, p_value=p_value, detail=detail)


def share_checks(
    zones: PatchGrid,
    observed: np.ndarray,
    expected: np.ndarray,
    variance: Callable[[np.ndarray], float],
    waveband: int,
    *,
    photons_per_unit: float = 1.0,
) -> list[Check]:
    """Two-sided tests for a share of photons with one of the two commonest mistakes of a sampler.

    Uniform in zenith angle (the sine and the cosine are missing) shows in rings. Equal radiance from everywhere
    (Lambert) differs most in azimuth from a sky with a sun. The function `variance` gives the variance, or an upper
    bound, of the sum over photons of a number of their zones.
    """
    zone = np.arange(zones.n_patches)
    width, turn = (np.diff(x)[:, 0] for x in (zones.zenith_bounds_deg, zones.azimuth_bounds_deg))
    checks = []
    for name, group, mistake in (
        ("share uniform in zenith angle", zone // zones.n_azimuth, np.outer(width, turn).ravel()),
        ("share of equal radiance from everywhere (Lambert)", zone, zones.projected_solid_angle_sr),
    ):
        score, difference = share_score(mistake, expected, group, photons_per_unit)
        deviation = math.sqrt(variance(score))
        if deviation == 0:
            checks.append(untested(name, waveband))
            continue
        found, scale = float(score @ (observed - expected)), difference * float(expected.sum())
        p_value = math.erfc(abs(found) / deviation / math.sqrt(2))
        detail = f"standard deviation {deviation / scale:.2g}"
        checks.append(Check(name=name, waveband=waveband, found=found / scale, p_value=p_value, detail=detail))
    return checks


_LEAST_DIFFERENCE = 1e-6
"""If D is smaller, the sky itself is too similar to the mistake."""


def share_score(
    mistake: np.ndarray, expected: np.ndarray, group: np.ndarray, photons_per_unit: float = 1.0
) -> tuple[np.ndarray, float]:
    """Numbers of zones whose sum over photons best shows a small share of a mistake, and its difference D.

    Let the sky put the share p_c of photons into group c of zones, and the mistake the share u_c. The derivative of the
    log-likelihood at a share of 0 is the sum over c of a_c n_c, a_c = u_c / p_c - 1. It has the most power of all
    statistics of these counts against a small share s (Neyman and Pearson). Its expectation is s N D, D = sum of u_c^2
    / p_c - 1. Groups are joined in the order of u / p until they expect 1000 photons, which loses little power. A
    p-value of 1e-7 from the normal law is then within a factor of 1.5. Zeros for fewer than two groups, and if D is 0.
    """
    p_all, u_all = np.bincount(group, expected), np.bincount(group, mistake)
    lit = np.flatnonzero(p_all > 0)
    lit = lit[np.argsort(u_all[lit] / p_all[lit], kind="stable")]
    starts = pool_starts(p_all[lit] * photons_per_unit, MIN_EVEN)
    group_scores = np.zeros(p_all.size)
    if starts.size < 2:
        return group_scores[group], 0.0
    u, p = (np.add.reduceat(x[lit], starts) / x[lit].sum() for x in (u_all, p_all))
    difference = float(np.sum(u * u / p)) - 1
    if difference >= _LEAST_DIFFERENCE:
        group_scores[lit] = np.repeat(u / p - 1, np.diff(np.append(starts, lit.size)))
    return group_scores[group], difference
