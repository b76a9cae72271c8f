"""The parameters of many cells from rows of a table to columns: number k of all photons side by side.

Vector loops read columns. From rows they would spend more instructions on turning them than on the photons. Here a
group of photons turns on its way from the table, in lanes of 16 bytes, which every vector unit turns in a few steps.
"""

from __future__ import annotations

from typing import Any

from aomc_sky.kernels.arithmetic.constants import SCRATCH_PHOTONS
from aomc_sky.kernels.jit import lowered

from llvmlite import ir
from numba.core import types

GROUP = 8
"""Photons that turn together."""

_LANE = 16
_ROW, _COLUMNS = 4, 7
_INDEX, _NUMBER = ir.IntType(64), ir.IntType(32)


def copy_group(words, place, slot, columns, j):
    """Write the parameters of the cells of the photons j to j + GROUP - 1 of a block to the columns of scratch memory.

    `place` has the positions of a slot's two rows in `words`, as `blocks.split_place` reads them. The columns, of
    SCRATCH_PHOTONS integers as wide as floats of the precision, are the first row and three numbers of the second.
    """
    numbers, half = words.view(columns.dtype), place.itemsize * 4
    for i in range(int(j), int(j) + GROUP):
        both = int(place[slot[i]])
        for k in range(_COLUMNS):
            row = both >> half if k < _ROW else both & (1 << half) - 1
            columns[k * SCRATCH_PHOTONS + i] = numbers[row * 8 // columns.itemsize + k % _ROW]


def _shuffled(builder: Any, a: Any, b: Any, order: list[int]) -> Any:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_NUMBER, len(order)), order))


def _joined(builder: Any, vectors: list[Any]) -> Any:
    """Vectors behind each other."""
    while len(vectors) > 1:
        order = list(range(2 * vectors[0].type.count))
        vectors = [_shuffled(builder, a, b, order) for a, b in zip(vectors[::2], vectors[1::2], strict=True)]
    return vectors[0]


def _zipped(builder: Any, a: Any, b: Any, per_lane: int) -> list[Any]:
    """Of the first halves of all lanes one number of a, one of b, and so on; and of the second halves."""
    n, half = a.type.count, per_lane // 2
    halves = [[lane + k for lane in range(0, n, per_lane) for k in range(at, at + half)] for at in (0, half)]
    return [_shuffled(builder, a, b, [i for k in order for i in (k, n + k)]) for order in halves]


def _turned(builder: Any, vectors: list[Any]) -> list[Any]:
    """From as many vectors as a lane has numbers, those in place k of each lane as vector k."""
    per_lane = len(vectors)
    if per_lane == 2:
        return _zipped(builder, *vectors, per_lane)
    even, odd = (_zipped(builder, *vectors[i::2], per_lane) for i in (0, 1))
    return [vector for pair in zip(even, odd, strict=True) for vector in _zipped(builder, *pair, per_lane)]


@lowered(
    copy_group,
    lambda words, place, slot, columns, j: types.void,
    types.Array,
    types.Array,
    types.Array,
    types.Array,
    types.Integer,
)
def _copy_group(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    words, place, slot, columns = (
        context.make_array(kind)(context, builder, value).data
        for kind, value in zip(signature.args[:4], values[:4], strict=True)
    )
    number = columns.type.pointee
    per_lane = _LANE * 8 // number.width
    lane, half = ir.VectorType(number, per_lane), place.type.pointee.width // 2
    starts: list[list[Any]] = [[], []]
    for i in range(GROUP):
        slot_number = builder.zext(builder.load(builder.gep(slot, [builder.add(values[4], _INDEX(i))])), _INDEX)
        both = builder.zext(builder.load(builder.gep(place, [slot_number])), _INDEX)
        starts[0].append(builder.lshr(both, _INDEX(half)))
        starts[1].append(builder.and_(both, _INDEX(2**half - 1)))
    for k in range(0, _COLUMNS, per_lane):
        lanes = []
        for start in starts[k // _ROW]:
            at = builder.gep(words, [builder.add(start, _INDEX(k % _ROW * number.width // 64))])
            lanes.append(builder.load(builder.bitcast(at, lane.as_pointer()), align=8))
        turned = _turned(builder, [_joined(builder, lanes[i::per_lane]) for i in range(per_lane)])
        for i, vector in enumerate(turned[: _COLUMNS - k]):
            at = builder.gep(columns, [builder.add(values[4], _INDEX((k + i) * SCRATCH_PHOTONS))])
            builder.store(vector, builder.bitcast(at, vector.type.as_pointer()), align=number.width // 8)
    return context.get_dummy_value()
