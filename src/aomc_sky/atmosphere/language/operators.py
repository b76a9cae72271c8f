"""Operators and built-in functions: what they do to arrays, and what they make of the types of their operands.

A value is a float64, int64 or bool array whose last axis is the lane (one altitude, one cosine) and, for a vector,
whose first axis is the component; a length of 1 stands for all lanes. Whole numbers have 32 bits in GLSL: a result
beyond them is refused, never wrapped. GLSL decides which types an operator takes; where it leaves a result open, the
lanes that meet it are refused.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.atmosphere.language import nodes
from aomc_sky.atmosphere.language.lexer import MAX_INT, RefusalError
from aomc_sky.atmosphere.language.nodes import VECTORS, Function, Offsets, Type, Typed, fits, joined, of_arithmetic

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
_NO_ANGLE: Fault = (lambda y, x: (x == 0) & (y == 0)), "atan has no value for 0 and 0"
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
    _of(
        "mod",
        _mod,
        "gg",
        "gf",
        faults=(((lambda x, y: y == 0.0), "mod has no value for a divisor of 0"),),
        decides=lambda x, y: np.floor(x / y),
    ),
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


_LETTER_SETS = ("xyzw", "rgba", "stpq")
_KINDS = {Type.BOOL: np.bool_, Type.INT: np.int64, Type.FLOAT: np.float64}


def a(kind: Type) -> str:
    """The type with its article."""
    return f"an {kind.value}" if kind is Type.INT else f"a {kind.value}"


def as_type(span: Offsets, value: Typed, expected: Type, what: str) -> Typed:
    """The value in one type; whole numbers become real ones where those are expected."""
    if fits(value.type, expected):
        return converted(value, expected)
    message = f"{what} is {a(value.type)}, not {a(expected)}"
    raise RefusalError(span.start, span.end, message, _way(value.type, expected))


def _way(given: Type, expected: Type) -> str:
    if expected is Type.BOOL:
        return "write a comparison"
    if given is Type.BOOL or not given.is_vector:
        return f"write {expected.value}(...) around it"
    if expected.is_number:
        return "take a component of it: .x"
    return f"a {expected.value} has {expected.n_components} components"


def converted(value: Typed, expected: Type) -> Typed:
    """The value in a type that it fits into."""
    if value.type is expected:
        return value
    if isinstance(value, nodes.Constant):
        return nodes.Constant(
            start=value.start, end=value.end, type=expected, value=value.value.astype(_KINDS[expected])
        )
    return _operation(value, CONVERSIONS[value.type, expected], expected, value)


def _operation(span: Offsets | Typed, function: Function, kind: Type, *operands: Typed) -> nodes.Operation:
    return nodes.Operation(start=span.start, end=span.end, type=kind, function=function, operands=operands)


def number(span: Offsets, kind: Type, value: float) -> Typed:
    """A literal."""
    return nodes.Constant(start=span.start, end=span.end, type=kind, value=np.full(1, value, dtype=_KINDS[kind]))


def unary(span: Offsets, operator: str, value: Typed) -> Typed:
    """``+``, ``-`` or ``!`` before a value."""
    if (operator == "!") is not (value.type is Type.BOOL):
        expected = "a bool" if operator == "!" else "a number"
        raise RefusalError(span.start, span.end, f"{operator} takes {expected}, not {a(value.type)}")
    if operator == "+":
        return value
    return _operation(span, NOT if operator == "!" else NEGATE, value.type, value)


def chain(span: Offsets, operators: Sequence[str], operands: Sequence[Typed]) -> Typed:
    """Operands with operators of one precedence between them, worked out from the left."""
    if operators[0] in ("&&", "||", "^^"):
        return _truths(span, operators, operands)
    if operators[0] in COMPARISON or operators[0] in EQUALITY:
        return _comparison(span, operators, operands)
    kind, laws = operands[0].type, []
    for operator, right in zip(operators, operands[1:], strict=True):
        law, kind = arithmetic_law(operator, kind, right.type, Offsets(span.start, right.end))
        laws.append(law)
    return nodes.Fold(start=span.start, end=span.end, type=kind, operands=tuple(operands), functions=tuple(laws))


def _truths(span: Offsets, operators: Sequence[str], operands: Sequence[Typed]) -> Typed:
    operator = operators[0]
    for one in operands:
        if one.type is not Type.BOOL:
            raise RefusalError(one.start, one.end, f"{operator} takes bools, not {a(one.type)}", "write a comparison")
    typed, laws = tuple(operands), (EITHER,) * len(operators)
    if operator == "^^":
        return nodes.Fold(start=span.start, end=span.end, type=Type.BOOL, operands=typed, functions=laws)
    return nodes.Logic(start=span.start, end=span.end, type=Type.BOOL, operands=typed, stops_at=operator == "||")


def _comparison(span: Offsets, operators: Sequence[str], operands: Sequence[Typed]) -> Typed:
    result = operands[0]
    for operator, right in zip(operators, operands[1:], strict=True):
        kind = joined(result.type, right.type)
        orders = operator in COMPARISON
        if kind is None or (orders and not kind.is_number):
            kinds = f"{result.type.value} and {right.type.value}"
            advice = "join two comparisons by &&" if result.type is Type.BOOL else ""
            what = "two numbers" if orders else "two values of one type"
            raise RefusalError(span.start, right.end, f"{operator} compares {what}, not {kinds}", advice)
        function = COMPARISON[operator] if orders else EQUALITY[operator]
        result = _operation(span, function, Type.BOOL, converted(result, kind), converted(right, kind))
    return result


def arithmetic_law(operator: str, left: Type, right: Type, span: Offsets) -> tuple[Function, Type]:
    """What an arithmetic operator does to two types, and the type of the result."""
    kind = of_arithmetic(left, right)
    if operator == "%" and kind is not Type.INT:
        message = f"% takes two ints, not {left.value} and {right.value}"
        raise RefusalError(span.start, span.end, message, "write mod(x, y)")
    if kind is None:
        advice = (
            "write cond ? a : b" if Type.BOOL in (left, right) else "use vectors of one size, or a component such as .x"
        )
        raise RefusalError(span.start, span.end, f"{operator} cannot combine {left.value} and {right.value}", advice)
    table = INTEGER_ARITHMETIC if kind is Type.INT else ARITHMETIC
    return table[operator], kind


def choice(span: Offsets, cases: Sequence[tuple[Typed, Typed]], otherwise: Typed) -> Typed:
    """``a ? x : b ? y : z``: conditions, which are bools, with their values; and the last value."""
    kind: Type | None = otherwise.type
    for _, value in cases:
        kind = None if kind is None else joined(kind, value.type)
    if kind is None:
        kinds = ", ".join(one.type.value for one in [*(value for _, value in cases), otherwise])
        raise RefusalError(
            span.start, span.end, f"the values of ?: have different types: {kinds}", "write values of one type"
        )
    typed = tuple((condition, converted(value, kind)) for condition, value in cases)
    return nodes.Choose(start=span.start, end=span.end, type=kind, cases=typed, otherwise=converted(otherwise, kind))


def call(span: Offsets, name: str, arguments: Sequence[Typed]) -> Typed:
    """A function or a constructor with its arguments."""
    if name in {kind.value for kind in Type}:
        return _constructed(span, Type(name), arguments)
    if name not in BUILT_INS:
        near = difflib.get_close_matches(name[:60], BUILT_INS, n=1)
        advice = f"is {near[0]} meant?" if near else "the functions are listed in docs/formats/atmo_blocks.md"
        raise RefusalError(span.start, span.start + len(name), f"there is no function {name[:60]}", advice)
    overload = resolve(name, tuple(one.type for one in arguments))
    if overload is None:
        raise _no_match(span, name, arguments)
    law, expected, kind = overload
    given = tuple(converted(one, kind) for one, kind in zip(arguments, expected, strict=True))
    return _operation(span, law, kind, *given)


def _no_match(span: Offsets, name: str, arguments: Sequence[Typed]) -> RefusalError:
    numbers = sorted({len(pattern) for one in BUILT_INS[name] for pattern in one.patterns})
    if len(arguments) not in numbers:
        expected = " or ".join(map(str, numbers))
        message = f"{name} takes {expected} argument{'s' if numbers != [1] else ''}, not {len(arguments)}"
        return RefusalError(span.start, span.end, message)
    vectors = [one.type.value for one in arguments if one.type.is_vector]
    advice = f"write {vectors[0]}(...) around the number" if len(vectors) < len(arguments) and vectors else ""
    kinds = ", ".join(one.type.value for one in arguments)
    return RefusalError(span.start, span.end, f"{name} does not take {kinds}: its values have one type", advice)


def _constructed(span: Offsets, kind: Type, arguments: Sequence[Typed]) -> Typed:
    if not arguments:
        raise RefusalError(span.start, span.end, f"{kind.value}() has no value between its brackets")
    if kind.is_vector:
        return _vector(span, kind, arguments)
    if len(arguments) > 1:
        raise RefusalError(span.start, span.end, f"{kind.value}() takes one value, not {len(arguments)}")
    value = arguments[0]
    if value.type.is_vector:
        value = nodes.Pick(start=value.start, end=value.end, type=Type.FLOAT, base=value, components=(0,))
    return value if value.type is kind else _operation(span, CONVERSIONS[value.type, kind], kind, value)


def _vector(span: Offsets, kind: Type, arguments: Sequence[Typed]) -> Typed:
    numbers = [_as_numbers(one) for one in arguments]
    sizes = [one.type.n_components for one in numbers]
    splat = len(numbers) == 1 and sizes == [1]
    if not splat and sum(sizes) < kind.n_components:
        message = f"{kind.value} has {kind.n_components} components, {sum(sizes)} are given"
        raise RefusalError(span.start, span.end, message, f"write one number for all, or {kind.n_components}")
    if sum(sizes[:-1]) >= kind.n_components:
        raise RefusalError(span.start, span.end, f"there are more values than components of {kind.value}")
    return _operation(span, vector_of(kind.n_components), kind, *numbers)


def _as_numbers(value: Typed) -> Typed:
    if value.type in (Type.INT, Type.BOOL):
        return _operation(value, CONVERSIONS[value.type, Type.FLOAT], Type.FLOAT, value)
    return value


def member(span: Offsets, base: Typed, letters: str) -> Typed:
    """The components that letters such as ``xyz`` name."""
    kind, start = base.type, span.end - len(letters)
    if not kind.is_vector:
        raise RefusalError(start, span.end, f"{a(kind)} has no components", "only vectors have them")
    for known in _LETTER_SETS:
        components = tuple(known.find(letter) for letter in letters)
        if min(components) >= 0 and max(components) < kind.n_components and len(components) <= 4:
            return _picked(span, base, components)
    known = ", ".join(one[: kind.n_components] for one in _LETTER_SETS)
    message = f".{letters[:40]} names no components of {a(kind)}"
    raise RefusalError(start, span.end, message, f"one to four letters of {known}")


def _picked(span: Offsets, base: Typed, components: tuple[int, ...]) -> Typed:
    kind = VECTORS.get(len(components), Type.FLOAT)
    if isinstance(base, nodes.Read):
        if base.components is not None:
            components = tuple(base.components[one] for one in components)
        return nodes.Read(
            start=span.start, end=span.end, type=kind, slot=base.slot, components=components, name=base.name
        )
    return nodes.Pick(start=span.start, end=span.end, type=kind, base=base, components=components)


def at_index(span: Offsets, base: Typed, index_span: Offsets, index: Typed) -> Typed:
    """The component of a vector that a whole number names; one that is a literal is looked at here."""
    is_literal = isinstance(index, nodes.Constant) and (index.start, index.end) == (index_span.start, index_span.end)
    if not (is_literal and index.type is Type.INT):
        index = as_type(index_span, index, Type.INT, "an index")
        return nodes.PickAt(start=span.start, end=span.end, type=Type.FLOAT, base=base, index=index)
    assert isinstance(index, nodes.Constant)
    size, component = base.type.n_components, int(index.value[0])
    if component >= size:
        message = f"{a(base.type)} has no component {component}"
        raise RefusalError(index.start, index.end, message, f"components are counted from 0 to {size - 1}")
    return _picked(span, base, (component,))
