"""Tiles of a Perez sky's patches, halved until two orders of Gauss points agree on them, compiled; see `mass`."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.formula import larger
from aomc_sky.kernels.jit import inner, inner_reader, kernel
from aomc_sky.kernels.perez.law import (
    HALF_PI,
    SUN_SINE,
    SUN_X,
    SUN_Y,
    C,
    D,
    E,
    arc,
    half_sine2,
    second_factor,
    sin_cos,
    with_aureole,
)
from aomc_sky.kernels.perez.mass import column_node, nearest, x_range, y_range
from aomc_sky.kernels.perez.nodes import (
    AGREE_6,
    AGREE_8,
    FAR_6,
    FAR_8,
    LONGEST_EDGE,
    NEGLIGIBLE,
    NODES,
    SMALLEST,
    STEP,
    THIN,
    W10,
    WEIGHTS,
    WIDEST_DECAY,
    X10,
)


@inner_reader
def sum_points(n, sky, h, weight, aureole):
    """Sum of weight times luminance over n points, where it is positive."""
    c, d, e = sky[C], sky[D], sky[E]
    for k in range(n):
        aureole[k] = d * arc(h[k])
    for k in range(n):
        aureole[k] = exp_level(aureole[k])
    for k in range(n):
        weight[k] = larger(weight[k] * with_aureole(h[k], c, aureole[k], e), 0.0)
    total = 0.0
    for k in range(n):
        total += weight[k]
    return total


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


@inner
def _insert(breaks, n, value):
    """Put a value between the first and the last of n ascending numbers, if it lies there; return their number."""
    if not breaks[0] < value < breaks[n - 1]:
        return n
    place = n
    while breaks[place - 1] > value:
        breaks[place] = breaks[place - 1]
        place -= 1
    breaks[place] = value
    return n + 1


@inner
def _line(x, y0, y1, sky, roots, breaks):
    """Integral along one line of constant x, cut where the second factor changes its sign."""
    near, growth, weight = column_node(x, 1.0, sky)
    breaks[0], breaks[1] = y0, y1
    n = 2
    for k in range(roots.size):
        share = (roots[k] - near) / growth if growth > 0.0 else -1.0
        if 0.0 < share < 1.0:
            angle = arc(share) / HALF_PI
            for side in range(2):
                y = (sky[SUN_Y] + angle if side == 0 else sky[SUN_Y] - angle) - y0
                y = y0 + (y - 4.0 * np.floor(0.25 * y))
                n = _insert(breaks, n, y)
    total = 0.0
    for k in range(n - 1):
        start, width = breaks[k], breaks[k + 1] - breaks[k]
        part = 0.0
        for j in range(X10.size):
            h = near + growth * half_sine2(start + width * X10[j] - sky[SUN_Y])
            part += W10[j] * max(weight * second_factor(h, sky[C], sky[D], sky[E]), 0.0)
        total += part * width
    return total


@inner
def _crossings(x0, x1, y0, y1, sky, roots, breaks):
    """Zenith angles where a circle about the sun begins, ends, or crosses a side of the tile; return their number.

    On a line of constant azimuth cos gamma is r cos(x - x_r), so that its crossings are known.
    """
    breaks[0], breaks[1] = x0, x1
    n = 2
    _, cos_sun = sin_cos(sky[SUN_X])
    for k in range(roots.size):
        angle = arc(roots[k]) / HALF_PI
        n = _insert(breaks, n, sky[SUN_X] + angle)
        n = _insert(breaks, n, abs(sky[SUN_X] - angle))
        cosine = 1.0 - (roots[k] + roots[k])
        for side in range(2):
            _, cos_y = sin_cos((y0 if side == 0 else y1) - sky[SUN_Y])
            sideways = sky[SUN_SINE] * cos_y
            r = np.sqrt(cos_sun * cos_sun + sideways * sideways)
            if abs(cosine) < r:
                x_r = np.copysign(arc(0.5 * (1.0 - cos_sun / r)), cos_y) / HALF_PI
                reach = arc(0.5 * (1.0 - cosine / r)) / HALF_PI
                n = _insert(breaks, n, x_r + reach)
                n = _insert(breaks, n, x_r - reach)
    return n


@inner
def _lines_sum(a, b, y0, y1, order, sky, roots, breaks):
    """Integral over lines from a to b, in a variable that makes the powers 3/2 at the ends whole ones."""
    total = 0.0
    for i in range(order):
        t = NODES[order, i]
        x = a + (b - a) * (t * t * (3.0 - 2.0 * t))
        total += WEIGHTS[order, i] * 6.0 * t * (1.0 - t) * _line(x, y0, y1, sky, roots, breaks)
    return total * (b - a) * STEP


@inner
def _clipped(x0, x1, y0, y1, tolerance, sky, roots):
    """Integral over a tile that an edge of the unlit region crosses: exact lines, cut where it enters and leaves."""
    breaks, ends = np.empty(2 * roots.size + 2), np.empty(6 * roots.size + 2)
    n_ends = _crossings(x0, x1, y0, y1, sky, roots, ends)
    left, right = np.empty(64), np.empty(64)
    total = 0.0
    for k in range(n_ends - 1):
        left[0], right[0] = ends[k], ends[k + 1]
        n = 1
        while n > 0:
            n -= 1
            a, b = left[n], right[n]
            low, high = 0.0, 0.0
            for order in range(8, 11, 2):
                low, high = high, _lines_sum(a, b, y0, y1, order, sky, roots, breaks)
            if abs(high - low) <= tolerance or b - a < SMALLEST or n > 60:
                total += high
            else:
                middle = 0.5 * (a + b)
                left[n], right[n] = middle, b
                left[n + 1], right[n + 1] = a, middle
                n += 2
    return total


@kernel
def edge_integrals(tiles, tolerance, sky, roots, out):
    """Fill `out` (tile,) with the integrals over tiles (x0, x1, y0, y1) to a tolerance each. [sr]"""
    for k in range(tiles.shape[0]):
        out[k] = _clipped(tiles[k, 0], tiles[k, 1], tiles[k, 2], tiles[k, 3], tolerance[k], sky, roots)
