"""Sums of products and quotients as if in twice the precision, for differences and powers that must keep digits."""

from __future__ import annotations

import numpy as np


def dot(*pairs: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Sum of products of factors up to 1e150 in size, within 1 ulp unless the terms cancel to 1e-16 of the largest."""
    total = rest = np.zeros(())
    for a, b in pairs:
        product, low = _product(a, b)
        grown = total + product
        part = grown - total
        rest = rest + (low + ((total - (grown - part)) + (product - part)))
        total = grown
    return total + rest


def quotient(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quotient a / b and what its rounding leaves out; their sum is the quotient within 1e-31 of itself."""
    value = a / b
    product, low = _product(value, b)
    return value, ((a - product) - low) / b


def _product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Product and its rounding error (Dekker)."""
    (a_high, a_low), (b_high, b_low) = _halves(a), _halves(b)
    product = a * b
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _halves(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    big = 134217729.0 * a
    high = big - (big - a)
    return high, a - high
