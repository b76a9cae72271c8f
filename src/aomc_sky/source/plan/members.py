"""One array of a plan as a line of a table: its type, its lengths, its range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.source.plan.problem import PlanRuleError, refuse_value

LARGE = 1.7976931348623157e308
"""As an end of a range: finite."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Member:
    """One array of a plan."""

    dtype: str  #: exactly this type, little-endian
    shape: tuple[str | int, ...]  #: a text is a length of `Lengths`, the same wherever it stands
    low: float | None = None  #: range of all values, both ends allowed; None where another rule looks at them
    high: float | None = None
    may_be_nan: bool = False  #: whether NaN stands for "not known"
    is_optional: bool = False


def check_shape(name: str, array: Any, member: Member, lengths: dict[str, int]) -> None:
    """Compare one array; lengths that are not known yet are those of the array."""
    if not isinstance(array, np.ndarray):
        raise PlanRuleError("E953", name, f"found {type(array).__name__}, wanted an array of {member.dtype}")
    expected: list[int] = []
    for axis, length in enumerate(member.shape):
        found = array.shape[axis] if axis < array.ndim else -1
        expected.append(length if isinstance(length, int) else _length(length, found, lengths))
    little = array.dtype.newbyteorder("<").str
    if little != member.dtype or not array.dtype.isnative or array.shape != tuple(expected):
        named = ", ".join(
            str(length) if isinstance(length, int) else f"{length} = {value}"
            for length, value in zip(member.shape, expected, strict=True)
        )
        allowed = f"{np.dtype(member.dtype).name} of shape ({named})"
        raise PlanRuleError("E953", name, f"found {array.dtype.name} of shape {array.shape}, wanted {allowed}")


def _length(text: str, found: int, lengths: dict[str, int]) -> int:
    """Value of a length such as ``n_cell + 1``; what is found where it stands for the first time."""
    name, _, more = text.partition(" + ")
    extra = int(more or 0)
    if name not in lengths:
        least = 0 if name.startswith("n_weight") else 1
        if found - extra < least:
            return least + extra  # what was found cannot be
        lengths[name] = found - extra
    return lengths[name] + extra


def check_range(name: str, array: np.ndarray, member: Member) -> None:
    """Raise E954 where a value lies outside the range of its member, or is not a number."""
    if member.low is None or member.high is None or not array.size:
        return
    values = array[~np.isnan(array)] if member.may_be_nan else array
    for found in (values.min(), values.max()) if values.size else ():
        if not member.low <= found <= member.high:  # NaN is neither
            raise refuse_value(name, found, f"values {_range(member.low, member.high)}")


def _range(low: float, high: float) -> str:
    if high == LARGE:
        return "that are finite" if low == -LARGE else f"from {low:g}, finite"
    return f"from {low:g} to {high:g}"
