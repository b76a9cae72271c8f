"""What the rounding of a sum and of a product left out: + - x alone, for arrays, and for kernels to compile."""

from __future__ import annotations

from typing import Any

_SPLIT = 134217729.0  # 2^27 + 1 cuts a float64 into two halves whose products are exact


def two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """Sum and its rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def product_error(a: Any, b: Any, product: Any) -> Any:
    """What the rounding of a * b left out (Dekker); exact where nothing overflows or leaves the normal numbers."""
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
