"""The Moon before the sun, as seen from the observer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import SceneError

_ROUNDING = 1e-12  # of a sine

RADIUS_M = 1.7371e6
"""Mean radius of the Moon. [m]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Moon:
    """A dark sphere that hides part of the sun's disc, from every point of the air and of the ground.

    Parameters
    ----------
    zenith_rad, azimuth_from_sun_rad : float
        Of its centre, seen from the observer at sea level. [rad]
    distance_m : float
        Between the observer and its centre. [m, > the radius]
    radius_m : float
        [m, > 0]
    """

    zenith_rad: float
    azimuth_from_sun_rad: float = 0.0
    distance_m: float
    radius_m: float = RADIUS_M

    def __post_init__(self) -> None:
        numbers = (self.zenith_rad, self.azimuth_from_sun_rad, self.distance_m, self.radius_m)
        if not np.all(np.isfinite(numbers)) or not 0.0 < self.radius_m < self.distance_m:
            raise SceneError("a Moon has finite angles, a positive radius, and stands farther away than that")

    @property
    def breaks_symmetry(self) -> bool:
        """Whether the sky right of the sun differs from that left of it: the Moon stands beside its vertical plane."""
        across = np.sin(self.zenith_rad) * np.sin(self.azimuth_from_sun_rad)
        return bool(abs(across) > _ROUNDING)

    def reaches(self, sun_zenith_rad: float, sun_radius_rad: float, *, across_m: float) -> bool:
        """Whether it may hide part of the sun from any place that is no farther from the observer than `across_m`.

        `across_m` is such as the diameter of the atmosphere.
        """
        if across_m + self.radius_m >= self.distance_m:
            return True
        cosine = np.cos(self.zenith_rad) * np.cos(sun_zenith_rad)
        cosine += np.sin(self.zenith_rad) * np.sin(sun_zenith_rad) * np.cos(self.azimuth_from_sun_rad)
        shift = np.arcsin(across_m / self.distance_m)
        own = np.arcsin(self.radius_m / (self.distance_m - across_m))
        return bool(np.arccos(np.clip(cosine, -1.0, 1.0)) <= shift + own + sun_radius_rad)

    def centre_m(self, earth_radius_m: float) -> tuple[float, float, float]:
        """Place of the centre, from the earth's, z through the observer and x towards the sun's azimuth. [m]"""
        across = self.distance_m * np.sin(self.zenith_rad)
        x, y = across * np.cos(self.azimuth_from_sun_rad), across * np.sin(self.azimuth_from_sun_rad)
        return float(x), float(y), float(earth_radius_m + self.distance_m * np.cos(self.zenith_rad))
