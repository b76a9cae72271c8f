"""From a rank to the slot that holds it: a guide table, then at most a few steps."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner_reader

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)


@inner_reader
def slot_of_rank(r, cumulative, guide, shift):
    """Slot of one rank, uint64; the first step is without a branch."""
    s = _U64(guide[_U64(r) >> shift])
    if r >= cumulative[s + _TWO]:
        s += _TWO
        while r >= cumulative[s + _ONE]:
            s += _ONE
        return s
    return s + _U64(r >= cumulative[s + _ONE])


@inner_reader
def cells_of_slots(m, cell_of_slot, cell):
    """Replace the slots of a block by the numbers of their cells."""
    j = _ZERO
    while j < m:
        c = cell_of_slot[_U64(cell[j])]
        if c < 0:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        cell[j] = c
        j += _ONE
