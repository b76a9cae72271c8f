"""Integral of the Perez luminance times cos xi over each patch of a grid, refined until two orders agree.

Angles are in quarter turns: x is the zenith angle, y the azimuth. In x and y everything is smooth but
for the cusp at the sun, the layer of exp(b/mu) at the horizon, and the edges of a region where the
luminance is negative and counts as 0. Rings are cut for the layer and at the zero of the first
factor, the sun's patch at the sun, and the zeros of the second factor, circles about the sun, are
found exactly on every line they cross.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez_law import arc, exp_level, first_factor, second_factor, sin_cos
from aomc_sky.kernels.perez_nodes import W3, W4, W6, W8, W10, X3, X4, X6, X8, X10

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE = range(8)
"""Places of the sky's numbers: coefficients, sun in quarter turns, sine of its zenith angle."""

AGREE_4, AGREE_6, AGREE_8 = 2e-10, 1e-9, 3e-11
"""Orders 4, 6 and 8 are taken where they agree to this share of the patch with orders 3, 4 and 6.

The difference is the error of the lower order; that of the one taken is below 1e-11 of the patch.
"""

_FAR_4, _FAR_6, _FAR_8 = 2.0, 0.6, 0.25
"""Half the patch lengths between a patch and the sun from which agreement is no accident."""

_HALF_PI = 1.5707963267948966
_STEP = _HALF_PI * _HALF_PI
_SNAP = 1e-12
_TILES = 400
_SMALLEST = 1e-9
_WIDEST_DECAY = 8.0
_NEGLIGIBLE = -40.0
_THIN = 0.25
_EDGE = 300.0


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
def _x_range(x0, x1, sky):
    """Smallest and largest sin^2((x - sun)/2) over [x0, x1]; exactly 0 where the ring touches the sun."""
    first, last = half_sine2(x0 - sky[SUN_X]), half_sine2(x1 - sky[SUN_X])
    touches = x0 - _SNAP <= sky[SUN_X] <= x1 + _SNAP
    return 0.0 if touches else min(first, last), max(first, last)


@inner
def y_range(y0, y1, sky):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1]; exactly 0 where the column touches the sun."""
    first, last = half_sine2(y0 - sky[SUN_Y]), half_sine2(y1 - sky[SUN_Y])
    sun = _sun_beyond(y0, y1, sky)
    low = 0.0 if sun <= y1 else min(first, last)
    opposite = sun + 2.0 if sun - y0 < 2.0 else sun - 2.0
    return low, 1.0 if y0 <= opposite <= y1 else max(first, last)


@inner
def _has_zero(low, high, roots):
    """Whether the second factor changes its sign between two half chords squared."""
    for k in range(roots.size):  # noqa: SIM110 - numba knows no any()
        if low <= roots[k] <= high:
            return True
    return False


@inner
def _too_wide(length, low, sky):
    """Whether the aureole decays so much over a length that Gauss points could miss it. [length rad]"""
    rate = sky[D]
    return abs(rate) * length > _WIDEST_DECAY and (rate > 0.0 or rate * arc(low) > _NEGLIGIBLE)


@inner
def _is_far(low, length, share, error, sky):
    """Whether a tile is farther from the sun than twice `share` of its length, or its cusp is below an error.

    `low` bounds h from below. A sun at the zenith has no cusp in x and y.
    """
    far = share * length
    return low >= far * far or sky[SUN_SINE] == 0.0 or abs(sky[C] * sky[D]) * length * length * length <= error


@inner
def _column_node(x, weight, sky):
    """Terms of h along one line of constant x, and the weight of its points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[SUN_X]), s * sky[SUN_SINE], weight * s * c * first_factor(c, sky[A], sky[B])


@inner
def _tile(x0, x1, y0, y1, nodes_x, weights_x, nodes_y, weights_y, sky, scratch):
    """Integral over one tile by tensor Gauss points."""
    n = nodes_y.size
    for j in range(n):
        scratch[2, j] = half_sine2(y0 + (y1 - y0) * nodes_y[j] - sky[SUN_Y])
    for i in range(nodes_x.size):
        near, growth, weight = _column_node(x0 + (x1 - x0) * nodes_x[i], weights_x[i], sky)
        for j in range(n):
            scratch[0, i * n + j] = near + growth * scratch[2, j]
            scratch[1, i * n + j] = weight * weights_y[j]
    return _sum_points(nodes_x.size * n, sky, scratch) * ((x1 - x0) * (y1 - y0) * _STEP)


@inner
def _sum_points(n, sky, scratch):
    """Sum of weight times luminance over n points, weights and h in the scratch memory."""
    c, d, e = sky[C], sky[D], sky[E]
    for k in range(n):
        scratch[1, k] = max(scratch[1, k] * second_factor(scratch[0, k], c, d, e), 0.0)
    total = 0.0
    for k in range(n):
        total += scratch[1, k]
    return total


@inner
def _triangle(xs, dx, dy, along_x, nodes, weights, sky, scratch):
    """Integral over the half of a tile whose corner is the sun, on lines through the sun.

    With x = sun + u dx, y = sun + u v dy (or the other way round) gamma / u is smooth: the cusp is gone.
    """
    n = nodes.size
    for i in range(n):
        for j in range(n):
            u, v = nodes[i], nodes[i] * nodes[j]
            step_x, step_y = (u * dx, v * dy) if along_x else (v * dx, u * dy)
            s, c = sin_cos(xs + step_x)
            scratch[0, i * n + j] = half_sine2(step_x) + s * sky[SUN_SINE] * half_sine2(step_y)
            scratch[1, i * n + j] = weights[i] * weights[j] * u * s * c * first_factor(c, sky[A], sky[B])
    return _sum_points(n * n, sky, scratch) * (abs(dx * dy) * _STEP)


@inner
def _push(tiles, n_tiles, x0, x1, y0, y1):
    """Put a tile on the stack, its edges in order; return the new height."""
    tiles[n_tiles, 0] = min(x0, x1)
    tiles[n_tiles, 1] = max(x0, x1)
    tiles[n_tiles, 2] = min(y0, y1)
    tiles[n_tiles, 3] = max(y0, y1)
    return n_tiles + 1


@inner
def _halve(tiles, n_tiles, x0, x1, y0, y1):
    """Put the two halves of a tile on the stack, cut across its longer side."""
    s, _ = sin_cos(0.5 * (x0 + x1))
    if x1 - x0 >= s * (y1 - y0):
        middle = 0.5 * (x0 + x1)
        n_tiles = _push(tiles, n_tiles, x0, middle, y0, y1)
        return _push(tiles, n_tiles, middle, x1, y0, y1)
    middle = 0.5 * (y0 + y1)
    n_tiles = _push(tiles, n_tiles, x0, x1, y0, middle)
    return _push(tiles, n_tiles, x0, x1, middle, y1)


@inner
def _corner(xs, ys, dx, dy, tolerance, edge, sky, roots, scratch, tiles, n_tiles):
    """Integral over the tile from the sun to (xs + dx, ys + dy); what is cut off goes to the stack.

    The corner is made nearly square on the sky, because only then lines through the sun are smooth in
    their direction, no wider than the aureole allows, and smaller than the first circle of negative
    luminance.
    """
    widest = _WIDEST_DECAY / (abs(sky[D]) * _HALF_PI + 1e-3)
    if roots.size > 0:
        widest = min(widest, max(0.5 * arc(roots[0]) / _HALF_PI, _SMALLEST))
    for _ in range(60):
        long_x, long_y = abs(dx), abs(dy) * sky[SUN_SINE]
        low_edge = max(min(long_x, long_y), _SMALLEST)
        limit = min(2.0 * low_edge, widest)
        if long_x > 1.001 * limit:
            n_tiles = _push(tiles, n_tiles, xs + np.copysign(limit, dx), xs + dx, ys, ys + dy)
            dx = np.copysign(limit, dx)
        elif long_y > 1.001 * limit:
            cut = limit / sky[SUN_SINE]
            n_tiles = _push(tiles, n_tiles, xs, xs + dx, ys + np.copysign(cut, dy), ys + dy)
            dy = np.copysign(cut, dy)
        else:
            x0, x1 = min(xs, xs + dx), max(xs, xs + dx)
            y0, y1 = min(ys, ys + dy), max(ys, ys + dy)
            _, x_high = _x_range(x0, x1, sky)
            _, y_high = y_range(y0, y1, sky)
            s, _ = sin_cos(x1)
            if _has_zero(0.0, x_high + s * sky[SUN_SINE] * y_high, roots):
                return _clipped(x0, x1, y0, y1, tolerance + edge, sky, roots), n_tiles
            low = _triangle(xs, dx, dy, True, X8, W8, sky, scratch) + _triangle(xs, dx, dy, False, X8, W8, sky, scratch)
            high = _triangle(xs, dx, dy, True, X10, W10, sky, scratch) + _triangle(
                xs, dx, dy, False, X10, W10, sky, scratch
            )
            if abs(high - low) <= tolerance or max(long_x, long_y) < _SMALLEST:
                return high, n_tiles
            n_tiles = _push(tiles, n_tiles, xs + 0.5 * dx, xs + dx, ys, ys + dy)
            n_tiles = _push(tiles, n_tiles, xs, xs + 0.5 * dx, ys + 0.5 * dy, ys + dy)
            dx, dy = 0.5 * dx, 0.5 * dy
    return 0.0, n_tiles


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
    near, growth, weight = _column_node(x, 1.0, sky)
    breaks[0], breaks[1] = y0, y1
    n = 2
    for k in range(roots.size):
        share = (roots[k] - near) / growth if growth > 0.0 else -1.0
        if 0.0 < share < 1.0:
            angle = arc(share) / _HALF_PI
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
        angle = arc(roots[k]) / _HALF_PI
        n = _insert(breaks, n, sky[SUN_X] + angle)
        n = _insert(breaks, n, abs(sky[SUN_X] - angle))
        cosine = 1.0 - (roots[k] + roots[k])
        for side in range(2):
            _, cos_y = sin_cos((y0 if side == 0 else y1) - sky[SUN_Y])
            sideways = sky[SUN_SINE] * cos_y
            r = np.sqrt(cos_sun * cos_sun + sideways * sideways)
            if abs(cosine) < r:
                x_r = np.copysign(arc(0.5 * (1.0 - cos_sun / r)), cos_y) / _HALF_PI
                reach = arc(0.5 * (1.0 - cosine / r)) / _HALF_PI
                n = _insert(breaks, n, x_r + reach)
                n = _insert(breaks, n, x_r - reach)
    return n


@inner
def _lines_sum(a, b, y0, y1, nodes, weights, sky, roots, breaks):
    """Integral over lines from a to b, in a variable that makes the powers 3/2 at the ends whole ones."""
    total = 0.0
    for i in range(nodes.size):
        t = nodes[i]
        x = a + (b - a) * (t * t * (3.0 - 2.0 * t))
        total += weights[i] * 6.0 * t * (1.0 - t) * _line(x, y0, y1, sky, roots, breaks)
    return total * (b - a) * _STEP


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
            low = _lines_sum(a, b, y0, y1, X8, W8, sky, roots, breaks)
            high = _lines_sum(a, b, y0, y1, X10, W10, sky, roots, breaks)
            if abs(high - low) <= tolerance or b - a < _SMALLEST or n > 60:
                total += high
            else:
                middle = 0.5 * (a + b)
                left[n], right[n] = middle, b
                left[n + 1], right[n + 1] = a, middle
                n += 2
    return total


@inner
def _refine(x0, x1, y0, y1, rough, floor, sky, roots, scratch, tiles):
    """Integral over one patch by tiles halved until orders 6 and 8 agree, the sun's corners apart."""
    tolerance = AGREE_8 * rough + floor
    n_tiles = _push(tiles, 0, x0, x1, y0, y1)
    total, is_first = 0.0, True
    while n_tiles > 0:
        n_tiles -= 1
        x0, x1, y0, y1 = tiles[n_tiles]
        s, _ = sin_cos(x1)
        length = max(x1 - x0, s * (y1 - y0)) * _HALF_PI
        x_low, x_high = _x_range(x0, x1, sky)
        y_low, y_high = y_range(y0, y1, sky)
        s_first, _ = sin_cos(x0)
        low = x_low + s_first * sky[SUN_SINE] * y_low
        high = x_high + s * sky[SUN_SINE] * y_high
        can_halve = n_tiles < _TILES - 8 and length > _SMALLEST
        if y1 - y0 > 1.0:
            n_tiles = _halve_y(tiles, n_tiles, x0, x1, y0, y1)
        elif x_low == 0.0 and y_low == 0.0 and sky[SUN_SINE] > 0.0 and can_halve:
            sun_x = min(max(sky[SUN_X], x0), x1)
            sun_y = _sun_beyond(y0, y1, sky)
            for side in range(4):
                dx = x1 - sun_x if side < 2 else x0 - sun_x
                dy = y1 - sun_y if side % 2 == 0 else y0 - sun_y
                if abs(dx) > _SNAP and abs(dy) > _SNAP:
                    part, n_tiles = _corner(
                        sun_x, sun_y, dx, dy, 0.1 * tolerance, _EDGE * floor, sky, roots, scratch, tiles, n_tiles
                    )
                    total += part
        elif _too_wide(length, low, sky) and can_halve:
            n_tiles = _halve(tiles, n_tiles, x0, x1, y0, y1)
        elif _has_zero(low, high, roots):
            if length > 0.1 and can_halve:
                n_tiles = _halve(tiles, n_tiles, x0, x1, y0, y1)
            else:
                total += _clipped(x0, x1, y0, y1, tolerance + _EDGE * floor, sky, roots)
        else:
            if s * (y1 - y0) < _THIN * (x1 - x0):
                six = _tile(x0, x1, y0, y1, X6, W6, X3, W3, sky, scratch)
                eight = _tile(x0, x1, y0, y1, X8, W8, X4, W4, sky, scratch)
            else:
                six = _tile(x0, x1, y0, y1, X6, W6, X6, W6, sky, scratch)
                agree = abs(six - rough) <= AGREE_6 * rough + floor
                if is_first and agree and _is_far(low, length, _FAR_6, floor, sky):
                    return six
                eight = _tile(x0, x1, y0, y1, X8, W8, X8, W8, sky, scratch)
            agree = abs(eight - six) <= tolerance and _is_far(low, length, _FAR_8, tolerance, sky)
            if agree or not can_halve:
                total += eight
            else:
                n_tiles = _halve(tiles, n_tiles, x0, x1, y0, y1)
        is_first = False
    return total


@inner
def _halve_y(tiles, n_tiles, x0, x1, y0, y1):
    """Put the two halves of a wide tile on the stack, cut at its middle azimuth."""
    middle = 0.5 * (y0 + y1)
    n_tiles = _push(tiles, n_tiles, x0, x1, y0, middle)
    return _push(tiles, n_tiles, x0, x1, middle, y1)


@inner
def _ring_weight(x0, x1, nodes, weights, sky):
    total = 0.0
    for i in range(nodes.size):
        s, c = sin_cos(x0 + (x1 - x0) * nodes[i])
        total += weights[i] * s * c * first_factor(c, sky[A], sky[B])
    return total


@inner
def _ring_pair(x0, x1, sky):
    """First of the pairs of orders 3 and 4, 4 and 6, 6 and 8 that agree on the first factor alone; 3: none."""
    s, c = sin_cos(0.5 * (x0 + x1))
    floor = 1e-15 * (1.0 + abs(sky[A])) * s * c
    three, four = _ring_weight(x0, x1, X3, W3, sky), _ring_weight(x0, x1, X4, W4, sky)
    if abs(four - three) <= 0.3 * AGREE_4 * abs(four) + floor:
        return 0
    six = _ring_weight(x0, x1, X6, W6, sky)
    if abs(six - four) <= 0.3 * AGREE_6 * abs(six) + floor:
        return 1
    eight = _ring_weight(x0, x1, X8, W8, sky)
    if abs(eight - six) <= 0.3 * AGREE_8 * abs(eight) + floor:
        return 2
    return 3


@inner
def _cut_ring(x0, x1, x_zero, sky, cuts):
    """Cut a ring at the zero of the first factor and until a pair of orders agrees; return the number of parts."""
    n_open, n_done = 1, 0
    open_ = np.empty((64, 2))
    open_[0, 0], open_[0, 1] = x0, x1
    while n_open > 0:
        n_open -= 1
        low, high = open_[n_open, 0], open_[n_open, 1]
        has_zero = low + _SNAP < x_zero < high - _SNAP
        pair = 3 if has_zero else _ring_pair(low, high, sky)
        if pair < 3 or high - low < 1e-6 or n_open > 60 or n_done > 60:
            cuts[n_done, 0], cuts[n_done, 1], cuts[n_done, 2] = low, high, min(pair, 2)
            n_done += 1
        else:
            middle = x_zero if has_zero else 0.5 * (low + high)
            open_[n_open, 0], open_[n_open, 1] = middle, high
            open_[n_open + 1, 0], open_[n_open + 1, 1] = low, middle
            n_open += 2
    return n_done


@inner
def _lines(x0, x1, nodes, weights, nodes_y, sky, total):
    """Sum over the lines of a ring, for all nodes of all columns at once."""
    c, d, e = sky[C], sky[D], sky[E]
    total[:] = 0.0
    for i in range(nodes.size):
        near, growth, weight = _column_node(x0 + (x1 - x0) * nodes[i], weights[i], sky)
        for k in range(total.size):
            total[k] += max(weight * second_factor(near + growth * nodes_y[k], c, d, e), 0.0)


@inner
def _column_nodes(azimuth, nodes, sky):
    n = nodes.size
    values = np.empty(azimuth.shape[0] * n)
    for k in range(azimuth.shape[0]):
        for j in range(n):
            y = azimuth[k, 0] + (azimuth[k, 1] - azimuth[k, 0]) * nodes[j]
            values[k * n + j] = half_sine2(y - sky[SUN_Y])
    return values


@inner
def _fill_lines(x0, x1, pair, nodes_3, nodes_4, sky, total_3, total_4):
    """Lines of the lower and of the higher order of a pair, summed for the columns' nodes of order 3 and 4."""
    if pair == 0:
        _lines(x0, x1, X3, W3, nodes_3, sky, total_3)
        _lines(x0, x1, X4, W4, nodes_4, sky, total_4)
    elif pair == 1:
        _lines(x0, x1, X4, W4, nodes_3, sky, total_3)
        _lines(x0, x1, X6, W6, nodes_4, sky, total_4)
    else:
        _lines(x0, x1, X6, W6, nodes_3, sky, total_3)
        _lines(x0, x1, X8, W8, nodes_4, sky, total_4)


@inner
def _mirror(azimuth, sky):
    """Sum of the numbers of two columns that mirror each other at the sun's azimuth, or -1 where none do.

    Equal columns around the whole sky, with the sun on an edge or in the middle of one, need half the work.
    """
    n = azimuth.shape[0]
    width = 4.0 / n
    for k in range(n):
        start = azimuth[0, 0] + k * width
        if abs(azimuth[k, 0] - start) > _SNAP or abs(azimuth[k, 1] - start - width) > _SNAP:
            return -1
    places = 2.0 * (sky[SUN_Y] - azimuth[0, 0]) / width
    nearest = np.rint(places)
    if abs(places - nearest) > _SNAP * n:
        return -1
    return (np.int64(nearest) - 1) % n


@kernel
def perez_masses(zenith, azimuth, sky, x_zero, roots, out):
    """Fill `out` (n_ring x n_column) with the integrals of max(f, 0) cos xi over the patches. [sr]

    `zenith` and `azimuth` (n, 2) are the patches' edges in quarter turns, `sky` as above with b <= 0,
    `x_zero` the zenith angle where the first factor is 0 (or -1), `roots` the half chords squared where
    the second one changes its sign. Return the sum of `out`, compensated.
    """
    n_columns = azimuth.shape[0]
    mirror = _mirror(azimuth, sky)
    column, n = np.empty(n_columns, np.int64), 0
    for k in range(n_columns):
        if mirror < 0 or k <= (mirror - k) % n_columns:
            column[n] = k
            n += 1
    edges = np.empty((n, 2))
    for i in range(n):
        edges[i, 0], edges[i, 1] = azimuth[column[i], 0], azimuth[column[i], 1]
    scratch, tiles, cuts = np.empty((3, 100)), np.empty((_TILES, 4)), np.empty((64, 3))
    nodes_3, nodes_4 = _column_nodes(edges, X3, sky), _column_nodes(edges, X4, sky)
    total_3, total_4, mass = np.empty(nodes_3.size), np.empty(nodes_4.size), np.empty(n)
    y_low, y_high = np.empty(n), np.empty(n)
    for i in range(n):
        y_low[i], y_high[i] = y_range(edges[i, 0], edges[i, 1], sky)
    for ring in range(zenith.shape[0]):
        mass[:] = 0.0
        if zenith[ring, 1] > zenith[ring, 0]:
            for part in range(_cut_ring(zenith[ring, 0], zenith[ring, 1], x_zero, sky, cuts)):
                x0, x1 = cuts[part, 0], cuts[part, 1]
                _fill_lines(x0, x1, cuts[part, 2], nodes_3, nodes_4, sky, total_3, total_4)
                _add_part(x0, x1, edges, y_low, y_high, total_3, total_4, sky, roots, scratch, tiles, mass)
        for i in range(n):
            out[ring, column[i]] = mass[i]
            if mirror >= 0:
                out[ring, (mirror - column[i]) % n_columns] = mass[i]
    total, rest = 0.0, 0.0
    for ring in range(zenith.shape[0]):
        for k in range(n_columns):
            value = out[ring, k] - rest
            larger = total + value
            rest = (larger - total) - value
            total = larger
    return total


@inner
def _add_part(x0, x1, edges, y_low, y_high, total_3, total_4, sky, roots, scratch, tiles, mass):
    """Add a part of a ring to the masses of its columns: the lines' sums where they agree, tiles elsewhere."""
    scale = 1e-15 * (1.0 + abs(sky[A])) * (1.0 + abs(sky[C]) + abs(sky[E]))
    x_low, x_high = _x_range(x0, x1, sky)
    s_first, _ = sin_cos(x0)
    s_last, _ = sin_cos(x1)
    s_middle, c_middle = sin_cos(0.5 * (x0 + x1))
    for k in range(edges.shape[0]):
        y0, y1 = edges[k, 0], edges[k, 1]
        if y1 <= y0:
            continue
        area = (x1 - x0) * (y1 - y0) * _STEP
        three, four = 0.0, 0.0
        for j in range(3):
            three += W3[j] * total_3[3 * k + j]
        for j in range(4):
            four += W4[j] * total_4[4 * k + j]
        three, four = three * area, four * area
        low = x_low + s_first * sky[SUN_SINE] * y_low[k]
        high = x_high + s_last * sky[SUN_SINE] * y_high[k]
        floor = scale * area * s_middle * c_middle
        length = max(x1 - x0, s_last * (y1 - y0)) * _HALF_PI
        is_simple = not (
            (x_low == 0.0 and y_low[k] == 0.0 and sky[SUN_SINE] > 0.0)
            or _too_wide(length, low, sky)
            or _has_zero(low, high, roots)
            or y1 - y0 > 1.0
        )
        agree = abs(four - three) <= AGREE_4 * four + floor and _is_far(low, length, _FAR_4, floor, sky)
        if not (is_simple and agree):
            four = _refine(x0, x1, y0, y1, four, floor, sky, roots, scratch, tiles)
        mass[k] += four


@kernel
def second_factor_roots(c, d, e):
    """Half chords squared where the second factor changes its sign, ascending, to the last bits."""
    found, n = np.empty(64), 0
    steps = 720
    before_h, before = 0.0, second_factor(0.0, c, d, e)
    for k in range(1, steps + 1):
        h = half_sine2(2.0 * k / steps) if k < steps else 1.0
        value = second_factor(h, c, d, e)
        if (value < 0.0) != (before < 0.0) and n < 64:
            low, high = before_h, h
            for _ in range(80):
                middle = 0.5 * (low + high)
                if (second_factor(middle, c, d, e) < 0.0) == (before < 0.0):
                    low = middle
                else:
                    high = middle
            found[n] = 0.5 * (low + high)
            n += 1
        before_h, before = h, value
    return found[:n].copy()


@kernel
def first_factor_zero(a, b):
    """Zenith angle in quarter turns where 1 + a exp(b/mu) = 0, or -1 where it has one sign; b <= 0."""
    if b == 0.0 or 1.0 + a * exp_level(b) >= 0.0:
        return -1.0
    low, high = 0.0, 1.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        _, mu = sin_cos(middle)
        if first_factor(mu, a, b) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
