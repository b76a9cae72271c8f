"""Light scattered once under a sun that the Moon hides in part: quadrature along the way that is looked along."""

from __future__ import annotations

import numpy as np

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.moon import Moon
from aomc_sky.atmosphere.optical_depth import columns, columns_to_top, meets_ground
from aomc_sky.atmosphere.order_one import scatterers, scattering_cosine
from aomc_sky.atmosphere.profile import Profile, density_profile

_N_NODES = 8
_PANELS = 12  # of each panel of the profile: the shadow's edge is not known beforehand


def solve_eclipsed_order_one(
    medium: Medium, sun_zenith_rad: float, zenith: np.ndarray, azimuth: np.ndarray, moon: Moon
) -> np.ndarray:
    """Radiance of light scattered once in air that sees only part of the sun.

    Parameters
    ----------
    medium : Medium
        The atmosphere; its `sun_angular_radius_rad` is the disc's.
    sun_zenith_rad : float
        Zenith angle of the sun's centre. [rad, 0 to pi]
    zenith, azimuth : ndarray, float64, shape (n,)
        Directions looked into, azimuth from the sun's. [rad]
    moon : Moon
        What hides the sun.

    Returns
    -------
    ndarray, float64, shape (n_wl, n)
        [W m-2 sr-1 nm-1]

    Notes
    -----
    Accuracy: 1e-4 of the light that the same air would have without the Moon. Cost: 5 ms a direction.
    """
    radiance = np.zeros((medium.wavelength_nm.size, zenith.size))
    which = scatterers(medium)
    if not which:
        return radiance
    profile = density_profile(medium)
    altitude, weight = _nodes(profile)
    density = profile.density(altitude)
    cosine = scattering_cosine(sun_zenith_rad, zenith, azimuth)
    for k in range(zenith.size):
        light = _light(medium, profile, altitude, sun_zenith_rad, (zenith[k], azimuth[k]), moon) * weight
        for index in which:
            part = medium.constituents[index]
            assert part.phase_function is not None  # it scatters
            for row in range(radiance.shape[0]):
                column = float(light[row] @ density[:, index]) * part.scattering_m2[row]
                radiance[row, k] += column * float(part.phase_function(cosine[k : k + 1], row)[0])
    return radiance * medium.toa_irradiance[:, None]


def _nodes(profile: Profile) -> tuple[np.ndarray, np.ndarray]:
    """Altitudes and weights of an integral over altitude, as squares of Gauss nodes of its root."""
    node, weight = np.polynomial.legendre.leggauss(_N_NODES)
    edge = np.sqrt(profile.edge_m)
    share = np.arange(_PANELS) / _PANELS
    fine = np.append((edge[:-1, None] + np.diff(edge)[:, None] * share).ravel(), edge[-1])
    half = 0.5 * np.diff(fine)[:, None]
    root = (0.5 * (fine[1:] + fine[:-1])[:, None] + half * node).ravel()
    return root * root, (half * weight).ravel() * 2.0 * root


def _light(
    medium: Medium,
    profile: Profile,
    altitude: np.ndarray,
    sun_zenith_rad: float,
    direction: tuple[float, float],
    moon: Moon,
) -> np.ndarray:
    """Way per altitude times transmission from the sun and to the eye times visible share, (n_wl, n_node)."""
    from aomc_sky.kernels.backward_light import fill_sun_share

    radius, (zenith, azimuth) = medium.earth_radius_m, direction
    mu, sine = np.cos(zenith), np.sin(zenith)
    rise = altitude * (altitude + 2.0 * radius)
    start = radius * mu
    root = np.sqrt(start * start + rise)
    way, r = rise / (start + root), radius + altitude
    vertical = np.stack([way * sine * np.cos(azimuth), way * sine * np.sin(azimuth), radius + way * mu]) / r
    sun = (float(np.sin(sun_zenith_rad)), 0.0, float(np.cos(sun_zenith_rad)))
    at_sun = np.clip(sun[0] * vertical[0] + sun[2] * vertical[2], -1.0, 1.0)
    column = columns_to_top(profile, altitude, at_sun) + columns(profile, 0.0, mu, altitude)
    lit = np.where(meets_ground(radius, altitude, at_sun), 0.0, r / root)
    share = np.empty_like(altitude)
    shadow = (*moon.centre_m(radius), moon.radius_m, float(medium.sun_angular_radius_rad))
    fill_sun_share(r, vertical, sun, shadow, share)
    return np.exp(-profile.extinction_m2 @ column.T) * lit * share
