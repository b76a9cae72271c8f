"""A photon source as domes: radiance, or photons per steradian, of every waveband; and the marks on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from aomc_sky.component import Component
from aomc_sky.emission.radiance import folded, patch_radiance, point_cells
from aomc_sky.errors import UsageError, require_one_of
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.picture import PHOTONS, RADIANCE, RELATIVE_RADIANCE, STOKES, Dome, Mark, Picture, Symbol, spread
from aomc_sky.plan.laws import beam_deg, law_of
from aomc_sky.whole_number import as_index

if TYPE_CHECKING:
    from aomc_sky.emission.photon_source import PhotonSource


ShowWord = Literal["radiance", "counts", "dop", "aop"]
SHOWN = get_args(ShowWord)
"""What the colours can show of a source."""

LOBE_BINS = (90, 360)
"""Equal bins of zenith and azimuth in which lobes, which have no patches, are drawn by their exact means."""


def source_picture(
    source: PhotonSource,
    *,
    show: ShowWord = "radiance",
    bands: Sequence[int] | None = None,
    sun: Mark | None = None,
    title: str = "",
) -> Picture:
    """Domes of the wavebands of a source, all or 12 spread over them.

    Radiance of each patch is its irradiance over its projected solid angle: absolute where the source knows it, else as
    a share of the irradiance of the surface. Or photons of each patch over its solid angle, or degree ("dop") or angle
    ("aop") of its polarisation. The sun is by default that
    of the beam or of the Perez sky. Lobes are drawn in `LOBE_BINS`.
    """
    require_one_of(SHOWN, show, "show")
    components, is_stokes = source.components, show in STOKES
    if is_stokes and not source.has_polarisation:
        raise UsageError(f"the light has no polarisation, so it has no {show}", "give a sky polarisation=, or Q and U")
    grids = [c.grid for c in components if c.grid is not None]
    grid = common_grid([*grids, PatchGrid.regular(*LOBE_BINS)] if _has_lobes(components) else grids)
    marks = marks_of(components, grid, sun)
    chosen = spread(range(source.n_bands)) if bands is None else [as_index(band, "band") for band in bands]
    is_absolute = source.irradiance() is not None
    quantity = PHOTONS if show == "counts" else RADIANCE if is_absolute else RELATIVE_RADIANCE
    quantity = STOKES.get(show, quantity)
    domes = []
    for band in chosen:
        light = _counts(source, band) if show == "counts" else source.cell_irradiances(band)
        values = np.zeros(grid.n_patches)
        for component, part in zip(components, light, strict=True):
            values += _density(component, part, grid, per_flux=show != "counts")
        if is_stokes:
            values = _polarisation(source, band, light, grid, values, show)
        domes.append(Dome(grid=grid, values=values, title=_dome_title(source, band, light, show), marks=marks))
    return Picture(domes=tuple(domes), quantity=quantity, title=title, notes=_notes(components, show))


_LEAST_DEGREE = 1e-6  # less is rounding, and has no angle


def _polarisation(
    source: PhotonSource, band: int, light: list[np.ndarray], grid: PatchGrid, total: np.ndarray, show: str
) -> np.ndarray:
    """Degree, or angle from the vertical plane [deg], of the light of all components in each patch; NaN without any."""
    q, u = np.zeros((2, grid.n_patches))
    for component, part in zip(source.components_of(band), light, strict=True):
        if component.stokes is not None:
            own_q, own_u = component.stokes[0].T * part
            q += _density(component, own_q, grid, per_flux=True)
            u += _density(component, own_u, grid, per_flux=True)
    degree = np.divide(np.hypot(q, u), total, out=np.full(total.size, np.nan), where=total > 0)
    if show == "dop":
        return degree
    return np.where(degree > _LEAST_DEGREE, np.rad2deg(np.arctan2(u, q)) / 2.0, np.nan)


def _has_lobes(components: Sequence[Component]) -> bool:
    return any(law_of(c.law).covers_sky for c in components)


def _counts(source: PhotonSource, band: int) -> list[np.ndarray]:
    """Photons of the cells of each component."""
    return np.split(source.counts[band].astype(np.float64), source.plan.component_start[1:-1])


def _density(component: Component, light: np.ndarray, grid: PatchGrid, *, per_flux: bool) -> np.ndarray:
    """Light of a component per solid angle, or per projected solid angle, of each patch; beams have none."""
    shares = law_of(component.law).shares
    if shares is not None:
        area = grid.projected_solid_angle_sr if per_flux else grid.solid_angle_sr
        return float(light.sum()) * shares(component, grid) / area
    if component.grid is None:
        return np.zeros(grid.n_patches)
    if per_flux:
        drawn, values = patch_radiance(component.law, component.grid, light)
        return on_grid(drawn, values, grid)
    drawn, light = folded(component.grid, light)
    return on_grid(drawn, light / drawn.solid_angle_sr, grid)


def _dome_title(source: PhotonSource, band: int, light: list[np.ndarray], show: str) -> str:
    """Wavelength, and what the beam takes."""
    wavelength = source.plan.bands[band].wavelength_nm
    title = f"waveband {band + 1}, {wavelength:g} nm" if source.n_bands > 1 else f"{wavelength:g} nm"
    beam = sum(float(x.sum()) for c, x in zip(source.components, light, strict=True) if law_of(c.law).is_beam)
    total = sum(float(part.sum()) for part in light)
    if not any(law_of(c.law).is_beam for c in source.components):
        return f"{title}\n{spaced(total)} photons" if show == "counts" else title
    if show == "counts":
        return f"{title}\n{spaced(total)} photons, {spaced(beam)} in the beam"
    return f"{title}\nbeam {100 * beam / total:.3g} % of the light" if total > 0 else f"{title}\nno light"


def spaced(number: float) -> str:
    """A whole number in groups of three digits."""
    return f"{int(number):,}".replace(",", " ")


def _notes(components: Sequence[Component], show: str) -> tuple[str, ...]:
    notes = []
    if _has_lobes(components):
        notes.append(lobe_note(LOBE_BINS))
    grids = [c.grid for c in components if c.grid is not None]
    if any(not np.any(g.solid_angle_sr > 0) for g in grids):
        notes.append(
            "The photons come from whole degrees (--compat aomc); each point is drawn as the degree around it."
        )
    if show == "counts" and grids:
        notes.append("Photons of a patch over its solid angle.")
    if show == "aop":
        notes.append("Angle of the electric vector from the vertical plane, anticlockwise as one looks up at it.")
    if show == "dop":
        notes.append("Degree of the light of each patch; beams are not in it.")
    if any((beam_deg(c) or (0.0,))[-1] > 0.0 for c in components):
        notes.append("The disc of the sun is half a degree wide; its mark is not to scale.")
    return tuple(notes)


_SAME_DEG = 1e-9


def common_grid(grids: Sequence[PatchGrid]) -> PatchGrid:
    """Patches on which each of some grids is constant: a single grid without gaps as it is, else all edges of all."""
    drawn = [grid if np.any(grid.solid_angle_sr > 0) else point_cells(grid) for grid in grids]
    if not drawn:
        return PatchGrid.regular(1, 1)
    if len(drawn) == 1 and _is_gapless(drawn[0]):
        return drawn[0]
    zenith = _edges([grid.zenith_bounds_deg for grid in drawn], 90.0)
    azimuth = _edges([np.mod(grid.azimuth_bounds_deg, 360.0) for grid in drawn], 360.0)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def _is_gapless(grid: PatchGrid) -> bool:
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


def marks_of(components: Iterable[Component], grid: PatchGrid, sun: Mark | None = None) -> tuple[Mark, ...]:
    """Marks of beams, of lobes with half of their light within a ring of `grid`, and of the sun if there is no beam.

    A given sun replaces that of a Perez sky.
    """
    marks = []
    for component in components:
        law, beam = law_of(component.law), beam_deg(component)
        if beam is not None:
            marks.append(Mark(zenith_deg=beam[0], azimuth_deg=beam[1], symbol=Symbol.BEAM))
        if law.sun_deg is not None and sun is None:
            sun = sun_mark(*law.sun_deg(component).tolist())
        if law.axis_deg is not None:
            zenith, azimuth, width = law.axis_deg(component)
            if width < 90.0 / grid.n_zenith and zenith <= 90.0:
                marks.append(Mark(zenith_deg=zenith, azimuth_deg=azimuth, symbol=Symbol.LOBE))
    if sun is not None and not any(mark.symbol is Symbol.BEAM for mark in marks):
        marks.append(sun)
    return tuple(marks)


def sun_mark(zenith_deg: float, azimuth_deg: float) -> Mark:
    """The sun without light of its own, above the horizon or below it."""
    symbol = Symbol.SUN if zenith_deg <= 90.0 else Symbol.SUN_BELOW
    return Mark(zenith_deg=zenith_deg, azimuth_deg=azimuth_deg, symbol=symbol)


def lobe_note(bins: tuple[int, int]) -> str:
    """Note on lobes drawn on equal bins of zenith and azimuth."""
    size = f"{90.0 / bins[0]:g}° x {360.0 / bins[1]:g}°"
    return f"Lobes have no patches of their own: each is drawn by its mean in patches of {size}."
