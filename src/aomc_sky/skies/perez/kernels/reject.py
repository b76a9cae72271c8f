"""The rejection of `cells` for the photons of a block, compiled.

Each step is a loop of its own over the photons that need it, side by side, so that it vectorises.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ACCEPT, LAST_TRIAL, ONE, PEREZ_CHUNK, PEREZ_WORDS, U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import arc, exp_level, sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import later_words, philox_pair
from aomc_sky.kernels.cells.blocks import MAX_PHOTONS, cell_of_photon, column, ring_offset_of_photon, whole_vectors
from aomc_sky.kernels.cells.laws import from_mu2
from aomc_sky.kernels.jit import inner, inner_no_refcount
from aomc_sky.skies.perez.kernels.cells import is_rejected, is_taken_at_once, measured, tilted
from aomc_sky.skies.perez.kernels.law import SUN_VECTOR, A, B, C, D, E, slant, with_aureole

_NEVER = np.uint32(0x80000000)
_FEW = np.uint64(6)
_CHUNK = np.uint64(PEREZ_CHUNK)
_FLAGS = np.uint64(64)


@inner_no_refcount
def accept_words(m, rank, steps, key, band, jitter, word):
    """The 64-bit uniform words that decide trial 0 of a block."""
    if jitter == ZERO:
        shift, step = steps[0], steps[1]
        for j in range(m):
            word[j] = shift + U64(rank[j]) * step
    else:
        for j in range(m):
            word[j], _ = philox_pair(key, U64(rank[j]), band, ACCEPT)


@inner_no_refcount
def gather_cell_words(m, slot, word_of_slot, cell_word):
    """The words of the cells of a block side by side: tilts in 10 bits each, then 12 of the threshold."""
    j = ZERO
    while j < m:
        w = word_of_slot[U64(slot[j])]
        cell_word[j] = w
        if w == _NEVER:  # a tilt of -512 steps does not exist; see _parameters_shuffled in emit.py
            break
        j += ONE


@inner_no_refcount
def tilt_block(m, cell_word, u, v, jacobian):
    """`tilted` for a block."""
    for j in range(m):
        u[j], v[j], jacobian[j] = tilted(u[j], v[j], cell_word[j])


@inner_no_refcount
def tilted_by_rank(m, rank, shifts, steps, bits, cell_word, u, v, jacobian):
    """`tilt_block` of the places by rank."""
    shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
    for j in range(min(m, MAX_PHOTONS)):
        r = U64(rank[j])
        first = unit(shift_u + r * step_u, u[j])
        second = unit(shift_v + r * step_v + ring_offset_of_photon(bits, j), v[j])
        u[j], v[j], jacobian[j] = tilted(first, second, cell_word[j])


@inner_no_refcount
def _undecided(m, word, cell_word, flag, chosen):
    """Photons that the lower bound does not take; in narrow cells they are so few that most chunks have none."""
    n = ZERO
    for lo in range(ZERO, m, _FLAGS):
        hi = min(lo + _FLAGS, m)
        any_set = np.uint8(0)
        for j in range(lo, hi):
            flag[j] = np.uint8(not is_taken_at_once(word[j], cell_word[j]))
            any_set = np.uint8(any_set | flag[j])
        if any_set != np.uint8(0):
            j = lo
            while j < hi:  # no branch, which would be guessed wrongly too often
                chosen[n] = j
                n += U64(flag[j])
                j += ONE
    return n


@inner_no_refcount
def _measure_chosen(n, chosen, ux, uy, uz, word, slot, jacobian, bound, sky, chord, mu, limit, scale):
    """`measured` for chosen photons, side by side."""
    sun_x, sun_y, sun_z = sky[SUN_VECTOR], sky[SUN_VECTOR + 1], sky[SUN_VECTOR + 2]
    k = ZERO
    while k < n:
        j = chosen[k]
        chord[k], mu[k], limit[k] = measured(ux[j], uy[j], uz[j], word[j], bound[U64(slot[j])], sun_x, sun_y, sun_z)
        scale[k] = jacobian[j]
        k += ONE


@inner_no_refcount
def _measure_again(n, x, y, z, word, sky, chord, mu, limit):
    """`measured` for new directions; `limit` holds the bounds."""
    sun_x, sun_y, sun_z = sky[SUN_VECTOR], sky[SUN_VECTOR + 1], sky[SUN_VECTOR + 2]
    for k in range(n):
        chord[k], mu[k], limit[k] = measured(x[k], y[k], z[k], word[k], limit[k], sun_x, sun_y, sun_z)


@inner_no_refcount
def _luminance(n, chord, mu, sky, scale, value):
    """Luminance of n photons x their J in `value`; `chord` and `mu` are used up.

    Each step of `law` has a loop of its own. In one loop each photon would wait for its whole chain of operations; in
    short loops the processor works on many photons at once.
    """
    a, b, c, d, e = sky[A], sky[B], sky[C], sky[D], sky[E]
    for k in range(n):
        value[k] = d * arc(chord[k])
    for k in range(n):
        value[k] = with_aureole(chord[k], c, exp_level(value[k]), e)
    for k in range(n):
        mu[k] = slant(mu[k], b)
    for k in range(n):
        value[k] = (1.0 + a * exp_level(mu[k])) * value[k] * np.float64(scale[k])


@inner_no_refcount
def _keep_rejected(n, limit, value, part, left, chosen):
    """Append the rejected of a part of the chosen photons to the front of them all; return their number."""
    k = ZERO
    while k < n:
        j = part[k]
        chosen[left] = j
        left += U64(limit[k] >= value[k])
        k += ONE
    return left


@inner_no_refcount
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


@inner_no_refcount
def _draw(n, trial, key, band, first, second, word):
    """Words of trial `trial` of n photons; `first` holds their ranks."""
    for k in range(n):
        first[k], second[k], word[k] = later_words(key, first[k], band, trial)


@inner_no_refcount
def _place_again(n, first, second, tilt, h0, h1, h2, h3, t0, t1, x, y, z, scale):
    """New directions from new words."""
    for k in range(n):
        u, v, scale[k] = tilted(unit(first[k], h0[k]), unit(second[k], h0[k]), tilt[k])
        sine, cosine = sincos_turned_any(t0[k], t1[k], h3[k], v)
        x[k], y[k], z[k] = from_mu2(h0[k], h1[k], h2[k], u, sine, cosine)


@inner_no_refcount
def _scatter(n, chosen, x, y, z, ux, uy, uz):
    k = ZERO
    while k < n:
        j = chosen[k]
        ux[j], uy[j], uz[j] = x[k], y[k], z[k]
        k += ONE


@inner_no_refcount
def further_trials(trial, x, y, z, rank, h0, h1, h2, h3, t0, t1, cell_word, bound, sky, key, band):
    """Direction of one photon after trial `trial` and as many more as it takes; (x, y, z) where none is left."""
    while trial < LAST_TRIAL:
        first, second, word = later_words(key, rank, band, trial)
        u, v, jacobian = tilted(unit(first, h0), unit(second, h0), cell_word)
        sine, cosine = sincos_turned_any(t0, t1, h3, v)
        x, y, z = from_mu2(h0, h1, h2, u, sine, cosine)
        if not is_rejected(x, y, z, jacobian, word, bound, sky):
            break
        trial += ONE
    return x, y, z


@inner
def taken_or_replaced(x, y, z, jacobian, slot, rank, cell, perez, key, band, jitter):
    """`reject` for one photon whose place was `tilted`; `jitter` is None for places by rank."""
    word_of_slot, bound, sky, steps = perez
    if jitter is None:
        word = steps[0] + rank * steps[1]
    else:
        word, _ = philox_pair(key, rank, band, ACCEPT)
    cell_word = word_of_slot[slot]
    if is_taken_at_once(word, cell_word) or not is_rejected(x, y, z, jacobian, word, bound[slot], sky):
        return x, y, z
    return further_trials(ONE, x, y, z, rank, *cell, cell_word, bound[slot], sky, key, band)


@inner_no_refcount
def _one_by_one(n, trial, chosen, slot, rank, p, bound, cell_word, sky, key, band, ux, uy, uz):
    """`further_trials` of the few photons that would not fill a vector."""
    for k in range(n):
        j = chosen[k]
        known = cell_word[j], bound[U64(slot[j])], sky, key, band
        ux[j], uy[j], uz[j] = further_trials(trial, ux[j], uy[j], uz[j], U64(rank[j]), *cell_of_photon(p, j), *known)


@inner_no_refcount
def reject(m, slot, rank, p, perez, key, band, word, cell_word, jacobian, scratch, ux, uy, uz):
    """Replace the photons of a block that the Perez luminance rejects.

    `perez` has the words of the slots (n_slot,) uint32: tilts, and the limit below which the upper 12 bits of a
    photon's word are taken at once. Then `bound` (n_slot,) float64, and `sky`: a to e, three angles and the sun's unit
    vector. `word` decides trial 0. `cell_word` and `jacobian` belong to the photons too. `scratch` comes from
    `perez_scratch`.
    """
    bound, sky = perez[1], perez[2]
    flag, chosen, first, second, decision, tilt, limit, chord, mu, value, x, y, z, h0, h1, h2, h3, t0, t1, scale = (
        scratch
    )
    n = _undecided(m, word, cell_word, flag, chosen)
    left = ZERO
    for lo in range(ZERO, n, _CHUNK):
        k = min(_CHUNK, n - lo)
        part = chosen[lo : lo + k]
        _measure_chosen(k, part, ux, uy, uz, word, slot, jacobian, bound, sky, chord, mu, limit, scale)
        _luminance(whole_vectors(k), chord, mu, sky, scale, value)
        left = _keep_rejected(k, limit, value, part, left, chosen)
    trial = ONE
    while left > _FEW and trial < LAST_TRIAL:
        n, left = left, ZERO
        for lo in range(ZERO, n, _CHUNK):
            k = min(_CHUNK, n - lo)
            part = chosen[lo : lo + k]
            _gather_cells(k, part, p, rank, slot, cell_word, bound, first, tilt, limit, h0, h1, h2, h3, t0, t1)
            _draw(whole_vectors(k), trial, key, band, first, second, decision)
            _place_again(whole_vectors(k), first, second, tilt, h0, h1, h2, h3, t0, t1, x, y, z, scale)
            _scatter(k, part, x, y, z, ux, uy, uz)
            _measure_again(whole_vectors(k), x, y, z, decision, sky, chord, mu, limit)
            _luminance(whole_vectors(k), chord, mu, sky, scale, value)
            left = _keep_rejected(k, limit, value, part, left, chosen)
        trial += ONE
    _one_by_one(left, trial, chosen, slot, rank, p, bound, cell_word, sky, key, band, ux, uy, uz)


_COLUMN = np.uint64(PEREZ_WORDS // 18)
"""Words of the memory of the chunks."""


@inner_no_refcount
def perez_scratch(memory, flag, chosen, like):
    """Scratch memory of `reject`; columns of their own, which the compiler can tell apart.

    `flag` and `chosen` hold an entry per photon of a block; `memory` has words for the columns of the chunks.
    """
    one, word, short = np.float64(0), ZERO, np.uint32(0)
    return (
        flag,
        chosen,
        column(memory, U64(0), _COLUMN, word),
        column(memory, U64(1), _COLUMN, word),
        column(memory, U64(2), _COLUMN, word),
        column(memory, U64(3), _COLUMN, short),
        column(memory, U64(4), _COLUMN, one),
        column(memory, U64(5), _COLUMN, one),
        column(memory, U64(6), _COLUMN, one),
        column(memory, U64(7), _COLUMN, one),
        column(memory, U64(8), _COLUMN, like),
        column(memory, U64(9), _COLUMN, like),
        column(memory, U64(10), _COLUMN, like),
        column(memory, U64(11), _COLUMN, like),
        column(memory, U64(12), _COLUMN, like),
        column(memory, U64(13), _COLUMN, like),
        column(memory, U64(14), _COLUMN, like),
        column(memory, U64(15), _COLUMN, like),
        column(memory, U64(16), _COLUMN, like),
        column(memory, U64(17), _COLUMN, like),
    )
