"""The sums of `perez_mass` in plain numpy, equal to the bit: a first sky need not wait for the compiler."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.plain_perez_law import first_factor, half_sine2, second_factor, sin_cos


def _lines(x, weights, sky):
    """Terms of h along lines of constant x, and the weights of their points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[5]), s * sky[7], weights * s * c * first_factor(c, sky[0], sky[1])


def ring_sums(x0, x1, nodes, weights, columns, sky, out):
    """Sums over the lines of each ring at the columns' nodes, shape (ring, node)."""
    out[:] = 0.0
    for node, weight in zip(nodes, weights, strict=True):
        near, growth, factor = _lines(x0 + (x1 - x0) * node, weight, sky)
        h = near[:, None] + growth[:, None] * columns
        out += np.maximum(factor[:, None] * second_factor(h, sky[2], sky[3], sky[4]), 0.0)


def tile_sums(tiles, nodes_x, weights_x, nodes_y, weights_y, sky, out):
    """Sums over tensor Gauss points of tiles (x0, x1, y0, y1); shape (tile,)."""
    x0, x1, y0, y1 = tiles.T[:, :, None]
    near, growth, factor = _lines(x0 + (x1 - x0) * nodes_x, weights_x, sky)
    columns = half_sine2(y0 + (y1 - y0) * nodes_y - sky[6])
    h = near[:, :, None] + growth[:, :, None] * columns[:, None, :]
    weight = factor[:, :, None] * weights_y
    value = np.maximum(weight * second_factor(h, sky[2], sky[3], sky[4]), 0.0)
    out[:] = np.cumsum(value.reshape(len(tiles), -1), axis=1)[:, -1]


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
