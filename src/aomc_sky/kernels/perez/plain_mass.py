"""The sums of `mass` in plain numpy, equal to the bit: a first sky need not wait for the compiler."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.plain import exp_level
from aomc_sky.kernels.perez.limits import (
    AGREE_4,
    AGREE_6,
    AGREE_8,
    FAR_4,
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
from aomc_sky.kernels.perez.plain_edges import edge_integrals
from aomc_sky.kernels.perez.plain_law import arc, first_factor, half_sine2, second_factor, sin_cos

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


def _lines(x, weights, sky):
    """Terms of h along lines of constant x, and the weights of their points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[5]), s * sky[7], weights * s * c * first_factor(c, sky[0], sky[1])


def each_sin_cos(x, out):
    """Sine and cosine of x quarter turns, shape (2, n)."""
    out[0], out[1] = sin_cos(x)


def each_aureole(h, c, d, out):
    """Aureole c exp(d gamma) at h = sin^2(gamma/2), shape (n,)."""
    out[:] = c * exp_level(d * arc(h))


def ring_pairs(x0, x1, orders, agree, rounding, nodes, weights, sky, out):
    """First k for which orders k and k + 1 agree on the first factor alone; the number of pairs where none does."""
    s, c = sin_cos(0.5 * (x0 + x1))
    floor = rounding * (1.0 + abs(sky[0]))
    out[:] = len(agree)
    lower = _ring_weight(x0, x1, orders[0], nodes, weights, sky)
    for k in range(len(agree)):
        higher = _ring_weight(x0, x1, orders[k + 1], nodes, weights, sky)
        is_first = (out == len(agree)) & (np.abs(higher - lower) <= agree[k] * np.abs(higher) + floor * (s * c))
        out[is_first] = k
        lower = higher


def _ring_weight(x0, x1, order, nodes, weights, sky):
    x = x0[:, None] + (x1 - x0)[:, None] * nodes[order, :order]
    return np.cumsum(_lines(x, weights[order, :order], sky)[2], axis=1)[:, -1]


def _line_sums(x0, x1, order, order_y, nodes, weights, columns, sky, n_columns):
    line = np.zeros((len(x0), len(columns)))
    for i in range(order):
        near, growth, factor = _lines(x0 + (x1 - x0) * nodes[order, i], weights[order, i], sky)
        h = near[:, None] + growth[:, None] * columns
        line += np.maximum(factor[:, None] * second_factor(h, sky[2], sky[3], sky[4]), 0.0)
    each = line.reshape(len(x0), n_columns, order_y)
    total = weights[order_y, 0] * each[:, :, 0]
    for j in range(1, order_y):
        total += weights[order_y, j] * each[:, :, j]
    return total


def _column_nodes(edges, order, nodes, sky):
    """sin^2((y - sun)/2) at the nodes of all columns, column after column."""
    y0, width = edges[:, :1], edges[:, 1:] - edges[:, :1]
    return half_sine2(y0 + width * nodes[order, :order] - sky[6]).ravel()


def ring_sums(x0, x1, pair, orders, edges, nodes, weights, sky, out):
    """Integrals by the lower and the higher order of each ring's pair; shape (2, ring, column)."""
    for level in range(2):
        columns = _column_nodes(edges, 3 + level, nodes, sky)
        for k in np.unique(pair):
            of = np.flatnonzero(pair == k)
            out[level, of] = _line_sums(
                x0[of], x1[of], orders[k + level], 3 + level, nodes, weights, columns, sky, len(edges)
            )
    out *= ((x1 - x0) * STEP)[:, None] * (edges[:, 1] - edges[:, 0])


def first_look(both, x0, x1, edges, scale, roots, sky, floor, out):
    """Whether a patch needs no refinement, and its rounding; shape (ring, column)."""
    three, four = both
    width = edges[:, 1] - edges[:, 0]
    x_low, x_high = (part[:, None] for part in _x_range(x0, x1, sky))
    y_low, y_high = _y_range(*edges.T, sky[6])
    s, c = sin_cos(np.stack([x0, x1, 0.5 * (x0 + x1)]))
    near, far = s[:2, :, None] * sky[7]
    rounding = (scale * (x1 - x0) * s[2] * c[2] * STEP)[:, None]
    length = np.maximum(x1 - x0, s[1] * width.max())[:, None] * HALF_PI  # of the widest column
    low, high = x_low + near * y_low, x_high + far * y_high
    floor[:] = rounding * width
    out[:] = (np.abs(four - three) <= AGREE_4 * four + floor) & (width <= 1.0)
    out &= low >= _nearest(length, FAR_4, rounding * width.min(), sky)
    out &= ~(_too_wide(length, low, sky) | _has_root(low, high, roots))


def _x_range(x0, x1, sky):
    """Smallest and largest sin^2((x - sun)/2) over [x0, x1]; exactly 0 where a ring touches the sun."""
    first, last = half_sine2(x0 - sky[5]), half_sine2(x1 - sky[5])
    is_level = (x0 - SNAP <= sky[5]) & (sky[5] <= x1 + SNAP)
    return np.where(is_level, 0.0, np.minimum(first, last)), np.maximum(first, last)


def _y_range(y0, y1, sun):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1]; exactly 0 where a column touches the sun."""
    first, last = half_sine2(y0 - sun), half_sine2(y1 - sun)
    rest = sun - y0
    y = y0 + (rest - 4.0 * np.floor(0.25 * rest))
    y = np.where(y0 + 4.0 - y < SNAP, y0, y)
    y = np.where(np.abs(y - y1) < SNAP, y1, y)
    opposite = np.where(y - y0 < 2.0, y + 2.0, y - 2.0)
    low = np.where(y <= y1, 0.0, np.minimum(first, last))
    return low, np.where((y0 <= opposite) & (opposite <= y1), 1.0, np.maximum(first, last))


def _bounds(tiles, sky):
    """Lower and upper bound of h over tiles, and their lengths on the sky. [length rad]"""
    x0, x1, y0, y1 = tiles.T
    s0, s1 = sin_cos(np.stack([x0, x1]))[0]
    x_low, x_high = _x_range(x0, x1, sky)
    y_low, y_high = _y_range(y0, y1, sky[6])
    low, high = x_low + s0 * sky[7] * y_low, x_high + s1 * sky[7] * y_high
    return low, high, np.maximum(x1 - x0, s1 * (y1 - y0)) * HALF_PI


def _too_wide(length, low, sky):
    """Whether the aureole decays so much over a length that Gauss points could miss it. [length rad]"""
    rate = sky[3]
    wide = np.abs(rate) * length > WIDEST_DECAY
    return wide if rate > 0 or not wide.any() else wide & (rate * arc(low) > NEGLIGIBLE)


def _has_root(low, high, roots):
    """Whether the second factor changes its sign between two half chords squared."""
    found = np.zeros(np.shape(low), dtype=bool)
    for root in roots:
        found |= (low <= root) & (root <= high)
    return found


def _nearest(length, share, error, sky):
    """Smallest half chord squared at which agreement on a tile is no accident."""
    reach = share * length
    cusp = abs(sky[2] * sky[3]) * (length * length * length)
    return np.where((cusp <= error) | (sky[7] <= 0), 0.0, reach * reach)


def _tile_sums(tiles, order_x, order_y, nodes, weights, sky):
    """Integrals over tiles by tensor Gauss points; shape (tile,)."""
    x0, x1, y0, y1 = tiles.T[:, :, None]
    near, growth, factor = _lines(x0 + (x1 - x0) * nodes[order_x, :order_x], weights[order_x, :order_x], sky)
    columns = half_sine2(y0 + (y1 - y0) * nodes[order_y, :order_y] - sky[6])
    h = near[:, :, None] + growth[:, :, None] * columns[:, None, :]
    weight = factor[:, :, None] * weights[order_y, :order_y]
    value = np.maximum(weight * second_factor(h, sky[2], sky[3], sky[4]), 0.0)
    total = np.cumsum(value.reshape(len(tiles), order_x * order_y), axis=1)[:, -1]
    return total * ((tiles[:, 1] - tiles[:, 0]) * (tiles[:, 3] - tiles[:, 2]) * STEP)


def _settled(tiles, low, length, rough, floor, is_whole, nodes, weights, sky):
    """Integrals over tiles by order 8 or, for whole patches, 6, and whether the order below agrees."""
    x0, x1, y0, y1 = tiles.T
    thin = sin_cos(x1)[0] * (y1 - y0) < THIN * (x1 - x0)
    value = _by_order(6, tiles, thin, nodes, weights, sky)
    good = is_whole & ~thin & (np.abs(value - rough) <= AGREE_6 * rough + floor)
    good &= low >= _nearest(length, FAR_6, floor, sky)
    of = np.flatnonzero(~good)
    eight = _by_order(8, tiles[of], thin[of], nodes, weights, sky)
    error = (AGREE_8 * rough + floor)[of]
    agree = (np.abs(eight - value[of]) <= error) & (low[of] >= _nearest(length[of], FAR_8, error, sky))
    value[of], good[of] = eight, agree | (length[of] <= SMALLEST)
    return value, good


def _by_order(order, tiles, thin, nodes, weights, sky):
    value = np.empty(len(tiles))
    for of, order_y in ((thin, order // 2), (~thin, order)):
        value[of] = _tile_sums(tiles[of], order, order_y, nodes, weights, sky)
    return value


def _halved(tiles):
    """Both halves of each tile, cut across its longer side, one after the other."""
    x0, x1, y0, y1 = tiles.T
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    along_x = x1 - x0 >= sin_cos(x)[0] * (y1 - y0)
    lower = np.stack([x0, np.where(along_x, x, x1), y0, np.where(along_x, y1, y)], axis=1)
    upper = np.stack([np.where(along_x, x, x0), x1, np.where(along_x, y0, y), y1], axis=1)
    return np.stack([lower, upper], axis=1).reshape(-1, 4)


def tile_round(tiles, owner, n_whole, rough, floor, roots, nodes, weights, sky, total, edge, rest, rest_owner):
    """Add integrals of settled tiles to `total`, mark the edge's, and halve the others; return their halves' number."""
    low, high, length = _bounds(tiles, sky)
    is_tiny, crosses = length <= SMALLEST, _has_root(low, high, roots)
    is_whole = np.arange(len(tiles)) < n_whole
    may = is_tiny | ~(_too_wide(length, low, sky) | (crosses & (length > LONGEST_EDGE)))
    edge[:] = may & crosses
    plain = np.flatnonzero(may & ~crosses)
    of = owner[plain]
    value, good = _settled(
        tiles[plain], low[plain], length[plain], rough[of], floor[of], is_whole[plain], nodes, weights, sky
    )
    np.add.at(total, of[good], value[good])
    open_ = ~edge
    open_[plain[good]] = False
    n = 2 * int(np.count_nonzero(open_))
    rest[:n], rest_owner[:n] = _halved(tiles[open_]), np.repeat(owner[open_], 2)
    return n


def corner_sums(corners, nodes, weights, sky, out):
    """Sums over both halves of corners (x of the sun, dx, dy) on lines through the sun; shape (corner, 2)."""
    xs, dx, dy = corners.T[:, :, None, None]
    u = nodes[:, None]
    v = u * nodes
    for half, (step_x, step_y) in enumerate(((u * dx, v * dy), (v * dx, u * dy))):
        step_x, step_y = np.broadcast_arrays(step_x, step_y)
        s, c = sin_cos(xs + step_x)
        h = half_sine2(step_x) + s * sky[7] * half_sine2(step_y)
        weight = weights[:, None] * weights * u * s * c * first_factor(c, sky[0], sky[1])
        value = np.maximum(weight * second_factor(h, sky[2], sky[3], sky[4]), 0.0)
        out[:, half] = np.cumsum(value.reshape(len(corners), -1), axis=1)[:, -1]
