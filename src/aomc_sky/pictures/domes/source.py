"""A photon source as domes: radiance, or photons per steradian, of every waveband."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.content import PHOTONS, RADIANCE, RELATIVE_RADIANCE, Dome, Picture
from aomc_sky.pictures.domes.lobe_share import lobe_note, lobe_share
from aomc_sky.pictures.domes.marks import BEAMS, marks_of
from aomc_sky.pictures.drawing.panels import MOST_PANELS
from aomc_sky.whole_number import as_index

if TYPE_CHECKING:
    from aomc_sky.source.photon_source import PhotonSource

SHOWN = ("radiance", "counts")
"""What the colours can show of a source."""


def source_picture(
    source: PhotonSource,
    *,
    show: str = "radiance",
    bands: Sequence[int] | None = None,
    sun_deg: tuple[float, float] | None = None,
    title: str = "",
    lobe_bins: tuple[int, int] = (90, 360),
) -> Picture:
    """Domes of the wavebands of a source, all or 12 spread over them.

    Radiance of each patch is its irradiance over its projected solid angle: absolute where the source knows it, else as
    a share of the irradiance of the surface. Or photons of each patch over its solid angle. The sun is by default that
    of the beam or of the Perez sky. Lobes, which have no patches, are shown by their exact means in `lobe_bins`.
    """
    if show not in SHOWN:
        raise UsageError(f"what is shown is one of {', '.join(SHOWN)}, not {show!r}")
    components = source.components
    grid = common_grid(
        [c.grid for c in components if c.grid is not None], lobe_bins if _has_lobes(components) else None
    )
    marks = marks_of(components, grid, sun_deg)
    chosen = spread(range(source.n_bands)) if bands is None else [as_index(band, "band") for band in bands]
    is_absolute = "irradiance_W_m2_nm" in source.plan.arrays
    quantity = PHOTONS if show == "counts" else RADIANCE if is_absolute else RELATIVE_RADIANCE
    domes = []
    for band in chosen:
        light = _counts(source, band) if show == "counts" else _irradiances(source, band)
        values = np.zeros(grid.n_patches)
        for component, part in zip(components, light, strict=True):
            values += _density(component, part, grid, per_flux=show == "radiance")
        domes.append(Dome(grid=grid, values=values, title=_dome_title(source, band, light, show), marks=marks))
    return Picture(
        domes=tuple(domes), quantity=quantity, title=title, notes=_notes(source, components, lobe_bins, show)
    )


def spread(bands: Sequence[int]) -> list[int]:
    """All of some bands, or 12 evenly spread over them, the first and the last among them."""
    if len(bands) <= MOST_PANELS:
        return list(bands)
    return [bands[round(k * (len(bands) - 1) / (MOST_PANELS - 1))] for k in range(MOST_PANELS)]


def _has_lobes(components: Sequence[Component]) -> bool:
    return any(c.law.is_lobe for c in components)


def _counts(source: PhotonSource, band: int) -> list[np.ndarray]:
    """Photons of the cells of each component."""
    return np.split(source.counts[band].astype(np.float64), source.plan.arrays["component_start"][1:-1])


def _irradiances(source: PhotonSource, band: int) -> list[np.ndarray]:
    """Irradiance of the cells of each component: W m-2 nm-1, or shares of all light where that is not known."""
    parts = np.split(source.mass(band), source.plan.arrays["component_start"][1:-1])
    absolute = source.irradiance(band)
    if absolute is None:
        return parts
    totals = [absolute[name] for name in source.plan.component_names]
    return [part * (total / part.sum()) if part.sum() > 0 else part for part, total in zip(parts, totals, strict=True)]


def _density(component: Component, light: np.ndarray, grid: PatchGrid, *, per_flux: bool) -> np.ndarray:
    """Light of a component per solid angle, or per projected solid angle, of each patch; beams have none."""
    if component.law.is_lobe:
        area = grid.projected_solid_angle_sr if per_flux else grid.solid_angle_sr
        return float(light.sum()) * lobe_share(component, grid) / area
    if component.grid is None:
        return np.zeros(grid.n_patches)
    drawn, light = folded(component.grid, light)
    if not per_flux:
        return on_grid(drawn, light / drawn.solid_angle_sr, grid)
    projected = drawn.projected_solid_angle_sr
    if component.law is Law.CELL_MU:  # photons follow the radiance per solid angle; the irradiance stays what it is
        radiance = light / drawn.solid_angle_sr
        total = float(radiance @ projected)
        return on_grid(drawn, radiance * (float(light.sum()) / total if total > 0 else 0.0), grid)
    return on_grid(drawn, light / projected, grid)


def _dome_title(source: PhotonSource, band: int, light: list[np.ndarray], show: str) -> str:
    """Wavelength, and what the beam takes."""
    wavelength = float(source.plan.arrays["wavelength_nm"][band])
    title = f"waveband {band + 1}, {wavelength:g} nm" if source.n_bands > 1 else f"{wavelength:g} nm"
    beam = sum(float(x.sum()) for c, x in zip(source.components, light, strict=True) if c.law in BEAMS)
    total = sum(float(part.sum()) for part in light)
    if not any(c.law in BEAMS for c in source.components):
        return f"{title}\n{spaced(total)} photons" if show == "counts" else title
    if show == "counts":
        return f"{title}\n{spaced(total)} photons, {spaced(beam)} in the beam"
    return f"{title}\nbeam {100 * beam / total:.3g} % of the light" if total > 0 else f"{title}\nno light"


def spaced(number: float) -> str:
    """A whole number in groups of three digits."""
    return f"{int(number):,}".replace(",", " ")


def _notes(
    source: PhotonSource, components: Sequence[Component], lobe_bins: tuple[int, int], show: str
) -> tuple[str, ...]:
    notes = []
    if _has_lobes(components):
        notes.append(lobe_note(lobe_bins))
    grids = [c.grid for c in components if c.grid is not None]
    if any(not np.any(g.solid_angle_sr > 0) for g in grids):
        notes.append(
            "The photons come from whole degrees (--compat aomc); each point is drawn as the degree around it."
        )
    if show == "counts" and grids:
        notes.append("Photons of a patch over its solid angle.")
    discs = {c.law for c in components} & {Law.DISC, Law.DISC_AT_HORIZON}
    if discs:
        notes.append("The disc of the sun is half a degree wide; its mark is not to scale.")
    return tuple(notes)


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
