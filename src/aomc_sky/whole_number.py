"""Whole numbers that a caller gives: numpy's and Python's alike become Python's own, everything else is refused."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from aomc_sky.errors import AomcSkyError, UsageError


def as_index(value: Any, name: str, *, error: type[AomcSkyError] = UsageError) -> int:
    """Return an index, a seed or a size as a Python integer, which no arithmetic wraps.

    Integers of any type and 0-dimensional integer arrays are taken. Booleans, text, None and floats
    are not, whole or not: 2^53 + 1 as a float is another number already.
    """
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, np.ndarray) and value.ndim > 0):
        raise error(f"{name} must be a whole number, got {value!r}")
    try:
        return operator.index(value)
    except TypeError:
        raise error(f"{name} must be a whole number, got {value!r}") from None


def as_number_of(value: Any, name: str, low: int, high: int, *, error: type[AomcSkyError] = UsageError) -> int:
    """Return how many as a Python integer within [low, high]; floats without a fraction (1e6) count too."""
    is_float = isinstance(value, (float, np.floating)) or (isinstance(value, np.ndarray) and value.dtype.kind == "f")
    if is_float and np.ndim(value) == 0 and np.isfinite(value) and value == np.rint(value):
        value = int(value)
    try:
        n = as_index(value, name)
    except UsageError:
        n = low - 1
    if not low <= n <= high:
        raise error(f"{name} must be a whole number from {low} to {high}, got {value!r}")
    return n
