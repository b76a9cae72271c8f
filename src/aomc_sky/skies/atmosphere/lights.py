"""Light from outside: the Moon before the sun, and the sun's light that reaches the ground unscattered."""

from __future__ import annotations

from dataclasses import InitVar, dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.errors import SceneError, number
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.optical_depth import optical_depth_to_top

_ROUNDING = 1e-12  # of a sine

MOON_RADIUS_M = 1.7371e6
"""Mean radius of the Moon. [m]"""


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class Moon:
    """A dark sphere that hides part of the sun's disc, from every point of the air and of the ground.

    Parameters
    ----------
    zenith_rad, or zenith_deg : float
        Zenith angle of its centre, seen from the observer at sea level. [rad]
    azimuth_from_sun_rad, or azimuth_from_sun_deg : float
        Its azimuth; by default that of the sun, 0. [rad]
    distance_m : float
        Between the observer and its centre. [m, > the radius]
    radius_m : float
        [m, > 0]

    Examples
    --------
    >>> moon = sky.atmosphere.Moon(zenith_deg=30.2, distance_m=3.7e8)
    >>> print(f"{np.degrees(moon.radius_m / moon.distance_m):.3f}")  # its angular radius
    0.269
    """

    zenith_rad: float = None  # type: ignore[assignment]
    azimuth_from_sun_rad: float = None  # type: ignore[assignment]
    distance_m: float
    radius_m: float = MOON_RADIUS_M
    zenith_deg: InitVar[float | None] = None
    azimuth_from_sun_deg: InitVar[float | None] = None

    def __post_init__(self, zenith_deg: float | None, azimuth_from_sun_deg: float | None) -> None:
        settle_angles(self, zenith_rad=zenith_deg)
        settle_angles(self, default=0.0, azimuth_from_sun_rad=azimuth_from_sun_deg)
        sizes = (number("distance_m", self.distance_m), number("radius_m", self.radius_m))
        numbers = (self.zenith_rad, self.azimuth_from_sun_rad, *sizes)
        if not np.all(np.isfinite(numbers)) or not 0.0 < self.radius_m < self.distance_m:
            raise SceneError("a Moon needs finite angles, a radius above 0, and a distance larger than the radius")

    @property
    def breaks_symmetry(self) -> bool:
        """Whether the Moon is beside the sun's vertical plane: the two sides of the sky then differ."""
        across = np.sin(self.zenith_rad) * np.sin(self.azimuth_from_sun_rad)
        return bool(abs(across) > _ROUNDING)

    def reaches(self, sun_zenith_rad: float, sun_radius_rad: float, *, across_m: float) -> bool:
        """Whether it may hide part of the sun from any place within `across_m` of the observer."""
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


def is_mirrored(moon: Moon | None) -> bool:
    """Whether the sky right of the sun is that left of it."""
    return moon is None or not moon.breaks_symmetry


def sun_and_moon(medium: Medium, sun_zenith_rad: float, moon: Moon | None) -> tuple[tuple[float, ...], ...]:
    """Direction of the sun, and centre and radius of the Moon with the sun's angular radius, as `shells.sun_share`."""
    sun = (float(np.sin(sun_zenith_rad)), 0.0, float(np.cos(sun_zenith_rad)))
    disc = float(medium.sun_angular_radius_rad)
    return sun, (0.0, 0.0, 0.0, 0.0, disc) if moon is None else (
        *moon.centre_m(medium.earth_radius_m),
        moon.radius_m,
        disc,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class GroundBeam:
    """The direct beam at the ground, a component of its own beside the radiance of the sky."""

    optical_depth: np.ndarray  #: (n_wl,) slant depth towards the sun's centre; infinite below the horizon
    #: (n_wl,) on the horizontal ground, cos(sun zenith) F0 exp(-optical_depth), 0 from 90 degrees on. [W m-2 nm-1]
    irradiance: np.ndarray


def ground_beam(medium: Medium, sun_zenith_rad: ArrayLike) -> GroundBeam:
    """The direct beam at the ground, with all of the sun's light from its centre; zenith angles add their axes.

    The page of the model has its difference from the mean over the sun's disc: 2e-4 at 80 degrees, 2 % at 88.
    """
    zenith = np.asarray(sun_zenith_rad, dtype=np.float64)
    depth = optical_depth_to_top(medium, 0.0, zenith)
    cosine = np.where(zenith < np.pi / 2, np.cos(zenith), 0.0)
    above = medium.toa_irradiance.reshape(-1, *(1,) * zenith.ndim)
    return GroundBeam(optical_depth=depth, irradiance=above * cosine * np.exp(-depth))
