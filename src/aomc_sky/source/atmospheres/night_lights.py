"""The Moon before the sun and the glow of the ground, as a scene asks for them of a description."""

from __future__ import annotations

import math
from numbers import Real
from typing import TypedDict

import numpy as np

from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.medium import Medium
from aomc_sky.errors import SceneError
from aomc_sky.formats.sky_toml.keys import MoonDirection
from aomc_sky.source.atmospheres.medium import MediumReport


class SkyLights(TypedDict):
    """The arguments of `AtmosphereSky` for an eclipse and a glowing ground."""

    moon: Moon | None
    ground_radiance: np.ndarray | None


def lights_of(
    direction: MoonDirection,
    luminance_cd_m2: float,
    medium: Medium,
    report: MediumReport,
    sun_zenith_deg: float,
    path: str,
    *,
    sun_azimuth_deg: float = 0.0,
) -> SkyLights:
    """Both lights of one sun; arguments and errors as `moon_of_direction` and `glow_of_luminance` have them."""
    return {
        "moon": moon_of_direction(direction, medium, report, sun_zenith_deg, sun_azimuth_deg),
        "ground_radiance": glow_of_luminance(luminance_cd_m2, report, path),
    }


def moon_of_direction(
    direction: MoonDirection | None, medium: Medium, report: MediumReport, sun_zenith_deg: float, sun_azimuth_deg: float
) -> Moon | None:
    """The Moon in a direction of the sky; none where it is empty. Direction of the sun in degrees.

    SceneError: nobody says where or how far away the Moon is, or it would stand inside the earth.
    """
    if direction is None or direction.is_empty:
        return None
    if not direction.has_angle:
        raise SceneError("moon_distance_km without a place of the Moon; give moon_zenith_offset_deg, such as 0")
    zenith, azimuth = (math.radians(angle) for angle in direction.angles(sun_zenith_deg, sun_azimuth_deg))
    if direction.distance_km is not None:
        distance = 1000.0 * direction.distance_km
    elif report.moon_distance_m is not None:
        distance = _from_observer(report.moon_distance_m, medium.earth_radius_m, zenith)
    else:
        raise SceneError("how far away is the Moon? write moon_distance_km, or Earth-Moon distance in the description")
    return Moon(zenith_rad=zenith, azimuth_from_sun_rad=azimuth, distance_m=distance)


def _from_observer(centres_m: float, earth_radius_m: float, zenith_rad: float) -> float:
    """Distance from the ground where the centres have a known one, by the law of cosines. [m]"""
    across = earth_radius_m * math.sin(zenith_rad)
    if not abs(across) < centres_m or not earth_radius_m < centres_m:
        raise SceneError(f"a Moon {centres_m / 1000:g} km from the earth's centre stands inside the earth")
    return math.sqrt((centres_m - across) * (centres_m + across)) - earth_radius_m * math.cos(zenith_rad)


def glow_of_luminance(luminance_cd_m2: float, report: MediumReport, path: str) -> np.ndarray | None:
    """Radiance of a ground of some luminance, None where that is 0; `path` is for messages. [W m-2 sr-1 nm-1]"""
    if not isinstance(luminance_cd_m2, Real) or not 0.0 <= luminance_cd_m2 < math.inf:
        raise SceneError(f"the luminance of the ground must be 0 cd/m2 or more, got {luminance_cd_m2!r}")
    if luminance_cd_m2 == 0.0:
        return None
    if report.ground_glow is None:
        raise SceneError(f"{path} has no 'light pollution relative radiance', the colour of the ground's light")
    return np.asarray(luminance_cd_m2 * report.ground_glow)
