"""Sums over photons, and the results of a waveband; they do not depend on how the work was divided."""

from __future__ import annotations

import math
import operator
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.component import Law
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.kernels.backend import use_kernels
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import Placement
from aomc_sky.plan.plan import Plan

_UNITS = 1 << 1074
"""Sums are whole numbers of units of 2^-1074, as every finite float is one: their order does not matter."""
_INFINITE = 1 << 2200
"""Units that stand for an infinite term; finite terms never reach them, and no float holds them."""


def _units(value: float) -> int:
    if not math.isfinite(value):
        return _INFINITE
    numerator, denominator = value.as_integer_ratio()
    return numerator * (_UNITS // denominator)


def _rounded(units: int) -> float:
    """The nearest float; infinite beyond their range."""
    try:
        return units / _UNITS
    except OverflowError:
        return math.inf


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockSums:
    """Sums over the photons of one block that belong to one replicate; weights are 1 unless photons carry them."""

    replicate: int  #: [0 to replicates - 1]
    n_photons: int
    mu: float
    inverse: float  #: of 1 / mu
    weight: float
    weighted_inverse: float  #: of weight / mu


_SUMMED = ("mu", "inverse", "weight", "weighted_inverse")


class PhotonSums:
    """Exact sums over the blocks of a band, replicate by replicate."""

    def __init__(self, replicates: int = 1) -> None:
        self._n_photons = [0] * replicates
        self._sums = {name: [0] * replicates for name in _SUMMED}

    def add(self, blocks: Iterable[BlockSums]) -> None:
        """Add the sums of blocks."""
        for block in blocks:
            self._n_photons[block.replicate] += block.n_photons
            for name, sums in self._sums.items():
                sums[block.replicate] += _units(getattr(block, name))

    def add_sums(self, other: PhotonSums) -> None:
        """Add the sums of other photons of the same band."""
        self._n_photons = [a + b for a, b in zip(self._n_photons, other._n_photons, strict=True)]
        for name, sums in self._sums.items():
            self._sums[name] = [a + b for a, b in zip(sums, other._sums[name], strict=True)]

    def as_json(self) -> dict[str, Any]:
        """The sums as JSON values, exactly."""
        return {"n_photons": self._n_photons, **self._sums}

    @classmethod
    def from_json(cls, values: dict[str, Any], replicates: int) -> PhotonSums:
        """The sums from the result of `as_json`; ValueError for anything else."""
        sums = cls(replicates)
        try:
            sums._n_photons, *columns = ([operator.index(n) for n in values[key]] for key in ("n_photons", *_SUMMED))
        except (KeyError, TypeError) as error:
            raise ValueError(f"these are no sums of photons ({error})") from error
        sums._sums = dict(zip(_SUMMED, columns, strict=True))
        if {len(column) for column in (sums._n_photons, *columns)} != {replicates}:
            raise ValueError(f"these are not sums of {replicates} replicates")
        return sums

    @property
    def n_photons(self) -> int:
        """Photons of all replicates."""
        return sum(self._n_photons)

    def total(self, name: str) -> float:
        """One sum over all photons, correctly rounded."""
        return _rounded(sum(self._sums[name]))

    def mean(self, name: str, per: str = "") -> float | None:
        """Mean over all photons, or `per` a sum; None without photons, infinite if a photon is horizontal."""
        return self.total(name) / self._divisor(per) if self.n_photons else None

    def planar_over_scalar(self, per: str = "") -> float | None:
        """1 / mean of 1 / mu: Ed / Eo of photons that carry equal flux, or None without photons."""
        return self._divisor(per) / self.total("inverse") if self.n_photons else None

    def standard_error(self, name: str, per: str = "") -> float | None:
        """Standard error of `mean`, from the scatter of the replicates."""
        counted = [_rounded(units) for units in self._sums[per]] if per else self._n_photons
        totals = np.array([_rounded(units) for units in self._sums[name]])
        return standard_error(totals, np.array(counted, np.float64))

    def _divisor(self, per: str) -> float:
        return self.total(per) if per else self.n_photons


def standard_error(totals: np.ndarray, n_photons: np.ndarray) -> float | None:
    """Standard error of sum(totals) / sum(n_photons), the mean over all photons of R independent replicates.

    With e_r = total_r - mean n_r it is sqrt(R / (R - 1) sum e_r^2) / N. Its own relative error is 1 / sqrt(2 (R - 1))
    for normal replicate means. The result is None for fewer than two replicates, no photons, or infinite totals.
    """
    n, all_photons = totals.size, math.fsum(n_photons)
    if n < 2 or all_photons == 0 or not np.all(np.isfinite(totals)):
        return None
    residual = totals - math.fsum(totals) / all_photons * n_photons
    return math.sqrt(n / (n - 1) * math.fsum(residual * residual)) / all_photons


def batch_functions() -> Any:
    """The functions for sums and records of a batch, plain or compiled, with the same bits."""
    if use_kernels(0):
        from aomc_sky.emission.kernels import batches

        return batches
    from aomc_sky.emission.kernels import plain

    return plain


def photon_sums(
    source: PhotonSource, band: int, start: int, uz: np.ndarray, weight: np.ndarray | None
) -> list[BlockSums]:
    """Sums over photons [start, start + n) of a band, separate for each replicate."""
    sums, functions = [], batch_functions()
    for replicate, begin, end in source.replicate_parts(band, start, start + uz.size):
        part = slice(begin - start, end - start)
        mu, inverse = functions.block_sums(uz[part])
        weights, weighted = float(end - begin), inverse
        if weight is not None:
            weights, weighted_mu, weighted = functions.weighted_block_sums(uz[part], weight[part])
            if source.has_bias:  # moments are those of the light
                mu, inverse = weighted_mu, weighted
        block_sums = {"mu": mu, "inverse": inverse, "weight": weights, "weighted_inverse": weighted}
        sums.append(BlockSums(replicate=replicate, n_photons=end - begin, **block_sums))
    return sums


@dataclass(frozen=True, kw_only=True, slots=True)
class BandResult:
    """The results of one waveband, in the order of the printed table.

    Means over photons are None without photons, and standard errors also without replicates. The planar irradiance per
    photon of weight 1 is `ed_photons`, the mean weight w. The scalar one is `eo_photons`, the mean of w / mu. The
    planar irradiance of all components is `irradiance_W_m2_nm`, where absolute units are known.
    """

    waveband: int
    wavelength_nm: float
    sky_wavelength_nm: float | None
    requested: int
    launched: int
    residual: int
    mean_cosine_exact: float | None
    mean_cosine_photons: float | None
    ed_over_eo_exact: float | None
    ed_over_eo_photons: float | None
    horizon_loss: float = 0.0
    irradiance_W_m2_nm: float | None = None  # noqa: N815
    component_irradiance_W_m2_nm: dict[str, float] | None = None  # noqa: N815
    ed_photons: float | None = None
    eo_photons: float | None = None
    mean_cosine_standard_error: float | None = None
    ed_over_eo_standard_error: float | None = None
    ed_standard_error: float | None = None
    eo_standard_error: float | None = None
    eo_variance_is_finite: bool = True


def band_results(source: PhotonSource, sums: Mapping[int, PhotonSums]) -> list[BandResult]:
    """Compare the photons of bands with the exact values of their masses."""
    plan, exact, have_variance = source.plan, source.moments_of([*sums]), scalars_have_variance(source.plan, sums)
    names, results = plan.component_names, []
    per = "weight" if source.has_bias else ""  # moments are those of the light
    for (band, of_band), moments, has_variance in zip(sums.items(), exact, have_variance, strict=True):
        plan_band, launched, scalar = plan.bands[band], source.launched[band], of_band.mean("weighted_inverse")
        ratio, inverse_error = of_band.planar_over_scalar(per), of_band.standard_error("inverse", per)
        absolute = plan_band.irradiance_W_m2_nm
        result = BandResult(
            waveband=band + 1,
            wavelength_nm=plan_band.wavelength_nm,
            sky_wavelength_nm=finite(plan_band.sky_wavelength_nm),
            requested=plan_band.requested,
            launched=launched,
            residual=launched - plan_band.requested,
            mean_cosine_exact=finite(moments.mean_mu),
            mean_cosine_photons=of_band.mean("mu", per),
            ed_over_eo_exact=finite(moments.planar_over_scalar),
            ed_over_eo_photons=ratio,
            horizon_loss=plan_band.horizon_loss,
            irradiance_W_m2_nm=None if absolute is None else math.fsum(absolute),
            component_irradiance_W_m2_nm=None if absolute is None else dict(zip(names, absolute, strict=True)),
            ed_photons=of_band.mean("weight"),
            eo_photons=None if scalar is None else finite(scalar),
            mean_cosine_standard_error=of_band.standard_error("mu", per),
            ed_over_eo_standard_error=None if inverse_error is None or ratio is None else ratio**2 * inverse_error,
            ed_standard_error=of_band.standard_error("weight"),
            eo_standard_error=of_band.standard_error("weighted_inverse"),
            eo_variance_is_finite=has_variance,
        )
        results.append(result)
    return results


def scalars_have_variance(plan: Plan, bands: Collection[int]) -> list[bool]:
    """Whether w / mu of a band's photons has a finite variance: no light at the horizon, or weights with a factor mu.

    The flux law has the density 2 mu near the horizon. The mean of 1 / mu is therefore finite, but the mean of 1 / mu^2
    is not.
    """
    if plan.options["placement"] == Placement.CENTRE.value:
        return [True] * len(bands)  # a finite number of directions
    at_horizon = [
        (c, law_of(c.law).reaches_horizon(c.cell))
        for c in plan.components
        if c.law is not Law.CELL_MU or c.weight is None  # their weights carry a factor mu
    ]
    rows = [plan.bands[band].row for band in bands]
    return [not any(np.any((c.mass[row] > 0) & is_there) for c, is_there in at_horizon) for row in rows]


def finite(value: float) -> float | None:
    """The value, or None if JSON has no number for it."""
    return value if math.isfinite(value) else None
