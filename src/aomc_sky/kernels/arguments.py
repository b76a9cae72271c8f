"""Arguments behind an address, as compiled code reads them: the other half of `machine_code`."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import from_dtype
from numba.core import types
from numba.extending import intrinsic, models, register_model
from numba.np.arrayobj import make_array, populate_array

from aomc_sky.kernels.machine_code import HEAD_WORDS, Kind

_WORD = ir.IntType(64)


def _typed(kind: Kind) -> Any:
    if kind is None:
        return types.none
    if isinstance(kind, tuple):
        return types.Tuple(tuple(map(_typed, kind)))
    if kind == "True":
        return types.boolean
    name, bracket, layout = kind.partition("[")
    number = from_dtype(np.dtype(name))
    return types.Array(number, 1, "C" if layout == "]" else "A") if bracket else number


class Block(types.Type):
    """The address of a block whose arguments have given types."""

    def __init__(self, kinds: tuple[Kind, ...]) -> None:
        self.kinds = _typed(kinds)
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
        stride = None if kind.layout == "C" else words.load()
        width = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        data = builder.inttoptr(data, array.data.type)
        populate_array(array, data=data, shape=[size], strides=[stride or width], itemsize=width, meminfo=None)
        return array._getvalue()
    word, number = words.load(), context.get_value_type(kind)
    bits = ir.IntType(context.get_abi_sizeof(number) * 8)
    word = word if bits == _WORD else builder.trunc(word, bits)
    return builder.bitcast(word, number) if isinstance(kind, types.Float) else word


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


def fixed_block(kinds: tuple[Kind, ...], address: int) -> Any:
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
