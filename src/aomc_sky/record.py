"""Equality and repr of records that hold arrays: the `==` of dataclasses raises for them, and their repr is long."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np


def same_content(one: Any, other: object) -> bool:
    """Whether two dataclasses of one kind hold equal values, arrays entry by entry, NaN equal to NaN: an `__eq__`."""
    if not isinstance(other, type(one)):
        return False  # NotImplemented would let an array compare its numbers with the record
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
    if dataclasses.is_dataclass(one) and type(one) is type(other):
        return same_content(one, other)
    return bool(one == other)


def short_repr(one: Any, shown: Callable[[str, Any], str] | None = None) -> str:
    """Class and fields of a dataclass that differ from their defaults, long ones by their size: a `__repr__`.

    `shown` may write ``name=value`` of some fields in another way; an empty text leaves it as it is.
    """
    parts = []
    for field in dataclasses.fields(one):
        value = getattr(one, field.name)
        is_default = value is field.default or (isinstance(value, (str, int, float)) and value == field.default)
        if field.repr and not is_default:
            own = shown(field.name, value) if shown else ""
            parts.append(own or f"{field.name}={_shown(value)}")
    return f"{type(one).__name__}({', '.join(parts)})"


def _shown(value: Any) -> str:
    if isinstance(value, (np.ndarray, np.generic)):
        return f"<{value.dtype} {value.shape}>" if value.size > 6 else repr(value.tolist())
    text = repr(value)
    if len(text) <= 80:
        return text
    return f"<{type(value).__name__} of {len(value)}>" if hasattr(value, "__len__") else f"<{type(value).__name__}>"
