"""Zones of the sky in which photons are counted: their edges, and how the cells of a source spread over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.directions import sin_cos_deg, sky_from_travel
from aomc_sky.grid import PatchGrid
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.options import Placement

MARGIN_DEG = 1e-4
"""Distance of an edge from such a direction: thirty times the rounding of a direction in single precision."""

WHOLE_TURN = 360.0


@dataclass(frozen=True, kw_only=True, slots=True)
class FixedDirections:
    """Rectangles in zenith angle and azimuth, each around a direction or a disc."""

    #: zenith_deg, azimuth_deg: Ends of each, margins not included. A width of 360 in azimuth: a disc around the zenith.
    #: [shape (n, 2)]
    zenith_deg: np.ndarray
    azimuth_deg: np.ndarray

    def with_margins(self) -> FixedDirections:
        """The same, widened by what rounding of a direction may move a photon."""
        lowest = np.sin(np.deg2rad(np.maximum(self.zenith_deg[:, 0], 0.01)))
        around = (MARGIN_DEG + MARGIN_DEG / lowest)[:, None] * np.array([-1.0, 1.0])
        return FixedDirections(
            zenith_deg=self.zenith_deg + np.array([-MARGIN_DEG, MARGIN_DEG]), azimuth_deg=self.azimuth_deg + around
        )


def fixed_directions(components: Sequence[Component], *, at_centres: bool) -> FixedDirections:
    """The fixed directions of all components; `at_centres`: photons lie in the centres of patches."""
    parts = [_fixed_of(component, at_centres) for component in components]
    zenith = np.concatenate([part[0] for part in parts] or [np.zeros((0, 2))])
    azimuth = np.concatenate([part[1] for part in parts] or [np.zeros((0, 2))])
    return FixedDirections(zenith_deg=zenith, azimuth_deg=azimuth)


def _fixed_of(component: Component, at_centres: bool) -> tuple[np.ndarray, np.ndarray]:
    head, sine, cosine = component.cell[:, :4], component.cell[:, 4], component.cell[:, 5]
    if component.law in (Law.DISC, Law.DISC_AT_HORIZON):
        return _disc(component.law, head[0].tolist(), float(sky_azimuth_deg(sine, cosine)[0]))
    points = np.zeros(0, dtype=np.int64)
    if component.law is Law.BEAM:
        points = np.arange(component.n_cells)
    elif component.grid is not None:
        lit = component.mass.max(axis=0) > 0
        extent = component.grid.solid_angle_sr > 0
        points = np.flatnonzero(lit & (np.full(extent.shape, at_centres) | ~extent))
    zenith, azimuth = cell_centre_deg(component, points)
    return np.column_stack([zenith, zenith]), np.column_stack([azimuth, azimuth])


def cell_centre_deg(component: Component, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sky direction of the middle of cells of a beam or a patch, halfway in the law's own coordinates. [deg]"""
    h0, h1, h2 = component.cell[cells, :3].T
    if component.law is Law.CELL_MU:
        one_minus_mu, mu = h0 + h1 / 2, h2 + h1 / 2
        sin2, mu2 = one_minus_mu * (1 + mu), mu * mu
    else:
        sin2, mu2 = h0 + h1 / 2, h2 + h1 / 2
    zenith = np.rad2deg(np.arctan2(np.sqrt(sin2), np.sqrt(mu2)))
    return zenith, sky_azimuth_deg(component.cell[cells, 4], component.cell[cells, 5])


def sky_azimuth_deg(sine: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Azimuth of sky directions from its sine and cosine. [deg, 0 to 360)"""
    travel = -np.stack([cosine, sine, np.zeros_like(sine)], axis=-1)
    return np.rad2deg(sky_from_travel(travel)[1])


def _disc(law: Law, head: list[float], azimuth: float) -> tuple[np.ndarray, np.ndarray]:
    if law is Law.DISC:
        sin_z, cos_z, sin_r, cos_r = head
        centre, radius = np.rad2deg(np.arctan2(sin_z, cos_z)), np.rad2deg(np.arctan2(sin_r, cos_r))
        zenith = max(centre - radius, 0.0), min(centre + radius, 90.0)
        half = np.rad2deg(np.arcsin(sin_r / sin_z)) if sin_r < sin_z else WHOLE_TURN / 2
    else:
        top2, half_width = head[0], head[1]
        zenith = np.rad2deg(np.arctan2(np.sqrt(1 - top2), np.sqrt(top2))), 90.0
        half = 90.0 * half_width
    return np.array([zenith]), np.array([[azimuth - half, azimuth + half]])


N_ZONES = 16
"""Zones in each coordinate: few cells have more power against a defect that reaches far than many have."""

_LEAST_EDGES = 7
"""So many edges of patches, or more, are good enough for zones."""


def choose_zones(source: PhotonSource) -> PatchGrid:
    """Up to 16 x 16 zones for the photons of a source, about equal in mu^2 and in azimuth.

    Edges are those of the first component with patches where it has at least 7 of them: the photons of a zone are then
    those of whole patches. No edge runs through a beam, a disc or another fixed direction, and
    none within 1e-4 degrees of it.
    """
    at_centres = source.plan.options["placement"] == Placement.CENTRE.value
    fixed = fixed_directions(source.components, at_centres=at_centres).with_margins()
    grid = source.grid
    targets = np.rad2deg(np.arcsin(np.sqrt(np.arange(1.0, N_ZONES) / N_ZONES)))
    zenith = _best_edges(targets, _between(grid, "zenith"), fixed.zenith_deg)
    zenith = np.concatenate([[0.0], zenith[(zenith > 0) & (zenith < 90)], [90.0]])
    azimuth = _azimuth_edges(_between(grid, "azimuth"), fixed)
    return PatchGrid(
        zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
        azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
    )


def _between(grid: PatchGrid | None, name: str) -> np.ndarray:
    """Where two rings, or two columns, meet; halfway between them where they are points."""
    if grid is None:
        return np.zeros(0)
    bounds = grid.zenith_bounds_deg if name == "zenith" else grid.azimuth_bounds_deg
    inner = (bounds[:-1, 1] + bounds[1:, 0]) / 2
    if name == "zenith":
        return inner[(inner > 0) & (inner < 90)]
    wrap = (bounds[-1, 1] + bounds[0, 0] + WHOLE_TURN) / 2
    return np.sort(np.mod(np.append(inner, wrap), WHOLE_TURN))


def _azimuth_edges(candidates: np.ndarray, fixed: FixedDirections) -> np.ndarray:
    """Edges once around, the last one a turn after the first."""
    bounded = fixed.azimuth_deg[np.diff(fixed.azimuth_deg, axis=1)[:, 0] < WHOLE_TURN]
    turns = np.concatenate([bounded + turn for turn in (-WHOLE_TURN, 0.0, WHOLE_TURN)])
    targets = np.arange(N_ZONES) * WHOLE_TURN / N_ZONES
    edges = np.unique(np.mod(_best_edges(targets, candidates, turns), WHOLE_TURN))
    return np.append(edges, edges[0] + WHOLE_TURN) if edges.size else np.array([0.0, WHOLE_TURN])


def _best_edges(targets: np.ndarray, candidates: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """For each target the nearest candidate that is not taken; with few candidates the targets, moved where taken."""
    low, high = _merged(taken)
    free = candidates[~_is_inside(candidates, low, high)]
    if free.size >= _LEAST_EDGES:
        nearest = free[np.abs(free[:, None] - targets).argmin(axis=0)]
        return np.unique(nearest)
    inside = _is_inside(targets, low, high)
    if low.size:
        index = np.maximum(np.searchsorted(low, targets, side="right") - 1, 0)
        nearer = np.where(targets - low[index] < high[index] - targets, low[index], high[index])
        targets = np.where(inside, nearer, targets)
    return np.unique(targets)


def _merged(intervals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Intervals put together where they meet, in rising order."""
    if len(intervals) == 0:
        return np.zeros(0), np.zeros(0)
    intervals = intervals[np.argsort(intervals[:, 0])]
    reach = np.maximum.accumulate(intervals[:, 1])
    starts = np.flatnonzero(np.append(True, intervals[1:, 0] > reach[:-1]))
    return intervals[starts, 0], reach[np.append(starts[1:] - 1, len(intervals) - 1)]


def _is_inside(values: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    if low.size == 0:
        return np.zeros(values.shape, dtype=bool)
    index = np.searchsorted(low, values, side="right") - 1
    return (index >= 0) & (values < high[np.maximum(index, 0)])


_SLIVER = 1e-9
"""Smallest part of a ring or column that is kept: less comes from rounding of edges."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GridCuts:
    """Parts of rings or columns."""

    #: parent, zone: The ring or column that each is part of, and the zone ring or column that it lies in. [shape (n,)]
    parent: np.ndarray
    zone: np.ndarray
    #: Its ends. [deg, shape (n, 2)]
    bounds_deg: np.ndarray

    def shares(self, measure: np.ndarray) -> np.ndarray:
        """Part of the parent that each piece is, from the measure of pieces; without extent, all of it."""
        total = np.bincount(self.parent, measure)[self.parent]
        return np.divide(measure, total, out=np.ones_like(total), where=total > 0)

    @property
    def is_cut(self) -> bool:
        """Whether any parent has several pieces."""
        return self.parent.size > np.unique(self.parent).size


def cut(bounds_deg: np.ndarray, zone_bounds_deg: np.ndarray, *, is_azimuth: bool) -> GridCuts:
    """Cut intervals, rings or columns, at the edges of zones; points are allowed.

    Zones leave no gaps between them, those of azimuth make one turn.
    """
    edges = np.append(zone_bounds_deg[:, 0], zone_bounds_deg[-1, 1])
    low, high = bounds_deg.T
    n_zones = len(zone_bounds_deg)
    if is_azimuth:
        low = edges[0] + np.mod(low - edges[0], WHOLE_TURN)
        high = low + (bounds_deg[:, 1] - bounds_deg[:, 0])
        edges = np.append(edges, edges[1:] + WHOLE_TURN)
    first = np.clip(np.searchsorted(edges, low, side="right") - 1, 0, edges.size - 2)
    last = np.clip(np.searchsorted(edges, high, side="left") - 1, first, edges.size - 2)
    number = last - first + 1
    parent = np.repeat(np.arange(low.size), number)
    zone = first[parent] + np.arange(parent.size) - np.repeat(np.cumsum(number) - number, number)
    start, end = np.maximum(low[parent], edges[zone]), np.minimum(high[parent], edges[zone + 1])
    kept = (end - start > _SLIVER * (high - low)[parent]) | (number[parent] == 1)
    bounds = np.column_stack([start, np.maximum(end, start)])[kept]
    return GridCuts(parent=parent[kept], zone=zone[kept] % n_zones, bounds_deg=bounds)


def growth_of_sin2(bounds_deg: np.ndarray) -> np.ndarray:
    """Growth of sin^2 of the zenith angle over rings: the flux of a constant radiance."""
    near, far = bounds_deg.T
    return sin_cos_deg(far - near)[0] * sin_cos_deg(far + near)[0]


def drop_of_mu(bounds_deg: np.ndarray) -> np.ndarray:
    """Drop of the cosine of the zenith angle over rings: their solid angle."""
    near, far = bounds_deg.T
    return 2.0 * sin_cos_deg((far + near) / 2)[0] * sin_cos_deg((far - near) / 2)[0]


_GAUSS_POINTS = 48


@dataclass(frozen=True, kw_only=True, slots=True)
class ZoneShares:
    """Parts of cells that lie in zones; those of one cell add up to 1."""

    #: cell, zone: Cell in the order of the counts, zone in the order of the patches of the zones. [shape (n,)]
    cell: np.ndarray
    zone: np.ndarray
    #: Part of the photons of the cell. [0 to 1, shape (n,)]
    share: np.ndarray
    #: Number of zones.
    n_zones: int

    def expected(self, of_cells: np.ndarray) -> np.ndarray:
        """What zones hold if cells hold this, float64 (n_zone,)."""
        return np.bincount(self.zone, of_cells[self.cell] * self.share, self.n_zones)

    def loose(self, of_cells: np.ndarray) -> np.ndarray:
        """Largest variance of the photons of a zone at given photons per cell: of independent positions, (n_zone,).

        0 where a zone consists of whole cells.
        """
        return np.bincount(self.zone, of_cells[self.cell] * self.share * (1 - self.share), self.n_zones)

    def variance(self, of_cells: np.ndarray, of_zones: np.ndarray) -> float:
        """Largest variance of the sum over photons of a number of their zones: of independent positions in cells.

        0 where that number is the same in all of a cell.
        """
        mean = np.bincount(self.cell, self.share * of_zones[self.zone], of_cells.size)
        off = of_zones[self.zone] - mean[self.cell]
        return float(of_cells[self.cell] @ (self.share * off * off))


def zone_shares(source: PhotonSource, zones: PatchGrid, *, is_flux: bool = False) -> ZoneShares:
    """Spread the cells of a source over zones.

    `is_flux` is for sums of weights: patches of law CELL_MU then count as those of law CELL_MU2, for their weights
    carry the cosine. Errors: 1e-14 for patches of constant radiance, beams and discs, 1e-10 for a Perez sky, for lobes
    those of `aomc_sky.lobes.patch_mass`.
    """
    at_centres = source.plan.options["placement"] == Placement.CENTRE.value
    start, parts = 0, []
    for component in source.components:
        cell, zone, share = _shares_of(component, zones, at_centres=at_centres, is_flux=is_flux)
        parts.append((cell + start, zone, share))
        start += component.n_cells
    cell, zone, share = (np.concatenate(column) for column in zip(*parts, strict=True))
    return ZoneShares(cell=cell, zone=zone, share=share, n_zones=zones.n_patches)


def _shares_of(
    component: Component, zones: PatchGrid, *, at_centres: bool, is_flux: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if component.law.is_lobe:
        from aomc_sky.skies.lobes.patches import patch_shares

        return _one_cell(patch_shares(component, zones))
    if component.law is Law.DISC_AT_HORIZON:
        # edges keep clear of the disc: any point of it will do, and the middle of the horizon is one
        return _points(component, zones, np.array([90.0]))
    if component.law is Law.DISC:
        sin_z, cos_z, sin_r, _ = component.cell[0, :4].tolist()
        if sin_r >= sin_z:
            return _one_cell(_disc_around_zenith(component, zones))
        return _points(component, zones, np.array([np.rad2deg(np.arctan2(sin_z, cos_z))]))
    if component.grid is None or at_centres:
        return _points(component, zones, None)
    return _patches(component, component.grid, zones, is_flux=is_flux)


def _points(
    component: Component, zones: PatchGrid, zenith: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    cells = np.arange(component.n_cells)
    middle, azimuth = cell_centre_deg(component, cells)
    zone = zones.patch_of(middle if zenith is None else zenith, azimuth)
    return cells, zone, np.ones(cells.size)


def _one_cell(mass: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    zone = np.flatnonzero(mass > 0)
    return np.zeros(zone.size, dtype=np.int64), zone, mass[zone] / mass[zone].sum()


def _patches(
    component: Component, grid: PatchGrid, zones: PatchGrid, *, is_flux: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rings = cut(grid.zenith_bounds_deg, zones.zenith_bounds_deg, is_azimuth=False)
    columns = cut(grid.azimuth_bounds_deg, zones.azimuth_bounds_deg, is_azimuth=True)
    parent = (rings.parent[:, None] * grid.n_azimuth + columns.parent).ravel()
    zone = (rings.zone[:, None] * zones.n_azimuth + columns.zone).ravel()
    if component.law is Law.PEREZ and (rings.is_cut or columns.is_cut):
        mass = perez_masses(component, rings.bounds_deg, columns.bounds_deg).ravel()
        total = np.bincount(parent, mass)[parent]
        share = np.divide(mass, total, out=np.zeros_like(mass), where=total > 0)
    else:
        measure = drop_of_mu if component.law is Law.CELL_MU and not is_flux else growth_of_sin2
        across = columns.shares(np.diff(columns.bounds_deg, axis=1)[:, 0])
        share = np.outer(rings.shares(measure(rings.bounds_deg)), across).ravel()
    return parent, zone, share


def perez_masses(component: Component, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> np.ndarray:
    """Flux of a Perez sky through each of rings x columns. [sr, shape (n_ring, n_column)]"""
    from aomc_sky.skies.perez.patches import patch_integrals

    assert component.shared is not None
    return patch_integrals(zenith_deg / 90.0, azimuth_deg / 90.0, component.shared)


def _disc_around_zenith(component: Component, zones: PatchGrid) -> np.ndarray:
    """Mass of a disc that holds the zenith: it lies in the first ring, its sectors are those of an ellipse.

    The orthographic projection of the disc is uniform in flux (Nusselt): an ellipse with semi-axes sin r cos z along
    the sun's azimuth and sin r across it, its centre at cos r sin z. The integral of s^2 / 2 over the azimuth is taken
    with 48 Gauss points in each sector.
    """
    sin_z, cos_z, sin_r, cos_r = component.cell[0, :4].tolist()
    azimuth = np.deg2rad(cell_centre_deg(component, np.array([0]))[1][0])
    low, high = np.deg2rad(zones.azimuth_bounds_deg).T
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    phi = low[:, None] + (high - low)[:, None] * (nodes + 1) / 2 - azimuth
    along, across, x0 = sin_r * cos_z, sin_r, cos_r * sin_z
    p = (np.cos(phi) / along) ** 2 + (np.sin(phi) / across) ** 2
    q, c = x0 * np.cos(phi) / along**2, (x0 / along) ** 2 - 1
    reach = (q + np.sqrt(q * q - p * c)) / p
    mass = np.zeros((zones.n_zenith, zones.n_azimuth))
    mass[0] = (reach**2) @ weights * (high - low)
    return mass.ravel()
