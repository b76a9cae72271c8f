"""Arguments of a kernel behind one address, so that code outside Python can hand them to it.

A *block* is an array of 64-bit words. Behind a head of two words that say whose it is, a number takes one
word, an array two (where it lies, its length), a tuple the words of its parts; an option (None or True)
takes none, because it is a type to the compiler. The types of the arguments are part of the block's own.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import config, types
from numba.extending import intrinsic, models, register_model
from numba.np.arrayobj import make_array, populate_array

HEAD_WORDS = 2

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


class Block(types.Type):
    """The address of a block whose arguments have given types."""

    def __init__(self, kinds: tuple[Any, ...]) -> None:
        self.kinds = types.Tuple(kinds)
        super().__init__(name=f"Block({self.kinds})")


register_model(Block)(models.OpaqueModel)


class _Words:
    """Emits loads of consecutive words, from the first argument on."""

    def __init__(self, builder: Any, address: Any) -> None:
        self.builder, self.place = builder, HEAD_WORDS
        self.base = builder.bitcast(address, _WORD.as_pointer())
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
        width = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        data = builder.inttoptr(data, array.data.type)
        populate_array(array, data=data, shape=[size], strides=[width], itemsize=width, meminfo=None)
        return array._getvalue()
    return words.load()


@intrinsic
def block_arguments(typing_context, block):
    """The tuple of arguments that stands behind the head of a block."""

    def generate(context, builder, signature, arguments):
        return _value(context, builder, block.kinds, _Words(builder, arguments[0]))

    return block.kinds(block), generate


@intrinsic
def block_head(typing_context, block):
    """The first two words of a block, uint64, as they are now."""
    answer = types.UniTuple(types.uint64, HEAD_WORDS)

    def generate(context, builder, signature, arguments):
        base = builder.bitcast(arguments[0], _WORD.as_pointer())
        words = [builder.load(builder.gep(base, [ir.Constant(_WORD, k)])) for k in range(HEAD_WORDS)]
        return context.make_tuple(builder, answer, words)

    return answer(block), generate


@intrinsic
def is_null(typing_context, pointer):
    """Whether a block or another pointer is NULL."""

    def generate(context, builder, signature, arguments):
        return builder.icmp_unsigned("==", arguments[0], ir.Constant(arguments[0].type, None))

    return types.boolean(pointer), generate


def fixed_block(kinds: tuple[Any, ...], address: int) -> Any:
    """Return a jitted function without arguments that gives a block at an address of this process.

    numba knows such an address as one that another process does not have: a function that uses it is not
    cached on disk, also when its author asks for that.
    """
    answer = Block(kinds)

    @intrinsic
    def give_block(typing_context):
        def generate(context, builder, signature, arguments):
            return context.add_dynamic_addr(builder, address, info="tables of a photon source")

        return answer(), generate

    return give_block
