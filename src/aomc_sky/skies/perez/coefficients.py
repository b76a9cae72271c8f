"""Irradiances and the sun become clearness, brightness and the coefficients a to e of the Perez sky, eqs. (4) to (8).

Exponential and power use + - x / alone. Those of numpy and libm differ between versions and processors in the last bit
of a few percent of their values. The coefficients and the hash of a run would differ with them.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, floats, require_one_of
from aomc_sky.kernels.arithmetic.elementary import LN2_HI, LN2_LO, exp_level
from aomc_sky.kernels.arithmetic.error_free import two_product, two_sum
from aomc_sky.skies.perez.irradiances import (
    EXTRATERRESTRIAL_NORMAL,
    checked_extraterrestrial,
    checked_irradiance,
    checked_sun,
)
from aomc_sky.skies.perez.table import EPSILON_EDGES, TEN_THOUSANDTHS

AirMassWord = Literal["kasten-young-1989", "kasten-1966"]
LimitsWord = Literal["radiance", "paper"]

#: Offset, reach and 1e4 power of cos Z + offset (reach - Z in degrees)^-power.
_AIR_MASS = {"kasten-young-1989": (0.50572, 96.07995, 16364.0), "kasten-1966": (0.15, 93.885, 12530.0)}
_KAPPA = 1.041

LIMITS = get_args(LimitsWord)
EPSILON_LIMITS = (1.0, 12.01)
DELTA_LIMITS = (0.01, 0.6)
DELTA_FLOOR = 0.2  #: Smallest Delta where 1.065 <= epsilon < 2.8, under the limits "radiance".
_FLOOR_BINS = (1, 4)

_LN2_REST = 1.1612227229362532e-26  # ln 2 less LN2_HI and LN2_LO


def sky_clearness(dni: ArrayLike, dhi: ArrayLike, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Sky clearness epsilon, eq. (4), with 1.041 Z^3 and Z in radians. [1 to inf]

    Without diffuse light it is infinite, without any light 1. Accuracy: 5 ulp, for 1 + (dni/dhi) / (1 + 1.041 Z^3)
    keeps a tiny dni.

    Parameters
    ----------
    dni, dhi : array_like
        Direct normal and diffuse horizontal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]

    Examples
    --------
    >>> print(sky.perez.sky_clearness(850.0, 95.0, np.radians(32.4)).round(2))
    8.53
    """
    direct, diffuse = np.broadcast_arrays(checked_irradiance("dni", dni), checked_irradiance("dhi", dhi))
    zenith = checked_sun(sun_zenith_rad)
    ratio = np.where(np.isnan(direct), np.nan, np.where(direct > 0, np.inf, 0.0))
    with np.errstate(over="ignore"):
        ratio = np.divide(direct, diffuse, out=ratio, where=diffuse != 0)
    return 1.0 + ratio / (1.0 + _KAPPA * zenith * zenith * zenith)


def beam_ratio(epsilon: float, sun_zenith_rad: float) -> float:
    """Direct normal over diffuse horizontal irradiance of a sky clearness: eq. (4) the other way."""
    return (epsilon - 1.0) / (float(sky_clearness(1.0, 1.0, sun_zenith_rad)) - 1.0)


def relative_air_mass(sun_zenith_rad: ArrayLike, *, formula: AirMassWord = "kasten-young-1989") -> np.ndarray:
    """Relative optical air mass at sea level: 1 overhead, 37.92 (36.51) at the horizon.

    Parameters
    ----------
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to below 96.08 or 93.885 degrees, where the formula ends]
    formula : {"kasten-young-1989", "kasten-1966"}
        The paper takes the first [kasten1989]. gendaylit takes the second, 0.15 (93.885 - Z)^-1.253.

    Examples
    --------
    >>> print(sky.perez.relative_air_mass(np.radians([0.0, 60.0, 90.0])).round(3))
    [ 1.     1.994 37.92 ]
    """
    require_one_of(_AIR_MASS, formula, "air_mass")
    offset, reach, exponent = _AIR_MASS[formula]
    zenith = floats("sun_zenith_rad", sun_zenith_rad)
    with np.errstate(over="ignore"):
        degrees = np.rad2deg(zenith)
    if np.any((degrees < 0) | (degrees >= reach)):
        raise SceneError(
            f"the air mass formula {formula} is for zenith angles of the sun from 0 to below {reach} degrees"
        )
    return 1.0 / (sin_cos_deg(degrees)[1] + offset * power(reach - degrees, np.full_like(degrees, -exponent)))


def sky_brightness(
    dhi: ArrayLike,
    sun_zenith_rad: ArrayLike,
    *,
    extraterrestrial_normal: ArrayLike = EXTRATERRESTRIAL_NORMAL,
    air_mass: AirMassWord = "kasten-young-1989",
) -> np.ndarray:
    """Sky brightness Delta, eq. (5): air mass x dhi / extraterrestrial_normal. [0 or more]

    Parameters
    ----------
    dhi : array_like
        Diffuse horizontal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    extraterrestrial_normal : array_like
        Irradiance on a plane that faces the sun outside the atmosphere, on that day. [W m-2]
    air_mass : {"kasten-young-1989", "kasten-1966"}
        Formula of the air mass.

    Examples
    --------
    >>> print(sky.perez.sky_brightness(95.0, np.radians(32.4)).round(5))
    0.08261
    """
    extraterrestrial = checked_extraterrestrial(extraterrestrial_normal)
    mass = relative_air_mass(checked_sun(sun_zenith_rad), formula=air_mass)
    with np.errstate(over="ignore"):
        brightness = mass * checked_irradiance("dhi", dhi) / extraterrestrial
    if np.any(np.isinf(brightness)):
        raise SceneError("the sky brightness Delta overflows: dhi and extraterrestrial_normal must be in W m-2")
    return brightness


def epsilon_bin(epsilon: ArrayLike) -> np.ndarray:
    """Row of Table 1 for a sky clearness, 0 to 7. A lower edge belongs to its bin, values below 1 to the first.

    Examples
    --------
    >>> print(sky.perez.epsilon_bin([1.0, 1.065, 7.0]))
    [0 1 7]
    """
    clearness = floats("epsilon", epsilon)
    if np.any(np.isnan(clearness)):
        raise SceneError("a sky clearness that is not a number has no bin")
    return np.searchsorted(np.array(EPSILON_EDGES[1:]), clearness, side="right")


def limited(epsilon: ArrayLike, delta: ArrayLike, *, limits: LimitsWord = "radiance") -> tuple[np.ndarray, np.ndarray]:
    """Sky clearness and brightness after the limits that the coefficients are taken at.

    SceneError: Delta is negative or infinite.

    Parameters
    ----------
    epsilon, delta : array_like
        Sky clearness and brightness. [-]
    limits : {"radiance", "paper"}
        "radiance" is the published practice: epsilon to [1, 12.01], Delta to [0.01, 0.6], and Delta at least 0.2 where
        1.065 <= epsilon < 2.8. "paper" changes nothing.

    Examples
    --------
    >>> epsilon, delta = sky.perez.limited(20.0, 0.005)
    >>> print(epsilon, delta)
    12.01 0.01
    """
    require_one_of(LIMITS, limits, "limits")
    clearness, brightness = np.broadcast_arrays(floats("epsilon", epsilon), floats("delta", delta))
    if np.any((brightness < 0) | np.isinf(brightness)):
        raise SceneError(
            f"the sky brightness Delta must be finite and not negative, got {np.nanmin(brightness):g} to "
            f"{np.nanmax(brightness):g}",
            "set the small negative offset of a pyranometer to 0",
        )
    if limits == "paper":
        return clearness, brightness
    clearness = np.clip(clearness, *EPSILON_LIMITS)
    brightness = np.clip(brightness, *DELTA_LIMITS)
    row = epsilon_bin(np.where(np.isnan(clearness), 1.0, clearness))
    floor = np.where((row >= _FLOOR_BINS[0]) & (row <= _FLOOR_BINS[1]), DELTA_FLOOR, 0.0)
    return clearness, np.maximum(brightness, floor)


def coefficients(
    epsilon: ArrayLike, delta: ArrayLike, sun_zenith_rad: ArrayLike, *, limits: LimitsWord = "radiance"
) -> np.ndarray:
    """Coefficients a to e of a sky, eqs. (6) to (8) with Table 1, shape (..., 5); b may be positive.

    Accuracy: a, b and e within 1.5 ulp for the given numbers; c and d for Delta up to 0.6 within 1e-15 of the sum of
    their terms' magnitudes.
    The model jumps between the bins of epsilon, by up to 0.25 in total variation. SceneError: an input is outside its
    range, or so large that a coefficient overflows.

    Parameters
    ----------
    epsilon, delta : array_like
        Sky clearness and brightness, eqs. (4) and (5). [-, 0 or more]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    limits : {"radiance", "paper"}
        See `limited`.

    Examples
    --------
    >>> print(sky.perez.coefficients(5.5, 0.12, np.radians(48.0)).round(4))
    [-0.9735 -0.2187 14.7685 -3.9062  0.5826]
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
            # c and d of the first bin, eqs. (7) and (8); their exponentials less 1 do not cancel
            (c1, c2, c3, c4), (d1, d2, d3, d4) = np.moveaxis(terms[overcast, 2:4], 0, -1)
            sun, delta = zenith[overcast], brightness[overcast]
            exponents = power(delta * (c1 + c2 * sun) / 1e4, c3), delta * (d1 + d2 * sun) / 1e4
            grown_c, grown_d = expm1(np.stack(exponents))
            values[overcast, 2] = grown_c + (1e4 - c4) / 1e4
            values[overcast, 3] = -grown_d + ((d3 - 1e4) + delta * d4) / 1e4
    values[undefined] = np.nan
    if not np.all(np.isfinite(values) | undefined[..., None]):
        raise SceneError(
            f"a coefficient overflows for a sky brightness Delta up to {np.nanmax(brightness):g}; "
            'skies have Delta below 0.6, where limits="radiance" puts it'
        )
    return values


def _linear(terms: np.ndarray, zenith: np.ndarray, brightness: np.ndarray) -> np.ndarray:
    """Eq. (6) with compensated products and sums; `terms` in units of 1e-4."""
    t1, t2, t3, t4 = (terms[..., k] for k in range(4))
    plain, plain_rest = two_product(t2, zenith)
    slope, slope_rest = two_product(t4, zenith)
    slope, rest = two_sum(t3, slope)
    scaled, scaled_rest = two_product(slope, brightness)
    scaled_rest = scaled_rest + (rest + slope_rest) * brightness
    total, rest_1 = two_sum(t1, plain)
    total, rest_2 = two_sum(total, scaled)
    return (total + (rest_1 + rest_2 + plain_rest + scaled_rest)) / 1e4


def exp(x: np.ndarray) -> np.ndarray:
    """Exponential of float64 numbers, within 1 ulp; 0 and inf beyond -700 and 700."""
    return np.asarray(exp_level(x) * np.select([x > 700.0, x < -700.0], [np.inf, 0.0], 1.0))


def expm1(x: np.ndarray) -> np.ndarray:
    """exp(x) - 1 for x >= 0, within 2 ulp: the series up to 1/2, the difference beyond."""
    series = np.ones_like(x)
    small = np.minimum(x, 0.5)
    for n in range(16, 1, -1):
        series *= small
        series /= n
        series += 1.0
    series *= small
    return np.where(x <= 0.5, series, exp(x) - 1.0) if np.any(x > 0.5) else series


def log(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Natural logarithm of positive numbers as a sum of two, to 1e-18 of the larger of it and 1."""
    m, k = np.frexp(x)
    low_half = m < 0.7071067811865476
    m = np.where(low_half, m + m, m)
    k = np.where(low_half, k - 1, k).astype(np.float64)
    f = m - 1.0
    below, below_rest = two_sum(np.full_like(f, 2.0), f)
    s = f / below
    product, product_rest = two_product(s, below)
    s_rest = (((f - product) - product_rest) - s * below_rest) / below
    z = s * s
    p = np.full_like(z, 2.0 / 25.0)
    for n in range(23, 1, -2):
        p *= z
        p += 2.0 / n
    head, rest_1 = two_sum(k * LN2_HI, 2.0 * s)
    head, rest_2 = two_sum(head, k * LN2_LO)
    return two_sum(head, rest_1 + rest_2 + 2.0 * s_rest + (s * z * p + k * _LN2_REST))


def power(x: np.ndarray, ten_thousandths: np.ndarray) -> np.ndarray:
    """Power of so many 1e-4 of x, for x >= 0 and a power that is not 0; within 2 ulp.

    0 to a positive power is 0.
    """
    exponent = np.asarray(ten_thousandths, dtype=np.float64) / 1e4
    product, rest = two_product(exponent, np.full_like(exponent, 1e4))
    exponent_rest = ((ten_thousandths - product) - rest) / 1e4
    head, tail = log(np.where(x == 0, 1.0, x))
    total, rest = two_product(head, exponent)
    value = exp(total)
    value = value + value * (rest + tail * exponent + head * exponent_rest)
    return np.where(x == 0, np.where(exponent > 0, 0.0, np.inf), value)
