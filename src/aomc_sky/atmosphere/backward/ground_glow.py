"""Light of a ground that glows by itself, such as that of towns, scattered back to the observer: by backward paths."""

from __future__ import annotations

import dataclasses
import os
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.medium.constituents import Medium

N_PATHS = 32768
"""Paths of each zenith angle and wavelength."""

_SEED = 1  # not that of the sun's paths


@dataclass(frozen=True, kw_only=True, slots=True)
class GlowOrders:
    """Radiance of the sky over a ground that glows alike everywhere; no azimuth differs from another.

    Parameters
    ----------
    radiance : ndarray, float64, shape (n_wl, n_row, n_zenith)
        By number of interactions, 1 first; the last row holds the rest where more count. [W m-2 sr-1 nm-1]
    relative_error : float
        Standard error of a direction as a share of its radiance, the median over directions and wavelengths.
    """

    radiance: np.ndarray
    relative_error: float


def glow_orders(
    medium: Medium,
    ground_radiance: np.ndarray,
    sky_zenith_rad: np.ndarray,
    n_orders: int,
    *,
    n_listed: int,
    n_paths: int | None = None,
    seed: int = _SEED,
) -> GlowOrders:
    """Follow paths in some zenith angles.

    Parameters
    ----------
    medium : Medium
        The atmosphere; its sun does not count.
    ground_radiance : ndarray, float64, shape (n_wl,)
        What the ground gives off, the same everywhere and into all directions. [W m-2 sr-1 nm-1, >= 0]
    sky_zenith_rad : ndarray, float64, shape (n_zenith,)
        Zenith angles looked into. [rad, 0 to pi/2]
    n_orders : int
        Most interactions that count. [1 or more]
    n_listed : int
        Orders that are listed one by one. [1 to 24]
    n_paths : int or None
        As for `solve_paths`; None is `N_PATHS`.
    seed : int
        As for `solve_paths`.

    Returns
    -------
    GlowOrders
        Linear in `ground_radiance`: no path depends on it.

    Notes
    -----
    Accuracy: the standard error, 0.2 to 0.5 % of a direction. Cost: 3 s a wavelength and core for 64 zenith angles.
    """
    dark = dataclasses.replace(medium, toa_irradiance=np.zeros_like(medium.toa_irradiance))
    found = solve_paths(
        dark, sun_zenith_rad=0.0, sky_zenith_rad=sky_zenith_rad, azimuth_from_sun_rad=np.zeros_like(sky_zenith_rad),
        n_paths=n_paths or N_PATHS, n_orders=n_orders, seed=seed, ground_radiance=ground_radiance,
        threads=os.cpu_count() or 1,
    )  # fmt: skip
    rows, whole = found.radiance_by_order, found.radiance
    rows = np.concatenate([rows[:, : n_listed - 1], rows[:, n_listed - 1 :].sum(axis=1, keepdims=True)], axis=1)
    share = found.standard_error[whole > 0] / whole[whole > 0]
    return GlowOrders(radiance=rows, relative_error=float(np.median(share)) if share.size else 0.0)
