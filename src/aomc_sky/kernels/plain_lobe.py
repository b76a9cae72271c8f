"""Photons of the lobes of background skies: the formulas, for arrays and for `lobe_cells` to compile, and the plain form.

A photon falls into one of 2^m bins, all equally likely, is uniform in it in the share b of the lobe that is farther from the
axis and in the azimuth psi, and becomes a direction as `aomc_sky.skies.lobe_frame` says. It stays with the
probability cos(zenith) / bound of the bin; if not, it falls anew into any bin. So its law is lobe times cosine, exactly.
Everything is worked out in float64 for both precisions.

Of a photon's first word the upper m bits are the bin, what is left the place in b; the second is the place in psi, the
third decides. Later trials divide two words as those of `perez_cells` do.

Columns of a table of lobes: M row by row (0 to 8), g, 1 - g, (1 - g)^2, (1 + g)^2, then 1 for "hg" and 1 for "beckmann".
Columns of a table of bins: least b, growth, least a = 1 - b; half the width in psi in quarter turns, sine and cosine of the
centre; bound.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import constants as k
from aomc_sky.kernels.plain import philox, sincos_quarter
from aomc_sky.kernels.plain_log import log_of_parts

LOBE_COLUMNS = 16
BIN_COLUMNS = 7
IS_HG, IS_BECKMANN = 13, 14

_U64 = np.uint64
_INV52 = 2.0**-52
_INV53 = 2.0**-53
_TO_53 = 2.0**53


def shares(whole, least_b, growth, least_a):
    """Shares a and b of the lobe nearer to and farther from the axis, from 52 bits as a float64; neither is 0."""
    t = (whole + 0.5) * _INV52
    return least_a + growth * (1.0 - t), least_b + growth * t


def heights(a, b, g, d, near, far, is_hg):
    """R and Z of "hg" (`is_hg` 1) and "ggx" (0)."""
    gb = g * b
    p = near * (a + a * gb)
    q = far * (b * (d + gb))
    square = is_hg * (4.0 * (p * q)) + (1.0 - is_hg) * a
    return np.sqrt(square), is_hg * (q - p) + (1.0 - is_hg) * np.sqrt(b)


def world(radius, z, sine, cosine, m0, m1, m2, m3, m4, m5, m6, m8):
    """Travel direction: minus M (R cos, R sin, Z), normalised."""
    along, across = radius * cosine, radius * sine
    x = m0 * along + m1 * across + m2 * z
    y = m3 * along + m4 * across + m5 * z
    up = m6 * along + m8 * z
    scale = -1.0 / np.sqrt(x * x + y * y + up * up)
    return x * scale, y * scale, up * scale


def _beckmann_radius(a, b):
    """Root of -log(b), from a where that is small."""
    m, power = np.frexp(b)
    small = m < 0.7071067811865476
    beside = a < 0.25
    f = np.where(beside, -a, np.where(small, m + m, m) - 1.0)
    return np.sqrt(-log_of_parts(f, np.where(beside, 0, power - small)))


def _fallen(first, second, lobe, tables):
    """Directions and bounds of photons of the lobes `lobe` from two words each."""
    ranges, shapes, bins = tables
    start, bits = ranges[2 * lobe], ranges[2 * lobe + 1]
    at = (start + (first >> (_U64(64) - bits))).astype(np.int64)
    b0, db, a0, half, t0, t1, bound = bins.reshape(-1, BIN_COLUMNS)[at].T
    shape = shapes.reshape(-1, LOBE_COLUMNS)[lobe].T
    a, b = shares(((first << bits) >> _U64(12)).astype(np.float64), b0, db, a0)
    radius, z = heights(a, b, *shape[9 : IS_HG + 1])
    is_beckmann = shape[IS_BECKMANN] == 1.0
    radius[is_beckmann], z[is_beckmann] = _beckmann_radius(a[is_beckmann], b[is_beckmann]), 1.0
    v = (second >> _U64(11)).astype(np.float64) * _INV53
    s, c = sincos_quarter(half * (v + v - 1.0))
    return world(radius, z, t0 * c + t1 * s, t1 * c - t0 * s, *shape[:7], shape[8]), bound


def place_lobes(lobe, tables, words, key, rank, band):
    """Directions (float64) of photons of the lobes `lobe`; `words` are the three words of trial 0 of each."""
    out = tuple(np.empty(lobe.size) for _ in range(3))
    left = np.arange(lobe.size)
    first, second, word = words
    trial = 0
    while left.size:
        directions, bound = _fallen(first, second, lobe[left], tables)
        for values, new in zip(out, directions, strict=True):
            values[left] = new
        limit = (word >> _U64(11)).astype(np.float64) * _INV53 * bound
        left = left[limit >= -directions[2]]
        trial += 1
        if trial >= int(k.LAST_TRIAL):
            break
        first, second = philox(key, rank[left], band, trial)
        word = (((first & k.REST_BITS) << k.REST_SHIFT) | (second & k.REST_BITS)) << k.ACCEPT_SHIFT
        first, second = first & k.PLACE_BITS, second & k.PLACE_BITS
    return out


def lobe_words(rank, shifts, steps, accept, key, band, jitter):
    """The three words of trial 0: by rank, or from Philox."""
    if jitter:
        return (*philox(key, rank, band, 0), philox(key, rank, band, int(k.ACCEPT))[0])
    return shifts[0] + rank * steps[0], shifts[1] + rank * steps[1], accept[0] + rank * accept[1]


def words_of_place(value):
    """Uniform numbers in [0, 1) as 64-bit fractions."""
    return (value.astype(np.float64) * _TO_53).astype(np.int64).astype(_U64) << _U64(11)
