"""Expressions: read by precedence of operators, with their types; each becomes a function of a run and its lanes."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.skies.atmosphere.language import operators
from aomc_sky.skies.atmosphere.language.lexer import Kind, RefusalError, Span, Token, number_value
from aomc_sky.skies.atmosphere.language.operators import BUILT_INS
from aomc_sky.skies.atmosphere.language.values import Array, Function, Run, Type

MAX_NESTING = 100
MAX_VARIABLES = 500
TYPE_NAMES = {kind.value: kind for kind in Type}
_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/"))
_LEVEL = {operator: level for level, operators in enumerate(_LEVELS) for operator in operators}
ASSIGNING = ("=", "+=", "-=", "*=", "/=")
NO_OPERATORS = {
    **dict.fromkeys(("%", "%="), "write mod(x, y)"),
    **dict.fromkeys(("&", "|", "^", "^^", "~"), "write &&, || or !="),
    **dict.fromkeys(("++", "--"), "write += 1 or -= 1"),
    **dict.fromkeys(("<<", ">>", "<<=", ">>=", "&=", "|=", "^="), "write a product or a quotient"),
}
_LETTER_SETS = ("xyzw", "rgba", "stpq")


@dataclass(frozen=True, kw_only=True, slots=True)
class Variable:
    """A name with its type; `slot` is where a run keeps its value."""

    name: str
    type: Type
    slot: int
    fixed: str = ""  #: why it cannot be changed
    may_be_empty: bool = False  #: declared without a value; it holds NaN until it gets one


@dataclass(frozen=True, kw_only=True, slots=True)
class Value:
    """An expression: `run` works it out for the lanes that count."""

    span: Span
    type: Type
    run: Callable[[Run, Array], Array]
    #: of ``v`` and ``v.xy``, which may take a value
    variable: Variable | None = None
    components: tuple[int, ...] | None = None

    def as_type(self, expected: Type, what: str) -> Value:
        """The value as an expected type; a whole number may replace a real one."""
        if self.type.joined(expected) is expected:
            return replace(self, type=expected)
        advice = f"write {expected.value}(...) around it"
        if expected is Type.BOOL:
            advice = "write a comparison"
        elif self.type.is_vector:
            advice = "take a component of it, such as .x, or write all components"
        raise RefusalError(self.span, f"{what} is {self.type.named}, not {expected.named}", advice)


class Expressions:
    """Goes through the tokens of a block.

    The names `given` have values that a block cannot change. The block is a function of the float `argument`, which it
    may change, as in GLSL. For names that other blocks have, `hints` say what to do instead.
    """

    def __init__(
        self, tokens: Sequence[Token], given: Mapping[str, Type], argument: str, hints: Mapping[str, str]
    ) -> None:
        self._tokens = tokens
        self._index = 0
        self._depth = 0
        self._hints = hints
        self._names: list[dict[str, Variable]] = [{}]  # by the braces they live in, the innermost last
        self.n_variables = 0
        for name, kind in given.items():
            self._add(name, kind, fixed="is given to the block")
        self._names.append({})
        self._add(argument, Type.FLOAT)

    # tokens

    @property
    def token(self) -> Token:
        """The token that comes next."""
        return self._tokens[self._index]

    @property
    def after(self) -> Token:
        """The token behind the next one."""
        return self._tokens[min(self._index + 1, len(self._tokens) - 1)]

    @property
    def behind(self) -> int:
        """Offset behind the last token that was taken."""
        return self._tokens[self._index - 1].span.end if self._index else 0

    def at(self, *symbols: str) -> bool:
        """Whether one of these symbols or words comes next."""
        return self.token.text in symbols

    def take(self) -> Token:
        """Return the next token and go on; the end stays the end."""
        token = self.token
        self._index += token.kind is not Kind.END
        return token

    def take_if(self, *symbols: str) -> Token | None:
        """Take the next token if it is one of these."""
        return self.take() if self.at(*symbols) else None

    def expect(self, symbol: str, where: str) -> Token:
        """Take this symbol, or refuse its absence: behind the last token, where it would be written."""
        if not self.at(symbol):
            message = f"{symbol} is missing {where}; {self._found}"
            raise RefusalError(Span(self.behind, self.behind), message, f"write {symbol}")
        return self.take()

    def unexpected(self, message: str, advice: str = "") -> RefusalError:
        """Return a refusal that stands at the next token and says what it is."""
        return RefusalError(self.token.span, f"{message}; {self._found}", advice)

    @property
    def _found(self) -> str:
        return "the block ends" if self.token.kind is Kind.END else f"found {self.token.text[:40]}"

    @contextmanager
    def deeper(self) -> Iterator[None]:
        """Guard one level of brackets, operators or statements inside each other: of recursion, here and in a run."""
        if self._depth >= MAX_NESTING:
            message = f"brackets, operators and statements are nested more than {MAX_NESTING} deep here"
            raise RefusalError(self.token.span, message, "put parts of it into variables")
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    # names

    @contextmanager
    def braces(self) -> Iterator[None]:
        """Names that are declared inside end with it."""
        self._names.append({})
        try:
            yield
        finally:
            self._names.pop()

    def declare(self, token: Token, kind: Type, *, is_const: bool, may_be_empty: bool) -> Variable:
        """Begin a variable in the innermost braces."""
        name = token.text
        if name in self._names[-1]:
            raise RefusalError(token.span, f"{name} is declared twice", "take another name, or leave out the type")
        if self.n_variables >= MAX_VARIABLES:
            raise RefusalError(token.span, f"the block has more than {MAX_VARIABLES} variables", "declare fewer")
        return self._add(name, kind, fixed="is const" if is_const else "", may_be_empty=may_be_empty)

    def _add(self, name: str, kind: Type, *, fixed: str = "", may_be_empty: bool = False) -> Variable:
        variable = Variable(name=name, type=kind, slot=self.n_variables, fixed=fixed, may_be_empty=may_be_empty)
        self._names[-1][name] = variable
        self.n_variables += 1
        return variable

    def _find(self, token: Token) -> Variable:
        name = token.text
        for frame in reversed(self._names):
            if name in frame:
                return frame[name]
        near = difflib.get_close_matches(name[:60], [one for frame in self._names for one in frame], n=1)
        advice = self._hints.get(name) or (f"is {near[0]} meant?" if near else "declare it: float name = value;")
        if name in BUILT_INS:
            advice = f"{name} is a function: write {name}(...)"
        raise RefusalError(token.span, f"the name {name[:60]} is not known", advice)

    # expressions

    def expression(self) -> Value:
        """Read an expression with its choices ``?:``."""
        cases: list[tuple[Value, Value]] = []
        with self.deeper():
            value = self._operation(0)
            while self.take_if("?"):
                condition = value.as_type(Type.BOOL, "the condition")
                chosen = self.expression()
                self.expect(":", "between the two values of ?:")
                cases.append((condition, chosen))
                value = self._operation(0)
        if self.at(*ASSIGNING):
            raise self.unexpected("an assignment is not a value here", "make it a statement of its own")
        if self.at(*NO_OPERATORS):
            message = f"the operator {self.token.text} is not part of this language"
            raise RefusalError(self.token.span, message, NO_OPERATORS[self.token.text])
        return _choice(cases, value) if cases else value

    def _operation(self, level: int) -> Value:
        """Read operators of this precedence and above; a sum of thousands of terms is one level deep."""
        value = self._unary()
        while _LEVEL.get(self.token.text, -1) >= level:
            names, operands = [], [value]
            chain_level = _LEVEL[self.token.text]
            while self.at(*_LEVELS[chain_level]):
                names.append(self.take().text)
                with self.deeper():
                    operands.append(self._operation(chain_level + 1))
            value = (_logic if names[0] in ("&&", "||") else _chain)(names, operands)
        return value

    def _unary(self) -> Value:
        sign = self.take_if("-", "+", "!")
        if sign is None:
            return self.operand()
        with self.deeper():
            value = self._unary()
        span = Span(sign.span.start, value.span.end)
        if (sign.text == "!") is not (value.type is Type.BOOL):
            expected = "a bool" if sign.text == "!" else "a number"
            raise RefusalError(span, f"{sign.text} takes {expected}, not {value.type.named}")
        return _applied(span, value.type, operators.SIGNS[sign.text], [value])

    def operand(self) -> Value:
        """Read a number, a name, a call or a bracket, with the components behind it."""
        if self.take_if("("):
            value = self.expression()
            if self.at(","):
                raise self.unexpected("there are two values in one pair of brackets", "write vec2(a, b) for a vector")
            self.expect(")", "after the value in brackets")
        else:
            value = self._call() if self.token.kind is Kind.NAME and self.after.text == "(" else self._plain()
        while self.at(".", "["):
            components = self._components(value.type)
            value = _part(value, components, Span(value.span.start, self.behind))
        return value

    def _plain(self) -> Value:
        token = self.token
        if token.kind in (Kind.SYMBOL, Kind.END):
            raise self.unexpected("a value is missing", "write a number, a name or a bracket")
        self.take()
        if token.kind is Kind.NUMBER:
            number = number_value(token.text, token.span)
            return _constant(token.span, Type.INT if isinstance(number, int) else Type.FLOAT, float(number))
        if token.text in ("true", "false"):
            return _constant(token.span, Type.BOOL, token.text == "true")
        return _read(token.span, self._find(token), None)

    def _components(self, kind: Type) -> tuple[int, ...]:
        """Read letters such as ``.xyz``, or one number such as ``[0]``."""
        is_index = self.take().text == "["
        token = self.token
        if not is_index and token.kind is not Kind.NAME:
            raise self.unexpected("components such as x or xyz are missing after the point")
        if is_index and not (token.kind is Kind.NUMBER and token.text.isdigit()):
            raise self.unexpected("an index is a whole number that stands there", "write v[0], or choose by ?:")
        self.take()
        if is_index:
            self.expect("]", "after the index")
        if not kind.is_vector:
            raise RefusalError(token.span, f"{kind.named} has no components", "only vectors have them")
        if is_index and int(token.text) < kind.size:
            return (int(token.text),)
        sets = [letters[: kind.size] for letters in _LETTER_SETS]
        for known in sets:
            if set(token.text) <= set(known) and len(token.text) <= 4:
                return tuple(map(known.index, token.text))
        advice = f"write an index of 0 to {kind.size - 1}" if is_index else f"one to four letters of {', '.join(sets)}"
        raise RefusalError(token.span, f"{token.text[:40]} names no components of {kind.named}", advice)

    def _call(self) -> Value:
        name = self.take()
        self.take()
        arguments: list[Value] = []
        if not self.at(")"):
            arguments.append(self.expression())
            while self.take_if(","):
                arguments.append(self.expression())
        span = Span(name.span.start, self.expect(")", f"after the arguments of {name.text[:40]}").span.end)
        if name.text in TYPE_NAMES:
            return _constructed(span, TYPE_NAMES[name.text], arguments)
        if name.text not in BUILT_INS:
            near = difflib.get_close_matches(name.text[:60], BUILT_INS, n=1)
            advice = f"is {near[0]} meant?" if near else "the functions are listed in docs/formats/atmo.md"
            raise RefusalError(name.span, f"there is no function {name.text[:60]}", advice)
        built_in, given = BUILT_INS[name.text], [one.type for one in arguments]
        kind = built_in.resolve(given)
        if kind is not None:
            return _applied(span, kind, built_in.function, arguments)
        numbers = sorted({len(pattern) for pattern in built_in.patterns})
        if len(given) not in numbers:
            shown = " or ".join(map(str, numbers))
            raise RefusalError(span, f"{name.text} takes {shown} values, not {len(given)}")
        message = f"{name.text} does not take {', '.join(one.value for one in given)}: its values have one type"
        raise RefusalError(span, message, "write vec4(...) around a number, or take a component such as .x")


def _constant(span: Span, kind: Type, value: float | bool) -> Value:
    array = np.full(1, value)
    return Value(span=span, type=kind, run=lambda run, mask: array)


def _read(span: Span, variable: Variable, components: tuple[int, ...] | None) -> Value:
    kind, part = (variable.type, slice(None)) if components is None else _component_part(components)

    def read(run: Run, mask: Array) -> Array:
        value = run.values[variable.slot][part]
        if variable.may_be_empty:
            empty = mask & np.isnan(value).reshape(-1, value.shape[-1]).any(axis=0)
            if empty.any():
                message = f"{variable.name} has no value, {run.where(int(np.argmax(empty)))}"
                raise RefusalError(span, message, f"declare it with one: {variable.name} = 0.0")
        return value.astype(np.bool_, copy=False) if kind is Type.BOOL else value

    return Value(span=span, type=kind, run=read, variable=variable, components=components)


def _part(base: Value, components: tuple[int, ...], span: Span) -> Value:
    if base.variable is not None:
        known = base.components
        return _read(span, base.variable, components if known is None else tuple(known[one] for one in components))
    kind, part = _component_part(components)
    return Value(span=span, type=kind, run=lambda run, mask: base.run(run, mask)[part])


def _component_part(components: tuple[int, ...]) -> tuple[Type, int | slice | list[int]]:
    one = len(components) == 1
    return Type.FLOAT if one else Type(f"vec{len(components)}"), components[0] if one else list(components)


def _applied(span: Span, kind: Type, function: Function, operands: Sequence[Value]) -> Value:
    def run(run: Run, mask: Array) -> Array:
        return run.apply(span, kind, function, [one.run(run, mask) for one in operands], mask)

    return Value(span=span, type=kind, run=run)


def _chain(names: Sequence[str], operands: Sequence[Value]) -> Value:
    """Numbers or comparisons with operators of one precedence between them, worked out from the left."""
    first, kind = operands[0], operands[0].type
    steps: list[tuple[Span, Type, Function, Value]] = []
    for name, right in zip(names, operands[1:], strict=True):
        span = Span(first.span.start, right.span.end)
        function, kind = law(name, kind, right.type, span)
        steps.append((span, kind, function, right))

    def run(run: Run, mask: Array) -> Array:
        result = first.run(run, mask)
        for span, kind, function, right in steps:
            result = run.apply(span, kind, function, [result, right.run(run, mask)], mask)
        return result

    return Value(span=Span(first.span.start, operands[-1].span.end), type=kind, run=run)


def law(operator: str, left: Type, right: Type, span: Span) -> tuple[Function, Type]:
    """The function of an operator for two types, and the type of the result."""
    kinds, kind = f"{left.value} and {right.value}", left.joined(right)
    if operator in operators.EQUALITY and kind is not None:
        return operators.EQUALITY[operator], Type.BOOL
    if operator in operators.ORDERS and kind in (Type.INT, Type.FLOAT):
        return operators.ORDERS[operator], Type.BOOL
    if operator not in operators.ARITHMETIC:
        what = "two numbers" if operator in operators.ORDERS else "two values of one type"
        advice = "join two comparisons by &&" if left is Type.BOOL else ""
        raise RefusalError(span, f"{operator} compares {what}, not {kinds}", advice)
    found = operators.arithmetic(operator, left, right)
    if found is None:
        is_truth = Type.BOOL in (left, right)
        advice = "write cond ? a : b" if is_truth else "use vectors of one size, or a component such as .x"
        raise RefusalError(span, f"{operator} cannot combine {kinds}", advice)
    return found


def _logic(names: Sequence[str], operands: Sequence[Value]) -> Value:
    """``&&``, which stops at False, or ``||``, which stops at True."""
    for one in operands:
        if one.type is not Type.BOOL:
            raise RefusalError(one.span, f"{names[0]} takes bools, not {one.type.named}", "write a comparison")
    stops_at = names[0] == "||"
    known = _constant(operands[0].span, Type.BOOL, stops_at)
    tests = [one if stops_at else _applied(one.span, Type.BOOL, operators.SIGNS["!"], [one]) for one in operands]
    return _choice([(test, known) for test in tests[:-1]], operands[-1])


def _choice(cases: Sequence[tuple[Value, Value]], otherwise: Value) -> Value:
    """``a ? x : b ? y : z``: the value of the first condition that holds, else the last one."""
    span, kind = Span(cases[0][0].span.start, otherwise.span.end), otherwise.type
    for _, value in cases:
        both = kind.joined(value.type)
        if both is None:
            kinds = f"{value.type.value} and {kind.value}"
            raise RefusalError(span, f"the values of ?: have different types: {kinds}", "write values of one type")
        kind = both

    def run(run: Run, mask: Array) -> Array:
        result: Array | None = None
        for condition, chosen in cases:
            truth = condition.run(run, mask)
            taken = mask & truth
            if taken.any():
                value = chosen.run(run, taken)
                result = value if result is None else np.where(taken, value, result)
            mask = mask & ~truth
        if mask.any() or result is None:
            value = otherwise.run(run, mask)
            result = value if result is None else np.where(mask, value, result)
        return result

    return Value(span=span, type=kind, run=run)


def _constructed(span: Span, kind: Type, arguments: Sequence[Value]) -> Value:
    sizes, name = [one.type.size for one in arguments], kind.value
    if not kind.is_vector and len(arguments) != 1:
        raise RefusalError(span, f"{name}() takes one value, not {len(arguments)}")
    if sizes != [1] and sum(sizes) < kind.size:
        message = f"{name} has {kind.size} components, {sum(sizes)} are given"
        raise RefusalError(span, message, f"write one number for all, or {kind.size}")
    if sum(sizes[:-1]) >= kind.size:
        raise RefusalError(span, f"there are more values than components of {name}")
    return _applied(span, kind, operators.constructor(kind), arguments)
