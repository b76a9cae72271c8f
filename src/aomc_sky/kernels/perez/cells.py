"""Photons of the Perez sky inside a cell: exact rejection, so that the emitted law does not depend on the cells.

A photon starts as one of CELL_MU2, uniform in mu^2 and azimuth, is moved along the slope of the luminance
(`tilted`), and is taken with the probability max(f, 0) J / bound, J being what the move divides the density by. Where
its uniform number already lies below the lower bound of f J over the bound, no luminance is computed. The number of
trial 0 is a sequence by rank like the place (or Philox, draw ACCEPT), later trials t take all from draw t
of Philox: 42 bits for each coordinate of the place, 44 for the number. Each step is a loop of its own over the
photons that need it, side by side, so that it vectorises.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import (
    ACCEPT,
    ACCEPT_SHIFT,
    LAST_TRIAL,
    ONE,
    PLACE_BITS,
    REST_BITS,
    REST_SHIFT,
    S11,
    TILT_STEP,
    U64,
    ZERO,
)
from aomc_sky.kernels.arithmetic.elementary import exp_level, sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells import laws as cells
from aomc_sky.kernels.cells.parameters import MAX_PHOTONS, cell_of_photon, turn_of_photon
from aomc_sky.kernels.jit import inner, inner_reader
from aomc_sky.kernels.perez.law import arc, first_factor, second_factor

_S10 = np.int32(10)
_S22 = np.int32(22)
_S52 = np.uint64(52)
_LOW12 = np.uint32(0xFFF)
_NEVER = np.uint32(0x80000000)
_INV53 = 2.0**-53
_FEW = np.uint64(6)
_CHUNK = np.uint64(256)


@inner_reader
def accept_words(m, rank, steps, key, band, jitter, word):
    """The 64-bit uniform words that decide trial 0 of a block."""
    if jitter is None:
        shift, step = steps[0], steps[1]
        for j in range(m):
            word[j] = shift + U64(rank[j]) * step
    else:
        for j in range(m):
            word[j], _ = philox_pair(key, U64(rank[j]), band, ACCEPT)


@inner_reader
def gather_cell_words(m, slot, word_of_slot, cell_word):
    """The words of the cells of a block side by side: tilts in 10 bits each, then 12 of the threshold."""
    j = ZERO
    while j < m:
        w = word_of_slot[U64(slot[j])]
        cell_word[j] = w
        if w == _NEVER:  # a tilt of -512 steps does not exist; see _parameters_shuffled in emit.py
            break
        j += ONE


@inner_reader
def tilted(u, v, cell_word):
    """The place (u, v) after the move along the luminance's slope, and J.

    u' = u + k u (1 - u) has the derivative 1 + k (1 - 2u), for v alike; J is the product of both.
    """
    kind = type(u)
    one, step = kind(1), kind(TILT_STEP)
    both = np.int32(cell_word)
    tilt_u = kind(both >> _S22) * step
    tilt_v = kind(np.int32(both << _S10) >> _S22) * step
    rest_u, rest_v = one - u, one - v
    jacobian = (one + tilt_u * (rest_u - u)) * (one + tilt_v * (rest_v - v))
    return u * (one + tilt_u * rest_u), v * (one + tilt_v * rest_v), jacobian


@inner_reader
def tilt_block(m, cell_word, u, v, jacobian):
    """`tilted` for a block."""
    for j in range(m):
        u[j], v[j], jacobian[j] = tilted(u[j], v[j], cell_word[j])


@inner_reader
def tilted_by_rank(m, rank, shifts, steps, bits, cell_word, u, v, jacobian):
    """`tilt_block` of the places by rank."""
    shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
    for j in range(min(m, MAX_PHOTONS)):
        r = U64(rank[j])
        first = unit(shift_u + r * step_u, u[j])
        second = unit(shift_v + r * step_v + turn_of_photon(bits, j), v[j])
        u[j], v[j], jacobian[j] = tilted(first, second, cell_word[j])


@inner_reader
def is_taken_at_once(word, cell_word):
    """Whether the lower bound of a cell takes the photon with this word."""
    return (word >> _S52) < U64(cell_word & _LOW12)


@inner_reader
def _undecided(m, word, cell_word, flag, chosen):
    """Photons that the lower bound does not take; no branch, which would be guessed wrongly too often."""
    for j in range(m):
        flag[j] = np.uint8(not is_taken_at_once(word[j], cell_word[j]))
    n, j = ZERO, ZERO
    while j < m:
        chosen[n] = j
        n += U64(flag[j])
        j += ONE
    return n


@inner_reader
def _whole_vectors(n):
    """The next multiple of 32: what a vector loop leaves over costs more than computing on stale memory."""
    return (n + U64(31)) & U64(0xFFFFFFFFFFFFFFE0)


@inner_reader
def _measure(x, y, z, word, bound, sun_x, sun_y, sun_z):
    """sin^2 of half the angle to the sun, mu, and the uniform number times the bound of one photon."""
    x, y, z = np.float64(x), np.float64(y), np.float64(z)
    dx, dy, dz = x + sun_x, y + sun_y, z + sun_z
    limit = (np.float64(np.int64(word >> S11)) * _INV53) * bound
    return min(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0), -z, limit


@inner_reader
def _measure_chosen(n, chosen, ux, uy, uz, word, slot, jacobian, bound, sky, chord, mu, limit, scale):
    """`_measure` for chosen photons, side by side."""
    sun_x, sun_y, sun_z = sky[8], sky[9], sky[10]
    k = ZERO
    while k < n:
        j = chosen[k]
        chord[k], mu[k], limit[k] = _measure(ux[j], uy[j], uz[j], word[j], bound[U64(slot[j])], sun_x, sun_y, sun_z)
        scale[k] = jacobian[j]
        k += ONE


@inner_reader
def _measure_again(n, x, y, z, word, sky, chord, mu, limit):
    """`_measure` for new directions; `limit` holds the bounds."""
    sun_x, sun_y, sun_z = sky[8], sky[9], sky[10]
    for k in range(n):
        chord[k], mu[k], limit[k] = _measure(x[k], y[k], z[k], word[k], limit[k], sun_x, sun_y, sun_z)


@inner_reader
def _luminance(n, chord, mu, sky, scale, value):
    """Luminance of n photons x their J in `value`; `chord` and `mu` are used up.

    The steps of `law` in loops of their own: in one loop each photon would wait for its whole chain of
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
        value[k] = (1.0 + a * exp_level(mu[k])) * value[k] * np.float64(scale[k])


@inner_reader
def _keep_rejected(n, limit, value, part, left, chosen):
    """Append the rejected of a part of the chosen photons to the front of them all; return how many stand there."""
    k = ZERO
    while k < n:
        j = part[k]
        chosen[left] = j
        left += U64(limit[k] >= value[k])
        k += ONE
    return left


@inner_reader
def _gather_cells(n, chosen, p, rank, slot, cell_word, bound, first, tilt, limit, h0, h1, h2, h3, t0, t1):
    """Ranks, words, bounds and cell parameters of chosen photons side by side."""
    k = ZERO
    while k < n:
        j = chosen[k]
        first[k] = U64(rank[j])
        tilt[k] = cell_word[j]
        limit[k] = bound[U64(slot[j])]
        h0[k], h1[k], h2[k], h3[k], t0[k], t1[k] = cell_of_photon(p, j)
        k += ONE


@inner_reader
def _draw(n, trial, key, band, first, second):
    """Words of trial `trial` of n photons; `first` holds their ranks."""
    for k in range(n):
        first[k], second[k] = philox_pair(key, first[k], band, trial)


@inner_reader
def _place_again(n, first, second, tilt, h0, h1, h2, h3, t0, t1, x, y, z, scale):
    """New directions from new words; what is left of the words, the decision's, replaces `first`."""
    for k in range(n):
        u, v = unit(first[k] & PLACE_BITS, h0[k]), unit(second[k] & PLACE_BITS, h0[k])
        u, v, scale[k] = tilted(u, v, tilt[k])
        sine, cosine = sincos_turned_any(t0[k], t1[k], h3[k], v)
        x[k], y[k], z[k] = cells.from_mu2(h0[k], h1[k], h2[k], u, sine, cosine)
    for k in range(n):
        first[k] = (((first[k] & REST_BITS) << REST_SHIFT) | (second[k] & REST_BITS)) << ACCEPT_SHIFT


@inner_reader
def _scatter(n, chosen, x, y, z, ux, uy, uz):
    k = ZERO
    while k < n:
        j = chosen[k]
        ux[j], uy[j], uz[j] = x[k], y[k], z[k]
        k += ONE


@inner_reader
def is_rejected(x, y, z, jacobian, word, bound, sky):
    """Whether the luminance refuses one photon; the same bits as the loops above."""
    chord, mu, limit = _measure(x, y, z, word, bound, sky[8], sky[9], sky[10])
    value = first_factor(mu, sky[0], sky[1]) * second_factor(chord, sky[2], sky[3], sky[4])
    return limit >= value * np.float64(jacobian)


@inner_reader
def further_trials(trial, x, y, z, rank, h0, h1, h2, h3, t0, t1, cell_word, bound, sky, key, band):
    """Direction of one photon after trial `trial` and as many more as it takes; (x, y, z) where none is left."""
    while trial < LAST_TRIAL:
        first, second = philox_pair(key, rank, band, trial)
        u, v, jacobian = tilted(unit(first & PLACE_BITS, h0), unit(second & PLACE_BITS, h0), cell_word)
        sine, cosine = sincos_turned_any(t0, t1, h3, v)
        x, y, z = cells.from_mu2(h0, h1, h2, u, sine, cosine)
        word = (((first & REST_BITS) << REST_SHIFT) | (second & REST_BITS)) << ACCEPT_SHIFT
        if not is_rejected(x, y, z, jacobian, word, bound, sky):
            break
        trial += ONE
    return x, y, z


@inner_reader
def _one_by_one(n, trial, chosen, slot, rank, p, bound, cell_word, sky, key, band, ux, uy, uz):
    """`further_trials` of the few photons that would not fill a vector."""
    for k in range(n):
        j = chosen[k]
        known = cell_word[j], bound[U64(slot[j])], sky, key, band
        ux[j], uy[j], uz[j] = further_trials(trial, ux[j], uy[j], uz[j], U64(rank[j]), *cell_of_photon(p, j), *known)


@inner_reader
def reject(m, slot, rank, p, perez, key, band, word, cell_word, jacobian, scratch, ux, uy, uz):
    """Replace the photons of a block that the Perez luminance rejects.

    `perez` holds the words of the slots (n_slot,) uint32, tilts and the number below which the upper 12 bits of a
    photon's word are taken at once; `bound` (n_slot,) float64; and `sky`, a to e, three angles and the sun's
    unit vector. `word` decides trial 0; `cell_word` and `jacobian` belong to the photons too; `scratch` comes from
    `perez_scratch`.
    """
    bound, sky = perez[1], perez[2]
    flag, chosen, first, second, tilt, limit, chord, mu, value, x, y, z, h0, h1, h2, h3, t0, t1, scale = scratch
    n = _undecided(m, word, cell_word, flag, chosen)
    left = ZERO
    for lo in range(ZERO, n, _CHUNK):
        k = min(_CHUNK, n - lo)
        part = chosen[lo : lo + k]
        _measure_chosen(k, part, ux, uy, uz, word, slot, jacobian, bound, sky, chord, mu, limit, scale)
        _luminance(_whole_vectors(k), chord, mu, sky, scale, value)
        left = _keep_rejected(k, limit, value, part, left, chosen)
    trial = ONE
    while left > _FEW and trial < LAST_TRIAL:
        n, left = left, ZERO
        for lo in range(ZERO, n, _CHUNK):
            k = min(_CHUNK, n - lo)
            part = chosen[lo : lo + k]
            _gather_cells(k, part, p, rank, slot, cell_word, bound, first, tilt, limit, h0, h1, h2, h3, t0, t1)
            _draw(_whole_vectors(k), trial, key, band, first, second)
            _place_again(_whole_vectors(k), first, second, tilt, h0, h1, h2, h3, t0, t1, x, y, z, scale)
            _scatter(k, part, x, y, z, ux, uy, uz)
            _measure_again(_whole_vectors(k), x, y, z, first, sky, chord, mu, limit)
            _luminance(_whole_vectors(k), chord, mu, sky, scale, value)
            left = _keep_rejected(k, limit, value, part, left, chosen)
        trial += ONE
    _one_by_one(left, trial, chosen, slot, rank, p, bound, cell_word, sky, key, band, ux, uy, uz)


@inner
def perez_scratch(n, like):
    """Scratch memory of `reject` for blocks of n photons; columns of their own, which the compiler can tell apart."""
    k = int(_CHUNK)
    return (
        np.empty(n, np.uint8),
        np.empty(n, np.uint64),
        np.zeros(k, np.uint64),
        np.zeros(k, np.uint64),
        np.zeros(k, np.uint32),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
        np.zeros(k, like.dtype),
    )
