"""Orders 2 and up of the whole sky by backward paths, as series of the azimuth; and the light of a glowing ground."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable

import numpy as np

from aomc_sky.errors import ModelLimitWarning
from aomc_sky.skies.atmosphere.backward import PathsResult, path_tables, seed_of, solve_paths
from aomc_sky.skies.atmosphere.lights import Moon, is_mirrored
from aomc_sky.skies.atmosphere.medium import Medium, scatterers, unlit
from aomc_sky.skies.atmosphere.optical_depth import vertical_optical_depth
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import LaterOrders
from aomc_sky.skies.atmosphere.sky.solved import azimuth_nodes, to_azimuth_series

N_AZIMUTH = 12
N_PATHS = 4096
"""Azimuths over half a turn, and paths of each direction and wavelength."""

_FEW = 0.01  # of the directions are flagged by chance
_LARGE, _MORE = 0.05, 4  # a median error above which so many times as many paths are followed

GLOW_PATHS = 32768
"""Paths of each zenith angle and wavelength."""

_SEED = 1  # not that of the sun's paths


def path_orders(
    medium: Medium,
    sun_zenith_rad: float,
    sky_zenith_rad: np.ndarray,
    n_orders: int,
    *,
    n_listed: int,
    moon: Moon | None = None,
    n_paths: int | None = None,
    order_one: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    seed: int = 0,
) -> LaterOrders:
    """Follow paths in all zenith angles and `N_AZIMUTH` azimuths. Cost: 4 s a wavelength and core.

    Orders from `n_listed` on share the last row. The function `order_one` gives the sun's order 1 (n_wl, n) in
    directions. The default of `n_paths` is `N_PATHS`, or four times as many if the median error of these is above 5 %.
    """
    mirrored = is_mirrored(moon)
    n_azimuth = N_AZIMUTH if mirrored else 2 * N_AZIMUTH - 1
    azimuth = azimuth_nodes(n_azimuth, is_mirrored=mirrored)
    theta, phi = np.meshgrid(sky_zenith_rad, azimuth, indexing="ij")
    tables = path_tables(medium)

    def follow(number: int, order_one: np.ndarray | None) -> PathsResult:
        return solve_paths(
            medium, sun_zenith_rad=sun_zenith_rad, sky_zenith_rad=theta.ravel(), azimuth_from_sun_rad=phi.ravel(),
            n_paths=number, n_orders=n_orders, threads=os.cpu_count() or 1, tables=tables,
            visible=moon, order_one=order_one, seed=seed_of(0, seed),
        )  # fmt: skip

    paths = follow(n_paths or N_PATHS, None if order_one is None else order_one(theta.ravel(), phi.ravel()))
    scatters = vertical_optical_depth(medium)[:, scatterers(medium)].sum(axis=1) > 0.0
    is_lit = scatters & (medium.toa_irradiance > 0.0)
    if n_paths is None and _later_error(paths, is_lit) > _LARGE:
        paths = follow(_MORE * N_PATHS, paths.radiance_by_order[:, 0])
    error = _later_error(paths, is_lit)
    if error > 2.0 * _LARGE:
        share = float(f"{100 * error:.2g}")
        warnings.warn(
            f"the paths give orders 2 and up with an error of {share:g} % in a direction: few of them reach air that "
            "the sun lights",
            ModelLimitWarning,
            stacklevel=3,
        )
    if paths.under_sampled.mean() > _FEW:
        warn_of_under_sampling(paths.under_sampled, stacklevel=4)
    rows = paths.radiance_by_order[:, 1:]
    rows = np.concatenate([rows[:, : n_listed - 2], rows[:, n_listed - 2 :].sum(axis=1, keepdims=True)], axis=1)
    to_modes = to_azimuth_series(n_azimuth, is_mirrored=mirrored)
    on_nodes = rows.reshape(*rows.shape[:2], sky_zenith_rad.size, n_azimuth)
    return LaterOrders(
        modes=np.einsum("ma,wkza->wkmz", to_modes, on_nodes),
        truncation=_truncation(paths, n_orders),
        resolution_error=error,
        n_paths=paths.n_paths,
        node_error=paths.standard_error.reshape(-1, sky_zenith_rad.size, n_azimuth),
    )


def _later_error(paths: PathsResult, is_lit: np.ndarray) -> float:
    """Median of the standard error over orders 2 and up; 1 where they are lit and no path found any of their light."""
    later = paths.radiance_by_order[:, 1:].sum(axis=1)
    unseen = np.broadcast_to(np.where(is_lit, 1.0, 0.0)[:, None], later.shape).copy()
    return float(np.median(np.divide(paths.standard_error, later, out=unseen, where=later > 0)))


def _truncation(paths: PathsResult, n_orders: int) -> np.ndarray:
    by_order = paths.radiance_by_order.sum(axis=2)
    if n_orders > by_order.shape[1]:
        return np.zeros(by_order.shape[0])
    before, last, total = by_order[:, -2], by_order[:, -1], by_order.sum(axis=1)
    ratio = np.minimum(np.divide(last, before, out=np.zeros_like(last), where=before > 0), 0.99)
    left = last * ratio / (1.0 - ratio)
    return np.divide(left, total + left, out=np.zeros_like(last), where=total > 0)


def warn_of_under_sampling(flagged: np.ndarray, *, stacklevel: int) -> None:
    """Warn of directions whose errors are not to be trusted."""
    warnings.warn(
        f"in {flagged.sum()} of {flagged.size} directions and wavelengths hardly any path reaches the air that the sun "
        "lights; errors there may be larger than stated",
        ModelLimitWarning,
        stacklevel=stacklevel,
    )


def glow_orders(
    medium: Medium,
    ground_radiance: np.ndarray,
    sky_zenith_rad: np.ndarray,
    n_orders: int,
    *,
    n_listed: int,
    n_paths: int | None = None,
    seed: int = 0,
) -> tuple[np.ndarray, float]:
    """Follow paths in some zenith angles, over a ground of radiance (n_wl,) that is the same everywhere; no sun.

    Returns the radiance (n_wl, n_row, n_zenith) by number of interactions, 1 first, linear in that of the ground
    [W m-2 sr-1 nm-1], and its median standard error as a share. Orders from `n_listed` on share the last row. Cost: 3 s
    a wavelength and core.
    """
    paths = solve_paths(
        unlit(medium), sun_zenith_rad=0.0, sky_zenith_rad=sky_zenith_rad,
        azimuth_from_sun_rad=np.zeros_like(sky_zenith_rad), n_paths=n_paths or GLOW_PATHS, n_orders=n_orders,
        seed=seed_of(_SEED, seed), ground_radiance=ground_radiance, threads=os.cpu_count() or 1,
    )  # fmt: skip
    rows, total = paths.radiance_by_order, paths.radiance
    rows = np.concatenate([rows[:, : n_listed - 1], rows[:, n_listed - 1 :].sum(axis=1, keepdims=True)], axis=1)
    share = paths.standard_error[total > 0] / total[total > 0]
    return rows, float(np.median(share)) if share.size else 0.0
