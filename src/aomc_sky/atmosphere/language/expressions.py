"""Expressions: read by operator precedence without recursion, by recursion for brackets alone, and typed on the way."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from aomc_sky.atmosphere.language import nodes, operators
from aomc_sky.atmosphere.language.lexer import MAX_NESTING, Cursor, Kind, RefusalError, Token
from aomc_sky.atmosphere.language.nodes import Offsets, Type, Typed
from aomc_sky.atmosphere.language.operators import BUILT_INS
from aomc_sky.errors import MAX_PROBLEMS_SHOWN

MAX_VARIABLES = 500


@dataclass(frozen=True, kw_only=True, slots=True)
class Variable:
    """A name with its type; `slot` is where the evaluator keeps its value."""

    name: str
    type: Type
    slot: int
    fixed: str = ""


class Scope:
    """Names by the braces they live in, the innermost last.

    `given` are names with values that a block reads and cannot change; `argument` is the float that it is a function
    of, which it may change, as in GLSL; `hints` say what to do instead of names that other blocks have.
    """

    def __init__(self, given: Mapping[str, Type], argument: str, hints: Mapping[str, str]) -> None:
        self._hints = hints
        self._frames: list[dict[str, Variable]] = [{}, {}]
        self.n_slots = 0
        for name, kind in given.items():
            self._frames[0][name] = self._new(name, kind, "is given to the block")
        self.argument = self._new(argument, Type.FLOAT, "")
        self._frames[1][argument] = self.argument

    @property
    def given(self) -> tuple[Variable, ...]:
        """Variables of the names that were given."""
        return tuple(self._frames[0].values())

    @contextmanager
    def braces(self) -> Iterator[None]:
        """Names that are declared inside end with it."""
        self._frames.append({})
        try:
            yield
        finally:
            self._frames.pop()

    def declare(self, token: Token, kind: Type, *, is_const: bool) -> Variable:
        """Begin a variable in the innermost braces."""
        name = token.text
        if name in self._frames[-1]:
            message = f"{name} is declared twice" if name != self.argument.name else f"{name} is the block's argument"
            raise RefusalError(token.start, token.end, message, "take another name, or leave out the type")
        if self.n_slots >= MAX_VARIABLES:
            raise RefusalError(token.start, token.end, f"the block has more than {MAX_VARIABLES} variables")
        self._frames[-1][name] = self._new(name, kind, "is const" if is_const else "")
        return self._frames[-1][name]

    def find(self, token: Token) -> Variable:
        """Return the variable that a name means, or refuse the name with the nearest known one."""
        name = token.text
        for frame in reversed(self._frames):
            if name in frame:
                return frame[name]
        raise RefusalError(token.start, token.end, f"the name {name[:60]} is not known", self._advice(name))

    def _advice(self, name: str) -> str:
        if name in self._hints:
            return self._hints[name]
        known = [one for frame in self._frames for one in frame]
        near = difflib.get_close_matches(name[:60], known, n=1)
        if name in BUILT_INS:
            return f"{name} is a function: write {name}(...)"
        return f"is {near[0]} meant?" if near else "declare it: float name = value;"

    def _new(self, name: str, kind: Type, fixed: str) -> Variable:
        variable = Variable(name=name, type=kind, slot=self.n_slots, fixed=fixed)
        self.n_slots += 1
        return variable


_LEVELS = (("||",), ("^^",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/", "%"))
_LEVEL = {operator: level for level, operators in enumerate(_LEVELS) for operator in operators}
_BITS = {"&": "&&", "|": "||", "^": "^^", "<<": "a product", ">>": "a quotient"}
ASSIGNING = ("=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", "++", "--")
TYPE_NAMES = {kind.value: kind for kind in Type}
_RESERVED_WORDS = """
attribute break buffer case centroid coherent const continue CONST default discard do double else false flat for highp
if in inout invariant layout lowp mediump noperspective out patch precise precision readonly restrict return sample
shared smooth struct subroutine switch true uniform varying void volatile while writeonly uint dvec2 dvec3 dvec4 ivec2
ivec3 ivec4 uvec2 uvec3 uvec4 bvec2 bvec3 bvec4 mat2 mat3 mat4"""
RESERVED = frozenset(_RESERVED_WORDS.split())

_REFUSED = Typed(start=0, end=0, type=Type.FLOAT)
"""Stands for an expression of a statement that is refused already; nobody looks at it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Piece:
    """A part of the text as it was read.

    `depth` counts the pieces on the longest way down, so that no reader of the tree needs more stack than MAX_NESTING
    allows. A sum of thousands of terms is one piece deep.
    """

    start: int
    end: int
    depth: int = 1

    def __post_init__(self) -> None:
        if self.depth > MAX_NESTING:
            message = f"operators and statements are nested more than {MAX_NESTING} deep here"
            raise RefusalError(self.start, self.start + 1, message, "put parts of it into variables")

    @property
    def span(self) -> Offsets:
        """Where it stands."""
        return Offsets(self.start, self.end)


@dataclass(frozen=True, kw_only=True, slots=True)
class Expression(Piece):
    """An expression with its node of the typed tree, whose own place may be narrower: ``+x`` is the node of ``x``."""

    value: Typed
    variable: Token | None = None  #: of ``v``, ``v.xy`` and ``v[i]``, which may take a value: the name


def deepest(*pieces: Piece | None) -> int:
    """Depth of a piece above these."""
    return 1 + max((piece.depth for piece in pieces if piece is not None), default=0)


class Reader(Cursor):
    """Goes through the tokens once and settles names and types on the way.

    Text that cannot be read is raised at once. A type that does not fit is kept, and nothing behind it in its
    statement is typed any more; it counts only if all of the text can be read.
    """

    def __init__(self, tokens: list[Token], scope: Scope) -> None:
        super().__init__(tokens)
        self.scope = scope
        self.refusal: RefusalError | None = None  #: of the statement that is read
        self.refusals: list[RefusalError] = []  #: of those before

    def settle(self, rule: Callable[..., Typed], *arguments: Any) -> Typed:
        """The node that a rule makes, unless something before it in the statement was refused."""
        if self.refusal is None:
            try:
                return rule(*arguments)
            except RefusalError as refusal:
                self.refusal = refusal
        return _REFUSED

    @property
    def is_full(self) -> bool:
        """Whether there are more refusals than are ever shown: nothing is typed any more."""
        return len(self.refusals) > MAX_PROBLEMS_SHOWN

    def end_statement(self) -> bool:
        """Whether nothing was refused; if something was, note it and begin anew."""
        if self.refusal is None:
            return True
        if not self.is_full:
            self.refusals.append(self.refusal)
        if not self.is_full:
            self.refusal = None
        return False


@dataclass(slots=True)
class _Pending:
    """A chain of operators of one precedence that may go on."""

    level: int
    operands: list[Expression] = field(default_factory=list)
    operators: list[str] = field(default_factory=list)

    def closed(self, reader: Reader, last: Expression) -> Expression:
        """The chain that ends with this operand."""
        operands = (*self.operands, last)
        span = Offsets(operands[0].start, last.end)
        value = reader.settle(operators.chain, span, self.operators, [one.value for one in operands])
        return Expression(start=span.start, end=span.end, depth=deepest(*operands), value=value)


def read_expression(reader: Reader) -> Expression:
    """Read an expression with its choices ``?:``."""
    with reader.nested():
        value = _operation(reader)
        parts: list[Expression] = []
        cases: list[tuple[Typed, Typed]] = []
        while reader.take_if("?"):
            condition = reader.settle(operators.as_type, value.span, value.value, Type.BOOL, "the condition")
            chosen = read_expression(reader)
            reader.expect(":", "between the two values of ?:")
            cases.append((condition, chosen.value))
            parts += [value, chosen]
            value = _operation(reader)
    if reader.at(*ASSIGNING):
        raise reader.unexpected("an assignment is not a value here", "make it a statement of its own")
    if not cases:
        return value
    span = Offsets(parts[0].start, value.end)
    whole = reader.settle(operators.choice, span, cases, value.value)
    return Expression(start=span.start, end=span.end, depth=deepest(value, *parts), value=whole)


def _operation(reader: Reader) -> Expression:
    pending: list[_Pending] = []
    operand = _unary(reader)
    while (level := _level_of(reader)) is not None:
        while pending and pending[-1].level > level:
            operand = pending.pop().closed(reader, operand)
        if not (pending and pending[-1].level == level):
            pending.append(_Pending(level))
        pending[-1].operands.append(operand)
        pending[-1].operators.append(reader.take().text)
        operand = _unary(reader)
    while pending:
        operand = pending.pop().closed(reader, operand)
    return operand


def _level_of(reader: Reader) -> int | None:
    if reader.token.kind is not Kind.SYMBOL:
        return None
    if reader.token.text in _BITS:
        token = reader.token
        advice = f"write {_BITS[token.text]} if that is meant"
        raise RefusalError(
            token.start, token.end, f"the operator {token.text} on bits is not part of this language", advice
        )
    return _LEVEL.get(reader.token.text)


def _unary(reader: Reader) -> Expression:
    signs = []
    while sign := reader.take_if("-", "+", "!"):
        signs.append(sign)
    operand = read_operand(reader)
    for sign in reversed(signs):
        value = reader.settle(operators.unary, Offsets(sign.start, operand.end), sign.text, operand.value)
        operand = Expression(start=sign.start, end=operand.end, depth=deepest(operand), value=value)
    return operand


def read_operand(reader: Reader) -> Expression:
    """Read a number, a name, a call or a bracket, with the components and indices behind it."""
    # one frame for each kind that holds expressions: the depth of Python's stack bounds that of the language
    if reader.at("("):
        value = _bracket(reader)
    elif reader.token.kind is Kind.NAME and reader.next_is("("):
        value = _call(reader)
    else:
        value = _plain(reader)
    while reader.at(".", "["):
        value = _index(reader, value) if reader.at("[") else _member(reader, value)
    return value


def _index(reader: Reader, base: Expression) -> Expression:
    reader.take()
    is_known = reader.refusal is None
    index = read_expression(reader)
    span = Offsets(base.start, reader.expect("]", "after the index").end)
    if is_known and not base.value.type.is_vector:
        # what is wrong inside the index stands behind it
        message = f"{operators.a(base.value.type)} has no components"
        reader.refusal = RefusalError(span.start, span.end, message, "only vectors have them")
    value = reader.settle(operators.at_index, span, base.value, index.span, index.value)
    return _part(span, base, value, deepest(base, index))


def _member(reader: Reader, base: Expression) -> Expression:
    reader.take()
    letters = reader.token
    if letters.kind is not Kind.NAME:
        raise reader.unexpected("components such as x or xyz are missing after the point")
    reader.take()
    span = Offsets(base.start, letters.end)
    return _part(span, base, reader.settle(operators.member, span, base.value, letters.text), deepest(base))


def _part(span: Offsets, base: Expression, value: Typed, depth: int) -> Expression:
    # v.x and v[i] take a value, v.xy.x takes none
    variable = base.variable if base.depth == 1 else None
    return Expression(start=span.start, end=span.end, depth=depth, value=value, variable=variable)


def _bracket(reader: Reader) -> Expression:
    reader.take()
    value = read_expression(reader)
    if reader.at(","):
        raise reader.unexpected("there are two values in one pair of brackets", "write vec2(a, b) for a vector")
    reader.expect(")", "after the value in brackets")
    return value


def _plain(reader: Reader) -> Expression:
    token = reader.token
    if reader.at("++", "--"):
        raise reader.unexpected("an assignment is not a value here", "make it a statement of its own")
    if token.kind in (Kind.SYMBOL, Kind.END):
        raise reader.unexpected("a value is missing", "write a number, a name or a bracket")
    reader.take()
    span = Offsets(token.start, token.end)
    if token.kind is not Kind.NAME:
        kind = Type.INT if token.kind is Kind.INT else Type.FLOAT
        return Expression(start=span.start, end=span.end, value=operators.number(span, kind, token.value))
    if token.text in ("true", "false"):
        value = operators.number(span, Type.BOOL, token.text == "true")
        return Expression(start=span.start, end=span.end, value=value)
    if token.text in TYPE_NAMES and reader.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if token.text in RESERVED or token.text in TYPE_NAMES:
        raise RefusalError(token.start, token.end, f"{token.text} has no meaning here", "write a value")
    return Expression(start=span.start, end=span.end, value=reader.settle(_read, reader.scope, token), variable=token)


def _read(scope: Scope, token: Token) -> Typed:
    variable = scope.find(token)
    return nodes.Read(
        start=token.start, end=token.end, type=variable.type, slot=variable.slot, components=None, name=token.text
    )


def _call(reader: Reader) -> Expression:
    token = reader.take()
    reader.take()
    arguments: list[Expression] = []
    if not reader.at(")"):
        arguments.append(read_expression(reader))
        while reader.take_if(","):
            arguments.append(read_expression(reader))
    span = Offsets(token.start, reader.expect(")", f"after the arguments of {token.text}").end)
    value = reader.settle(operators.call, span, token.text, [one.value for one in arguments])
    return Expression(start=span.start, end=span.end, depth=deepest(*arguments), value=value)
