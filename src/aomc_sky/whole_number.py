"""Whole numbers from a caller: integers of numpy and Python become Python's own, everything else is refused."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from aomc_sky.errors import AomcSkyError, UsageError


def as_index(value: Any, name: str) -> int:
    """Return an index as a Python integer, which no arithmetic wraps.

    Integers of any type and 0-dimensional integer arrays are taken. Booleans, text, None and floats
    are not, whole or not: 2^53 + 1 as a float is another number already.
    """
    index = _index_of(value)
    if index is None:
        raise UsageError(f"{name} must be a whole number, got {value!r}")
    return index


def as_index_within(value: Any, name: str, low: int, high: int) -> int:
    """As `as_index`, within [low, high]."""
    return _within(_index_of(value), value, name, (low, high), UsageError)


def as_number_of(value: Any, name: str, low: int, high: int, *, error: type[AomcSkyError] = UsageError) -> int:
    """Return how many, within [low, high], as a Python integer; floats without a fraction (1e6) count too."""
    is_float = isinstance(value, float) or (isinstance(value, (np.generic, np.ndarray)) and value.dtype.kind == "f")
    is_float = is_float and np.ndim(value) == 0
    is_whole = is_float and bool(np.isfinite(value)) and float(value).is_integer()
    return _within(int(value) if is_whole else _index_of(value), value, name, (low, high), error)


def _index_of(value: Any) -> int | None:
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, np.ndarray) and value.ndim > 0):
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def _within(n: int | None, value: Any, name: str, bounds: tuple[int, int], error: type[AomcSkyError]) -> int:
    low, high = bounds
    if n is None or not low <= n <= high:
        raise error(f"{name} must be a whole number from {low} to {_in_words(high)}, got {value!r}")
    return n


def _in_words(high: int) -> str:
    """A bound as a person reads it: 2^62, not its nineteen digits."""
    for less, words in ((0, ""), (1, " - 1")):
        power = high + less
        if power > 2**20 and power & (power - 1) == 0:
            return f"2^{power.bit_length() - 1}{words}"
    return str(high)
