"""What a run says of its photons: means of mu and 1/mu that no split into threads or batches can change."""

from __future__ import annotations

import math
import sys

import numpy as np

from aomc_sky.outputs.manifest import BandResult, finite
from aomc_sky.source.photon_source import PhotonSource


class PhotonSums:
    """Sums of mu and 1/mu over the fixed blocks of a band, combined exactly."""

    def __init__(self) -> None:
        self._mu: list[float] = []
        self._inverse: list[float] = []

    def add(self, sums: tuple[float, float]) -> None:
        """Add the sums of the next block."""
        self._mu.append(sums[0])
        self._inverse.append(sums[1])

    def means(self, n_photons: int) -> tuple[float | None, float | None]:
        """Mean cosine and Ed/Eo of the photons; None where none were emitted."""
        if n_photons == 0 or not self._mu:
            return None, None
        inverse = math.fsum(self._inverse) if all(map(math.isfinite, self._inverse)) else math.inf
        return math.fsum(self._mu) / n_photons, n_photons / inverse


def block_sums(uz: np.ndarray) -> tuple[float, float]:
    """Sums of mu and 1/mu over a block; the plain and the compiled form add in the same order."""
    if "aomc_sky.kernels.emit" in sys.modules:
        from aomc_sky.kernels.statistics import block_sums as compiled

        return compiled(uz)
    from aomc_sky.kernels import plain

    return plain.block_sums(uz)


def band_result(source: PhotonSource, band: int, sums: PhotonSums) -> BandResult:
    """Compare the photons of a band with the exact values of its masses."""
    arrays, moments = source.plan.arrays, source.exact_moments(band)
    requested, launched = int(arrays["requested"][band]), source.n_photons(band)
    mean_cosine, ratio = sums.means(launched)
    return BandResult(
        waveband=band + 1,
        wavelength_nm=float(arrays["wavelength_nm"][band]),
        sky_wavelength_nm=finite(float(arrays["sky_wavelength_nm"][band])),
        requested=requested,
        launched=launched,
        residual=launched - requested,
        mean_cosine_exact=finite(moments.mean_mu),
        mean_cosine_photons=mean_cosine,
        ed_over_eo_exact=finite(moments.planar_over_scalar),
        ed_over_eo_photons=ratio,
    )
