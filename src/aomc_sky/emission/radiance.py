"""Radiance of the diffuse light as the photons have it: of patches, and in any direction of the sky."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from aomc_sky.component import Component, Law, slope_factor
from aomc_sky.errors import SceneError, floats
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import law_of

Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Radiance by zenith angle and azimuth of the sky. [rad]"""


def band_radiance(components: Sequence[Component], row: int, irradiance: Sequence[float]) -> list[Radiance]:
    """Functions whose sum is the radiance of a band without beams and discs, for many calls.

    `irradiance` of each component on a horizontal plane sets the unit. The functions can be pickled.
    """
    parts: list[Radiance] = []
    for component, total in zip(components, irradiance, strict=True):
        law, mass = law_of(component.law), component.mass_of(row)
        if law.is_beam or not total > 0:
            continue
        if law.radiance is not None:
            parts.append(partial(law.radiance(component), float(total)))
        else:
            assert component.grid is not None
            grid, values = patch_radiance(component.law, component.grid, mass * (total / mass.sum()))
            slope = component.of_row(row).slope
            sloped = None if slope is None else (np.append(slope[0], np.zeros((1, 2)), axis=0), grid.ring_sin2())
            parts.append(partial(_patch_radiance, grid, np.append(values, 0.0), sloped))
    return parts


def sum_of(parts: Sequence[Radiance], sky_zenith_rad: np.ndarray, sky_azimuth_rad: np.ndarray) -> np.ndarray:
    """Radiance of `band_radiance` in directions above the horizon, their broadcast shape."""
    zenith, azimuth = floats("sky_zenith_rad", sky_zenith_rad), floats("sky_azimuth_rad", sky_azimuth_rad)
    if not ((zenith >= 0.0) & (zenith <= _HORIZON)).all() or not np.isfinite(azimuth).all():
        raise SceneError("a direction of the sky has a zenith angle of 0 to 90 degrees and a finite azimuth")
    if zenith.shape != azimuth.shape:
        zenith, azimuth = np.broadcast_arrays(zenith, azimuth)
    total = np.zeros(zenith.shape)
    for part in parts:
        total += part(zenith, azimuth)
    return total


_HORIZON = np.nextafter(np.pi / 2, 2.0)


def _patch_radiance(
    grid: PatchGrid,
    values: np.ndarray,
    sloped: tuple[np.ndarray, tuple[np.ndarray, ...]] | None,
    zenith: np.ndarray,
    azimuth: np.ndarray,
) -> np.ndarray:
    """Value of the patch; the last one is that of directions outside all patches.

    `sloped`: slopes of patches as in `Component`, and `grid.ring_sin2()`.
    """
    # radians of whole degrees come back as these, so that edges belong to the patch that starts there
    zenith_deg, azimuth_deg = np.round(np.rad2deg(zenith), 12), np.round(np.rad2deg(azimuth), 12)
    patch = grid.patch_of(zenith_deg, azimuth_deg)
    if sloped is None:
        return values[patch]
    slope, sin2 = sloped
    return values[patch] * slope_factor(slope[patch], grid, sin2, patch, zenith, azimuth_deg)


def patch_radiance(law: Law, grid: PatchGrid, light: np.ndarray) -> tuple[PatchGrid, np.ndarray]:
    """Patches with an extent, and the mean radiance of each for the irradiance `light` of the patches, (n_patch,)."""
    grid, light = folded(grid, light)
    projected = grid.projected_solid_angle_sr
    if law is not Law.CELL_MU:
        return grid, light / projected
    radiance = light / grid.solid_angle_sr  # photons follow it per solid angle; the irradiance stays what it is
    total = float(radiance @ projected)
    return grid, radiance * (float(light.sum()) / total if total > 0 else 0.0)


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
