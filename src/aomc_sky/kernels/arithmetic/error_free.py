"""Rounding errors of a sum and a product; sums, shares of a sum and products without any error.

`two_sum` and `two_product` are + - x alone, for arrays, and for kernels to compile; the rest is of arrays alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

FIXED_POINT_BITS = 62

_LOW = np.uint64(0xFFFFFFFF)
_S2 = np.uint64(2)
_S32 = np.uint64(32)
_S62 = np.uint64(62)
_REST = np.uint64((1 << 62) - 1)

_CUMULATIVE_BITS = 107
_CHUNK = 8192  # intermediate arrays of this size stay in the cache
_NEAR_A_HALF = 2.0**-26
_SUM_LEVELS = 3
_SPLIT = 134217729.0  # 2^27 + 1 cuts a float64 into two halves whose products are exact


def two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """Sum and its rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def product_error(a: Any, b: Any, product: Any) -> Any:
    """Rounding error of a * b (Dekker); exact for normal numbers without overflow."""
    cut = _SPLIT * a
    a_high = cut - (cut - a)
    cut = _SPLIT * b
    b_high = cut - (cut - b)
    a_low, b_low = a - a_high, b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def two_product(a: Any, b: Any) -> tuple[Any, Any]:
    """Product and its rounding error."""
    product = a * b
    return product, product_error(a, b, product)


def exact_sum(values: np.ndarray) -> float:
    """Correctly rounded sum, equal to `math.fsum` to the bit and several times as fast for large arrays.

    Values lie in [0, 1]. Adding and subtracting a power of two cuts every summand at the same bit without an error. The
    upper parts have so few bits that their plain sum is exact in any order (S. M. Rump, T. Ogita, S. Oishi, Accurate
    floating-point summation I, SIAM J. Sci. Comput. 31, 189, 2008).
    """
    bits = (values.size + 1).bit_length()
    sigma = math.ldexp(1.0, bits)
    parts = []
    rest = values
    for _ in range(_SUM_LEVELS):
        upper = rest + sigma
        upper -= sigma
        parts.append(float(upper.sum()))
        rest = np.subtract(rest, upper, out=upper)
        if not rest.any():
            break
        sigma = math.ldexp(sigma, bits - 53)
    return math.fsum([*parts, *rest[rest != 0].tolist()])


def rounded_cumulative(values: np.ndarray) -> np.ndarray:
    """Cumulative sums over the total, each rounded to the nearest multiple of 2^-62: uint64 (n + 1,), from 0 to 2^62.

    Entry k is floor(2^62 S_k / S_n + 1/2), where S_k is the exact sum of the first k values. [0 to 1.8e308, at least
    one positive]

    Running sums and quotients have twice the precision of float64. The error of a quotient is below 2^-30 units.
    Quotients within 2^-26 of a change of rounding are computed with integers.
    """
    units = np.zeros(values.size + 1, dtype=np.int64)
    doubtful = _fill_units(values, units[1:])
    if doubtful.size:
        units[1 + doubtful] = _rounded_by_integers(values, doubtful)
    return units.view(np.uint64)


def _fill_units(values: np.ndarray, units: np.ndarray) -> np.ndarray:
    """Fill in the rounded quotients and return which of them are in doubt."""
    high, low = _running_sums(np.ldexp(values, -int(np.frexp(values.max())[1])))
    doubtful = []
    for start in range(0, values.size, _CHUNK):
        part = slice(start, start + _CHUNK)
        units[part], found = _rounded_quotients(high[part], low[part], high[-1], low[-1])
        doubtful.append(found + start)
    return np.concatenate(doubtful)


def _running_sums(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Running sums of numbers up to 1 as sums of two floats, with relative errors below 2^-95 + 2^-105.

    The cuts are those of `exact_sum`. A level takes 53 - b bits of numbers of which there are up to 2^b, so few that
    their running sums are exact. There are so many levels that all that is left adds up to less than 2^-107.
    """
    bits = (values.size + 1).bit_length()
    levels = -(-(_CUMULATIVE_BITS + bits) // (53 - bits))
    sigma = [2.0 ** (bits + level * (bits - 53)) for level in range(levels)]
    reached = [0.0] * levels
    high, low = np.empty_like(values), np.empty_like(values)
    for start in range(0, values.size, _CHUNK):
        rest = values[start : start + _CHUNK].copy()
        sums = []
        for level in range(levels):
            upper = (rest + sigma[level]) - sigma[level]
            rest -= upper
            running = np.cumsum(upper)
            running += reached[level]
            reached[level] = running[-1]
            sums.append(running)
            if not rest.any() and not any(reached[level + 1 :]):
                break
        total, error = two_sum(sums[0], sums[1]) if len(sums) > 1 else (sums[0], np.zeros_like(rest))
        for running in sums[2:]:
            error += running
        high[start : start + _CHUNK], low[start : start + _CHUNK] = total, error
    return high, low


def _rounded_quotients(
    high: np.ndarray, low: np.ndarray, total: float, total_low: float
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of two floats over the total in units of 2^-62, rounded; and which of them are in doubt."""
    first = high / total
    product, product_low = two_product(first, total)
    second = (((high - product) - product_low) + (low - first * total_low)) / total
    first *= 2.0**FIXED_POINT_BITS
    whole = np.floor(first)
    first -= whole
    rest = first + second * 2.0**FIXED_POINT_BITS + 0.5
    steps = np.floor(rest)
    rest -= steps
    return (whole.astype(np.int64) + steps.astype(np.int64)), np.flatnonzero(np.abs(rest - 0.5) > 0.5 - _NEAR_A_HALF)


def _rounded_by_integers(values: np.ndarray, chosen: np.ndarray) -> list[int]:
    """The same for chosen running sums in integers of any length."""
    total = sum(_integers(values))
    places = set(chosen.tolist())
    sums = (s for k, s in enumerate(itertools.accumulate(_integers(values))) if k in places)
    return [((s << (FIXED_POINT_BITS + 1)) + total) // (2 * total) for s in sums]


def _integers(values: np.ndarray) -> Iterator[int]:
    """The values as integers of one unit, the last bit of the smallest."""
    mantissa, exponent = np.frexp(values)
    shift = np.where(values > 0, exponent - exponent[values > 0].min(), 0)
    numbers = np.ldexp(mantissa, 53).astype(np.int64)
    return (number << places for number, places in zip(numbers.tolist(), shift.tolist(), strict=True))


def product_over_2_62(a: np.ndarray, n: int, offset: int) -> tuple[np.ndarray, np.ndarray]:
    """Quotient and remainder (uint64) of n a + offset by 2^62, exactly. [a (uint64), n 0 to 2^62; offset below 2^62]"""
    b0, b1 = np.uint64(n & 0xFFFFFFFF), np.uint64(n >> 32)
    low, high = a & _LOW, a >> _S32
    middle = low * b1  # the sum of the products across and the carry from below stays below 2^64
    low *= b0
    middle += high * b0
    middle += low >> _S32
    high *= b1
    high += middle >> _S32
    middle <<= _S32
    low &= _LOW
    low |= middle
    low += np.uint64(offset)  # wraps, and the carry goes to the high word
    high += low < np.uint64(offset)
    high <<= _S2
    high |= low >> _S62
    low &= _REST
    return high, low
