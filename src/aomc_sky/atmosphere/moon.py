"""The Moon before the sun, as seen from the observer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import SceneError

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

    def centre_m(self, earth_radius_m: float) -> tuple[float, float, float]:
        """Place of the centre, from the earth's, z through the observer and x towards the sun's azimuth. [m]"""
        across = self.distance_m * np.sin(self.zenith_rad)
        x, y = across * np.cos(self.azimuth_from_sun_rad), across * np.sin(self.azimuth_from_sun_rad)
        return float(x), float(y), float(earth_radius_m + self.distance_m * np.cos(self.zenith_rad))
