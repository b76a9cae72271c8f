"""What every sky model promises, and how a model that only knows its radiance reaches the sampler."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.grid import PatchGrid

_GAUSS_ORDER = 4


@runtime_checkable
class SkyModel(Protocol):
    """Radiance of the sky.

    `radiance` broadcasts its arguments and is finite, not negative, and pure: equal arguments give
    equal values. A model may also have `lower(wavelength_nm)`, which returns its components with
    exact laws; one without is lowered to patches of constant radiance by `lower_radiance`.
    """

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance, relative unless the model says otherwise, of a sky element. [>= 0]"""
        ...


def lower_radiance(model: SkyModel, grid: PatchGrid, wavelength_nm: ArrayLike, *, name: str) -> tuple[Component, ...]:
    """Lower any model to one component of patches with constant radiance, flux law, a row of masses per wavelength.

    Its mass is the integral of L cos over each patch by 4 x 4 Gauss points in mu^2 and azimuth, its strength the sum of
    the masses.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_ORDER)
    share, weights = (nodes + 1) / 2, weights / 2
    near, growth, far = grid.ring_sin2()
    sin2 = near[:, None] + growth[:, None] * share
    cos2 = far[:, None] + growth[:, None] * (1 - share)
    zenith = np.arctan2(np.sqrt(sin2), np.sqrt(cos2))
    bounds = np.deg2rad(grid.azimuth_bounds_deg)
    azimuth = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * share
    wavelengths = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    mass = np.empty((wavelengths.size, grid.n_patches))
    for row, wavelength in enumerate(wavelengths):
        radiance = model.radiance(zenith[:, None, :, None], azimuth[None, :, None, :], wavelength)
        mean = np.einsum(
            "zaij,i,j->za", np.broadcast_to(radiance, (*zenith.shape[:1], *azimuth.shape[:1], 4, 4)), weights, weights
        )
        mass[row] = mean.ravel() * grid.projected_solid_angle_sr
    component = Component(
        name=name, law=Law.CELL_MU2, strength=mass.sum(axis=1), mass=mass, cell=cells_of_grid(grid), grid=grid
    )
    return (component,)
