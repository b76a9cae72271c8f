"""The function that delivers a range of photons of a band: the kernel behind an address, for numba's `fill`."""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.emission.kernels.emit import emit, emit_runs, emit_with
from aomc_sky.emission.kernels.hooks import with_hooks
from aomc_sky.kernels.arguments import Block, block_arguments
from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.jit import c_function

from numba import carray, from_dtype, types
from numba.core.types import ExternalFunctionPointer

_CHUNK = 16384  # so many cells, which hosts do not get, stay in the cache


def _next(block, start, count, ux, uy, uz):
    """Write the directions of the photons [start, start + count), which the band has; count is above 0."""
    x, y, z = carray(ux, count), carray(uy, count), carray(uz, count)
    cell = np.empty(min(count, _CHUNK), np.int32)
    arguments = block_arguments(block)[1]
    memory = np.zeros(arguments[0], np.uint64)
    for lo in range(0, count, _CHUNK):
        hi = min(lo + _CHUNK, count)
        emit(U64(start + lo), x[lo:hi], y[lo:hi], z[lo:hi], cell[: hi - lo], memory, *arguments[1:])


def next_signature(kinds: Any, precision: np.dtype) -> Any:
    """Numba's signature of `next` for arguments of these types and a precision."""
    pointer = types.CPointer(from_dtype(precision))
    return types.void(Block(kinds), types.int64, types.int64, pointer, pointer, pointer)


def compile_next(kernel: str, hooks: tuple[str, ...], signature: Any) -> Any:
    """Return the function `next(block, start, count, ux, uy, uz)` over a kernel of the emission.

    A block holds the arguments of `numbers_of_photons`, then the words of memory and the arguments of the kernel.
    """
    if kernel == "emit_runs":
        return c_function(with_hooks(_next, ("runs",), emit=emit_runs), signature)  # no slice, but a name of its own
    return c_function(with_hooks(_next, hooks, emit=emit_with(*hooks)), signature)


def _address_of(function: JittedNext) -> int:
    return int(function.compiled.address)


class JittedNext:
    """A compiled function as jitted code calls it: by its address, without compiling it again."""

    def __init__(self, compiled: Any, signature: Any) -> None:
        self.compiled = compiled
        self._numba_type_ = ExternalFunctionPointer(signature, get_pointer=_address_of)
