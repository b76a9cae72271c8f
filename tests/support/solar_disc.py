"""Direct irradiance by the whole disc of the sun: what the centre of the disc is compared with."""

from __future__ import annotations

import numpy as np

from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.medium import Medium

_N_RING = 48  # Gauss nodes of rings of equal zenith angle


def disc_irradiance(medium: Medium, sun_zenith_rad: float) -> np.ndarray:
    """Mean over the whole disc of cos(zenith) F0 exp(-slant depth), 0 below the horizon, shape (n_wl,), within 1e-7."""
    zenith, share = _rings(sun_zenith_rad, medium.sun_angular_radius_rad)
    return ground_beam(medium, zenith).irradiance @ share


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
