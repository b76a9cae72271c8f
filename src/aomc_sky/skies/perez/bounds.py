"""Rigorous bounds of the Perez luminance over each patch, for the exact rejection inside it.

The first factor is monotonic in mu for b <= 0, exp(d gamma) in gamma, and the ends of gamma over a patch are
known, so bounds of both factors and of their product follow without sampling. Where the luminance is smooth,
`perez_tilt` knows better: there photons are sent along its slope first, and little is left to reject.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.kernels.perez.plain_law import first_factor, half_sine2, sin_cos
from aomc_sky.skies.perez.tilt import tilted_bounds

_SLACK = 1e-6  # the rounding of the luminance, of float32 directions and of their slope stays inside


def _azimuth_range(y0: np.ndarray, y1: np.ndarray, sun: float) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest sin^2((y - sun)/2) over each column [y0, y1]. [quarter turns]"""
    first, last = half_sine2(y0 - sun), half_sine2(y1 - sun)
    has_sun = np.mod(sun - y0, 4.0) <= y1 - y0
    has_opposite = np.mod(sun + 2.0 - y0, 4.0) <= y1 - y0
    return np.where(has_sun, 0.0, np.minimum(first, last)), np.where(has_opposite, 1.0, np.maximum(first, last))


def _half_chord2_range(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest sin^2(gamma/2) over each patch, shape (n_ring, n_column).

    It grows with the azimuth from the sun on every ring, so both lie on the nearest and the farthest meridian.
    Along one of them cos gamma = A cos x + B sin x with A = cos Z, B = sin Z cos(azimuth): the largest
    value is at an end, the smallest at an end or at the foot of the perpendicular from the sun, where
    cos^2 gamma = 1 - sin^2 Z sin^2(azimuth).
    """
    sun_x, sun_y, sine, cosine = numbers[5], numbers[6], numbers[7], numbers[10]
    y_low, y_high = _azimuth_range(azimuth[:, 0], azimuth[:, 1], sun_y)
    (s0, s1), (c0, c1) = sin_cos(zenith.T)
    near, far = half_sine2(zenith.T - sun_x)
    ends_low = np.minimum(near[:, None] + (s0 * sine)[:, None] * y_low, far[:, None] + (s1 * sine)[:, None] * y_low)
    high = np.maximum(near[:, None] + (s0 * sine)[:, None] * y_high, far[:, None] + (s1 * sine)[:, None] * y_high)
    along = sine * (1.0 - (y_low + y_low))
    across = sine * sine * (4.0 * y_low * (1.0 - y_low))
    foot = 0.5 * across / (1.0 + np.sqrt(np.maximum(1.0 - across, 0.0)))
    has_foot = (along * c0[:, None] >= cosine * s0[:, None]) & (along * c1[:, None] <= cosine * s1[:, None])
    return np.where(has_foot, np.minimum(ends_low, foot), ends_low), np.minimum(high, 1.0)


def perez_bounds(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray, sums: Any) -> np.ndarray:
    """Return the slope along which photons are sent over each patch, and bounds of max(f, 0) with it.

    Parameters
    ----------
    zenith, azimuth : ndarray, float64, shape (n_ring, 2) and (n_column, 2)
        Edges of rings and columns. [quarter turns]
    numbers : ndarray, float64, shape (11,)
        The sky, as `aomc_sky.component.Component.shared` lists it, with b <= 0.
    sums : module
        `aomc_sky.kernels.perez.mass`, or `aomc_sky.kernels.perez.plain_mass` with the same bits.

    Returns
    -------
    ndarray, float64, shape (n_ring, n_column, 4)
        Upper bound, lower bound, tilts in u and v, as `Component.bounds` lists them; tilts are 0 where the bounds
        without them are closer. Accuracy: on patches of 2 degrees of a clear sky the upper bounds are 2 % above
        the means, all together, under an overcast one 0.1 %.
    """
    a, b, c, d, e = numbers[:5]
    low, high = _half_chord2_range(zenith, azimuth, numbers)
    aureole = np.empty((2, low.size))
    for half_chord2, out in zip((low, high), aureole, strict=True):
        sums.each_aureole(half_chord2.ravel(), c, d, out)
    first, last = aureole.reshape(2, *low.shape)
    q0, q1 = 1.0 - (low + low), 1.0 - (high + high)
    most = np.maximum(q0 * q0, q1 * q1)
    least = np.where(q0 * q1 <= 0.0, 0.0, np.minimum(q0 * q0, q1 * q1))
    second_low = 1.0 + np.minimum(first, last) + np.minimum(e * least, e * most)
    second_high = 1.0 + np.maximum(first, last) + np.maximum(e * least, e * most)
    factor = first_factor(sin_cos(zenith)[1], a, b)
    products = [factor[:, k, None] * second for k in (0, 1) for second in (second_low, second_high)]
    flat = np.zeros((*low.shape, 4))
    flat[..., 0], flat[..., 1] = np.maximum.reduce(products), np.minimum.reduce(products)
    tilted = tilted_bounds(zenith, azimuth, numbers, (low, high), second_low)
    bounds = np.where((tilted[..., :1] < flat[..., :1]), tilted, flat)  # not where it is NaN
    bounds[..., 0] = np.maximum(bounds[..., 0], 0.0) * (1.0 + _SLACK)
    bounds[..., 1] = np.maximum(bounds[..., 1], 0.0) * (1.0 - _SLACK)
    return bounds
