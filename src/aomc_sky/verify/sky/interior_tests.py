"""Tests of places inside patches, all patches together."""

from __future__ import annotations

import numpy as np

from aomc_sky.verify.report import Check
from aomc_sky.verify.sky.interior import InteriorCounts, PatchInterior
from aomc_sky.verify.sky.zone_tests import MIN_EVEN, of_chi_square, untested
from aomc_sky.verify.tails import kolmogorov_p

_COORDINATES = ("mu^2", "azimuth")


def interior_checks(
    interior: PatchInterior, counts: InteriorCounts, waveband: int, *, are_independent: bool
) -> list[Check]:
    """Chi-square and Kolmogorov-Smirnov of both coordinates.

    Where photons lie independently of each other inside patches the chi-square is two-sided; otherwise only too uneven
    positions fail. The Kolmogorov distance is taken between steps, so it is at most the true one, and the p-value at
    most too large.
    """
    checks = []
    n = int(counts.patch.sum())
    found_of = (counts.along, counts.across)
    for coordinate, found, expected in zip(_COORDINATES, found_of, interior.expected(counts.patch), strict=True):
        name = f"inside patches, {coordinate}"
        if n < MIN_EVEN or expected.min() < MIN_EVEN / found.size:
            checks += [untested(f"{name}: {kind}", waveband) for kind in ("chi-square", "Kolmogorov-Smirnov")]
            continue
        checks.append(_chi_square(found, expected, name, waveband, are_independent=are_independent))
        distance = float(np.abs(np.cumsum(found - expected)).max() / n)
        checks.append(
            Check(
                name=f"{name}: Kolmogorov-Smirnov",
                waveband=waveband,
                passed=True,
                found=distance,
                p_value=kolmogorov_p(distance, n),
                detail=f"{n} photons",
            )
        )
    return checks


def _chi_square(found: np.ndarray, expected: np.ndarray, name: str, waveband: int, *, are_independent: bool) -> Check:
    statistic, degrees = float(np.sum((found - expected) ** 2 / expected)), found.size - 1
    kind = "chi-square, two-sided" if are_independent else "chi-square"
    return of_chi_square(statistic, degrees, f"{name}: {kind}", waveband, is_two_sided=are_independent)
