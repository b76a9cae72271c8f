"""Integrals along straight rays: particles per area, and weights of a column's source function.

A ray that rises from altitude a under the cosine mu has, s further on, the altitude

a + q / (sqrt(r^2 + q) + r), q = s (s + 2 r mu), r = R + a,

and reaches altitude b at s = c / (r mu + sqrt((r mu)^2 + c)), c = (b - a)(b + a + 2 R). The densities are polynomials
between the edges of panels; Gauss nodes along s are smooth there, also where the ray starts out level.

For successive orders a ray crosses an element of a column from share a to share b of its vertical depth, at the rate x
of optical path per share. The source is the polynomial through the element's nodes; rows of `inverse` turn its node
values into coefficients of powers.
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
def node_coordinates(low, start, mu, centre, half, middle, scale, node, x):
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
        node_coordinates(low, start, mu, 0.5 * (far + near), half, middle, scale, node, x)
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


@inner
def powers_integral(z, out):
    """psi_d(z) = int_0^1 v^d exp(-z (1 - v)) z dv for d = 0 .. out.size - 1; upward for z >= 1, else by a series."""
    top = out.size - 1
    if z >= 1.0:
        out[0] = -math.expm1(-z)
        for d in range(1, top + 1):
            out[d] = 1.0 - d / z * out[d - 1]
        return
    series = 0.0
    for j in range(14, -1, -1):
        series = z / (top + j + 1) * (1.0 - series)
    out[top] = series
    for d in range(top, 0, -1):
        out[d - 1] = (1.0 - out[d]) * z / d


@inner
def add_weights(rate, end, factor, inverse, psi, out):
    """Add to `out` factor times the weights of int_0^end exp(-rate (end - s)) J(s) rate ds."""
    powers_integral(rate * end, psi)
    power = factor
    for d in range(psi.size):
        term = psi[d] * power
        for j in range(psi.size):
            out[j] += term * inverse[d, j]
        power *= end


@inner
def add_stretch(depth, begin, end, factor, inverse, psi, out):
    """Add the weights of a stretch of optical path `depth` from share `begin` to `end`."""
    if depth <= 0.0 or end <= begin:
        return
    rate = depth / (end - begin)
    add_weights(rate, end, factor, inverse, psi, out)
    if begin > 0.0:
        add_weights(rate, begin, -factor * math.exp(-depth), inverse, psi, out)


@kernel
def fill_down(crossed, own, share, element, inverse, out):
    """Light that comes down to points: out (n_mu, n_point, n_level).

    Optical paths: crossed (n_point, n_mu, n_element) through each element, own (n_point, n_mu) above the point in its
    own one. Places of points: share, element (n_point,). Shape of inverse: (n_element, n_node, n_node).
    """
    n_node = inverse.shape[1]
    psi = np.empty(n_node)
    out[:] = 0.0
    for k in range(crossed.shape[0]):
        last = element[k]
        for i in range(crossed.shape[1]):
            row = out[i, k]
            add_stretch(own[k, i], 0.0, share[k], 1.0, inverse[last], psi, row[last * n_node : (last + 1) * n_node])
            left = math.exp(-own[k, i])
            for e in range(last - 1, -1, -1):
                add_stretch(crossed[k, i, e], 0.0, 1.0, left, inverse[e], psi, row[e * n_node : (e + 1) * n_node])
                left *= math.exp(-crossed[k, i, e])


@kernel
def fill_up(crossed, below, tangent, lowest, share, element, inverse, turned, up, over, from_ground):
    """Light that goes up to points: from this side of a line's lowest point, from beyond it, and from the ground.

    Optical path through the part of the own element below a point: below (n_point, n_mu). Lowest point of a line:
    tangent (n_point, n_mu, n_element), the share of an element above it, and lowest (n_point, n_mu), its altitude,
    negative under the ground. The `inverse` for shares counted from below: turned. Results: up, over (n_mu, n_point,
    n_level); from_ground (n_mu, n_point).
    """
    n_element, n_node = inverse.shape[0], inverse.shape[1]
    psi = np.empty(n_node)
    up[:] = 0.0
    over[:] = 0.0
    from_ground[:] = 0.0
    for k in range(crossed.shape[0]):
        first = element[k]
        for i in range(crossed.shape[1]):
            row = up[i, k]
            end = 1.0 - share[k]
            begin = min(1.0 - tangent[k, i, first], end)
            own = row[first * n_node : (first + 1) * n_node]
            add_stretch(below[k, i], begin, end, 1.0, turned[first], psi, own)
            left = math.exp(-below[k, i])
            deepest = first
            for e in range(first + 1, n_element):
                if tangent[k, i, e] <= 0.0:
                    break
                depth = crossed[k, i, e]
                here = row[e * n_node : (e + 1) * n_node]
                add_stretch(depth, 1.0 - tangent[k, i, e], 1.0, left, turned[e], psi, here)
                left *= math.exp(-depth)
                deepest = e
            if lowest[k, i] < 0.0:
                from_ground[i, k] = left
                continue
            far = over[i, k]
            for e in range(deepest, -1, -1):
                depth = crossed[k, i, e]
                here = far[e * n_node : (e + 1) * n_node]
                add_stretch(depth, 0.0, tangent[k, i, e], left, inverse[e], psi, here)
                left *= math.exp(-depth)
