"""Weights of a column's source function along straight lines through its elements, for successive orders of scattering.

An element is crossed from share a to share b of its vertical depth at the rate x of optical path per share; the
source is the polynomial through its nodes. Rows of `inverse` turn its node values into coefficients of powers.
"""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.jit import inner, kernel


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

    crossed (n_point, n_mu, n_element): optical path through each element; own (n_point, n_mu): through the part above
    the point of its own one; share, element (n_point,): where the point lies; inverse (n_element, n_node, n_node).
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

    below (n_point, n_mu): optical path through the part of the own element below a point; tangent (n_point, n_mu,
    n_element): share of an element above the line's lowest point; lowest (n_point, n_mu): its altitude, negative under
    the ground; turned: `inverse` for shares counted from below. up, over (n_mu, n_point, n_level); from_ground (n_mu,
    n_point).
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
