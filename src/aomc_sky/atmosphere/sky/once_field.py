"""Light scattered once over the whole sky, as a field: how it is fitted, and how well."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aomc_sky.atmosphere.lights.moon import Moon
from aomc_sky.atmosphere.medium.constituents import Medium
from aomc_sky.atmosphere.numerics.sky_field import SkyField, fit_field
from aomc_sky.atmosphere.order_one.eclipse import eclipsed_once
from aomc_sky.atmosphere.order_one.exact import ExactOnce
from aomc_sky.atmosphere.order_one.radiance import (
    once_tables,
    scattered_once,
    scatterers,
    scattering_cosine,
    with_phases,
)
from aomc_sky.atmosphere.sky.lights import Lights
from aomc_sky.atmosphere.sky.method import LOWEST_SUN_DEG

ONCE_NODES = (48, 7)
ONCE_NODES_LOW_SUN = (96, 13)
"""Nodes of zenith angle and azimuth for light scattered once; the second pair for a sun below 10 degrees."""

ONCE_NODES_ECLIPSE = (48, 13)
"""The same where the Moon hides part of the sun."""

_LOWEST_OF_SERIES_DEG = 90.0
"""Zenith angle of the sun beyond which the shadow of the earth cuts paths, and a series of order 1 fails."""


def once_field(medium: Medium, sun_zenith_rad: float, lights: Lights) -> SkyField | ExactOnce:
    """Light scattered once before the phase functions, over the whole sky: a series, or in twilight solved anew."""
    degrees = float(np.rad2deg(sun_zenith_rad))
    if lights.has_sun and lights.moon is None and degrees > _LOWEST_OF_SERIES_DEG:
        tables = once_tables(medium, sun_zenith_rad)
        return ExactOnce(medium=medium, sun_zenith_rad=sun_zenith_rad, tables=tables)
    n_zenith, n_azimuth = ONCE_NODES if degrees <= LOWEST_SUN_DEG else ONCE_NODES_LOW_SUN
    if not lights.has_sun:
        shape = (medium.wavelength_nm.size, len(scatterers(medium)), 1, 1)
        return SkyField(coefficient=np.zeros(shape))
    if lights.moon is None:
        return fit_field(_once_law(medium, sun_zenith_rad, None), n_zenith=n_zenith, n_azimuth=n_azimuth)
    is_mirrored = not lights.moon.breaks_symmetry
    n_zenith, n_azimuth = ONCE_NODES_ECLIPSE
    return fit_field(
        _once_law(medium, sun_zenith_rad, lights.moon),
        n_zenith=n_zenith,
        n_azimuth=n_azimuth if is_mirrored else 2 * n_azimuth - 1,
        is_mirrored=is_mirrored,
    )


def _once_law(
    medium: Medium, sun_zenith_rad: float, moon: Moon | None
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Order 1 before the phase functions, of directions."""
    if moon is None:
        return lambda zenith, azimuth: scattered_once(medium, sun_zenith_rad, zenith, azimuth)
    return lambda zenith, azimuth: eclipsed_once(medium, sun_zenith_rad, zenith, azimuth, moon)


def radiance_of_once(
    medium: Medium, sun_zenith_rad: float, once: SkyField | ExactOnce, zenith_rad: np.ndarray, azimuth_rad: np.ndarray
) -> np.ndarray:
    """Radiance of order 1 in directions (n,) by its field, shape (n_wl, n). [W m-2 sr-1 nm-1]"""
    cosine = scattering_cosine(sun_zenith_rad, zenith_rad, azimuth_rad)
    return with_phases(medium, once.at(zenith_rad, azimuth_rad), cosine)


def series_error(medium: Medium, sun_zenith_rad: float, once: SkyField | ExactOnce, moon: Moon | None = None) -> float:
    """Largest relative difference of order 1 from its solver in 64 directions that are no nodes.

    Of an eclipse: the largest difference as a share of the brightest of them, for in totality the later orders are
    the brighter ones.
    """
    if isinstance(once, ExactOnce):
        return 0.0
    k = np.arange(64)
    zenith = np.arccos(((k + 0.5) / 64) ** 1.5)
    azimuth = (np.pi if moon is None else 2.0 * np.pi) * np.mod(0.5 + k * 0.6180339887498949, 1.0)
    exact = _once_law(medium, sun_zenith_rad, moon)(zenith, azimuth).sum(axis=1)
    found = once.at(zenith, azimuth).sum(axis=1)
    brightest = exact.max(axis=1, keepdims=True, initial=0.0)
    scale = exact + 1e-6 * brightest if moon is None else np.broadcast_to(brightest, exact.shape)
    return float(
        np.max(np.divide(np.abs(found - exact), scale, out=np.zeros_like(exact), where=scale > 0), initial=0.0)
    )
