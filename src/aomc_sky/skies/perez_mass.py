"""Integral of the Perez luminance times cos xi over each patch of a grid, refined until two orders agree.

In zenith angle x and azimuth y everything is smooth but for the cusp at the sun, the layer of exp(b/mu) at
the horizon, and the edges of a region where the luminance is negative and counts as 0. Rings are cut
for the layer and at the zero of the first factor; tiles that two orders do not agree on are halved; the
sun's tiles are integrated on lines through the sun; tiles that the edge of the unlit region crosses
go to `aomc_sky.kernels.perez_edges`. All with + - x / sqrt: the same bits on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.kernels.perez_limits import (
    AGREE_4,
    AGREE_6,
    AGREE_8,
    FAR_4,
    HALF_PI,
    SNAP,
    STEP,
    WIDEST_DECAY,
)
from aomc_sky.kernels.perez_nodes import NODES, WEIGHTS, X3, X4
from aomc_sky.skies.perez_refine import refined
from aomc_sky.skies.perez_tiles import ROUNDING, TiledSky
from aomc_sky.skies.perez_zeros import first_factor_zero, second_factor_zeros

_ORDERS = np.array([3, 4, 6, 8])
_RING_AGREE = 0.3 * np.array([AGREE_4, AGREE_6, AGREE_8])


def patch_integrals(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray, sums: Any) -> np.ndarray:
    """Integrate max(f, 0) cos xi over each patch.

    Parameters
    ----------
    zenith, azimuth : ndarray, float64, shapes (n_ring, 2) and (n_column, 2)
        Edges of the rings and of the columns. [quarter turns]
    numbers : ndarray, float64, shape (8 or more,)
        a, b, c, d, e with b <= 0, zenith angle and azimuth of the sun in quarter turns, sine of the former.
    sums : module
        `aomc_sky.kernels.perez_mass`, or `aomc_sky.kernels.plain_perez_mass` with the same bits.

    Returns
    -------
    ndarray, float64, shape (n_ring, n_column)
        [sr]

    Notes
    -----
    Accuracy: 1e-10 of a patch; the largest errors are at the point opposite to a sun on the horizon.
    """
    a, b, c, d, e = numbers[:5].tolist()
    sky = TiledSky(numbers=numbers, roots=second_factor_zeros(c, d, e), x_zero=first_factor_zero(a, b), sums=sums)
    columns, partner = _columns(azimuth, sky)
    out = np.zeros((len(zenith), len(azimuth)))
    x0, x1, pair, ring = _cut_rings(zenith, sky)
    if not len(ring) or not len(columns):
        return out
    edges = azimuth[columns]
    mass, tiles, rough, floor, place = _first_pass(x0, x1, pair, edges, sky)
    mass = mass.ravel()
    if len(tiles):
        mass[place] = refined(tiles, rough, floor, sky)
    parts = mass.reshape(len(ring), -1)
    is_start = np.diff(ring, prepend=-1) > 0
    summed, row = parts[is_start], np.cumsum(is_start) - 1
    for part in np.flatnonzero(~is_start):
        summed[row[part]] += parts[part]
    rows = ring[is_start][:, None]
    out[rows, columns] = summed
    if partner is not columns:
        out[rows, partner] = summed
    return out


def _columns(azimuth: np.ndarray, sky: TiledSky) -> tuple[np.ndarray, np.ndarray]:
    """Columns to integrate, and the one that each also serves as its mirror image at the sun's azimuth.

    Equal columns around the whole sky, with the sun on an edge or in the middle of one, need half the work.
    """
    n = len(azimuth)
    all_ = np.flatnonzero(azimuth[:, 1] > azimuth[:, 0])
    starts = azimuth[0, 0] + np.arange(n) * (4.0 / n)
    places = (sky.numbers[6] - azimuth[0, 0]) * (n / 2.0)
    is_even = np.max(np.abs(azimuth - np.stack([starts, starts + 4.0 / n], axis=1))) < SNAP
    if not is_even or abs(places - np.rint(places)) > SNAP * n:
        return all_, all_
    partner = (int(np.rint(places)) - 1 - np.arange(n)) % n
    first = np.flatnonzero(np.arange(n) <= partner)
    return first, partner[first]


def _cut_rings(zenith: np.ndarray, sky: TiledSky) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Parts of the rings on which a pair of orders agrees on the first factor alone: edges, pair and ring."""
    ring = np.flatnonzero(zenith[:, 1] > zenith[:, 0])
    x0, x1 = zenith[ring].T
    done: list[tuple[np.ndarray, ...]] = []
    while len(ring):
        has_zero = (x0 + SNAP < sky.x_zero) & (sky.x_zero < x1 - SNAP)
        pair = np.empty(len(ring), dtype=np.int64)
        sky.sums.ring_pairs(x0, x1, _ORDERS, _RING_AGREE, ROUNDING, NODES, WEIGHTS, sky.numbers, pair)
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
    """Masses of all patches where a pair of orders agrees, and the tiles, estimates, floors and places of the rest."""
    y0, y1 = edges.T
    width = y1 - y0
    (x_low, x_high), (y_low, y_high) = sky.x_range(x0, x1), sky.y_range(y0, y1)
    s, c = sky.sin_cos(np.stack([x0, x1, 0.5 * (x0 + x1)]))
    growth = s * sky.numbers[7]
    per_width = sky.scale * (x1 - x0) * s[2] * c[2] * STEP
    length = np.maximum(x1 - x0, s[1] * width.max()) * HALF_PI  # of the widest column
    nearest = sky.nearest(length, FAR_4, per_width * width.min())
    three, four = _pair_masses(x0, x1, pair, edges, sky)
    good = np.empty(four.shape, dtype=bool)
    sky.sums.first_look(three, four, (x_low, growth[0], y_low), nearest, per_width, width, AGREE_4, good)
    good &= width <= 1.0
    if abs(sky.numbers[3]) * length.max() > WIDEST_DECAY or len(sky.roots):
        low = x_low[:, None] + growth[0][:, None] * y_low
        high = x_high[:, None] + growth[1][:, None] * y_high
        good &= ~sky.needs_cut(length[:, None], low, high)
    part, column = np.nonzero(~good)
    tiles = np.stack([x0[part], x1[part], y0[column], y1[column]], axis=1)
    rest = (tiles, four[part, column], per_width[part] * width[column], part * len(edges) + column)
    return np.where(good, four, 0.0), *rest


def _pair_masses(
    x0: np.ndarray, x1: np.ndarray, pair: np.ndarray, edges: np.ndarray, sky: TiledSky
) -> tuple[np.ndarray, np.ndarray]:
    """Masses by the lower and the higher order of each ring's pair, orders 3 and 4 in azimuth; (part, column)."""
    width = edges[:, 1] - edges[:, 0]
    three, four = np.empty((len(x0), len(edges))), np.empty((len(x0), len(edges)))
    nodes = [(edges[:, :1] + width[:, None] * ny).ravel() for ny in (X3, X4)]
    columns = np.split(sky.half_sine2(np.concatenate(nodes) - sky.numbers[6]), [len(nodes[0])])
    sky.sums.ring_sums(x0, x1, pair, _ORDERS, *columns, NODES, WEIGHTS, sky.numbers, three, four)
    area = ((x1 - x0) * STEP)[:, None] * width
    three *= area
    four *= area
    return three, four
