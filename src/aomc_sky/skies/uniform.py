"""A sky of equal radiance everywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.errors import require_switch
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.model import Share, broadcast, check_share, with_share


@dataclass(frozen=True, kw_only=True, slots=True)
class UniformSky(Share):
    """Relative radiance 1 in every direction above the horizon.

    Parameters
    ----------
    per_solid_angle : bool
        False: photons through the horizontal sea surface, density proportional to the cosine (flux
        law). True: density uniform in solid angle, AOMC's own law for its diffuse light.
    strength : array_like, optional
        Share of the light in a scene of several models: relative irradiance on a horizontal plane, a number or one for
        each wavelength of the scene. [>= 0]
    irradiance_W_m2_nm : array_like, optional
        The same in absolute units, for all components of a scene or none. [W m-2 nm-1]

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components=sky.UniformSky())
    >>> print(f"{scene.source().exact_moments(0).mean_mu:.6f}")
    0.666667
    """

    per_solid_angle: bool = False

    def __post_init__(self) -> None:
        check_share(self)
        require_switch(self.per_solid_angle, "per_solid_angle")

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Relative radiance: 1 everywhere, 0 below the horizon."""
        zenith, _, _ = broadcast(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        return np.where(np.isnan(zenith), np.nan, np.where(zenith > np.pi / 2, 0.0, 1.0))

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One cell, the whole dome, so that low-discrepancy points fill it as one."""
        grid = PatchGrid.regular(1, 1)
        law = Law.CELL_MU if self.per_solid_angle else Law.CELL_MU2
        component = Component(
            name="uniform",
            law=law,
            strength=np.ones(np.size(wavelength_nm)),
            mass=np.ones((1, 1)),
            cell=cells_of_grid(grid, law),
            grid=grid,
            weight=np.full((1, 1), 2.0) if self.per_solid_angle else None,
        )
        return with_share(self, (component,))
