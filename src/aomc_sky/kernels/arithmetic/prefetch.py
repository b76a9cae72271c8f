"""Hints to the processor about memory that is needed soon; they change no result.

Stores to lines outside the nearest cache wait for one line after the other. Lines that were asked for arrive together.
"""

from __future__ import annotations

from typing import Any

from aomc_sky.kernels.jit import lowered

from llvmlite import ir
from numba.core import cgutils, types

_KEEP_NEAR = 3
_DATA = 1


def _asking(write: int) -> Any:
    """Code that asks for the line of an element, to write it or to read it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        index = context.cast(builder, arguments[1], signature.args[1], types.uint64)
        address = builder.bitcast(builder.gep(data, [index]), cgutils.voidptr_t)
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, number, number, number])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(function, [address, number(write), number(_KEEP_NEAR), number(_DATA)])
        return context.get_dummy_value()

    return code


def prefetch_to_read(array, index):
    """Ask for the cache line of an element that will be read soon; an index beyond the array does no harm."""


def prefetch_to_write(array, index):
    """Ask for the cache line of an element that will be written soon; an index beyond the array does no harm."""


for _write, _ask in enumerate((prefetch_to_read, prefetch_to_write)):
    lowered(_ask, lambda array, index: types.void, types.Array, types.Integer)(_asking(_write))
