"""The overcast sky of the CIE, which ocean optics calls the cardioidal sky: radiance as 1 + 2 cos z."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.function_sky import FunctionSky
from aomc_sky.skies.model import Share, broadcast, with_share


@dataclass(frozen=True, kw_only=True, slots=True)
class OvercastSky(Share):
    """Radiance (1 + 2 cos z) / 3 of the zenith's, z being the zenith angle: three times the horizon's in the zenith.

    Moon and Spencer, Illum. Eng. 37 (1942) 707; the standard overcast sky of the CIE, and the cardioidal sky of Mobley,
    Light and Water (1994), sect. 4.6. Without sun and beam, the same at all wavelengths.

    Parameters
    ----------
    grid : PatchGrid
        Patches of its photons; by default 720 rings of an eighth of a degree, in which the mean cosine 5/7 of the
        photons is exact to 2e-7.
    strength, irradiance_W_m2_nm : array_like, optional
        As for `UniformSky`. [>= 0]

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="overcast")
    >>> round(scene.source().exact_moments(0).mean_mu, 6)
    0.714286
    """

    grid: PatchGrid = field(default_factory=lambda: PatchGrid.regular(720, 1))

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of sky elements, as a share of the zenith's; 0 below the horizon."""
        zenith, _, _ = broadcast(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        return np.where(zenith > np.pi / 2, 0.0, (1.0 + 2.0 * np.cos(zenith)) / 3.0)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of rings."""
        return with_share(self, FunctionSky(self.radiance, grid=self.grid, name="overcast").lower(wavelength_nm))


CardioidalSky = OvercastSky
"""The name that ocean optics uses."""
