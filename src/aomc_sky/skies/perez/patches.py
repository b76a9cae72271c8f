"""What a patch of a Perez sky holds: the integral of the luminance times cos xi, and the means of mu and of 1/mu.

In zenith angle x and azimuth y everything is smooth but for the cusp at the sun, the layer of exp(b/mu) at the horizon,
and the edges of a region where the luminance is negative and counts as 0. Rings are cut for the layer and at the zero
of the first factor. Tiles, rectangles in x and y, are halved until two orders of Gauss points agree; those at the sun
are integrated on lines through it, those that the edge of the unlit region crosses by `edge_integrals`. All with
+ - x / sqrt: the same bits on every machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.perez.law import HALF_PI, arc, first_factor, half_sine2, second_factor, sin_cos
from aomc_sky.kernels.perez.nodes import (
    AGREE_4,
    AGREE_6,
    AGREE_8,
    NODES,
    SMALLEST,
    SNAP,
    STEP,
    W4,
    W8,
    W10,
    WEIGHTS,
    WIDEST_DECAY,
    X4,
    X8,
    X10,
)

_ORDERS = np.array([3, 4, 6, 8])
_RING_AGREE = 0.3 * np.array([AGREE_4, AGREE_6, AGREE_8])
_STEPS = 720
_HALVINGS = 80
_ROUNDING = 1e-15
_EDGE = 300.0


def patch_integrals(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray, sums: Any) -> np.ndarray:
    """Integral of max(f, 0) cos xi over each patch to 1e-10 of it, shape (n_ring, n_column). [sr]

    Edges of rings and columns (n, 2) in quarter turns; of `numbers` the first eight as in `Component.shared`, b <= 0;
    `sums` from `backend.perez_sums`. The largest errors are at the point opposite to a sun on the horizon.
    """
    sky = TiledSky.of(numbers, sums)
    columns, source = _columns(azimuth, sky)
    x0, x1, pair, ring = _cut_rings(zenith, sky)
    mass = np.zeros((len(zenith), len(columns) + 1))  # the last column is that of empty patches
    if len(ring) and len(columns):
        parts, tiles, rough, floor, index = _first_pass(x0, x1, pair, azimuth[columns], sky)
        if len(tiles):
            parts.ravel()[index] = _refined(tiles, rough, floor, sky)
        is_start = np.diff(ring, prepend=-1) > 0
        mass[ring[is_start], :-1] = parts[is_start]
        for part in np.flatnonzero(~is_start):
            mass[ring[part], :-1] += parts[part]
    return mass.take(source, axis=1)


def _columns(azimuth: np.ndarray, sky: TiledSky) -> tuple[np.ndarray, np.ndarray]:
    """Columns to integrate, and for each column the index among them of the one that has its masses, or -1.

    Equal columns around the whole sky, with the sun on an edge or in the middle of one, need half the work:
    each serves its mirror image at the sun's azimuth too.
    """
    n = len(azimuth)
    every, source = np.arange(n), np.full(n, -1)
    starts, width = azimuth[0, 0] + every * (4.0 / n), 4.0 / n
    half_columns = float(sky.numbers[6] - azimuth[0, 0]) * (n / 2.0)
    is_even = (
        abs(half_columns - round(half_columns)) <= SNAP * n
        and np.abs(azimuth.T - (starts, starts + width)).max() < SNAP
    )
    if not is_even:
        columns = np.flatnonzero(azimuth[:, 1] > azimuth[:, 0])
        source[columns] = every[: len(columns)]
        return columns, source
    partner = (round(half_columns) - 1 - every) % n
    columns = np.flatnonzero(every <= partner)
    source[columns] = source[partner[columns]] = every[: len(columns)]
    return columns, source


def _cut_rings(zenith: np.ndarray, sky: TiledSky) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Parts of the rings on which a pair of orders agrees on the first factor alone: edges, pair and ring."""
    ring = np.flatnonzero(zenith[:, 1] > zenith[:, 0])
    x0, x1 = np.ascontiguousarray(zenith[ring].T)
    done: list[tuple[np.ndarray, ...]] = []
    while len(ring):
        has_zero = (x0 + SNAP < sky.x_zero) & (sky.x_zero < x1 - SNAP)
        pair = np.empty(len(ring), dtype=np.int64)
        sky.sums.ring_pairs(x0, x1, _ORDERS, _RING_AGREE, _ROUNDING, NODES, WEIGHTS, sky.numbers, pair)
        pair[has_zero] = 3
        good = (pair < 3) | (x1 - x0 < 1e-6)
        done.append((x0[good], x1[good], np.minimum(pair, 2)[good], ring[good]))
        middle = np.where(has_zero, sky.x_zero, 0.5 * (x0 + x1))[~good]
        x0, x1 = np.concatenate([x0[~good], middle]), np.concatenate([middle, x1[~good]])
        ring = np.concatenate([ring[~good], ring[~good]])
    if not done:
        return x0, x1, ring, ring
    x0, x1, pair, ring = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((x0, ring))
    return x0[order], x1[order], pair[order], ring[order]


def _first_pass(
    x0: np.ndarray, x1: np.ndarray, pair: np.ndarray, edges: np.ndarray, sky: TiledSky
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Masses of all patches where a pair of orders agrees; tiles, estimates, floors and flat indices of the rest."""
    both = np.empty((2, len(x0), len(edges)))
    floor, good = np.empty(both.shape[1:]), np.empty(both.shape[1:], dtype=bool)
    sky.sums.ring_sums(x0, x1, pair, _ORDERS, edges, NODES, WEIGHTS, sky.numbers, both)
    sky.sums.first_look(both, x0, x1, edges, sky.scale, sky.roots, sky.numbers, floor, good)
    index = np.flatnonzero(~good)
    part, column = np.divmod(index, len(edges))
    tiles = np.stack([x0[part], x1[part], edges[column, 0], edges[column, 1]], axis=1)
    return both[1], tiles, both[1].ravel()[index], floor.ravel()[index], index


def patch_moments(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means of mu and of 1/mu over the flux of max(f, 0) from each patch, (n_ring, n_column) each, 0 where it is dark.

    Arguments as for `patch_integrals`. 4 x 4 Gauss points in zenith angle and azimuth, where the flux over mu is smooth
    up to the horizon: means over a whole sky are good to 1e-6 on patches of 2 degrees, 1e-4 on patches of 10.
    """
    x = zenith[:, :1] + (zenith[:, 1:] - zenith[:, :1]) * X4
    y = azimuth[:, :1] + (azimuth[:, 1:] - azimuth[:, :1]) * X4
    sine, mu = sin_cos(x)
    columns = half_sine2(y - numbers[6]).ravel()
    h = half_sine2(x - numbers[5])[:, :, None] + (sine * numbers[7])[:, :, None] * columns
    a, b, c, d, e = numbers[:5]
    value = np.maximum(first_factor(mu, a, b)[:, :, None] * second_factor(h, c, d, e), 0.0)
    lines = value.reshape(*x.shape, azimuth.shape[0], W4.size) @ W4
    weight = W4 * sine
    flux = np.einsum("ri,ric->rc", weight * mu, lines)
    with_mu = np.einsum("ri,ric->rc", weight * mu * mu, lines)
    without_mu = np.einsum("ri,ric->rc", weight, lines)
    lit = flux > 0
    return (
        np.divide(with_mu, flux, out=np.zeros_like(flux), where=lit),
        np.divide(without_mu, flux, out=np.zeros_like(flux), where=lit),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class TiledSky:
    """A Perez sky as the integration of its patches sees it."""

    #: a to e, zenith angle and azimuth of the sun in quarter turns, sine of the former; more may follow.
    numbers: np.ndarray
    #: sin^2(gamma/2) where the second factor changes its sign, ascending.
    roots: np.ndarray
    x_zero: float  #: Zenith angle where the first factor is 0, or -1. [quarter turns]
    sums: Any  #: A module as `backend.perez_sums` gives it.

    @classmethod
    def of(cls, numbers: np.ndarray, sums: Any) -> TiledSky:
        """The sky of these numbers, b <= 0."""
        a, b, c, d, e = numbers[:5].tolist()
        mine = numbers.copy()  # an array that nobody may write, as a plan's, is another variant to compile
        return cls(numbers=mine, roots=second_factor_zeros(c, d, e), x_zero=first_factor_zero(a, b), sums=sums)

    @property
    def has_cusp(self) -> bool:
        """Whether the sun is a point in x and y; at the zenith it is a whole line."""
        return bool(self.numbers[7] > 0)

    @property
    def scale(self) -> float:
        """Rounding of the luminance in the units of f."""
        a, _, c, _, e = np.abs(self.numbers[:5]).tolist()
        return _ROUNDING * (1.0 + a) * (1.0 + c + e)

    def sin_cos(self, x: np.ndarray) -> np.ndarray:
        """Sine and cosine of x quarter turns, shape (2, ...)."""
        out = np.empty((2, x.size))
        self.sums.each_sin_cos(x.ravel(), out)
        return out.reshape(2, *x.shape)

    def sun_beyond(self, y0: np.ndarray, y1: np.ndarray) -> np.ndarray:
        """Azimuth of the sun as the first one not before y0, snapped to the edges of [y0, y1]."""
        rest = self.numbers[6] - y0
        y = y0 + (rest - 4.0 * np.floor(0.25 * rest))
        y = np.where(y0 + 4.0 - y < SNAP, y0, y)
        return np.where(np.abs(y - y1) < SNAP, y1, y)


def first_factor_zero(a: float, b: float) -> float:
    """Zenith angle where 1 + a exp(b/mu), b <= 0, is 0 and below which it is negative, or -1. [quarter turns]"""
    if b == 0 or a > -1.0 or 1.0 + a * float(exp_level(b)) >= 0:
        return -1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if first_factor(sin_cos(middle)[1], a, b) < 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def second_factor_zeros(c: float, d: float, e: float) -> np.ndarray:
    """sin^2(gamma/2), ascending, where 1 + c exp(d gamma) + e cos^2 gamma changes its sign.

    Seen in steps of a quarter degree, in numbers that are the same on every machine.
    """
    if c >= 0 and e > -1:
        return np.empty(0)
    h = half_sine2(np.arange(_STEPS + 1) * (2.0 / _STEPS))
    h[-1] = 1.0
    negative = second_factor(h, c, d, e) < 0
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    low, high = h[changes], h[changes + 1]
    for _ in range(_HALVINGS if changes.size else 0):
        middle = 0.5 * (low + high)
        is_low = (second_factor(middle, c, d, e) < 0) == negative[changes]
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return 0.5 * (low + high)


def _refined(tiles: np.ndarray, rough: np.ndarray, floor: np.ndarray, sky: TiledSky) -> np.ndarray:
    """Integrals over tiles (x0, x1, y0, y1), halved until orders 6 and 8 agree, the sun's corners apart. [sr]

    `rough` is what order 4 has of them, `floor` the error that rounding makes of them.
    """
    total = np.zeros(len(tiles))
    tolerance = AGREE_8 * rough + floor
    tiles, owner, n_whole = _narrowed(tiles)
    if sky.has_cusp:
        tiles, owner, n_whole = _without_sun(tiles, owner, n_whole, tolerance, total, sky)
    while len(tiles):
        edge = np.empty(len(tiles), dtype=bool)
        rest, rest_owner = np.empty((2 * len(tiles), 4)), np.empty(2 * len(tiles), dtype=np.int64)
        rules = (sky.roots, NODES, WEIGHTS, sky.numbers)
        n = sky.sums.tile_round(tiles, owner, n_whole, rough, floor, *rules, total, edge, rest, rest_owner)
        if len(sky.roots) and edge.any():
            at = owner[edge]
            value = np.empty(len(at))
            sky.sums.edge_integrals(tiles[edge], (tolerance + _EDGE * floor)[at], sky.numbers, sky.roots, value)
            np.add.at(total, at, value)
        tiles, owner, n_whole = rest[:n], rest_owner[:n], 0
    return total


def _narrowed(tiles: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Tiles of at most a quarter turn in azimuth, whose patches they are, and how many first ones were not cut."""
    owner = np.arange(len(tiles))
    wide = tiles[:, 3] - tiles[:, 2] > 1.0
    n_whole = len(tiles) - int(np.count_nonzero(wide))
    while wide.any():
        lower, upper = tiles[wide], tiles[wide]
        lower[:, 3] = upper[:, 2] = 0.5 * (lower[:, 2] + lower[:, 3])
        tiles = np.concatenate([tiles[~wide], lower, upper])
        owner = np.concatenate([owner[~wide], owner[wide], owner[wide]])
        wide = tiles[:, 3] - tiles[:, 2] > 1.0
    return tiles, owner, n_whole


def _without_sun(
    tiles: np.ndarray, owner: np.ndarray, n_whole: int, tolerance: np.ndarray, total: np.ndarray, sky: TiledSky
) -> tuple[np.ndarray, np.ndarray, int]:
    """Tiles, owners and number of uncut ones where the sun's corners are cut off and added to `total`."""
    sun = sky.numbers[5]
    level = np.flatnonzero((tiles[:, 0] - SNAP <= sun) & (sun <= tiles[:, 1] + SNAP))
    y0, y1 = tiles[level, 2], tiles[level, 3]
    touching = level[sky.sun_beyond(y0, y1) <= y1]
    x0, x1, y0, y1 = tiles[touching].T
    is_tiny = np.maximum(x1 - x0, sky.sin_cos(x1)[0] * (y1 - y0)) * HALF_PI <= SMALLEST
    sunny = touching[~is_tiny].tolist()
    rest, rest_owner = [], []
    for k in sunny:
        value, cut = _sunny_tile(tiles[k], 0.1 * float(tolerance[owner[k]]), sky)
        total[owner[k]] += value
        rest += cut
        rest_owner += [owner[k]] * len(cut)
    if not sunny:
        return tiles, owner, n_whole
    others = np.ones(len(tiles), dtype=bool)
    others[sunny] = False
    tiles = np.concatenate([tiles[others], np.array(rest).reshape(-1, 4)])
    owner = np.concatenate([owner[others], np.array(rest_owner, dtype=np.int64)])
    return tiles, owner, int(np.count_nonzero(others[:n_whole]))


def _sunny_tile(tile: np.ndarray, tolerance: float, sky: TiledSky) -> tuple[float, list[tuple[float, ...]]]:
    """Integral over the corners of a tile at the sun, and the tiles that are cut off them."""
    x0, x1, y0, y1 = tile.tolist()
    xs = min(max(float(sky.numbers[5]), x0), x1)
    ys = float(sky.sun_beyond(tile[2:3], tile[3:4])[0])
    cut: list[tuple[float, ...]] = []
    total = 0.0
    for dx in (x1 - xs, x0 - xs):
        for dy in (y1 - ys, y0 - ys):
            if abs(dx) > SNAP and abs(dy) > SNAP:
                total += _corner(xs, ys, dx, dy, tolerance, sky, cut)
    return total, cut


def _corner(
    xs: float, ys: float, dx: float, dy: float, tolerance: float, sky: TiledSky, cut: list[tuple[float, ...]]
) -> float:
    """Integral over the tile from the sun to (xs + dx, ys + dy), less what goes to `cut`.

    The corner is made nearly square on the sky, because only then lines through the sun are smooth in
    their direction, no wider than the aureole allows, and smaller than the first circle of negative
    luminance.
    """

    def put(xa: float, xb: float, ya: float, yb: float) -> None:
        cut.append((min(xa, xb), max(xa, xb), min(ya, yb), max(ya, yb)))

    sine = float(sky.numbers[7])
    widest = WIDEST_DECAY / (abs(float(sky.numbers[3])) * HALF_PI + 1e-3)
    if len(sky.roots):
        widest = min(widest, max(0.5 * float(arc(sky.roots[0])) / HALF_PI, SMALLEST))
    while True:
        long_x, long_y = abs(dx), abs(dy) * sine
        limit = min(2.0 * max(min(long_x, long_y), SMALLEST), widest)
        if long_x > 1.001 * limit:
            put(xs + math.copysign(limit, dx), xs + dx, ys, ys + dy)
            dx = math.copysign(limit, dx)
        elif long_y > 1.001 * limit:
            put(xs, xs + dx, ys + math.copysign(limit / sine, dy), ys + dy)
            dy = math.copysign(limit / sine, dy)
        else:
            low, high = _corner_sums(xs, dx, dy, sky)
            if abs(high - low) <= tolerance or max(long_x, long_y) < SMALLEST:
                return high
            put(xs + 0.5 * dx, xs + dx, ys, ys + dy)
            put(xs, xs + 0.5 * dx, ys + 0.5 * dy, ys + dy)
            dx, dy = 0.5 * dx, 0.5 * dy


def _corner_sums(xs: float, dx: float, dy: float, sky: TiledSky) -> tuple[float, float]:
    """Integral over one corner by orders 8 and 10."""
    corner, sums = np.array([[xs, dx, dy]]), []
    for nodes, weights in ((X8, W8), (X10, W10)):
        out = np.empty((1, 2))
        sky.sums.corner_sums(corner, nodes, weights, sky.numbers, out)
        sums.append(float(out[0, 0] + out[0, 1]) * (abs(dx * dy) * STEP))
    return sums[0], sums[1]
