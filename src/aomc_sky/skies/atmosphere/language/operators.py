"""Operators and built-in functions: what they do to arrays, and what they make of the types of their operands.

The types are those of GLSL. A result that GLSL leaves open is NaN here, and `Run` refuses it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.skies.atmosphere.language.values import Array, Function, Type

Law = Callable[..., Any]


def _equal(left: Array, right: Array) -> Array:
    same = np.equal(left, right)
    return same.all(axis=0) if same.ndim > 1 else same


ARITHMETIC = {
    "+": Function("+", np.add),
    "-": Function("-", np.subtract),
    "*": Function("*", np.multiply),
    "/": Function("/", np.divide),
}
# towards zero, as on every graphics card
WHOLE_QUOTIENT = Function("/", lambda left, right: np.trunc(left / right))
ORDERS = {
    "<": Function("<", np.less, np.less),
    ">": Function(">", np.greater, np.greater),
    "<=": Function("<=", np.less_equal, np.less_equal),
    ">=": Function(">=", np.greater_equal, np.greater_equal),
}
EQUALITY = {
    "==": Function("==", _equal, _equal),
    "!=": Function("!=", lambda left, right: ~_equal(left, right), _equal),
}
SIGNS = {"-": Function("-", np.negative), "+": Function("+", np.positive), "!": Function("!", np.logical_not)}


def arithmetic(operator: str, left: Type, right: Type) -> tuple[Function, Type] | None:
    """Return the function of an operator for two types, and the type of the result; or None, as GLSL has none."""
    if Type.BOOL in (left, right) or (left.is_vector and right.is_vector and left is not right):
        return None
    if left is right is Type.INT:
        return (WHOLE_QUOTIENT if operator == "/" else ARITHMETIC[operator]), Type.INT
    vectors = [kind for kind in (left, right) if kind.is_vector]
    return ARITHMETIC[operator], vectors[0] if vectors else Type.FLOAT


def constructor(kind: Type) -> Function:
    """Return the function that makes a value of a type from numbers and truths."""

    def build(*parts: Array) -> Array:
        rows = [row for part in parts for row in (part if part.ndim > 1 else part[None])]
        if kind.is_vector:
            rows = rows * kind.size if len(rows) == 1 else rows[: kind.size]
            return np.stack(np.broadcast_arrays(*rows)).astype(np.float64, copy=False)
        if kind is Type.FLOAT:
            return rows[0].astype(np.float64)
        return rows[0] != 0 if kind is Type.BOOL else np.trunc(rows[0])

    return Function(kind.value, build, build if kind in (Type.BOOL, Type.INT) else None)


@dataclass(frozen=True, kw_only=True, slots=True)
class BuiltIn:
    """A function of the language with its patterns of arguments."""

    function: Function
    patterns: tuple[str, ...]  #: one letter an argument: g a float or vector, the same for all g; f a float
    takes_int: bool  #: whole numbers stay whole numbers if all arguments are
    gives_float: bool  #: the result is a float whatever g is

    def resolve(self, given: Sequence[Type]) -> Type | None:
        """Type of the result for arguments of these types, or None if it does not take them."""
        for pattern in self.patterns:
            if len(pattern) != len(given) or Type.BOOL in given:
                continue
            if self.takes_int and set(given) == {Type.INT}:
                return Type.INT
            kinds = [Type.FLOAT if kind is Type.INT else kind for kind in given]
            general = {kind for letter, kind in zip(pattern, kinds, strict=True) if letter == "g"}
            vectors = [kind for letter, kind in zip(pattern, kinds, strict=True) if letter == "f" and kind.is_vector]
            if len(general) == 1 and not vectors:
                return Type.FLOAT if self.gives_float else general.pop()
        return None


def _within(domain: Law, law: Law) -> Law:
    return lambda *values: np.where(domain(*values), law(*values), np.nan)


def _positive(law: Law) -> Law:
    return _within(lambda x: x > 0.0, law)


def _arctan(y: Array, x: Array | None = None) -> Array:
    return np.arctan(y) if x is None else np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x))


def _min(x: Array, y: Array) -> Array:
    return np.where(y < x, y, x)  # GLSL's; of 0 and -0 the first, where np.minimum asks the processor


def _max(x: Array, y: Array) -> Array:
    return np.where(x < y, y, x)


def _clamp(x: Array, low: Array, high: Array) -> Array:
    return _min(_max(x, low), high)


def _smoothstep(low: Array, high: Array, x: Array) -> Array:
    t = _clamp((x - low) / (high - low), np.zeros(1), np.ones(1))
    return t * t * (3.0 - 2.0 * t)


def _dot(x: Array, y: Array) -> Array:
    product = x * y
    return product.sum(axis=0) if product.ndim > 1 else product


def _length(x: Array) -> Array:
    return np.sqrt(_dot(x, x)) if x.ndim > 1 else np.abs(x)


def _side(x: Array) -> Array:
    # the length of a number is its absolute value; that of a vector bends at its origin alone
    return np.sign(x) if x.ndim == 1 else np.zeros(1)


def _between(x: Array, low: Array, high: Array) -> Array:
    return (x > low).astype(np.int64) + (x > high)


_BUILT_INS: tuple[tuple[str, str, Law, Law | None], ...] = (
    # name, patterns (i: takes whole numbers, s: gives a scalar), law, decisions
    ("sin", "g", np.sin, None),
    ("cos", "g", np.cos, None),
    ("tan", "g", np.tan, lambda x: np.floor(x / np.pi + 0.5)),
    ("asin", "g", np.arcsin, None),
    ("acos", "g", np.arccos, None),
    ("atan", "g gg", _arctan, lambda y, x=1.0: (x < 0) * (1 + (y < 0))),
    ("sinh", "g", np.sinh, None),
    ("cosh", "g", np.cosh, None),
    ("tanh", "g", np.tanh, None),
    ("radians", "g", lambda x: x * (np.pi / 180.0), None),
    ("degrees", "g", lambda x: x * (180.0 / np.pi), None),
    ("exp", "g", np.exp, None),
    ("exp2", "g", np.exp2, None),
    ("log", "g", _positive(np.log), None),
    ("log2", "g", _positive(np.log2), None),
    ("sqrt", "g", np.sqrt, None),
    ("inversesqrt", "g", _positive(lambda x: 1.0 / np.sqrt(x)), None),
    ("floor", "g", np.floor, np.floor),
    ("ceil", "g", np.ceil, np.ceil),
    ("trunc", "g", np.trunc, np.trunc),
    ("fract", "g", lambda x: x - np.floor(x), np.floor),
    ("normalize", "g", lambda x: x / _length(x), _side),
    ("abs", "g i", np.abs, np.sign),
    ("sign", "g i", np.sign, np.sign),
    ("sqr", "g i", lambda x: x * x, None),
    ("pow", "gg", _within(lambda x, y: (x > 0.0) | ((x == 0.0) & (y > 0.0)), np.power), None),
    ("mod", "gg gf", lambda x, y: x - y * np.floor(x / y), lambda x, y: np.floor(x / y)),
    ("min", "gg gf i", _min, np.less),
    ("max", "gg gf i", _max, np.less),
    ("clamp", "ggg gff i", _within(lambda x, low, high: low <= high, _clamp), _between),
    ("mix", "ggg ggf", lambda x, y, share: x * (1.0 - share) + y * share, None),
    ("step", "gg fg", lambda edge, x: (x >= edge).astype(np.float64), np.greater),
    (
        "smoothstep",
        "ggg ffg",
        _within(lambda low, high, x: low < high, _smoothstep),
        lambda low, high, x: _between(x, low, high),
    ),
    ("dot", "gg s", _dot, None),
    ("length", "g s", _length, _side),
    ("distance", "gg s", lambda x, y: _length(x - y), lambda x, y: _side(x - y)),
)
BUILT_INS = {
    name: BuiltIn(
        function=Function(name, law, decides),
        patterns=tuple(one for one in patterns.split() if one not in ("i", "s")),
        takes_int="i" in patterns,
        gives_float="s" in patterns,
    )
    for name, patterns, law, decides in _BUILT_INS
}
