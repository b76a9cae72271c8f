"""Operators and built-in functions: arrays in, arrays out, and where GLSL leaves the result open.

A value is a float64, int64 or bool array whose last axis is the lane (one altitude, one cosine) and, for a vector,
whose first axis is the component; a length of 1 stands for all lanes. Whole numbers have 32 bits in GLSL: a result
beyond them is refused, never wrapped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.atmosphere.language.lexer import MAX_INT
from aomc_sky.atmosphere.language.nodes import Function, Type

Array = np.ndarray
Fault = tuple[Callable[..., Any], str]


@dataclass(frozen=True, kw_only=True, slots=True)
class BuiltIn:
    """A function of the language with its patterns of arguments."""

    function: Function
    patterns: tuple[str, ...]  #: one letter an argument: g a float or vector, the same for all g; f a float
    takes_int: bool = False  #: whole numbers stay whole numbers if all arguments are
    gives_float: bool = False  #: the result is a float whatever g is


def _beyond_int(law: Callable[..., Any]) -> Fault:
    return (lambda *values: np.abs(law(*values)) > MAX_INT), f"the whole number is beyond {MAX_INT}"


def _quotient(left: Array, right: Array) -> Array:
    # towards zero, as on every graphics card; a lane divided by 0 is refused where it counts
    divisor = np.where(right == 0, 1, right)
    return np.sign(left) * np.sign(divisor) * (np.abs(left) // np.abs(divisor))


def _remainder(left: Array, right: Array) -> Array:
    return left - right * _quotient(left, right)


_BY_ZERO: Fault = (lambda _, right: right == 0), "a whole number is divided by 0"
_OF_NEGATIVE: Fault = (lambda left, right: (left < 0) | (right < 0)), "% has no defined result for a negative number"

ARITHMETIC = {
    "+": Function(name="+", apply=np.add),
    "-": Function(name="-", apply=np.subtract),
    "*": Function(name="*", apply=np.multiply),
    "/": Function(name="/", apply=np.divide),
}
INTEGER_ARITHMETIC = {
    "+": Function(name="+", apply=np.add, faults=(_beyond_int(np.add),)),
    "-": Function(name="-", apply=np.subtract, faults=(_beyond_int(np.subtract),)),
    "*": Function(name="*", apply=np.multiply, faults=(_beyond_int(np.multiply),)),
    "/": Function(name="/", apply=_quotient, faults=(_BY_ZERO,)),
    "%": Function(name="%", apply=_remainder, faults=(_BY_ZERO, _OF_NEGATIVE)),
}
COMPARISON = {
    "<": Function(name="<", apply=np.less, decides=np.less),
    ">": Function(name=">", apply=np.greater, decides=np.greater),
    "<=": Function(name="<=", apply=np.less_equal, decides=np.less_equal),
    ">=": Function(name=">=", apply=np.greater_equal, decides=np.greater_equal),
}


def _equal(left: Array, right: Array) -> Array:
    same = np.equal(left, right)
    return same.all(axis=0) if same.ndim > 1 else same


def _different(left: Array, right: Array) -> Array:
    return ~_equal(left, right)


EQUALITY = {
    "==": Function(name="==", apply=_equal, decides=_equal),
    "!=": Function(name="!=", apply=_different, decides=_different),
}
EITHER = Function(name="^^", apply=np.logical_xor)
NEGATE = Function(name="-", apply=np.negative)
NOT = Function(name="!", apply=np.logical_not)


def _whole(value: Array) -> Array:
    inside = np.abs(value) <= MAX_INT
    return np.where(inside, np.trunc(value), 0).astype(np.int64)


_NO_INT: Fault = (lambda value: ~(np.abs(value) < MAX_INT + 1.0)), "the number does not fit into a whole number"
_TO_INT = Function(name="int", apply=_whole, faults=(_NO_INT,), decides=_whole)
_TO_FLOAT = Function(name="float", apply=lambda value: value.astype(np.float64))
_NOT_ZERO = Function(name="bool", apply=lambda value: value != 0, decides=lambda value: value != 0)

CONVERSIONS = {
    (Type.INT, Type.FLOAT): _TO_FLOAT,
    (Type.BOOL, Type.FLOAT): _TO_FLOAT,
    (Type.BOOL, Type.INT): Function(name="int", apply=lambda value: value.astype(np.int64)),
    (Type.FLOAT, Type.INT): _TO_INT,
    (Type.FLOAT, Type.BOOL): _NOT_ZERO,
    (Type.INT, Type.BOOL): _NOT_ZERO,
}


def vector_of(size: int) -> Function:
    """Return the constructor of a vector from its components, or from one number for all of them."""

    def build(*parts: Array) -> Array:
        rows = [row for part in parts for row in (part if part.ndim > 1 else part[None])]
        rows = rows * size if len(rows) == 1 else rows[:size]
        return np.stack(np.broadcast_arrays(*rows)).astype(np.float64, copy=False)

    return Function(name=f"vec{size}", apply=build)


def _sqr(x: Array) -> Array:
    return x * x


def _fract(x: Array) -> Array:
    return x - np.floor(x)


def _mod(x: Array, y: Array) -> Array:
    return x - y * np.floor(x / y)


def _clamp(x: Array, low: Array, high: Array) -> Array:
    return np.minimum(np.maximum(x, low), high)


def _mix(x: Array, y: Array, share: Array) -> Array:
    return x * (1.0 - share) + y * share


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


def _at_most(name: str) -> Fault:
    return (lambda x: np.abs(x) > 1.0), f"{name} has no value beyond -1 and 1"


def _between(x: Array, low: Array, high: Array) -> Array:
    return (x > low).astype(np.int64) + (x > high)


_POW_FAULTS: tuple[Fault, ...] = (
    ((lambda x, y: x < 0.0), "pow of a negative number has no defined value"),
    ((lambda x, y: (x == 0.0) & (y <= 0.0)), "pow of 0 needs a positive exponent"),
)
_CLAMP_FAULT: Fault = (lambda x, low, high: low > high), "the lower limit of clamp is above the upper one"
_NO_ANGLE: Fault = (lambda y, x: (x == 0) & (y == 0)), "atan of 0 and 0"
_NO_LENGTH: Fault = (lambda x: _length(x) == 0.0), "normalize has no value for length 0"
_STEP_FAULT: Fault = (lambda low, high, x: low >= high), "the first edge of smoothstep is not below the second"


def _real(name: str, apply: Callable[..., Any], *faults: Fault, decides: Callable[..., Any] | None = None) -> BuiltIn:
    return BuiltIn(function=Function(name=name, apply=apply, faults=faults, decides=decides), patterns=("g",))


def _of(name: str, apply: Callable[..., Any], *patterns: str, **more: Any) -> BuiltIn:
    flags = {key: more.pop(key) for key in ("takes_int", "gives_float") if key in more}
    return BuiltIn(function=Function(name=name, apply=apply, **more), patterns=patterns, **flags)


_ALL = (
    _real("sin", np.sin),
    _real("cos", np.cos),
    _real("tan", np.tan, decides=lambda x: np.floor(x / np.pi + 0.5)),
    _real("asin", np.arcsin, _at_most("asin")),
    _real("acos", np.arccos, _at_most("acos")),
    _real("sinh", np.sinh),
    _real("cosh", np.cosh),
    _real("tanh", np.tanh),
    _real("radians", lambda x: x * (np.pi / 180.0)),
    _real("degrees", lambda x: x * (180.0 / np.pi)),
    _real("exp", np.exp),
    _real("exp2", np.exp2),
    _real("log", np.log, ((lambda x: x <= 0.0), "log has no value for 0 and below")),
    _real("log2", np.log2, ((lambda x: x <= 0.0), "log2 has no value for 0 and below")),
    _real("sqrt", np.sqrt, ((lambda x: x < 0.0), "sqrt has no value for a negative number")),
    _real(
        "inversesqrt", lambda x: 1.0 / np.sqrt(x), ((lambda x: x <= 0.0), "inversesqrt has no value for 0 and below")
    ),
    _real("floor", np.floor, decides=np.floor),
    _real("ceil", np.ceil, decides=np.ceil),
    _real("trunc", np.trunc, decides=np.trunc),
    _real("fract", _fract, decides=np.floor),
    _real("normalize", lambda x: x / _length(x), _NO_LENGTH, decides=_side),
    _of("abs", np.abs, "g", takes_int=True, decides=np.sign),
    _of("sign", np.sign, "g", takes_int=True, decides=np.sign),
    _of("sqr", _sqr, "g", takes_int=True),
    _of("pow", np.power, "gg", faults=_POW_FAULTS),
    _of("mod", _mod, "gg", "gf", faults=(((lambda x, y: y == 0.0), "mod by 0"),), decides=lambda x, y: np.floor(x / y)),
    _of("min", np.minimum, "gg", "gf", takes_int=True, decides=np.less),
    _of("max", np.maximum, "gg", "gf", takes_int=True, decides=np.less),
    _of("clamp", _clamp, "ggg", "gff", takes_int=True, faults=(_CLAMP_FAULT,), decides=_between),
    _of("mix", _mix, "ggg", "ggf"),
    _of("step", lambda edge, x: (x >= edge).astype(np.float64), "gg", "fg", decides=np.greater),
    _of(
        "smoothstep",
        _smoothstep,
        "ggg",
        "ffg",
        faults=(_STEP_FAULT,),
        decides=lambda low, high, x: _between(x, low, high),
    ),
    _of("dot", _dot, "gg", gives_float=True),
    _of("length", _length, "g", gives_float=True, decides=_side),
    _of("distance", lambda x, y: _length(x - y), "gg", gives_float=True, decides=lambda x, y: _side(x - y)),
)
BUILT_INS: dict[str, tuple[BuiltIn, ...]] = {one.function.name: (one,) for one in _ALL}
# the only name with two laws: the quotient, or its two parts with their signs
BUILT_INS["atan"] = (
    _real("atan", np.arctan),
    _of("atan", np.arctan2, "gg", faults=(_NO_ANGLE,), decides=lambda y, x: (x < 0) * (1 + (y < 0))),
)


def resolve(name: str, given: tuple[Type, ...]) -> tuple[Function, tuple[Type, ...], Type] | None:
    """Law of a built-in for arguments of these types, the types it wants them in, and that of its result."""
    for one in BUILT_INS[name]:
        for pattern in one.patterns:
            expected = _match(pattern, given, one.takes_int)
            if expected is not None:
                general = expected[pattern.index("g")]
                return one.function, expected, Type.FLOAT if one.gives_float else general
    return None


def _match(pattern: str, given: tuple[Type, ...], takes_int: bool) -> tuple[Type, ...] | None:
    if len(pattern) != len(given) or Type.BOOL in given:
        return None
    if takes_int and set(given) == {Type.INT}:
        return given
    general = {
        Type.FLOAT if kind is Type.INT else kind for letter, kind in zip(pattern, given, strict=True) if letter == "g"
    }
    fixed = {kind for letter, kind in zip(pattern, given, strict=True) if letter == "f"}
    if len(general) != 1 or any(kind.is_vector for kind in fixed):
        return None
    kind = general.pop()
    return tuple(kind if letter == "g" else Type.FLOAT for letter in pattern)
