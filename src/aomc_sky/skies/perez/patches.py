"""What a patch of a Perez sky holds: the integral of the luminance times cos xi, and the means of mu and of 1/mu.

In zenith angle x and azimuth y everything is smooth but for the cusp at the sun, the layer of exp(b/mu) at
the horizon, and the edges of a region where the luminance is negative and counts as 0. Rings are cut
for the layer and at the zero of the first factor; tiles that two orders do not agree on are halved; the
sun's tiles are integrated on lines through the sun; tiles that the edge of the unlit region crosses
go to `edge_integrals`. All with + - x / sqrt: the same bits on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.kernels.perez.limits import AGREE_4, AGREE_6, AGREE_8, SNAP
from aomc_sky.kernels.perez.nodes import NODES, W4, WEIGHTS, X4
from aomc_sky.kernels.perez.plain_law import first_factor, half_sine2, second_factor, sin_cos
from aomc_sky.skies.perez.tiles import ROUNDING, TiledSky, refined

_ORDERS = np.array([3, 4, 6, 8])
_RING_AGREE = 0.3 * np.array([AGREE_4, AGREE_6, AGREE_8])


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
            parts.ravel()[index] = refined(tiles, rough, floor, sky)
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
