"""The five quantities whose error is measured, and their sums over emitted photons.

Photons follow the flux law (density proportional to radiance times cosine), so a share of the photons is a share of
the planar irradiance. None of the edges below is an edge of a patch, for stratified samplers are exact on those.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.grid import PatchGrid
from aomc_sky.source.photons import PhotonBatch

QUANTITIES = ("planar", "scalar", "cone", "histogram", "ring")

TITLES = {
    "planar": "planar irradiance (mean of mu)",
    "scalar": "scalar irradiance (mean of 1/mu)",
    "cone": "cone of 5 degrees",
    "histogram": "288 bins of the refracted direction",
    "ring": "ring at 87.3 to 88.7 degrees",
}

REFRACTIVE_INDEX = 1.34
CONE_ZENITH_DEG, CONE_AZIMUTH_DEG, CONE_HALF_ANGLE_DEG = 33.37, 217.71, 5.0
RING_ZENITH_DEG = (87.3, 88.7)
N_ROWS, N_SECTORS = 12, 24
FIRST_SECTOR_DEG = 3.7


def histogram_grid() -> PatchGrid:
    """The bins of the refracted direction as patches of the sky.

    12 rows, equal in the angle of refraction from 0 to the critical angle, times 24 sectors of 15 degrees of azimuth,
    the first from 3.7 degrees. A row of refracted angles is a ring of sky zenith angles (Snell's law).
    """
    critical = np.arcsin(1.0 / REFRACTIVE_INDEX)
    sine = REFRACTIVE_INDEX * np.sin(np.linspace(0.0, critical, N_ROWS + 1)[:-1])
    zenith = np.append(np.rad2deg(np.arcsin(sine)), 90.0)
    azimuth = FIRST_SECTOR_DEG + np.arange(N_SECTORS + 1) * (360.0 / N_SECTORS)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def cone_axis() -> np.ndarray:
    """Sky direction of the cone's axis: x, y, z."""
    (sine, east), (cosine, north) = sin_cos_deg(np.array([CONE_ZENITH_DEG, CONE_AZIMUTH_DEG]))
    return np.array([sine * north, sine * east, cosine])


def ring_mu() -> np.ndarray:
    """Lower and upper cosine of the ring."""
    return sin_cos_deg(np.array(RING_ZENITH_DEG[::-1]))[1]


@dataclass(frozen=True, kw_only=True, slots=True)
class Values:
    """The quantities, of photons or of a sky."""

    #: planar, scalar: Means of mu and of 1 / mu over the photons. [0 to 1; 1 to inf]
    planar: float
    scalar: float
    #: cone, ring: Shares of the photons. [0 to 1]
    cone: float
    ring: float
    #: Shares of the photons. [0 to 1, shape (288,)]
    histogram: np.ndarray

    def relative_error(self, truth: Values, quantity: str) -> float:
        """Signed relative error of a quantity; of the histogram the Euclidean norm of it over that of the truth."""
        if quantity == "histogram":
            return float(np.linalg.norm(self.histogram - truth.histogram) / np.linalg.norm(truth.histogram))
        true = float(getattr(truth, quantity))
        return (float(getattr(self, quantity)) - true) / true


class Tally:
    """Sums over photons, batch by batch.

    Edges of the histogram are taken in the precision of the photons, the rest in float64.
    """

    def __init__(self) -> None:
        from aomc_sky.kernels.batches.tally import tally

        self._add = tally
        self._cone = np.append(cone_axis(), sin_cos_deg(np.array([CONE_HALF_ANGLE_DEG]))[1])
        self._ring = ring_mu()
        grid = histogram_grid()
        sine, cosine = sin_cos_deg(grid.azimuth_bounds_deg[: N_SECTORS // 2, 0])
        self._row_mu = np.ascontiguousarray(grid.mu_edges[1:-1])
        self._starts = np.column_stack([cosine, sine])
        self._sums = np.zeros(4)
        self._histogram = np.zeros((N_ROWS, N_SECTORS), np.int64)

    def add(self, ux: np.ndarray, uy: np.ndarray, uz: np.ndarray) -> None:
        """Count photons by their travel directions, z up, each array of shape (n,)."""
        row_mu, starts = self._row_mu.astype(ux.dtype), self._starts.astype(ux.dtype)
        self._add(ux, uy, uz, self._cone, self._ring, row_mu, starts, self._sums, self._histogram)

    def add_batch(self, batch: PhotonBatch) -> None:
        """Count the photons of a batch."""
        self.add(batch.ux, batch.uy, batch.uz)

    def values(self) -> Values:
        """The quantities of the photons so far; all 0 where there is none, as AOMC's rounding of few photons does."""
        n = max(int(self._histogram.sum()), 1)
        planar, scalar, cone, ring = (self._sums / n).tolist()
        return Values(planar=planar, scalar=scalar, cone=cone, ring=ring, histogram=self._histogram.ravel() / n)
