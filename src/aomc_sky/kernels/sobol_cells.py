"""Which cell a photon of the Sobol method falls into, and where in it; and the counts that follow.

The first coordinate of a point settles the ring of patches, the second the column within it, both by
exact integer cumulatives; what is left of each is the place in the cell. Each component has a sequence of
its own; a tree of splits says whose turn it is. One simple loop per step, as in `emit`.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.constants import ACCEPT_SHIFT, PLACE_BITS, REST_BITS, REST_SHIFT
from aomc_sky.kernels.elementary import unit
from aomc_sky.kernels.emit import BLOCK, _cells_of_slots
from aomc_sky.kernels.jit import inlined, inner, kernel
from aomc_sky.kernels.rng import philox_pair
from aomc_sky.kernels.slots import slot_of_rank
from aomc_sky.kernels.sobol import sobol_range

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_S11 = np.uint64(11)
_S32 = np.uint64(32)
_S62 = np.uint64(62)
_LOW = np.uint64(0xFFFFFFFF)
_REST62 = np.uint64((1 << 62) - 1)
_NEVER = np.uint64(2**64 - 1)
_TO_53 = 2.0**53
_LARGEST_53 = np.int64(2**53 - 1)
_INV62 = 2.0**-62


@inner
def start_split(start, tree, rest, point):
    """State of `_split` before photon `start`: a remainder for each inner node, the next point of each leaf."""
    n_leaf = _U64(tree.size) >> _ONE
    index = np.zeros(tree.size, np.uint64)
    index[1] = start
    for node in range(_ONE, n_leaf):
        total, left = tree[node], tree[_TWO * node]
        product = index[node] * left + (total >> _ONE)
        before = product // total if total != _ZERO else _ZERO
        rest[node] = product - before * total
        index[_TWO * node] = before
        index[_TWO * node + _ONE] = index[node] - before
    for leaf in range(n_leaf):
        point[leaf] = index[n_leaf + leaf]


@inner
def _split(m, tree, rest, number, where):
    """Give the next m photons of a lane to its components.

    At each node photon i goes left where round(i left / total) steps, so that no prefix is off by more
    than half a photon there. `number` counts the photons of each leaf, `where` lists them, a row each.
    """
    n_leaf = _U64(tree.size) >> _ONE
    number[:] = _ZERO
    for j in range(m):
        node = _ONE
        while node < n_leaf:
            r = rest[node] + tree[_TWO * node]
            is_left = r >= tree[node]
            rest[node] = r - tree[node] if is_left else r
            node = _TWO * node + _U64(not is_left)
        leaf = node - n_leaf
        where[leaf * _U64(BLOCK) + number[leaf]] = j
        number[leaf] += _ONE


@inner
def _draw(first_photon, m, key, lane, first, second):
    """Two random words for each of m photons, for what lies below the scrambled levels."""
    for j in range(m):
        first[j], second[j] = philox_pair(key, first_photon + j, lane, _ZERO)


@inner
def decision_words(m, first, second, word):
    """The words that decide the first try of a rejection, from the bits that the places leave."""
    for j in range(m):
        word[j] = (((first[j] & REST_BITS) << REST_SHIFT) | (second[j] & REST_BITS)) << ACCEPT_SHIFT


@inlined
def _times_over_2_62(a, b):
    """Quotient and remainder of a b by 2^62 for numbers up to 2^62."""
    a0, a1, b0, b1 = a & _LOW, a >> _S32, b & _LOW, b >> _S32
    p00, p01, p10 = a0 * b0, a0 * b1, a1 * b0
    middle = (p00 >> _S32) + (p01 & _LOW) + (p10 & _LOW)
    low = (middle << _S32) | (p00 & _LOW)
    high = a1 * b1 + (p01 >> _S32) + (p10 >> _S32) + (middle >> _S32)
    return (high << _TWO) | (low >> _S62), low & _REST62


@inlined
def _float(a):
    return np.float64(np.int64(a))


@inlined
def _fraction_word(value):
    """A float in [0, 1] as a 64-bit fraction of 53 bits below 1."""
    return _U64(min(np.int64(value * _TO_53), _LARGEST_53)) << _S11


@inner
def _steps_of(m, place, ends, guide, shift, step, begin, end):
    """Ring or cell of m places in units of 2^-62, and where it begins and ends."""
    j = _ZERO
    while j < m:
        s = slot_of_rank(place[j], ends, guide, shift)
        step[j], begin[j], end[j] = s, ends[s], ends[s + _ONE]
        if s == _NEVER:  # an exit keeps the compiler from turning this loop into slow gathers
            break
        j += _ONE


@inner
def _along(m, point, below, word, place):
    """Coordinates in units of 2^-62: the scrambled levels of points, and random bits below them."""
    for j in range(m):
        place[j] = ((_U64(point[j]) << _S32) | ((word[j] & PLACE_BITS) >> below)) >> _TWO


@inner
def _rest_of_first(m, place, begin, end, u):
    for j in range(m):
        u[j] = unit(_fraction_word(_float(place[j] - begin[j]) / _float(end[j] - begin[j])), u[j])


@inner
def _into_ring(m, along, begin, end, place, rest):
    """Place in the ring of a share of its width, and the remainder in units of 2^-124."""
    for j in range(m):
        ahead, rest[j] = _times_over_2_62(along[j], end[j] - begin[j])
        place[j] = begin[j] + ahead


@inner
def _rest_of_second(m, place, rest, begin, end, v):
    for j in range(m):
        along = _float(place[j] - begin[j]) + _float(rest[j]) * _INV62
        v[j] = unit(_fraction_word(along / _float(end[j] - begin[j])), v[j])


@inner
def _find(m, x, y, below, table, first, second, memory, u, v):
    """Cells of points, counted from the component's first, in `memory[0]`, and the places in them.

    `first` and `second` hold random words for what lies below the scrambled levels.
    """
    rings, ring_guide, ring_shift, ends, guide, shift = table
    step, begin, end, place, rest = memory
    _along(m, x, below, first, place)
    _steps_of(m, place, rings, ring_guide, ring_shift, step, begin, end)
    _rest_of_first(m, place, begin, end, u)
    _along(m, y, below, second, step)
    _into_ring(m, step, begin, end, place, rest)
    _steps_of(m, place, ends, guide, shift, step, begin, end)
    _rest_of_second(m, place, rest, begin, end, v)


@inner
def _find_some(n, where, x, y, below, table, first, second, memory, own, u, v):
    """`_find` for the n photons that `where` lists."""
    own_first, own_second, own_u, own_v = own
    for i in range(n):
        own_first[i], own_second[i] = first[where[i]], second[where[i]]
    _find(n, x, y, below, table, own_first, own_second, memory, own_u, own_v)
    for i in range(n):
        u[where[i]], v[where[i]] = own_u[i], own_v[i]


@inner
def _component_table(c, tables):
    """The tables of one component: parts of flat arrays, by the positions in `at`."""
    at, rings, ring_guide, ends, guide = tables
    i = _U64(12) * c
    table = (
        rings[at[i] : at[i + _ONE]],
        ring_guide[at[i + _TWO] : at[i + _U64(3)]],
        at[i + _U64(4)],
        ends[at[i + _U64(5)] : at[i + _U64(6)]],
        guide[at[i + _U64(7)] : at[i + _U64(8)]],
        at[i + _U64(9)],
    )
    return table, at[i + _U64(10)], at[i + _U64(11)]


@inner
def scratch_of_cells(n_leaf, like):
    """State and memory of `cells_of_block`; places in the precision of the array `like`."""
    split = np.zeros(n_leaf, np.uint64), np.zeros(n_leaf, np.uint64), np.zeros(n_leaf, np.uint64)
    words = np.empty(BLOCK, np.uint64), np.empty(BLOCK, np.uint64)
    points = np.empty(BLOCK, np.uint32), np.empty(BLOCK, np.uint32), np.empty(BLOCK, np.uint32)
    steps = (
        np.empty(BLOCK, np.uint64),
        np.empty(BLOCK, np.uint64),
        np.empty(BLOCK, np.uint64),
        np.empty(BLOCK, np.uint64),
        np.empty(BLOCK, np.uint64),
    )
    own = (
        np.empty(BLOCK, np.uint64),
        np.empty(BLOCK, np.uint64),
        np.zeros(BLOCK, like.dtype),
        np.zeros(BLOCK, like.dtype),
    )
    return split, words, points, steps, np.empty(n_leaf * _U64(BLOCK), np.uint64), own


@inner
def _one_direction(n, is_all, where, first_slot, slot, u, v):
    """Photons of a beam need no point."""
    for i in range(n):
        j = _U64(i) if is_all else where[i]
        slot[j] = first_slot
        u[j], v[j] = 0, 0


@inner
def cells_of_block(photon, m, lane, key, tree, tops, keys, tables, memory, slot, u, v):
    """Slots of m photons from `photon` on, in order after the block before, and their places in the cells."""
    (rest, point, number), (first, second), (plain, x, y), steps, where, own = memory
    n_leaf = _U64(point.size)
    _draw(photon, m, key, lane, first, second)
    number[0] = m
    if n_leaf > _ONE:
        _split(m, tree, rest, number, where)
    for c in range(n_leaf):
        n = number[c]
        if n == _ZERO:
            continue
        places = where[c * _U64(BLOCK) : (c + _ONE) * _U64(BLOCK)]
        table, first_slot, n_groups = _component_table(c, tables)
        if n_groups == _ZERO:
            _one_direction(n, n == m, places, first_slot, slot, u, v)
            continue
        top = tops[c * _U64(8192) : (c + _ONE) * _U64(8192)]
        node_keys = keys[c * _U64(32) : (c + _ONE) * _U64(32)]
        sobol_range(point[c], n, top, node_keys, n_groups, plain, x, y)
        point[c] += n
        below = _U64(4) * n_groups
        if n == m:
            _find(m, x, y, below, table, first, second, steps, u, v)
            for j in range(m):
                slot[j] = steps[0][j] + first_slot
        else:
            _find_some(n, places, x, y, below, table, first, second, steps, own, u, v)
            for i in range(n):
                slot[places[i]] = steps[0][i] + first_slot


@kernel
def count_sobol(start, n, lane, key, tree, tops, keys, tables, cell_of_slot, counts):
    """Add the photons [start, start + n) of a lane to `counts` int64 (n_cell,); the rest as in `emit_sobol`."""
    u, v = np.zeros(BLOCK, np.float32), np.zeros(BLOCK, np.float32)
    memory = scratch_of_cells(_U64(tree.size) >> _ONE, u)
    slot = np.empty(BLOCK, np.int32)
    start_split(start, tree, memory[0][0], memory[0][1])
    for lo in range(_ZERO, n, _U64(BLOCK)):
        m = min(n - lo, _U64(BLOCK))
        cells_of_block(start + lo, m, lane, key, tree, tops, keys, tables, memory, slot, u, v)
        if cell_of_slot is not None:
            _cells_of_slots(m, cell_of_slot, slot)
        for j in range(m):
            counts[_U64(slot[j])] += 1
