"""The counts of a plan against its masses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aomc_sky.sampling.allocation import AllocationMethod
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.counts import CountCheck, verify_counts
from aomc_sky.verify.report import Check

_ROUNDING = 1e-6
"""Of the AOMC program, which works in the table's own units: share of a photon."""


def count_checks(source: PhotonSource, bands: Sequence[int]) -> list[Check]:
    """Check the counts of wavebands as `aomc_sky.verify_counts` does, of each replicate on its own; the worst one
    counts.

    Under allocation aomc every cell is what is expected, rounded to a whole number.
    """
    options = source.plan.options
    method = AllocationMethod(options["allocation"])
    checks: list[Check] = []
    for band in bands:
        if method is AllocationMethod.AOMC:
            checks.append(_rounded(source, band))
            continue
        if source.mass(band).max(initial=0.0) > 0:
            checks += _of_band(source, band, method)
    return checks


def _of_band(source: PhotonSource, band: int, method: AllocationMethod) -> list[Check]:
    counts = source.replicate_counts(band)
    each, left = divmod(int(source.plan.arrays["requested"][band]), source.replicates)
    wanted = each + (np.arange(source.replicates) < left)
    report = verify_counts(counts, source.mass(band), method=method, n_photons=wanted)
    found: dict[str, Check] = {}
    for check in (_as_check(c, band, several=source.replicates > 1) for c in report.checks):
        if check.p_value is not None:  # every replicate is a test of its own
            found[f"{check.name}, {check.detail}"] = check
        elif check.name not in found or found[check.name].passed:
            found[check.name] = check
    return list(found.values())


def _as_check(check: CountCheck, band: int, *, several: bool) -> Check:
    where = [f"replicate {check.band}"] if several else []
    is_test = check.name.startswith("chi-square, ")
    if check.cell is not None and not check.passed:
        where.append(f"cell {check.cell}")
    result = Check(
        name=f"counts: {check.name.partition(',')[0] if is_test else check.name}",
        waveband=band + 1,
        passed=check.passed,
        found=check.found,
        allowed=check.allowed,
        detail=", ".join(where),
    )
    if not is_test:
        return result
    detail = ", ".join([check.name.partition(", ")[2], *where])
    return replace(result, found=None, allowed=None, p_value=check.found, detail=detail)


def _rounded(source: PhotonSource, band: int) -> Check:
    wanted = source.expected(band)
    off = np.abs(source.counts[band] - wanted)
    worst = int(off.argmax())
    allowed = 0.5 + _ROUNDING * max(1.0, float(wanted[worst]))
    is_near = bool(off[worst] <= allowed)
    return Check(
        name="counts: each cell rounded",
        waveband=band + 1,
        passed=is_near,
        found=float(off[worst]),
        allowed=allowed,
        detail="" if is_near else f"cell {worst}",
    )
