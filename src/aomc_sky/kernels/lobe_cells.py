"""Photons of the lobes of background skies, in blocks; the law and the words are explained in `plain_lobe`.

The photons of lobes are picked out of a block and sorted by lobe, hence by kind, and what they need is laid side by
side: every loop over them vectorises but the look-up of their cells.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import plain_lobe
from aomc_sky.kernels.constants import ACCEPT, ACCEPT_SHIFT, LAST_TRIAL, PLACE_BITS, REST_BITS, REST_SHIFT
from aomc_sky.kernels.elementary import log_of_parts, sincos_turned, split_power
from aomc_sky.kernels.jit import inlined, inner
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
_FEW = np.uint64(4)
_LANES = np.uint64(7)
_WHOLE_VECTORS = np.uint64(0xFFFFFFFFFFFFFFF8)
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


@inner
def _of_lobe(lobe, tables):
    """First bin, binary logarithm of their number and first cell of a lobe, and its row of numbers."""
    ranges, _, shapes, _, _ = tables
    r, s = _RANGE_COLUMNS * _U64(lobe), _LOBE_COLUMNS * _U64(lobe)
    return ranges[r], ranges[r + _ONE], ranges[r + _TWO], shapes[s : s + _LOBE_COLUMNS]


@inner
def lobe_at(lobe, tables, trial, first, second, word, key, rank, band):
    """Travel direction (float64) of one photon from trial `trial` on, whose words are given; bits as in blocks."""
    bins, envelopes, kinds = tables[1], tables[3], tables[4]
    start, bits, cell, s = _of_lobe(lobe, tables)
    while True:
        one = bins[start + (first >> (_S64 - bits))]
        at = _CELL_COLUMNS * (cell + _U64(one >> _S16))
        c = envelopes[at : at + _CELL_COLUMNS]
        a, b = _shares(np.float64(one & _LOW16), _whole(first, bits), c[0], c[1], c[2], c[3])
        if lobe < kinds[0]:
            radius, z = _heights_hg(a, b, s[9])
        elif lobe < kinds[1]:
            radius, z = np.sqrt(a), np.sqrt(b)
        else:
            radius, z = _beckmann_radius(a, b), 1.0
        sine, cosine = sincos_turned(c[5], c[6], c[4], _uniform(second), None)
        x, y, up = _world(radius, z, sine, cosine, s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[8])
        trial += _ONE
        if _uniform(word) * c[7] + up < 0.0 or trial >= LAST_TRIAL:
            return x, y, up
        first, second = philox_pair(key, rank, band, trial)
        word = (((first & REST_BITS) << REST_SHIFT) | (second & REST_BITS)) << ACCEPT_SHIFT
        first, second = first & PLACE_BITS, second & PLACE_BITS


@inner
def _try_all(
    n, offset, lobe, first, second, ranges, bins, shapes, envelopes, kinds,
    part, b0, width, a0, count, half, t0, t1, bound, a, b, radius, z, sine, cosine, x, y, up,
):  # fmt: skip
    """Directions x, y, up and bounds of n photons from `offset` on, one lobe after the other.

    One function on purpose: handing arrays on for every lobe would cost more than the photons of most. Loops that
    vectorise go over whole vectors; what they write beyond a lobe's photons is written again by the next one.
    """
    k = _ZERO
    while k < n:
        one = lobe[offset + k]
        r, s = _RANGE_COLUMNS * _U64(one), _LOBE_COLUMNS * _U64(one)
        start, bits, cell = ranges[r], ranges[r + _ONE], ranges[r + _TWO]
        end = k
        while end < n and lobe[offset + end] == one:
            found = bins[start + (first[offset + end] >> (_S64 - bits))]
            at = _CELL_COLUMNS * (cell + _U64(found >> _S16))
            part[end] = np.float64(found & _LOW16)
            b0[end], width[end], a0[end] = envelopes[at], envelopes[at + _ONE], envelopes[at + _TWO]
            count[end], half[end], t0[end] = envelopes[at + _U64(3)], envelopes[at + _U64(4)], envelopes[at + _U64(5)]
            t1[end], bound[end] = envelopes[at + _U64(6)], envelopes[at + _U64(7)]
            end += _ONE
        whole = k + ((end - k + _LANES) & _WHOLE_VECTORS)
        for i in range(k, whole):
            a[i], b[i] = _shares(part[i], _whole(first[offset + i], bits), b0[i], width[i], a0[i], count[i])
        if one < kinds[0]:
            g = shapes[s + _U64(9)]
            for i in range(k, whole):
                radius[i], z[i] = _heights_hg(a[i], b[i], g)
        elif one < kinds[1]:
            for i in range(k, whole):
                radius[i], z[i] = np.sqrt(a[i]), np.sqrt(b[i])
        else:
            for i in range(k, whole):
                radius[i], z[i] = _beckmann_radius(a[i], b[i]), 1.0
        for i in range(k, whole):
            sine[i], cosine[i] = sincos_turned(t0[i], t1[i], half[i], _uniform(second[offset + i]), None)
        m0, m1, m2, m3 = shapes[s], shapes[s + _ONE], shapes[s + _TWO], shapes[s + _U64(3)]
        m4, m5, m6, m8 = shapes[s + _U64(4)], shapes[s + _U64(5)], shapes[s + _U64(6)], shapes[s + _U64(8)]
        for i in range(k, whole):
            x[i], y[i], up[i] = _world(radius[i], z[i], sine[i], cosine[i], m0, m1, m2, m3, m4, m5, m6, m8)
        k = end


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
    chosen, lobe, (first, second, third), _, _, _, cell, (a, b, radius, z, sine, cosine, x, y, up) = memory
    bound, place = cell[8], (*cell, a, b, radius, z, sine, cosine, x, y, up)
    trial, count = _ZERO, n
    while count > _FEW and trial < LAST_TRIAL:
        left = _ZERO
        for lo in range(_ZERO, count, _CHUNK):
            m = min(_CHUNK, count - lo)
            _try_all(m, lo, lobe, first, second, ranges, bins, shapes, envelopes, kinds, *place)
            _scatter(m, lo, chosen, x, y, up, ux, uy, uz)
            left = _keep_rejected(m, lo, left, third, bound, up, chosen, lobe)
        trial, count = trial + _ONE, left
        _ranks(count, chosen, rank, first)
        _later_words(count, trial, key, band, first, second, third)
    for k in range(count):
        j = chosen[k]
        words_of = first[k], second[k], third[k]
        ux[j], uy[j], uz[j] = lobe_at(lobe[k], lobes[1], trial, *words_of, key, _U64(rank[j]), band)


@inner
def lobe_scratch(n, lobes):
    """Scratch memory for blocks of n photons; what vector loops touch has room for whole vectors."""
    room, k = n + 8, int(_CHUNK) + 8
    return (
        np.zeros(room, np.uint64),
        np.zeros(room, np.int32),
        (np.zeros(room, np.uint64), np.zeros(room, np.uint64), np.zeros(room, np.uint64)),
        np.zeros(lobes[1][0].size // 4 + 1, np.uint64),
        np.zeros(room, np.uint64),
        np.zeros(room, np.int32),
        (
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
        ),
        (
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
            np.zeros(k),
        ),
    )
