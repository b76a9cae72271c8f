"""The kernels in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down.

The formulas are those of the kernels, called with whole arrays; the tests compare both forms bit by bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.component import Law
from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.arithmetic.elementary import sincos_turned_any, unit
from aomc_sky.kernels.arithmetic.net import digits_of_x2_plus_x_plus_1, digits_of_x_plus_1, index_of_rank, net_word
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells.laws import positions_in_cells, sloped
from aomc_sky.kernels.cells.order import ranks_of_photons
from aomc_sky.kernels.formula import formulas, kind_of, larger, select
from aomc_sky.plan.laws import law_of

_BLOCK = 4096  # records of intermediate arrays that stay in the cache


def emit(
    start,
    stop,
    order,
    shifts,
    steps,
    place_key,
    band,
    jitter,
    finder,
    ring_offsets,
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
    """Write the photons [start, stop) of a band.

    `finder` is `slot_finder` over the counts of all cells. The pair `ring_offsets` has the ring of each cell and the
    offset of each ring. The array `cells` (n_cell, 6) has the precision of the outputs, and `laws` is int8 (n_cell,). A
    Perez sky has in `perez` words and bounds (n_cell,), the sky's numbers, and the steps of the first trial. Lobes have
    in `lobes` the lobe of each cell, the tables of `lobes.kernels.law`, the steps of the first trial, and
    `bin_proposals` with `bins_per_photon`. The words of `laws.sloped` (n_cell,) are in `slopes`. The other arguments
    are those of the kernel.
    """
    rank = _ranks(start, stop, order)
    cell[:] = finder(rank)
    u, v = positions_in_cells(rank, jitter, place_key, band, shifts, steps, ring_offsets[1][ring_offsets[0][cell]], ux)
    if slopes is not None:
        u, v = sloped(u, v, slopes[cell])
    law = laws[cell]
    for code in np.flatnonzero(np.bincount(law)):
        chosen = slice(None) if np.all(law == code) else np.flatnonzero(law == code)
        p = tuple(cells[:, j][cell[chosen]] for j in range(6))
        own = law_of(Law(code))
        if own.hook == "perez" and perez is not None:
            from aomc_sky.skies.perez.kernels.cells import accept_words, place_perez

            looked_up = (perez[0][cell[chosen]], perez[1][cell[chosen]], perez[2])
            word = accept_words(rank[chosen], perez[3], place_key, band, jitter)
            directions = place_perez(p, looked_up, u[chosen], v[chosen], word, place_key, rank[chosen], band)
        elif own.hook == "lobes":
            from aomc_sky.skies.lobes.kernels.law import lobe_words, place_lobes

            lobe = lobes[0][cell[chosen]]
            word = lobe_words(rank[chosen], lobe, lobes[3], shifts, steps, lobes[2], place_key, band, jitter)
            directions = place_lobes(lobe, lobes[1], word, place_key, rank[chosen], band)
        else:
            draw = own.directions or law_of(own.starts_as).directions
            directions = draw(p, u[chosen], v[chosen], place_key, rank[chosen], band)
        ux[chosen], uy[chosen], uz[chosen] = directions


def _ranks(start, stop, order):
    if not order.size:
        return np.arange(start, stop, dtype=U64)
    return ranks_of_photons(start, stop, int(order[0]), order[3:])


def in_circle(u, v, radius):
    """Position from two uniform numbers, uniform over a circle around the origin: r = radius sqrt(u)."""
    zero, one = kind_of(u)(0), kind_of(u)(1)
    sine, cosine = sincos_turned_any(zero, one, one + one, v)
    r = kind_of(u)(radius) * np.sqrt(u)
    return r * cosine, r * sine


def in_rectangle(u, v, size_x, size_y):
    """Position from two uniform numbers, uniform over a rectangle centred on the origin."""
    kind = kind_of(u)
    return kind(size_x) * (u - kind(0.5)), kind(size_y) * (v - kind(0.5))


def positions(is_circle, start, key, band, size_x, size_y, x, y):
    """Positions over a circle of diameter size_x or a rectangle, from a stream of their own."""
    a, b = philox_pair(key, np.arange(start, start + x.size, dtype=U64), band, U64(0))
    u, v = unit(a, x), unit(b, x)
    x[:], y[:] = in_circle(u, v, size_x / 2) if is_circle else in_rectangle(u, v, size_x, size_y)


def numbers(start, out, order, shifts, steps, key, band, jitter):
    """The numbers of the photons from `start` on, as in `kernels.numbers`; `out` (n, k)."""
    rank = _ranks(start, start + out.shape[0], order)
    digits_of = (lambda index: index, digits_of_x_plus_1, digits_of_x2_plus_x_plus_1)
    index = None if jitter or steps is not None else index_of_rank(rank, shifts[3])
    for c in range(out.shape[1]):
        if jitter:
            word = philox_pair(key, rank, band, U64(2 if c == 2 else 1))[c % 2]
        elif index is not None:
            word = net_word(digits_of[c](index), shifts[c])
        else:
            word = shifts[c] + rank * steps[c]
        out[:, c] = unit(word, out)


def block_sums(uz):
    """Sums of mu and 1 / mu in the order of the photons, mu = -uz, in float64."""
    mu = -uz.astype(np.float64)
    with np.errstate(divide="ignore"):
        return _sums(mu, 1.0 / mu)


def weighted_block_sums(uz, weight):
    """Sums of the weight w, of w mu and of w / mu, likewise."""
    w, mu = weight.astype(np.float64), -uz.astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight_sum, scalar_sum = _sums(w, w / mu)
    return weight_sum, _sums(w * mu, w)[0], scalar_sum


def _sums(first, second):
    """Two sums at once, as parts of a complex one: `cumsum` adds one number after the other."""
    both = np.empty(first.size, np.complex128)
    both.real, both.imag = first, second
    last = np.cumsum(both, out=both)[-1]
    return float(last.real), float(last.imag)


def packed(x, y, z, energy):
    """The packed direction of an MCPL record (adaptive projection), equal to libmcpl to the bit.

    It has the two smaller components of the unit vector, 1 / uz in the place of the largest one, and the energy with
    the sign of the largest. The library libmcpl divides in float64 and rounds. A division in float32 gives the same
    bits, because 53 >= 2 x 24 + 2.
    """
    far_x, far_y = np.abs(x), np.abs(y)
    is_flat = np.abs(z) < larger(far_x, far_y)
    is_x, is_y = is_flat & (far_x >= far_y), is_flat & (far_x < far_y)
    inverse = kind_of(z)(1) / select(z == 0, np.abs(z), z)  # infinity without a sign, also of -0
    signed_energy = np.copysign(energy, select(is_x, x, select(is_y, y, z)))
    return select(is_x, inverse, x), select(is_y, inverse, y), signed_energy


def pack(ux, uy, uz, cell, energy, flags, n_flagged, first, second, signed_energy, user_flags):
    """Write `packed` and user flags into the fields of records: `flags` + cell, or 0 from the cell `n_flagged` on."""
    for start in range(0, ux.size, _BLOCK):
        part = slice(start, start + _BLOCK)
        with np.errstate(divide="ignore", over="ignore"):
            first[part], second[part], signed_energy[part] = packed(ux[part], uy[part], uz[part], energy)
        own = cell[part]
        user_flags[part] = np.where(own < n_flagged, flags + own.astype(np.uint32), np.uint32(0))


formulas(in_circle, in_rectangle, packed)
