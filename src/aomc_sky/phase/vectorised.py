"""Formulas of the kernels over whole arrays: checks, precision, broadcasting, and blocks that stay in the cache.

Plain numpy: no compiler is loaded, and the bits are those of the jitted kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aomc_sky.errors import UsageError

Formula = Callable[..., tuple[Any, ...]]

_BLOCK = 8192


def precision_of(*arguments: ArrayLike) -> np.dtype[Any]:
    """float32 where every array is no finer than that, else float64; plain Python numbers do not decide."""
    try:
        kind = np.result_type(*[a if isinstance(a, (int, float)) else np.asarray(a) for a in arguments])
    except TypeError:
        raise UsageError("real numbers are wanted, not text or objects") from None
    if kind.kind not in "biuf":
        raise UsageError(f"real numbers are wanted, not {kind}")
    return np.dtype(np.float32) if kind in (np.float16, np.float32) else np.dtype(np.float64)


def checked(name: str, value: ArrayLike, kind: np.dtype[Any], low: float, high: float, open_ends: bool = False) -> Any:
    """`value` rounded to the precision of the call, then as float64; UsageError outside its range, NaN included."""
    with np.errstate(over="ignore"):
        array = np.asarray(value).astype(kind).astype(np.float64)
    inside = (array > low) & (array < high) if open_ends else (array >= low) & (array <= high)
    if not inside.all():
        first = array[~inside].flat[0] if array.ndim else array[()]
        ends = f"between {low:g} and {high:g}, ends excluded" if open_ends else f"in {low:g} to {high:g}"
        raise UsageError(f"{name} must lie {ends}; found {first!r}" + _rounded(value, array, kind))
    return array


def _rounded(value: ArrayLike, array: NDArray[np.float64], kind: np.dtype[Any]) -> str:
    if kind == np.float32 and not np.array_equal(np.asarray(value, dtype=np.float64), array, equal_nan=True):
        return " after rounding to float32; give float64 numbers to keep more digits"
    return ""


def evaluate(formula: Formula, kind: np.dtype[Any], *arguments: NDArray[np.float64]) -> tuple[Any, ...]:
    """Results of `formula` over broadcast arguments, block by block, in the precision of the call.

    Scalars give numpy scalars. Arguments of one element stay what they are, so that what depends on them
    alone is worked out once per block.
    """
    try:
        shape = np.broadcast_shapes(*[a.shape for a in arguments])
    except ValueError:
        shapes = " and ".join(str(a.shape) for a in arguments)
        raise UsageError(f"arguments of shapes {shapes} do not broadcast") from None
    size = int(np.prod(shape, dtype=np.int64))
    flat = [a.reshape(1) if a.size == 1 else np.broadcast_to(a, shape).reshape(-1) for a in arguments]
    results: list[NDArray[Any]] = []
    for start in range(0, max(size, 1), _BLOCK):
        values = formula(*[a if a.size == 1 else a[start : start + _BLOCK] for a in flat])
        if not results:
            results = [np.empty(size, dtype=kind) for _ in values]
        for result, value in zip(results, values, strict=True):
            result[start : start + _BLOCK] = value
    return tuple(result.reshape(shape)[()] for result in results)
