"""The functions of the all-weather sky of Perez, Seals and Michalsky (1993) [perez1993], with its equation numbers.

All broadcast over directions, over skies (time series of epsilon, Delta and the sun) and over both, and return float64.
NaN comes out only where NaN went in.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError, floats
from aomc_sky.skies.perez.coefficients import (
    coefficients,
    epsilon_bin,
    limited,
    relative_air_mass,
    sky_brightness,
    sky_clearness,
)
from aomc_sky.skies.perez.irradiances import checked_sun

__all__ = [
    "coefficients",
    "epsilon_bin",
    "horizontal_integral",
    "limited",
    "luminance",
    "relative_air_mass",
    "relative_radiance",
    "sky_brightness",
    "sky_clearness",
]

_RULE_GAMMA = (32, 3.0)
_RULE_PSI = (36, 3.1)
_SKIES_AT_ONCE = 32


def relative_radiance(
    sky_zenith_rad: ArrayLike, azimuth_from_sun_rad: ArrayLike, sun_zenith_rad: ArrayLike, coefficients: ArrayLike
) -> np.ndarray:
    """Relative radiance f of eq. (1): [1 + a exp(b / cos xi)] [1 + c exp(d gamma) + e cos^2 gamma].

    It is neither normalised nor clipped: some coefficients give negative values. At the horizon the limit of the first
    factor is 1 for b < 0, 1 + a for b = 0 and infinite for b > 0. Values beyond the largest float64 are infinite.
    Accuracy: 2e-15 (1 + |b| / cos^2 xi) of the product of the factors' sums of magnitudes, also beside the sun.
    SceneError: an angle is outside its range.

    Parameters
    ----------
    sky_zenith_rad : array_like
        Zenith angle xi of the sky element. [rad, 0 to pi/2]
    azimuth_from_sun_rad : array_like
        Azimuth of the sky element less that of the sun; the sign does not matter. [rad]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    coefficients : array_like, shape (..., 5)
        a, b, c, d, e; the leading axes broadcast with the angles.

    Examples
    --------
    >>> coefficients = sky.perez.coefficients(5.5, 0.12, np.radians(48.0))
    >>> towards_the_sun, opposite = sky.perez.relative_radiance(
    ...     np.radians(48.0), [0.0, np.pi], np.radians(48.0), coefficients
    ... )
    >>> print(f"{towards_the_sun / opposite:.2f}")
    15.91
    """
    a, b, c, d, e = np.moveaxis(_five(coefficients), -1, 0)
    zenith = floats("sky_zenith_rad", sky_zenith_rad)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError("the zenith angle of a sky element must be from 0 to pi/2 rad")
    azimuth = floats("azimuth_from_sun_rad", azimuth_from_sun_rad)
    if np.any(np.isinf(azimuth)):
        raise SceneError("the azimuth of a sky element must be finite")
    sun = checked_sun(sun_zenith_rad)
    product = np.sin(zenith) * np.sin(sun)
    half_sine2 = np.sin((zenith - sun) / 2) ** 2 + product * np.sin(azimuth / 2) ** 2
    half_cosine2 = np.cos((zenith + sun) / 2) ** 2 + product * np.cos(azimuth / 2) ** 2
    # the angle to the sun is right to the last bits at the sun and opposite it
    gamma = 2.0 * np.arctan2(np.sqrt(half_sine2), np.sqrt(half_cosine2))
    mu = np.where(zenith == np.pi / 2, 0.0, np.cos(zenith))
    # at the horizon the limits of b / mu: -inf, 0 where b is 0, inf
    far = np.where(b == 0, 0.0, np.where(b < 0, -np.inf, np.where(b > 0, np.inf, np.nan)))
    shape = np.broadcast_shapes(mu.shape, b.shape)
    exponent = np.broadcast_to(far, shape).copy()
    np.divide(b, mu, out=exponent, where=np.broadcast_to(mu > 0, shape))
    with np.errstate(over="ignore", invalid="ignore"):
        second = 1.0 + e * np.cos(gamma) ** 2 + _product(c, np.exp(d * gamma))
        return _product(1.0 + _product(a, np.exp(exponent)), second)


def _five(coefficients: ArrayLike) -> np.ndarray:
    """Coefficients (..., 5) as float64; a SceneError for another number of them."""
    values = floats("coefficients", coefficients)
    if values.shape[-1:] != (5,):
        raise SceneError(f"coefficients must be the five numbers a, b, c, d, e, got shape {values.shape}")
    return values


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product in which 0 times infinity is 0."""
    is_zero = ((a == 0) & np.isinf(b)) | ((b == 0) & np.isinf(a))
    value: np.ndarray = np.where(is_zero, 0.0, a * b)[()]
    return value


def luminance(
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    sun_zenith_rad: ArrayLike,
    coefficients: ArrayLike,
    *,
    zenith_luminance: ArrayLike | None = None,
    diffuse_illuminance: ArrayLike | None = None,
) -> np.ndarray:
    """Luminance of a sky element from the zenith luminance, eq. (2), or the diffuse illuminance, eq. (3); not clipped.

    SceneError: f overhead (eq. 2) or its integral (eq. 3) is not positive, so that nothing can be scaled by it.

    Parameters
    ----------
    sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients : array_like
        As for `relative_radiance`.
    zenith_luminance : array_like, optional
        Lvz; one of the two must be given. [cd m-2]
    diffuse_illuminance : array_like, optional
        Evd. [lx; W m-2 gives a radiance in W m-2 sr-1]

    Examples
    --------
    >>> coefficients = sky.perez.coefficients(5.5, 0.12, np.radians(48.0))
    >>> overhead = sky.perez.luminance(
    ...     0.0, 0.0, np.radians(48.0), coefficients, diffuse_illuminance=12_000.0
    ... )
    >>> print(overhead.round(1))
    2085.9
    """
    relative = relative_radiance(sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients)
    if (zenith_luminance is None) == (diffuse_illuminance is None):
        raise UsageError("give either zenith_luminance or diffuse_illuminance")
    if zenith_luminance is not None:
        known, reference = zenith_luminance, relative_radiance(0.0, 0.0, sun_zenith_rad, coefficients)
    else:
        assert diffuse_illuminance is not None
        known, reference = diffuse_illuminance, horizontal_integral(coefficients, sun_zenith_rad)
    if np.any(reference <= 0):
        raise SceneError("the model's sky is negative overhead or as a whole and cannot be scaled", "see PerezSky")
    return relative * (floats("the luminance", known) / reference)


def horizontal_integral(coefficients: ArrayLike, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Integral of f cos xi over the hemisphere, the denominator of eq. (3), without a clip of f. [sr]

    Accuracy: 1e-10 of the sum of the magnitudes of the three terms, for d from -200 on. SceneError: b > 0 with a not 0,
    where the integral diverges at the horizon, or the sun is below the horizon.

    Parameters
    ----------
    coefficients : array_like, shape (..., 5)
        a, b, c, d, e with b <= 0; the leading axes broadcast with the sun.
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]

    Examples
    --------
    >>> coefficients = sky.perez.coefficients(5.5, 0.12, np.radians(48.0))
    >>> print(sky.perez.horizontal_integral(coefficients, np.radians(48.0)).round(4))
    2.2812
    """
    values = _five(coefficients)
    zenith = checked_sun(sun_zenith_rad)
    shape = np.broadcast_shapes(values.shape[:-1], zenith.shape)
    values = np.broadcast_to(values, (*shape, 5)).reshape(-1, 5)
    suns = np.broadcast_to(zenith, shape).ravel()
    if np.any((values[:, 1] > 0) & (values[:, 0] != 0)):
        raise SceneError("the integral over the sky diverges for b > 0", "take np.minimum(b, 0), as PerezSky does")
    total = np.empty(len(values))
    for start in range(0, len(values), _SKIES_AT_ONCE):
        part = slice(start, start + _SKIES_AT_ONCE)
        total[part] = _smooth_part(values[part], suns[part]) + _aureole_part(values[part], suns[part])
    return total.reshape(shape)


def _smooth_part(values: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """The integral with F2 = 1 + e cos^2 gamma: E3 and E5 are those of mu exp(b/mu) and mu^3 exp(b/mu)."""
    from scipy.special import expn

    a, b, _, _, e = values.T
    depth = np.where(a == 0, 0.0, -b)
    cube, fifth = 0.5 + a * expn(3, depth), 0.25 + a * expn(5, depth)
    half_sine2 = np.sin(sun) ** 2 / 2
    return 2 * np.pi * (cube * (1 + e * half_sine2) + fifth * e * (np.cos(sun) ** 2 - half_sine2))


def _aureole_part(values: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """The integral with F2 = c exp(d gamma), over whole circles about the sun and then over cut ones.

    There is a cusp at the sun and a boundary layer at the horizon, as thin as |b|. In coordinates about the sun, split
    at gamma = pi/2 - Z, both are edges of the rectangle. Double-exponential quadrature resolves edges at every scale.
    """
    near, far, weight = _rule(*_RULE_GAMMA)
    near, far = near[:, None], far[:, None]
    along, left, weight_psi = _rule(*_RULE_PSI)
    half = np.sin(sun)[:, None, None]
    uncut = (np.pi / 2 - sun)[:, None, None]
    gamma = uncut * near
    lowest = np.sin(uncut * far)  # mu of the circle's lowest point
    mu = lowest + 2 * np.sin(gamma) * half * np.sin(np.pi / 2 * left) ** 2
    total = _circles(values, gamma, mu) @ weight_psi @ weight * np.pi * uncut[:, 0, 0]
    cut = 2 * sun[:, None, None]
    below, above = cut * near, cut * far
    gamma = uncut + below
    # a cut circle meets the horizon at psi = +-end; half angles keep the differences from cancelling
    end = 2 * np.arctan2(np.sqrt(np.sin(above)), np.sqrt(np.sin(below)))
    mu = 2 * np.sin(gamma) * half * np.sin(end * (1 + along) / 2) * np.sin(end * left / 2)
    total += (_circles(values, gamma, mu) * end) @ weight_psi @ weight * cut[:, 0, 0]
    return 2 * values[:, 2] * total


def _circles(values: np.ndarray, gamma: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """exp(d gamma) sin gamma mu F1, shape (sky, gamma, psi)."""
    a, b, _, d, _ = (v[:, None, None] for v in values.T)
    # beyond e^-60 nothing is left beside 1, and tiny exponentials are slow
    depth = np.maximum(b / np.maximum(mu, 1e-300), -60.0)
    return (np.exp(d * gamma) * np.sin(gamma)) * (mu * (1 + a * np.exp(depth)))


@cache
def _rule(steps: int, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Double-exponential rule on (0, 1): distance from 0, distance from 1, weights [takahasi1974]."""
    t = np.linspace(-reach, reach, 2 * steps + 1)
    rise = np.pi * np.sinh(t)
    from_zero, from_one = 1.0 / (1.0 + np.exp(-rise)), 1.0 / (1.0 + np.exp(rise))
    weight = np.pi * np.cosh(t) * from_zero * from_one * (t[1] - t[0])
    return from_zero, from_one, weight
