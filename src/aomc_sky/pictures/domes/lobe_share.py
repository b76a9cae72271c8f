"""Lobes in pictures: shares of patches, of narrow ones fast enough for a picture; where they are, and how wide."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from aomc_sky.component import Component
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.lobes.envelope import lobe_of
from aomc_sky.skies.lobes.lobe import pdf, quaternion_of
from aomc_sky.skies.lobes.patches import patch_mass, patch_shares

_NARROW_RINGS = 2.0


def lobe_share(component: Component, grid: PatchGrid) -> np.ndarray:
    """Share of the flux of a lobe that comes through each patch, sum 1, shape (n_patch,).

    Exact as `patch_shares` is; of a lobe narrower than two rings as `narrow_lobe_share` is.
    """
    kind, first, second, rotation = lobe_of(component)
    if _width_deg(kind, first, second) < _NARROW_RINGS * 90.0 / grid.n_zenith:
        return narrow_lobe_share(kind, first, second, rotation, grid)
    return patch_shares(component, grid)


def lobe_note(bins: tuple[int, int]) -> str:
    """What a picture says of lobes drawn on equal bins of zenith and azimuth."""
    size = f"{90.0 / bins[0]:g}° x {360.0 / bins[1]:g}°"
    return f"Lobes have no patches of their own: each is drawn by its mean in patches of {size}."


def axis_and_width_deg(component: Component) -> tuple[float, float, float]:
    """Zenith angle and azimuth of the axis, and how wide the lobe is about it. [deg]

    The width is twice the angle that holds half the lobe, of the narrower way where it has two.
    """
    kind, first, second, rotation = lobe_of(component)
    x, y, z = rotation[:, 2].tolist()
    place = math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(y, x)) % 360.0
    return *place, _width_deg(kind, first, second)


def _width_deg(kind: str, first: float, second: float) -> float:
    """Twice the angle about the axis that holds half of a lobe, of the narrower way where it has two. [deg]"""
    if kind == "hg":
        half = 2.0 * math.asin((1.0 - first) * math.sqrt(2.0 + first) / 2.0)
    else:
        half = math.atan(min(first, second) * (1.0 if kind == "ggx" else math.sqrt(math.log(2.0))))
    return 2.0 * math.degrees(half)


_NEAR_RINGS = 2.0
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def narrow_lobe_share(kind: str, param0: float, param1: float, rotation: np.ndarray, grid: PatchGrid) -> np.ndarray:
    """Share of the flux of a narrow lobe that comes through each patch of the whole hemisphere, sum 1.

    Patches within two rings of the axis are exact, as `aomc_sky.skies.lobes.patches.patch_mass` has them; of the
    others, where little of the lobe is, 3 x 3 points of Gauss's rule are good to 1e-2 of themselves. The mass before it
    is scaled to 1 was within 1e-6 of the whole for widths of 0.01 to 2 degrees. Cost: half a second, 6 s where the axis
    is the zenith; exact patches everywhere would take minutes. `rotation` leads from local to world.
    """
    bounds = grid.zenith_bounds_deg.tobytes(), grid.azimuth_bounds_deg.tobytes()
    return _cached_share(kind, param0, param1, rotation.tobytes(), *bounds)


@lru_cache(maxsize=16)
def _cached_share(
    kind: str, param0: float, param1: float, rotation: bytes, zenith: bytes, azimuth: bytes
) -> np.ndarray:
    """The same for values that can be compared, so that bands and frames share the work."""
    matrix = np.frombuffer(rotation).reshape(3, 3)
    rows, columns = (np.frombuffer(bounds).reshape(-1, 2) for bounds in (zenith, azimuth))
    grid = PatchGrid(zenith_bounds_deg=rows, azimuth_bounds_deg=columns)
    mass = _by_points(kind, param0, param1, matrix, grid)
    rings, sides, turns = _around_axis(matrix, grid)
    if rings.size:
        near = PatchGrid(
            zenith_bounds_deg=grid.zenith_bounds_deg[rings],
            azimuth_bounds_deg=grid.azimuth_bounds_deg[sides] + turns[:, None],
        )
        exact = patch_mass(kind, param0, param1, quaternion_of(matrix), near, weighting="projected")
        mass[np.ix_(rings, sides)] = exact.reshape(rings.size, sides.size)
    share: np.ndarray = mass.ravel() / mass.sum()
    share.flags.writeable = False
    return share


def _around_axis(rotation: np.ndarray, grid: PatchGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rings and columns near the axis, the columns in the order of azimuth, and turns that put them in one row."""
    x, y, z = rotation[:, 2].tolist()
    sine = math.hypot(x, y)
    zenith, azimuth = math.degrees(math.atan2(sine, z)), math.degrees(math.atan2(y, x))
    near = _NEAR_RINGS * 90.0 / grid.n_zenith
    low, high = grid.zenith_bounds_deg.T
    rings = np.flatnonzero((low < zenith + near) & (high > zenith - near))
    start, end = grid.azimuth_bounds_deg.T
    middle, half = (start + end) / 2, (end - start) / 2
    away = np.mod(middle - azimuth + 180.0, 360.0) - 180.0
    reach = min(near / sine, 180.0) if sine > 0 else 180.0
    columns = np.flatnonzero(np.abs(away) <= reach + half)
    columns = columns[np.argsort(away[columns], kind="stable")]
    turns = 360.0 * np.rint((away[columns] + azimuth - middle[columns]) / 360.0)
    return rings, columns, turns


def _by_points(kind: str, param0: float, param1: float, rotation: np.ndarray, grid: PatchGrid) -> np.ndarray:
    """Density times cosine over patches by 3 x 3 points of Gauss's rule, shape (n_zenith, n_azimuth)."""
    (z0, z1), (a0, a1) = np.deg2rad(grid.zenith_bounds_deg.T), np.deg2rad(grid.azimuth_bounds_deg.T)
    total = np.zeros((grid.n_zenith, grid.n_azimuth))
    for u, of_u in zip(_NODES, _WEIGHTS, strict=True):
        zenith = ((z0 + z1 + u * (z1 - z0)) / 2)[:, None]
        sine, cosine = np.sin(zenith), np.cos(zenith)
        for v, of_v in zip(_NODES, _WEIGHTS, strict=True):
            azimuth = ((a0 + a1 + v * (a1 - a0)) / 2)[None, :]
            world = np.stack(np.broadcast_arrays(sine * np.cos(azimuth), sine * np.sin(azimuth), cosine), axis=-1)
            total += of_u * of_v / 4 * sine * cosine * pdf(kind, param0, param1, world @ rotation)
    return total * (z1 - z0)[:, None] * (a1 - a0)[None, :]
