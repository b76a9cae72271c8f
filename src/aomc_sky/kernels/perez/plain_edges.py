"""The integrals of `edges` in plain numpy, equal to the bit.

Where the kernel cuts a line or a tile at a place, all possible places are put inside its ends and sorted
here: those that lie outside make parts of no width, which add 0.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.perez.limits import HALF_PI, SMALLEST, STEP
from aomc_sky.kernels.perez.nodes import W8, W10, X8, X10
from aomc_sky.kernels.perez.plain_law import arc, first_factor, half_sine2, second_factor, sin_cos


def _breaks(first, last, places):
    """First and last (n,), and the places (n, k) between them: ascending, shape (n, k + 2)."""
    inside = np.minimum(np.maximum(places, first[:, None]), last[:, None])
    return np.sort(np.concatenate([first[:, None], inside, last[:, None]], axis=1), axis=1)


def _lines(x, y0, y1, sky, roots):
    """Integrals along lines of constant x, cut where the second factor changes its sign; shape (n,)."""
    s, c = sin_cos(x)
    near, growth = half_sine2(x - sky[5])[:, None], (s * sky[7])[:, None]
    weight = (s * c * first_factor(c, sky[0], sky[1]))[:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(growth > 0, (roots - near) / growth, -1.0)
    crosses = (share > 0) & (share < 1)
    angle = arc(np.where(crosses, share, 0.0)) / HALF_PI
    y = np.concatenate([sky[6] + angle, sky[6] - angle], axis=1) - y0[:, None]
    y = y0[:, None] + (y - 4.0 * np.floor(0.25 * y))
    breaks = _breaks(y0, y1, np.where(np.tile(crosses, 2), y, y0[:, None]))
    total = np.zeros(len(x))
    for k in range(breaks.shape[1] - 1):
        start, width = breaks[:, k : k + 1], breaks[:, k + 1 : k + 2] - breaks[:, k : k + 1]
        h = near + growth * half_sine2(start + width * X10 - sky[6])
        value = W10 * np.maximum(weight * second_factor(h, sky[2], sky[3], sky[4]), 0.0)
        total += np.cumsum(value, axis=1)[:, -1] * width[:, 0]
    return total


def _crossings(tiles, sky, roots):
    """Zenith angles where a circle about the sun begins, ends, or crosses a side of a tile, its ends among them."""
    x0, x1 = tiles[:, 0], tiles[:, 1]
    _, cos_sun = sin_cos(sky[5])
    angle, cosine = arc(roots) / HALF_PI, 1.0 - (roots + roots)
    tops = np.broadcast_to([sky[5] + angle, np.abs(sky[5] - angle)], (len(tiles), 2, len(roots)))
    places = [tops.reshape(len(tiles), -1)]
    for y in (tiles[:, 2:3], tiles[:, 3:4]):
        _, cos_y = sin_cos(y - sky[6])
        sideways = sky[7] * cos_y
        r = np.sqrt(cos_sun * cos_sun + sideways * sideways)
        crosses = np.abs(cosine) < r
        with np.errstate(divide="ignore", invalid="ignore"):
            x_r = np.copysign(arc(0.5 * (1.0 - cos_sun / r)), cos_y) / HALF_PI
            reach = arc(np.where(crosses, 0.5 * (1.0 - cosine / r), 0.0)) / HALF_PI
        places += [np.where(crosses, x_r + reach, x0[:, None]), np.where(crosses, x_r - reach, x0[:, None])]
    return _breaks(x0, x1, np.concatenate(places, axis=1))


def _lines_sums(a, b, y0, y1, nodes, weights, sky, roots):
    """Integrals over lines from a to b, in a variable that makes the powers 3/2 at the ends whole ones."""
    t = nodes
    x = a[:, None] + (b - a)[:, None] * (t * t * (3.0 - 2.0 * t))
    each = _lines(x.ravel(), np.repeat(y0, t.size), np.repeat(y1, t.size), sky, roots).reshape(x.shape)
    return np.cumsum(weights * 6.0 * t * (1.0 - t) * each, axis=1)[:, -1] * (b - a) * STEP


def edge_integrals(tiles, tolerance, sky, roots, out):
    """Integrals over tiles (x0, x1, y0, y1) to a tolerance each; shape (tile,). [sr]"""
    ends = _crossings(tiles, sky, roots)
    owner = np.repeat(np.arange(len(tiles)), ends.shape[1] - 1)
    a, b = ends[:, :-1].ravel(), ends[:, 1:].ravel()
    done = []
    while len(a):
        y0, y1 = tiles[owner, 2], tiles[owner, 3]
        low = _lines_sums(a, b, y0, y1, X8, W8, sky, roots)
        high = _lines_sums(a, b, y0, y1, X10, W10, sky, roots)
        good = (np.abs(high - low) <= tolerance[owner]) | (b - a < SMALLEST)
        done.append((owner[good], a[good], high[good]))
        a, b, owner = a[~good], b[~good], owner[~good]
        middle = 0.5 * (a + b)
        a, b, owner = np.concatenate([a, middle]), np.concatenate([middle, b]), np.concatenate([owner, owner])
    owner, a, value = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((a, owner))  # the kernel adds from the smallest zenith angle on
    out[:] = 0.0
    np.add.at(out, owner[order], value[order])
