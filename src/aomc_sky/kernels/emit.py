"""Photon i of a band, for i in [start, stop): rank, cell, place in the cell, travel direction.

Work goes in blocks that stay in the cache, one simple loop per step, because simple loops vectorise
and a fused one does not. A band is a table of *slots*: its cells with at least one photon, in order.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import cells
from aomc_sky.kernels.elementary import unit
from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.order import permute_step, split_order
from aomc_sky.kernels.rng import R2_STEP_U, R2_STEP_V, philox_pair

BLOCK = 2048

PATCH_ORDER = 0
SHUFFLED = 1

R2 = 0
PHILOX = 1
CENTRE = 2

_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_HALF = np.uint64(1 << 63)


@kernel
def build_guide(cumulative, shift, guide):
    """Fill guide[b] with the slot that holds rank b << shift; one entry more closes the table."""
    slot = 0
    last = cumulative.size - 2
    for b in range(guide.size):
        rank = np.int64(np.uint64(b) << shift)
        while slot < last and cumulative[slot + 1] <= rank:
            slot += 1
        guide[b] = slot


@inner
def _shuffled_ranks(start, m, n, keys, rank):
    s, b = split_order(n)
    k0, k1, k2, k3 = keys[0], keys[1], keys[2], keys[3]
    beyond = _ZERO
    for j in range(m):
        r = permute_step(start + np.uint64(j), s, b, k0, k1, k2, k3)
        rank[j] = r
        beyond += np.uint64(r >= n)
    if beyond != _ZERO:
        for j in range(m):
            r = rank[j]
            while r >= n:
                r = permute_step(r, s, b, k0, k1, k2, k3)
            rank[j] = r


@inner
def _slots_of_ranks(m, rank, cumulative, guide, shift, slot):
    for j in range(m):
        r = np.int64(rank[j])
        bucket = np.int64(rank[j] >> shift)
        lo = guide[bucket]
        hi = guide[bucket + 1]
        while hi - lo > 4:
            middle = (lo + hi) >> 1
            if cumulative[middle] <= r:
                lo = middle
            else:
                hi = middle
        while cumulative[lo + 1] <= r:
            lo += 1
        slot[j] = lo


@inner
def _slots_in_order(start, m, cumulative, first, slot):
    """Slots of the consecutive ranks from `start`; `first` is the slot of the first of them."""
    k = first
    j = 0
    while j < m:
        end = min(m, cumulative[k + 1] - start)
        run = slot[j:end]
        run[:] = k
        j = max(j, end)
        k += 1


@inner
def _places(m, rank, placement, shift_u, shift_v, key, band, u, v):
    like = u[0]
    if placement == R2:
        for j in range(m):
            u[j] = unit(shift_u + rank[j] * R2_STEP_U, like)
            v[j] = unit(shift_v + rank[j] * R2_STEP_V, like)
    elif placement == PHILOX:
        for j in range(m):
            a, b = philox_pair(key, rank[j], band, _ZERO)
            u[j] = unit(a, like)
            v[j] = unit(b, like)
    else:
        for j in range(m):
            u[j] = unit(_HALF, like)
            v[j] = unit(_HALF, like)


@inner
def _place_block(m, main_law, slot, table, u, v, ux, uy, uz):
    if main_law == cells.CELL_MU:
        for j in range(m):
            t = slot[j]
            ux[j], uy[j], uz[j] = cells.cell_mu(
                table[t, 0], table[t, 1], table[t, 2], table[t, 3], table[t, 4], table[t, 5], u[j], v[j]
            )
    else:
        for j in range(m):
            t = slot[j]
            ux[j], uy[j], uz[j] = cells.cell_mu2(
                table[t, 0], table[t, 1], table[t, 2], table[t, 3], table[t, 4], table[t, 5], u[j], v[j]
            )


@inner
def _place_others(m, main_law, slot, law, table, rank, key, band, u, v, ux, uy, uz):
    for j in range(m):
        t = slot[j]
        code = law[t]
        if code == main_law:
            continue
        p0, p1, p2, p3, p4, p5 = table[t, 0], table[t, 1], table[t, 2], table[t, 3], table[t, 4], table[t, 5]
        if code == cells.DISC:
            ux[j], uy[j], uz[j] = cells.disc(p0, p1, p2, p3, p4, p5, u[j], v[j])
        elif code == cells.DISC_AT_HORIZON:
            ux[j], uy[j], uz[j] = cells.disc_at_horizon(
                p0, p1, p2, p3, p4, p5, u[j], v[j], key, rank[j], band
            )
        elif code == cells.CELL_MU:
            ux[j], uy[j], uz[j] = cells.cell_mu(p0, p1, p2, p3, p4, p5, u[j], v[j])
        else:
            ux[j], uy[j], uz[j] = cells.cell_mu2(p0, p1, p2, p3, p4, p5, u[j], v[j])


@kernel
def emit(
    start,
    n,
    order,
    order_keys,
    placement,
    place_key,
    shifts,
    band,
    cumulative,
    guide,
    guide_shift,
    cell_of_slot,
    law,
    main_law,
    mixed,
    table,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, start + ux.size) of a band with n photons.

    Parameters are flat on purpose: integers in int64 or uint64, tables of the band's slots
    (`cumulative` (n_slot + 1,) int64, `cell_of_slot` int32, `law` int8, `table` (n_slot, 6) in the
    precision of the output), outputs `ux`, `uy`, `uz`, `cell` of one length.
    """
    rank = np.empty(BLOCK, np.uint64)
    slot = np.empty(BLOCK, np.int32)
    u = np.empty(BLOCK, ux.dtype)
    v = np.empty(BLOCK, ux.dtype)
    for lo in range(0, ux.size, BLOCK):
        hi = min(lo + BLOCK, ux.size)
        m = hi - lo
        first = start + lo
        if order == SHUFFLED:
            _shuffled_ranks(np.uint64(first), m, np.uint64(n), order_keys, rank)
            _slots_of_ranks(m, rank, cumulative, guide, guide_shift, slot)
        else:
            for j in range(m):
                rank[j] = np.uint64(first) + np.uint64(j)
            _slots_of_ranks(1, rank, cumulative, guide, guide_shift, slot)
            _slots_in_order(first, m, cumulative, slot[0], slot)
        _places(m, rank, placement, shifts[0], shifts[1], place_key, band, u, v)
        _place_block(m, main_law, slot, table, u, v, ux[lo:hi], uy[lo:hi], uz[lo:hi])
        if mixed:
            _place_others(
                m, main_law, slot, law, table, rank, place_key, band, u, v, ux[lo:hi], uy[lo:hi], uz[lo:hi]
            )
        o = cell[lo:hi]
        for j in range(m):
            o[j] = cell_of_slot[slot[j]]
