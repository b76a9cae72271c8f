"""The way of a ray through uniform spherical shells until it has passed a given optical depth.

On a line with impact parameter p the way from its lowest point to radius a is q = sqrt(a^2 - p^2), and what it runs in
a shell is the difference of two of them: one root a shell. With c = h (h + 2 R) of an altitude h, a^2 - p^2 is
(r mu)^2 + c_a - c for a ray that has the cosine mu at radius r: ways are good to an ulp of the earth's radius.
"""

from __future__ import annotations

import math

from aomc_sky.kernels.atmosphere.backward.light import EXTINCTION, FALL, RISE, index
from aomc_sky.kernels.jit import inlined_reader


@inlined_reader
def march(radius, shells, altitude, shell, mu, depth):
    """Shell and way at which a ray from a point has passed `depth`; shell -1 where the top or the ground is first."""
    start = (radius + altitude) * mu
    base = start * start - altitude * (altitude + 2.0 * radius)
    q = start
    if mu < 0.0:
        while base + shells[FALL, index(shell)] > 0.0:
            k = index(shell)
            onward = -math.sqrt(base + shells[FALL, k])
            left = depth - (onward - q) * shells[EXTINCTION, k]
            if left <= 0.0:
                return shell, q - start + depth / shells[EXTINCTION, k]
            depth = left
            q = onward
            shell -= 1
            if shell < 0:
                return -1, q - start
    for at in range(shell, shells.shape[1]):
        k = index(at)
        onward = math.sqrt(max(base + shells[RISE, k], 0.0))
        left = depth - (onward - q) * shells[EXTINCTION, k]
        if left <= 0.0:
            return at, q - start + depth / shells[EXTINCTION, k]
        depth = left
        q = onward
    return -1, q - start
