"""Sums over the photons of a block, and what a run says of its photons, which no split of the work can change."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.emission.irradiance import scalar_has_variance
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.kernels.backend import use_kernels

_MOST_TERMS = 4096


class ExactSum:
    """A sum that no order or grouping of its terms changes.

    Terms are kept as they are until they are many. Then they become an expansion: the sum rounded to nearest, what is
    left of it rounded, and so on to zero, at most forty numbers, whose sum is that of the terms without any error.
    A term that is not finite, and a sum beyond the range of floats, make it infinite.
    """

    __slots__ = ("_terms",)

    def __init__(self) -> None:
        self._terms: list[float] = []

    def add(self, term: float) -> None:
        """Add a number."""
        self._terms.append(term)
        if len(self._terms) > _MOST_TERMS:
            self._terms = _expansion(self._terms)

    def add_sum(self, other: ExactSum) -> None:
        """Add another sum."""
        for term in other._terms:
            self.add(term)

    @property
    def terms(self) -> list[float]:
        """A few numbers whose sum is this one without any error."""
        return _expansion(self._terms)

    @property
    def value(self) -> float:
        """The sum, correctly rounded."""
        return _rounded(self._terms)


def _rounded(terms: list[float]) -> float:
    try:
        return math.fsum(terms) if all(map(math.isfinite, terms)) else math.inf
    except OverflowError:
        return math.inf


def _expansion(terms: list[float]) -> list[float]:
    parts: list[float] = []
    while part := _rounded(terms):
        parts.append(part)
        if math.isinf(part):
            return [part]
        terms = [*terms, -part]
    return parts


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockSums:
    """Sums over the photons of one block that belong to one replicate."""

    replicate: int  #: replicate of the photons [0 to replicates - 1]
    n_photons: int  #: how many they are
    #: sums of mu and of 1 / mu
    mu: float
    inverse: float
    #: sums of the weight w and of w / mu; w is 1 where photons carry no weights
    weight: float
    weighted_inverse: float


_SUMMED = ("mu", "inverse", "weight", "weighted_inverse")


class PhotonSums:
    """Sums over the fixed blocks of a band, combined exactly, replicate by replicate."""

    def __init__(self, replicates: int = 1) -> None:
        self._n_photons = [0] * replicates
        self._sums = {name: [ExactSum() for _ in range(replicates)] for name in _SUMMED}

    def add(self, blocks: Iterable[BlockSums]) -> None:
        """Add the sums of the next photons."""
        for block in blocks:
            self._n_photons[block.replicate] += block.n_photons
            for name, sums in self._sums.items():
                sums[block.replicate].add(getattr(block, name))

    def add_sums(self, other: PhotonSums) -> None:
        """Add the sums of other photons of the same band."""
        self._n_photons = [a + b for a, b in zip(self._n_photons, other._n_photons, strict=True)]
        for name, sums in self._sums.items():
            for of_replicate, of_other in zip(sums, other._sums[name], strict=True):
                of_replicate.add_sum(of_other)

    def as_json(self) -> dict[str, Any]:
        """The sums as JSON values, without any error; a sum without an end is null."""
        sums = {
            name: [[t if math.isfinite(t) else None for t in r.terms] for r in self._sums[name]] for name in _SUMMED
        }
        return {"n_photons": self._n_photons, **sums}

    @classmethod
    def from_json(cls, values: dict[str, Any], replicates: int) -> PhotonSums:
        """What `as_json` gave; ValueError for anything else."""
        sums = cls(replicates)
        try:
            sums._n_photons = [operator.index(n) for n in values["n_photons"]]
            for name, of_replicates in sums._sums.items():
                for of_replicate, terms in zip(of_replicates, values[name], strict=True):
                    for term in terms:
                        of_replicate.add(math.inf if term is None else float(term))
        except (KeyError, TypeError) as error:
            raise ValueError(f"these are no sums of photons ({error})") from error
        if len(sums._n_photons) != replicates:
            raise ValueError(f"these are sums of {len(sums._n_photons)} replicates, not {replicates}")
        return sums

    def totals(self, name: str) -> list[float]:
        """One sum over each replicate, correctly rounded; infinite where a photon is horizontal."""
        return [of_replicate.value for of_replicate in self._sums[name]]

    @property
    def n_photons(self) -> int:
        """Photons of all replicates."""
        return sum(self._n_photons)

    def total(self, name: str) -> float:
        """One sum over all photons, correctly rounded."""
        every = ExactSum()
        for of_replicate in self._sums[name]:
            every.add_sum(of_replicate)
        return every.value

    def mean(self, name: str) -> float | None:
        """Mean over all photons; None where none were emitted, infinite where a photon is horizontal."""
        return self.total(name) / self.n_photons if self.n_photons else None

    def planar_over_scalar(self) -> float | None:
        """1 / mean of 1 / mu: Ed / Eo of photons that carry equal flux; None where none were emitted."""
        return self.n_photons / self.total("inverse") if self.n_photons else None

    def standard_error(self, name: str) -> float | None:
        """Standard error of `mean`, from the scatter of the replicates; see `standard_error`."""
        return standard_error(np.array(self.totals(name)), np.array(self._n_photons, np.float64))


def standard_error(totals: np.ndarray, n_photons: np.ndarray) -> float | None:
    """Standard error of sum(totals) / sum(n_photons), the mean over all photons of R independent replicates.

    With e_r = total_r - mean n_r it is sqrt(R / (R - 1) sum e_r^2) / N; None for fewer than two
    replicates, no photons, or a total that is not finite. Its own relative error is
    1 / sqrt(2 (R - 1)) for normal replicate means.
    """
    n, all_photons = totals.size, math.fsum(n_photons)
    if n < 2 or all_photons == 0 or not np.all(np.isfinite(totals)):
        return None
    residual = totals - math.fsum(totals) / all_photons * n_photons
    return math.sqrt(n / (n - 1) * math.fsum(residual * residual)) / all_photons


def batch_functions() -> Any:
    """The sums and records of a batch, plain or compiled, which give the same bits."""
    if use_kernels(0):
        from aomc_sky.emission.kernels import batches

        return batches
    from aomc_sky.emission.kernels import plain

    return plain


def photon_sums(
    source: PhotonSource, band: int, start: int, uz: np.ndarray, weight: np.ndarray | None
) -> list[BlockSums]:
    """Sums over photons [start, start + n) of a band, apart for each replicate among them."""
    sums, of_batch = [], batch_functions()
    for replicate, begin, end in source.replicate_parts(band, start, start + uz.size):
        part = slice(begin - start, end - start)
        mu, inverse = of_batch.block_sums(uz[part])
        of_weights = (float(end - begin), inverse)
        if weight is not None:
            of_weights = of_batch.weighted_block_sums(uz[part], weight[part])
        sums.append(
            BlockSums(
                replicate=replicate,
                n_photons=end - begin,
                mu=mu,
                inverse=inverse,
                weight=of_weights[0],
                weighted_inverse=of_weights[1],
            )
        )
    return sums


@dataclass(frozen=True, kw_only=True, slots=True)
class BandResult:
    """One waveband of a run, in the order of the printed table.

    Means of the photons are None where none were emitted, standard errors besides where there are no
    replicates. `ed_photons` is the mean weight w, `eo_photons` the mean of w / mu: planar and scalar
    irradiance in units of what one photon of weight 1 stands for. Where absolute units are known
    `irradiance_W_m2_nm` is the planar irradiance of all components together.
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


def band_result(source: PhotonSource, band: int, sums: PhotonSums) -> BandResult:
    """Compare the photons of a band with the exact values of its masses."""
    arrays, moments = source.plan.arrays, source.exact_moments(band)
    requested, launched = int(arrays["requested"][band]), source.n_photons(band)
    ratio, inverse_error = sums.planar_over_scalar(), sums.standard_error("inverse")
    scalar = sums.mean("weighted_inverse")
    absolute = source.irradiance(band)
    return BandResult(
        waveband=band + 1,
        wavelength_nm=float(arrays["wavelength_nm"][band]),
        sky_wavelength_nm=finite(float(arrays["sky_wavelength_nm"][band])),
        requested=requested,
        launched=launched,
        residual=launched - requested,
        mean_cosine_exact=finite(moments.mean_mu),
        mean_cosine_photons=sums.mean("mu"),
        ed_over_eo_exact=finite(moments.planar_over_scalar),
        ed_over_eo_photons=ratio,
        horizon_loss=source.horizon_loss(band),
        irradiance_W_m2_nm=None if absolute is None else math.fsum(absolute.values()),
        component_irradiance_W_m2_nm=absolute,
        ed_photons=sums.mean("weight"),
        eo_photons=None if scalar is None else finite(scalar),
        mean_cosine_standard_error=sums.standard_error("mu"),
        ed_over_eo_standard_error=None if inverse_error is None or ratio is None else ratio**2 * inverse_error,
        ed_standard_error=sums.standard_error("weight"),
        eo_standard_error=sums.standard_error("weighted_inverse"),
        eo_variance_is_finite=scalar_has_variance(source.plan, band),
    )


def finite(value: float) -> float | None:
    """The value, or None where JSON has no number for it."""
    return value if math.isfinite(value) else None
