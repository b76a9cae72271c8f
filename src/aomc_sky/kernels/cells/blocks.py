"""From a rank to the parameters of a cell, on the way to the photons of a block.

A slot is a cell with photons. A guide table and at most a few steps find the slot of a rank. The parameters of a slot
are a head and a tail of four floats each, moved as 64-bit words. The head belongs to the ring: the first three
parameters and the *ring offset*, an integer. The tail belongs to the column: sine and cosine of the centre, half the
width, and an unused float. One table of words holds heads and tails, with two words for four float32 and four for four
float64.

The scratch memory has a column for each parameter of a block's photons, in the order h0, h1, h2, ring offset, t0, t1,
h3. So vector loops read it without shuffles; see `columns`.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import FOUR, LOW32, ONE, S32, SCRATCH_PHOTONS, THREE, TWO, U32, U64, ZERO
from aomc_sky.kernels.cells.laws import sloped
from aomc_sky.kernels.cells.order import SHORT_LIMIT, permute_long, permute_short
from aomc_sky.kernels.formula import by_width
from aomc_sky.kernels.jit import inline_always, inner_no_refcount, view_as

MAX_PHOTONS = np.uint64(SCRATCH_PHOTONS)
"""Most photons of a block. Loops with this bound vectorise, because 16 bytes times the index cannot wrap."""

_COLUMN = np.uint64(SCRATCH_PHOTONS)
_FIVE, _SIX = np.uint64(5), np.uint64(6)
_CHUNK = np.uint64(256)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_HIGH32 = np.uint64(0xFFFFFFFF00000000)


@inner_no_refcount
def fill_parameters(columns, lo, hi, words, head, tail, slot, s):
    """Write the parameters of slot s to the columns of the photons lo to hi - 1, and s to `slot`.

    The columns are seen as integers of the precision's width.
    """
    per_word = np.uint64(8) // np.uint64(columns.itemsize)
    numbers, h, t = view_as(words, columns[0]), head * per_word, tail * per_word
    a, b, c, d = numbers[h], numbers[h + ONE], numbers[h + TWO], numbers[h + THREE]
    e, f, g = numbers[t], numbers[t + ONE], numbers[t + TWO]
    for j in range(lo, min(hi, MAX_PHOTONS)):
        columns[j] = a
        columns[j + _COLUMN] = b
        columns[j + TWO * _COLUMN] = c
        columns[j + THREE * _COLUMN] = d
        columns[j + FOUR * _COLUMN] = e
        columns[j + _FIVE * _COLUMN] = f
        columns[j + _SIX * _COLUMN] = g
        slot[j] = s


@inner_no_refcount
def cell_of_photon(p, j):
    """The six parameters h0, h1, h2, h3, t0, t1 of photon j from the scratch memory p, seen as floats."""
    c = _COLUMN
    return p[j], p[j + c], p[j + TWO * c], p[j + _SIX * c], p[j + FOUR * c], p[j + _FIVE * c]


_NO_SLOPE = np.uint64(1 << 63)


@inner_no_refcount
def place_on_slopes(m, slot, word_of_slot, word, u, v):
    """`sloped` for a block; `word` is scratch memory."""
    j = ZERO
    while j < m:
        w = word_of_slot[U64(slot[j])]
        word[j] = w
        if w == _NO_SLOPE:  # never; see `cells_of_slots`
            break
        j += ONE
    for j in range(min(m, MAX_PHOTONS)):
        u[j], v[j] = sloped(u[j], v[j], word[j])


@inner_no_refcount
def whole_vectors(n):
    """The next multiple of 32: what a vector loop leaves over costs more than computing on stale memory."""
    return (n + U64(31)) & U64(0xFFFFFFFFFFFFFFE0)


@inline_always
def column(memory, number, size, like):
    """Column `number` (uint64) of a memory of uint64 words whose columns have `size` words, as numbers like `like`."""
    start = number * size
    return view_as(memory[start : start + size], like)


@inner_no_refcount
def cell_of_table(values, head, tail):
    """The same six from the table of words, seen as floats."""
    per_word = np.uint64(8) // np.uint64(values.itemsize)
    h, t = head * per_word, tail * per_word
    return values[h], values[h + ONE], values[h + TWO], values[t + TWO], values[t], values[t + ONE]


#: An integer type as wide as `like`, for the ring offsets of photons.
word_like = by_width(lambda like: U32(0), lambda like: U64(0))

#: The offset of photon j's ring, a 64-bit fraction, from the scratch memory seen as `word_like` numbers: (bits, j).
ring_offset_of_photon = by_width(
    lambda bits, j: np.uint64(bits[j + THREE * _COLUMN]) << S32,
    lambda bits, j: bits[j + THREE * _COLUMN],
    of=0,
)

#: The ring offset of a head of the table of words; `like` is any number of the precision.
ring_offset_of_table = by_width(
    lambda words, head, like: words[head + ONE] & _HIGH32, lambda words, head, like: words[head + THREE]
)

#: Positions of a cell's head and tail in the table of words: the two halves of a 32- or 64-bit word.
split_place = by_width(
    lambda word: (np.uint64(word >> _S16), np.uint64(word & _LOW16)), lambda word: (word >> S32, word & LOW32)
)


@inner_no_refcount
def _ranks_short(start, m, order, rank):
    """A rank beyond the end is permuted again; most chunks have none."""
    last, s, b = U32(order[0] - ONE), U32(order[1]), U32(order[2])
    k0, k1, k2 = U32(order[3]), U32(order[4]), U32(order[5])
    for lo in range(ZERO, m, _CHUNK):
        part = rank[lo : min(lo + _CHUNK, m)]
        first = U32(start + lo)
        beyond = U32(0)
        for j in range(part.size):
            r = permute_short(U32(first + U32(j)), s, b, k0, k1, k2)
            part[j] = r
            beyond = U32(beyond | U32(r > last))
        if beyond != U32(0):
            for j in range(part.size):
                r = U32(part[j])
                while r > last:
                    r = permute_short(r, s, b, k0, k1, k2)
                part[j] = r


@inner_no_refcount
def _ranks_long(start, m, order, rank):
    n, s, b = order[0], order[1], order[2]
    k0, k1, k2 = U32(order[3]), U32(order[4]), U32(order[5])
    for j in range(m):
        r = permute_long(start + U64(j), s, b, k0, k1, k2)
        while r >= n:
            r = permute_long(r, s, b, k0, k1, k2)
        rank[j] = r


@inner_no_refcount
def ranks_of_block(start, m, order, rank):
    """Write the ranks of the photons [start, start + m), uint64; `order` is `StreamWords.order`."""
    if order[0] <= SHORT_LIMIT:
        _ranks_short(start, m, order, rank)
    else:
        _ranks_long(start, m, order, rank)


@inner_no_refcount
def rank_of_photon(i, order):
    """Rank of one photon, uint64; `order` is `StreamWords.order` as a tuple."""
    n, s, b, k0, k1, k2 = order
    if n <= SHORT_LIMIT:
        last = U32(n - ONE)
        r = permute_short(U32(i), U32(s), U32(b), U32(k0), U32(k1), U32(k2))
        while r > last:
            r = permute_short(r, U32(s), U32(b), U32(k0), U32(k1), U32(k2))
        return U64(r)
    r = permute_long(i, s, b, U32(k0), U32(k1), U32(k2))
    while r >= n:
        r = permute_long(r, s, b, U32(k0), U32(k1), U32(k2))
    return r


@inner_no_refcount
def slot_of_rank(r, cumulative, guide, shift):
    """Slot of one rank, uint64; the first step is without a branch."""
    s = U64(guide[U64(r) >> shift])
    if r >= cumulative[s + TWO]:
        s += TWO
        while r >= cumulative[s + ONE]:
            s += ONE
        return s
    return s + U64(r >= cumulative[s + ONE])


@inner_no_refcount
def cells_of_slots(m, cell_of_slot, cell):
    """Replace the slots of a block by the numbers of their cells."""
    j = ZERO
    while j < m:
        c = cell_of_slot[U64(cell[j])]
        if c < 0:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        cell[j] = c
        j += ONE
