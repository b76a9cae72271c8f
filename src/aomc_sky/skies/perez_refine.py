"""Refinement of the tiles of a Perez sky that two orders of Gauss points do not agree on."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.perez_nodes import W3, W4, W6, W8, W10, X3, X4, X6, X8, X10
from aomc_sky.kernels.plain_perez_law import arc
from aomc_sky.skies.perez_tiles import (
    AGREE_6,
    AGREE_8,
    FAR_6,
    FAR_8,
    HALF_PI,
    SMALLEST,
    SNAP,
    STEP,
    WIDEST_DECAY,
    TiledSky,
)

_THIN = 0.25
_EDGE = 300.0


def refined(tiles: np.ndarray, rough: np.ndarray, floor: np.ndarray, sky: TiledSky) -> np.ndarray:
    """Integrate over tiles, halved until orders 6 and 8 agree, the sun's corners apart.

    Parameters
    ----------
    tiles : ndarray, float64, shape (n_tile, 4)
        x0, x1, y0, y1. [quarter turns]
    rough, floor : ndarray, float64, shape (n_tile,)
        The integrals by order 4, and the error that rounding makes of them. [sr]
    sky : TiledSky
        The sky.

    Returns
    -------
    ndarray, float64, shape (n_tile,)
        [sr]
    """
    total = np.zeros(len(tiles))
    owner = np.arange(len(tiles))
    tolerance = AGREE_8 * rough + floor
    is_first = True
    while len(tiles):
        value, tiles, owner = _one_round(tiles, owner, rough, floor, tolerance, is_first, sky)
        for places, part in value:
            np.add.at(total, places, part)
        is_first = False
    return total


def _one_round(
    tiles: np.ndarray,
    owner: np.ndarray,
    rough: np.ndarray,
    floor: np.ndarray,
    tolerance: np.ndarray,
    is_first: bool,
    sky: TiledSky,
) -> tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray, np.ndarray]:
    """Integrals that are settled, by owner, and the tiles that remain."""
    shapes = np.empty((6, len(tiles)))
    sky.sums.tile_shapes(tiles, _THIN, sky.numbers, shapes)
    low, high, length = shapes[:3]
    touches, along_x, thin = shapes[3:] > 0
    is_tiny = length <= SMALLEST
    around = tiles[:, 3] - tiles[:, 2] > 1.0
    sunny = touches & ~around & ~is_tiny if sky.has_cusp else np.zeros_like(touches)
    wide = ~(around | sunny | is_tiny) & sky.too_wide(length, low)
    edge = ~(around | sunny | wide) & sky.has_root(low, high)
    wide |= edge & (length > 0.1) & ~is_tiny
    edge &= ~wide
    plain = np.flatnonzero(~(around | sunny | wide | edge))
    shape = (low[plain], length[plain], thin[plain])
    eight, agree = _plain_tiles(tiles[plain], shape, owner[plain], rough, floor, is_first, sky)
    good = agree | is_tiny[plain]
    settled = [(owner[plain[good]], eight[good])]
    if edge.any():
        settled.append((owner[edge], _edge_tiles(tiles[edge], (tolerance + _EDGE * floor)[owner[edge]], sky)))
    wide[plain[~good]] = True
    rest, rest_owner = [], []
    for k in np.flatnonzero(sunny):
        value, cut = _sunny_tile(tiles[k], 0.1 * tolerance[owner[k]], sky)
        settled.append((owner[k : k + 1], np.array([value])))
        rest.append(np.array(cut).reshape(-1, 4))
        rest_owner.append(np.full(len(cut), owner[k]))
    chosen = around | wide
    if chosen.any():
        rest.append(_halved(tiles[chosen], (along_x & ~around)[chosen]))
        rest_owner.append(np.concatenate([owner[chosen], owner[chosen]]))
    if not rest:
        return settled, tiles[:0], owner[:0]
    return settled, np.concatenate(rest), np.concatenate(rest_owner)


def _plain_tiles(
    tiles: np.ndarray,
    shape: tuple[np.ndarray, np.ndarray, np.ndarray],
    owner: np.ndarray,
    rough: np.ndarray,
    floor: np.ndarray,
    is_first: bool,
    sky: TiledSky,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrals by order 8 or, the first time, 6, and whether the order below agrees."""
    tolerance = (AGREE_8 * rough + floor)[owner]
    low, length, thin = shape
    six, eight = np.empty(len(tiles)), np.empty(len(tiles))
    six[thin] = sky.tile_sums(tiles[thin], X6, W6, X3, W3)
    six[~thin] = sky.tile_sums(tiles[~thin], X6, W6, X6, W6)
    agree = np.zeros(len(tiles), dtype=bool)
    if is_first:
        agree = ~thin & (np.abs(six - rough[owner]) <= AGREE_6 * rough[owner] + floor[owner])
        agree &= low >= sky.nearest(length, FAR_6, floor[owner])
    eight[agree] = six[agree]
    more, thick = thin & ~agree, ~thin & ~agree
    eight[more] = sky.tile_sums(tiles[more], X8, W8, X4, W4)
    eight[thick] = sky.tile_sums(tiles[thick], X8, W8, X8, W8)
    agree |= (np.abs(eight - six) <= tolerance) & (low >= sky.nearest(length, FAR_8, tolerance))
    return eight, agree


def _edge_tiles(tiles: np.ndarray, tolerance: np.ndarray, sky: TiledSky) -> np.ndarray:
    """Integrals over tiles that the edge of the unlit region crosses."""
    from aomc_sky.kernels.perez_edges import edge_integrals

    out = np.empty(len(tiles))
    edge_integrals(np.ascontiguousarray(tiles), tolerance, sky.numbers, sky.roots, out)
    return out


def _halved(tiles: np.ndarray, along_x: np.ndarray) -> np.ndarray:
    """Both halves of each tile, cut along x or along y; first the lower halves."""
    middle_x, middle_y = 0.5 * (tiles[:, 0] + tiles[:, 1]), 0.5 * (tiles[:, 2] + tiles[:, 3])
    lower, upper = tiles.copy(), tiles.copy()
    lower[:, 1] = np.where(along_x, middle_x, tiles[:, 1])
    upper[:, 0] = np.where(along_x, middle_x, tiles[:, 0])
    lower[:, 3] = np.where(along_x, tiles[:, 3], middle_y)
    upper[:, 2] = np.where(along_x, tiles[:, 2], middle_y)
    return np.concatenate([lower, upper])


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
    corner, found = np.array([[xs, dx, dy]]), []
    for nodes, weights in ((X8, W8), (X10, W10)):
        out = np.empty((1, 2))
        sky.sums.corner_sums(corner, nodes, weights, sky.numbers, out)
        found.append(float(out[0, 0] + out[0, 1]) * (abs(dx * dy) * STEP))
    return found[0], found[1]
