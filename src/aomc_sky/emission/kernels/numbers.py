"""Numbers that a photon carries for its host, from its rank alone: of a scrambled net, of a lattice, or of Philox."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import BLOCK, ONE, THREE, TWO, U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import unit
from aomc_sky.kernels.arithmetic.net import digits_of_x2_plus_x_plus_1, digits_of_x_plus_1, index_of_rank, net_word
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells.blocks import rank_of_photon, ranks_of_block
from aomc_sky.kernels.jit import inlined, inner_no_refcount, kernel


@inner_no_refcount
def _by_rank(m, rank, shift, step, out):
    for j in range(m):
        out[j] = unit(shift + rank[j] * step, out[j])


@inner_no_refcount
def _points(m, rank, key, index):
    for j in range(m):
        index[j] = index_of_rank(rank[j], key)


@inner_no_refcount
def _first_of_net(m, index, key, out):
    for j in range(m):
        out[j] = unit(net_word(index[j], key), out[j])


@inner_no_refcount
def _second_of_net(m, index, key, out):
    for j in range(m):
        out[j] = unit(net_word(digits_of_x_plus_1(index[j]), key), out[j])


@inner_no_refcount
def _third_of_net(m, index, key, out):
    for j in range(m):
        out[j] = unit(net_word(digits_of_x2_plus_x_plus_1(index[j]), key), out[j])


@inner_no_refcount
def _by_net(m, index, key, c, out):
    if c == 0:
        _first_of_net(m, index, key, out)
    elif c == 1:
        _second_of_net(m, index, key, out)
    else:
        _third_of_net(m, index, key, out)


@inner_no_refcount
def _by_philox(m, rank, key, band, draw, is_second, out):
    for j in range(m):
        first, second = philox_pair(key, rank[j], band, draw)
        out[j] = unit(second if is_second else first, out[j])


@kernel
def numbers_of_photons(start, first, second, third, order, shifts, steps, key, band, jitter):
    """Write the numbers of the photons from `start` on (uint64) into three arrays; an empty one is left out.

    With `jitter` 0 they are of the net, whose keys are the words `shifts`, uint64 (4,), the last one that of the rank.
    Where there are `steps`, uint64 (3,), they are shift + rank x step, as 64-bit fractions. With `jitter` not 0: words
    of Philox, counter (rank, `band`, 1) for two of them and (rank, `band`, 2) for the third. Others as in `emit`.
    """
    rank, index = np.empty(BLOCK, np.uint64), np.empty(BLOCK, np.uint32)
    size = max(first.size, second.size, third.size)
    for lo in range(0, size, BLOCK):
        hi = min(lo + BLOCK, size)
        m = U64(hi - lo)
        if order.size == 0:
            for j in range(m):
                rank[j] = start + U64(lo) + j
        else:
            ranks_of_block(start + U64(lo), m, order, rank)
        if steps is None and jitter == ZERO:
            _points(m, rank, shifts[THREE], index)
        for c, out in enumerate((first, second, third)):
            if out.size == 0:
                continue
            if jitter == ZERO:
                if steps is None:
                    _by_net(m, index, shifts[c], c, out[lo:hi])
                else:
                    _by_rank(m, rank, shifts[c], steps[c], out[lo:hi])
            else:
                _by_philox(m, rank, key, band, TWO if c == 2 else ONE, c == 1, out[lo:hi])


@inlined
def three_numbers(i, like, order, shifts, steps, key, band, jitter):
    """The numbers of photon i; arguments as in `sampler.photon_at`, `like` is any number of the precision."""
    rank = i if order is None else rank_of_photon(i, order)
    if jitter is not None:
        a, b = philox_pair(key, rank, band, ONE)
        c, _ = philox_pair(key, rank, band, TWO)
    elif steps is None:
        index = index_of_rank(U64(rank), shifts[3])
        a, b = net_word(index, shifts[0]), net_word(digits_of_x_plus_1(index), shifts[1])
        c = net_word(digits_of_x2_plus_x_plus_1(index), shifts[2])
    else:
        a, b, c = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1], shifts[2] + rank * steps[2]
    return unit(a, like), unit(b, like), unit(c, like)
