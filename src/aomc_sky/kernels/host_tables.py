"""Arguments of a kernel behind one address, so that code outside Python can hand them to it.

A *block* is an array of 64-bit words: a number takes one word, an array two (where it lies, its length), a
tuple the words of its parts; an option (None or True) takes none, because it is a type to the compiler.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import config, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

_WORD = ir.IntType(64)


def is_compiled() -> bool:
    """Whether numba compiles at all (NUMBA_DISABLE_JIT)."""
    return not config.DISABLE_JIT


def kinds_of(values: Iterable[object]) -> tuple[Any, ...]:
    """Numba's types of arguments, as a dispatcher sees them."""
    return tuple(types.Tuple(kinds_of(v)) if isinstance(v, tuple) else numba.typeof(v) for v in values)


def words_of(values: Iterable[object]) -> list[int]:
    """The words of a block for arguments; the arrays must outlive it."""
    words: list[int] = []
    for value in values:
        if value is None or value is True:
            continue
        if isinstance(value, tuple):
            words += words_of(value)
        elif isinstance(value, np.ndarray):
            if value.ndim != 1 or not value.flags.c_contiguous:
                raise TypeError("arrays behind an address have one contiguous dimension")
            words += [value.ctypes.data, value.size]
        elif isinstance(value, np.uint64):
            words.append(int(value))
        else:
            raise TypeError(f"a {type(value).__name__} cannot stand in a block")
    return words


class _Words:
    """Emits loads of consecutive words, from `first` on."""

    def __init__(self, builder: Any, address: Any, first: int) -> None:
        self.builder, self.place = builder, first
        self.base = builder.inttoptr(address, _WORD.as_pointer())
        self.unchanging = builder.module.add_metadata([])

    def load(self) -> Any:
        """The next word; blocks never change, which lets the compiler keep words in registers over a loop."""
        where = self.builder.gep(self.base, [ir.Constant(_WORD, self.place)])
        word = self.builder.load(where)
        word.set_metadata("invariant.load", self.unchanging)
        self.place += 1
        return word


def _value(context: Any, builder: Any, kind: Any, words: _Words) -> Any:
    if isinstance(kind, types.BaseTuple):
        return context.make_tuple(builder, kind, [_value(context, builder, k, words) for k in kind.types])
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value()
    if isinstance(kind, types.Boolean):
        return context.get_constant(kind, True)
    if isinstance(kind, types.Array):
        array = make_array(kind)(context, builder)
        data, size = words.load(), words.load()
        width = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        populate_array(
            array,
            data=builder.inttoptr(data, array.data.type),
            shape=[size],
            strides=[context.get_constant(types.intp, width)],
            itemsize=context.get_constant(types.intp, width),
            meminfo=None,
        )
        return array._getvalue()
    return words.load()


def block_reader(kinds: tuple[Any, ...], first: int) -> Any:
    """Return a jitted function from the address of a block (uint64) to the tuple of arguments behind word `first`."""
    answer = types.Tuple(kinds)

    @intrinsic
    def read_block(typing_context, address):
        def generate(context, builder, signature, arguments):
            return _value(context, builder, answer, _Words(builder, arguments[0], first))

        return answer(types.uint64), generate

    return read_block


def fixed_address(address: int) -> Any:
    """Return a jitted function without arguments that gives an address of this process.

    numba knows such an address as one that another process does not have: a function that uses it is not
    cached on disk, also when its author asks for that.
    """

    @intrinsic
    def give_address(typing_context):
        def generate(context, builder, signature, arguments):
            pointer = context.add_dynamic_addr(builder, address, info="tables of a photon source")
            return builder.ptrtoint(pointer, _WORD)

        return types.uint64(), generate

    return give_address
