"""The Sobol points and their emission in plain numpy, equal to `sobol` and `emit_sobol` bit by bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import constants as k
from aomc_sky.kernels.plain import HG, PEREZ, philox, place, unit

_U32 = np.uint32
_U64 = np.uint64
_S62 = np.uint64(62)
_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)
_REST62 = np.uint64((1 << 62) - 1)
_TO_53 = 2.0**53
_LARGEST_53 = np.int64(2**53 - 1)
N_GROUPS = 8
TABLE_GROUPS = 3
_HALVES = ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF))


def plain_points(index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first two Sobol coordinates of points, uint32 fractions of 2^32.

    Parameters
    ----------
    index : ndarray, uint32
        Points of the sequence. [0 to 2^32 - 1]
    """
    x = index
    for shift, mask in _HALVES:
        x = ((x >> _U32(shift)) & _U32(mask)) | ((x & _U32(mask)) << _U32(shift))
    x = (x >> _U32(16)) | (x << _U32(16))
    y = x ^ (x << _U32(16))
    for shift, mask in reversed(_HALVES):
        y = y ^ ((y & _U32(mask)) << _U32(shift))
    return x, y


def _swaps(node, key_a, key_b):
    x = node + key_a
    x = (x ^ (x >> _U32(16))) * k.STIR_A
    x = ((x ^ (x >> _U32(15))) + key_b) * k.STIR_B
    return x ^ (x >> _U32(16))


def scramble(x: np.ndarray, keys: np.ndarray, n_groups: int = N_GROUPS) -> np.ndarray:
    """Nested uniform scrambling of the upper 4 n_groups bits of fractions of 2^32; the bits below become 0.

    Parameters
    ----------
    x : ndarray, uint32
        One coordinate.
    keys : ndarray, uint32, shape (8, 2)
        A pair of keys for each group of four levels.
    n_groups : int
        Groups wanted. [0 to 8]
    """
    out = np.zeros_like(x)
    for group in range(n_groups):
        shift = _U32(28 - 4 * group)
        part = x >> shift
        digit = part & _U32(15)
        h = _swaps(part >> _U32(4), *keys[group])
        flips = (h & _U32(1)) << _U32(3)
        for level, first in ((3, 1), (2, 3), (1, 7)):
            flips |= ((h >> (_U32(first) + (digit >> _U32(level)))) & _U32(1)) << _U32(level - 1)
        out |= (digit ^ flips) << shift
    return out


def top_table(keys: np.ndarray) -> np.ndarray:
    """The first twelve levels of both coordinates, scrambled: uint16 (2, 4096) for keys (2, 8, 2)."""
    nodes = np.arange(4096, dtype=_U32) << _U32(20)
    return np.stack([scramble(nodes, one, TABLE_GROUPS) >> _U32(20) for one in keys]).astype(np.uint16)


def component_points(index: np.ndarray, tree: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Component of each photon, and which of its points the photon takes; as `sobol_cells` finds them.

    Parameters
    ----------
    index : ndarray, uint64
        Photons of the lane. [0 to 2^32 - 1]
    tree : ndarray, uint64, shape (2 n_leaf,)
        Photons of each node; node 1 is the root, node i has the children 2 i and 2 i + 1, leaves are last.
    """
    node = np.ones(index.size, np.int64)
    while index.size and node[0] < tree.size // 2:
        total, left = tree[node], tree[2 * node]
        product = index * left + (total >> _U64(1))
        before = product // np.maximum(total, _U64(1))
        is_left = product - before * total + left >= total
        index = np.where(is_left, before, index - before)
        node = 2 * node + np.where(is_left, 0, 1)
    return node - tree.size // 2, index


def times_over_2_62(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quotient and remainder of a b by 2^62 for uint64 numbers up to 2^62."""
    a0, a1, b0, b1 = a & _LOW, a >> _S32, b & _LOW, b >> _S32
    p00, p01, p10 = a0 * b0, a0 * b1, a1 * b0
    middle = (p00 >> _S32) + (p01 & _LOW) + (p10 & _LOW)
    low = (middle << _S32) | (p00 & _LOW)
    high = a1 * b1 + (p01 >> _S32) + (p10 >> _S32) + (middle >> _S32)
    return (high << _U64(2)) | (low >> _S62), low & _REST62


def fraction_word(value: np.ndarray) -> np.ndarray:
    """A float in [0, 1] as a 64-bit fraction of 53 bits below 1."""
    return np.minimum((value * _TO_53).astype(np.int64), _LARGEST_53).astype(_U64) << _U64(11)


def _find(x, y, table):
    """Cells of a component, and 64-bit places in them, of coordinates of 64 bits; `table` as in `find_cells`."""
    rings, cells = table
    x, y = x >> _U64(2), y >> _U64(2)
    ring = np.searchsorted(rings, x, side="right") - 1
    start = rings[ring]
    width = rings[ring + 1] - start
    u = fraction_word((x - start).astype(np.float64) / width.astype(np.float64))
    ahead, rest = times_over_2_62(y, width)
    position = start + ahead
    slot = np.searchsorted(cells, position, side="right") - 1
    start = cells[slot]
    along = (position - start).astype(np.float64) + rest.astype(np.float64) * 2.0**-62
    return slot, u, fraction_word(along / (cells[slot + 1] - start).astype(np.float64))


def find_cells(index, lane, place_key, tree, keys, n_groups, tables):
    """Slots, places u and v (64-bit fractions) and decision words of photons.

    Parameters
    ----------
    index : ndarray, uint64
        Photons of the lane.
    lane, place_key : int, numpy.uint64
        Counter and key of the numbers below the scrambled levels.
    tree : ndarray
        See `component_points`.
    keys : list of ndarray, uint32, shape (2, 8, 2)
        Scrambling keys of each component.
    n_groups : list of int
        Groups of four levels that are scrambled in each; 0 for a beam, which is one direction.
    tables : list
        For each component with photons its first slot; the cumulative fixed-point masses of its rings
        (n_ring + 1,), 0 to 2^62; and of its cells (n_slot + 1,).
    """
    first, second = philox(place_key, index, lane, 0)
    word = (((first & k.REST_BITS) << k.REST_SHIFT) | (second & k.REST_BITS)) << k.ACCEPT_SHIFT
    component, point = component_points(index, tree)
    slot = np.zeros(index.size, np.int64)
    u, v = np.zeros(index.size, _U64), np.zeros(index.size, _U64)
    for c in np.unique(component):
        chosen = np.flatnonzero(component == c)
        groups = int(n_groups[c])
        if groups == 0:  # a beam needs no point
            slot[chosen] = tables[c][0]
            continue
        below = _U64(4 * groups)
        x, y = (scramble(p, keys[c][d], groups) for d, p in enumerate(plain_points(point[chosen].astype(_U32))))
        x = (x.astype(_U64) << _S32) | ((first[chosen] & k.PLACE_BITS) >> below)
        y = (y.astype(_U64) << _S32) | ((second[chosen] & k.PLACE_BITS) >> below)
        offset, *table = tables[c]
        found, u[chosen], v[chosen] = _find(x, y, table)
        slot[chosen] = found + offset
    return slot, u, v, word


def count_cells(n, counts, cell_of_slot, *address):
    """Add the photons [0, n) of a lane to the counts (n_cell,) of their cells; the rest as `find_cells`."""
    for start in range(0, n, 1 << 18):
        slot = find_cells(np.arange(start, min(n, start + (1 << 18)), dtype=_U64), *address)[0]
        counts += np.bincount(cell_of_slot[slot], minlength=counts.size)


def emit(start, address, cell_of_slot, cells, laws, perez, lobes, ux, uy, uz, cell):
    """Write the photons from `start` on.

    `address` holds what `find_cells` needs after the photons; `cells` (n_cell, 6) in the precision of the
    outputs; `laws` int8 (n_cell,); `perez` holds words and bounds (n_cell,) and the sky's numbers, or None; `lobes` the
    lobe of each cell and the tables of `plain_lobe`.
    """
    index = np.arange(start, start + ux.size, dtype=_U64)
    lane, key = address[:2]
    slot, u, v, word = find_cells(index, *address)
    cell[:] = cell_of_slot[slot]
    u, v = unit(u, ux.dtype), unit(v, ux.dtype)
    law = laws[cell]
    for code in np.unique(law):
        chosen = np.flatnonzero(law == code)
        p = tuple(cells[:, j][cell[chosen]] for j in range(6))
        if code == PEREZ and perez is not None:
            from aomc_sky.kernels.plain_perez import place_perez

            looked_up = (perez[0][cell[chosen]], perez[1][cell[chosen]], perez[2])
            directions = place_perez(p, looked_up, u[chosen], v[chosen], word[chosen], key, index[chosen], lane)
        elif code >= HG:
            from aomc_sky.kernels.plain_lobe import place_lobes, words_of_place

            words = None, words_of_place(u[chosen]), words_of_place(v[chosen]), word[chosen]
            directions = place_lobes(lobes[0][cell[chosen]], lobes[1], words, key, index[chosen], lane)
        else:
            directions = place(code, p, u[chosen], v[chosen], key, index[chosen], lane)
        ux[chosen], uy[chosen], uz[chosen] = directions
