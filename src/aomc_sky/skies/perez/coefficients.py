"""Coefficients a to e of the Perez sky from clearness, brightness and the sun: eqs. (6) to (8)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.kernels.arithmetic.error_free import two_product, two_sum
from aomc_sky.skies.perez.clearness import checked_sun, epsilon_bin
from aomc_sky.skies.perez.elementary import expm1, power
from aomc_sky.skies.perez.table import TEN_THOUSANDTHS

LIMITS = ("radiance", "paper")

EPSILON_LIMITS = (1.0, 12.01)
DELTA_LIMITS = (0.01, 0.6)
DELTA_FLOOR = 0.2  #: Smallest Delta where 1.065 <= epsilon < 2.8, under the limits "radiance".

_FLOOR_BINS = (1, 4)


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
    arrays = (np.asarray(epsilon, dtype=np.float64), np.asarray(delta, dtype=np.float64))
    clearness, brightness = np.broadcast_arrays(*arrays)
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
    t1, t2, t3, t4 = (terms[..., k] for k in range(4))
    plain, plain_rest = two_product(t2, zenith)
    slope, slope_rest = two_product(t4, zenith)
    slope, rest = two_sum(t3, slope)
    scaled, scaled_rest = two_product(slope, brightness)
    scaled_rest = scaled_rest + (rest + slope_rest) * brightness
    total, rest_1 = two_sum(t1, plain)
    total, rest_2 = two_sum(total, scaled)
    return (total + (rest_1 + rest_2 + plain_rest + scaled_rest)) / 1e4


def _overcast(terms: np.ndarray, zenith: np.ndarray, brightness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients c and d of the first bin, eqs. (7) and (8); their exponentials less 1 do not cancel."""
    c1, c2, c3, c4 = (terms[..., 2, k] for k in range(4))
    d1, d2, d3, d4 = (terms[..., 3, k] for k in range(4))
    exponents = power(brightness * (c1 + c2 * zenith) / 1e4, c3), brightness * (d1 + d2 * zenith) / 1e4
    grown_c, grown_d = expm1(np.stack(exponents))
    return grown_c + (1e4 - c4) / 1e4, -grown_d + ((d3 - 1e4) + brightness * d4) / 1e4
