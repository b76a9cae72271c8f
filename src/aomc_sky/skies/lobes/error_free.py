"""Sums of products and quotients as if in twice the precision, for differences and powers that must keep digits."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.error_free import two_product, two_sum


def dot(*pairs: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Sum of products of factors up to 1e150 in size, within 1 ulp unless the terms cancel to 1e-16 of the largest."""
    total = rest = np.zeros(())
    for a, b in pairs:
        product, low = two_product(a, b)
        total, lost = two_sum(total, product)
        rest = rest + (low + lost)
    return total + rest


def quotient(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quotient a / b and what its rounding leaves out; their sum is the quotient within 1e-31 of itself."""
    value = a / b
    product, low = two_product(value, b)
    return value, ((a - product) - low) / b
