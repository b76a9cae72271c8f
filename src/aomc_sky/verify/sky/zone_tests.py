"""Tests of photons counted by zone: one statistic for each way in which photons may be tied together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.counts import MIN_EXPECTED
from aomc_sky.verify.report import Check
from aomc_sky.verify.tails import chi_square_rest, chi_square_tail, pool_starts, pooled

MIN_EVEN = 1000.0
"""Photons that a cell expects at least where stratified photons are tested for evenness."""

MAX_PER_DEGREE = 0.1
"""Chi-square per degree of freedom that stratified photons stay below in such cells; independent ones have 1."""

MIN_WEIGHTED = 100.0
"""Photons that a cell stands for at least where weights differ: their variance is estimated."""

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
    found, wanted = pooled(observed, expected, MIN_EXPECTED)
    name = f"{name}: chi-square" + ("" if is_mixed else ", two-sided")
    if wanted.size < 2:
        return untested(name, waveband)
    statistic = float(np.sum((found - wanted) ** 2 / wanted))
    return of_chi_square(statistic, wanted.size - 1, name, waveband, is_two_sided=not is_mixed)


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
    """Two-sided chi-square of evenly spread photons that a fair coin has thinned.

    Expectation N p / 2, variance N p / 4, and cells independent: chi-square with as many degrees of freedom as cells.
    Where cells cut patches or lobes the variance may be larger by `loose` / 4; the upper tail then allows for the
    largest share of it.
    """
    lit = expected > 0
    starts = pool_starts(expected[lit] / 2, MIN_EXPECTED)
    name = f"{name}: chi-square after a fair coin"
    if starts.size < 2:
        return untested(name, waveband)
    found, half, free = (np.add.reduceat(x[lit], starts) for x in (kept, expected / 2, loose / 2))
    statistic = float(np.sum((found - half) ** 2 / (half / 2)))
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
    found, wanted, free = (np.add.reduceat(x[lit], starts) for x in (observed, expected, loose))
    statistic, degrees = float(np.sum((found - wanted) ** 2 / wanted)), wanted.size - 1
    per_degree, share = statistic / degrees, RESONANCE * float((free / wanted).max())
    detail = f"{wanted.size} cells"
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
    detail += ", not of whole patches: p-value from above"
    return Check(name=name, waveband=waveband, passed=True, found=per_degree, p_value=p_value, detail=detail)


def by_marginals(zones: PatchGrid, test: Callable[..., Check], *of_zones: np.ndarray, waveband: int) -> list[Check]:
    """One test for each way of putting zones together; one with a single cell says nothing and is left out."""
    return [
        test(*(marginal.sums(values) for values in of_zones), marginal.name, waveband)
        for marginal in marginals(zones)
        if marginal.group.max() > 0
    ]
