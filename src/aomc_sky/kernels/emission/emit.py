"""Photon i of a band, for i in [start, stop): rank, slot, place in the cell, travel direction.

A band is a table of *slots*: its cells with at least one photon, in order. Work goes in blocks that
stay in the cache, one simple loop per step: simple loops vectorise, a fused one does not, and a
vectorised table look-up (a gather) costs more than the scalar one on most processors.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ANY_WIDTH, IN_MU, NARROW, ONE, U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import sincos_turned, sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells import laws as cells
from aomc_sky.kernels.cells.order import shuffled_ranks
from aomc_sky.kernels.cells.parameters import (
    MAX_PHOTONS,
    cell_of_photon,
    copy_parameters,
    fill_parameters,
    scratch_words,
    split_place,
    turn_bits,
    turn_of_photon,
)
from aomc_sky.kernels.cells.slots import cells_of_slots, slot_of_rank
from aomc_sky.kernels.jit import inner_reader, kernel
from aomc_sky.kernels.lobes.cells import lobe_scratch, place_lobes, place_the_rest
from aomc_sky.kernels.perez.cells import (
    accept_words,
    gather_cell_words,
    perez_scratch,
    reject,
    tilt_block,
    tilted_by_rank,
)

BLOCK = 2048


@inner_reader
def _slots_shuffled(m, rank, cumulative, guide, shift, slot):
    for j in range(m):
        slot[j] = slot_of_rank(rank[j], cumulative, guide, shift)


@inner_reader
def _parameters_shuffled(m, slot, place, words, scratch, like):
    j = ZERO
    while j < m:
        head, tail = split_place(place[U64(slot[j])])
        copy_parameters(scratch, j, words, head, tail, like)
        if tail == ZERO:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        j += ONE


@inner_reader
def _in_order(start, m, rank, cumulative, first_slot, slot, place, words, scratch, like):
    """Ranks, slots and parameters of consecutive ranks: one run per slot."""
    for j in range(m):
        rank[j] = start + U64(j)
    s = first_slot
    j = ZERO
    while j < m:
        end = min(m, U64(cumulative[s + ONE]) - start)
        head, tail = split_place(place[s])
        fill_parameters(scratch, j, end, words, head, tail, slot, s, like)
        j = end
        s += ONE


@inner_reader
def _places_by_rank(m, rank, shifts, steps, bits, u, v):
    shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
    for j in range(min(m, MAX_PHOTONS)):
        r = U64(rank[j])
        u[j] = unit(shift_u + r * step_u, u[j])
        v[j] = unit(shift_v + r * step_v + turn_of_photon(bits, j), v[j])


@inner_reader
def _places_by_philox(m, rank, key, band, u, v):
    for j in range(m):
        a, b = philox_pair(key, U64(rank[j]), band, ZERO)
        u[j] = unit(a, u[j])
        v[j] = unit(b, v[j])


@inner_reader
def _cells_of_width(m, p, u, v, is_narrow, ux, uy, uz):
    for j in range(min(m, MAX_PHOTONS)):
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        sine, cosine = sincos_turned(t0, t1, h3, v[j], is_narrow)
        ux[j], uy[j], uz[j] = cells.from_mu2(h0, h1, h2, u[j], sine, cosine)


@inner_reader
def _cells_mu2(m, p, u, v, main, ux, uy, uz):
    if main == NARROW:
        _cells_of_width(m, p, u, v, True, ux, uy, uz)
    else:
        _cells_of_width(m, p, u, v, None, ux, uy, uz)


@inner_reader
def _cells_mu2_by_rank(m, p, rank, shifts, steps, bits, is_narrow, ux, uy, uz):
    """`_places_by_rank` and `_cells_of_width` in one: the common case spares two arrays."""
    shift_u, shift_v, step_u, step_v = shifts[0], shifts[1], steps[0], steps[1]
    for j in range(min(m, MAX_PHOTONS)):
        r = U64(rank[j])
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        u = unit(shift_u + r * step_u, h0)
        v = unit(shift_v + r * step_v + turn_of_photon(bits, j), h0)
        sine, cosine = sincos_turned(t0, t1, h3, v, is_narrow)
        ux[j], uy[j], uz[j] = cells.from_mu2(h0, h1, h2, u, sine, cosine)


@inner_reader
def _cells_mu2_any(m, p, u, v, ux, uy, uz):
    for j in range(min(m, MAX_PHOTONS)):
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        sine, cosine = sincos_turned_any(t0, t1, h3, v[j])
        ux[j], uy[j], uz[j] = cells.from_mu2(h0, h1, h2, u[j], sine, cosine)


@inner_reader
def _cells_mu_any(m, p, u, v, ux, uy, uz):
    for j in range(min(m, MAX_PHOTONS)):
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        sine, cosine = sincos_turned_any(t0, t1, h3, v[j])
        ux[j], uy[j], uz[j] = cells.from_mu(h0, h1, h2, u[j], sine, cosine)


@inner_reader
def _other_laws(m, main_law, slot, law, p, rank, key, band, u, v, ux, uy, uz):
    """Write the photons of slots of another law over those of the main law; lobes have their turn later."""
    for j in range(m):
        code = law[U64(slot[j])]
        if code == main_law or cells.HG <= code <= cells.BECKMANN:
            continue
        h0, h1, h2, h3, t0, t1 = cell_of_photon(p, j)
        if code == cells.DISC:
            ux[j], uy[j], uz[j] = cells.disc(h0, h1, h2, h3, t0, t1, u[j], v[j])
        elif code == cells.DISC_AT_HORIZON:
            ux[j], uy[j], uz[j] = cells.disc_at_horizon(h0, h1, h2, h3, t0, t1, u[j], v[j], key, U64(rank[j]), band)
        else:
            sine, cosine = sincos_turned_any(t0, t1, h3, v[j])
            if code == cells.CELL_MU:
                ux[j], uy[j], uz[j] = cells.from_mu(h0, h1, h2, u[j], sine, cosine)
            else:
                ux[j], uy[j], uz[j] = cells.from_mu2(h0, h1, h2, u[j], sine, cosine)


@kernel
def emit(
    start,
    n,
    order_keys,
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
    main,
    law,
    perez,
    lobes,
    cell_of_slot,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, start + ux.size) of a band with n photons.

    Parameters are flat on purpose, and an option that is off is None: numba then compiles only what
    a scene needs. `order_keys` None leaves the photons in the order of the cells; `jitter` None
    takes the place in the cell from `shifts` + rank x `steps` (+ the ring's turn for v) instead of Philox. `main` is
    the way of most slots, one of `constants.NARROW` and those after it. `law` None is the common case: all slots go
    this way, NARROW or QUARTER, and `jitter` is None. Else it is the law of each slot (int8), empty where all go the
    main way. `perez` is what `perez.cells.reject` reads, and the steps of its first trial; `lobes` holds the lobe of
    each slot (int32, -1 for none), the tables of `lobes.plain`, the steps of its first trial, and `falls` with
    `paces`; `cell_of_slot` (int32) is empty where slot = cell.

    Tables of the band: `cumulative` (n_slot + 3,), the ranks before each slot and two sentinels;
    `guide`, the slot of every 2^guide_shift-th rank; `place`, one word per slot, whose
    halves are the positions of its ring's and its column's parameters in `words` (see `parameters`). Outputs have one
    length and, for directions, one precision. Integers that count photons are uint64.
    """
    rank = np.empty(BLOCK, cumulative.dtype)
    scratch = scratch_words(ux)
    p = scratch.view(ux.dtype)
    bits = turn_bits(scratch, ux)
    u = np.zeros(BLOCK, ux.dtype)
    v = np.zeros(BLOCK, ux.dtype)
    if perez is not None:
        word = np.empty(BLOCK, np.uint64)
        cell_word = np.empty(BLOCK, np.uint32)
        jacobian = np.empty(BLOCK, ux.dtype)
        perez_memory = perez_scratch(BLOCK, ux)
    if lobes is not None:
        lobe_memory = lobe_scratch(rank, lobes, ux)
        lobe_steps = (shifts, steps, lobes[2], lobes[3])
    for lo in range(0, ux.size, BLOCK):
        hi = min(lo + BLOCK, ux.size)
        m = U64(hi - lo)
        first = start + U64(lo)
        x, y, z, slot = ux[lo:hi], uy[lo:hi], uz[lo:hi], cell[lo:hi]
        if order_keys is None:
            rank[0] = first
            s = slot_of_rank(rank[0], cumulative, guide, guide_shift)
            _in_order(first, m, rank, cumulative, s, slot, place, words, scratch, u[0])
        else:
            shuffled_ranks(first, m, n, order_keys, rank)
            _slots_shuffled(m, rank, cumulative, guide, guide_shift, slot)
            _parameters_shuffled(m, slot, place, words, scratch, u[0])
        if perez is not None:
            gather_cell_words(m, slot, perez[0], cell_word)
        if law is None:
            if perez is not None:
                tilted_by_rank(m, rank, shifts, steps, bits, cell_word, u, v, jacobian)
                _cells_mu2(m, p, u, v, main, x, y, z)
            elif main == NARROW:
                _cells_mu2_by_rank(m, p, rank, shifts, steps, bits, True, x, y, z)
            else:
                _cells_mu2_by_rank(m, p, rank, shifts, steps, bits, None, x, y, z)
        else:
            if jitter is not None:
                _places_by_philox(m, rank, place_key, band, u, v)
                if perez is not None:
                    tilt_block(m, cell_word, u, v, jacobian)
            elif perez is not None:
                tilted_by_rank(m, rank, shifts, steps, bits, cell_word, u, v, jacobian)
            else:
                _places_by_rank(m, rank, shifts, steps, bits, u, v)
            if main == IN_MU:
                _cells_mu_any(m, p, u, v, x, y, z)
            elif main == ANY_WIDTH:
                _cells_mu2_any(m, p, u, v, x, y, z)
            else:
                _cells_mu2(m, p, u, v, main, x, y, z)
            if law.size > 0:
                main_law = cells.CELL_MU if main == IN_MU else cells.CELL_MU2
                _other_laws(m, main_law, slot, law, p, rank, place_key, band, u, v, x, y, z)
        if perez is not None:
            accept_words(m, rank, perez[3], place_key, band, jitter, word)
            reject(m, slot, rank, p, perez, place_key, band, word, cell_word, jacobian, perez_memory, x, y, z)
        if lobes is not None:
            place_lobes(U64(lo), m, slot, rank, lobes, lobe_steps, place_key, band, jitter, lobe_memory, ux, uy, uz)
        if cell_of_slot.size > 0:
            cells_of_slots(m, cell_of_slot, slot)
    if lobes is not None:
        place_the_rest(lobes, lobe_steps, place_key, band, jitter, lobe_memory, ux, uy, uz)
