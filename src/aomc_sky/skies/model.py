"""What every sky model promises, the sky models by name, and how one that only knows its radiance is sampled.

`SKY_MODELS` is the only place that names them; third parties add theirs as entry points of the group
``aomc_sky.sky_models``, which are looked at only for a name that is not there.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid

_GAUSS_ORDER = 4

ENTRY_POINT_GROUP = "aomc_sky.sky_models"

#: Name of a sky model -> "module:Class".
SKY_MODELS = {
    "atmosphere": "aomc_sky.skies.atmosphere:AtmosphereSky",
    "lobes": "aomc_sky.skies.lobes.sky:LobeSky",
    "tabulated": "aomc_sky.skies.tabulated:TabulatedSky",
    "perez": "aomc_sky.skies.perez.sky:PerezSky",
    "uniform": "aomc_sky.skies.uniform:UniformSky",
}


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


def sky_model(name: str) -> Any:
    """The class of a sky model, by a name of `SKY_MODELS` or of an entry point; its instances are `SkyModel`s."""
    target = SKY_MODELS.get(name)
    if target is not None:
        module, _, attribute = target.partition(":")
        return getattr(import_module(module), attribute)
    from importlib.metadata import entry_points

    for entry in entry_points(group=ENTRY_POINT_GROUP, name=name):
        return entry.load()
    raise UsageError(f"there is no sky model {name!r}; the models are {', '.join(sorted(SKY_MODELS))}")
