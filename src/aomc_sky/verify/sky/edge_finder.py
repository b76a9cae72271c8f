"""Intervals and patches that many numbers lie in, found by tables of equal steps and not by bisection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.verify.sky.fixed_directions import WHOLE_TURN

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
        with np.errstate(invalid="ignore"):  # what is no number is told apart by whoever asks
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
    #: In the turn that begins with the first column. [deg, shape (n,)]
    azimuth_deg: np.ndarray
    #: Whether there is a patch. [shape (n,)]
    is_inside: np.ndarray

    def number(self, n_columns: int) -> np.ndarray:
        """Patch of each direction, zenith-major; any where there is none."""
        patch = self.ring * n_columns
        patch += self.column
        return patch


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
        turned += WHOLE_TURN * (turned < 0)
        turned += self._turn
        ring, column = self._rings.find(zenith_deg), self._columns.find(turned)
        inside = zenith_deg <= (self._end if self._ring_ends is None else self._ring_ends.take(ring, mode="clip"))
        if self._start > 0:
            inside &= zenith_deg >= self._start
        if self._column_ends is not None:
            inside &= turned <= self._column_ends.take(column, mode="clip")
        return FoundPatches(ring=ring, column=column, azimuth_deg=turned, is_inside=inside)


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
