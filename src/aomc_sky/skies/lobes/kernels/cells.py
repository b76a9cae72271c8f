"""Directions of photons of one lobe at a time; `law` explains the law and the words.

Their numbers lie side by side, so every loop vectorises but the look-up of their cells and the writing. No function
here makes an array: numba then counts no references to its arguments, which costs more than a loop over few photons.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT, LAST_TRIAL, LOBE_COLUMN, ONE, TWO, U32, U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import sincos_turned, uniform_f64
from aomc_sky.kernels.arithmetic.prefetch import prefetch_to_read, prefetch_to_write
from aomc_sky.kernels.arithmetic.rng import later_words, philox_pair
from aomc_sky.kernels.cells.blocks import column, whole_vectors
from aomc_sky.kernels.jit import inner, inner_no_refcount, view_as
from aomc_sky.skies.lobes.kernels.law import (
    CELL_COLUMNS,
    LOBE_COLUMNS,
    RANGE_COLUMNS,
    beckmann_radius,
    bin_of_rank,
    decision_by_rank,
    heights_hg,
    place_of,
    shares,
    world,
)
from aomc_sky.skies.lobes.kernels.queue import (
    AHEAD,
    OVERHANG,
    QUEUE_SIZE,
    append_photons,
    back_to_front,
    bin_proposal,
    bins_by_rank,
    lobe_queues,
    photons_of_lobes,
    words_of_photons,
)

_S64 = np.uint64(64)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_P1 = TWO * (QUEUE_SIZE + U64(36))  # rows of pairs; a power of two would let them collide in the cache
_P2 = TWO * _P1
_P3 = U64(3) * _P1
NO_NUMBER = U64(0xFFFFFFFFFFFFFFFF)
_NO_CELL = U64(0xFFFFFFFFFFFFFFFF)
_NO_BIN = np.uint32(0xFFFFFFFF)
_RANGE_COLUMNS = np.uint64(RANGE_COLUMNS)
_CELL_COLUMNS = np.uint64(CELL_COLUMNS)
_LOBE_COLUMNS = np.uint64(LOBE_COLUMNS)


@inner_no_refcount
def _try_one(lobe, number, first, second, ranges, bins, shapes, envelopes, kinds):
    """Direction of one photon from two words, and the bound of its bin; `number` as for `_until_taken`."""
    r, s = _RANGE_COLUMNS * U64(lobe), _LOBE_COLUMNS * U64(lobe)
    bits = ranges[r + ONE]
    is_named = number == NO_NUMBER
    word = bins[ranges[r] + (first >> (_S64 - bits) if is_named else number)]
    c = _CELL_COLUMNS * (ranges[r + TWO] + U64(word >> _S16))
    least_b, width, least_a, count = envelopes[c], envelopes[c + ONE], envelopes[c + TWO], envelopes[c + U64(3)]
    part, span = (np.float64(word & _LOW16), 1.0) if is_named else (0.0, count)
    a, b = shares(part, span, place_of(first, bits if is_named else ZERO), least_b, width, least_a, count)
    if lobe < kinds[0]:
        radius, z = heights_hg(a, b, shapes[s + U64(8)])
    elif lobe < kinds[1]:
        radius, z = np.sqrt(a), np.sqrt(b)
    else:
        radius, z = beckmann_radius(a, b), 1.0
    half, t0, t1 = envelopes[c + U64(4)], envelopes[c + U64(5)], envelopes[c + U64(6)]
    sine, cosine = sincos_turned(t0, t1, half, uniform_f64(second))
    m0, m1, m2, m3 = shapes[s], shapes[s + ONE], shapes[s + TWO], shapes[s + U64(3)]
    m4, m5, m6, m8 = shapes[s + U64(4)], shapes[s + U64(5)], shapes[s + U64(6)], shapes[s + U64(7)]
    x, y, up = world(radius, z, sine, cosine, m0, m1, m2, m3, m4, m5, m6, m8)
    return x, y, up, envelopes[c + U64(7)]


@inner_no_refcount
def _until_taken(lobe, ranges, bins, shapes, envelopes, kinds, number, first, second, word, key, rank, band):
    """Travel direction (float64) of one photon whose words of trial 0 are given; bits as in blocks.

    It lies in the cell of bin `number`; NO_NUMBER where the first word names the bin.
    """
    trial = ZERO
    while True:
        x, y, up, bound = _try_one(lobe, number, first, second, ranges, bins, shapes, envelopes, kinds)
        trial += ONE
        if uniform_f64(word) * bound + up < 0.0 or trial >= LAST_TRIAL:
            return x, y, up
        first, second, word = later_words(key, rank, band, trial)
        number = NO_NUMBER


@inner
def lobe_photon(lobe, first, second, rank, lobes, key, band, jitter):
    """Direction of a photon whose place has two words; `jitter` is None where they follow from its rank."""
    ranges, bins, shapes, envelopes, kinds = lobes[1]
    if jitter is None:
        number, accept = bin_of_rank(rank, *bin_proposal(lobe, lobes[3])), lobes[2]
        word = decision_by_rank(rank, accept[0], accept[1], accept[2])
    else:
        number = NO_NUMBER
        word, _ = philox_pair(key, rank, band, ACCEPT)
    return _until_taken(lobe, ranges, bins, shapes, envelopes, kinds, number, first, second, word, key, rank, band)


@inner_no_refcount
def _named_bins(n, first, bits, bin0, at):
    """Bins that words name, of n photons of a lobe whose first one is `bin0`."""
    down = _S64 - bits
    for k in range(n):
        at[k] = bin0 + (first[k] >> down)


@inner_no_refcount
def _cells(n, at, cell0, bins, envelopes, words, rows):
    """Cells of n photons in rows of pairs side by side, and the numbers of their bins in them; `at` is used up."""
    k = ZERO
    while k < n:
        word = bins[at[k]]
        c = _CELL_COLUMNS * (cell0 + U64(word >> _S16))
        prefetch_to_read(envelopes, c)
        words[k], at[k] = word, c
        if word == _NO_BIN:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        k += ONE
    k = ZERO
    while k < n:
        c, i = at[k], TWO * k
        rows[i], rows[i + ONE] = envelopes[c], envelopes[c + ONE]
        rows[i + _P1], rows[i + _P1 + ONE] = envelopes[c + TWO], envelopes[c + U64(3)]
        rows[i + _P2], rows[i + _P2 + ONE] = envelopes[c + U64(4)], envelopes[c + U64(5)]
        rows[i + _P3], rows[i + _P3 + ONE] = envelopes[c + U64(6)], envelopes[c + U64(7)]
        if c == _NO_CELL:  # never
            break
        k += ONE


@inner_no_refcount
def _shares_in_bins(n, first, bits, words, rows, a, b):
    """Shares of the lobe nearer to and farther from the axis of n photons whose words name their bins."""
    for k in range(n):
        i = TWO * k
        part = np.float64(np.int32(words[k] & _LOW16))
        t = place_of(first[k], bits)
        a[k], b[k] = shares(part, 1.0, t, rows[i], rows[i + ONE], rows[i + _P1], rows[i + _P1 + ONE])


@inner_no_refcount
def _shares_in_cells(again, n, first, rows, a, b):
    """The same of the photons from `again` on, whose words are the place in the whole cell."""
    for k in range(again, again + whole_vectors(n - again)):
        i = TWO * k
        count = rows[i + _P1 + ONE]
        a[k], b[k] = shares(0.0, count, place_of(first[k], ZERO), rows[i], rows[i + ONE], rows[i + _P1], count)


@inner_no_refcount
def _heights(n, lobe, kinds, g, a, b, radius, z):
    """R and Z of n photons of a lobe."""
    if lobe < U64(kinds[0]):
        for k in range(n):
            radius[k], z[k] = heights_hg(a[k], b[k], g)
    elif lobe < U64(kinds[1]):
        for k in range(n):
            radius[k], z[k] = np.sqrt(a[k]), np.sqrt(b[k])
    else:
        for k in range(n):
            radius[k], z[k] = beckmann_radius(a[k], b[k]), 1.0


@inner_no_refcount
def _azimuths(n, second, third, rows, sine, cosine, excess):
    """Sines and cosines of n photons, and their deciding numbers x bound."""
    for k in range(n):
        i = TWO * k
        v = uniform_f64(second[k])
        sine[k], cosine[k] = sincos_turned(rows[i + _P2 + ONE], rows[i + _P3], rows[i + _P2], v)
        excess[k] = uniform_f64(third[k]) * rows[i + _P3 + ONE]


@inner_no_refcount
def _directions(n, s, shapes, radius, z, sine, cosine, excess, x, y, up):
    """Directions of n photons of a lobe, and which are rejected: those whose excess is not negative."""
    m0, m1, m2, m3 = shapes[s], shapes[s + ONE], shapes[s + TWO], shapes[s + U64(3)]
    m4, m5, m6, m8 = shapes[s + U64(4)], shapes[s + U64(5)], shapes[s + U64(6)], shapes[s + U64(7)]
    for k in range(n):
        x[k], y[k], w = world(radius[k], z[k], sine[k], cosine[k], m0, m1, m2, m3, m4, m5, m6, m8)
        up[k] = w
        excess[k] += w


@inner_no_refcount
def _scatter(n, at, excess, x, y, up, ux, uy, uz, rejected):
    """Write n directions over those of a call; return how many are rejected, and which."""
    size = U64(ux.size)
    left, k = ZERO, ZERO
    while k < n:
        j = U64(at[k])
        if j >= size:  # never: an exit keeps the compiler from slow scatters
            break
        ux[j], uy[j], uz[j] = x[k], y[k], up[k]
        ahead = U64(at[k + AHEAD])
        prefetch_to_write(ux, ahead)
        prefetch_to_write(uy, ahead)
        prefetch_to_write(uz, ahead)
        rejected[left] = k
        left += U64(excess[k] >= 0.0)
        k += ONE
    return left


@inner_no_refcount
def _place_queue(lobe, lobes, steps, key, band, jitter, memory, ux, uy, uz):
    """One trial of each photon of a queue."""
    ranges, bins, shapes, envelopes, kinds = lobes[1]
    size, retries, all_at, all_rank, all_trial, _ = memory[0]
    first, second, third, rejected, at_bin = memory[1]
    words, rows, (a, b, radius, z, sine, cosine, excess), (x, y, up) = memory[2:]
    n, again, lo, hi = size[lobe], retries[lobe], lobe * QUEUE_SIZE, (lobe + ONE) * QUEUE_SIZE
    at, rank, trial = all_at[lo : hi + AHEAD], all_rank[lo : hi + OVERHANG], all_trial[lo:hi]
    words_of_photons(again, n, rank, trial, steps, key, band, jitter, first, second, third)
    r, s = _RANGE_COLUMNS * lobe, _LOBE_COLUMNS * lobe
    bin0, bits, cell0 = ranges[r], ranges[r + ONE], ranges[r + TWO]
    whole = whole_vectors(n)
    if jitter == ZERO:
        _named_bins(whole_vectors(again), first, bits, bin0, at_bin)
        bins_by_rank(lobe, again, n, rank, bin0, steps[3], at_bin)
        _cells(n, at_bin, cell0, bins, envelopes, words, rows)
        _shares_in_bins(whole_vectors(again), first, bits, words, rows, a, b)
        _shares_in_cells(again, n, first, rows, a, b)
    else:
        _named_bins(whole, first, bits, bin0, at_bin)
        _cells(n, at_bin, cell0, bins, envelopes, words, rows)
        _shares_in_bins(whole, first, bits, words, rows, a, b)
    _heights(whole, lobe, kinds, shapes[s + U64(8)], a, b, radius, z)
    _azimuths(whole, second, third, rows, sine, cosine, excess)
    _directions(whole, s, shapes, radius, z, sine, cosine, excess, x, y, up)
    n_rejected = _scatter(n, at, excess, x, y, up, ux, uy, uz, rejected)
    left = back_to_front(n_rejected, rejected, again, at, rank, trial)
    size[lobe], retries[lobe] = left, left


@inner_no_refcount
def place_lobes(lo, m, slot, rank, lobes, steps, key, band, jitter, memory, ux, uy, uz):
    """Take in the photons of a block whose slot is a lobe, and work off the queues that are full.

    `lobes` is (lobe of each slot, tables of `law`, ...); `memory` comes from `lobe_scratch`. Directions are
    written over those of the whole call, in which the block begins at photon `lo`. For `steps` see
    `words_of_photons`.
    """
    queues = memory[0]
    photons, size = queues[5], queues[0]
    n = photons_of_lobes(m, slot, lobes, photons)
    k = ZERO
    while k < n:
        k, full = append_photons(k, n, lo, photons, slot, rank, lobes[0], queues)
        while full >= 0 and size[U64(full)] == QUEUE_SIZE:
            _place_queue(U64(full), lobes, steps, key, band, jitter, memory, ux, uy, uz)


@inner_no_refcount
def place_the_rest(lobes, steps, key, band, jitter, memory, ux, uy, uz):
    """Work off all queues, after the last block of a call."""
    size = memory[0][0]
    for lobe in range(U64(size.size)):
        while size[lobe] > ZERO:
            _place_queue(lobe, lobes, steps, key, band, jitter, memory, ux, uy, uz)


@inner_no_refcount
def _columns(memory, like):
    """Columns of the photons of a queue: five of words, one of short words, seven and three of floats, and rows."""
    short, one, size = U32(0), np.float64(0), U64(LOBE_COLUMN)
    floats = memory[U64(6) * size :]
    return (
        (
            column(memory, ZERO, size, ZERO),
            column(memory, ONE, size, ZERO),
            column(memory, TWO, size, ZERO),
            column(memory, U64(3), size, ZERO),
            column(memory, U64(4), size, ZERO),
        ),
        column(memory, U64(5), size, short),
        view_as(floats[U64(10) * size :], one),
        (
            column(floats, ZERO, size, one),
            column(floats, ONE, size, one),
            column(floats, TWO, size, one),
            column(floats, U64(3), size, one),
            column(floats, U64(4), size, one),
            column(floats, U64(5), size, one),
            column(floats, U64(6), size, one),
        ),
        (
            column(floats, U64(7), size, like),
            column(floats, U64(8), size, like),
            column(floats, U64(9), size, like),
        ),
    )


@inner_no_refcount
def lobe_scratch(memory, rank, lobes, like):
    """Scratch memory of a call whose directions are like `like`, in words; ranks of photons are like `rank`.

    Arrays of vector loops have room for whole vectors, and numbers other than zero.
    """
    queues, rest = lobe_queues(memory, rank, U64(lobes[1][0].size) // _RANGE_COLUMNS)
    words, found, rows, floats, directions = _columns(rest, like)
    for values in floats:
        values[:] = 1.0
    rows[:] = 1.0
    return queues, words, found, rows, floats, directions
