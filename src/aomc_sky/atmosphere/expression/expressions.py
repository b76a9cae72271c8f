"""Parser of expressions: operator precedence without recursion, recursion for brackets alone."""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.atmosphere.expression.cursor import Cursor
from aomc_sky.atmosphere.expression.lexer import Kind, Token
from aomc_sky.atmosphere.expression.refusal import RefusalError
from aomc_sky.atmosphere.expression.syntax import (
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
from aomc_sky.atmosphere.expression.types import Type

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
    value = _primary(cursor)
    while cursor.at(".", "["):
        if cursor.take().text == "[":
            index = parse_expression(cursor)
            end = cursor.expect("]", "behind the index").end
            value = Index(start=value.start, end=end, depth=deepest(value, index), base=value, index=index)
            continue
        letters = cursor.token
        if letters.kind is not Kind.NAME:
            raise cursor.unexpected("components such as x or xyz are missing behind the point")
        cursor.take()
        value = Member(start=value.start, end=letters.end, depth=deepest(value), base=value, letters=letters.text)
    return value


def _primary(cursor: Cursor) -> Node:
    token = cursor.token
    if token.kind in (Kind.INT, Kind.FLOAT):
        cursor.take()
        kind = Type.INT if token.kind is Kind.INT else Type.FLOAT
        return Number(start=token.start, end=token.end, type=kind, value=token.value)
    if cursor.take_if("("):
        value = parse_expression(cursor)
        if cursor.at(","):
            raise cursor.unexpected("two values stand between one pair of brackets", "write vec2(a, b) for a vector")
        cursor.expect(")", "behind the value in brackets")
        return value
    if token.kind is Kind.NAME:
        return _named(cursor, cursor.take())
    if cursor.at("++", "--"):
        raise cursor.unexpected("an assignment is no value here", "make it a statement of its own")
    raise cursor.unexpected("a value is missing", "write a number, a name or a bracket")


def _named(cursor: Cursor, token: Token) -> Node:
    if token.text in ("true", "false"):
        return Number(start=token.start, end=token.end, type=Type.BOOL, value=float(token.text == "true"))
    if cursor.at("["):
        if token.text in TYPE_NAMES:
            raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    elif cursor.take_if("("):
        return _call(cursor, token)
    if token.text in RESERVED or token.text in TYPE_NAMES:
        raise RefusalError(token.start, token.end, f"{token.text} has no meaning here", "write a value")
    return Name(start=token.start, end=token.end, name=token.text)


def _call(cursor: Cursor, token: Token) -> Node:
    arguments: list[Node] = []
    if not cursor.at(")"):
        arguments.append(parse_expression(cursor))
        while cursor.take_if(","):
            arguments.append(parse_expression(cursor))
    end = cursor.expect(")", f"behind the arguments of {token.text}").end
    depth = deepest(*arguments)
    return Call(start=token.start, end=end, depth=depth, name=token.text, arguments=tuple(arguments))
