"""The clear sky of Harrison and Coombes (1988), as HydroLight users know it."""

from __future__ import annotations

import math
from dataclasses import InitVar, dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.skies.model import Share, check_share
from aomc_sky.skies.perez.sky import PerezSky


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class HarrisonCoombesSky(Share):
    """Relative radiance of a cloudless sky: (1.63 + 53.7 exp(-5.49 p) + 2.04 cos^2 p cos Z) (1 - exp(-0.19 / cos z)).

    z is the zenith angle of a sky element, p its angle from the sun in radians, Z the zenith angle of the sun. Harrison
    and Coombes, Solar Energy 40 (1988) 387, for a sky without clouds. It is the law of Perez with other coefficients,
    so photons follow it exactly inside patches. The direct beam is not in it; the same at all wavelengths.

    Parameters
    ----------
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun. [0 to below 90 degrees]
    sun_azimuth_deg, or sun_azimuth_rad : float
        Azimuth of the sun from +x (east) towards +y (north). [any turn]
    strength, irradiance_W_m2_nm : array_like, optional
        As for `UniformSky`. [>= 0]

    Examples
    --------
    >>> import aomc_sky as sky
    >>> model = sky.HarrisonCoombesSky(sun_zenith_deg=40.0, sun_azimuth_deg=0.0)
    >>> photons = sky.Scene(wavebands=[550.0], n_photons=1000, components=model).source().photons()
    >>> len(photons)
    1000
    """

    sun_zenith_rad: float = None  # type: ignore[assignment]
    sun_azimuth_rad: float = None  # type: ignore[assignment]
    sun_zenith_deg: InitVar[float | None] = None
    sun_azimuth_deg: InitVar[float | None] = None

    def __post_init__(self, sun_zenith_deg: float | None, sun_azimuth_deg: float | None) -> None:
        check_share(self)
        settle_angles(self, sun_zenith_rad=sun_zenith_deg, sun_azimuth_rad=sun_azimuth_deg)
        self._law()  # which checks the sun

    def _law(self) -> PerezSky:
        e = 2.04 * math.cos(self.sun_zenith_rad) / 1.63
        return PerezSky(
            sun_zenith_rad=self.sun_zenith_rad,
            sun_azimuth_rad=self.sun_azimuth_rad,
            coefficients=(-1.0, -0.19, 53.7 / 1.63, -5.49, e),
            strength=self.strength,
            irradiance_W_m2_nm=self.irradiance_W_m2_nm,
        )

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of sky elements, relative; 0 below the horizon."""
        return self._law().radiance(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches."""
        return self._law().lower(wavelength_nm)
