"""Photons of the Perez sky inside a cell: exact rejection, so that the emitted law does not depend on the cells.

A photon starts as one of CELL_MU2, uniform in mu^2 and azimuth, and is taken with the probability
max(f, 0) / bound. Where its uniform number already lies below the lower bound of f over the bound, no
luminance is computed. The number of trial 0 is a sequence by rank like the place (or Philox, draw ACCEPT),
later trials t take all from draw t of Philox: 42 bits for each coordinate of the place, 44 for the number.
Each step is a loop of its own over the photons that need it, side by side, so that it vectorises.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import cells
from aomc_sky.kernels.constants import ACCEPT, ACCEPT_SHIFT, LAST_TRIAL, PLACE_BITS, REST_BITS, REST_SHIFT
from aomc_sky.kernels.elementary import sincos_turned_any, unit
from aomc_sky.kernels.jit import inner
from aomc_sky.kernels.parameters import PAIR_ROW
from aomc_sky.kernels.perez_law import arc, exp_level
from aomc_sky.kernels.rng import philox_pair

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_S11 = np.uint64(11)
_S32 = np.uint64(32)
_INV53 = 2.0**-53


@inner
def accept_words(m, rank, steps, key, band, jitter, word):
    """The 64-bit uniform words that decide trial 0 of a block."""
    if jitter is None:
        shift, step = steps[0], steps[1]
        for j in range(m):
            word[j] = shift + _U64(rank[j]) * step
    else:
        for j in range(m):
            word[j], _ = philox_pair(key, _U64(rank[j]), band, ACCEPT)


@inner
def _undecided(m, slot, word, threshold, chosen):
    """Photons that the lower bound does not take; written without a branch."""
    n, j = _ZERO, _ZERO
    while j < m:
        chosen[n] = j
        n += _U64((word[j] >> _S32) >= threshold[_U64(slot[j])])
        j += _ONE
    return n


@inner
def _whole_vectors(n):
    """The next multiple of 32: what a vector loop leaves over costs more than computing on stale memory."""
    return (n + _U64(31)) & _U64(0xFFFFFFFFFFFFFFE0)


@inner
def _measure(x, y, z, word, bound, sun_x, sun_y, sun_z):
    """sin^2 of half the angle to the sun, mu, and the uniform number times the bound of one photon."""
    x, y, z = np.float64(x), np.float64(y), np.float64(z)
    dx, dy, dz = x + sun_x, y + sun_y, z + sun_z
    limit = (np.float64(np.int64(word >> _S11)) * _INV53) * bound
    return min(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0), -z, limit


@inner
def _measure_chosen(n, chosen, ux, uy, uz, word, slot, bound, sky, chord, mu, limit):
    """`_measure` for chosen photons, side by side."""
    sun_x, sun_y, sun_z = sky[8], sky[9], sky[10]
    k = _ZERO
    while k < n:
        j = chosen[k]
        chord[k], mu[k], limit[k] = _measure(ux[j], uy[j], uz[j], word[j], bound[_U64(slot[j])], sun_x, sun_y, sun_z)
        k += _ONE


@inner
def _measure_again(n, x, y, z, word, sky, chord, mu, limit):
    """`_measure` for new directions; `limit` holds the bounds."""
    sun_x, sun_y, sun_z = sky[8], sky[9], sky[10]
    for k in range(n):
        chord[k], mu[k], limit[k] = _measure(x[k], y[k], z[k], word[k], limit[k], sun_x, sun_y, sun_z)


@inner
def _luminance(n, chord, mu, sky, value):
    """Luminance of n photons in `value`; `chord` and `mu` are used up.

    The steps of `perez_law` in loops of their own: in one loop each photon would wait for its whole chain of
    operations, in short ones the processor works on many photons at once.
    """
    a, b, c, d, e = sky[0], sky[1], sky[2], sky[3], sky[4]
    for k in range(n):
        value[k] = d * arc(chord[k])
    for k in range(n):
        q = 1.0 - (chord[k] + chord[k])
        value[k] = 1.0 + c * exp_level(value[k]) + e * (q * q)
    for k in range(n):
        mu[k] = b / max(mu[k], 1e-300)
    for k in range(n):
        value[k] = (1.0 + a * exp_level(mu[k])) * value[k]


@inner
def _keep_rejected(n, limit, value, chosen):
    """Move the rejected of the first n photons to the front; return how many they are."""
    left, k = _ZERO, _ZERO
    while k < n:
        j = chosen[k]
        chosen[left] = j
        left += _U64(limit[k] >= value[k])
        k += _ONE
    return left


@inner
def _gather_cells(n, chosen, p, rank, slot, bound, first, limit, h0, h1, h2, h3, t0, t1):
    """Ranks, bounds and cell parameters of chosen photons side by side."""
    k = _ZERO
    while k < n:
        j = chosen[k]
        i = _TWO * j
        q, t = i + PAIR_ROW, i + _TWO * PAIR_ROW
        first[k] = _U64(rank[j])
        limit[k] = bound[_U64(slot[j])]
        h0[k], h1[k], h2[k], h3[k], t0[k], t1[k] = p[i], p[i + _ONE], p[q], p[q + _ONE], p[t], p[t + _ONE]
        k += _ONE


@inner
def _draw(n, trial, key, band, first, second):
    """Words of trial `trial` of n photons; `first` holds their ranks."""
    for k in range(n):
        first[k], second[k] = philox_pair(key, first[k], band, trial)


@inner
def _place_again(n, first, second, h0, h1, h2, h3, t0, t1, x, y, z):
    """New directions from new words; what is left of the words, the decision's, replaces `first`."""
    for k in range(n):
        u, v = unit(first[k] & PLACE_BITS, h0[k]), unit(second[k] & PLACE_BITS, h0[k])
        sine, cosine = sincos_turned_any(t0[k], t1[k], h3[k], v)
        x[k], y[k], z[k] = cells.from_mu2(h0[k], h1[k], h2[k], u, sine, cosine)
    for k in range(n):
        first[k] = (((first[k] & REST_BITS) << REST_SHIFT) | (second[k] & REST_BITS)) << ACCEPT_SHIFT


@inner
def _scatter(n, chosen, x, y, z, ux, uy, uz):
    k = _ZERO
    while k < n:
        j = chosen[k]
        ux[j], uy[j], uz[j] = x[k], y[k], z[k]
        k += _ONE


@inner
def reject(m, slot, rank, p, perez, key, band, word, scratch, ux, uy, uz):
    """Replace the photons of a block that the Perez luminance rejects.

    `perez` holds `threshold` (n_slot,) uint32, below which the upper half of a word is taken at once;
    `bound` (n_slot,) float64; `sky`, a to e, three angles and the sun's unit vector; and the steps of
    trial 0. `scratch` comes from `perez_scratch`.
    """
    threshold, bound, sky, _ = perez
    chosen, first, second, limit, chord, mu, value, x, y, z, h0, h1, h2, h3, t0, t1 = scratch
    n = _undecided(m, slot, word, threshold, chosen)
    _measure_chosen(n, chosen, ux, uy, uz, word, slot, bound, sky, chord, mu, limit)
    _luminance(_whole_vectors(n), chord, mu, sky, value)
    n = _keep_rejected(n, limit, value, chosen)
    trial = _ONE
    while n > _ZERO and trial < LAST_TRIAL:
        _gather_cells(n, chosen, p, rank, slot, bound, first, limit, h0, h1, h2, h3, t0, t1)
        _draw(_whole_vectors(n), trial, key, band, first, second)
        _place_again(_whole_vectors(n), first, second, h0, h1, h2, h3, t0, t1, x, y, z)
        _scatter(n, chosen, x, y, z, ux, uy, uz)
        _measure_again(_whole_vectors(n), x, y, z, first, sky, chord, mu, limit)
        _luminance(_whole_vectors(n), chord, mu, sky, value)
        n = _keep_rejected(n, limit, value, chosen)
        trial += _ONE


@inner
def perez_scratch(n, like):
    """Scratch memory of `reject` for n photons; columns of their own, which the compiler can tell apart."""
    n += 32
    return (
        np.zeros(n, np.uint64),
        np.zeros(n, np.uint64),
        np.zeros(n, np.uint64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
        np.zeros(n, like.dtype),
    )
