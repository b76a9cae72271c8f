"""Where photons lie inside the patches of a sky: both coordinates counted in equal steps, over all patches together."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.grid import PatchGrid
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.sampling_options import Placement
from aomc_sky.verify.fixed_places import WHOLE_TURN, FixedPlaces, fixed_places
from aomc_sky.verify.pieces import drop_of_mu, growth_of_sin2
from aomc_sky.verify.zone_shares import perez_masses

N_STEPS = 64
"""Steps across a patch of constant radiance: the Kolmogorov distance between them says nearly all."""

N_STEPS_PEREZ = 8
"""Steps across a patch with the luminance of Perez: each wants the mass of its own part."""


class PatchInterior:
    """The patches of one component, the places in them, and what is expected.

    Parameters
    ----------
    component : Component
        Law CELL_MU2, CELL_MU or PEREZ, on a grid.
    places : FixedPlaces
        Patches that touch one of them are left out.
    """

    def __init__(self, component: Component, places: FixedPlaces) -> None:
        assert component.grid is not None
        self.grid: PatchGrid = component.grid
        self._component = component
        self.n_steps = N_STEPS_PEREZ if component.law is Law.PEREZ else N_STEPS
        self._usable = (self.grid.solid_angle_sr > 0) & ~_touched(self.grid, places)

    def tally(self, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> InteriorCounts:
        """Count photons by patch and by step of either coordinate."""
        patch = self.grid.patch_of(zenith_deg, azimuth_deg)
        inside = (patch >= 0) & self._usable[patch]
        patch = patch[inside]
        ring, column = np.divmod(patch, self.grid.n_azimuth)
        along = self._along(zenith_deg[inside], ring)
        start, end = self.grid.azimuth_bounds_deg[column].T
        across = np.mod(azimuth_deg[inside] - start, WHOLE_TURN) / (end - start)
        steps = [np.minimum((x * self.n_steps).astype(np.int64), self.n_steps - 1) for x in (along, across)]
        counts = [np.bincount(np.maximum(step, 0), minlength=self.n_steps) for step in steps]
        return InteriorCounts(
            patch=np.bincount(patch, minlength=self.grid.n_patches), along=counts[0], across=counts[1]
        )

    def _along(self, zenith_deg: np.ndarray, ring: np.ndarray) -> np.ndarray:
        """Share of the ring between its near edge and the photon, in the law's coordinate."""
        near, far = self.grid.zenith_bounds_deg[ring].T
        if self._component.law is Law.PEREZ:
            return (zenith_deg - near) / (far - near)
        measure = drop_of_mu if self._component.law is Law.CELL_MU else growth_of_sin2
        whole = measure(self.grid.zenith_bounds_deg)[ring]
        return measure(np.column_stack([near, zenith_deg])) / whole

    def expected(self, of_patches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Photons of each step along and across, if patches hold these. [two of shape (n_steps,)]"""
        if self._component.law is not Law.PEREZ:
            even = np.full(self.n_steps, of_patches.sum() / self.n_steps)
            return even, even
        return tuple(of_patches @ share for share in self._perez_shares)

    @cached_property
    def _perez_shares(self) -> tuple[np.ndarray, np.ndarray]:
        """Share of each step of each patch along and across, (n_patch, n_steps) each."""
        n, rings, columns = self.n_steps, self.grid.n_zenith, self.grid.n_azimuth
        zenith, azimuth = self.grid.zenith_bounds_deg, self.grid.azimuth_bounds_deg
        along = perez_masses(self._component, _steps(zenith, n), azimuth)
        across = perez_masses(self._component, zenith, _steps(azimuth, n))
        along = along.reshape(rings, n, columns).transpose(0, 2, 1).reshape(-1, n)
        return _normalised(along), _normalised(across.reshape(-1, n))


@dataclass(frozen=True, kw_only=True, slots=True)
class InteriorCounts:
    """Photons by patch, and by step along and across all patches together; each int64."""

    patch: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def __add__(self, other: InteriorCounts) -> InteriorCounts:
        return InteriorCounts(
            patch=self.patch + other.patch, along=self.along + other.along, across=self.across + other.across
        )


def interior_of(source: PhotonSource) -> tuple[PatchInterior | None, str]:
    """The patches of a source whose inside can be tested, or None and why not."""
    if source.plan.options["placement"] == Placement.CENTRE.value:
        return None, "photons lie in the centres of patches"
    components = source.components
    if any(component.law.is_lobe for component in components):
        return None, "lobes shine through the patches" if source.grid is not None else "lobes have no patches"
    with_grid = [c for c in components if c.grid is not None]
    if not with_grid:
        return None, "no part of the sky has patches"
    if len(with_grid) > 1:
        return None, "several parts of the sky have patches"
    if not np.any(with_grid[0].grid.solid_angle_sr > 0):  # type: ignore[union-attr]
        return None, "the patches are points"
    places = fixed_places([c for c in components if c.grid is None], at_centres=False)
    return PatchInterior(with_grid[0], places.with_margins()), ""


def _touched(grid: PatchGrid, places: FixedPlaces) -> np.ndarray:
    """Whether a patch touches a fixed place, (n_patch,)."""
    found = np.zeros((grid.n_zenith, grid.n_azimuth), dtype=bool)
    for zenith, azimuth in zip(places.zenith_deg, places.azimuth_deg, strict=True):
        rings = (grid.zenith_bounds_deg[:, 0] <= zenith[1]) & (zenith[0] <= grid.zenith_bounds_deg[:, 1])
        low, high = grid.azimuth_bounds_deg.T
        columns = np.mod(azimuth[0] - low, WHOLE_TURN) <= high - low
        columns |= np.mod(low - azimuth[0], WHOLE_TURN) <= azimuth[1] - azimuth[0]
        found |= rings[:, None] & columns
    return found.ravel()


def _steps(bounds: np.ndarray, n: int) -> np.ndarray:
    """Each interval cut into n equal ones."""
    edges = bounds[:, :1] + np.diff(bounds, axis=1) * np.arange(n + 1) / n
    edges[:, -1] = bounds[:, 1]
    return np.stack([edges[:, :-1], edges[:, 1:]], axis=-1).reshape(-1, 2)


def _normalised(mass: np.ndarray) -> np.ndarray:
    total = mass.sum(axis=1, keepdims=True)
    return np.divide(mass, total, out=np.zeros_like(mass), where=total > 0)
