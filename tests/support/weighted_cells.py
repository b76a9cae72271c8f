"""Weighted directions of a sky beside a table of its patch means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammainc, gammaincc, ndtr

from aomc_sky.atmosphere.sky.weighted_directions import DirectionDensity, WeightedDirections
from aomc_sky.grid import PatchGrid
from tests.support.chi2 import two_sided

LEAST = 2500
"""Directions that a group of cells expects at least: weights are skewed, and few do not know their scatter."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GroupSums:
    """Directions of one wavelength in groups of neighbouring cells of a table.

    `group` says which one each cell belongs to; `counts` and `expected` are by what directions are drawn from; `mean`
    and `error` of the irradiance that a group brings: chance of the group times the mean weight in it, so that how many
    directions came adds no noise. [W m-2 nm-1]
    """

    group: np.ndarray
    counts: np.ndarray
    expected: np.ndarray
    mean: np.ndarray
    error: np.ndarray

    def sums_of(self, of_cells: np.ndarray) -> np.ndarray:
        """What cells bring, by groups."""
        return np.bincount(self.group, of_cells)


def group_sums(found: WeightedDirections, row: int, density: DirectionDensity, grid: PatchGrid) -> GroupSums:
    """Sums over the cells of a grid that the patches of the density lie in as they are."""
    n = found.weight.shape[1]
    middle = [bounds.mean(axis=1) for bounds in (density.grid.zenith_bounds_deg, density.grid.azimuth_bounds_deg)]
    parent = grid.patch_of(*(part.ravel() for part in np.meshgrid(*middle, indexing="ij")))
    of_cells = np.bincount(parent, density.chance[row], grid.n_patches)
    group = _groups(n * of_cells)
    chance = np.bincount(group, of_cells)
    here = group[grid.patch_of(np.rad2deg(found.zenith_rad[row]), np.rad2deg(found.azimuth_from_sun_rad[row]))]
    counts = np.bincount(here, minlength=chance.size)
    mean = np.bincount(here, found.weight[row]) / counts
    variance = np.bincount(here, (found.weight[row] - mean[here]) ** 2) / (counts - 1)
    return GroupSums(
        group=group, counts=counts, expected=n * chance, mean=chance * mean, error=chance * np.sqrt(variance / counts)
    )


def _groups(expected: np.ndarray) -> np.ndarray:
    """Groups of neighbours that expect `LEAST` each; what is left joins the last one."""
    group, filled, number = np.empty(expected.size, dtype=np.int64), 0.0, 0
    for k, share in enumerate(expected):
        group[k] = number
        filled += share
        if filled >= LEAST:
            filled, number = 0.0, number + 1
    return np.minimum(group, number - 1)


def groups_p(sums: GroupSums, table: np.ndarray, table_error: np.ndarray) -> float:
    """Two-sided p-value of the irradiances of the groups beside those of a table and their errors."""
    pulls = (sums.mean - table) / np.hypot(sums.error, table_error)
    half, statistic = pulls.size / 2, float(np.sum(pulls**2))
    return two_sided(gammainc(half, statistic / 2), gammaincc(half, statistic / 2))


def whole_p(sums: GroupSums, table: np.ndarray, table_error: float) -> float:
    """Two-sided p-value of the irradiance of the whole sky; the error of a table's irradiance is given."""
    error = np.hypot(np.sqrt(np.sum(sums.error**2)), table_error)
    return float(2.0 * ndtr(-abs(sums.mean.sum() - table.sum()) / error))
