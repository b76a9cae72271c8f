"""Photons of the lobes of background skies, in blocks; the law and the words are explained in `plain_lobe`.

The photons of lobes are picked out of a block and sorted by lobe, hence by kind, and what they need is laid side by
side: every loop over them vectorises but the look-up of their cells.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import plain_lobe
from aomc_sky.kernels.constants import ACCEPT, ACCEPT_SHIFT, LAST_TRIAL, PLACE_BITS, REST_BITS, REST_SHIFT
from aomc_sky.kernels.elementary import log_of_parts, sincos_turned, split_power
from aomc_sky.kernels.jit import inlined, inner, spliced
from aomc_sky.kernels.rng import philox_pair

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_S11 = np.uint64(11)
_S12 = np.uint64(12)
_S64 = np.uint64(64)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_INV53 = 2.0**-53
_TO_53 = 2.0**53
_CHUNK = np.uint64(256)
_FEW = np.uint64(3)
_LANES = np.uint64(31)
_WHOLE_VECTORS = np.uint64(0xFFFFFFFFFFFFFFE0)
_RANGE_COLUMNS = np.uint64(plain_lobe.RANGE_COLUMNS)
_CELL_COLUMNS = np.uint64(plain_lobe.CELL_COLUMNS)
_LOBE_COLUMNS = np.uint64(plain_lobe.LOBE_COLUMNS)

_shares = inlined(plain_lobe.shares)
_heights_hg = inlined(plain_lobe.heights_hg)
_world = inlined(plain_lobe.world)


@inner
def choose_lobes(m, slot, lobes, memory):
    """Photons of a block whose slot is a lobe, sorted by lobe, in `memory`; return how many."""
    lobe_of_slot, begin = lobes[0], memory[3]
    chosen, lobe, at, found = memory[0], memory[1], memory[4], memory[5]
    n, j = _ZERO, _ZERO
    while j < m:
        one = lobe_of_slot[_U64(slot[j])]
        at[n] = j
        found[n] = one
        n += _U64(one >= 0)
        j += _ONE
    for i in range(begin.size):
        begin[i] = 0
    for k in range(n):
        begin[_U64(found[k]) + _ONE] += _ONE
    for i in range(1, begin.size):
        begin[i] += begin[i - 1]
    k = _ZERO
    while k < n:
        one = _U64(found[k])
        to = begin[one]
        chosen[to] = at[k]
        lobe[to] = found[k]
        begin[one] = to + _ONE
        k += _ONE
    return n


@inner
def _ranks(n, chosen, rank, out):
    k = _ZERO
    while k < n:
        out[k] = _U64(rank[chosen[k]])
        k += _ONE


@inner
def lobe_words(n, rank, shifts, steps, accept, key, band, jitter, memory):
    """The three words of trial 0 of the n photons of `choose_lobes`."""
    first, second, third = memory[2]
    _ranks(n, memory[0], rank, first)
    if jitter is None:
        shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
        shift, step = accept[0], accept[1]
        for k in range(n):
            r = first[k]
            first[k] = shift_u + r * step_u
            second[k] = shift_v + r * step_v
            third[k] = shift + r * step
    else:
        for k in range(n):
            r = first[k]
            first[k], second[k] = philox_pair(key, r, band, _ZERO)
            third[k], _ = philox_pair(key, r, band, ACCEPT)


@inner
def lobe_words_of_places(n, u, v, word, memory):
    """The same from places in the cell and deciding words of the block."""
    chosen, (first, second, third) = memory[0], memory[2]
    for k in range(n):
        j = chosen[k]
        first[k] = _U64(np.int64(np.float64(u[j]) * _TO_53)) << _S11
        second[k] = _U64(np.int64(np.float64(v[j]) * _TO_53)) << _S11
        third[k] = word[j]


@inner
def _later_words(n, trial, key, band, first, second, third):
    """The three words of a later trial; `first` holds the ranks."""
    for k in range(n):
        first[k], second[k] = philox_pair(key, first[k], band, trial)
    for k in range(n):
        third[k] = (((first[k] & REST_BITS) << REST_SHIFT) | (second[k] & REST_BITS)) << ACCEPT_SHIFT
        first[k] &= PLACE_BITS
        second[k] &= PLACE_BITS


@inlined
def _uniform(word):
    return np.float64(np.int64(word >> _S11)) * _INV53


@inlined
def _whole(word, bits):
    """The upper 52 bits of a word without its first ones."""
    return np.float64(np.int64((word << bits) >> _S12))


@inlined
def _beckmann_radius(a, b):
    m, power = split_power(b)
    is_small = m < 0.7071067811865476
    f = (m + m if is_small else m) - 1.0
    k = power - (1.0 if is_small else 0.0)
    is_near = a < 0.25
    return np.sqrt(-log_of_parts(-a if is_near else f, 0.0 if is_near else k))


@spliced
def _try_one(lobe, first, second, ranges, bins, shapes, envelopes, kinds):
    """Direction of one photon from two words, and the bound of its bin."""
    r, s = _RANGE_COLUMNS * _U64(lobe), _LOBE_COLUMNS * _U64(lobe)
    bits = ranges[r + _ONE]
    found = bins[ranges[r] + (first >> (_S64 - bits))]
    c = _CELL_COLUMNS * (ranges[r + _TWO] + _U64(found >> _S16))
    least_b, width, least_a, count = envelopes[c], envelopes[c + _ONE], envelopes[c + _TWO], envelopes[c + _U64(3)]
    a, b = _shares(np.float64(found & _LOW16), _whole(first, bits), least_b, width, least_a, count)
    if lobe < kinds[0]:
        radius, z = _heights_hg(a, b, shapes[s + _U64(9)])
    elif lobe < kinds[1]:
        radius, z = np.sqrt(a), np.sqrt(b)
    else:
        radius, z = _beckmann_radius(a, b), 1.0
    half, t0, t1 = envelopes[c + _U64(4)], envelopes[c + _U64(5)], envelopes[c + _U64(6)]
    sine, cosine = sincos_turned(t0, t1, half, _uniform(second), None)
    m0, m1, m2, m3 = shapes[s], shapes[s + _ONE], shapes[s + _TWO], shapes[s + _U64(3)]
    m4, m5, m6, m8 = shapes[s + _U64(4)], shapes[s + _U64(5)], shapes[s + _U64(6)], shapes[s + _U64(8)]
    x, y, up = _world(radius, z, sine, cosine, m0, m1, m2, m3, m4, m5, m6, m8)
    return x, y, up, envelopes[c + _U64(7)]


@spliced
def _until_taken(lobe, ranges, bins, shapes, envelopes, kinds, trial, first, second, word, key, rank, band):
    """Direction of one photon from trial `trial` on, whose words are given."""
    while True:
        x, y, up, bound = _try_one(lobe, first, second, ranges, bins, shapes, envelopes, kinds)
        trial += _ONE
        if _uniform(word) * bound + up < 0.0 or trial >= LAST_TRIAL:
            return x, y, up
        first, second = philox_pair(key, rank, band, trial)
        word = (((first & REST_BITS) << REST_SHIFT) | (second & REST_BITS)) << ACCEPT_SHIFT
        first, second = first & PLACE_BITS, second & PLACE_BITS


@inner
def lobe_at(lobe, tables, trial, first, second, word, key, rank, band):
    """Travel direction (float64) of one photon from trial `trial` on, whose words are given; bits as in blocks."""
    ranges, bins, shapes, envelopes, kinds = tables
    return _until_taken(lobe, ranges, bins, shapes, envelopes, kinds, trial, first, second, word, key, rank, band)


@inner
def _gather(
    n, offset, lobe, first, ranges, bins, shapes, envelopes, part, b0, width, a0, count, half, t0, t1, bound,
    m0, m1, m2, m3, m4, m5, m6, m8, g,
):  # fmt: skip
    """Cells and lobes of n photons from `offset` on, side by side; what is left of first words replaces them."""
    k = _ZERO
    while k < n:
        one, word = _U64(lobe[offset + k]), first[offset + k]
        r, s = _RANGE_COLUMNS * one, _LOBE_COLUMNS * one
        bits = ranges[r + _ONE]
        found = bins[ranges[r] + (word >> (_S64 - bits))]
        at = _CELL_COLUMNS * (ranges[r + _TWO] + _U64(found >> _S16))
        first[offset + k] = word << bits
        part[k] = np.float64(found & _LOW16)
        b0[k], width[k], a0[k] = envelopes[at], envelopes[at + _ONE], envelopes[at + _TWO]
        count[k], half[k], t0[k] = envelopes[at + _U64(3)], envelopes[at + _U64(4)], envelopes[at + _U64(5)]
        t1[k], bound[k] = envelopes[at + _U64(6)], envelopes[at + _U64(7)]
        m0[k], m1[k], m2[k], m3[k] = shapes[s], shapes[s + _ONE], shapes[s + _TWO], shapes[s + _U64(3)]
        m4[k], m5[k], m6[k], m8[k] = shapes[s + _U64(4)], shapes[s + _U64(5)], shapes[s + _U64(6)], shapes[s + _U64(8)]
        g[k] = shapes[s + _U64(9)]
        if bits == _ZERO:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        k += _ONE


@inner
def _ends_of_kinds(n, offset, lobe, kinds):
    """How many of n photons, sorted by lobe, are of the first kind, and of the first two."""
    end_hg, end_ggx = _ZERO, _ZERO
    for k in range(offset, offset + n):
        end_hg += _U64(lobe[k] < kinds[0])
        end_ggx += _U64(lobe[k] < kinds[1])
    return end_hg, end_ggx


@inner
def _heights(n, offset, end_hg, end_ggx, first, part, b0, width, a0, count, g, a, b, radius, z):
    """R and Z of n photons, which stand in the order of the kinds."""
    for k in range(n):
        a[k], b[k] = _shares(part[k], _whole(first[offset + k], _ZERO), b0[k], width[k], a0[k], count[k])
    for k in range(end_hg):
        radius[k], z[k] = _heights_hg(a[k], b[k], g[k])
    for k in range(end_hg, end_ggx):
        radius[k], z[k] = np.sqrt(a[k]), np.sqrt(b[k])
    for k in range(end_ggx, n):
        radius[k], z[k] = _beckmann_radius(a[k], b[k]), 1.0


@inner
def _directions(
    n, offset, second, half, t0, t1, m0, m1, m2, m3, m4, m5, m6, m8, radius, z, sine, cosine, x, y, up
):  # fmt: skip
    """Directions of n photons."""
    for k in range(n):
        sine[k], cosine[k] = sincos_turned(t0[k], t1[k], half[k], _uniform(second[offset + k]), None)
    for k in range(n):
        x[k], y[k], up[k] = _world(
            radius[k], z[k], sine[k], cosine[k], m0[k], m1[k], m2[k], m3[k], m4[k], m5[k], m6[k], m8[k]
        )


@inner
def _whole_vectors(n):
    """The next multiple of 32: what a vector loop leaves over costs more than computing on stale memory."""
    return (n + _LANES) & _WHOLE_VECTORS


@inner
def _scatter(n, offset, chosen, x, y, up, ux, uy, uz):
    k = _ZERO
    while k < n:
        j = chosen[offset + k]
        ux[j], uy[j], uz[j] = x[k], y[k], up[k]
        k += _ONE


@inner
def _keep_rejected(n, offset, left, third, bound, up, chosen, lobe):
    """Move the rejected of a chunk to the front of all chosen photons; return how many stand there."""
    for k in range(n):
        bound[k] = _uniform(third[offset + k]) * bound[k] + up[k]
    k = _ZERO
    while k < n:
        chosen[left] = chosen[offset + k]
        lobe[left] = lobe[offset + k]
        left += _U64(bound[k] >= 0.0)
        k += _ONE
    return left


@inner
def place_lobes(n, lobes, rank, key, band, memory, ux, uy, uz):
    """Write the directions of the n photons that `choose_lobes` picked over those of a block.

    `lobes` is (lobe of each slot, tables of `plain_lobe`, ...); `memory` comes from `lobe_scratch` and holds the words
    of trial 0.
    """
    ranges, bins, shapes, envelopes, kinds = lobes[1]
    chosen, lobe, (first, second, third), _, _, _, cell, matrix, (g, a, b, radius, z, sine, cosine, x, y, up) = memory
    part, b0, width, a0, of_cell, half, t0, t1, bound = cell
    trial, count = _ZERO, n
    while count > _FEW and trial < LAST_TRIAL:
        left = _ZERO
        for lo in range(_ZERO, count, _CHUNK):
            m = min(_CHUNK, count - lo)
            whole = _whole_vectors(m)
            end_hg, end_ggx = _ends_of_kinds(m, lo, lobe, kinds)
            _gather(m, lo, lobe, first, ranges, bins, shapes, envelopes, *cell, *matrix, g)
            _heights(m, lo, end_hg, end_ggx, first, part, b0, width, a0, of_cell, g, a, b, radius, z)
            _directions(whole, lo, second, half, t0, t1, *matrix, radius, z, sine, cosine, x, y, up)
            _scatter(m, lo, chosen, x, y, up, ux, uy, uz)
            left = _keep_rejected(m, lo, left, third, bound, up, chosen, lobe)
        trial, count = trial + _ONE, left
        _ranks(count, chosen, rank, first)
        _later_words(count, trial, key, band, first, second, third)
    for k in range(count):
        j = chosen[k]
        r = _U64(rank[j])
        ux[j], uy[j], uz[j] = _until_taken(
            lobe[k], ranges, bins, shapes, envelopes, kinds, trial, first[k], second[k], third[k], key, r, band
        )


@inner
def lobe_scratch(n, lobes):
    """Scratch memory for blocks of n photons; what vector loops touch has room for whole vectors, and no zeros."""
    room, k = n + int(_LANES), int(_CHUNK + _LANES)
    return (
        np.zeros(room, np.uint64),
        np.zeros(room, np.int32),
        (np.zeros(room, np.uint64), np.zeros(room, np.uint64), np.zeros(room, np.uint64)),
        np.zeros(lobes[1][0].size // 4 + 1, np.uint64),
        np.zeros(room, np.uint64),
        np.zeros(room, np.int32),
        (
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
        ),
        (
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
        ),
        (
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
            np.ones(k),
        ),
    )
