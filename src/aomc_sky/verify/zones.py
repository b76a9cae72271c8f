"""Zones of the sky in which photons are counted, and how the cells of a source spread over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.laws import beam_deg, law_of
from aomc_sky.plan.options import Placement

N_ZONES = 16
"""Zones in each coordinate; few zones have more power against a defect of large extent than many."""

MARGIN_DEG = 1e-4
"""Distance between edges and directions that many photons share: thirty times the rounding of single precision."""

_LEAST_EDGES = 7
"""Fewest edges of patches that are enough for zones."""

_FINE = 4096
"""Possible edges of zones where patches have too few."""

_SLIVER = 1e-9
"""Smaller parts of a ring or column come from rounding of edges."""


def at_centres(source: PhotonSource) -> bool:
    """Whether all photons of a patch come from its centre."""
    return bool(source.plan.options["placement"] == Placement.CENTRE.value)


def components_seen(source: PhotonSource, band: int) -> tuple[Component, ...]:
    """The components of a source; of this band alone if bands place photons differently in cells."""
    return source.components_of(band) if source.bands_differ_inside_cells else source.components


def points_deg(component: Component, *, is_centred: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells whose photons share one direction, the zenith angles and the azimuths of these directions. [deg]

    They are beams, patches without extent, and with `is_centred` every patch with light.
    """
    is_direction = law_of(component.law).is_beam and _disc_deg(component) is None
    cells = np.arange(component.n_cells if is_direction else 0)
    if component.grid is not None:
        is_point = (component.grid.solid_angle_sr == 0) | is_centred
        cells = np.flatnonzero(is_point & (component.mass.max(axis=0) > 0))
    near, growth, far, _, sine, cosine = component.cell[cells].T  # the middle in the coordinate of the law
    sin2, mu2 = near + growth / 2, far + growth / 2
    if component.law is Law.CELL_MU:
        sin2, mu2 = sin2 * (1 + mu2), mu2 * mu2
    return cells, np.rad2deg(np.arctan2(np.sqrt(sin2), np.sqrt(mu2))), np.rad2deg(np.arctan2(sine, cosine))


def fixed_directions(components: Sequence[Component], *, is_centred: bool) -> np.ndarray:
    """Rectangles around directions that many photons share, and around discs, with margins for rounding.

    Ends in zenith angle and azimuth, (n, 4); a disc around the zenith has a width of 360 in azimuth. [deg]
    """
    parts = [np.zeros((0, 4))]
    for component in components:
        _, zenith, azimuth = points_deg(component, is_centred=is_centred)
        parts.append(np.column_stack([zenith, zenith, azimuth, azimuth]))
        if (disc := _disc_deg(component)) is not None:
            parts.append(_around_disc(*disc))
    fixed = np.concatenate(parts)
    lowest = np.sin(np.deg2rad(np.maximum(fixed[:, 0], 0.01)))
    margin = np.column_stack([np.full(len(fixed), MARGIN_DEG), MARGIN_DEG + MARGIN_DEG / lowest])
    fixed[:, [0, 2]] -= margin
    fixed[:, [1, 3]] += margin
    return fixed


def _around_disc(zenith: float, azimuth: float, radius: float) -> np.ndarray:
    """Rectangle around a disc, (1, 4); all azimuths if the disc contains the zenith."""
    half = 180.0
    if radius < zenith:
        half = float(np.rad2deg(np.arcsin(np.sin(np.deg2rad(radius)) / np.sin(np.deg2rad(zenith)))))
    return np.array([[max(zenith - radius, 0.0), min(zenith + radius, 90.0), azimuth - half, azimuth + half]])


def _disc_deg(component: Component) -> tuple[float, float, float] | None:
    """Zenith angle, azimuth and radius of a disc; None for other components. [deg]"""
    beam, law = beam_deg(component), law_of(component.law).beam
    assert beam is not None or law is None or law(component.cell[0].tolist())[1] == 0.0, "a disc has one cell"
    return None if beam is None or beam[2] == 0.0 else beam


def choose_zones(source: PhotonSource) -> PatchGrid:
    """Up to 16 x 16 zones for the photons of a source, about equal in mu^2 and in azimuth.

    The edges are those of the first component with patches if it has at least 7 of them, so that zones are made of
    whole patches. Edges keep 1e-4 degrees away from beams, discs and other fixed directions. Azimuth is not cut if the
    sun's disc holds the zenith beside its centre.
    """
    fixed = fixed_directions(source.components, is_centred=at_centres(source))
    is_sector = fixed[:, 3] - fixed[:, 2] < 360.0
    zenith, azimuth = np.zeros(0), np.zeros(0)
    if source.grid is not None:
        rings, columns = source.grid.zenith_bounds_deg, source.grid.azimuth_bounds_deg
        zenith = (rings[:-1, 1] + rings[1:, 0]) / 2
        after = np.append(columns[1:, 0], columns[0, 0] + 360.0)
        azimuth = np.sort(np.mod((columns[:, 1] + after) / 2, 360.0))
    targets = np.rad2deg(np.arcsin(np.sqrt(np.arange(1.0, N_ZONES) / N_ZONES)))
    zenith = _edges(targets, zenith[(zenith > 0) & (zenith < 90)], fixed[:, :2], 90.0)
    zenith = np.concatenate([[0.0], zenith, [90.0]])
    azimuth = _edges(np.arange(N_ZONES) * 360.0 / N_ZONES, azimuth, fixed[is_sector, 2:], 360.0)
    discs = [disc for disc in map(_disc_deg, source.components) if disc is not None]
    is_lopsided = any(0.0 < zenith <= radius for zenith, _, radius in discs)
    azimuth = np.array([0.0, 360.0]) if is_lopsided or not azimuth.size else np.append(azimuth, azimuth[0] + 360.0)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def _edges(targets: np.ndarray, candidates: np.ndarray, taken: np.ndarray, end: float) -> np.ndarray:
    """For each target the nearest candidate outside the intervals `taken`; with few candidates, any number will do."""
    low = np.mod(taken[:, 0], 360.0)
    high = low + (taken[:, 1] - taken[:, 0])
    lows, highs = (np.sort(np.concatenate([x - 360.0, x])) for x in (low, high))
    for possible in (candidates, np.union1d(targets, np.arange(1, _FINE) * end / _FINE)):
        n_around = np.searchsorted(lows, possible, side="right") - np.searchsorted(highs, possible, side="left")
        free = possible[n_around == 0]
        if free.size >= _LEAST_EDGES:
            break
    return np.unique(free[np.abs(free[:, None] - targets).argmin(axis=0)]) if free.size else free


@dataclass(frozen=True, kw_only=True, slots=True)
class ZoneShares:
    """Parts of cells that lie in zones; the parts of one cell add up to 1."""

    cell: np.ndarray  #: in the order of the counts [shape (n,)]
    zone: np.ndarray  #: in the order of the patches of the zones [shape (n,)]
    share: np.ndarray  #: part of the photons of the cell [0 to 1, shape (n,)]
    n_zones: int

    def expected(self, per_cell: np.ndarray) -> np.ndarray:
        """Photons of zones if cells have these, float64 (n_zone,)."""
        return np.bincount(self.zone, per_cell[self.cell] * self.share, self.n_zones)

    def loose(self, per_cell: np.ndarray) -> np.ndarray:
        """Variance of the photons of each zone for fixed photons of cells, if positions in cells are independent.

        0 for zones of whole cells. [shape (n_zone,)]
        """
        return np.bincount(self.zone, per_cell[self.cell] * self.share * (1 - self.share), self.n_zones)

    def variance(self, per_cell: np.ndarray, per_zone: np.ndarray) -> float:
        """Variance of the sum over photons of a number of their zones, if positions in cells are independent."""
        mean = np.bincount(self.cell, self.share * per_zone[self.zone], per_cell.size)
        off = per_zone[self.zone] - mean[self.cell]
        return float(per_cell[self.cell] @ (self.share * off * off))


def zone_shares(source: PhotonSource, zones: PatchGrid, band: int = 0, *, is_flux: bool = False) -> ZoneShares:
    """Spread the cells of a source over zones; `band` counts if bands differ inside cells.

    With `is_flux`, for sums of weights, patches of law CELL_MU count as patches of law CELL_MU2, because their weights
    carry the cosine. Errors: 1e-12 for patches of constant radiance or with slopes, beams and discs, 1e-10 for a Perez
    sky, for lobes those of `aomc_sky.lobes.patch_mass`.
    """
    start, parts = 0, []
    for component in components_seen(source, band):
        disc = _disc_deg(component)
        if law_of(component.law).covers_sky or (disc is not None and disc[2] >= disc[0]):
            mass = (law_of(component.law).shares or _disc_around_zenith)(component, zones)
            zone = np.flatnonzero(mass > 0)
            parts.append((np.full(zone.size, start), zone, mass[zone] / mass[zone].sum()))
        else:
            cell, zenith, azimuth = points_deg(component, is_centred=at_centres(source))
            if disc is not None:  # edges keep clear of the disc, so any point will do
                cell, (zenith, azimuth) = np.zeros(1, np.int64), np.array([disc[:2]]).T
            parts.append((cell + start, zones.patch_of(np.minimum(zenith, 90.0), azimuth), np.ones(cell.size)))
            if component.grid is not None and not at_centres(source):
                parts.append(_parts_of_patches(component, component.grid, zones, start, is_flux=is_flux))
        start += component.n_cells
    cell, zone, share = (np.concatenate(column) for column in zip(*parts, strict=True))
    return ZoneShares(cell=cell, zone=zone, share=share, n_zones=zones.n_patches)


_Parts = tuple[np.ndarray, np.ndarray, np.ndarray]


def _parts_of_patches(component: Component, grid: PatchGrid, zones: PatchGrid, start: int, *, is_flux: bool) -> _Parts:
    """Patches with an extent, cut at the edges of zones."""
    ring, zone_ring, zenith = grid_cuts(grid.zenith_bounds_deg, zones.zenith_bounds_deg)
    column, zone_column, azimuth = grid_cuts(grid.azimuth_bounds_deg, zones.azimuth_bounds_deg)
    cell = (ring[:, None] * grid.n_azimuth + column).ravel()
    zone = (zone_ring[:, None] * zones.n_azimuth + zone_column).ravel()
    law = law_of(Law.CELL_MU2 if is_flux and component.law is Law.CELL_MU else component.law)
    if law.flux is None:
        mass = np.outer(np.diff(law.coordinate(zenith)), np.diff(azimuth)).ravel()
    else:
        is_cut = cell.size > grid.n_patches
        mass = law.flux(component, zenith, azimuth).ravel() if is_cut else np.ones(cell.size)
    total = np.bincount(cell, mass)[cell]
    return cell + start, zone, np.divide(mass, total, out=np.zeros_like(mass), where=total > 0)


def grid_cuts(bounds_deg: np.ndarray, zone_bounds_deg: np.ndarray) -> _Parts:
    """Cut rings or columns at the edges of zones without gaps: parent, zone and ends (n, 2) of each part."""
    edges = np.append(zone_bounds_deg[:, 0], zone_bounds_deg[-1, 1])
    low = edges[0] + np.mod(bounds_deg[:, 0] - edges[0], 360.0)
    high = low + (bounds_deg[:, 1] - bounds_deg[:, 0])
    edges = np.append(edges, edges[1:] + 360.0)  # a column may begin in the last zone and end in the first one
    start, end = np.maximum(low[:, None], edges[:-1]), np.minimum(high[:, None], edges[1:])
    parent, zone = np.nonzero(end - start > _SLIVER * (high - low)[:, None])
    return parent, zone % len(zone_bounds_deg), np.column_stack([start[parent, zone], end[parent, zone]])


def _disc_around_zenith(_: Component, zones: PatchGrid) -> np.ndarray:
    """Mass of a disc around the zenith, which lies in the first ring: even, or all of it in a ring of one zone."""
    mass = np.zeros((zones.n_zenith, zones.n_azimuth))
    mass[0] = np.diff(zones.azimuth_bounds_deg, axis=1)[:, 0]
    return mass.ravel()
