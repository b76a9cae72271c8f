"""From a rank to the slot that holds it: a guide table, then at most a few steps."""

from __future__ import annotations

from aomc_sky.kernels.arithmetic.constants import ONE, TWO, U64, ZERO
from aomc_sky.kernels.jit import inner_reader


@inner_reader
def slot_of_rank(r, cumulative, guide, shift):
    """Slot of one rank, uint64; the first step is without a branch."""
    s = U64(guide[U64(r) >> shift])
    if r >= cumulative[s + TWO]:
        s += TWO
        while r >= cumulative[s + ONE]:
            s += ONE
        return s
    return s + U64(r >= cumulative[s + ONE])


@inner_reader
def cells_of_slots(m, cell_of_slot, cell):
    """Replace the slots of a block by the numbers of their cells."""
    j = ZERO
    while j < m:
        c = cell_of_slot[U64(cell[j])]
        if c < 0:  # never: an exit keeps the compiler from turning this loop into slow gathers
            break
        cell[j] = c
        j += ONE
