"""Formulas of the kernels over whole arrays: checks, precision, broadcasting, and blocks that stay in the cache."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aomc_sky.errors import UsageError, unmasked

Formula = Callable[..., Any]

_BLOCK = 8192


def shape_of(arguments: tuple[NDArray[Any], ...]) -> tuple[int, ...]:
    """Shape to which arrays broadcast; UsageError where they do not."""
    try:
        return np.broadcast_shapes(*[a.shape for a in arguments])
    except ValueError:
        shapes = " and ".join(str(a.shape) for a in arguments)
        raise UsageError(f"arguments of shapes {shapes} do not broadcast") from None


def precision_of(*arguments: ArrayLike) -> np.dtype[Any]:
    """float32 if no array is finer than that, else float64; plain Python numbers do not decide."""
    for argument in arguments:
        unmasked("an argument", argument)
    try:
        kind = np.result_type(*[a if isinstance(a, (int, float)) else np.asarray(a) for a in arguments])
    except (TypeError, ValueError):
        raise UsageError("expected real numbers, not text or objects") from None
    if kind.kind not in "biuf":
        raise UsageError(f"expected real numbers, not {kind}")
    return np.dtype(np.float32) if kind in (np.float16, np.float32) else np.dtype(np.float64)


def real(value: ArrayLike) -> NDArray[np.float64]:
    """The value in float64; a UsageError for anything but real numbers."""
    precision_of(value)
    return np.asarray(value, dtype=np.float64)


def checked(name: str, value: ArrayLike, kind: np.dtype[Any], low: float, high: float, open_ends: bool = False) -> Any:
    """`value` rounded to the precision of the call; UsageError outside its range, NaN included."""
    with np.errstate(over="ignore"):
        array = np.asarray(value, dtype=kind)
    if array.size == 0:
        return array
    least, most = float(array.min()), float(array.max())  # NaN if there is one
    if (low < least and most < high) or (not open_ends and low <= least and most <= high):
        return array
    wide = array.astype(np.float64)
    outside = wide[~((wide > low) & (wide < high) if open_ends else (wide >= low) & (wide <= high))]
    ends = f"between {low:g} and {high:g}, ends excluded" if open_ends else f"in {low:g} to {high:g}"
    is_rounded = kind == np.float32 and not np.array_equal(np.asarray(value, dtype=np.float64), wide, equal_nan=True)
    advice = " after rounding to float32; give float64 numbers to keep more digits" if is_rounded else ""
    raise UsageError(f"{name} must lie {ends}; found {float(outside.flat[0])!r}{advice}")


def evaluate(formula: Formula, kind: np.dtype[Any], *arguments: NDArray[Any]) -> tuple[Any, ...]:
    """Results of `formula` over broadcast arguments, block by block, in the precision of the call.

    Scalars give numpy scalars. Arguments of one element stay what they are, so that what depends on them
    alone is worked out once per block.
    """
    shape = shape_of(arguments)
    size = math.prod(shape)
    flat = [a.reshape(1) if a.size == 1 else np.broadcast_to(a, shape).reshape(-1) for a in arguments]
    results: list[NDArray[Any]] = []
    for start in range(0, max(size, 1), _BLOCK):
        blocks = [a if a.size == 1 else a[start : start + _BLOCK] for a in flat]
        values = formula(*[b.astype(np.float64, copy=False) for b in blocks])
        values = values if isinstance(values, tuple) else (values,)
        if not results:
            results = [np.empty(size, dtype=kind) for _ in values]
        for result, value in zip(results, values, strict=True):
            result[start : start + _BLOCK] = value
    return tuple(result.reshape(shape)[()] for result in results)
