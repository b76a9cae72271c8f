"""Optical depth along straight rays through a spherical atmosphere: to the top, to the ground, of the sun's beam.

A ray is an altitude and the zenith angle of the direction it takes there. One that sinks is folded at the lowest
point it reaches: to the top it has twice the depth of the level ray from there, less that of its mirror image.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.medium.profile import Profile, density_profile
from aomc_sky.errors import UsageError

N_GAUSS = 10
"""Gauss nodes of a panel of the profile: 1e-11 of its polynomials."""


def lowest_altitude(radius_m: float, altitude_m: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Altitude of the point of a whole straight line that is nearest to the earth's centre.

    h - r mu^2 / (1 + sqrt(1 - mu^2)); negative where the line meets the ground. Points and cosines broadcast. [m]
    """
    return altitude_m - (radius_m + altitude_m) * mu * mu / (1.0 + np.sqrt((1.0 - mu) * (1.0 + mu)))


def meets_ground(radius_m: float, altitude_m: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Whether rays sink into the ground; one that only touches it does not."""
    return (mu < 0.0) & (lowest_altitude(radius_m, altitude_m, mu) < 0.0)


def columns(profile: Profile, low_m: ArrayLike, mu: ArrayLike, high_m: ArrayLike) -> np.ndarray:
    """Particles per area along rising rays between two altitudes.

    Shape (..., n_constituent) of altitudes 0 <= low <= high <= top and the cosine of the zenith angle at the start, 0
    to 1, which broadcast. [m-2]

    Accuracy: 1e-13 for the profile's polynomials, so `Profile.relative_error` decides. Cost: 0.1 us a panel.
    """
    from aomc_sky.kernels.atmosphere.columns import fill_columns

    low, cosine, high = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (low_m, mu, high_m)))
    out = np.empty((low.size, profile.coefficient.shape[1]))
    rays = [np.array(x).ravel() for x in (low, cosine, high)]  # copies: old numpy warns of broadcast arrays in kernels
    fill_columns(profile.earth_radius_m, profile.edge_m, profile.coefficient, *gauss_nodes(), *rays, out)
    return out.reshape(*low.shape, -1)


def columns_to_top(profile: Profile, altitude_m: ArrayLike, mu: ArrayLike) -> np.ndarray:
    """Particles per area from a point to the top, along a ray of any zenith angle.

    Shape (..., n_constituent). Of no meaning where the ground is in the way: see `meets_ground`. [m-2]
    """
    altitude, cosine = np.broadcast_arrays(np.asarray(altitude_m, dtype=np.float64), np.asarray(mu, dtype=np.float64))
    rising = columns(profile, altitude, np.abs(cosine), profile.top_m)
    sinks = cosine < 0.0
    if not sinks.any():
        return rising
    lowest = lowest_altitude(profile.earth_radius_m, altitude[sinks], cosine[sinks])
    level = columns(profile, np.maximum(lowest, 0.0), 0.0, profile.top_m)
    rising[sinks] = 2.0 * level - rising[sinks]
    return rising


def optical_depth_to_top(medium: Medium, altitude_m: ArrayLike, zenith_rad: ArrayLike) -> np.ndarray:
    """Optical depth between a point and the top of the atmosphere along a straight ray.

    Shape (n_wl, ...) of altitudes and zenith angles, which broadcast. Infinite where the ray meets the ground; one that
    only touches it passes. A UsageError for what is out of range.

    Accuracy: 1e-10 relative, where the densities are smooth between declared kinks and the angle is given to as many
    digits. Cost: 10 ms for the polynomials, then 2 to 5 us a ray.
    """
    altitude, zenith = _checked(medium, altitude_m, zenith_rad)
    profile = density_profile(medium)
    cosine = np.cos(zenith)
    blocked = meets_ground(medium.earth_radius_m, altitude, cosine)
    return _depths(profile, columns_to_top(profile, altitude, cosine), blocked)


def beam_optical_depth(medium: Medium, altitude_m: ArrayLike, sun_zenith_rad: float) -> np.ndarray:
    """Slant optical depth of the sun's beam above points on one vertical: what a pseudo-spherical solver attenuates by.

    Shape (n_wl, n_altitude); infinite in the earth's shadow, where `numpy.exp(-depth)` is 0.

    Accuracy and cost as of `optical_depth_to_top`.
    """
    return optical_depth_to_top(medium, altitude_m, sun_zenith_rad)


def vertical_optical_depth(medium: Medium) -> np.ndarray:
    """Optical depth of the whole atmosphere along the vertical, by constituent: (n_wl, n_constituent)."""
    profile = density_profile(medium)
    return profile.extinction_m2 * columns(profile, 0.0, 1.0, profile.top_m)


def _depths(profile: Profile, column: np.ndarray, blocked: np.ndarray) -> np.ndarray:
    """Optical depths (n_wl, ...) of columns (..., n_constituent), infinite where blocked."""
    return np.where(blocked, np.inf, np.moveaxis(column @ profile.extinction_m2.T, -1, 0))


@functools.cache
def gauss_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [-1, 1] of a panel of the profile."""
    node, weight = np.polynomial.legendre.leggauss(N_GAUSS)
    return node, weight


def _checked(medium: Medium, altitude_m: ArrayLike, zenith_rad: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    altitude, zenith = np.broadcast_arrays(
        np.asarray(altitude_m, dtype=np.float64), np.asarray(zenith_rad, dtype=np.float64)
    )
    if not np.all((altitude >= 0.0) & (altitude <= medium.top_m)):
        raise UsageError(f"an altitude must lie within 0 and the top of the atmosphere, {medium.top_m:g} m")
    if not np.all((zenith >= 0.0) & (zenith <= np.pi)):
        raise UsageError("a zenith angle must lie within 0 and pi radians")
    return altitude, zenith
