"""Integrals over tiles of the sky that the edge of an unlit region crosses.

Such edges are circles about the sun where the second factor is 0, found exactly on every line they cross.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez.law import arc, second_factor, sin_cos
from aomc_sky.kernels.perez.limits import HALF_PI, SMALLEST, STEP
from aomc_sky.kernels.perez.nodes import NODES, W10, WEIGHTS, X10
from aomc_sky.kernels.perez.points import SUN_SINE, SUN_X, SUN_Y, C, D, E, column_node, half_sine2


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
