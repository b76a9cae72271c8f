"""Positions of photons inside patches, all patches of a component together: what is expected, counts, tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.directions import sin_cos_deg
from aomc_sky.grid import PatchGrid
from aomc_sky.source.options import Placement
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.report import Check
from aomc_sky.verify.sky.edge_finder import FoundPatches, PatchFinder
from aomc_sky.verify.sky.fixed_directions import WHOLE_TURN, FixedDirections, fixed_directions
from aomc_sky.verify.sky.grid_cuts import drop_of_mu, growth_of_sin2
from aomc_sky.verify.sky.photon_angles import PhotonAngles
from aomc_sky.verify.sky.zone_shares import perez_masses
from aomc_sky.verify.sky.zone_tests import MIN_EVEN, of_chi_square, untested
from aomc_sky.verify.tails import kolmogorov_p

N_STEPS = 64
"""Steps across a patch of constant radiance: the Kolmogorov distance between them says nearly all."""

N_STEPS_PEREZ = 8
"""Steps across a patch with the luminance of Perez: each wants the mass of its own part."""


class PatchInterior:
    """The patches of one component of law CELL_MU2, CELL_MU or PEREZ, the positions in them, and what is expected.

    Patches that touch a fixed direction are left out.
    """

    def __init__(self, component: Component, fixed: FixedDirections) -> None:
        assert component.grid is not None
        self.grid: PatchGrid = component.grid
        self._component = component
        self.n_steps = N_STEPS_PEREZ if component.law is Law.PEREZ else N_STEPS
        self._is_usable = (self.grid.solid_angle_sr > 0) & ~_touched(self.grid, fixed)
        self._finder = PatchFinder(self.grid)
        self._near, whole = self._ring_coordinate()
        self._start, end = (np.ascontiguousarray(x) for x in self.grid.azimuth_bounds_deg.T)
        self._per_ring, self._per_column = (_per_extent(self.n_steps, x) for x in (whole, end - self._start))

    def _ring_coordinate(self) -> tuple[np.ndarray, np.ndarray]:
        """`_along` at the near edge of each ring, and how far it goes to the far edge."""
        bounds = self.grid.zenith_bounds_deg
        near = bounds[:, 0].copy()
        if self._component.law is Law.PEREZ:
            return near, bounds[:, 1] - near
        if self._component.law is Law.CELL_MU:
            return sin_cos_deg(near)[1], -drop_of_mu(bounds)
        return sin_cos_deg(near)[0] ** 2, growth_of_sin2(bounds)

    def find(self, angles: PhotonAngles) -> FoundPatches:
        """Patches of photons."""
        return self._finder.find(angles.zenith_deg, angles.azimuth_deg)

    def tally(self, angles: PhotonAngles, found: FoundPatches) -> InteriorCounts:
        """Count photons by patch and by step of either coordinate; azimuths of `found` are used up."""
        patch = found.number(self.grid.n_azimuth)
        inside = found.is_inside & self._is_usable.take(patch, mode="clip")
        along, across = self._along(angles), found.azimuth_deg
        along -= self._near.take(found.ring, mode="clip")
        along *= self._per_ring.take(found.ring, mode="clip")
        across -= self._start.take(found.column, mode="clip")
        across *= self._per_column.take(found.column, mode="clip")
        steps = [self._counted(x, inside) for x in (along, across)]
        if self._component.law is Law.PEREZ:
            of_patches = np.bincount(patch[inside], minlength=self.grid.n_patches)
        else:
            of_patches = np.array([np.count_nonzero(inside)])
        return InteriorCounts(patch=of_patches, along=steps[0], across=steps[1])

    def _along(self, angles: PhotonAngles) -> np.ndarray:
        """The coordinate in which photons of a ring are spread evenly; for a Perez sky the zenith angle."""
        if self._component.law is Law.PEREZ:
            return angles.zenith_deg.copy()
        return angles.mu() if self._component.law is Law.CELL_MU else angles.sin2()

    def _counted(self, step: np.ndarray, inside: np.ndarray) -> np.ndarray:
        """Photons of each step; rounding may bring one over an end of its patch."""
        n = self.n_steps
        np.fmin(np.fmax(step, 0.0, out=step), n - 0.5, out=step)  # no number: 0
        index = step.astype(np.intp)
        index += 1
        index *= inside
        return np.bincount(index, minlength=n + 1)[1:]

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
    """Photons by patch, and by step along and across all patches together; each int64.

    Where all patches expect the same, one number tells the photons of all of them.
    """

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
    fixed = fixed_directions([c for c in components if c.grid is None], at_centres=False)
    return PatchInterior(with_grid[0], fixed.with_margins()), ""


def _per_extent(n: int, extent: np.ndarray) -> np.ndarray:
    """Steps for each unit of a coordinate; 0 where there is no extent, and no photon is counted."""
    return np.divide(n, extent, out=np.zeros_like(extent), where=extent != 0)


def _touched(grid: PatchGrid, fixed: FixedDirections) -> np.ndarray:
    """Whether a patch touches a fixed place, (n_patch,)."""
    found = np.zeros((grid.n_zenith, grid.n_azimuth), dtype=bool)
    for zenith, azimuth in zip(fixed.zenith_deg, fixed.azimuth_deg, strict=True):
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


_COORDINATES = ("mu^2", "azimuth")


def interior_checks(
    interior: PatchInterior, counts: InteriorCounts, waveband: int, *, are_independent: bool
) -> list[Check]:
    """Chi-square and Kolmogorov-Smirnov of both coordinates.

    Where photons lie independently of each other inside patches the chi-square is two-sided; otherwise only too uneven
    positions fail. The Kolmogorov distance is taken between steps, so it is at most the true one, and the p-value at
    most too large.
    """
    checks = []
    n = int(counts.patch.sum())
    found_of = (counts.along, counts.across)
    for coordinate, found, expected in zip(_COORDINATES, found_of, interior.expected(counts.patch), strict=True):
        name = f"inside patches, {coordinate}"
        if n < MIN_EVEN or expected.min() < MIN_EVEN / found.size:
            checks += [untested(f"{name}: {kind}", waveband) for kind in ("chi-square", "Kolmogorov-Smirnov")]
            continue
        checks.append(_chi_square(found, expected, name, waveband, are_independent=are_independent))
        distance = float(np.abs(np.cumsum(found - expected)).max() / n)
        checks.append(
            Check(
                name=f"{name}: Kolmogorov-Smirnov",
                waveband=waveband,
                passed=True,
                found=distance,
                p_value=kolmogorov_p(distance, n),
                detail=f"{n} photons",
            )
        )
    return checks


def _chi_square(found: np.ndarray, expected: np.ndarray, name: str, waveband: int, *, are_independent: bool) -> Check:
    statistic, degrees = float(np.sum((found - expected) ** 2 / expected)), found.size - 1
    kind = "chi-square, two-sided" if are_independent else "chi-square"
    return of_chi_square(statistic, degrees, f"{name}: {kind}", waveband, is_two_sided=are_independent)
