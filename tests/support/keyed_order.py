"""The keyed order of photons there and back, compiled for tests."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.cells.blocks import ranks_of_block
from aomc_sky.kernels.cells.order import SHORT_LIMIT, high_step, split_order, stir
from aomc_sky.kernels.jit import inner, shared

_U32, _U64 = np.uint32, np.uint64
_ONE, _S32 = np.uint64(1), np.uint64(32)


@shared
def ranks_of_range(start, n, keys, rank):
    """Rank of each photon of [start, start + rank.size) of n: start and n uint64, rank uint64."""
    ranks_of_block(start, _U64(rank.size), n, keys, rank)


@shared
def indices_of_ranks(rank, n, keys, index):
    """Photon index that has each rank: the inverse of `ranks_of_range`, for any ranks below n."""
    s, b = split_order(n)
    is_short = n <= SHORT_LIMIT
    k0, k1, k2 = _U32(keys[0]), _U32(keys[1]), _U32(keys[2])
    for j in range(rank.size):
        i = _unpermute(rank[j], s, b, k0, k1, k2, is_short)
        while i >= n:
            i = _unpermute(i, s, b, k0, k1, k2, is_short)
        index[j] = i


@inner
def _unpermute(i, s, b, k0, k1, k2, is_short):
    """Inverse of both passes of the order."""
    mask = (_ONE << s) - _ONE
    low = i & mask
    high = (i >> s) + b
    if is_short:
        high = high - (((_U64(stir(_U32(low), k2)) >> _U64(16)) * b) >> _U64(16))
    else:
        high = high - high_step(low, k2, b)
    high = high - b if high >= b else high
    low = (low - (_U64(stir(_U32(high), k1)) >> (_S32 - s))) & mask
    high = high + b
    if is_short:
        high = high - (((_U64(stir(_U32(low), k0)) >> _U64(16)) * b) >> _U64(16))
    else:
        high = high - high_step(low, k0, b)
    high = high - b if high >= b else high
    return (high << s) | low
