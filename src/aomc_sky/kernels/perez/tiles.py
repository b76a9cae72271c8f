"""Tiles of a Perez sky's patches, halved until two orders of Gauss points agree on them.

`plain_mass` has the same in plain numpy, equal to the bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner_reader, kernel
from aomc_sky.kernels.perez.law import arc, sin_cos
from aomc_sky.kernels.perez.limits import (
    AGREE_6,
    AGREE_8,
    FAR_6,
    FAR_8,
    HALF_PI,
    LONGEST_EDGE,
    NEGLIGIBLE,
    SMALLEST,
    STEP,
    THIN,
    WIDEST_DECAY,
)
from aomc_sky.kernels.perez.points import (
    SUN_SINE,
    SUN_X,
    SUN_Y,
    C,
    D,
    column_node,
    half_sine2,
    sum_points,
    x_range,
    y_range,
)


@inner_reader
def _bounds(x0, x1, y0, y1, sky, sines):
    """Lower and upper bound of h over a tile, its width [quarter turns] and its length on the sky [rad].

    The third of `sines` is left as that of the middle x.
    """
    sines[0], sines[1], sines[2] = x0, x1, 0.5 * (x0 + x1)
    sines[3], sines[4] = 0.5 * (x0 - sky[SUN_X]), 0.5 * (x1 - sky[SUN_X])
    sines[5], sines[6] = 0.5 * (y0 - sky[SUN_Y]), 0.5 * (y1 - sky[SUN_Y])
    for k in range(7):  # one place for the compiler to look at
        sines[k], _ = sin_cos(sines[k])
    x_low, x_high = x_range(x0, x1, sines[3], sines[4], sky)
    y_low, y_high = y_range(y0, y1, sines[5], sines[6], sky)
    low = x_low + sines[0] * sky[SUN_SINE] * y_low
    high = x_high + sines[1] * sky[SUN_SINE] * y_high
    width = sines[1] * (y1 - y0)
    return low, high, width, max(x1 - x0, width) * HALF_PI


@inner_reader
def too_wide(length, low, sky):
    """Whether the aureole decays so much over a length that Gauss points could miss it. [length rad]"""
    rate = sky[D]
    return abs(rate) * length > WIDEST_DECAY and (rate > 0.0 or rate * arc(low) > NEGLIGIBLE)


@inner_reader
def has_root(low, high, roots):
    """Whether the second factor changes its sign between two half chords squared."""
    found = False
    for k in range(roots.size):
        found |= low <= roots[k] and roots[k] <= high
    return found


@inner_reader
def nearest(length, share, error, sky):
    """Smallest half chord squared at which agreement on a tile is no accident: `share` of its length.

    0 where the tile's cusp would be below an error, and everywhere for a sun at the zenith, which has none.
    """
    reach = share * length
    cusp = abs(sky[C] * sky[D]) * (length * length * length)
    return 0.0 if cusp <= error or sky[SUN_SINE] <= 0.0 else reach * reach


@inner_reader
def _tile_sum(x0, x1, y0, y1, order_x, order_y, nodes, weights, sky, scratch):
    """Integral over one tile by tensor Gauss points."""
    h, weight, aureole, columns = scratch[0], scratch[1], scratch[2], scratch[3]
    for j in range(order_y):
        columns[j] = half_sine2(y0 + (y1 - y0) * nodes[order_y, j] - sky[SUN_Y])
    for i in range(order_x):
        near, growth, factor = column_node(x0 + (x1 - x0) * nodes[order_x, i], weights[order_x, i], sky)
        for j in range(order_y):
            h[i * order_y + j] = near + growth * columns[j]
            weight[i * order_y + j] = factor * weights[order_y, j]
    return sum_points(order_x * order_y, sky, h, weight, aureole) * ((x1 - x0) * (y1 - y0) * STEP)


@inner_reader
def _settled(x0, x1, y0, y1, low, length, is_thin, is_whole, rough, floor, nodes, weights, sky, scratch):
    """Integral over a tile by order 8 or, for a whole patch, 6, and whether the order below agrees."""
    lower, value = rough, 0.0
    for level in range(2):
        order = 6 + 2 * level
        value = _tile_sum(x0, x1, y0, y1, order, order // 2 if is_thin else order, nodes, weights, sky, scratch)
        bound = (AGREE_8 if level else AGREE_6) * rough + floor
        least = nearest(length, FAR_8 if level else FAR_6, bound if level else floor, sky)
        may = level == 1 or (is_whole and not is_thin)
        if may and abs(value - lower) <= bound and low >= least:
            return value, True
        lower = value
    return value, length <= SMALLEST


@inner_reader
def _halve(x0, x1, y0, y1, along_x, out):
    """Fill `out` (2, 4) with both halves of a tile."""
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    for side in range(2):
        out[side, 0] = x if along_x and side == 1 else x0
        out[side, 1] = x if along_x and side == 0 else x1
        out[side, 2] = y if not along_x and side == 1 else y0
        out[side, 3] = y if not along_x and side == 0 else y1


@kernel
def tile_round(tiles, owner, n_whole, rough, floor, roots, nodes, weights, sky, total, edge, rest, rest_owner):
    """Add the integrals over tiles (x0, x1, y0, y1) on which two orders agree to the `total` of their owners.

    Tiles that the edge of the unlit region crosses get a True in `edge`; both halves of the others fill
    `rest` and `rest_owner`, tile after tile; their number is returned. The first `n_whole` tiles are
    whole patches, of which `rough` (owner,) is the integral by order 4; `floor` is its rounding. [sr]
    """
    scratch, sines = np.empty((4, 64)), np.empty(7)
    n = 0
    for t in range(tiles.shape[0]):
        x0, x1, y0, y1 = tiles[t, 0], tiles[t, 1], tiles[t, 2], tiles[t, 3]
        low, high, width, length = _bounds(x0, x1, y0, y1, sky, sines)
        crosses = has_root(low, high, roots)
        may = length <= SMALLEST or not (too_wide(length, low, sky) or (crosses and length > LONGEST_EDGE))
        edge[t] = may and crosses
        k, is_settled = owner[t], edge[t]
        if may and not crosses:
            is_thin = width < THIN * (x1 - x0)
            value, is_settled = _settled(
                x0, x1, y0, y1, low, length, is_thin, t < n_whole, rough[k], floor[k], nodes, weights, sky, scratch
            )
            total[k] += value if is_settled else 0.0
        if not is_settled:
            _halve(x0, x1, y0, y1, x1 - x0 >= sines[2] * (y1 - y0), rest[n : n + 2])
            rest_owner[n] = rest_owner[n + 1] = k
            n += 2
    return n
