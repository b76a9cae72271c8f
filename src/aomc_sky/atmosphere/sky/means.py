"""Means of a solved sky over patches: what the flux law of a patch wants, to a known error."""

from __future__ import annotations

import numpy as np

from aomc_sky.atmosphere.numerics.sky_field import SkyField
from aomc_sky.atmosphere.sky.solved import SolvedSky
from aomc_sky.grid import PatchGrid

FIRST_POINTS = 3
"""Gauss points of order 1 in each direction of a patch, before any patch is refined."""

MORE_POINTS = 16
"""Gauss points of the orders above, whose series are averaged term by term."""

_GROWTH = 5 / 3
_MOST_POINTS = 64
_MOST_VALUES = 2_000_000
"""Radiances evaluated at a time, so that no call takes more than some ten megabytes."""


def patch_means(
    sky: SolvedSky, grid: PatchGrid, sun_azimuth_rad: float, *, tolerance: float = 1e-5
) -> tuple[np.ndarray, float]:
    """Flux-weighted mean radiance of every patch, by order.

    Shape (n_wl, n_order, n_patch): integral of L cos over the patch / its projected solid angle [W m-2 sr-1 nm-1]; and
    the largest relative change of order 1 by the last refinement of any patch, which is above its error. `tolerance` is
    such a change by two thirds more points each way.

    Gauss points in mu^2 and azimuth. Order 1 has 3 x 3 and then 5 x 5 of them in all patches, and more where the mean
    still changes: around the sun under aerosols with a sharp forward peak, and along the horizon.
    """
    columns, mirror = _distinct_columns(grid, sun_azimuth_rad, is_mirrored=sky.is_mirrored)
    once, change = _refined_once(sky, grid, columns, tolerance)
    mean = np.zeros((once.shape[0], sky.n_listed, grid.n_zenith, len(columns)))
    mean[:, 0] = once.reshape(once.shape[0], grid.n_zenith, -1)
    if sky.more is not None:
        share, weight = _gauss(MORE_POINTS)
        azimuth = columns[:, :1] + (columns[:, 1:] - columns[:, :1]) * share
        mean[:, 1:] = np.maximum(sky.more.means(_zeniths(grid, share), azimuth, weight), 0.0)
    if sky.glow is not None:
        mean += glow_means(sky.glow, grid)[..., None]
    return mean[..., mirror].reshape(*mean.shape[:2], -1), change


def glow_means(glow: SkyField, grid: PatchGrid) -> np.ndarray:
    """Means of a sky that is the same all around over the rings of a grid, shape (n_wl, n_order, n_zenith)."""
    share, weight = _gauss(MORE_POINTS)
    anywhere = np.zeros((1, MORE_POINTS))
    return np.maximum(glow.means(_zeniths(grid, share), anywhere, weight)[..., 0], 0.0)


def _refined_once(sky: SolvedSky, grid: PatchGrid, columns: np.ndarray, tolerance: float) -> tuple[np.ndarray, float]:
    """Means of order 1, and their largest last change."""
    mean = _on_all(sky, grid, columns, FIRST_POINTS)
    n_points = _more(FIRST_POINTS)
    finer = _on_all(sky, grid, columns, n_points)
    change, mean = _relative_change(mean, finer), finer
    while n_points < _MOST_POINTS and np.any(change > tolerance):
        n_points = _more(n_points)
        unsettled = np.flatnonzero(change > tolerance)
        finer = _on_some(sky, grid, columns, unsettled, n_points)
        change[unsettled] = _relative_change(mean[:, unsettled], finer)
        mean[:, unsettled] = finer
    return mean, float(change.max(initial=0.0))


def _more(n_points: int) -> int:
    return min(int(np.ceil(n_points * _GROWTH)), _MOST_POINTS)


def _relative_change(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Largest change of a patch over the wavelengths, shape (n_patch,)."""
    share = np.divide(np.abs(fine - coarse), fine, out=np.zeros_like(fine), where=fine > 0)
    return share.max(axis=0)


def _distinct_columns(grid: PatchGrid, sun_azimuth_rad: float, *, is_mirrored: bool) -> tuple[np.ndarray, np.ndarray]:
    """Columns that are no mirror image of another on the sun's vertical plane, and which of them each column is.

    Where the sky is not mirrored there, all of them.

    Where the sky is not mirrored there, all of them. Columns are (n, 2) azimuths from the sun [rad], the others indices
    (n_azimuth,) into them.
    """
    bounds = np.deg2rad(grid.azimuth_bounds_deg) - sun_azimuth_rad
    middle, width = bounds.mean(axis=1), bounds[:, 1] - bounds[:, 0]
    folded = np.mod(middle + np.pi, 2 * np.pi) - np.pi
    if is_mirrored:
        folded = np.abs(folded)
    alike = np.round(np.column_stack([folded, width]), 12)
    _, first, mirror = np.unique(alike, axis=0, return_index=True, return_inverse=True)
    columns = folded[first, None] + width[first, None] * np.array([-0.5, 0.5])
    return columns, mirror.ravel()


def _gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (nodes + 1) / 2, weights / 2


def _zeniths(grid: PatchGrid, share: np.ndarray) -> np.ndarray:
    """Zenith angles at shares of the growth of sin^2 in each ring, shape (n_zenith, n). [rad]"""
    near, growth, far = grid.ring_sin2()
    sin2 = near[:, None] + growth[:, None] * share
    cos2 = far[:, None] + growth[:, None] * (1 - share)
    return np.arctan2(np.sqrt(sin2), np.sqrt(cos2))


def _on_all(sky: SolvedSky, grid: PatchGrid, columns: np.ndarray, n: int) -> np.ndarray:
    """Means of order 1 over all patches by n x n points, some rings at a time, shape (n_wl, n_patch)."""
    share, weight = _gauss(n)
    zenith = _zeniths(grid, share)
    azimuth = (columns[:, :1] + (columns[:, 1:] - columns[:, :1]) * share).ravel()
    rings = max(_MOST_VALUES // (n * azimuth.size * sky.medium.wavelength_nm.size), 1)
    means = []
    for start in range(0, grid.n_zenith, rings):
        some = zenith[start : start + rings]
        radiance = sky.once_on_product(some.ravel(), azimuth)
        cells = radiance.reshape(-1, len(some), n, len(columns), n)
        means.append(np.einsum("wzicj,i,j->wzc", cells, weight, weight, optimize=True))
    return np.concatenate(means, axis=1).reshape(sky.medium.wavelength_nm.size, -1)


def _on_some(sky: SolvedSky, grid: PatchGrid, columns: np.ndarray, patches: np.ndarray, n: int) -> np.ndarray:
    """Means of order 1 over listed patches by n x n points, shape (n_wl, n_listed)."""
    share, weight = _gauss(n)
    at_once = max(_MOST_VALUES // (n * n * sky.medium.wavelength_nm.size), 1)
    zenith = _zeniths(grid, share)
    azimuth = columns[:, :1] + (columns[:, 1:] - columns[:, :1]) * share
    means = []
    for start in range(0, patches.size, at_once):
        ring, column = np.divmod(patches[start : start + at_once], len(columns))
        cells = sky.once_in_cells(zenith, azimuth, ring, column)
        means.append(np.einsum("wpij,i,j->wp", cells, weight, weight, optimize=True))
    return np.concatenate(means, axis=1)
