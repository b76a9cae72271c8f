"""The sky of Harrison and Coombes (1988), clear to overcast, as HydroLight users know it."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import InitVar, dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.errors import SceneError, floats, number
from aomc_sky.skies.function_sky import FunctionSky
from aomc_sky.skies.model import Share, check_share, polarised, sky_repr, with_share
from aomc_sky.skies.perez.sky import PerezSky

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class HarrisonCoombesSky(Share):
    """Relative radiance of a sky with the cloud cover C: C N_cloud + (1 - C) N_clear.

    N_clear = (1.63 + 53.7 exp(-5.49 p) + 2.04 cos^2 p cos Z) (1 - exp(-0.19 / cos z)) (1 - exp(-0.53 / cos Z)). N_cloud
    = 0.45 + 0.12 Z + 0.43 cos z + 0.72 exp(-1.88 p). A sky element has the zenith angle z and the angle p from the sun;
    the sun has the zenith angle Z, all in radians. Harrison and Coombes, Solar Energy 41 (1988) 387, eqs. (3) to (5),
    the default sky of HydroLight. Without clouds it is the law of Perez with other coefficients, and photons follow it
    exactly inside patches. The direct beam is not in it; the same at all wavelengths.

    Parameters
    ----------
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun. [0 to below 90 degrees]
    sun_azimuth_deg, or sun_azimuth_rad : float
        Azimuth of the sun from +x (east) towards +y (north); 0 by default. [any turn]
    cloud_cover : float
        Cover C of opaque clouds. [0, the default, to 1]
    polarisation : RayleighPattern, optional
        Linear polarisation of the light; without it photons carry none.
    strength, irradiance_W_m2_nm : array_like, optional
        As for `UniformSky`. [>= 0]

    Examples
    --------
    >>> model = sky.HarrisonCoombesSky(sun_zenith_deg=40.0, sun_azimuth_deg=0.0)
    >>> photons = (
    ...     sky.Scene(wavebands=[550.0], n_photons=1000, components=model)
    ...     .source()
    ...     .photons()
    ... )
    >>> len(photons)
    1000
    """

    sun_zenith_rad: float = None  # type: ignore[assignment]
    sun_azimuth_rad: float = None  # type: ignore[assignment]
    cloud_cover: float = 0.0
    polarisation: RayleighPattern | None = None
    sun_zenith_deg: InitVar[float | None] = None
    sun_azimuth_deg: InitVar[float | None] = None

    __repr__ = sky_repr

    def __post_init__(self, sun_zenith_deg: float | None, sun_azimuth_deg: float | None) -> None:
        if not 0.0 <= number("cloud_cover", self.cloud_cover) <= 1.0:
            raise SceneError(f"cloud_cover must be 0 to 1, got {self.cloud_cover!r}")
        check_share(self)
        settle_angles(self, sun_zenith_rad=sun_zenith_deg)
        settle_angles(self, default=0.0, sun_azimuth_rad=sun_azimuth_deg)
        self._law()  # which checks the sun

    def _law(self) -> PerezSky:
        return dataclasses.replace(
            _clear(self.sun_zenith_rad, self.sun_azimuth_rad),
            strength=self.strength,
            irradiance_W_m2_nm=self.irradiance_W_m2_nm,
            polarisation=self.polarisation,
        )

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """C N_cloud + (1 - C) N_clear of sky elements; 0 below the horizon."""
        law, cosine = _clear(self.sun_zenith_rad, self.sun_azimuth_rad), math.cos(self.sun_zenith_rad)
        clear = law.radiance(sky_zenith_rad, sky_azimuth_rad, wavelength_nm) * (-1.63 * math.expm1(-0.53 / cosine))
        if self.cloud_cover == 0:
            return clear
        cloudy = _aureole(self.sun_zenith_rad, self.sun_azimuth_rad).radiance(
            sky_zenith_rad, sky_azimuth_rad, wavelength_nm
        )
        rest = 0.12 * self.sun_zenith_rad - 0.55 + 0.43 * np.cos(floats("sky_zenith_rad", sky_zenith_rad))
        return np.where(cloudy == 0, 0.0, self.cloud_cover * (cloudy + rest) + (1.0 - self.cloud_cover) * clear)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches."""
        if self.cloud_cover == 0:
            return tuple(dataclasses.replace(one, name="harrison-coombes") for one in self._law().lower(wavelength_nm))
        (one,) = FunctionSky(self.radiance, name="harrison-coombes").lower(550.0)  # for all wavelengths
        strength = np.full(np.size(wavelength_nm), one.strength[0])
        parts = polarised(self, (dataclasses.replace(one, strength=strength),), 550.0)
        return with_share(self, parts)


@functools.lru_cache(maxsize=2)  # a law integrates the sky when it is made, and radiances are asked for 200 times
def _clear(sun_zenith_rad: float, sun_azimuth_rad: float) -> PerezSky:
    """N_clear without its factor, as a law of Perez."""
    e = 2.04 * (math.cos(sun_zenith_rad) if math.isfinite(sun_zenith_rad) else 0.0) / 1.63
    coefficients = (-1.0, -0.19, 53.7 / 1.63, -5.49, e)
    return PerezSky(sun_zenith_rad=sun_zenith_rad, sun_azimuth_rad=sun_azimuth_rad, coefficients=coefficients)


@functools.lru_cache(maxsize=2)
def _aureole(sun_zenith_rad: float, sun_azimuth_rad: float) -> PerezSky:
    """1 + 0.72 exp(-1.88 p) of N_cloud, as a law of Perez."""
    return dataclasses.replace(_clear(sun_zenith_rad, sun_azimuth_rad), coefficients=(0.0, 0.0, 0.72, -1.88, 0.0))
