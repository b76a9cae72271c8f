"""Particles per area along straight rays through a spherical atmosphere: the quadrature under all optical depths.

A ray that rises from altitude a under the cosine mu has, s further on, the altitude

    a + q / (sqrt(r^2 + q) + r),  q = s (s + 2 r mu),  r = R + a,

and reaches altitude b at s = c / (r mu + sqrt((r mu)^2 + c)), c = (b - a)(b + a + 2 R). Nothing is subtracted from
something as large as the earth, so an atmosphere of 1 m keeps its digits. The densities are polynomials between the
edges of panels; Gauss nodes along s are smooth there, also where the ray starts out level.
"""

from __future__ import annotations

import math

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
def add_panel(coefficient, panel, x, weight, column):
    """Add weight times the densities at x in [-1, 1] of a panel; Horner's rule, highest power first."""
    for part in range(column.size):
        value = coefficient[panel, 0, part]
        for power in range(1, coefficient.shape[1]):
            value = value * x + coefficient[panel, power, part]
        column[part] += weight * value


@inner
def column_between(radius, edge, coefficient, node, node_weight, low, mu, high, column):
    """Particles per area (n_part,) along a rising ray from `low` to `high`, split at the edges."""
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
        centre = 0.5 * (far + near)
        middle = 0.5 * (edge[panel] + edge[panel + 1])
        scale = 2.0 / (edge[panel + 1] - edge[panel])
        for k in range(node.size):
            s = centre + half * node[k]
            q = s * (s + 2.0 * start * mu)
            altitude = low + q / (math.sqrt(start * start + q) + start)
            add_panel(coefficient, panel, (altitude - middle) * scale, half * node_weight[k], column)
        near = far
        panel += 1


@kernel
def fill_columns(radius, edge, coefficient, node, node_weight, low, mu, high, column):
    """Particles per area (n, n_part) along n rising rays, each from its `low` to its `high` altitude."""
    for k in range(low.size):
        column_between(radius, edge, coefficient, node, node_weight, low[k], mu[k], high[k], column[k])
