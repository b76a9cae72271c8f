"""Parser of expressions: operator precedence without recursion, recursion for brackets alone."""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.atmosphere.language.cursor import Cursor
from aomc_sky.atmosphere.language.lexer import Kind
from aomc_sky.atmosphere.language.refusal import RefusalError
from aomc_sky.atmosphere.language.syntax import (
    Call,
    Chain,
    Choice,
    Index,
    Member,
    Name,
    Node,
    Number,
    Unary,
    deepest,
)
from aomc_sky.atmosphere.language.types import Type

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


@dataclass(slots=True)
class _Pending:
    level: int
    operands: list[Node]
    operators: list[str]

    def closed(self, last: Node) -> Chain:
        """The chain that ends with this operand."""
        operands = (*self.operands, last)
        return Chain(
            start=operands[0].start,
            end=last.end,
            depth=deepest(*operands),
            operands=operands,
            operators=tuple(self.operators),
        )


def parse_expression(cursor: Cursor) -> Node:
    """Parse an expression with its choices ``?:``."""
    with cursor.nested():
        value = _operation(cursor)
        cases = []
        while cursor.take_if("?"):
            chosen = parse_expression(cursor)
            cursor.expect(":", "between the two values of ?:")
            cases.append((value, chosen))
            value = _operation(cursor)
    if cursor.at(*ASSIGNING):
        raise cursor.unexpected("an assignment is no value here", "make it a statement of its own")
    if not cases:
        return value
    depth = deepest(value, *(node for case in cases for node in case))
    return Choice(start=cases[0][0].start, end=value.end, depth=depth, cases=tuple(cases), otherwise=value)


def _operation(cursor: Cursor) -> Node:
    pending: list[_Pending] = []
    operand = _unary(cursor)
    while (level := _level_of(cursor)) is not None:
        while pending and pending[-1].level > level:
            operand = pending.pop().closed(operand)
        if not (pending and pending[-1].level == level):
            pending.append(_Pending(level, [], []))
        pending[-1].operands.append(operand)
        pending[-1].operators.append(cursor.take().text)
        operand = _unary(cursor)
    while pending:
        operand = pending.pop().closed(operand)
    return operand


def _level_of(cursor: Cursor) -> int | None:
    if cursor.token.kind is not Kind.SYMBOL:
        return None
    if cursor.token.text in _BITS:
        token = cursor.token
        advice = f"write {_BITS[token.text]} if that is meant"
        raise RefusalError(token.start, token.end, f"the operator {token.text} on bits is not known here", advice)
    return _LEVEL.get(cursor.token.text)


def _unary(cursor: Cursor) -> Node:
    signs = []
    while sign := cursor.take_if("-", "+", "!"):
        signs.append(sign)
    value = parse_operand(cursor)
    for sign in reversed(signs):
        value = Unary(start=sign.start, end=value.end, depth=deepest(value), operator=sign.text, operand=value)
    return value


def parse_operand(cursor: Cursor) -> Node:
    """Parse a number, a name, a call or a bracket, with the components and indices behind it."""
    # one frame for each kind that holds expressions: the depth of Python's stack bounds that of the language
    if cursor.at("("):
        value = _bracket(cursor)
    elif cursor.token.kind is Kind.NAME and cursor.next_is("("):
        value = _call(cursor)
    else:
        value = _plain(cursor)
    while cursor.at(".", "["):
        value = _index(cursor, value) if cursor.at("[") else _member(cursor, value)
    return value


def _index(cursor: Cursor, base: Node) -> Node:
    cursor.take()
    index = parse_expression(cursor)
    end = cursor.expect("]", "behind the index").end
    return Index(start=base.start, end=end, depth=deepest(base, index), base=base, index=index)


def _member(cursor: Cursor, base: Node) -> Node:
    cursor.take()
    letters = cursor.token
    if letters.kind is not Kind.NAME:
        raise cursor.unexpected("components such as x or xyz are missing behind the point")
    cursor.take()
    return Member(start=base.start, end=letters.end, depth=deepest(base), base=base, letters=letters.text)


def _bracket(cursor: Cursor) -> Node:
    cursor.take()
    value = parse_expression(cursor)
    if cursor.at(","):
        raise cursor.unexpected("two values stand between one pair of brackets", "write vec2(a, b) for a vector")
    cursor.expect(")", "behind the value in brackets")
    return value


def _plain(cursor: Cursor) -> Node:
    token = cursor.token
    if cursor.at("++", "--"):
        raise cursor.unexpected("an assignment is no value here", "make it a statement of its own")
    if token.kind in (Kind.SYMBOL, Kind.END):
        raise cursor.unexpected("a value is missing", "write a number, a name or a bracket")
    cursor.take()
    if token.kind is not Kind.NAME:
        kind = Type.INT if token.kind is Kind.INT else Type.FLOAT
        return Number(start=token.start, end=token.end, type=kind, value=token.value)
    if token.text in ("true", "false"):
        return Number(start=token.start, end=token.end, type=Type.BOOL, value=float(token.text == "true"))
    if token.text in TYPE_NAMES and cursor.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if token.text in RESERVED or token.text in TYPE_NAMES:
        raise RefusalError(token.start, token.end, f"{token.text} has no meaning here", "write a value")
    return Name(start=token.start, end=token.end, name=token.text)


def _call(cursor: Cursor) -> Node:
    token = cursor.take()
    cursor.take()
    arguments: list[Node] = []
    if not cursor.at(")"):
        arguments.append(parse_expression(cursor))
        while cursor.take_if(","):
            arguments.append(parse_expression(cursor))
    end = cursor.expect(")", f"behind the arguments of {token.text}").end
    depth = deepest(*arguments)
    return Call(start=token.start, end=end, depth=depth, name=token.text, arguments=tuple(arguments))
