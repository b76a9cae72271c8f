"""Sums of the Perez luminance times cos xi over the points of the patches of a sky, compiled; see `mass`."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.formula import larger
from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez.law import (
    HALF_PI,
    SUN_SINE,
    SUN_X,
    SUN_Y,
    A,
    B,
    C,
    D,
    E,
    arc,
    first_factor,
    half_sine2,
    sin_cos,
    with_aureole,
)
from aomc_sky.kernels.perez.mass import column_node, nearest, x_range, y_range
from aomc_sky.kernels.perez.nodes import AGREE_4, FAR_4, STEP, WIDEST_DECAY
from aomc_sky.kernels.perez.tiles import edge_integrals, has_root, sum_points, tile_round, too_wide

__all__ = [
    "corner_sums",
    "each_aureole",
    "each_sin_cos",
    "edge_integrals",
    "first_look",
    "ring_pairs",
    "ring_sums",
    "tile_round",
]


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
        lower = 0.0
        for k in range(orders.size):
            higher = _ring_weight(x0[ring], x1[ring], orders[k], nodes, weights, sky)
            if k > 0 and abs(higher - lower) <= agree[k - 1] * abs(higher) + floor * (s * c):
                out[ring] = k - 1
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
        factor = with_aureole(near + growth * columns[k], c, aureole[k], e)
        line[k] += larger(weight * factor, 0.0)


@inner
def _line_sums(x0, x1, order, order_y, nodes, weights, columns, sky, aureole, line, out):
    """Sums over tensor Gauss points of one ring, all nodes of all columns at once."""
    line[:] = 0.0
    for i in range(order):
        near, growth, weight = column_node(x0 + (x1 - x0) * nodes[order, i], weights[order, i], sky)
        _add_luminance(line.size, weight, near, growth, columns, sky, aureole, line)
    for column in range(out.size):
        out[column] = weights[order_y, 0] * line[column]
    for j in range(1, order_y):
        for column in range(out.size):
            out[column] += weights[order_y, j] * line[j * out.size + column]


@kernel
def ring_sums(x0, x1, pair, orders, edges, nodes, weights, sky, out):
    """Fill `out` (2, ring, column) with integrals by the lower and the higher order of each ring's pair.

    The orders in azimuth are 3 and 4. `edges` (column, 2) are those of the columns; `nodes` and `weights`
    have a row per order.
    """
    n = edges.shape[0]
    columns, line, aureole = np.empty((2, 4 * n)), np.empty(4 * n), np.empty(4 * n)
    for level in range(2):
        order = 3 + level
        for k in range(order * n):  # the first nodes of all columns, then the second ones
            y0, y1 = edges[k % n, 0], edges[k % n, 1]
            columns[level, k] = half_sine2(y0 + (y1 - y0) * nodes[order, k // n] - sky[SUN_Y])
    for ring in range(x0.size):
        a, b = x0[ring], x1[ring]
        for level in range(2):
            order, of = orders[pair[ring] + level], columns[level, : (3 + level) * n]
            sums, first = out[level, ring], line[: of.size]
            _line_sums(a, b, order, 3 + level, nodes, weights, of, sky, aureole, first, sums)
            for column in range(n):
                sums[column] *= (b - a) * STEP * (edges[column, 1] - edges[column, 0])


@kernel
def first_look(both, x0, x1, edges, scale, roots, sky, floor, out):
    """Fill `out` (ring, column) with whether a patch needs no refinement, and `floor` with its rounding.

    It needs none where it is far from the sun, at most a quarter turn wide, without an edge of an unlit
    region, and both orders agree. `scale` is the rounding of the luminance.
    """
    n = edges.shape[0]
    y_low, y_high, width, ends, sines = np.empty(n), np.empty(n), np.empty(n), np.empty((n, 2)), np.empty(5)
    for k in range(2 * n):
        ends[k // 2, k % 2], _ = sin_cos(0.5 * (edges[k // 2, k % 2] - sky[SUN_Y]))
    widest, narrowest = 0.0, np.inf
    for column in range(n):
        y0, y1 = edges[column, 0], edges[column, 1]
        y_low[column], y_high[column] = y_range(y0, y1, ends[column, 0], ends[column, 1], sky)
        width[column] = y1 - y0
        widest, narrowest = max(widest, y1 - y0), min(narrowest, y1 - y0)
    for ring in range(x0.size):
        a, b = x0[ring], x1[ring]
        sines[0], sines[1], sines[4] = a, b, 0.5 * (a + b)
        sines[2], sines[3] = 0.5 * (a - sky[SUN_X]), 0.5 * (b - sky[SUN_X])
        c = 0.0
        for k in range(5):
            sines[k], c = sin_cos(sines[k])
        x_low, x_high = x_range(a, b, sines[2], sines[3], sky)
        rounding = scale * (b - a) * sines[4] * c * STEP
        length = max(b - a, sines[1] * widest) * HALF_PI  # of the widest column
        near, far = sines[0] * sky[SUN_SINE], sines[1] * sky[SUN_SINE]
        least = nearest(length, FAR_4, rounding * narrowest, sky)
        may_need_cut = roots.size > 0 or abs(sky[D]) * length > WIDEST_DECAY
        for column in range(n):
            low = x_low + near * y_low[column]
            floor[ring, column] = rounding * width[column]
            error = AGREE_4 * both[1, ring, column] + floor[ring, column]
            good = (abs(both[1, ring, column] - both[0, ring, column]) <= error) & (low >= least)
            out[ring, column] = good & (width[column] <= 1.0)
        for column in range(n if may_need_cut else 0):
            low, high = x_low + near * y_low[column], x_high + far * y_high[column]
            if too_wide(length, low, sky) or has_root(low, high, roots):
                out[ring, column] = False


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
