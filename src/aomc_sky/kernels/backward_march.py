"""The way of a ray through uniform spherical shells until it has passed a given optical depth.

Between radii a and b a line with impact parameter p runs (b^2 - a^2) / (sqrt(a^2 - p^2) + sqrt(b^2 - p^2)), where
a^2 - p^2 = (r mu)^2 + (a - r)(a + r) for a ray that has the cosine mu at radius r: one root and one quotient a shell,
and nothing is subtracted from something as large as the earth.
"""

from __future__ import annotations

import math

from aomc_sky.kernels.backward_light import EXTINCTION, GAP, HIGH, LOW
from aomc_sky.kernels.jit import inlined_reader


@inlined_reader
def rise(radius, shells, altitude, shell, mu, way, first, depth):
    """Go on upwards from a point: the shell, and the way in all, where `depth` is used up.

    `altitude` and `mu` are those of any point of the line; `first` is the difference of the squared radii of the
    first stretch, column GAP that of each shell. Shell -1: the top comes first.
    """
    twice = 2.0 * radius + altitude
    start = (radius + altitude) * mu
    square = start * start
    end = shells[shell, HIGH]
    q = math.sqrt(max(square + (end - altitude) * (end + twice) - first, 0.0))
    stretch = first
    for k in range(shell, shells.shape[0]):
        end = shells[k, HIGH]
        onward = math.sqrt(max(square + (end - altitude) * (end + twice), 0.0))
        length = stretch / (q + onward)
        passed = length * shells[k, EXTINCTION]
        if passed >= depth:
            return k, way + depth / shells[k, EXTINCTION]
        depth -= passed
        way += length
        q = onward
        stretch = shells[min(k + 1, shells.shape[0] - 1), GAP]
    return -1, way


@inlined_reader
def march(radius, shells, altitude, shell, mu, depth):
    """Shell and way at which a ray from a point has passed `depth`; shell -1 where the top or the ground is first."""
    twice = 2.0 * radius + altitude
    q = abs((radius + altitude) * mu)
    square = q * q
    way = 0.0
    first = (shells[shell, HIGH] - altitude) * (shells[shell, HIGH] + twice)
    if mu < 0.0:
        stretch = (altitude - shells[shell, LOW]) * (altitude + shells[shell, LOW] + 2.0 * radius)
        k = shell
        while True:
            rest = square - (altitude - shells[k, LOW]) * (shells[k, LOW] + twice)
            onward = math.sqrt(max(rest, 0.0))
            length = 2.0 * q if rest <= 0.0 else stretch / (q + onward)
            passed = length * shells[k, EXTINCTION]
            if passed >= depth:
                return k, way + depth / shells[k, EXTINCTION]
            depth -= passed
            way += length
            if rest <= 0.0:
                break
            k -= 1
            if k < 0:
                return -1, way
            q = onward
            stretch = shells[k, GAP]
        if k < shell:  # it is at this shell's upper edge again
            shell = k + 1
            first = shells[shell, GAP]
    return rise(radius, shells, altitude, shell, mu, way, first, depth)
