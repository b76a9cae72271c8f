"""From a rank to the slot that holds it: a guide table, then at most a few steps."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner_reader, kernel

_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)


@kernel
def build_guide(cumulative, shift, guide):
    """Fill guide[b] with the slot that holds rank b << shift; `cumulative` ends with two sentinels."""
    slot = _ZERO
    last = _U64(cumulative.size - 4)
    for b in range(guide.size):
        rank = _U64(b) << shift
        while slot < last and cumulative[slot + _ONE] <= rank:
            slot += _ONE
        guide[b] = slot


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
