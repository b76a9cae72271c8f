"""Exact values of the measured quantities, by sums over patches or by quadrature, each with its own error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aomc_sky.benchmark.quadrature import cone_of_model, cone_of_table, hemisphere_of_model
from aomc_sky.benchmark.quantities import (
    CONE_HALF_ANGLE_DEG,
    RING_ZENITH_DEG,
    Values,
    cone_axis,
    histogram_grid,
    ring_mu,
)
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky

MASS_ERROR = 1e-10
"""Relative error that `PerezSky.patch_mass` promises."""
ROUNDING = 1e-13
"""Bound of the rounding of sums over 32 400 patches."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Truth:
    """What a perfect sampler would give."""

    #: The quantities of the sky.
    values: Values
    #: Relative error of each: the difference of two orders of a quadrature, at least the rounding.
    error: Mapping[str, float]


def truth_of_table(grid: PatchGrid, mass: np.ndarray) -> Truth:
    """Values of a sky that is uniform in mu^2 and azimuth inside each patch, its masses of any scale.

    Exact sums; the cone by Gauss points between all edges that its rim crosses.
    """
    share = (mass / np.sum(mass)).reshape(grid.n_zenith, grid.n_azimuth)
    near, far = grid.ring_mu()
    rings = share.sum(axis=1)
    bins = histogram_grid()
    shares = _overlap_mu2(grid, bins).T @ share @ _overlap_azimuth(grid, bins)
    low, high = ring_mu()
    cut = np.clip(np.minimum(near, high) ** 2 - np.maximum(far, low) ** 2, 0.0, None)
    cone, cone_error = cone_of_table(grid, share, cone_axis(), np.deg2rad(CONE_HALF_ANGLE_DEG))
    values = Values(
        planar=float(rings @ ((2.0 / 3.0) * (near * near + near * far + far * far) / (near + far))),
        scalar=float(rings @ (2.0 / (near + far))),
        cone=cone,
        ring=float(rings @ (cut / grid.ring_sin2()[1])),
        histogram=shares.ravel(),
    )
    exact = dict.fromkeys(("planar", "scalar", "ring", "histogram"), ROUNDING)
    return Truth(values=values, error={**exact, "cone": max(cone_error, ROUNDING)})


def _overlap_mu2(grid: PatchGrid, bins: PatchGrid) -> np.ndarray:
    """Share of each ring of the grid that lies in each row of bins, in mu^2, shape (n_zenith, n_row)."""
    near, far = (mu**2 for mu in grid.ring_mu())
    top, bottom = (mu**2 for mu in bins.ring_mu())
    common = np.minimum.outer(near, top) - np.maximum.outer(far, bottom)
    return np.clip(common, 0.0, None) / grid.ring_sin2()[1][:, None]


def _overlap_azimuth(grid: PatchGrid, bins: PatchGrid) -> np.ndarray:
    """Share of each column of the grid that lies in each sector, shape (n_azimuth, n_sector)."""
    start, end = grid.azimuth_bounds_deg.T
    total = np.zeros((grid.n_azimuth, bins.n_azimuth))
    for turn in (-360.0, 0.0, 360.0):
        first, last = bins.azimuth_bounds_deg.T + turn
        total += np.clip(np.minimum.outer(end, last) - np.maximum.outer(start, first), 0.0, None)
    return total / (end - start)[:, None]


def truth_of_perez(model: PerezSky) -> Truth:
    """Values of the continuous Perez sky, positive everywhere, its sun neither overhead nor inside the cone.

    Planar and scalar irradiance in polar coordinates around the sun, the cone in its own, at two orders each; bins and
    ring from `PerezSky.patch_mass`.
    """
    (flux, with_mu, without_mu), error = hemisphere_of_model(model)
    cone, cone_error = cone_of_model(model, cone_axis(), np.deg2rad(CONE_HALF_ANGLE_DEG))
    around = PatchGrid(zenith_bounds_deg=np.array([RING_ZENITH_DEG]), azimuth_bounds_deg=np.array([[0.0, 360.0]]))
    values = Values(
        planar=with_mu / flux,
        scalar=without_mu / flux,
        cone=cone / flux,
        ring=float(model.patch_mass(around)[0]),
        histogram=model.patch_mass(histogram_grid()),
    )
    return Truth(
        values=values,
        error={
            "planar": error,
            "scalar": error,
            "cone": cone_error + error,
            "ring": MASS_ERROR,
            "histogram": MASS_ERROR,
        },
    )
