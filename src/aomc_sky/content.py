"""Equality of records that hold arrays: the `==` of dataclasses raises for them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np


def same_content(one: Any, other: object) -> bool:
    """Whether two dataclasses of one kind hold equal values, arrays entry by entry, NaN equal to NaN: an `__eq__`."""
    if not isinstance(other, type(one)):
        return NotImplemented
    names = (field.name for field in dataclasses.fields(one) if field.compare)
    return all(_are_equal(getattr(one, name), getattr(other, name)) for name in names)


def _are_equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        pair = np.asarray(one), np.asarray(other)
        return np.array_equal(*pair, equal_nan=all(array.dtype.kind in "fc" for array in pair))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_are_equal(one[name], other[name]) for name in one)
    if isinstance(one, (tuple, list)) and type(one) is type(other):
        return len(one) == len(other) and all(map(_are_equal, one, other))
    return bool(one == other)
