"""Exact products of 62-bit integers: 128 bits as two uint64, for whole arrays."""

from __future__ import annotations

import numpy as np

_LOW = np.uint64(0xFFFFFFFF)
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
    a0, a1 = a & _LOW, a >> _S32
    b0, b1 = np.uint64(n & 0xFFFFFFFF), np.uint64(n >> 32)
    p00, p01, p10, p11 = a0 * b0, a0 * b1, a1 * b0, a1 * b1
    middle = (p00 >> _S32) + (p01 & _LOW) + (p10 & _LOW)
    low = (middle << _S32) | (p00 & _LOW)
    high = p11 + (p01 >> _S32) + (p10 >> _S32) + (middle >> _S32)
    total = low + np.uint64(offset)  # wraps, and the carry goes to the high word
    high += total < low
    return (high << np.uint64(2)) | (total >> _S62), total & _REST
