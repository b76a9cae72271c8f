"""Parser of statements: a block is the body of a function."""

from __future__ import annotations

from collections.abc import Callable

from aomc_sky.atmosphere.language.cursor import Cursor
from aomc_sky.atmosphere.language.expressions import ASSIGNING, RESERVED, TYPE_NAMES, parse_expression, parse_operand
from aomc_sky.atmosphere.language.lexer import Kind, read_tokens
from aomc_sky.atmosphere.language.refusal import Problems, RefusalError
from aomc_sky.atmosphere.language.syntax import (
    Assignment,
    Body,
    Declaration,
    Declarator,
    If,
    Jump,
    Loop,
    Node,
    Number,
    Return,
    deepest,
)
from aomc_sky.atmosphere.language.types import Type

_REFUSED = {
    "do": "write the loop with while or for",
    "switch": "write it with if and else",
    "struct": "use one variable for each part",
    "double": "write float; all numbers are 64 bits wide",
    "void": "there are no functions of one's own; write what it does where it is wanted",
    "discard": "return a value",
    "precision": "leave it out; all numbers are 64 bits wide",
    "uniform": "a block knows its own variables and the names given to it",
    "uint": "write int",
}


def parse_block(problems: Problems) -> Body:
    """Parse the whole block; raise all problems of its text together.

    Parameters
    ----------
    problems : Problems
        Holds the block.

    Raises
    ------
    InputFileError
        With every statement that could not be read.
    """
    cursor = Cursor(read_tokens(problems))
    statements: list[Node] = []
    while cursor.token.kind is not Kind.END:
        try:
            if cursor.at("}"):
                token = cursor.take()
                raise RefusalError(
                    token.start, token.end, "this } closes nothing that was opened in the block", "remove it"
                )
            statements += _statements(cursor)
        except RefusalError as refusal:
            problems.add(refusal)
            cursor.skip_statement()
    problems.raise_found()
    # no node lies above this one: its depth counts for nothing
    return Body(start=0, end=cursor.token.start, statements=tuple(statements))


def _statements(cursor: Cursor) -> list[Node]:
    # none where only a semicolon stands
    return [] if cursor.take_if(";") else [_statement(cursor)]


def _statement(cursor: Cursor) -> Node:
    with cursor.nested():
        token = cursor.token
        if cursor.at("{"):
            return _body(cursor)
        reader = _COMPOUND.get(token.text)
        if reader is not None:
            cursor.take()
            return reader(cursor, token.start)
        node = _simple(cursor, may_declare=True)
    cursor.expect(";", "at the end of the statement")
    return node


def _body(cursor: Cursor) -> Body:
    opened = cursor.take()
    statements: list[Node] = []
    while not cursor.at("}"):
        if cursor.token.kind is Kind.END:
            raise RefusalError(
                opened.start, opened.end, "this { is not closed in the block", "write } behind its statements"
            )
        statements += _statements(cursor)
    return Body(start=opened.start, end=cursor.take().end, depth=deepest(*statements), statements=tuple(statements))


def _inner(cursor: Cursor) -> Node:
    # what hangs on if, else, for and while
    if cursor.at(";"):
        end = cursor.take()
        return Body(start=end.start, end=end.end, statements=())
    return _statement(cursor)


def _if(cursor: Cursor, start: int) -> Node:
    cases = [_case(cursor)]
    otherwise = None
    while otherwise is None and cursor.take_if("else"):
        if cursor.take_if("if"):
            cases.append(_case(cursor))
        else:
            otherwise = _inner(cursor)
    depth = deepest(otherwise, *(node for case in cases for node in case))
    return If(start=start, end=cursor.behind, depth=depth, cases=tuple(cases), otherwise=otherwise)


def _case(cursor: Cursor) -> tuple[Node, Node]:
    cursor.expect("(", "behind if")
    condition = parse_expression(cursor)
    cursor.expect(")", "behind the condition")
    return condition, _inner(cursor)


def _while(cursor: Cursor, start: int) -> Node:
    cursor.expect("(", "behind while")
    condition = parse_expression(cursor)
    cursor.expect(")", "behind the condition")
    body = _inner(cursor)
    depth = deepest(condition, body)
    return Loop(start=start, end=cursor.behind, depth=depth, first=None, condition=condition, step=None, body=body)


def _for(cursor: Cursor, start: int) -> Node:
    cursor.expect("(", "behind for")
    first = None if cursor.at(";") else _simple(cursor, may_declare=True)
    cursor.expect(";", "behind the first part of for")
    condition = None if cursor.at(";") else parse_expression(cursor)
    cursor.expect(";", "behind the condition of for")
    step = None if cursor.at(")") else _simple(cursor, may_declare=False)
    cursor.expect(")", "behind the step of for")
    body = _inner(cursor)
    depth = deepest(first, condition, step, body)
    return Loop(start=start, end=cursor.behind, depth=depth, first=first, condition=condition, step=step, body=body)


def _return(cursor: Cursor, start: int) -> Node:
    if cursor.at(";"):
        raise cursor.unexpected("return has no value", "write return and a value")
    value = parse_expression(cursor)
    cursor.expect(";", "behind the value of return")
    return Return(start=start, end=cursor.behind, depth=deepest(value), value=value)


def _jump(word: str) -> Callable[[Cursor, int], Node]:
    def read(cursor: Cursor, start: int) -> Node:
        cursor.expect(";", f"behind {word}")
        return Jump(start=start, end=start + len(word), word=word)

    return read


_COMPOUND: dict[str, Callable[[Cursor, int], Node]] = {
    "if": _if,
    "for": _for,
    "while": _while,
    "return": _return,
    "break": _jump("break"),
    "continue": _jump("continue"),
}


def _simple(cursor: Cursor, *, may_declare: bool) -> Node:
    token = cursor.token
    if token.text in _REFUSED:
        raise RefusalError(token.start, token.end, f"{token.text} is not part of this language", _REFUSED[token.text])
    if token.text == "else":
        raise RefusalError(token.start, token.end, "else stands behind no if")
    is_type = token.text in TYPE_NAMES and not cursor.next_is("(")
    if may_declare and (is_type or token.text in ("const", "CONST")):
        return _declaration(cursor)
    return _assignment(cursor)


def _declaration(cursor: Cursor) -> Node:
    start = cursor.token.start
    is_const = cursor.take_if("const", "CONST") is not None
    word = cursor.token
    if word.text not in TYPE_NAMES:
        raise cursor.unexpected("a type is missing", f"the types are {', '.join(TYPE_NAMES)}")
    cursor.take()
    declarators = [_declarator(cursor)]
    while cursor.take_if(","):
        declarators.append(_declarator(cursor))
    depth = deepest(*(one.value for one in declarators))
    kind = TYPE_NAMES[word.text]
    return Declaration(
        start=start, end=cursor.behind, depth=depth, type=kind, is_const=is_const, declarators=tuple(declarators)
    )


def _declarator(cursor: Cursor) -> Declarator:
    token = cursor.token
    if cursor.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if token.kind is not Kind.NAME or token.text in RESERVED or token.text in TYPE_NAMES:
        raise cursor.unexpected("a name is missing behind the type")
    cursor.take()
    if cursor.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if cursor.at("("):
        message = "a block has no functions of its own"
        raise RefusalError(token.start, token.end, message, "write what it does where it is wanted")
    value = parse_expression(cursor) if cursor.take_if("=") else None
    return Declarator(start=token.start, end=token.end, depth=deepest(value), name=token.text, value=value)


def _assignment(cursor: Cursor) -> Node:
    start = cursor.token.start
    prefix = cursor.take_if("++", "--")
    # a target is read as a value first: only names, v.x and v[i] pass the checker
    target = parse_operand(cursor)
    operator = prefix or cursor.take_if(*ASSIGNING)
    if operator is None:
        if cursor.token.kind is Kind.NAME and cursor.behind < cursor.token.start:
            raise RefusalError(start, cursor.behind, "a type is not known", f"the types are {', '.join(TYPE_NAMES)}")
        raise RefusalError(
            start, cursor.behind, "this statement does nothing", "assign its value to a variable, or return it"
        )
    if operator.text in ("++", "--"):
        value: Node = Number(start=operator.start, end=operator.end, type=Type.INT, value=1)
    elif operator.text[0] in "&|^<>":
        raise RefusalError(operator.start, operator.end, f"{operator.text} works on bits, which are not known here")
    else:
        value = parse_expression(cursor)
    sign = operator.text[0].replace("=", "")
    depth = deepest(target, value)
    return Assignment(start=start, end=cursor.behind, depth=depth, target=target, operator=sign, value=value)
