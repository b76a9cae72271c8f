"""Photons of the lobes of background skies, in blocks; the law and the words are explained in `plain_lobe`.

The photons of lobes are picked out of a block and worked on side by side, trial after trial, so that every loop vectorises
but the gathers and Beckmann's logarithm.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels import plain_lobe
from aomc_sky.kernels.constants import ACCEPT, ACCEPT_SHIFT, LAST_TRIAL, PLACE_BITS, REST_BITS, REST_SHIFT
from aomc_sky.kernels.elementary import log, log_of_parts, sincos_turned
from aomc_sky.kernels.jit import inlined, inner
from aomc_sky.kernels.rng import philox_pair

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_S11 = np.uint64(11)
_S12 = np.uint64(12)
_S64 = np.uint64(64)
_INV53 = 2.0**-53
_TO_53 = 2.0**53
_CHUNK = np.uint64(128)
_FEW = np.uint64(6)
_BIN_COLUMNS = np.uint64(plain_lobe.BIN_COLUMNS)
_LOBE_COLUMNS = np.uint64(plain_lobe.LOBE_COLUMNS)
_IS_HG = np.uint64(plain_lobe.IS_HG)
_IS_BECKMANN = np.uint64(plain_lobe.IS_BECKMANN)

_shares = inner(plain_lobe.shares)
_heights = inner(plain_lobe.heights)
_world = inlined(plain_lobe.world)


@inner
def choose_lobes(m, slot, lobe_of_slot, chosen, lobe):
    """Photons of a block whose slot is a lobe, and their lobes; no branch."""
    n, j = _ZERO, _ZERO
    while j < m:
        found = lobe_of_slot[_U64(slot[j])]
        chosen[n] = j
        lobe[n] = found
        n += _U64(found >= 0)
        j += _ONE
    return n


@inner
def lobe_words(n, chosen, rank, shifts, steps, accept, key, band, jitter, words):
    """The three words of trial 0 of n chosen photons."""
    first, second, third = words
    for k in range(n):
        r = _U64(rank[chosen[k]])
        if jitter is None:
            first[k] = shifts[0] + r * steps[0]
            second[k] = shifts[1] + r * steps[1]
            third[k] = accept[0] + r * accept[1]
        else:
            first[k], second[k] = philox_pair(key, r, band, _ZERO)
            third[k], _ = philox_pair(key, r, band, ACCEPT)


@inner
def lobe_words_of_places(n, chosen, u, v, word, words):
    """The same from places in the cell and deciding words of the block."""
    first, second, third = words
    for k in range(n):
        j = chosen[k]
        first[k] = _U64(np.int64(np.float64(u[j]) * _TO_53)) << _S11
        second[k] = _U64(np.int64(np.float64(v[j]) * _TO_53)) << _S11
        third[k] = word[j]


@inner
def _later_words(key, rank, band, trial):
    """The three words of a later trial."""
    first, second = philox_pair(key, rank, band, trial)
    third = (((first & REST_BITS) << REST_SHIFT) | (second & REST_BITS)) << ACCEPT_SHIFT
    return first & PLACE_BITS, second & PLACE_BITS, third


@inner
def _beckmann_radius(a, b):
    return np.sqrt(-log_of_parts(-a, 0)) if a < 0.25 else np.sqrt(-log(b))


@inner
def lobe_at(lobe, tables, trial, first, second, word, key, rank, band):
    """Travel direction (float64) of one photon from trial `trial` on, whose words are given; the same bits as the block's."""
    ranges, shapes, bins = tables
    i = _U64(lobe)
    start, bits = ranges[_TWO * i], ranges[_TWO * i + _ONE]
    s = shapes[_LOBE_COLUMNS * i : _LOBE_COLUMNS * (i + _ONE)]
    while True:
        at = _BIN_COLUMNS * (start + (first >> (_S64 - bits)))
        c = bins[at : at + _BIN_COLUMNS]
        a, b = _shares(np.float64(np.int64((first << bits) >> _S12)), c[0], c[1], c[2])
        if s[_IS_BECKMANN] == 1.0:
            radius, z = _beckmann_radius(a, b), 1.0
        else:
            radius, z = _heights(a, b, s[9], s[10], s[11], s[12], s[13])
        sine, cosine = sincos_turned(c[4], c[5], c[3], np.float64(np.int64(second >> _S11)) * _INV53, None)
        x, y, up = _world(radius, z, sine, cosine, s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[8])
        trial += _ONE
        if np.float64(np.int64(word >> _S11)) * _INV53 * c[6] < -up or trial >= LAST_TRIAL:
            return x, y, up
        first, second, word = _later_words(key, rank, band, trial)


@inner
def _gather(n, lobe, tables, words, columns, rest):
    """Bins and lobes of n photons side by side: the columns of both, the bits of the place in b, where the bin is."""
    ranges, shapes, bins = tables
    first, _, _ = words
    k = _ZERO
    while k < n:
        i = _U64(lobe[k])
        bits = ranges[_TWO * i + _ONE]
        at = _BIN_COLUMNS * (ranges[_TWO * i] + (first[k] >> (_S64 - bits)))
        rest[k] = (first[k] << bits) >> _S12
        for c in range(_BIN_COLUMNS):
            columns[c * _CHUNK + k] = bins[at + c]
        for c in range(_LOBE_COLUMNS):
            columns[(c + _BIN_COLUMNS) * _CHUNK + k] = shapes[_LOBE_COLUMNS * i + c]
        k += _ONE


@inner
def _column(columns, c):
    start = _U64(c) * _CHUNK
    return columns[start : start + _CHUNK]


@inner
def _whole_vectors(n):
    """The next multiple of 8: what a vector loop leaves over costs more than computing on stale memory."""
    return (n + _U64(7)) & _U64(0xFFFFFFFFFFFFFFF8)


@inner
def _lobe_heights(n, columns, rest, radius, z, share_a, share_b):
    b0, db, a0 = _column(columns, 0), _column(columns, 1), _column(columns, 2)
    g, d, near, far = _column(columns, 16), _column(columns, 17), _column(columns, 18), _column(columns, 19)
    is_hg = _column(columns, 20)
    for k in range(n):
        share_a[k], share_b[k] = _shares(np.float64(np.int64(rest[k])), b0[k], db[k], a0[k])
    for k in range(n):
        radius[k], z[k] = _heights(share_a[k], share_b[k], g[k], d[k], near[k], far[k], is_hg[k])


@inner
def _beckmann_heights(n, columns, radius, z, share_a, share_b):
    is_beckmann = _column(columns, 21)
    for k in range(n):
        if is_beckmann[k] == 1.0:
            radius[k], z[k] = _beckmann_radius(share_a[k], share_b[k]), 1.0


@inner
def _directions(n, columns, second, radius, z, sine, cosine, x, y, up):
    half, t0, t1 = _column(columns, 3), _column(columns, 4), _column(columns, 5)
    m0, m1, m2 = _column(columns, 7), _column(columns, 8), _column(columns, 9)
    m3, m4, m5 = _column(columns, 10), _column(columns, 11), _column(columns, 12)
    m6, m8 = _column(columns, 13), _column(columns, 15)
    for k in range(n):
        v = np.float64(np.int64(second[k] >> _S11)) * _INV53
        sine[k], cosine[k] = sincos_turned(t0[k], t1[k], half[k], v, None)
    for k in range(n):
        row = m0[k], m1[k], m2[k], m3[k], m4[k], m5[k], m6[k], m8[k]
        x[k], y[k], up[k] = _world(radius[k], z[k], sine[k], cosine[k], *row)


@inner
def _keep_rejected(n, offset, left, words, columns, up, chosen, lobe):
    """Move the rejected of a chunk to the front of all chosen photons; return how many stand there."""
    bound, word = _column(columns, 6), words[2]
    k = _ZERO
    while k < n:
        chosen[left] = chosen[offset + k]
        lobe[left] = lobe[offset + k]
        left += _U64(np.float64(np.int64(word[offset + k] >> _S11)) * _INV53 * bound[k] >= -up[k])
        k += _ONE
    return left


@inner
def _scatter(n, chosen, x, y, up, ux, uy, uz):
    k = _ZERO
    while k < n:
        j = chosen[k]
        ux[j], uy[j], uz[j] = x[k], y[k], up[k]
        k += _ONE


@inner
def place_lobes(n, lobes, rank, key, band, memory, ux, uy, uz):
    """Write the directions of the n photons that `choose_lobes` picked over those of a block.

    `lobes` is (lobe of each slot, tables of `plain_lobe`, step of the decision); `memory` comes from `lobe_scratch` and
    holds the words of trial 0.
    """
    tables = lobes[1]
    chosen, lobe, words, columns, rest, radius, z, share_a, share_b, sine, cosine, x, y, up = memory
    first, second, third = words
    trial, count = _ZERO, n
    while count > _FEW and trial < LAST_TRIAL:
        left = _ZERO
        for lo in range(_ZERO, count, _CHUNK):
            m = min(_CHUNK, count - lo)
            part = first[lo : lo + m], second[lo : lo + m], third[lo : lo + m]
            _gather(m, lobe[lo : lo + m], tables, part, columns, rest)
            _lobe_heights(_whole_vectors(m), columns, rest, radius, z, share_a, share_b)
            _beckmann_heights(m, columns, radius, z, share_a, share_b)
            _directions(_whole_vectors(m), columns, second[lo:], radius, z, sine, cosine, x, y, up)
            _scatter(m, chosen[lo : lo + m], x, y, up, ux, uy, uz)
            left = _keep_rejected(m, lo, left, words, columns, up, chosen, lobe)
        count = left
        trial += _ONE
        for k in range(count):
            first[k], second[k], third[k] = _later_words(key, _U64(rank[chosen[k]]), band, trial)
    for k in range(count):
        j = chosen[k]
        r = _U64(rank[j])
        ux[j], uy[j], uz[j] = lobe_at(lobe[k], tables, trial, first[k], second[k], third[k], key, r, band)


@inner
def lobe_scratch(n):
    """Scratch memory for blocks of n photons; the words have room for whole vectors."""
    k = int(_CHUNK)
    return (
        np.zeros(n, np.uint64),
        np.zeros(n, np.int32),
        (np.zeros(n + k, np.uint64), np.zeros(n + k, np.uint64), np.zeros(n + k, np.uint64)),
        np.zeros(k * int(_BIN_COLUMNS + _LOBE_COLUMNS)),
        np.zeros(k, np.uint64),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
    )
