"""Quadratures over the hemisphere and over a cone, each at two orders; their difference is the stated error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky

_ORDERS = (20, 28)
_ROUNDING = 1e-13
_WAVELENGTH_NM = 500.0


def _points(edges: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights of every panel between the edges, flat."""
    x, w = np.polynomial.legendre.leggauss(order)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (x + 1)).ravel(), (half * w).ravel()


def _graded(n: int) -> np.ndarray:
    """Edges from 0 to 1 that crowd towards 1, where a radiance over mu flattens out beyond all powers."""
    return np.append(1.0 - 0.4 ** np.arange(n), 1.0)


def _two_orders(work: Callable[[int], Any]) -> tuple[np.ndarray, float]:
    """Result of the higher order, and the largest relative difference from the lower one."""
    low, high = (np.asarray(work(order)) for order in _ORDERS)
    return high, float(np.max(np.abs(high - low) / np.abs(high)))


def hemisphere_of_model(model: PerezSky) -> tuple[tuple[float, float, float], float]:
    """Integrals of radiance times mu, mu^2 and 1 over the hemisphere, and the largest relative difference of two
    orders.

    In polar coordinates around the sun, which stands between zenith and horizon: the aureole is smooth in the distance
    from the sun, while any grid of zenith and azimuth sees its cusp. Circles that meet the horizon end there; square
    roots at the first and the last of them vanish in the variable t.
    """

    def integrals(order: int) -> np.ndarray:
        whole = np.pi / 2 - model.sun_zenith_rad
        gamma, weight = _points(np.array([0.0, 0.02, 0.06, 0.15, 0.4, 0.7, 0.85, 0.94, 0.98, 1.0]) * whole, order)
        inner = _circles(model, gamma, weight, np.full(gamma.size, np.pi), order)
        t, weight = _points(np.linspace(0.0, np.pi, 13), order)
        span = 2.0 * model.sun_zenith_rad
        gamma = whole + span * np.sin(t / 2) ** 2
        up = np.cos(model.sun_zenith_rad) * np.cos(gamma)
        across = np.sin(model.sun_zenith_rad) * np.sin(gamma)
        ends = np.arccos(np.clip(-up / across, -1.0, 1.0))
        return inner + _circles(model, gamma, weight * span * np.sin(t) / 2, ends, order)

    (flux, with_mu, without_mu), error = _two_orders(integrals)
    return (float(flux), float(with_mu), float(without_mu)), max(error, _ROUNDING)


def _circles(model: PerezSky, gamma: np.ndarray, weight: np.ndarray, ends: np.ndarray, order: int) -> np.ndarray:
    """Sum over circles around the sun, each from the meridian towards the zenith to its end, and mirrored."""
    s, ws = _points(_graded(14), order)
    psi = ends[:, None] * s
    zenith, azimuth, mu = _seen_from(model.sun_zenith_rad, model.sun_azimuth_rad, gamma[:, None], psi)
    value = model.radiance(zenith, azimuth, _WAVELENGTH_NM) * (2.0 * ends * weight * np.sin(gamma))[:, None] * ws
    return np.array([np.sum(value * mu), np.sum(value * mu * mu), np.sum(value)])


def _seen_from(
    axis_zenith: float, axis_azimuth: float, gamma: np.ndarray, psi: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zenith angle, azimuth and mu of points at a distance from an axis, psi from the side of the zenith."""
    sine, cosine = np.sin(axis_zenith), np.cos(axis_zenith)
    along, across = np.cos(gamma), np.sin(gamma)
    mu = np.clip(cosine * along + sine * across * np.cos(psi), 0.0, 1.0)
    forward = sine * along - cosine * across * np.cos(psi)
    sideways = np.broadcast_to(across * np.sin(psi), mu.shape)
    return np.arctan2(np.hypot(forward, sideways), mu), axis_azimuth + np.arctan2(sideways, forward), mu


def cone_of_model(model: PerezSky, axis: np.ndarray, half_angle: float) -> tuple[float, float]:
    """Integral of radiance times mu over a cone above the horizon that does not hold the sun, and its relative error.

    The axis is a sky direction, the half angle in radians; the error is the difference of two orders.
    """
    zenith, azimuth = float(np.arccos(axis[2])), float(np.arctan2(axis[1], axis[0]))

    def integral(order: int) -> np.ndarray:
        gamma, weight = _points(np.array([0.0, half_angle]), order)
        psi, around = _points(np.linspace(-np.pi, np.pi, 5), order)
        where = _seen_from(zenith, azimuth, gamma[:, None], psi)
        value = model.radiance(where[0], where[1], _WAVELENGTH_NM) * where[2]
        return np.array([np.sum(value * (weight * np.sin(gamma))[:, None] * around)])

    (value,), error = _two_orders(integral)
    return float(value), max(error, _ROUNDING)


def cone_of_table(grid: PatchGrid, share: np.ndarray, axis: np.ndarray, half_angle: float) -> tuple[float, float]:
    """Share of the photons in a cone, of a law that is uniform in mu^2 and azimuth inside each patch, and its relative
    error.

    The cone touches neither zenith nor horizon. At each azimuth it is an interval of mu, and the patches under it add
    up exactly. What is left is one integral, smooth between the azimuths at which the rim crosses an edge. With
    sin(azimuth from the axis) = sin(largest) sin(t) the rim's square roots are smooth in t.
    """
    z, a = float(np.arccos(axis[2])), float(np.arctan2(axis[1], axis[0]))
    largest = np.sin(half_angle) / np.sin(z)  # sine of the largest azimuth from the axis
    breaks = _azimuths_of_breaks(grid, z, a, half_angle)
    t = np.arcsin(np.clip(np.sin(breaks) / largest, -1.0, 1.0))
    edges = np.unique(np.concatenate([[-np.pi / 2, np.pi / 2], t]))

    def integral(order: int) -> np.ndarray:
        nodes, weight = _points(edges, order)
        delta = np.arcsin(largest * np.sin(nodes))
        slope = largest * np.cos(nodes) / np.cos(delta)
        return np.array([np.sum(weight * slope * _under(grid, share, z, a, half_angle, delta))])

    (value,), error = _two_orders(integral)
    return float(value), max(error, _ROUNDING)


def _azimuths_of_breaks(grid: PatchGrid, z: float, a: float, half_angle: float) -> np.ndarray:
    """Azimuths from the axis of all columns' edges, and of all points where the rim meets a ring's edge."""
    columns = np.deg2rad(grid.azimuth_bounds_deg.ravel()) - a
    columns = np.arctan2(np.sin(columns), np.cos(columns))
    mu = sin_cos_deg(grid.zenith_bounds_deg.ravel())[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (np.cos(half_angle) - mu * np.cos(z)) / (np.sqrt(1 - mu * mu) * np.sin(z))
    met = np.arccos(cosine[np.abs(cosine) <= 1])
    limit = np.arcsin(np.sin(half_angle) / np.sin(z))
    found = np.concatenate([columns, met, -met])
    return found[np.abs(found) < limit]


def _under(grid: PatchGrid, share: np.ndarray, z: float, a: float, half_angle: float, delta: np.ndarray) -> np.ndarray:
    """Density in azimuth of the share inside the cone, at azimuths from its axis, shape (n,)."""
    # mu cos z + sqrt(1 - mu^2) sin z cos(delta) = cos(half_angle), as cos(zenith - middle) = height / length
    middle = np.arctan2(np.sin(z) * np.cos(delta), np.cos(z))
    length = np.hypot(np.cos(z), np.sin(z) * np.cos(delta))
    reach = np.arccos(np.clip(np.cos(half_angle) / length, -1.0, 1.0))
    high, low = np.cos(middle - reach) ** 2, np.cos(middle + reach) ** 2
    near, far = (mu**2 for mu in grid.ring_mu())
    common = np.minimum.outer(high, near) - np.maximum.outer(low, far)
    part = np.clip(common, 0.0, None) / grid.ring_sin2()[1]
    column = grid.patch_of(np.full(delta.shape, grid.zenith_bounds_deg[0].mean()), np.rad2deg(a + delta))
    width = np.deg2rad(np.diff(grid.azimuth_bounds_deg, axis=1)).ravel()
    density = share / width
    return np.einsum("nr,rn->n", part, density[:, column])
