"""Exact products of 62-bit integers: 128 bits as two uint64, for whole arrays."""

from __future__ import annotations

import numpy as np

_LOW = np.uint64(0xFFFFFFFF)
_S2 = np.uint64(2)
_S32 = np.uint64(32)
_S62 = np.uint64(62)
_REST = np.uint64((1 << 62) - 1)


def product_over_2_62(a: np.ndarray, n: int, offset: int) -> tuple[np.ndarray, np.ndarray]:
    """Quotient and remainder of n a + offset by 2^62, exactly.

    Parameters
    ----------
    a : ndarray, uint64
        First factors. [0 to 2^62]
    n : int
        Second factor. [0 to 2^62]
    offset : int
        Added to every product. [0 to 2^62 - 1]

    Returns
    -------
    quotient, remainder : ndarray, uint64, shape of `a`
        quotient 2^62 + remainder = n a + offset.
    """
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
