"""The order in which systematic allocation goes through the patches of a grid.

Systematic allocation gives a photon to every N-th part of the cumulative mass. If all patches of a ring are equal,
those with a photon more are therefore evenly spaced. If every ring began at the same column, rings of equal mass would
fill the same columns. Therefore each ring begins its walk at a column of its own and closes the circle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aomc_sky.kernels.arithmetic.error_free import FIXED_POINT_BITS, product_over_2_62
from aomc_sky.kernels.arithmetic.rng import philox_pair

_SHIFT_STEP = np.uint64(0x6A09E667F3BCC909)
_COLUMN_STEP = np.uint64(0x4D82B446159F360F)
"""From ring to ring, in units of 2^-64: frac(sqrt 2) and (sqrt 13 - 3) / 2, rounded to an odd number. Their multiples
spread nearly as evenly as those of the golden ratio, which the places in the cells take from ring to ring."""

_SCATTER = 1 / 16
_TO_FRACTION = 2.0**-64
_ONE_PHOTON = 0.999  # below 1: a ring of exactly one photon must not change sides by a rounding
_HALF = 0.5001  # above 1/2, for the same reason


class WalkedGrid(NamedTuple):
    """One grid among the cells of all components, whose rings are walked."""

    first_cell: int  #: the number of the grid's first cell
    n_rings: int
    n_columns: int


def first_columns(units_before: np.ndarray, n_photons: int, n_columns: int) -> np.ndarray:
    """The column at which the walk through each ring begins, int64 (n_ring,).

    `units_before`, uint64 (n_ring + 1,), is the fixed-point cumulative mass before each ring, and at the end.

    Write E for the photons that a ring expects, and C for those of the rings before it in the grid. Write x in [0, 1)
    for the share of the ring before its first column. The pattern of patches with a photon more is shifted by E x - C
    of its period. Ring q takes an x that makes this shift frac(q sqrt 2). The shifts of successive rings are then
    spread evenly whatever E is. Among these x it takes the one next to frac(q (sqrt 13 - 3) / 2 + w / 16), where w is a
    pseudo-random number (Philox, counter q). E counts modulo the columns; where more than half of the patches have a
    photon more, those without one are the pattern. A ring that expects less than one photon takes x = w. The first ring
    begins at column 0.
    """
    quotient, remainder = product_over_2_62(units_before - units_before[0], n_photons, 0)
    unit = 2.0**-FIXED_POINT_BITS
    expected = np.diff(quotient.view(np.int64)) + np.diff(remainder.view(np.int64)) * unit
    excess = np.mod(expected, n_columns)
    is_gap = excess > _HALF * n_columns
    fewer = np.where(is_gap, n_columns - excess, excess)
    ring = np.arange(expected.size, dtype=np.uint64)
    random = philox_pair(np.uint64(0), ring, np.uint64(0), np.uint64(0))[0] * _TO_FRACTION
    near = (ring * _COLUMN_STEP) * _TO_FRACTION + random * _SCATTER
    before = np.where(is_gap, -1.0, 1.0) * (remainder[:-1] * unit)
    off = (ring * _SHIFT_STEP) * _TO_FRACTION + before - fewer * near
    share = np.where(fewer < _ONE_PHOTON, near, near + (off - np.rint(off)) / np.maximum(fewer, 1.0))
    share = np.where(np.less(expected, _ONE_PHOTON), random, share)
    share[0] = 0.0
    return np.floor((share - np.floor(share)) * n_columns).astype(np.int64) % n_columns


def walk_of_cells(cumulative: np.ndarray, n_photons: int, rings: tuple[WalkedGrid, ...]) -> np.ndarray:
    """The cells in the order of the walk, int64 (n_cell,).

    `cumulative`, uint64 (n_cell + 1,), is the fixed-point cumulative mass in the order of the cells. Cells outside all
    grids, grids of one column and grids of one ring keep their order.
    """
    order = np.arange(cumulative.size - 1)
    for first_cell, n_rings, n_columns in rings:
        if n_columns == 1 or n_rings == 1:
            continue
        edges = first_cell + n_columns * np.arange(n_rings + 1)
        first = first_columns(cumulative[edges], n_photons, n_columns)
        column = (first[:, None] + np.arange(n_columns)) % n_columns
        order[edges[0] : edges[-1]] = (edges[:-1, None] + column).ravel()
    return order
