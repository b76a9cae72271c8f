"""Rigorous bounds of the Perez luminance over each patch, for the exact rejection inside it.

The first factor is monotonic in mu for b <= 0, exp(d gamma) in gamma. The ends of gamma over a patch are known. They
bound both factors and their product without sampling. If the luminance is smooth, photons are sent along
its slope first, and little is left to reject:

A patch is the unit square of (u, v), uniform in mu^2 and in azimuth. The map u' = u + k u (1 - u), and the same for v,
sends photons to the brighter side. Their density is 1 / J, J = (1 + k_u (1 - 2u)) (1 + k_v (1 - 2v)). With k half the
logarithmic slope of the luminance f across the patch, f J is constant to second order. By Taylor's theorem, log f
differs from its tangent at the patch's centre by at most R, half the largest second derivative along any line through
the patch. The map's difference from the tangent is known exactly:

    e^|k_u| (1 - |k_u|) e^|k_v| (1 - |k_v|) e^-R  <=  f J / f(centre)  <=  e^((k_u^2 + k_v^2)/2 + R).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.kernels.arithmetic.constants import TILT_STEP
from aomc_sky.kernels.arithmetic.elementary import HALF_PI, arc, exp_level, half_sine2, sin_cos
from aomc_sky.skies.perez.kernels.law import first_factor

_LARGEST_TILT = 0.2
_TINY = 1e-300
_Pair = tuple[np.ndarray, np.ndarray]
_SLACK = 1e-6  # the rounding of the luminance, of float32 directions and of their slope stays inside


def patch_bounds(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Upper bound, lower bound of max(f, 0), and the tilts in u and v, shape (n_ring, n_column, 4): `Component.bounds`.

    Edges of rings and columns (n, 2) in quarter turns, `numbers` as `Component.shared` with b <= 0. Tilts are 0
    where the bounds without them are closer. On patches of 2 degrees of a clear sky the upper bounds are 2 % above the
    means, all together, under an overcast one 0.1 %.
    """
    a, b, c, d, e = numbers[:5]
    low, high = _half_chord2_range(zenith, azimuth, numbers)
    first, last = (c * exp_level(d * arc(half_chord2)) for half_chord2 in (low, high))
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


def _half_chord2_range(zenith: np.ndarray, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest sin^2(gamma/2) over each patch, shape (n_ring, n_column).

    It grows with the azimuth from the sun on every ring, so both lie on the nearest and the farthest meridian. Along
    one of them cos gamma = A cos x + B sin x with A = cos Z, B = sin Z cos(azimuth). The largest value is at an end.
    The smallest is at an end or at the foot of the perpendicular from the sun, where cos^2 gamma = 1 - sin^2 Z
    sin^2(azimuth).
    """
    sun_x, sun_y, sine, cosine = numbers[5], numbers[6], numbers[7], numbers[10]
    start, end = azimuth.T
    first, last = half_sine2(start - sun_y), half_sine2(end - sun_y)
    # sin^2 of half the azimuth from the sun, over each column
    y_low = np.where(np.mod(sun_y - start, 4.0) <= end - start, 0.0, np.minimum(first, last))
    y_high = np.where(np.mod(sun_y + 2.0 - start, 4.0) <= end - start, 1.0, np.maximum(first, last))
    (s0, s1), (c0, c1) = sin_cos(zenith.T)
    near, far = half_sine2(zenith.T - sun_x)
    ends_low = np.minimum(near[:, None] + (s0 * sine)[:, None] * y_low, far[:, None] + (s1 * sine)[:, None] * y_low)
    high = np.maximum(near[:, None] + (s0 * sine)[:, None] * y_high, far[:, None] + (s1 * sine)[:, None] * y_high)
    along = sine * (1.0 - (y_low + y_low))
    across = sine * sine * (4.0 * y_low * (1.0 - y_low))
    foot = 0.5 * across / (1.0 + np.sqrt(np.maximum(1.0 - across, 0.0)))
    has_foot = (along * c0[:, None] >= cosine * s0[:, None]) & (along * c1[:, None] <= cosine * s1[:, None])
    return np.where(has_foot, np.minimum(ends_low, foot), ends_low), np.minimum(high, 1.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Rings:
    """Every ring: sines and cosines of its edges, its middle in mu^2, and slope and curvature of log F1 over u."""

    sine: np.ndarray
    cosine: np.ndarray
    growth: np.ndarray
    mid_sine: np.ndarray
    mid_cosine: np.ndarray
    factor: np.ndarray
    slope: np.ndarray
    #: Bound of the absolute value; infinite where F1 has a zero or the ring touches the horizon.
    curvature: np.ndarray

    @classmethod
    def of(cls, zenith: np.ndarray, a: float, b: float) -> _Rings:
        """First factor 1 + a exp(b / mu), b <= 0, over rings (n_ring, 2). [quarter turns]"""
        sine, cosine = sin_cos(zenith.T)
        growth = sine[1] * sine[1] - sine[0] * sine[0]
        mu2 = 0.5 * (cosine[0] * cosine[0] + cosine[1] * cosine[1])
        mu = np.sqrt(mu2)
        level = exp_level(b / np.maximum(np.stack([cosine[0], mu, cosine[1]]), _TINY))
        factor = 1.0 + a * level
        least = np.maximum(np.minimum(factor[0], factor[2]), 0.0)
        # |b|^k exp(b/mu) / mu^n is largest at mu = |b| / n, or at the end of the ring that is nearest to it
        first, second, third = (
            exp_level(b / mu_n) / mu_n**n
            for n in (3, 5, 6)
            for mu_n in [np.maximum(np.minimum(np.maximum(-b / n, cosine[1]), cosine[0]), _TINY)]
        )
        first, second = -0.5 * b * first, np.maximum(0.25 * b * b * third, -0.75 * b * second)
        share = abs(a) / least
        return cls(
            sine=sine,
            cosine=cosine,
            growth=growth,
            mid_sine=np.sqrt(0.5 * (sine[0] * sine[0] + sine[1] * sine[1])),
            mid_cosine=mu,
            factor=factor[1],
            slope=0.5 * a * b * level[1] / (mu2 * mu) * growth / factor[1],
            curvature=growth * growth * (share * second + (share * first) * (share * first)),
        )


def tilted_bounds(
    zenith: np.ndarray,
    azimuth: np.ndarray,
    numbers: np.ndarray,
    half_chord2: _Pair,
    least: np.ndarray,
) -> np.ndarray:
    """Bounds of f J over each patch and the tilts k_u and k_v, whole multiples of `TILT_STEP` up to 0.2.

    `half_chord2` is the smallest and the largest sin^2(gamma/2) over each patch, `least` a lower bound of the second
    factor. The upper bound is infinite or NaN where the theorem says nothing: at the sun, the zenith, the horizon and
    zeros of f.
    """
    with np.errstate(all="ignore"):
        rings = _Rings.of(zenith, numbers[0], numbers[1])
        value, *slopes = _centre(rings, azimuth, numbers)
        rest = _remainder(rings, azimuth, numbers, half_chord2, least)
        tilts = [
            np.rint(np.maximum(np.minimum(0.5 * s, _LARGEST_TILT), -_LARGEST_TILT) / TILT_STEP) * TILT_STEP
            for s in slopes
        ]
        shrink = np.ones_like(value)
        grow = np.zeros_like(value)
        for tilt, slope in zip(tilts, slopes, strict=True):
            size = np.abs(tilt)
            rest = rest + 0.5 * np.abs(slope - (tilt + tilt))
            shrink = shrink * (exp_level(size) * (1.0 - size))
            grow = grow + 0.5 * (tilt * tilt)
        upper = np.where(value > 0.0, value * exp_level(grow + rest), np.inf)
        lower = value * (shrink * exp_level(-rest))
        return np.stack([upper, lower, *tilts], axis=-1)


def _centre(rings: _Rings, azimuth: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Luminance at the centre of each patch, and the slopes of its logarithm over u and v."""
    c, d, e, sun, sun_sine, sun_cosine = numbers[2], numbers[3], numbers[4], numbers[6], numbers[7], numbers[10]
    width = (azimuth[:, 1] - azimuth[:, 0]) * HALF_PI
    sine, cosine = sin_cos(0.5 * (azimuth[:, 0] + azimuth[:, 1]) - sun)
    across, up = rings.mid_sine * sun_sine, rings.mid_cosine * sun_cosine
    q = across[:, None] * cosine + up[:, None]
    q = np.maximum(np.minimum(q, 1.0), -1.0)
    away = np.sqrt(1.0 - q * q)
    aureole = c * exp_level(d * arc(0.5 * (1.0 - q)))
    factor = 1.0 + aureole + e * (q * q)
    # the derivative of log F2 over q; that of gamma is -1 / sin(gamma)
    slope = (2.0 * e * q - d * aureole / away) / factor
    q_u = 0.5 * rings.growth[:, None] * ((sun_sine / rings.mid_sine)[:, None] * cosine)
    q_u -= (0.5 * rings.growth * sun_cosine / rings.mid_cosine)[:, None]
    q_v = -across[:, None] * (sine * width)
    return rings.factor[:, None] * factor, rings.slope[:, None] + slope * q_u, slope * q_v


def _remainder(
    rings: _Rings,
    azimuth: np.ndarray,
    numbers: np.ndarray,
    half_chord2: _Pair,
    least: np.ndarray,
) -> np.ndarray:
    """R: half the largest second derivative of log f along a line from the centre of a patch to its rim.

    For p(gamma) = log F2 = log(1 + c exp(d gamma) + e cos^2 gamma) it is p'' r^2 + p' (cot(gamma) t^2 + k). The move
    across the sky has the parts r towards the sun and t past it; k is the bend of the line on the sphere. The argument
    `least` is a lower bound of F2.
    """
    (near, far), (high_mu, low_mu), growth = rings.sine, rings.cosine, rings.growth
    both = np.minimum(near * high_mu, far * low_mu)  # sine x cosine has no minimum inside
    width = (azimuth[:, 1] - azimuth[:, 0]) * HALF_PI
    along = 0.5 * growth / both
    move2 = 0.25 * ((along * along)[:, None] + (far * far)[:, None] * (width * width))
    bend = 0.25 * ((along * along / both)[:, None] + (growth / near)[:, None] * width + 0.5 * (width * width))
    c, d, e = numbers[2:5]
    (low, high), least = half_chord2, np.maximum(least, 0.0)
    # bounds of |p'| and |p''| over each patch
    ends = [c * d * exp_level(d * arc(h)) for h in half_chord2]
    slope = (np.maximum(np.abs(ends[0]), np.abs(ends[1])) + abs(e)) / least
    second = np.stack(ends) * d
    up = np.maximum(np.maximum(second[0], second[1]) + 2.0 * abs(e), 0.0)
    down = np.minimum(np.minimum(second[0], second[1]) - 2.0 * abs(e), 0.0)
    curvature = np.maximum(up / least, slope * slope - down / least)
    most = np.maximum(np.abs(1.0 - (low + low)), np.abs(1.0 - (high + high)))
    away = 2.0 * np.sqrt(np.minimum(low * (1.0 - low), high * (1.0 - high)))
    curved = np.maximum(curvature, slope * (most / away)) * move2 + slope * bend
    return 0.5 * curved + 0.125 * rings.curvature[:, None]
