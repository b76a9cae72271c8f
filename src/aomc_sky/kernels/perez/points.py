"""Points of a Perez sky's integrals: lines of constant zenith angle, ranges of azimuth, sums over many points."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.jit import inner_reader
from aomc_sky.kernels.perez.law import arc, first_factor, sin_cos
from aomc_sky.kernels.perez.limits import SNAP

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE = range(8)
"""Places of the sky's numbers: coefficients, sun in quarter turns, sine of its zenith angle."""


@inner_reader
def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * x)
    return s * s


@inner_reader
def x_range(x0, x1, first, last, sky):
    """Smallest and largest sin^2((x - sun)/2) over [x0, x1] from the sines at its ends; 0 where it touches the sun."""
    is_level = x0 - SNAP <= sky[SUN_X] and sky[SUN_X] <= x1 + SNAP
    return 0.0 if is_level else min(first * first, last * last), max(first * first, last * last)


@inner_reader
def y_range(y0, y1, first, last, sky):
    """Smallest and largest sin^2((y - sun)/2) over [y0, y1] from the sines at its ends.

    Exactly 0 where the column touches the sun: the first one not before y0, snapped to the edges.
    """
    sun = sky[SUN_Y] - y0
    sun = y0 + (sun - 4.0 * np.floor(0.25 * sun))
    if y0 + 4.0 - sun < SNAP:
        sun = y0
    if abs(sun - y1) < SNAP:
        sun = y1
    low = 0.0 if sun <= y1 else min(first * first, last * last)
    opposite = sun + 2.0 if sun - y0 < 2.0 else sun - 2.0
    return low, 1.0 if y0 <= opposite <= y1 else max(first * first, last * last)


@inner_reader
def column_node(x, weight, sky):
    """Terms of h along one line of constant x, and the weight of its points."""
    s, c = sin_cos(x)
    return half_sine2(x - sky[SUN_X]), s * sky[SUN_SINE], weight * s * c * first_factor(c, sky[A], sky[B])


@inner_reader
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
