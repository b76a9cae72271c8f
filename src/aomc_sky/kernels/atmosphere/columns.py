"""Particles per area along straight rays through a spherical atmosphere: the quadrature under all optical depths.

A ray that rises from altitude a under the cosine mu has, s further on, the altitude

    a + q / (sqrt(r^2 + q) + r),  q = s (s + 2 r mu),  r = R + a,

and reaches altitude b at s = c / (r mu + sqrt((r mu)^2 + c)), c = (b - a)(b + a + 2 R). Nothing is subtracted from
something as large as the earth, so an atmosphere of 1 m keeps its digits. The densities are polynomials between the
edges of panels; Gauss nodes along s are smooth there, also where the ray starts out level.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.jit import inner, kernel


@inner
def distance_to(radius, low, mu, high):
    """Way along a rising ray (mu >= 0) from altitude `low` to `high`."""
    start = (radius + low) * mu
    c = (high - low) * (high + low + 2.0 * radius)
    if c <= 0.0:
        return 0.0
    return c / (start + math.sqrt(start * start + c))


@inner
def place(low, start, mu, centre, half, middle, scale, node, x):
    """Coordinates in the panel, -1 to 1, of the nodes of the stretch of a ray."""
    turn = 2.0 * start * mu
    square = start * start
    for k in range(node.size):
        s = centre + half * node[k]
        q = s * (s + turn)
        x[k] = (low - middle + q / (math.sqrt(square + q) + start)) * scale


@inner
def add_panel(term, x, half, node_weight, value, column):
    """Add to `column` the integrals over a stretch; term (n_part, 10), named one by one so that nodes go abreast."""
    for part in range(column.size):
        a, b, c, d, e = term[part, 0], term[part, 1], term[part, 2], term[part, 3], term[part, 4]
        f, g, h, i, j = term[part, 5], term[part, 6], term[part, 7], term[part, 8], term[part, 9]
        for k in range(x.size):
            y = x[k]
            high = (((a * y + b) * y + c) * y + d) * y + e
            value[k] = node_weight[k] * (((((high * y + f) * y + g) * y + h) * y + i) * y + j)
        total = 0.0
        for k in range(x.size):
            total += value[k]
        column[part] += half * total


@inner
def column_between(radius, edge, coefficient, node, node_weight, low, mu, high, x, value, column):
    """Particles per area (n_part,) along a rising ray from `low` to `high`, split at the edges; x and value: (k,)."""
    column[:] = 0.0
    start = radius + low
    n_panel = edge.size - 1
    panel = 0
    while panel < n_panel - 1 and edge[panel + 1] <= low:
        panel += 1
    near = 0.0
    while panel < n_panel and edge[panel] < high:
        far = distance_to(radius, low, mu, min(high, edge[panel + 1]))
        half = 0.5 * (far - near)
        middle = 0.5 * (edge[panel] + edge[panel + 1])
        scale = 2.0 / (edge[panel + 1] - edge[panel])
        place(low, start, mu, 0.5 * (far + near), half, middle, scale, node, x)
        add_panel(coefficient[panel], x, half, node_weight, value, column)
        near = far
        panel += 1


@kernel
def fill_columns(radius, edge, coefficient, node, node_weight, low, mu, high, column):
    """Particles per area (n, n_part) along n rising rays, each from its `low` to its `high` altitude.

    `coefficient` is (n_panel, n_part, 10), highest power first, over x in [-1, 1] of each panel.
    """
    x = np.empty(node.size)
    value = np.empty(node.size)
    for k in range(low.size):
        column_between(radius, edge, coefficient, node, node_weight, low[k], mu[k], high[k], x, value, column[k])
