"""The emission of `emit` in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down.

Every formula stands here a second time, written for whole arrays; the tests compare both forms bit by bit.
Only + - x / sqrt, integers and rounding are used, so numpy gives the same bits as the kernels everywhere.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.arithmetic.plain import philox, sincos_turned, unit
from aomc_sky.kernels.cells.plain import BECKMANN, HG, PEREZ, place, places, shuffled_ranks


def emit(
    start,
    stop,
    n,
    order_keys,
    shifts,
    steps,
    place_key,
    band,
    jitter,
    finder,
    turns,
    cells,
    laws,
    perez,
    lobes,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, stop) of a band with n photons.

    `finder` comes from `slot_finder` over the counts of all cells; `turns` holds the ring of each
    cell and the turn of each ring; `cells` (n_cell, 6) in the precision
    of the outputs; `laws` int8 (n_cell,); `perez` holds words and bounds (n_cell,), the sky's numbers and
    the steps of the first trial, or None; `lobes` the lobe of each cell, the tables of `lobes.plain`, the steps of
    the first trial, and `falls` with `paces`. Other parameters are those of the kernel.
    """
    rank = np.arange(start, stop, dtype=U64) if order_keys is None else shuffled_ranks(start, stop, n, order_keys)
    cell[:] = finder(rank)
    u, v = places(rank, jitter, place_key, band, shifts, steps, turns[1][turns[0][cell]], ux.dtype)
    law = laws[cell]
    for code in np.unique(law):
        chosen = slice(None) if np.all(law == code) else np.flatnonzero(law == code)
        p = tuple(cells[:, j][cell[chosen]] for j in range(6))
        if code == PEREZ and perez is not None:
            from aomc_sky.kernels.perez.plain_cells import accept_words, place_perez

            looked_up = (perez[0][cell[chosen]], perez[1][cell[chosen]], perez[2])
            word = accept_words(rank[chosen], perez[3], place_key, band, jitter)
            directions = place_perez(p, looked_up, u[chosen], v[chosen], word, place_key, rank[chosen], band)
        elif HG <= code <= BECKMANN:
            from aomc_sky.kernels.lobes.plain import lobe_words, place_lobes

            lobe = lobes[0][cell[chosen]]
            word = lobe_words(rank[chosen], lobe, lobes[3], shifts, steps, lobes[2], place_key, band, jitter)
            directions = place_lobes(lobe, lobes[1], word, place_key, rank[chosen], band)
        else:
            directions = place(code, p, u[chosen], v[chosen], place_key, rank[chosen], band)
        ux[chosen], uy[chosen], uz[chosen] = directions


def positions(shape_is_circle, start, key, band, size_x, size_y, x, y):
    """Positions over a circle of diameter size_x or a rectangle, as `positions` makes them."""
    a, b = philox(key, np.arange(start, start + x.size, dtype=U64), band, 0)
    u, v, kind = unit(a, x.dtype), unit(b, x.dtype), x.dtype.type
    if shape_is_circle:
        sine, cosine = sincos_turned(kind(0), kind(1), kind(2), v)
        r = kind(size_x / 2) * np.sqrt(u)
        x[:], y[:] = r * cosine, r * sine
    else:
        x[:], y[:] = kind(size_x) * (u - kind(0.5)), kind(size_y) * (v - kind(0.5))
