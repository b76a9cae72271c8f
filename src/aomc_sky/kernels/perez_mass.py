"""Sums of the Perez luminance times cos xi over the points of many tiles of the sky.

Angles are in quarter turns: x is the zenith angle, y the azimuth. `aomc_sky.skies.perez_mass` decides
which tiles; `plain_perez_mass` has the same sums in plain numpy, equal to the bit.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez_law import arc, exp_level, first_factor, sin_cos

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE = range(8)
"""Places of the sky's numbers: coefficients, sun in quarter turns, sine of its zenith angle."""

_HALF_PI = 1.5707963267948966
_SNAP = 1e-12


@inner
def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * x)
    return s * s


@inner
def _sun_beyond(y0, y1, sky):
    """Azimuth of the sun as the first one not before y0, snapped to the edges of [y0, y1]."""
    y = sky[SUN_Y] - y0
    y = y0 + (y - 4.0 * np.floor(0.25 * y))
    if y0 + 4.0 - y < _SNAP:
        y = y0
    if abs(y - y1) < _SNAP:
        y = y1
    return y


@inner
def y_range(y0, y1, sky):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1]; exactly 0 where the column touches the sun."""
    first, last = half_sine2(y0 - sky[SUN_Y]), half_sine2(y1 - sky[SUN_Y])
    sun = _sun_beyond(y0, y1, sky)
    low = 0.0 if sun <= y1 else min(first, last)
    opposite = sun + 2.0 if sun - y0 < 2.0 else sun - 2.0
    return low, 1.0 if y0 <= opposite <= y1 else max(first, last)


@inner
def column_node(x, weight, sky):
    """Terms of h along one line of constant x, and the weight of its points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[SUN_X]), s * sky[SUN_SINE], weight * s * c * first_factor(c, sky[A], sky[B])


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


@kernel
def tile_shapes(tiles, thin, sky, out):
    """Fill `out` (6, tile): lower and upper bound of h, length on the sky [rad], and three truths as 0 or 1.

    The truths: the tile touches the sun, its longer side is along x, it is thinner in y than `thin` of x.
    """
    sun = sky[SUN_X]
    for t in range(tiles.shape[0]):
        x0, x1, y0, y1 = tiles[t, 0], tiles[t, 1], tiles[t, 2], tiles[t, 3]
        s0, _ = sin_cos(x0)
        s1, _ = sin_cos(x1)
        middle, _ = sin_cos(0.5 * (x0 + x1))
        first, last = half_sine2(x0 - sun), half_sine2(x1 - sun)
        is_level = x0 - _SNAP <= sun and sun <= x1 + _SNAP
        x_low = 0.0 if is_level else min(first, last)
        y_low, y_high = y_range(y0, y1, sky)
        out[0, t] = x_low + s0 * sky[SUN_SINE] * y_low
        out[1, t] = max(first, last) + s1 * sky[SUN_SINE] * y_high
        out[2, t] = max(x1 - x0, s1 * (y1 - y0)) * _HALF_PI
        out[3, t] = 1.0 if is_level and y_low == 0.0 else 0.0
        out[4, t] = 1.0 if x1 - x0 >= middle * (y1 - y0) else 0.0
        out[5, t] = 1.0 if s1 * (y1 - y0) < thin * (x1 - x0) else 0.0


@inner
def _sum_points(n, sky, h, weight, aureole):
    """Sum of weight times luminance over n points, where it is positive."""
    c, d, e = sky[C], sky[D], sky[E]
    for k in range(n):
        aureole[k] = d * arc(h[k])
    for k in range(n):
        aureole[k] = exp_level(aureole[k])
    for k in range(n):
        q = 1.0 - (h[k] + h[k])
        weight[k] = max(weight[k] * (1.0 + c * aureole[k] + e * (q * q)), 0.0)
    total = 0.0
    for k in range(n):
        total += weight[k]
    return total


@kernel
def tile_sums(tiles, nodes_x, weights_x, nodes_y, weights_y, sky, out):
    """Fill `out` (tile,) with sums over tensor Gauss points of tiles (x0, x1, y0, y1)."""
    n = nodes_y.size
    size = nodes_x.size * n
    h, weight, aureole, columns = np.empty(size), np.empty(size), np.empty(size), np.empty(n)
    for t in range(tiles.shape[0]):
        x0, x1, y0, y1 = tiles[t, 0], tiles[t, 1], tiles[t, 2], tiles[t, 3]
        for j in range(n):
            columns[j] = half_sine2(y0 + (y1 - y0) * nodes_y[j] - sky[SUN_Y])
        for i in range(nodes_x.size):
            near, growth, factor = column_node(x0 + (x1 - x0) * nodes_x[i], weights_x[i], sky)
            for j in range(n):
                h[i * n + j] = near + growth * columns[j]
                weight[i * n + j] = factor * weights_y[j]
        out[t] = _sum_points(size, sky, h, weight, aureole)


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
            out[t, half] = _sum_points(n * n, sky, h, weight, aureole)
