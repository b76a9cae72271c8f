"""Arguments of a kernel behind an address, for hosts: Python writes them, and compiled code reads them.

A *block* of 64-bit words has the arguments one after the other. A number takes one word, an array two (address and
length), a tuple the words of its parts. The compiler knows None and True by their types, so they take no word. The
types of all arguments are the type of the block.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from aomc_sky.kernels.jit import array_at

from llvmlite import ir
from numba import from_dtype, types
from numba.core.base import BaseContext
from numba.extending import intrinsic, models, register_model

_WORD = ir.IntType(64)
_ADD_ADDRESS = BaseContext.add_dynamic_addr  # private, so that a numba without it is found at once


def typed(argument: Any) -> Any:
    """Numba's type of an argument, or of the tuple of several."""
    if argument is None:
        return types.none
    if argument is True:
        return types.boolean
    if isinstance(argument, tuple):
        return types.Tuple(tuple(typed(part) for part in argument))
    if isinstance(argument, np.ndarray) and argument.ndim == 1 and argument.flags.c_contiguous:
        return types.Array(from_dtype(argument.dtype), 1, "C")
    if isinstance(argument, np.generic):
        return from_dtype(argument.dtype)
    raise TypeError(f"a {type(argument).__name__} cannot stand in a block")


def words_of(arguments: Iterable[object]) -> list[int]:
    """The words of a block for arguments of `typed`; their arrays must outlive it."""
    words: list[int] = []
    for argument in arguments:
        if isinstance(argument, tuple):
            words += words_of(argument)
        elif isinstance(argument, np.ndarray):
            words += [int(argument.ctypes.data), argument.size]
        elif isinstance(argument, np.generic):
            words.append(int(argument if argument.dtype.kind == "u" else argument.view(f"u{argument.itemsize}")))
    return words


class Block(types.Type):
    """The address of a block whose arguments have the type of a tuple."""

    def __init__(self, kinds: Any) -> None:
        self.kinds = kinds
        super().__init__(name=f"Block({kinds})")


register_model(Block)(models.OpaqueModel)


class _Words:
    """Emits loads of consecutive words, from the first argument on."""

    def __init__(self, builder: Any, address: Any) -> None:
        self.builder, self.next = builder, 0
        self.base = builder.bitcast(address, _WORD.as_pointer())
        self.unchanging = builder.module.add_metadata([])

    def load(self) -> Any:
        """The next word; blocks never change, which lets the compiler keep words in registers over a loop."""
        word = self.builder.load(self.builder.gep(self.base, [ir.Constant(_WORD, self.next)]))
        word.set_metadata("invariant.load", self.unchanging)
        self.next += 1
        return word


def _value(context: Any, builder: Any, kind: Any, words: _Words) -> Any:
    if isinstance(kind, types.BaseTuple):
        return context.make_tuple(builder, kind, [_value(context, builder, k, words) for k in kind.types])
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value()
    if isinstance(kind, types.Boolean):
        return context.get_constant(kind, True)
    if isinstance(kind, types.Array):
        address = builder.inttoptr(words.load(), ir.IntType(8).as_pointer())
        return array_at(context, builder, kind, address, words.load())
    word, number = words.load(), context.get_value_type(kind)
    bits = ir.IntType(context.get_abi_sizeof(number) * 8)
    word = word if bits == _WORD else builder.trunc(word, bits)
    return builder.bitcast(word, number) if isinstance(kind, types.Float) else word


@intrinsic
def block_arguments(typing_context, block):
    """The tuple of arguments of a block."""

    def generate(context, builder, signature, arguments):
        return _value(context, builder, block.kinds, _Words(builder, arguments[0]))

    return block.kinds(block), generate


def fixed_block(kinds: Any, address: int) -> Any:
    """Return a jitted function without arguments that gives a block at an address of this process.

    Another process does not have this address. numba knows that, and never caches a function that uses it.
    """
    answer = Block(kinds)

    @intrinsic
    def give_block(typing_context):
        def generate(context, builder, signature, arguments):
            return _ADD_ADDRESS(context, builder, address, info="tables of a photon source")

        return answer(), generate

    return give_block
