"""Hints to the processor which memory is wanted soon; no effect on any result.

Stores to lines that are not in the nearest cache wait for them one after the other; lines asked for come side by side.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from aomc_sky.kernels.jit import overloads

_KEEP_NEAR = 3
_DATA = 1


def _asking(write: int) -> Any:
    """Code that asks for the line of an element, to write it or to read it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, index = arguments
        data = context.make_array(signature.args[0])(context, builder, array).data
        address = builder.bitcast(builder.gep(data, [index]), cgutils.voidptr_t)
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, number, number, number])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(function, [address, number(write), number(_KEEP_NEAR), number(_DATA)])
        return context.get_dummy_value()

    return code


@intrinsic
def _ask_to_read(context, array, index):
    return types.void(array, types.uint64), _asking(0)


@intrinsic
def _ask_to_write(context, array, index):
    return types.void(array, types.uint64), _asking(1)


def prefetch_to_read(array, index):
    """Ask for the cache line of an element that will be read soon; an index beyond the array does no harm."""


def prefetch_to_write(array, index):
    """Ask for the cache line of an element that will be written soon; an index beyond the array does no harm."""


@overloads(prefetch_to_read)
def _read_overload(array, index):
    def ask(array, index):
        _ask_to_read(array, index)

    return ask


@overloads(prefetch_to_write)
def _write_overload(array, index):
    def ask(array, index):
        _ask_to_write(array, index)

    return ask
