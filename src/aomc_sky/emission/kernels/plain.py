"""The emission of `emit` in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down.

The formulas are those of the kernels, called with whole arrays; the tests compare both forms bit by bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.arithmetic.elementary import sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells.laws import BECKMANN, HG, PEREZ, directions_of, positions_in_cells, sloped
from aomc_sky.kernels.cells.order import ranks_of_photons
from aomc_sky.kernels.formula import formula, kind_of


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
    slopes,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, stop) of a band with n photons.

    `finder` comes from `slot_finder` over the counts of all cells; `turns` holds the ring of each
    cell and the turn of each ring; `cells` (n_cell, 6) in the precision of the outputs; `laws` int8 (n_cell,); `perez`
    holds words and bounds (n_cell,), the sky's numbers and the steps of the first trial, or None; `lobes` the lobe of
    each cell, the tables of `lobes.kernels.law`, the steps of the first trial, and `falls` with `paces`; `slopes` the
    words of `laws.sloped` (n_cell,), or None. Other parameters are those of the kernel.
    """
    is_shuffled = order_keys.size > 0
    rank = ranks_of_photons(start, stop, n, order_keys) if is_shuffled else np.arange(start, stop, dtype=U64)
    cell[:] = finder(rank)
    u, v = positions_in_cells(rank, jitter, place_key, band, shifts, steps, turns[1][turns[0][cell]], ux)
    if slopes is not None:
        u, v = sloped(u, v, slopes[cell])
    law = laws[cell]
    for code in np.flatnonzero(np.bincount(law)):
        chosen = slice(None) if np.all(law == code) else np.flatnonzero(law == code)
        p = tuple(cells[:, j][cell[chosen]] for j in range(6))
        if code == PEREZ and perez is not None:
            from aomc_sky.skies.perez.kernels.cells import accept_words, place_perez

            looked_up = (perez[0][cell[chosen]], perez[1][cell[chosen]], perez[2])
            word = accept_words(rank[chosen], perez[3], place_key, band, jitter)
            directions = place_perez(p, looked_up, u[chosen], v[chosen], word, place_key, rank[chosen], band)
        elif HG <= code <= BECKMANN:
            from aomc_sky.skies.lobes.kernels.law import lobe_words, place_lobes

            lobe = lobes[0][cell[chosen]]
            word = lobe_words(rank[chosen], lobe, lobes[3], shifts, steps, lobes[2], place_key, band, jitter)
            directions = place_lobes(lobe, lobes[1], word, place_key, rank[chosen], band)
        else:
            directions = directions_of(code, p, u[chosen], v[chosen], place_key, rank[chosen], band)
        ux[chosen], uy[chosen], uz[chosen] = directions


@formula
def in_circle(u, v, radius):
    """Position from two uniform numbers, uniform over a circle around the origin: r = radius sqrt(u)."""
    zero, one = kind_of(u)(0), kind_of(u)(1)
    sine, cosine = sincos_turned_any(zero, one, one + one, v)
    r = kind_of(u)(radius) * np.sqrt(u)
    return r * cosine, r * sine


@formula
def in_rectangle(u, v, size_x, size_y):
    """Position from two uniform numbers, uniform over a rectangle centred on the origin."""
    kind = kind_of(u)
    return kind(size_x) * (u - kind(0.5)), kind(size_y) * (v - kind(0.5))


def positions(shape_is_circle, start, key, band, size_x, size_y, x, y):
    """Positions over a circle of diameter size_x or a rectangle, from a stream of their own."""
    a, b = philox_pair(key, np.arange(start, start + x.size, dtype=U64), U64(band), U64(0))
    u, v = unit(a, x), unit(b, x)
    x[:], y[:] = in_circle(u, v, size_x / 2) if shape_is_circle else in_rectangle(u, v, size_x, size_y)


def numbers(start, out, n, order_keys, shifts, steps, key, band, jitter):
    """The numbers of the photons from `start` on, as in `kernels.numbers`; `out` (n, k)."""
    stop = start + out.shape[0]
    rank = ranks_of_photons(start, stop, n, order_keys) if order_keys.size else np.arange(start, stop, dtype=U64)
    for c in range(out.shape[1]):
        if jitter:
            word = philox_pair(key, rank, band, U64(2 if c == 2 else 1))[c % 2]
        else:
            word = shifts[c] + rank * steps[c]
        out[:, c] = unit(word, out)
