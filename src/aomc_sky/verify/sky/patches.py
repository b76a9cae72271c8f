"""Patches that photons come from, and the positions inside them: what is expected, counts, tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.directions import Frame, sin_cos_deg, sky_columns_deg
from aomc_sky.grid import PatchGrid
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.options import Placement
from aomc_sky.verify.report import Check, kolmogorov_p
from aomc_sky.verify.sky.zone_tests import MIN_EVEN, of_chi_square, untested
from aomc_sky.verify.sky.zones import (
    WHOLE_TURN,
    FixedDirections,
    drop_of_mu,
    fixed_directions,
    growth_of_sin2,
    perez_masses,
)

_ZENITH_DEG = 1e-3
"""So near to the zenith an azimuth says nothing, and counts as 0."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonAngles:
    """Sky directions of photons."""

    #: zenith_deg, azimuth_deg: Azimuth 0 within 0.001 degrees of the zenith. [deg, shape (n,)]
    zenith_deg: np.ndarray
    azimuth_deg: np.ndarray
    #: across2, up2, length2: Squares of the horizontal part of a direction, of its vertical part, and of its length.
    #: [shape (n,)]
    across2: np.ndarray
    up2: np.ndarray
    length2: np.ndarray

    @classmethod
    def of(cls, direction: np.ndarray, frame: Frame) -> PhotonAngles:
        """Of travel directions (n, 3), in any precision."""
        x, y, z = np.ascontiguousarray(direction.T, dtype=np.float64)
        across2, up2 = x * x, z * z
        across2 += y * y
        zenith, azimuth = sky_columns_deg(x, y, z, across2, frame)
        azimuth[zenith < _ZENITH_DEG] = 0.0
        return cls(zenith_deg=zenith, azimuth_deg=azimuth, across2=across2, up2=up2, length2=across2 + up2)

    def sin2(self) -> np.ndarray:
        """sin^2 of the zenith angle, (n,)."""
        return self.across2 / self.length2

    def mu(self) -> np.ndarray:
        """Cosine of the zenith angle of photons from above, (n,)."""
        return np.sqrt(self.up2 / self.length2)


_FEWEST_STEPS, _MOST_STEPS = 64, 16_384
_SLACK = 1e-6
"""By how much of a step rounding can at most move a number."""


class EdgeFinder:
    """The last of rising starts that is not above a number: `numpy.searchsorted`, eight times as fast.

    A table of equal steps says which interval the lower end of a step lies in; as many comparisons follow as edges lie
    in the fullest step, mostly one. Comparisons are those of the numbers themselves, so the answer is exact. Equal
    neighbours are allowed; `end` is where the last interval ends.
    """

    def __init__(self, starts: np.ndarray, end: float) -> None:
        self._first = float(starts[0])
        self._next = np.append(starts[1:], np.inf)
        width = end - self._first
        n_steps = _FEWEST_STEPS
        while True:
            self._scale = n_steps / width if width > 0 else 0.0
            self._table, self._n_comparisons = self._steps(starts, n_steps)
            if self._n_comparisons <= 1 or n_steps >= _MOST_STEPS:
                return
            n_steps *= 2

    def _steps(self, starts: np.ndarray, n_steps: int) -> tuple[np.ndarray, int]:
        """Interval at the lower end of each step, and the most edges in a step."""
        if self._scale == 0:
            return np.zeros(1, dtype=np.intp), starts.size - 1
        step = np.arange(n_steps)
        low = self._first + (step - _SLACK) / self._scale
        high = self._first + (step + 1 + _SLACK) / self._scale
        high[-1] = np.inf
        at_low, at_high = (np.maximum(np.searchsorted(starts, x, side="right") - 1, 0) for x in (low, high))
        return at_low.astype(np.intp), int((at_high - at_low).max())

    def find(self, values: np.ndarray) -> np.ndarray:
        """Interval of each number; those below the first start, and those that are no numbers, get some interval."""
        scaled = values - self._first
        scaled *= self._scale
        with np.errstate(invalid="ignore"):  # what is no number is marked as outside by the caller
            found = self._table.take(scaled.astype(np.intp), mode="clip")
        for _ in range(self._n_comparisons):
            found += values >= self._next.take(found, mode="clip")
        return found


@dataclass(frozen=True, kw_only=True, slots=True)
class FoundPatches:
    """Patches of directions."""

    #: ring, column: Of the patch; any where there is none. [shape (n,)]
    ring: np.ndarray
    column: np.ndarray
    #: Of the patch, zenith-major; any where there is none. [shape (n,)]
    number: np.ndarray
    #: In the turn that begins with the first column. [deg, shape (n,)]
    azimuth_deg: np.ndarray
    #: Whether there is a patch. [shape (n,)]
    is_inside: np.ndarray


class PatchFinder:
    """Patches of a grid that directions lie in: `PatchGrid.patch_of` for millions of them."""

    def __init__(self, grid: PatchGrid) -> None:
        self.grid = grid
        rings, columns = grid.zenith_bounds_deg, grid.azimuth_bounds_deg
        self._start, self._turn = float(rings[0, 0]), float(columns[0, 0])
        self._end = float(rings[-1, 1])
        self._rings = EdgeFinder(rings[:, 0], self._end)
        self._columns = EdgeFinder(columns[:, 0], max(self._turn + WHOLE_TURN, float(columns[-1, 0])))
        self._ring_ends = None if np.all(rings[:-1, 1] >= rings[1:, 0]) else rings[:, 1].copy()
        is_gapless = np.all(columns[:-1, 1] >= columns[1:, 0]) and columns[-1, 1] >= self._turn + WHOLE_TURN
        self._column_ends = None if is_gapless else columns[:, 1].copy()

    def find(self, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> FoundPatches:
        """Patch of each sky direction, zenith 0 to 180 and azimuth 0 to 360 degrees."""
        turned = azimuth_deg - self._turn
        turned -= WHOLE_TURN * (turned >= WHOLE_TURN)
        if self._turn:
            turned += WHOLE_TURN * (turned < 0)
            turned += self._turn
        ring, column = self._rings.find(zenith_deg), self._columns.find(turned)
        inside = zenith_deg <= (self._end if self._ring_ends is None else self._ring_ends.take(ring, mode="clip"))
        if self._start > 0:
            inside &= zenith_deg >= self._start
        if self._column_ends is not None:
            inside &= turned <= self._column_ends.take(column, mode="clip")
        number = ring * self.grid.n_azimuth
        number += column
        return FoundPatches(ring=ring, column=column, number=number, azimuth_deg=turned, is_inside=inside)


def zone_of_patches(zones: PatchGrid, grid: PatchGrid) -> np.ndarray | None:
    """Zone that each patch lies in, where every zone is made of whole patches and patches leave no gap; else None.

    The zone of a direction is then that of its patch, but for azimuths whose last digit settles it.
    """
    rings, columns = grid.zenith_bounds_deg, grid.azimuth_bounds_deg
    covers = rings[0, 0] == 0 and rings[-1, 1] == 90 and columns[-1, 1] - columns[0, 0] == WHOLE_TURN
    if not (covers and np.array_equal(rings[:-1, 1], rings[1:, 0]) and np.array_equal(columns[:-1, 1], columns[1:, 0])):
        return None
    on_rings = np.isin(zones.zenith_bounds_deg[:, 0], rings[:, 0]).all()
    on_columns = np.isin(np.mod(zones.azimuth_bounds_deg[:, 0], WHOLE_TURN), np.mod(columns[:, 0], WHOLE_TURN)).all()
    if not (on_rings and (on_columns or zones.n_azimuth == 1)):
        return None
    middle = np.mod(columns.mean(axis=1), WHOLE_TURN)
    return zones.patch_of(np.repeat(rings.mean(axis=1), grid.n_azimuth), np.tile(middle, grid.n_zenith))


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
        self._all_usable = bool(self._is_usable.all())
        self._finder = PatchFinder(self.grid)
        self._near, extent = self._ring_coordinate()
        self._start, end = (np.ascontiguousarray(x) for x in self.grid.azimuth_bounds_deg.T)
        self._per_ring, self._per_column = (_per_extent(self.n_steps, x) for x in (extent, end - self._start))
        if np.all(self._per_column == self._per_column[0]):
            self._per_column = self._per_column[:1]

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
        patch, inside = found.number, found.is_inside
        if not self._all_usable:
            inside = inside & self._is_usable.take(patch, mode="clip")
        along, across = self._along(angles), found.azimuth_deg
        along -= self._near.take(found.ring, mode="clip")
        along *= self._per_ring.take(found.ring, mode="clip")
        across -= self._start.take(found.column, mode="clip")
        across *= self._per_column if self._per_column.size == 1 else self._per_column.take(found.column, mode="clip")
        outside = np.flatnonzero(~inside)
        steps = [self._counted(x, outside) for x in (along, across)]
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

    def _counted(self, step: np.ndarray, outside: np.ndarray) -> np.ndarray:
        """Photons of each step, but for those outside; rounding may bring one over an end of its patch."""
        n = self.n_steps
        np.fmin(np.fmax(step, 0.0, out=step), n - 0.5, out=step)  # no number: 0
        index = step.astype(np.intp)
        return np.bincount(index, minlength=n) - np.bincount(index[outside], minlength=n)

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

    Where all patches expect the same, one number holds the photons of all of them.
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
        return None, "lobes add light inside the patches" if source.grid is not None else "lobes have no patches"
    with_grid = [c for c in components if c.grid is not None]
    if not with_grid:
        return None, "no component has patches"
    if len(with_grid) > 1:
        return None, "several components have patches"
    if not np.any(with_grid[0].grid.solid_angle_sr > 0):  # type: ignore[union-attr]
        return None, "the patches are points"
    fixed = fixed_directions([c for c in components if c.grid is None], at_centres=False)
    return PatchInterior(with_grid[0], fixed.with_margins()), ""


def _per_extent(n: int, extent: np.ndarray) -> np.ndarray:
    """Steps for each unit of a coordinate; 0 where there is no extent, and no photon is counted."""
    return np.divide(n, extent, out=np.zeros_like(extent), where=extent != 0)


def _touched(grid: PatchGrid, fixed: FixedDirections) -> np.ndarray:
    """Whether a patch touches a fixed direction, (n_patch,)."""
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
