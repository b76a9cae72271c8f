"""What operators, functions and components make of the types of their operands: what GLSL takes, and nothing else.

Each rule takes operands whose types are settled and gives the node above them, or raises a RefusalError.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import numpy as np

from aomc_sky.atmosphere.language import functions, nodes
from aomc_sky.atmosphere.language.nodes import VECTORS, Function, Offsets, Type, Typed, fits, joined, of_arithmetic
from aomc_sky.atmosphere.language.refusal import RefusalError

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
    return _operation(value, functions.CONVERSIONS[value.type, expected], expected, value)


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
    return _operation(span, functions.NOT if operator == "!" else functions.NEGATE, value.type, value)


def chain(span: Offsets, operators: Sequence[str], operands: Sequence[Typed]) -> Typed:
    """Operands with operators of one precedence between them, worked out from the left."""
    if operators[0] in ("&&", "||", "^^"):
        return _truths(span, operators, operands)
    if operators[0] in functions.COMPARISON or operators[0] in functions.EQUALITY:
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
    typed, laws = tuple(operands), (functions.EITHER,) * len(operators)
    if operator == "^^":
        return nodes.Fold(start=span.start, end=span.end, type=Type.BOOL, operands=typed, functions=laws)
    return nodes.Logic(start=span.start, end=span.end, type=Type.BOOL, operands=typed, stops_at=operator == "||")


def _comparison(span: Offsets, operators: Sequence[str], operands: Sequence[Typed]) -> Typed:
    result = operands[0]
    for operator, right in zip(operators, operands[1:], strict=True):
        kind = joined(result.type, right.type)
        orders = operator in functions.COMPARISON
        if kind is None or (orders and not kind.is_number):
            found = f"{result.type.value} and {right.type.value}"
            advice = "join two comparisons by &&" if result.type is Type.BOOL else ""
            what = "two numbers" if orders else "two values of one type"
            raise RefusalError(span.start, right.end, f"{operator} compares {what}, not {found}", advice)
        function = functions.COMPARISON[operator] if orders else functions.EQUALITY[operator]
        result = _operation(span, function, Type.BOOL, converted(result, kind), converted(right, kind))
    return result


def arithmetic_law(operator: str, left: Type, right: Type, span: Offsets) -> tuple[Function, Type]:
    """What an arithmetic operator does to two types, and the type of the result."""
    kind = of_arithmetic(left, right)
    if operator == "%" and kind is not Type.INT:
        message = f"% takes two ints, not {left.value} and {right.value}"
        raise RefusalError(span.start, span.end, message, "write mod(x, y)")
    if kind is None:
        advice = "write cond ? a : b" if Type.BOOL in (left, right) else "take components of one number"
        raise RefusalError(span.start, span.end, f"{operator} does not join {left.value} and {right.value}", advice)
    table = functions.INTEGER_ARITHMETIC if kind is Type.INT else functions.ARITHMETIC
    return table[operator], kind


def choice(span: Offsets, cases: Sequence[tuple[Typed, Typed]], otherwise: Typed) -> Typed:
    """``a ? x : b ? y : z``: conditions, which are bools, with their values; and the last value."""
    kind: Type | None = otherwise.type
    for _, value in cases:
        kind = None if kind is None else joined(kind, value.type)
    if kind is None:
        found = ", ".join(one.type.value for one in [*(value for _, value in cases), otherwise])
        raise RefusalError(span.start, span.end, f"the values of ?: have different types: {found}", "write them alike")
    typed = tuple((condition, converted(value, kind)) for condition, value in cases)
    return nodes.Choose(start=span.start, end=span.end, type=kind, cases=typed, otherwise=converted(otherwise, kind))


def call(span: Offsets, name: str, arguments: Sequence[Typed]) -> Typed:
    """A function or a constructor with its arguments."""
    if name in {kind.value for kind in Type}:
        return _constructed(span, Type(name), arguments)
    if name not in functions.BUILT_INS:
        near = difflib.get_close_matches(name[:60], functions.BUILT_INS, n=1)
        advice = f"is {near[0]} meant?" if near else "the functions are listed in docs/formats/atmo_blocks.md"
        raise RefusalError(span.start, span.start + len(name), f"there is no function {name[:60]}", advice)
    found = functions.resolve(name, tuple(one.type for one in arguments))
    if found is None:
        raise _no_match(span, name, arguments)
    law, expected, kind = found
    given = tuple(converted(one, kind) for one, kind in zip(arguments, expected, strict=True))
    return _operation(span, law, kind, *given)


def _no_match(span: Offsets, name: str, arguments: Sequence[Typed]) -> RefusalError:
    numbers = sorted({len(pattern) for one in functions.BUILT_INS[name] for pattern in one.patterns})
    if len(arguments) not in numbers:
        expected = " or ".join(map(str, numbers))
        message = f"{name} takes {expected} argument{'s' if numbers != [1] else ''}, not {len(arguments)}"
        return RefusalError(span.start, span.end, message)
    vectors = [one.type.value for one in arguments if one.type.is_vector]
    advice = f"write {vectors[0]}(...) around the number" if len(vectors) < len(arguments) and vectors else ""
    found = ", ".join(one.type.value for one in arguments)
    return RefusalError(span.start, span.end, f"{name} does not take {found}: its values have one type", advice)


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
    return value if value.type is kind else _operation(span, functions.CONVERSIONS[value.type, kind], kind, value)


def _vector(span: Offsets, kind: Type, arguments: Sequence[Typed]) -> Typed:
    numbers = [_as_numbers(one) for one in arguments]
    sizes = [one.type.n_components for one in numbers]
    splat = len(numbers) == 1 and sizes == [1]
    if not splat and sum(sizes) < kind.n_components:
        message = f"{kind.value} has {kind.n_components} components, {sum(sizes)} are given"
        raise RefusalError(span.start, span.end, message, f"write one number for all, or {kind.n_components}")
    if sum(sizes[:-1]) >= kind.n_components:
        raise RefusalError(span.start, span.end, f"the last value has no place among the components of {kind.value}")
    return _operation(span, functions.vector_of(kind.n_components), kind, *numbers)


def _as_numbers(value: Typed) -> Typed:
    if value.type in (Type.INT, Type.BOOL):
        return _operation(value, functions.CONVERSIONS[value.type, Type.FLOAT], Type.FLOAT, value)
    return value


def member(span: Offsets, base: Typed, letters: str) -> Typed:
    """The components that letters such as ``xyz`` name."""
    kind, start = base.type, span.end - len(letters)
    if not kind.is_vector:
        raise RefusalError(start, span.end, f"{a(kind)} has no components", "only vectors have them")
    for known in _LETTER_SETS:
        found = tuple(known.find(letter) for letter in letters)
        if min(found) >= 0 and max(found) < kind.n_components and len(found) <= 4:
            return _picked(span, base, found)
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
        raise RefusalError(index.start, index.end, message, f"they are counted from 0 to {size - 1}")
    return _picked(span, base, (component,))
