"""The all-weather sky of Perez, Seals and Michalsky (1993) [perez1993]: coefficients and luminance.

The equation numbers are the paper's. All functions broadcast over directions, over skies (time
series of epsilon, Delta and the sun) and over both. NaN comes out only where NaN went in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.perez_inputs import (
    checked_sun,
    diffuse_from_global,
    epsilon_bin,
    relative_air_mass,
    sky_brightness,
    sky_clearness,
)
from aomc_sky.skies.perez_integral import horizontal_integral
from aomc_sky.skies.perez_table import TEN_THOUSANDTHS

__all__ = [
    "coefficients",
    "diffuse_from_global",
    "epsilon_bin",
    "horizontal_integral",
    "limited",
    "luminance",
    "relative_air_mass",
    "relative_radiance",
    "relative_radiance_log",
    "sky_brightness",
    "sky_clearness",
    "zenith_luminance",
]

LIMITS = ("radiance", "paper")

EPSILON_LIMITS = (1.0, 12.01)
DELTA_LIMITS = (0.01, 0.6)
DELTA_FLOOR = 0.2
"""Smallest Delta where 1.065 <= epsilon < 2.8, under the limits "radiance"."""

_FLOOR_BINS = (1, 4)
_SPLIT = 134217729.0  # 2^27 + 1: cuts a float64 into two halves whose products are exact


def limited(epsilon: ArrayLike, delta: ArrayLike, *, limits: str = "radiance") -> tuple[np.ndarray, np.ndarray]:
    """Sky clearness and brightness after the limits that the coefficients are taken at.

    Parameters
    ----------
    epsilon : array_like
        Sky clearness. [-]
    delta : array_like
        Sky brightness. [0 or more]
    limits : {"radiance", "paper"}
        "radiance" is the published practice: epsilon to [1, 12.01], Delta to [0.01, 0.6], and Delta
        at least 0.2 where 1.065 <= epsilon < 2.8. "paper" changes nothing.

    Returns
    -------
    epsilon, delta : ndarray, float64
        Broadcast of the arguments.

    Raises
    ------
    SceneError
        Delta is negative or infinite.
    UsageError
        `limits` is neither of the two.
    """
    if limits not in LIMITS:
        raise UsageError(f"limits must be one of {', '.join(map(repr, LIMITS))}, got {limits!r}")
    given = (np.asarray(epsilon, dtype=np.float64), np.asarray(delta, dtype=np.float64))
    clearness, brightness = np.broadcast_arrays(*given)
    if np.any((brightness < 0) | np.isinf(brightness)):
        raise SceneError(
            f"the sky brightness Delta must be finite and not negative, got {np.nanmin(brightness):g} to "
            f"{np.nanmax(brightness):g}; set the small negative offset of a pyranometer to 0"
        )
    if limits == "paper":
        return clearness, brightness
    clearness = np.clip(clearness, *EPSILON_LIMITS)
    brightness = np.clip(brightness, *DELTA_LIMITS)
    row = epsilon_bin(np.where(np.isnan(clearness), 1.0, clearness))
    floor = np.where((row >= _FLOOR_BINS[0]) & (row <= _FLOOR_BINS[1]), DELTA_FLOOR, 0.0)
    return clearness, np.maximum(brightness, floor)


def coefficients(
    epsilon: ArrayLike, delta: ArrayLike, sun_zenith_rad: ArrayLike, *, limits: str = "radiance"
) -> np.ndarray:
    """Coefficients a to e of a sky, eqs. (6) to (8) with Table 1.

    Parameters
    ----------
    epsilon : array_like
        Sky clearness, eq. (4). [-]
    delta : array_like
        Sky brightness, eq. (5). [0 or more]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    limits : {"radiance", "paper"}
        See `limited`.

    Returns
    -------
    ndarray, float64, shape (..., 5)
        a, b, c, d, e; the leading axes are the broadcast of the arguments. b may be positive.

    Raises
    ------
    SceneError
        An input is outside its range, or so large that a coefficient overflows.

    Notes
    -----
    Accuracy: a, b and e within 1 ulp for the given numbers; c and d within 1e-15 of the sum of their
    terms' magnitudes. The sums are compensated and Table 1 is exact, so that terms may cancel. The
    sky jumps between the bins of epsilon, by up to 0.25 in total variation: the model is so.
    """
    clearness, brightness = limited(epsilon, delta, limits=limits)
    clearness, brightness, zenith = np.broadcast_arrays(clearness, brightness, checked_sun(sun_zenith_rad))
    undefined = np.isnan(clearness) | np.isnan(brightness) | np.isnan(zenith)
    row = epsilon_bin(np.where(undefined, 1.0, clearness))
    terms = TEN_THOUSANDTHS[row]
    with np.errstate(over="ignore", invalid="ignore"):
        values = _linear(terms, zenith[..., None], brightness[..., None])
        overcast = row == 0
        if np.any(overcast):
            c, d = _overcast(terms[overcast], zenith[overcast], brightness[overcast])
            values[overcast, 2] = c
            values[overcast, 3] = d
    values[undefined] = np.nan
    if not np.all(np.isfinite(values) | undefined[..., None]):
        raise SceneError(
            f"a coefficient overflows for a sky brightness Delta up to {np.nanmax(brightness):g}; "
            'skies have Delta below 0.6, where limits="radiance" puts it'
        )
    return values


def _linear(terms: np.ndarray, zenith: np.ndarray, brightness: np.ndarray) -> np.ndarray:
    """Eq. (6) with compensated products and sums; `terms` in units of 1e-4."""
    t1, t2, t3, t4 = np.moveaxis(terms, -1, 0)
    plain, plain_rest = _product(t2, zenith)
    slope, slope_rest = _product(t4, zenith)
    slope, rest = _sum(t3, slope)
    scaled, scaled_rest = _product(slope, brightness)
    scaled_rest = scaled_rest + (rest + slope_rest) * brightness
    total, rest_1 = _sum(t1, plain)
    total, rest_2 = _sum(total, scaled)
    return (total + (rest_1 + rest_2 + plain_rest + scaled_rest)) / 1e4


def _overcast(terms: np.ndarray, zenith: np.ndarray, brightness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C and d of the first bin, eqs. (7) and (8); their exponentials less 1 do not cancel."""
    c1, c2, c3, c4 = np.moveaxis(terms[..., 2, :], -1, 0)
    d1, d2, d3, d4 = np.moveaxis(terms[..., 3, :], -1, 0)
    c = np.expm1((brightness * (c1 + c2 * zenith) / 1e4) ** (c3 / 1e4)) + (1e4 - c4) / 1e4
    d = -np.expm1(brightness * (d1 + d2 * zenith) / 1e4) + ((d3 - 1e4) + brightness * d4) / 1e4
    return c, d


def _sum(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X + y and what its rounding left out."""
    total = x + y
    shadow = total - x
    return total, (x - (total - shadow)) + (y - shadow)


def _product(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X * y and what its rounding left out."""
    product = x * y
    cut_x, cut_y = _SPLIT * x, _SPLIT * y
    high_x, high_y = cut_x - (cut_x - x), cut_y - (cut_y - y)
    low_x, low_y = x - high_x, y - high_y
    return product, low_x * low_y - (((product - high_x * high_y) - low_x * high_y) - high_x * low_y)


def _angle_to_sun(zenith: np.ndarray, azimuth: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """Angle gamma to the sun from its half angle: right to the last bits at the sun and opposite it."""
    product = np.sin(zenith) * np.sin(sun)
    half_sine2 = np.sin((zenith - sun) / 2) ** 2 + product * np.sin(azimuth / 2) ** 2
    half_cosine2 = np.cos((zenith + sun) / 2) ** 2 + product * np.cos(azimuth / 2) ** 2
    return 2.0 * np.arctan2(np.sqrt(half_sine2), np.sqrt(half_cosine2))


def _factors(
    sky_zenith_rad: ArrayLike, azimuth_from_sun_rad: ArrayLike, sun_zenith_rad: ArrayLike, coefficients: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Exponents b/mu and d gamma, and a and the rest of each factor: F1 = 1 + a e^x, F2 = r + c e^y."""
    a, b, c, d, e = np.moveaxis(np.asarray(coefficients, dtype=np.float64), -1, 0)
    zenith = np.asarray(sky_zenith_rad, dtype=np.float64)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError("the zenith angle of a sky element must lie in 0 to pi/2 rad")
    azimuth = np.asarray(azimuth_from_sun_rad, dtype=np.float64)
    gamma = _angle_to_sun(zenith, azimuth, checked_sun(sun_zenith_rad))
    mu = np.where(zenith == np.pi / 2, 0.0, np.cos(zenith))
    # at the horizon the limits of b / mu: -inf, 0 where b is 0, inf
    far = np.where(b == 0, 0.0, np.where(b < 0, -np.inf, np.where(b > 0, np.inf, np.nan)))
    shape = np.broadcast_shapes(mu.shape, b.shape)
    exponent = np.broadcast_to(far, shape).copy()
    np.divide(b, mu, out=exponent, where=np.broadcast_to(mu > 0, shape))
    return a, exponent, c, d * gamma, 1.0 + e * np.cos(gamma) ** 2


def relative_radiance(
    sky_zenith_rad: ArrayLike, azimuth_from_sun_rad: ArrayLike, sun_zenith_rad: ArrayLike, coefficients: ArrayLike
) -> np.ndarray:
    """Relative radiance f of eq. (1): [1 + a exp(b / cos xi)] [1 + c exp(d gamma) + e cos^2 gamma].

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

    Returns
    -------
    ndarray, float64
        Not normalised and not clipped: some coefficients give negative values. At the horizon the
        limit of the first factor is 1 for b < 0, 1 + a for b = 0 and infinite for b > 0. Values
        beyond the largest float64 are infinite; `relative_radiance_log` has their logarithm.

    Raises
    ------
    SceneError
        An angle is outside its range.

    Notes
    -----
    Accuracy: 1e-15 (1 + |b| / cos^2 xi) of the product of the factors' sums of magnitudes, also beside
    the sun: gamma comes from the half angle, never from the arc cosine of a dot product.
    """
    a, x, c, y, rest = _factors(sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients)
    with np.errstate(over="ignore", invalid="ignore"):
        value = (1.0 + a * np.exp(x)) * (rest + c * np.exp(y))
        if np.all(np.isfinite(value)):
            return value
        sign, log = _sign_and_log(a, x, c, y, rest)
        return np.where(np.isfinite(value), value, sign * np.exp(log))


def relative_radiance_log(
    sky_zenith_rad: ArrayLike, azimuth_from_sun_rad: ArrayLike, sun_zenith_rad: ArrayLike, coefficients: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Sign and natural logarithm of the magnitude of f, for b > 0, where f itself may overflow.

    Parameters
    ----------
    sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients : array_like
        As for `relative_radiance`.

    Returns
    -------
    sign, log_magnitude : ndarray, float64
        -1, 0 or 1, and a number that is -inf where f = 0 and inf only at the horizon itself.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return _sign_and_log(*_factors(sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients))


def _sign_and_log(
    a: np.ndarray, x: np.ndarray, c: np.ndarray, y: np.ndarray, rest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    sign_1, log_1 = _factor_log(a, x, np.ones(()))
    sign_2, log_2 = _factor_log(c, y, rest)
    sign = sign_1 * sign_2
    return sign, np.where(sign == 0, -np.inf, log_1 + log_2)


def _factor_log(scale: np.ndarray, exponent: np.ndarray, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sign and logarithm of rest + scale exp(exponent); `rest` is of order 1."""
    with np.errstate(divide="ignore"):
        value = np.where(scale == 0, rest, rest + scale * np.exp(exponent))
        large = (exponent > 600.0) & (scale != 0)
        log = np.where(large, np.log(np.abs(scale)) + exponent, np.log(np.abs(value)))
    return np.where(large, np.sign(scale), np.sign(value)), log


def zenith_luminance(
    coefficients: ArrayLike, sun_zenith_rad: ArrayLike, *, diffuse_illuminance: ArrayLike
) -> np.ndarray:
    """Luminance overhead of a sky whose horizontal diffuse illuminance is known, eq. (3) at the zenith.

    The paper takes Lvz from measurement or from another paper's model, so none is built in.

    Parameters
    ----------
    coefficients : array_like, shape (..., 5)
        a, b, c, d, e with b <= 0.
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    diffuse_illuminance : array_like
        Evd. [lx; W m-2 gives a radiance]

    Returns
    -------
    ndarray, float64
        Lvz. [cd m-2, or W m-2 sr-1]
    """
    return luminance(0.0, 0.0, sun_zenith_rad, coefficients, diffuse_illuminance=diffuse_illuminance)


def luminance(
    sky_zenith_rad: ArrayLike,
    azimuth_from_sun_rad: ArrayLike,
    sun_zenith_rad: ArrayLike,
    coefficients: ArrayLike,
    *,
    zenith_luminance: ArrayLike | None = None,
    diffuse_illuminance: ArrayLike | None = None,
) -> np.ndarray:
    """Luminance of a sky element from the zenith luminance, eq. (2), or the diffuse illuminance, eq. (3).

    Parameters
    ----------
    sky_zenith_rad, azimuth_from_sun_rad, sun_zenith_rad, coefficients : array_like
        As for `relative_radiance`.
    zenith_luminance : array_like, optional
        Lvz; one of the two must be given. [cd m-2]
    diffuse_illuminance : array_like, optional
        Evd. [lx; W m-2 gives a radiance in W m-2 sr-1]

    Returns
    -------
    ndarray, float64
        Lv, not clipped. [cd m-2]

    Raises
    ------
    UsageError
        Neither or both of the two are given.
    SceneError
        f overhead (eq. 2) or its integral (eq. 3) is not positive, so that nothing can be scaled by it.
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
        raise SceneError("the model's sky is negative overhead or as a whole and cannot be scaled; see PerezSky")
    return relative * (np.asarray(known, dtype=np.float64) / reference)
