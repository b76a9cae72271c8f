"""Photon i of a band, for i in [start, stop): rank, slot, place in the cell, travel direction, position.

A band is a table of *slots*: its cells with at least one photon, in order. Photons are made in blocks that stay in the
cache, with one simple loop per step, because simple loops vectorise and a fused one does not. A vectorised table
look-up (a gather) costs more than the scalar one on most processors.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from aomc_sky.emission.kernels.hooks import with_hooks
from aomc_sky.emission.kernels.plain import in_circle, in_rectangle
from aomc_sky.kernels.arithmetic.constants import (
    ANY_WIDTH,
    BLOCK,
    COLUMNS,
    IN_MU,
    LAST_TRIAL,
    NARROW,
    ONE,
    PARAMETER_COLUMN,
    PEREZ_WORDS,
    QUARTER,
    SCRATCH_PHOTONS,
    U32,
    U64,
    ZERO,
)
from aomc_sky.kernels.arithmetic.elementary import sincos_turned, sincos_turned_any, sincos_turned_narrow, unit
from aomc_sky.kernels.arithmetic.prefetch import prefetch_to_read
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells import laws
from aomc_sky.kernels.cells.blocks import (
    MAX_PHOTONS,
    cell_of_photon,
    cell_of_table,
    cells_of_slots,
    column,
    fill_parameters,
    place_on_slopes,
    ranks_of_block,
    ring_offset_of_photon,
    ring_offset_of_table,
    slot_of_rank,
    split_place,
    word_like,
)
from aomc_sky.kernels.cells.columns import GROUP, copy_group
from aomc_sky.kernels.cells.laws import disc, disc_at_horizon_trial, from_mu, from_mu2
from aomc_sky.kernels.formula import by_width, select
from aomc_sky.kernels.jit import inlined_no_refcount, inner_no_refcount, no_refcount, view_as

perez_hook: Any = None
lobes_hook: Any = None
"""None here: `emit_with` swaps them in copies of `emit`; see `hooks`."""

_PARAMETERS = PARAMETER_COLUMN * SCRATCH_PHOTONS
_PEREZ_MEMORY = COLUMNS * SCRATCH_PHOTONS
_LOBES_MEMORY = _PEREZ_MEMORY + PEREZ_WORDS
_MANY = np.uint64(16)  # the formula of a disc takes for a whole block about as long as for one photon in 16, singly
_FAR, _NEAR = np.uint64(48), np.uint64(24)  # so many photons ahead the guide and the ranks of slots are asked for
_GROUP, _REST_OF_GROUP = np.uint64(GROUP), np.uint64(GROUP - 1)
_REST_OF_VECTOR = np.uint64(15)
_WHOLE_VECTORS = np.uint64(0xFFFFFFFFFFFFFFF0)


def _slots_near(m, rank, cumulative, shift, place, slot, guide):
    for j in range(m):
        slot[j] = slot_of_rank(rank[j], cumulative, guide, shift)


def _slots_far(m, rank, cumulative, shift, place, slot, guide):
    last = m - ONE
    for j in range(m):
        prefetch_to_read(guide, U64(rank[min(j + _FAR, last)]) >> shift)
        prefetch_to_read(cumulative, U64(guide[U64(rank[min(j + _NEAR, last)]) >> shift]))
        s = slot_of_rank(rank[j], cumulative, guide, shift)
        prefetch_to_read(place, s)
        slot[j] = s


#: Slots of the ranks of a block. Tables of 2^16 slots and more (guides of 32 bits) do not fit the near caches. There
#: the entries of later photons are fetched early, because the look-ups of one photon wait for each other.
_slots_shuffled = by_width(_slots_far, _slots_near)


@inner_no_refcount
def _parameters_shuffled(m, slot, place, words, bits):
    j = ZERO
    while j + _GROUP <= m:
        copy_group(words, place, slot, bits, j)
        j += _GROUP
    while j < m:
        s = U64(slot[j])
        head, tail = split_place(place[s])
        fill_parameters(bits, j, j + ONE, words, head, tail, slot, s)
        j += ONE


@inner_no_refcount
def _in_order(start, m, rank, cumulative, guide, guide_shift, slot, place, words, bits):
    """Ranks, slots and parameters of consecutive ranks: one run per slot."""
    for j in range(m):
        rank[j] = start + U64(j)
    s = slot_of_rank(rank[0], cumulative, guide, guide_shift)
    j = ZERO
    while j < m:
        end = min(m, U64(cumulative[s + ONE]) - start)
        head, tail = split_place(place[s])
        groups = min(m, j + ((end - j + _REST_OF_GROUP) & ~_REST_OF_GROUP))  # as `vectors` in `emit_runs`
        fill_parameters(bits, j, groups, words, head, tail, slot, s)
        j = end
        s += ONE


@inner_no_refcount
def _places_by_rank(m, rank, shifts, steps, bits, u, v):
    shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
    for j in range(min(m, MAX_PHOTONS)):
        r = U64(rank[j])
        u[j] = unit(shift_u + r * step_u, u[j])
        v[j] = unit(shift_v + r * step_v + ring_offset_of_photon(bits, j), v[j])


@inner_no_refcount
def _places_by_philox(m, rank, key, band, u, v):
    for j in range(m):
        a, b = philox_pair(key, U64(rank[j]), band, ZERO)
        u[j] = unit(a, u[j])
        v[j] = unit(b, v[j])


def _cells(turned, place):
    """The loop over a block for cells of one width and one law."""

    def loop(m, p, u, v, ux, uy, uz):
        for j in range(min(m, MAX_PHOTONS)):
            h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
            sine, cosine = turned(t0, t1, h3, v[j])
            ux[j], uy[j], uz[j] = place(h0, h1, h2, u[j], sine, cosine)

    return inner_no_refcount(loop)


def _cells_by_rank(turned):
    """`_places_by_rank` and the loop of cells in mu^2 in one: the common case spares two arrays."""

    def loop(m, p, rank, shifts, steps, bits, ux, uy, uz):
        shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
        for j in range(min(m, MAX_PHOTONS)):
            r = U64(rank[j])
            h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
            u = unit(shift_u + r * step_u, h0)
            v = unit(shift_v + r * step_v + ring_offset_of_photon(bits, j), h0)
            sine, cosine = turned(t0, t1, h3, v)
            ux[j], uy[j], uz[j] = from_mu2(h0, h1, h2, u, sine, cosine)

    return inner_no_refcount(loop)


_cells_mu2_quarter = _cells(sincos_turned, from_mu2)
_cells_mu2_narrow = _cells(sincos_turned_narrow, from_mu2)
_cells_mu2_any = _cells(sincos_turned_any, from_mu2)
_cells_mu_any = _cells(sincos_turned_any, from_mu)
_quarter_by_rank = _cells_by_rank(sincos_turned)
_narrow_by_rank = _cells_by_rank(sincos_turned_narrow)


@inner_no_refcount
def direction_of(code, parameters, u, v, key, rank, band):
    """Travel direction of one photon of any law but a lobe's, from the six parameters of its cell."""
    h0, h1, h2, h3, t0, t1 = parameters
    if code == laws.DISC:
        return disc(h0, h1, h2, h3, t0, t1, u, v)
    if code == laws.DISC_AT_HORIZON:
        trial = ONE
        hit, x, y, z = disc_at_horizon_trial(h0, h1, h2, h3, t0, t1, u, v)
        while not hit and trial < LAST_TRIAL:
            a, b = philox_pair(key, rank, band, trial)
            hit, x, y, z = disc_at_horizon_trial(h0, h1, h2, h3, t0, t1, unit(a, u), unit(b, v))
            trial += ONE
        return x, y, z
    sine, cosine = sincos_turned_any(t0, t1, h3, v)
    if code == laws.CELL_MU:
        return from_mu(h0, h1, h2, u, sine, cosine)
    return from_mu2(h0, h1, h2, u, sine, cosine)


@inner_no_refcount
def _beside_main(m, main_law, slot, law, is_disc, chosen):
    """Mark the photons of discs and choose all beside the main law; return how many there are of both."""
    n_disc, n, j = ZERO, ZERO, ZERO
    while j < m:  # no branch, which would be guessed wrongly too often
        code = law[U64(slot[j])]
        is_disc[j] = np.uint8(code == laws.DISC)
        n_disc += U64(code == laws.DISC)
        chosen[n] = j
        n += U64(code != main_law)
        j += ONE
    return n_disc, n


@inner_no_refcount
def _discs(m, p, is_disc, u, v, ux, uy, uz):
    """Write the photons of discs over those of the main law; all go through the formula, so that it vectorises."""
    for j in range(min(m, MAX_PHOTONS)):
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        x, y, z = disc(h0, h1, h2, h3, t0, t1, u[j], v[j])
        taken = is_disc[j] != np.uint8(0)
        ux[j], uy[j], uz[j] = select(taken, x, ux[j]), select(taken, y, uy[j]), select(taken, z, uz[j])


@inner_no_refcount
def _one_disc(m, one, slot, p, is_disc, u, v, ux, uy, uz):
    """Write the photons of slot `one`, a disc, over those of the main law, that of all other slots."""
    n_disc = U32(0)
    for j in range(m):
        is_disc[j] = np.uint8(slot[j] == one)
        n_disc = U32(n_disc + is_disc[j])
    if U64(n_disc) * _MANY > m:
        _discs(m, p, is_disc, u, v, ux, uy, uz)
    elif n_disc != U32(0):
        for j in range(m):
            if is_disc[j] != np.uint8(0):
                ux[j], uy[j], uz[j] = disc(*cell_of_photon(p, j), u[j], v[j])


@inner_no_refcount
def _other_laws(m, main_law, slot, law, p, is_disc, chosen, rank, key, band, u, v, ux, uy, uz):
    """Write the photons of slots of another law over those of the main law; lobes have their turn later."""
    n_disc, n = _beside_main(m, main_law, slot, law, is_disc, chosen)
    are_many = n_disc * _MANY > m
    if are_many:
        _discs(m, p, is_disc, u, v, ux, uy, uz)
        if n == n_disc:
            return
    for k in range(n):
        j = chosen[k]
        code = law[U64(slot[j])]
        if laws.HG <= code <= laws.BECKMANN or (are_many and code == laws.DISC):
            continue
        parameters = cell_of_photon(p, j)
        ux[j], uy[j], uz[j] = direction_of(code, parameters, u[j], v[j], key, U64(rank[j]), band)


def emit(
    start,
    ux,
    uy,
    uz,
    cell,
    memory,
    order,
    shifts,
    steps,
    place_key,
    band,
    jitter,
    cumulative,
    guide,
    guide_shift,
    place,
    words,
    values,
    law,
    perez,
    lobes,
    slopes,
    azimuth_kernel,
    one_disc,
    cell_of_slot,
):
    """Write the photons [start, start + ux.size) of a band; the parameters from `order` on are those of `band.Band`.

    `memory` is scratch of `constants.scratch_words` words, zeros at first. Use it for one precision alone, because
    vector loops read stale values behind the last photon. Integers that count photons are uint64.
    """
    like = type(ux[0])(0)
    rank = column(memory, U64(0), MAX_PHOTONS, type(cumulative[0])(0))
    u = column(memory, U64(1), MAX_PHOTONS, like)
    v = column(memory, U64(2), MAX_PHOTONS, like)
    flag = column(memory, U64(3), MAX_PHOTONS, np.uint8(0))
    chosen = column(memory, U64(7), MAX_PHOTONS, ZERO)
    scratch = memory[_PARAMETERS:_PEREZ_MEMORY]
    p, bits = view_as(scratch, like), view_as(scratch, word_like(like))
    if perez_hook is not None:
        word = column(memory, U64(4), MAX_PHOTONS, ZERO)
        cell_word = column(memory, U64(5), MAX_PHOTONS, np.uint32(0))
        jacobian = column(memory, U64(6), MAX_PHOTONS, like)
        perez_memory = perez_hook.perez_scratch(memory[_PEREZ_MEMORY:_LOBES_MEMORY], flag, chosen, like)
    if lobes_hook is not None:
        lobe_memory = lobes_hook.lobe_scratch(memory[_LOBES_MEMORY:], rank[0], lobes, like)
        lobe_steps = (shifts, steps, lobes[2], lobes[3])
    for lo in range(0, ux.size, BLOCK):
        hi = min(lo + BLOCK, ux.size)
        m = U64(hi - lo)
        first = start + U64(lo)
        x, y, z, slot = ux[lo:hi], uy[lo:hi], uz[lo:hi], cell[lo:hi]
        if order.size == 0:
            _in_order(first, m, rank, cumulative, guide, guide_shift, slot, place, words, bits)
        else:
            ranks_of_block(first, m, order, rank)
            _slots_shuffled(m, rank, cumulative, guide_shift, place, slot, guide)
            _parameters_shuffled(m, slot, place, words, bits)
        if law is None:
            if azimuth_kernel == NARROW:
                _narrow_by_rank(m, p, rank, shifts, steps, bits, x, y, z)
            else:
                _quarter_by_rank(m, p, rank, shifts, steps, bits, x, y, z)
        else:
            if perez_hook is not None:
                perez_hook.gather_cell_words(m, slot, perez[0], cell_word)
            if jitter != ZERO:
                _places_by_philox(m, rank, place_key, band, u, v)
                if perez_hook is not None:
                    perez_hook.tilt_block(m, cell_word, u, v, jacobian)
            elif perez_hook is not None:
                perez_hook.tilted_by_rank(m, rank, shifts, steps, bits, cell_word, u, v, jacobian)
            else:
                _places_by_rank(m, rank, shifts, steps, bits, u, v)
            if slopes is not None:
                place_on_slopes(m, slot, slopes, column(memory, U64(4), MAX_PHOTONS, ZERO), u, v)
            if azimuth_kernel == NARROW:
                _cells_mu2_narrow(m, p, u, v, x, y, z)
            elif azimuth_kernel == QUARTER:
                _cells_mu2_quarter(m, p, u, v, x, y, z)
            elif azimuth_kernel == ANY_WIDTH:
                _cells_mu2_any(m, p, u, v, x, y, z)
            else:
                _cells_mu_any(m, p, u, v, x, y, z)
            if one_disc >= np.int32(0):
                _one_disc(m, one_disc, slot, p, flag, u, v, x, y, z)
            elif law.size > 0:
                main_law = laws.CELL_MU if azimuth_kernel == IN_MU else laws.CELL_MU2
                _other_laws(m, main_law, slot, law, p, flag, chosen, rank, place_key, band, u, v, x, y, z)
            if perez_hook is not None:
                perez_words = (word, cell_word, jacobian, perez_memory)
                perez_hook.accept_words(m, rank, perez[3], place_key, band, jitter, word)
                perez_hook.reject(m, slot, rank, p, perez, place_key, band, *perez_words, x, y, z)
            if lobes_hook is not None:
                known = (lobes, lobe_steps, place_key, band, jitter, lobe_memory)
                lobes_hook.place_lobes(U64(lo), m, slot, rank, *known, ux, uy, uz)
        if cell_of_slot.size > 0:
            cells_of_slots(m, cell_of_slot, slot)
    if lobes_hook is not None:
        lobes_hook.place_the_rest(lobes, lobe_steps, place_key, band, jitter, lobe_memory, ux, uy, uz)


@cache
def emit_with(*hooks: str) -> Any:
    """`emit` compiled with these hooks, those of a plan in the order of `hooks`."""
    return no_refcount(with_hooks(emit, hooks))


@no_refcount
def emit_runs(
    start,
    ux,
    uy,
    uz,
    cell,
    memory,
    order,
    shifts,
    steps,
    place_key,
    band,
    jitter,
    cumulative,
    guide,
    guide_shift,
    place,
    words,
    values,
    law,
    perez,
    lobes,
    slopes,
    azimuth_kernel,
    one_disc,
    cell_of_slot,
):
    """Write the photons of the ranks [start, start + ux.size) run by run: the parameters of a cell stay in registers.

    The photons are those of `emit`, 1.5 times as fast if cells hold many of them. It serves the common case: one law
    uniform in mu^2, no cell wider than 90 degrees, positions by rank. Parameters are those of `emit`.
    """
    n = U64(ux.size)
    step_u, step_v = steps[0], steps[1]
    base_u, base_v = shifts[0] + start * step_u, shifts[1] + start * step_v
    s = slot_of_rank(start, cumulative, guide, guide_shift)
    j = ZERO
    while j < n:
        end = min(n, U64(cumulative[s + ONE]) - start)
        head, tail = split_place(place[s])
        parameters = cell_of_table(values, head, tail)
        turned_v = base_v + ring_offset_of_table(words, head, parameters[0])
        c = cell_of_slot[s] if cell_of_slot.size > 0 else np.int32(s)
        # whole vectors: the next run writes the photons beyond the end of this one again
        vectors = min(n, j + ((end - j + _REST_OF_VECTOR) & _WHOLE_VECTORS))
        if azimuth_kernel == NARROW:
            _narrow_run(j, vectors, base_u, turned_v, step_u, step_v, parameters, c, ux, uy, uz, cell)
        else:
            _quarter_run(j, vectors, base_u, turned_v, step_u, step_v, parameters, c, ux, uy, uz, cell)
        j = end
        s += ONE


def _run(turned):
    """The photons lo to hi - 1, which are of one cell."""

    def loop(lo, hi, base_u, base_v, step_u, step_v, parameters, c, ux, uy, uz, cell):
        h0, h1, h2, half_width, t0, t1 = parameters
        bits_u, bits_v = base_u + lo * step_u, base_v + lo * step_v
        for i in range(lo, hi):
            sine, cosine = turned(t0, t1, half_width, unit(bits_v, h0))
            ux[i], uy[i], uz[i] = from_mu2(h0, h1, h2, unit(bits_u, h0), sine, cosine)
            cell[i] = c
            bits_u += step_u  # a sum, because vectors of 64-bit products take longer
            bits_v += step_v

    return inlined_no_refcount(loop)


_narrow_run = _run(sincos_turned_narrow)
_quarter_run = _run(sincos_turned)


@no_refcount
def positions(is_circle, start, key, band, size_x, size_y, x, y):
    """Positions over a circle of diameter `size_x` or a rectangle, from a stream of their own; uint64 and float64."""
    for j in range(U64(x.size)):
        a, b = philox_pair(key, start + j, band, ZERO)
        u, v = unit(a, x[j]), unit(b, x[j])
        if is_circle:
            x[j], y[j] = in_circle(u, v, size_x / 2)
        else:
            x[j], y[j] = in_rectangle(u, v, size_x, size_y)
