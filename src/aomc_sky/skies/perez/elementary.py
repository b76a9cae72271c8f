"""Exponential and power with + - x / alone, so that a sky's coefficients have the same bits on every machine.

numpy and libm differ between versions and processors in the last bit of a few percent of their
values; the masses, and the hash that names a run, would differ with them.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import LN2_HI, LN2_LO
from aomc_sky.kernels.arithmetic.error_free import two_product, two_sum
from aomc_sky.kernels.arithmetic.plain import exp_reduced

_LN2_REST = 1.1612227229362532e-26


def exp(x: np.ndarray) -> np.ndarray:
    """Exponential of float64 numbers, within 1 ulp; 0 and inf beyond the range."""
    x = np.minimum(np.maximum(x, -800.0), 800.0)
    k = np.rint(x * 1.4426950408889634)
    reduced = exp_reduced(x - k * LN2_HI, k * LN2_LO)
    exponent = np.where(np.isnan(k), 0.0, k).astype(np.int64)
    with np.errstate(over="ignore", under="ignore"):
        return np.ldexp(reduced, exponent)


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
