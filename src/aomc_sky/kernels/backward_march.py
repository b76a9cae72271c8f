"""The way of a ray through uniform spherical shells until it has passed a given optical depth.

Between radii a and b a line with impact parameter p runs (b^2 - a^2) / (sqrt(a^2 - p^2) + sqrt(b^2 - p^2)), where
a^2 - p^2 = (r mu)^2 + (a - r)(a + r) for a ray that has the cosine mu at radius r: one root and one quotient a shell,
and nothing is subtracted from something as large as the earth.
"""

from __future__ import annotations

import math

from aomc_sky.kernels.jit import inner


@inner
def rise(radius, edge, gap, extinction, altitude, shell, mu, way, first, depth):
    """Go on upwards from a point: the shell, and the way in all, where `depth` is used up.

    `altitude` and `mu` are those of any point of the line; `first` is the difference of the squared radii of the
    first stretch, `gap` that of each shell. Shell -1: the top comes first.
    """
    twice = 2.0 * radius + altitude
    start = (radius + altitude) * mu
    square = start * start
    end = edge[shell + 1]
    q = math.sqrt(max(square + (end - altitude) * (end + twice) - first, 0.0))
    stretch = first
    for k in range(shell, extinction.size):
        end = edge[k + 1]
        onward = math.sqrt(max(square + (end - altitude) * (end + twice), 0.0))
        length = stretch / (q + onward)
        passed = length * extinction[k]
        if passed >= depth:
            return k, way + depth / extinction[k]
        depth -= passed
        way += length
        q = onward
        stretch = gap[min(k + 1, extinction.size - 1)]
    return -1, way


@inner
def march(radius, edge, gap, extinction, altitude, shell, mu, depth):
    """Shell and way at which a ray from a point has passed `depth`; shell -1 where the top or the ground is first."""
    twice = 2.0 * radius + altitude
    part = (edge[shell + 1] - altitude) * (edge[shell + 1] + twice)
    if mu >= 0.0:
        return rise(radius, edge, gap, extinction, altitude, shell, mu, 0.0, part, depth)
    q = -(radius + altitude) * mu
    square = q * q
    way = 0.0
    stretch = (altitude - edge[shell]) * (altitude + edge[shell] + 2.0 * radius)
    for k in range(shell, -1, -1):
        rest = square - (altitude - edge[k]) * (edge[k] + twice)
        low_point = rest <= 0.0
        onward = math.sqrt(max(rest, 0.0))
        length = 2.0 * q if low_point else stretch / (q + onward)
        passed = length * extinction[k]
        if passed >= depth:
            return k, way + depth / extinction[k]
        depth -= passed
        way += length
        if low_point and k == shell:
            return rise(radius, edge, gap, extinction, altitude, k, mu, way, part, depth)
        if low_point:
            return rise(radius, edge, gap, extinction, altitude, k + 1, mu, way, gap[k + 1], depth)
        q = onward
        stretch = gap[max(k - 1, 0)]
    return -1, way
