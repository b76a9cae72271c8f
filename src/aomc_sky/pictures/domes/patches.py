"""Patches that can be drawn: points as areas, and one grid for components that have different ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aomc_sky.grid import PatchGrid

_SAME_DEG = 1e-9


def folded(grid: PatchGrid, light: np.ndarray) -> tuple[PatchGrid, np.ndarray]:
    """Patches with an extent, and the light on them, zenith-major.

    Patches of zero extent are the whole degrees of the AOMC program: they become cells of one degree around the points,
    zenith 1 to 90 and azimuth 0 to 359. Points of azimuth 360 and more fall on those of a turn less.
    """
    if np.any(grid.solid_angle_sr > 0):
        return grid, light
    drawn = point_cells(grid)
    rings = grid.zenith_bounds_deg[:, 0].astype(np.int64) - 1
    columns = np.mod(grid.azimuth_bounds_deg[:, 0].astype(np.int64), 360)
    patch = (rings[:, None] * drawn.n_azimuth + columns[None, :]).ravel()
    return drawn, np.bincount(patch, weights=light, minlength=drawn.n_patches)


def point_cells(grid: PatchGrid) -> PatchGrid:
    """Cells of one degree around whole degrees as far down as a lattice goes; the ring of 90 ends at the horizon."""
    z = np.unique(grid.zenith_bounds_deg[:, 0])
    a = np.arange(360.0)
    zenith = np.column_stack([z - 0.5, np.minimum(z + 0.5, 90.0)])
    return PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=np.column_stack([a - 0.5, a + 0.5]))


def common_grid(grids: Sequence[PatchGrid], lobe_bins: tuple[int, int] | None) -> PatchGrid:
    """Patches on which each of several grids is constant: a single grid without gaps as it is, else all edges of all
    grids.

    `lobe_bins` are equal bins that are wanted besides.
    """
    wanted = [grid if np.any(grid.solid_angle_sr > 0) else point_cells(grid) for grid in grids]
    wanted += [] if lobe_bins is None else [PatchGrid.regular(*lobe_bins)]
    if not wanted:
        return PatchGrid.regular(1, 1)
    if len(wanted) == 1 and _is_whole(wanted[0]):
        return wanted[0]
    zenith = _edges([grid.zenith_bounds_deg for grid in wanted], 90.0)
    azimuth = _edges([np.mod(grid.azimuth_bounds_deg, 360.0) for grid in wanted], 360.0)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def _is_whole(grid: PatchGrid) -> bool:
    """Whether each ring and column begins where the one before it ends."""
    return all(np.array_equal(b[1:, 0], b[:-1, 1]) for b in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))


def _edges(bounds: list[np.ndarray], last: float) -> np.ndarray:
    """All edges from 0 to `last`, those that differ by rounding once."""
    edges = np.unique(np.concatenate([[0.0, last], *(b.ravel() for b in bounds)]))
    return edges[np.append(True, np.diff(edges) > _SAME_DEG)]


def on_grid(grid: PatchGrid, values: np.ndarray, finer: PatchGrid) -> np.ndarray:
    """Values of patches on a finer grid: each fine patch takes the value of the patch that holds it, or 0."""
    if finer is grid:
        return values
    zenith, azimuth = finer.zenith_bounds_deg.mean(axis=1), finer.azimuth_bounds_deg.mean(axis=1)
    patch = grid.patch_of(*np.broadcast_arrays(zenith[:, None], azimuth[None, :])).ravel()
    return np.where(patch >= 0, values[np.maximum(patch, 0)], 0.0)
