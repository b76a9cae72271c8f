"""Points of a Perez sky's integrals: lines of constant zenith angle, ranges of azimuth, sums over many points."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner
from aomc_sky.kernels.perez_law import arc, exp_level, first_factor, sin_cos
from aomc_sky.kernels.perez_limits import SNAP

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE = range(8)
"""Places of the sky's numbers: coefficients, sun in quarter turns, sine of its zenith angle."""


@inner
def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * x)
    return s * s


@inner
def _sun_beyond(y0, y1, sky):
    """Azimuth of the sun as the first one not before y0, snapped to the edges of [y0, y1]."""
    y = sky[SUN_Y] - y0
    y = y0 + (y - 4.0 * np.floor(0.25 * y))
    if y0 + 4.0 - y < SNAP:
        y = y0
    if abs(y - y1) < SNAP:
        y = y1
    return y


@inner
def y_range(y0, y1, sky):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1]; exactly 0 where the column touches the sun."""
    first, last = half_sine2(y0 - sky[SUN_Y]), half_sine2(y1 - sky[SUN_Y])
    sun = _sun_beyond(y0, y1, sky)
    low = 0.0 if sun <= y1 else min(first, last)
    opposite = sun + 2.0 if sun - y0 < 2.0 else sun - 2.0
    return low, 1.0 if y0 <= opposite <= y1 else max(first, last)


@inner
def column_node(x, weight, sky):
    """Terms of h along one line of constant x, and the weight of its points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[SUN_X]), s * sky[SUN_SINE], weight * s * c * first_factor(c, sky[A], sky[B])


@inner
def sum_points(n, sky, h, weight, aureole):
    """Sum of weight times luminance over n points, where it is positive."""
    c, d, e = sky[C], sky[D], sky[E]
    for k in range(n):
        aureole[k] = d * arc(h[k])
    for k in range(n):
        aureole[k] = exp_level(aureole[k])
    for k in range(n):
        q = 1.0 - (h[k] + h[k])
        weight[k] = max(weight[k] * (1.0 + c * aureole[k] + e * (q * q)), 0.0)
    total = 0.0
    for k in range(n):
        total += weight[k]
    return total
