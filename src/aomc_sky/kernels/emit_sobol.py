"""Photon i of a lane by marginal and conditional inversion of scrambled Sobol points, for i in [start, stop).

`sobol_cells` finds the cells and the places in them; the laws inside cells are those of `emit`, block by block.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import cells
from aomc_sky.kernels.emit import (
    BLOCK,
    _cells_mu2,
    _cells_mu2_any,
    _cells_mu_any,
    _cells_of_slots,
    _other_laws,
    _parameters_shuffled,
)
from aomc_sky.kernels.jit import kernel
from aomc_sky.kernels.lobe_cells import lobe_scratch, place_lobes, place_the_rest
from aomc_sky.kernels.parameters import scratch_words
from aomc_sky.kernels.perez_cells import gather_cell_words, perez_scratch, reject, tilt_block
from aomc_sky.kernels.sobol_cells import cells_of_block, decision_words, scratch_of_cells, start_split

_U64 = np.uint64
_ONE = np.uint64(1)


@kernel
def emit_sobol(
    start,
    lane,
    key,
    tree,
    tops,
    keys,
    tables,
    place,
    words,
    law,
    main_in_mu,
    main_is_mixed,
    is_narrow,
    perez,
    lobes,
    cell_of_slot,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, start + ux.size) of a lane; at most 2^32 photons, at least one.

    `lane` and `key` address the random numbers below the scrambled levels. `tree` holds the photons of
    the nodes above the components, as in `plain_sobol.component_points`. For each component `tops` (uint16)
    has 2 x 4096 entries and `keys` (uint32) 2 x 8 x 2, as `sobol.sobol_range` reads them. `tables` holds flat
    arrays: the bounds of each component's part in them; then of the rings the cumulative masses in units
    of 2^-62 with two sentinels, and a guide; and the same of the cells. The other parameters are those of `emit`;
    `perez` is (words of the slots, bound, sky), `lobes` (lobe of each slot, tables).
    """
    memory = scratch_of_cells(_U64(tree.size) >> _ONE, ux)
    scratch = scratch_words(ux)
    p = scratch.view(ux.dtype)
    u = np.zeros(BLOCK, ux.dtype)
    v = np.zeros(BLOCK, ux.dtype)
    photon = np.empty(BLOCK, np.uint64)
    word = np.empty(BLOCK, np.uint64)
    if lobes is not None:
        lobe_memory = lobe_scratch(photon, lobes, True, ux)
    if perez is not None:
        perez_memory = perez_scratch(BLOCK, ux)
        cell_word = np.empty(BLOCK, np.uint32)
        jacobian = np.empty(BLOCK, ux.dtype)
    start_split(start, tree, memory[0][0], memory[0][1])
    for lo in range(0, ux.size, BLOCK):
        hi = min(lo + BLOCK, ux.size)
        m = _U64(hi - lo)
        first = start + _U64(lo)
        x, y, z, slot = ux[lo:hi], uy[lo:hi], uz[lo:hi], cell[lo:hi]
        cells_of_block(first, m, lane, key, tree, tops, keys, tables, memory, slot, u, v)
        _parameters_shuffled(m, slot, place, words, scratch, u[0])
        for j in range(m):
            photon[j] = first + j
        if perez is not None:
            gather_cell_words(m, slot, perez[0], cell_word)
            tilt_block(m, cell_word, u, v, jacobian)
        if main_in_mu is not None:
            _cells_mu_any(m, p, u, v, x, y, z)
        elif main_is_mixed is not None:
            _cells_mu2_any(m, p, u, v, x, y, z)
        else:
            _cells_mu2(m, p, u, v, is_narrow, x, y, z)
        if law is not None:
            main = cells.CELL_MU2 if main_in_mu is None else cells.CELL_MU
            _other_laws(m, main, slot, law, p, photon, key, lane, u, v, x, y, z)
        if perez is not None:
            decision_words(m, memory[1][0], memory[1][1], word)
            reject(m, slot, photon, p, perez, key, lane, word, cell_word, jacobian, perez_memory, x, y, z)
        if lobes is not None:
            decision_words(m, memory[1][0], memory[1][1], word)
            places = (u, v, word)
            place_lobes(_U64(lo), m, slot, photon, places, lobes, None, key, lane, None, lobe_memory, ux, uy, uz)
        if cell_of_slot is not None:
            _cells_of_slots(m, cell_of_slot, slot)
    if lobes is not None:
        place_the_rest(lobes, None, key, lane, None, lobe_memory, ux, uy, uz)
