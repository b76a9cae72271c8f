"""Integrals of the Perez luminance times cos xi over patches and tiles of the sky, in plain numpy.

Angles are in quarter turns: x is the zenith angle, y the azimuth. `aomc_sky.skies.perez.patches` decides which tiles.
A first sky need not wait for the compiler; `sums` and `tiles` have the same, compiled and equal to the bit, with the
formulas that stand here first.

The edge of an unlit region is a circle about the sun where the second factor is 0, found exactly on every line that it
crosses. Where the compiled form cuts a line or a tile at a place, all possible places are put inside its ends and
sorted here: those that lie outside make parts of no width, which add 0.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.formula import formula, larger, select, smaller
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
    second_factor,
    sin_cos,
)
from aomc_sky.kernels.perez.nodes import (
    AGREE_4,
    AGREE_6,
    AGREE_8,
    FAR_4,
    FAR_6,
    FAR_8,
    LONGEST_EDGE,
    NEGLIGIBLE,
    SMALLEST,
    SNAP,
    STEP,
    THIN,
    W8,
    W10,
    WIDEST_DECAY,
    X8,
    X10,
)


@formula
def column_node(x, weight, sky):
    """Terms of h along one line of constant x, and the weight of its points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[SUN_X]), s * sky[SUN_SINE], weight * s * c * first_factor(c, sky[A], sky[B])


@formula
def x_range(x0, x1, first, last, sky):
    """Smallest and largest sin^2((x - sun)/2) over [x0, x1] from the sines at its ends; 0 where it touches the sun."""
    is_level = (x0 - SNAP <= sky[SUN_X]) & (sky[SUN_X] <= x1 + SNAP)
    first, last = first * first, last * last
    return select(is_level, 0.0, smaller(first, last)), larger(first, last)


@formula
def y_range(y0, y1, first, last, sky):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1] from the sines at its ends.

    Exactly 0 where the column touches the sun: the first one not before y0, snapped to the edges.
    """
    sun = sky[SUN_Y] - y0
    sun = y0 + (sun - 4.0 * np.floor(0.25 * sun))
    sun = select(y0 + 4.0 - sun < SNAP, y0, sun)
    sun = select(np.abs(sun - y1) < SNAP, y1, sun)
    first, last = first * first, last * last
    opposite = select(sun - y0 < 2.0, sun + 2.0, sun - 2.0)
    low = select(sun <= y1, 0.0, smaller(first, last))
    return low, select((y0 <= opposite) & (opposite <= y1), 1.0, larger(first, last))


@formula
def nearest(length, share, error, sky):
    """Smallest half chord squared at which agreement on a tile is no accident: `share` of its length.

    0 where the tile's cusp would be below an error, and everywhere for a sun at the zenith, which has none.
    """
    reach = share * length
    cusp = np.abs(sky[C] * sky[D]) * (length * length * length)
    return select((cusp <= error) | (sky[SUN_SINE] <= 0.0), 0.0, reach * reach)


def each_sin_cos(x, out):
    """Sine and cosine of x quarter turns, shape (2, n)."""
    out[0], out[1] = sin_cos(x)


def each_aureole(h, c, d, out):
    """Aureole c exp(d gamma) at h = sin^2(gamma/2), shape (n,)."""
    out[:] = c * exp_level(d * arc(h))


def ring_pairs(x0, x1, orders, agree, rounding, nodes, weights, sky, out):
    """First k for which orders k and k + 1 agree on the first factor alone; the number of pairs where none does."""
    s, c = sin_cos(0.5 * (x0 + x1))
    floor = rounding * (1.0 + abs(sky[A]))
    out[:] = len(agree)
    lower = _ring_weight(x0, x1, orders[0], nodes, weights, sky)
    for k in range(len(agree)):
        higher = _ring_weight(x0, x1, orders[k + 1], nodes, weights, sky)
        is_first = (out == len(agree)) & (np.abs(higher - lower) <= agree[k] * np.abs(higher) + floor * (s * c))
        out[is_first] = k
        lower = higher


def _ring_weight(x0, x1, order, nodes, weights, sky):
    x = x0[:, None] + (x1 - x0)[:, None] * nodes[order, :order]
    return np.cumsum(column_node(x, weights[order, :order], sky)[2], axis=1)[:, -1]


def _line_sums(x0, x1, order, order_y, nodes, weights, columns, sky, n_columns):
    line = np.zeros((len(x0), len(columns)))
    for i in range(order):
        near, growth, factor = column_node(x0 + (x1 - x0) * nodes[order, i], weights[order, i], sky)
        h = near[:, None] + growth[:, None] * columns
        line += np.maximum(factor[:, None] * second_factor(h, sky[C], sky[D], sky[E]), 0.0)
    each = line.reshape(len(x0), n_columns, order_y)
    total = weights[order_y, 0] * each[:, :, 0]
    for j in range(1, order_y):
        total += weights[order_y, j] * each[:, :, j]
    return total


def _column_nodes(edges, order, nodes, sky):
    """sin^2((y - sun)/2) at the nodes of all columns, column after column."""
    y0, width = edges[:, :1], edges[:, 1:] - edges[:, :1]
    return half_sine2(y0 + width * nodes[order, :order] - sky[SUN_Y]).ravel()


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
    x_low, x_high = (part[:, None] for part in x_range(x0, x1, *_half_sines(x0, x1, sky[SUN_X]), sky))
    y_low, y_high = y_range(*edges.T, *_half_sines(*edges.T, sky[SUN_Y]), sky)
    s, c = sin_cos(np.stack([x0, x1, 0.5 * (x0 + x1)]))
    near, far = s[:2, :, None] * sky[SUN_SINE]
    rounding = (scale * (x1 - x0) * s[2] * c[2] * STEP)[:, None]
    length = np.maximum(x1 - x0, s[1] * width.max())[:, None] * HALF_PI  # of the widest column
    low, high = x_low + near * y_low, x_high + far * y_high
    floor[:] = rounding * width
    out[:] = (np.abs(four - three) <= AGREE_4 * four + floor) & (width <= 1.0)
    out &= low >= nearest(length, FAR_4, rounding * width.min(), sky)
    out &= ~(_too_wide(length, low, sky) | _has_root(low, high, roots))


def _half_sines(first, last, sun):
    """Sines of half the ways from the sun to both ends of ranges."""
    return sin_cos(0.5 * (first - sun))[0], sin_cos(0.5 * (last - sun))[0]


def _bounds(tiles, sky):
    """Lower and upper bound of h over tiles, and their lengths on the sky. [length rad]"""
    x0, x1, y0, y1 = tiles.T
    s0, s1 = sin_cos(np.stack([x0, x1]))[0]
    x_low, x_high = x_range(x0, x1, *_half_sines(x0, x1, sky[SUN_X]), sky)
    y_low, y_high = y_range(y0, y1, *_half_sines(y0, y1, sky[SUN_Y]), sky)
    low, high = x_low + s0 * sky[SUN_SINE] * y_low, x_high + s1 * sky[SUN_SINE] * y_high
    return low, high, np.maximum(x1 - x0, s1 * (y1 - y0)) * HALF_PI


def _too_wide(length, low, sky):
    """Whether the aureole decays so much over a length that Gauss points could miss it. [length rad]"""
    rate = sky[D]
    wide = np.abs(rate) * length > WIDEST_DECAY
    return wide if rate > 0 or not wide.any() else wide & (rate * arc(low) > NEGLIGIBLE)


def _has_root(low, high, roots):
    """Whether the second factor changes its sign between two half chords squared."""
    found = np.zeros(np.shape(low), dtype=bool)
    for root in roots:
        found |= (low <= root) & (root <= high)
    return found


def _tile_sums(tiles, order_x, order_y, nodes, weights, sky):
    """Integrals over tiles by tensor Gauss points; shape (tile,)."""
    x0, x1, y0, y1 = tiles.T[:, :, None]
    near, growth, factor = column_node(x0 + (x1 - x0) * nodes[order_x, :order_x], weights[order_x, :order_x], sky)
    columns = half_sine2(y0 + (y1 - y0) * nodes[order_y, :order_y] - sky[SUN_Y])
    h = near[:, :, None] + growth[:, :, None] * columns[:, None, :]
    weight = factor[:, :, None] * weights[order_y, :order_y]
    value = np.maximum(weight * second_factor(h, sky[C], sky[D], sky[E]), 0.0)
    total = np.cumsum(value.reshape(len(tiles), order_x * order_y), axis=1)[:, -1]
    return total * ((tiles[:, 1] - tiles[:, 0]) * (tiles[:, 3] - tiles[:, 2]) * STEP)


def _settled(tiles, low, length, rough, floor, is_whole, nodes, weights, sky):
    """Integrals over tiles by order 8 or, for whole patches, 6, and whether the order below agrees."""
    x0, x1, y0, y1 = tiles.T
    thin = sin_cos(x1)[0] * (y1 - y0) < THIN * (x1 - x0)
    value = _by_order(6, tiles, thin, nodes, weights, sky)
    good = is_whole & ~thin & (np.abs(value - rough) <= AGREE_6 * rough + floor)
    good &= low >= nearest(length, FAR_6, floor, sky)
    of = np.flatnonzero(~good)
    eight = _by_order(8, tiles[of], thin[of], nodes, weights, sky)
    error = (AGREE_8 * rough + floor)[of]
    agree = (np.abs(eight - value[of]) <= error) & (low[of] >= nearest(length[of], FAR_8, error, sky))
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
        h = half_sine2(step_x) + s * sky[SUN_SINE] * half_sine2(step_y)
        weight = weights[:, None] * weights * u * s * c * first_factor(c, sky[A], sky[B])
        value = np.maximum(weight * second_factor(h, sky[C], sky[D], sky[E]), 0.0)
        out[:, half] = np.cumsum(value.reshape(len(corners), -1), axis=1)[:, -1]


def _breaks(first, last, places):
    """First and last (n,), and the places (n, k) between them: ascending, shape (n, k + 2)."""
    inside = np.minimum(np.maximum(places, first[:, None]), last[:, None])
    return np.sort(np.concatenate([first[:, None], inside, last[:, None]], axis=1), axis=1)


def _cut_lines(x, y0, y1, sky, roots):
    """Integrals along lines of constant x, cut where the second factor changes its sign; shape (n,)."""
    near, growth, weight = (values[:, None] for values in column_node(x, 1.0, sky))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(growth > 0, (roots - near) / growth, -1.0)
    crosses = (share > 0) & (share < 1)
    angle = arc(np.where(crosses, share, 0.0)) / HALF_PI
    y = np.concatenate([sky[SUN_Y] + angle, sky[SUN_Y] - angle], axis=1) - y0[:, None]
    y = y0[:, None] + (y - 4.0 * np.floor(0.25 * y))
    breaks = _breaks(y0, y1, np.where(np.tile(crosses, 2), y, y0[:, None]))
    total = np.zeros(len(x))
    for k in range(breaks.shape[1] - 1):
        start, width = breaks[:, k : k + 1], breaks[:, k + 1 : k + 2] - breaks[:, k : k + 1]
        h = near + growth * half_sine2(start + width * X10 - sky[SUN_Y])
        value = W10 * np.maximum(weight * second_factor(h, sky[C], sky[D], sky[E]), 0.0)
        total += np.cumsum(value, axis=1)[:, -1] * width[:, 0]
    return total


def _crossings(tiles, sky, roots):
    """Zenith angles where a circle about the sun begins, ends, or crosses a side of a tile, its ends among them."""
    x0, x1 = tiles[:, 0], tiles[:, 1]
    _, cos_sun = sin_cos(sky[SUN_X])
    angle, cosine = arc(roots) / HALF_PI, 1.0 - (roots + roots)
    tops = np.broadcast_to([sky[SUN_X] + angle, np.abs(sky[SUN_X] - angle)], (len(tiles), 2, len(roots)))
    places = [tops.reshape(len(tiles), -1)]
    for y in (tiles[:, 2:3], tiles[:, 3:4]):
        _, cos_y = sin_cos(y - sky[SUN_Y])
        sideways = sky[SUN_SINE] * cos_y
        r = np.sqrt(cos_sun * cos_sun + sideways * sideways)
        crosses = np.abs(cosine) < r
        with np.errstate(divide="ignore", invalid="ignore"):
            x_r = np.copysign(arc(0.5 * (1.0 - cos_sun / r)), cos_y) / HALF_PI
            reach = arc(np.where(crosses, 0.5 * (1.0 - cosine / r), 0.0)) / HALF_PI
        places += [np.where(crosses, x_r + reach, x0[:, None]), np.where(crosses, x_r - reach, x0[:, None])]
    return _breaks(x0, x1, np.concatenate(places, axis=1))


def _sums_of_lines(a, b, y0, y1, nodes, weights, sky, roots):
    """Integrals over lines from a to b, in a variable that makes the powers 3/2 at the ends whole ones."""
    t = nodes
    x = a[:, None] + (b - a)[:, None] * (t * t * (3.0 - 2.0 * t))
    each = _cut_lines(x.ravel(), np.repeat(y0, t.size), np.repeat(y1, t.size), sky, roots).reshape(x.shape)
    return np.cumsum(weights * 6.0 * t * (1.0 - t) * each, axis=1)[:, -1] * (b - a) * STEP


def edge_integrals(tiles, tolerance, sky, roots, out):
    """Integrals over tiles (x0, x1, y0, y1) to a tolerance each; shape (tile,). [sr]"""
    ends = _crossings(tiles, sky, roots)
    owner = np.repeat(np.arange(len(tiles)), ends.shape[1] - 1)
    a, b = ends[:, :-1].ravel(), ends[:, 1:].ravel()
    done = []
    while len(a):
        y0, y1 = tiles[owner, 2], tiles[owner, 3]
        low = _sums_of_lines(a, b, y0, y1, X8, W8, sky, roots)
        high = _sums_of_lines(a, b, y0, y1, X10, W10, sky, roots)
        good = (np.abs(high - low) <= tolerance[owner]) | (b - a < SMALLEST)
        done.append((owner[good], a[good], high[good]))
        a, b, owner = a[~good], b[~good], owner[~good]
        middle = 0.5 * (a + b)
        a, b, owner = np.concatenate([a, middle]), np.concatenate([middle, b]), np.concatenate([owner, owner])
    owner, a, value = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((a, owner))  # the kernel adds from the smallest zenith angle on
    out[:] = 0.0
    np.add.at(out, owner[order], value[order])
