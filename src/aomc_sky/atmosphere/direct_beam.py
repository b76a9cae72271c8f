"""Light of the sun that reaches the ground unscattered: its irradiance, and the disc it comes from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.optical_depth import optical_depth_to_top
from aomc_sky.errors import UsageError

_N_RING = 48  # Gauss nodes of rings of equal zenith angle


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectBeam:
    """The direct beam at the ground, a component of its own beside the radiance of the sky.

    Parameters
    ----------
    sun_zenith_rad : float
        Zenith angle of the sun's centre. [rad]
    sun_angular_radius_rad : float
        Of the disc that photons of the beam come from, 0 for a point. [rad]
    optical_depth : ndarray, float64, shape (n_wl,)
        Slant depth towards the sun's centre; infinite below the horizon.
    irradiance : ndarray, float64, shape (n_wl,)
        On the horizontal ground, cos(sun zenith) F0 exp(-optical_depth), 0 from 90 degrees on. [W m-2 nm-1]
    """

    sun_zenith_rad: float
    sun_angular_radius_rad: float
    optical_depth: np.ndarray
    irradiance: np.ndarray


def direct_beam(medium: Medium, sun_zenith_rad: float) -> DirectBeam:
    """The direct beam at the ground, with all of the sun's light from its centre.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : float
        Zenith angle of the sun's centre. [rad, 0 to pi]

    Returns
    -------
    DirectBeam

    Raises
    ------
    UsageError
        The angle is outside its range.

    Notes
    -----
    Accuracy: 1e-10 of the formula. The mean over a disc of 0.27 degrees, `disc_irradiance`, differs from it by 7e-6
    below 60 degrees, 2e-4 at 80, 2e-3 at 85, 2 % at 88 and 6 % at 89 (450 nm, molecules and aerosol). From there on,
    where the lower edge of the disc reddens and sets, it is another quantity; it ends when the upper edge has set,
    and the irradiance of this beam at 90 degrees.
    """
    depth = optical_depth_to_top(medium, 0.0, sun_zenith_rad)
    return DirectBeam(
        sun_zenith_rad=float(sun_zenith_rad),
        sun_angular_radius_rad=medium.sun_angular_radius_rad,
        optical_depth=depth,
        irradiance=ground_direct_irradiance(medium, np.array([sun_zenith_rad]))[:, 0],
    )


def ground_direct_irradiance(medium: Medium, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Direct irradiance of the horizontal ground, all of the sun's light from its centre.

    Parameters
    ----------
    medium : Medium
        The atmosphere.
    sun_zenith_rad : array_like, shape (n,)
        Zenith angles of the sun's centre at places on the ground. [rad, 0 to pi]

    Returns
    -------
    ndarray, float64, shape (n_wl, n)
        cos(sun zenith) F0 exp(-slant depth), 0 from 90 degrees on. [W m-2 nm-1]

    Notes
    -----
    Accuracy: 1e-10, as the optical depth. Cost: 10 ms, then 3 us a place.
    """
    zenith = np.atleast_1d(np.asarray(sun_zenith_rad, dtype=np.float64))
    depth = optical_depth_to_top(medium, 0.0, zenith)
    cosine = np.where(zenith < np.pi / 2, np.cos(zenith), 0.0)
    return medium.toa_irradiance[:, None] * cosine * np.exp(-depth)


def disc_irradiance(medium: Medium, sun_zenith_rad: float) -> np.ndarray:
    """Direct irradiance of the horizontal ground by the part of the solar disc that is above the horizon.

    Parameters
    ----------
    medium : Medium
        The atmosphere; its `sun_angular_radius_rad` is that of a disc of uniform radiance. [0 to 10 degrees]
    sun_zenith_rad : float
        Zenith angle of the sun's centre. [rad, 0 to pi]

    Returns
    -------
    ndarray, float64, shape (n_wl,)
        Mean over the whole disc of cos(zenith) F0 exp(-slant depth), which is 0 below the horizon. [W m-2 nm-1]

    Raises
    ------
    UsageError
        The angle or the radius is outside its range.

    Notes
    -----
    Accuracy: 1e-7, by rings of equal zenith angle. Cost: 15 ms.
    """
    radius = medium.sun_angular_radius_rad
    if not 0.0 <= radius <= np.radians(10.0):
        raise UsageError(f"the radius of the solar disc must lie within 0 and 10 degrees, got {np.degrees(radius):g}")
    if radius == 0.0 or not 0.0 <= sun_zenith_rad <= np.pi:
        return ground_direct_irradiance(medium, sun_zenith_rad)[:, 0]
    zenith, share = _rings(sun_zenith_rad, radius)
    return ground_direct_irradiance(medium, zenith) @ share


def _rings(centre: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Zenith angles, and shares of the disc's solid angle, of what is above the horizon; its limits as roots of t."""
    node, weight = np.polynomial.legendre.leggauss(_N_RING)
    lowest, highest = abs(centre - radius), centre + radius
    middle, half = 0.5 * (highest + lowest), 0.5 * (highest - lowest)
    last = np.arccos(np.clip((middle - np.pi / 2) / half, -1.0, 1.0)) if half > 0.0 else 0.0
    t = 0.5 * last * (1.0 + node)
    zenith = middle - half * np.cos(t)
    sine = np.maximum(np.sin(zenith) * np.sin(centre), 1e-300)
    across = np.sin(0.5 * (radius + zenith - centre)) * np.sin(0.5 * (radius - zenith + centre))
    turn = 4.0 * np.arcsin(np.sqrt(np.clip(across / sine, 0.0, 1.0)))
    share = 0.5 * last * weight * half * np.sin(t) * turn * np.sin(zenith)
    inside = max(radius - centre, 0.0)  # rings around the zenith that lie in the disc as a whole
    inner = 0.5 * inside * (1.0 + node)
    whole = 0.5 * inside * weight * 2.0 * np.pi * np.sin(inner)
    solid_angle = 4.0 * np.pi * np.sin(0.5 * radius) ** 2
    return np.concatenate([zenith, inner]), np.concatenate([share, whole]) / solid_angle
