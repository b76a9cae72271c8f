"""Bounds of the Perez luminance over each patch, for the exact rejection inside it."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel
from aomc_sky.kernels.perez_law import arc, exp_level, first_factor, sin_cos
from aomc_sky.kernels.perez_mass import SUN_SINE, SUN_X, A, B, C, D, E, half_sine2, y_range

_SLACK = 1e-9  # rounding of the luminance and of float32 directions stays inside


@inner
def _lowest_half_chord2(x0, x1, s0, s1, y_low, sky):
    """Smallest sin^2(gamma/2) over a patch: on the meridian nearest to the sun, at an end or at its foot.

    Along a meridian cos gamma = A cos x + B sin x with A = cos S, B = sin S cos(azimuth), and the largest
    value, at the foot of the perpendicular from the sun, is the root of 1 - sin^2 S sin^2(azimuth).
    """
    sine = sky[SUN_SINE]
    low = min(
        half_sine2(x0 - sky[SUN_X]) + s0 * sine * y_low,
        half_sine2(x1 - sky[SUN_X]) + s1 * sine * y_low,
    )
    _, cosine = sin_cos(sky[SUN_X])
    along = sine * (1.0 - (y_low + y_low))
    _, c0 = sin_cos(x0)
    _, c1 = sin_cos(x1)
    if along * c0 - cosine * s0 >= 0.0 and along * c1 - cosine * s1 <= 0.0:
        across = sine * sine * (4.0 * y_low * (1.0 - y_low))
        low = min(low, 0.5 * across / (1.0 + np.sqrt(max(1.0 - across, 0.0))))
    return low


@inner
def _second_factor_range(low, high, c, d, e):
    """Bounds of 1 + c exp(d gamma) + e cos^2 gamma where sin^2(gamma/2) lies within [low, high]."""
    first, last = c * exp_level(d * arc(low)), c * exp_level(d * arc(high))
    q0, q1 = 1.0 - (low + low), 1.0 - (high + high)
    least = 0.0 if q0 * q1 <= 0.0 else min(q0 * q0, q1 * q1)
    most = max(q0 * q0, q1 * q1)
    return 1.0 + min(first, last) + min(e * least, e * most), 1.0 + max(first, last) + max(e * least, e * most)


@kernel
def perez_bounds(zenith, azimuth, sky, out):
    """Fill `out` (n_ring, n_column, 2) with an upper and a lower bound of max(f, 0) over each patch.

    `zenith` and `azimuth` (n, 2) are the patches' edges in quarter turns, `sky` as in `perez_mass`. The first
    factor is monotonic in mu for b <= 0, exp(d gamma) in gamma, and the ends of gamma are exact, so that
    the bounds are rigorous; the product of the factors' bounds is within a few percent of the true ends.
    """
    for ring in range(zenith.shape[0]):
        x0, x1 = zenith[ring, 0], zenith[ring, 1]
        s0, c0 = sin_cos(x0)
        s1, c1 = sin_cos(x1)
        near, far = first_factor(c0, sky[A], sky[B]), first_factor(c1, sky[A], sky[B])
        for column in range(azimuth.shape[0]):
            y_low, y_high = y_range(azimuth[column, 0], azimuth[column, 1], sky)
            low = _lowest_half_chord2(x0, x1, s0, s1, y_low, sky)
            high = max(
                half_sine2(x0 - sky[SUN_X]) + s0 * sky[SUN_SINE] * y_high,
                half_sine2(x1 - sky[SUN_X]) + s1 * sky[SUN_SINE] * y_high,
            )
            least, most = _second_factor_range(low, min(high, 1.0), sky[C], sky[D], sky[E])
            upper = max(near * least, near * most, far * least, far * most)
            lower = min(near * least, near * most, far * least, far * most)
            out[ring, column, 0] = max(upper, 0.0) * (1.0 + _SLACK)
            out[ring, column, 1] = max(lower, 0.0) * (1.0 - _SLACK)
