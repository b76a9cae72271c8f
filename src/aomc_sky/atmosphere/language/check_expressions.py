"""Types of expressions: what GLSL takes, and nothing else."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from typing import Any

import numpy as np

from aomc_sky.atmosphere.language import functions, program, syntax
from aomc_sky.atmosphere.language.functions import Function
from aomc_sky.atmosphere.language.refusal import RefusalError
from aomc_sky.atmosphere.language.scope import Scope
from aomc_sky.atmosphere.language.types import VECTORS, Type, fits, joined, of_arithmetic

_LETTER_SETS = ("xyzw", "rgba", "stpq")
_KINDS = {Type.BOOL: np.bool_, Type.INT: np.int64, Type.FLOAT: np.float64}


def checked(node: syntax.Node, scope: Scope) -> program.Typed:
    """Return the expression with its type, or refuse it.

    Parameters
    ----------
    node : Node
        An expression of the syntax tree.
    scope : Scope
        Names it may read.

    Raises
    ------
    RefusalError
        At the first operator, function or name that does not take what it is given.
    """
    return _CHECKS[type(node)](node, scope)


def checked_as(node: syntax.Node, scope: Scope, wanted: Type, what: str) -> program.Typed:
    """Return the expression as a value of one type; whole numbers become real ones where those are wanted."""
    value = checked(node, scope)
    if fits(value.type, wanted):
        return converted(value, wanted)
    message = f"{what} is {a(value.type)}, not {a(wanted)}"
    raise RefusalError(node.start, node.end, message, _way(value.type, wanted))


def a(kind: Type) -> str:
    """Return the type with its article."""
    return f"an {kind.value}" if kind is Type.INT else f"a {kind.value}"


def _way(given: Type, wanted: Type) -> str:
    if wanted is Type.BOOL:
        return "write a comparison"
    if given is Type.BOOL or not given.is_vector:
        return f"write {wanted.value}(...) around it"
    return (
        "take a component of it: .x" if wanted.is_number else f"a {wanted.value} has {wanted.n_components} components"
    )


def converted(value: program.Typed, wanted: Type) -> program.Typed:
    """Return the value in a type that it fits into."""
    if value.type is wanted:
        return value
    if isinstance(value, program.Constant):
        return program.Constant(start=value.start, end=value.end, type=wanted, value=value.value.astype(_KINDS[wanted]))
    return _operation(value, functions.CONVERSIONS[value.type, wanted], wanted, value)


def _operation(place: Any, function: Function, kind: Type, *operands: program.Typed) -> program.Operation:
    return program.Operation(start=place.start, end=place.end, type=kind, function=function, operands=operands)


def _number(node: syntax.Number, scope: Scope) -> program.Typed:
    value: np.ndarray = np.full(1, node.value, dtype=_KINDS[node.type])
    return program.Constant(start=node.start, end=node.end, type=node.type, value=value)


def _name(node: syntax.Name, scope: Scope) -> program.Typed:
    variable = scope.find(node)
    return program.Read(
        start=node.start, end=node.end, type=variable.type, slot=variable.slot, components=None, name=node.name
    )


def _unary(node: syntax.Unary, scope: Scope) -> program.Typed:
    value = checked(node.operand, scope)
    if (node.operator == "!") is not (value.type is Type.BOOL):
        wanted = "a bool" if node.operator == "!" else "a number"
        raise RefusalError(node.start, node.end, f"{node.operator} takes {wanted}, not {a(value.type)}")
    if node.operator == "+":
        return value
    return _operation(node, functions.NOT if node.operator == "!" else functions.NEGATE, value.type, value)


def _chain(node: syntax.Chain, scope: Scope) -> program.Typed:
    operands = [checked(one, scope) for one in node.operands]
    if node.operators[0] in ("&&", "||", "^^"):
        return _truths(node, operands)
    if node.operators[0] in functions.COMPARISON or node.operators[0] in functions.EQUALITY:
        return _comparison(node, operands)
    return _arithmetic(node, operands)


def _truths(node: syntax.Chain, operands: list[program.Typed]) -> program.Typed:
    operator = node.operators[0]
    for one in operands:
        if one.type is not Type.BOOL:
            raise RefusalError(one.start, one.end, f"{operator} takes bools, not {a(one.type)}", "write a comparison")
    typed, laws = tuple(operands), (functions.EITHER,) * len(node.operators)
    if operator == "^^":
        return program.Fold(start=node.start, end=node.end, type=Type.BOOL, operands=typed, functions=laws)
    return program.Logic(start=node.start, end=node.end, type=Type.BOOL, operands=typed, stops_at=operator == "||")


def _comparison(node: syntax.Chain, operands: list[program.Typed]) -> program.Typed:
    result = operands[0]
    for operator, right in zip(node.operators, operands[1:], strict=True):
        kind = joined(result.type, right.type)
        orders = operator in functions.COMPARISON
        if kind is None or (orders and not kind.is_number):
            found = f"{result.type.value} and {right.type.value}"
            advice = "join two comparisons by &&" if result.type is Type.BOOL else ""
            what = "two numbers" if orders else "two values of one type"
            raise RefusalError(node.start, right.end, f"{operator} compares {what}, not {found}", advice)
        function = functions.COMPARISON[operator] if orders else functions.EQUALITY[operator]
        result = _operation(node, function, Type.BOOL, converted(result, kind), converted(right, kind))
    return result


def _arithmetic(node: syntax.Chain, operands: list[program.Typed]) -> program.Typed:
    kind, laws = operands[0].type, []
    for operator, right in zip(node.operators, operands[1:], strict=True):
        law, kind = arithmetic_law(operator, kind, right.type, node.start, right.end)
        laws.append(law)
    return program.Fold(start=node.start, end=node.end, type=kind, operands=tuple(operands), functions=tuple(laws))


def arithmetic_law(operator: str, left: Type, right: Type, start: int, end: int) -> tuple[Function, Type]:
    """Return what an arithmetic operator does to two types, and the type of the result."""
    kind = of_arithmetic(left, right)
    if operator == "%" and kind is not Type.INT:
        raise RefusalError(start, end, f"% takes two ints, not {left.value} and {right.value}", "write mod(x, y)")
    if kind is None:
        advice = "write cond ? a : b" if Type.BOOL in (left, right) else "take components of one number"
        raise RefusalError(start, end, f"{operator} does not join {left.value} and {right.value}", advice)
    table = functions.INTEGER_ARITHMETIC if kind is Type.INT else functions.ARITHMETIC
    return table[operator], kind


def _choice(node: syntax.Choice, scope: Scope) -> program.Typed:
    cases = [(checked_as(one, scope, Type.BOOL, "the condition"), checked(value, scope)) for one, value in node.cases]
    otherwise = checked(node.otherwise, scope)
    kind: Type | None = otherwise.type
    for _, value in cases:
        kind = None if kind is None else joined(kind, value.type)
    if kind is None:
        found = ", ".join(one.type.value for one in [*(value for _, value in cases), otherwise])
        raise RefusalError(node.start, node.end, f"the values of ?: have different types: {found}", "write them alike")
    typed = tuple((condition, converted(value, kind)) for condition, value in cases)
    return program.Choose(start=node.start, end=node.end, type=kind, cases=typed, otherwise=converted(otherwise, kind))


def _call(node: syntax.Call, scope: Scope) -> program.Typed:
    arguments = [checked(one, scope) for one in node.arguments]
    if node.name in {kind.value for kind in Type}:
        return _constructed(node, Type(node.name), arguments)
    if node.name not in functions.BUILT_INS:
        near = difflib.get_close_matches(node.name[:60], functions.BUILT_INS, n=1)
        advice = f"is {near[0]} meant?" if near else "the functions are listed in docs/formats/atmo_blocks.md"
        raise RefusalError(node.start, node.start + len(node.name), f"there is no function {node.name[:60]}", advice)
    found = functions.resolve(node.name, tuple(one.type for one in arguments))
    if found is None:
        raise _no_match(node, arguments)
    law, wanted, kind = found
    given = tuple(converted(one, kind) for one, kind in zip(arguments, wanted, strict=True))
    return _operation(node, law, kind, *given)


def _no_match(node: syntax.Call, arguments: list[program.Typed]) -> RefusalError:
    numbers = sorted({len(pattern) for one in functions.BUILT_INS[node.name] for pattern in one.patterns})
    if len(arguments) not in numbers:
        wanted = " or ".join(map(str, numbers))
        message = f"{node.name} takes {wanted} argument{'s' if numbers != [1] else ''}, not {len(arguments)}"
        return RefusalError(node.start, node.end, message)
    vectors = [one.type.value for one in arguments if one.type.is_vector]
    advice = f"write {vectors[0]}(...) around the number" if len(vectors) < len(arguments) and vectors else ""
    found = ", ".join(one.type.value for one in arguments)
    return RefusalError(node.start, node.end, f"{node.name} does not take {found}: its values have one type", advice)


def _constructed(node: syntax.Call, kind: Type, arguments: list[program.Typed]) -> program.Typed:
    if not arguments:
        raise RefusalError(node.start, node.end, f"{kind.value}() has no value between its brackets")
    if kind.is_vector:
        return _vector(node, kind, arguments)
    if len(arguments) > 1:
        raise RefusalError(node.start, node.end, f"{kind.value}() takes one value, not {len(arguments)}")
    value = arguments[0]
    if value.type.is_vector:
        value = program.Pick(start=value.start, end=value.end, type=Type.FLOAT, base=value, components=(0,))
    return value if value.type is kind else _operation(node, functions.CONVERSIONS[value.type, kind], kind, value)


def _vector(node: syntax.Call, kind: Type, arguments: list[program.Typed]) -> program.Typed:
    numbers = [_as_numbers(one) for one in arguments]
    sizes = [one.type.n_components for one in numbers]
    splat = len(numbers) == 1 and sizes == [1]
    if not splat and sum(sizes) < kind.n_components:
        message = f"{kind.value} has {kind.n_components} components, {sum(sizes)} are given"
        raise RefusalError(node.start, node.end, message, f"write one number for all, or {kind.n_components}")
    if sum(sizes[:-1]) >= kind.n_components:
        raise RefusalError(node.start, node.end, f"the last value has no place among the components of {kind.value}")
    return _operation(node, functions.vector_of(kind.n_components), kind, *numbers)


def _as_numbers(value: program.Typed) -> program.Typed:
    if value.type in (Type.INT, Type.BOOL):
        return _operation(value, functions.CONVERSIONS[value.type, Type.FLOAT], Type.FLOAT, value)
    return value


def components_of(node: syntax.Member, kind: Type) -> tuple[int, ...]:
    """Return the components that letters such as ``xyz`` name, or refuse them."""
    start = node.end - len(node.letters)
    if not kind.is_vector:
        raise RefusalError(start, node.end, f"{a(kind)} has no components", "only vectors have them")
    for letters in _LETTER_SETS:
        found = tuple(letters.find(letter) for letter in node.letters)
        if min(found) < 0:
            continue
        if max(found) < kind.n_components and len(found) <= 4:
            return found
    known = ", ".join(letters[: kind.n_components] for letters in _LETTER_SETS)
    message = f".{node.letters[:40]} names no components of {a(kind)}"
    raise RefusalError(start, node.end, message, f"one to four letters of {known}")


def _member(node: syntax.Member, scope: Scope) -> program.Typed:
    base = checked(node.base, scope)
    return _picked(node, base, components_of(node, base.type))


def _picked(node: syntax.Node, base: program.Typed, components: tuple[int, ...]) -> program.Typed:
    kind = VECTORS.get(len(components), Type.FLOAT)
    if isinstance(base, program.Read):
        if base.components is not None:
            components = tuple(base.components[one] for one in components)
        return program.Read(
            start=node.start, end=node.end, type=kind, slot=base.slot, components=components, name=base.name
        )
    return program.Pick(start=node.start, end=node.end, type=kind, base=base, components=components)


def fixed_index(node: syntax.Index, kind: Type) -> int | None:
    """Return the index where it is a literal, None where it is worked out; refuse one beyond the vector."""
    if not kind.is_vector:
        raise RefusalError(node.start, node.end, f"{a(kind)} has no components", "only vectors have them")
    if not isinstance(node.index, syntax.Number) or node.index.type is not Type.INT:
        return None
    if node.index.value >= kind.n_components:
        message = f"{a(kind)} has no component {int(node.index.value)}"
        raise RefusalError(
            node.index.start, node.index.end, message, f"they are counted from 0 to {kind.n_components - 1}"
        )
    return int(node.index.value)


def _index(node: syntax.Index, scope: Scope) -> program.Typed:
    base = checked(node.base, scope)
    fixed = fixed_index(node, base.type)
    if fixed is not None:
        return _picked(node, base, (fixed,))
    index = checked_index(node, scope)
    return program.PickAt(start=node.start, end=node.end, type=Type.FLOAT, base=base, index=index)


def checked_index(node: syntax.Index, scope: Scope) -> program.Typed:
    """Return the index that is worked out: a whole number."""
    return checked_as(node.index, scope, Type.INT, "an index")


_CHECKS: dict[type, Callable[[Any, Scope], program.Typed]] = {
    syntax.Number: _number,
    syntax.Name: _name,
    syntax.Unary: _unary,
    syntax.Chain: _chain,
    syntax.Choice: _choice,
    syntax.Call: _call,
    syntax.Member: _member,
    syntax.Index: _index,
}
