"""How the cells of a source spread over zones of the sky: exact masses of the models, no sampling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.source.options import Placement
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.sky.fixed_directions import cell_centre_deg
from aomc_sky.verify.sky.grid_cuts import cut, drop_of_mu, growth_of_sin2

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
        """Largest variance of the photons of a zone at given photons per cell: that of independent places, (n_zone,).

        0 where a zone consists of whole cells.
        """
        return np.bincount(self.zone, of_cells[self.cell] * self.share * (1 - self.share), self.n_zones)

    def variance(self, of_cells: np.ndarray, of_zones: np.ndarray) -> float:
        """Largest variance of the sum over photons of a number of their zones: that of independent places in cells.

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
        cell, zone, share = _of_component(component, zones, at_centres=at_centres, is_flux=is_flux)
        parts.append((cell + start, zone, share))
        start += component.n_cells
    cell, zone, share = (np.concatenate(column) for column in zip(*parts, strict=True))
    return ZoneShares(cell=cell, zone=zone, share=share, n_zones=zones.n_patches)


def _of_component(
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
    from aomc_sky.kernels.backend import perez_sums
    from aomc_sky.skies.perez.patches import patch_integrals

    assert component.shared is not None
    sums = perez_sums(len(zenith_deg) * len(azimuth_deg))
    return patch_integrals(zenith_deg / 90.0, azimuth_deg / 90.0, component.shared, sums)


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
