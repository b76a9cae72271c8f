"""Sums of the Perez luminance times cos xi over the points of many tiles of the sky.

Angles are in quarter turns: x is the zenith angle, y the azimuth. `aomc_sky.skies.perez_mass` decides
which tiles; `plain_perez_mass` has the same sums in plain numpy, equal to the bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez_law import arc, exp_level, first_factor, sin_cos
from aomc_sky.kernels.perez_limits import (
    AGREE_6,
    AGREE_8,
    FAR_6,
    FAR_8,
    HALF_PI,
    LONGEST_EDGE,
    NEGLIGIBLE,
    SMALLEST,
    SNAP,
    STEP,
    THIN,
    WIDEST_DECAY,
)
from aomc_sky.kernels.perez_points import (
    SUN_SINE,
    SUN_X,
    SUN_Y,
    A,
    B,
    C,
    D,
    E,
    column_node,
    half_sine2,
    sum_points,
    y_range,
)


@kernel
def each_sin_cos(x, out):
    """Fill `out` (2, n) with sine and cosine of x quarter turns."""
    for k in range(x.size):
        out[0, k], out[1, k] = sin_cos(x[k])


@kernel
def each_aureole(h, c, d, out):
    """Fill `out` (n,) with c exp(d gamma) at h = sin^2(gamma/2)."""
    for k in range(h.size):
        out[k] = d * arc(h[k])
    for k in range(h.size):
        out[k] = c * exp_level(out[k])


@inner
def _ring_weight(x0, x1, order, nodes, weights, sky):
    total = 0.0
    for i in range(order):
        _, _, weight = column_node(x0 + (x1 - x0) * nodes[order, i], weights[order, i], sky)
        total += weight
    return total


@kernel
def ring_pairs(x0, x1, orders, agree, rounding, nodes, weights, sky, out):
    """Fill `out` (ring,) with the first k for which orders k and k + 1 of `orders` agree on the first factor alone.

    They agree to a share `agree[k]`, or to rounding; the number of pairs where none does.
    """
    floor = rounding * (1.0 + abs(sky[A]))
    for ring in range(x0.size):
        s, c = sin_cos(0.5 * (x0[ring] + x1[ring]))
        out[ring] = agree.size
        lower = _ring_weight(x0[ring], x1[ring], orders[0], nodes, weights, sky)
        for k in range(agree.size):
            higher = _ring_weight(x0[ring], x1[ring], orders[k + 1], nodes, weights, sky)
            if abs(higher - lower) <= agree[k] * abs(higher) + floor * (s * c):
                out[ring] = k
                break
            lower = higher


@inner
def _add_luminance(n, weight, near, growth, columns, sky, aureole, line):
    """Add weight times luminance at h = near + growth * column, where it is positive, to n sums.

    The steps of `second_factor` in loops of their own: in one loop each point would wait for its whole
    chain of divisions and roots.
    """
    c, d, e = sky[C], sky[D], sky[E]
    for k in range(n):
        aureole[k] = d * arc(near + growth * columns[k])
    for k in range(n):
        aureole[k] = exp_level(aureole[k])
    for k in range(n):
        h = near + growth * columns[k]
        q = 1.0 - (h + h)
        line[k] += max(weight * (1.0 + c * aureole[k] + e * (q * q)), 0.0)


@inner
def _line_sums(x0, x1, order, order_y, nodes, weights, columns, sky, aureole, line, out):
    """Sums over tensor Gauss points of one ring, all nodes of all columns at once."""
    line[:] = 0.0
    for i in range(order):
        near, growth, weight = column_node(x0 + (x1 - x0) * nodes[order, i], weights[order, i], sky)
        _add_luminance(line.size, weight, near, growth, columns, sky, aureole, line)
    for column in range(out.size):
        total = weights[order_y, 0] * line[column * order_y]
        for j in range(1, order_y):
            total += weights[order_y, j] * line[column * order_y + j]
        out[column] = total


@kernel
def ring_sums(x0, x1, pair, orders, columns_3, columns_4, nodes, weights, sky, three, four):
    """Fill `three` and `four` (ring, column) with sums by the lower and the higher order of each ring's pair.

    The orders in azimuth are 3 and 4; `columns_3` and `columns_4` hold sin^2((y - sun)/2) of their nodes,
    column after column. `nodes` and `weights` have a row per order.
    """
    line_3, line_4, aureole = np.empty(columns_3.size), np.empty(columns_4.size), np.empty(columns_4.size)
    for ring in range(x0.size):
        k = pair[ring]
        _line_sums(x0[ring], x1[ring], orders[k], 3, nodes, weights, columns_3, sky, aureole, line_3, three[ring])
        _line_sums(x0[ring], x1[ring], orders[k + 1], 4, nodes, weights, columns_4, sky, aureole, line_4, four[ring])


@kernel
def first_look(three, four, low, nearest, per_width, width, agree, out):
    """Fill `out` (ring, column) with whether a patch needs no refinement: far from the sun, and both orders agree.

    `low` (2, ring) and (column,) make the lower bound of h; the floor of a patch is `per_width` times its width.
    """
    x_low, growth, y_low = low
    for ring in range(three.shape[0]):
        for column in range(three.shape[1]):
            bound = agree * four[ring, column] + per_width[ring] * width[column]
            is_far = x_low[ring] + growth[ring] * y_low[column] >= nearest[ring]
            out[ring, column] = is_far and abs(four[ring, column] - three[ring, column]) <= bound


@inner
def _bounds(x0, x1, y0, y1, sky):
    """Lower and upper bound of h over a tile, and its length on the sky. [length rad]"""
    s0, _ = sin_cos(x0)
    s1, _ = sin_cos(x1)
    first, last = half_sine2(x0 - sky[SUN_X]), half_sine2(x1 - sky[SUN_X])
    is_level = x0 - SNAP <= sky[SUN_X] and sky[SUN_X] <= x1 + SNAP
    x_low = 0.0 if is_level else min(first, last)
    y_low, y_high = y_range(y0, y1, sky)
    low = x_low + s0 * sky[SUN_SINE] * y_low
    high = max(first, last) + s1 * sky[SUN_SINE] * y_high
    return low, high, max(x1 - x0, s1 * (y1 - y0)) * HALF_PI


@inner
def _too_wide(length, low, sky):
    """Whether the aureole decays so much over a length that Gauss points could miss it. [length rad]"""
    rate = sky[D]
    return abs(rate) * length > WIDEST_DECAY and (rate > 0.0 or rate * arc(low) > NEGLIGIBLE)


@inner
def _has_root(low, high, roots):
    """Whether the second factor changes its sign between two half chords squared."""
    found = False
    for k in range(roots.size):
        found |= low <= roots[k] and roots[k] <= high
    return found


@inner
def _is_far(low, length, share, error, sky):
    """Whether agreement on a tile is no accident: it is far from the sun, or its cusp is below an error."""
    reach = share * length
    cusp = abs(sky[C] * sky[D]) * (length * length * length)
    return low >= reach * reach or cusp <= error or sky[SUN_SINE] <= 0.0


@inner
def _tile_sum(tile, order_x, order_y, nodes, weights, sky, scratch):
    """Integral over one tile by tensor Gauss points."""
    x0, x1, y0, y1 = tile[0], tile[1], tile[2], tile[3]
    h, weight, aureole, columns = scratch[0], scratch[1], scratch[2], scratch[3]
    for j in range(order_y):
        columns[j] = half_sine2(y0 + (y1 - y0) * nodes[order_y, j] - sky[SUN_Y])
    for i in range(order_x):
        near, growth, factor = column_node(x0 + (x1 - x0) * nodes[order_x, i], weights[order_x, i], sky)
        for j in range(order_y):
            h[i * order_y + j] = near + growth * columns[j]
            weight[i * order_y + j] = factor * weights[order_y, j]
    return sum_points(order_x * order_y, sky, h, weight, aureole) * ((x1 - x0) * (y1 - y0) * STEP)


@inner
def _settled(tile, low, length, rough, floor, is_whole, nodes, weights, sky, scratch):
    """Integral over a tile by order 8 or, for a whole patch, 6, and whether the order below agrees."""
    x0, x1, y0, y1 = tile[0], tile[1], tile[2], tile[3]
    s1, _ = sin_cos(x1)
    is_thin = s1 * (y1 - y0) < THIN * (x1 - x0)
    lower, value = rough, 0.0
    for order in (6, 8):
        value = _tile_sum(tile, order, order // 2 if is_thin else order, nodes, weights, sky, scratch)
        if order == 6:
            may, error, share = is_whole and not is_thin, floor, FAR_6
            bound = AGREE_6 * rough + floor
        else:
            may, error, share = True, AGREE_8 * rough + floor, FAR_8
            bound = error
        if may and abs(value - lower) <= bound and _is_far(low, length, share, error, sky):
            return value, True
        lower = value
    return value, length <= SMALLEST


@inner
def _halve(tile, k, owner, out, out_owner):
    """Put both halves of a tile, cut across its longer side, at k and k + 1 of `out`."""
    x0, x1, y0, y1 = tile[0], tile[1], tile[2], tile[3]
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    s, _ = sin_cos(x)
    for side in range(2):
        out[k + side] = tile
        out_owner[k + side] = owner
        if x1 - x0 >= s * (y1 - y0):
            out[k + side, 1 - side] = x
        else:
            out[k + side, 3 - side] = y


@kernel
def tile_round(tiles, owner, n_whole, rough, floor, roots, nodes, weights, sky, total, edge, rest, rest_owner):
    """Add the integrals over tiles (x0, x1, y0, y1) on which two orders agree to the `total` of their owners.

    Tiles that the edge of the unlit region crosses get a True in `edge`; both halves of the others fill
    `rest` and `rest_owner`, tile after tile; their number is returned. The first `n_whole` tiles are
    whole patches, of which `rough` (owner,) is the integral by order 4; `floor` is its rounding. [sr]
    """
    scratch = np.empty((4, 64))
    n = 0
    for t in range(tiles.shape[0]):
        k = owner[t]
        low, high, length = _bounds(tiles[t, 0], tiles[t, 1], tiles[t, 2], tiles[t, 3], sky)
        is_tiny = length <= SMALLEST
        crosses = _has_root(low, high, roots)
        is_settled = False
        if is_tiny or not (_too_wide(length, low, sky) or (crosses and length > LONGEST_EDGE)):
            edge[t] = crosses
            if crosses:
                continue
            value, is_settled = _settled(
                tiles[t], low, length, rough[k], floor[k], t < n_whole, nodes, weights, sky, scratch
            )
        if is_settled:
            total[k] += value
        else:
            edge[t] = False
            _halve(tiles[t], n, k, rest, rest_owner)
            n += 2
    return n


@kernel
def corner_sums(corners, nodes, weights, sky, out):
    """Fill `out` (corner, 2) with sums over both halves of corners (x of the sun, dx, dy), on lines through the sun.

    With x = sun + u dx, y = sun + u v dy (or the other way round) gamma / u is smooth: the cusp is gone.
    """
    n = nodes.size
    h, weight, aureole = np.empty(n * n), np.empty(n * n), np.empty(n * n)
    for t in range(corners.shape[0]):
        for half in range(2):
            for i in range(n):
                for j in range(n):
                    u, v = nodes[i], nodes[i] * nodes[j]
                    step_x = (u if half == 0 else v) * corners[t, 1]
                    step_y = (v if half == 0 else u) * corners[t, 2]
                    s, c = sin_cos(corners[t, 0] + step_x)
                    h[i * n + j] = half_sine2(step_x) + s * sky[SUN_SINE] * half_sine2(step_y)
                    factor = weights[i] * weights[j] * u * s * c
                    weight[i * n + j] = factor * first_factor(c, sky[A], sky[B])
            out[t, half] = sum_points(n * n, sky, h, weight, aureole)
