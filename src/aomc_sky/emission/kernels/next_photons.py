"""The C functions that deliver photons of a band and their numbers: kernels behind an address, for C and Fortran."""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.emission.kernels.emit import emit, emit_runs, emit_with
from aomc_sky.emission.kernels.hooks import with_hooks
from aomc_sky.emission.kernels.numbers import numbers_of_photons
from aomc_sky.kernels.arguments import Block, block_arguments, block_head, is_null
from aomc_sky.kernels.arithmetic.constants import U64
from aomc_sky.kernels.jit import c_function, inner

from numba import carray, from_dtype, types
from numba.core.types import ExternalFunctionPointer

CLOSED, BAD_START, BAD_COUNT, NO_ARRAY = -1, -2, -3, -4
"""Errors, as in include/aomc_sky_embed.h."""

OPEN = np.uint64(0x736B79616F6D6331)
"""First word of the block of an open source; the second is the number of photons."""

_CHUNK = 16384  # so many cells, which hosts do not get, stay in the cache


@inner
def _photons_due(block, start, n, ux, uy, uz):
    """Number of photons that a call delivers, 0 at the end of the band; or an error."""
    if is_null(block):
        return CLOSED
    state, end = block_head(block)
    if state != OPEN:
        return CLOSED
    if start < 0:
        return BAD_START
    if n < 0:
        return BAD_COUNT
    count = max(min(n, np.int64(end) - start), 0)
    if count > 0 and (is_null(ux) or is_null(uy) or is_null(uz)):
        return NO_ARRAY
    return count


def _next(block, start, n, ux, uy, uz):
    count = _photons_due(block, start, n, ux, uy, uz)
    if count <= 0:
        return count
    x, y, z = carray(ux, count), carray(uy, count), carray(uz, count)
    cell = np.empty(min(count, _CHUNK), np.int32)
    arguments = block_arguments(block)[1]
    memory = np.zeros(arguments[0], np.uint64)
    for lo in range(0, count, _CHUNK):
        hi = min(lo + _CHUNK, count)
        emit(U64(start + lo), x[lo:hi], y[lo:hi], z[lo:hi], cell[: hi - lo], memory, *arguments[1:])
    return count


def _numbers(block, start, n, n1, n2, n3):
    count = _photons_due(block, start, n, block, block, block)
    if count <= 0:
        return count
    if is_null(n1) and is_null(n2) and is_null(n3):
        return NO_ARRAY
    first, second = carray(n1, 0 if is_null(n1) else count), carray(n2, 0 if is_null(n2) else count)
    third = carray(n3, 0 if is_null(n3) else count)
    numbers_of_photons(U64(start), first, second, third, *block_arguments(block)[0])
    return count


def next_signature(kinds: Any, precision: np.dtype) -> Any:
    """Numba's signature of `next` for arguments of these types and a precision."""
    pointer = types.CPointer(from_dtype(precision))
    return types.int64(Block(kinds), types.int64, types.int64, pointer, pointer, pointer)


def numbers_signature(kinds: Any, precision: np.dtype) -> Any:
    """The same of the function of the numbers, which reads the first arguments of a block of these types."""
    return next_signature(types.Tuple((kinds[0],)), precision)


def compile_next(kernel: str, hooks: tuple[str, ...], signature: Any) -> Any:
    """Return the C function `next(block, start, n, ux, uy, uz)` over a kernel of the emission.

    A block holds the arguments of `numbers_of_photons`, then the words of memory and the arguments of the kernel. The
    kernel "numbers" reads the first ones alone: one function serves all blocks.
    """
    text = _numbers if kernel == "numbers" else _next
    if kernel == "emit_runs":
        return c_function(with_hooks(text, ("runs",), emit=emit_runs), signature)  # no slice, but a name of its own
    return c_function(with_hooks(text, hooks, emit=emit_with(*hooks)), signature)


def _address_of(function: JittedNext) -> int:
    return int(function.compiled.address)


class JittedNext:
    """A compiled C function as jitted code calls it: by its address, without compiling it again."""

    def __init__(self, compiled: Any, signature: Any) -> None:
        self.compiled = compiled
        self._numba_type_ = ExternalFunctionPointer(signature, get_pointer=_address_of)
