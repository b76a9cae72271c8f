"""Statements: a block is the body of a function, read and typed in one pass; every way through it ends with a value."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from aomc_sky.atmosphere.language import nodes, operators
from aomc_sky.atmosphere.language.expressions import (
    ASSIGNING,
    RESERVED,
    TYPE_NAMES,
    Expression,
    Piece,
    Reader,
    Scope,
    Variable,
    deepest,
    read_expression,
    read_operand,
)
from aomc_sky.atmosphere.language.lexer import Kind, Problems, RefusalError, Token, read_tokens
from aomc_sky.atmosphere.language.nodes import Offsets, Type, Typed, fits

_REFUSED = {
    "do": "write the loop with while or for",
    "switch": "write it with if and else",
    "struct": "use one variable for each part",
    "double": "write float; all numbers are 64 bits wide",
    "void": "a block cannot define functions; write the code where you need it",
    "discard": "return a value",
    "precision": "leave it out; all numbers are 64 bits wide",
    "uniform": "a block knows its own variables and the names given to it",
    "uint": "write int",
}


def read_body(problems: Problems, scope: Scope, gives: Type) -> nodes.Sequence:
    """Read the whole block.

    An InputFileError has every statement that could not be read; if all could, one problem of every statement whose
    names or types do not fit.
    """
    reader = _Statements(read_tokens(problems), scope, gives)
    statements: list[nodes.Statement] = []
    while reader.token.kind is not Kind.END:
        try:
            if reader.at("}"):
                token = reader.take()
                raise RefusalError(token.start, token.end, "this } has no { before it in the block", "remove it")
            statements += _statement(reader).does
        except RefusalError as refusal:
            problems.add(refusal)
            reader.skip_statement()
    problems.raise_found()
    for wrong in reader.refusals:
        problems.add(wrong)
    end = reader.token.start
    body = nodes.Sequence(start=0, end=end, statements=tuple(statements))
    if not problems.found and not _ends(body):
        message = f"the block can end without a value; it must return {operators.a(gives)}"
        problems.add(RefusalError(end, end, message, "write return and a value at its end"))
    problems.raise_found()
    return body


def _ends(node: nodes.Statement | None) -> bool:
    """Whether every way through a statement meets a return; a loop may have no round at all."""
    if isinstance(node, nodes.Sequence):
        return any(_ends(one) for one in node.statements)
    if isinstance(node, nodes.Branch):
        return _ends(node.otherwise) and all(_ends(body) for _, body in node.cases)
    return isinstance(node, nodes.Give)


class _Statements(Reader):
    """A reader that knows what the block gives, and how many loops stand around."""

    def __init__(self, tokens: list[Token], scope: Scope, gives: Type) -> None:
        super().__init__(tokens, scope)
        self.gives = gives
        self.n_loops = 0

    @contextmanager
    def loop(self) -> Iterator[None]:
        """Inside of a loop, with names of its own."""
        self.n_loops += 1
        try:
            with self.scope.braces():
                yield
        finally:
            self.n_loops -= 1


@dataclass(frozen=True, kw_only=True, slots=True)
class _Written(Piece):
    """A statement with what it does: nothing if it was refused."""

    does: Sequence[nodes.Statement] = ()

    @property
    def sequence(self) -> nodes.Sequence:
        """All that it does, as one statement."""
        if len(self.does) == 1 and isinstance(self.does[0], nodes.Sequence):
            return self.does[0]
        return nodes.Sequence(start=self.start, end=self.end, statements=tuple(self.does))


def _statement(reader: _Statements) -> _Written:
    if reader.at(";"):
        end = reader.take()
        return _Written(start=end.start, end=end.end)
    with reader.nested():
        token = reader.token
        if reader.at("{"):
            with reader.scope.braces():
                return _body(reader)
        compound = _COMPOUND.get(token.text)
        if compound is not None:
            reader.take()
            return compound(reader, token.start)
        written = _simple(reader, may_declare=True)
    reader.expect(";", "at the end of the statement")
    return written


def _body(reader: _Statements) -> _Written:
    opened = reader.take()
    inside: list[_Written] = []
    while not reader.at("}"):
        if reader.token.kind is Kind.END:
            raise RefusalError(
                opened.start, opened.end, "this { is not closed in the block", "write } after its statements"
            )
        if not reader.take_if(";"):
            inside.append(_statement(reader))
    end = reader.take().end
    body = nodes.Sequence(start=opened.start, end=end, statements=tuple(node for one in inside for node in one.does))
    return _Written(start=opened.start, end=end, depth=deepest(*inside), does=(body,))


def _inner(reader: _Statements) -> _Written:
    # what hangs on if, else, for and while
    with reader.scope.braces():
        return _statement(reader)


def _settled(reader: _Statements, node: nodes.Statement | None) -> Sequence[nodes.Statement]:
    """What one statement does; its refusal, if there is one, is noted."""
    return (node,) if reader.end_statement() and node is not None else ()


def _if(reader: _Statements, start: int) -> _Written:
    pieces: list[Piece] = []
    cases: list[tuple[Typed | None, nodes.Statement]] = []
    otherwise = None
    is_case = True
    while is_case:
        condition, truth, body = _case(reader)
        pieces += [condition, body]
        cases.append((truth, body.sequence))
        has_else = reader.take_if("else") is not None
        is_case = has_else and reader.take_if("if") is not None
        if has_else and not is_case:
            otherwise = _inner(reader)
    end, depth = reader.behind, deepest(otherwise, *pieces)
    typed = tuple((truth, body) for truth, body in cases if truth is not None)
    last = None if otherwise is None else otherwise.sequence
    branch = nodes.Branch(start=start, end=end, cases=typed, otherwise=last)
    return _Written(start=start, end=end, depth=depth, does=(branch,) if len(typed) == len(cases) else ())


def _case(reader: _Statements) -> tuple[Expression, Typed | None, _Written]:
    reader.expect("(", "after if")
    condition, truth = _condition(reader)
    reader.expect(")", "after the condition")
    return condition, truth, _inner(reader)


def _condition(reader: _Statements) -> tuple[Expression, Typed | None]:
    # noted at once, so that the statements behind a wrong condition are looked at too
    condition = read_expression(reader)
    truth = reader.settle(operators.as_type, condition.span, condition.value, Type.BOOL, "the condition")
    return condition, truth if reader.end_statement() else None


def _while(reader: _Statements, start: int) -> _Written:
    with reader.loop():
        reader.expect("(", "after while")
        condition, truth = _condition(reader)
        reader.expect(")", "after the condition")
        body = _inner(reader)
    end = reader.behind
    loop = nodes.Repeat(start=start, end=end, first=None, condition=truth, step=None, body=body.sequence)
    return _Written(start=start, end=end, depth=deepest(condition, body), does=(loop,))


def _for(reader: _Statements, start: int) -> _Written:
    condition, truth = None, None
    with reader.loop():
        reader.expect("(", "after for")
        first = None if reader.at(";") else _simple(reader, may_declare=True)
        reader.expect(";", "after the first part of for")
        if not reader.at(";"):
            condition, truth = _condition(reader)
        reader.expect(";", "after the condition of for")
        step = None if reader.at(")") else _simple(reader, may_declare=False)
        reader.expect(")", "after the step of for")
        body = _inner(reader)
    end = reader.behind
    loop = nodes.Repeat(
        start=start,
        end=end,
        first=None if first is None else first.sequence,
        condition=truth,
        step=None if step is None else step.sequence,
        body=body.sequence,
    )
    return _Written(start=start, end=end, depth=deepest(first, condition, step, body), does=(loop,))


def _return(reader: _Statements, start: int) -> _Written:
    if reader.at(";"):
        raise reader.unexpected("return has no value", "write return and a value")
    value = read_expression(reader)
    reader.expect(";", "after the value of return")
    end = reader.behind
    given = reader.settle(operators.as_type, value.span, value.value, reader.gives, "the value that is returned")
    does = _settled(reader, nodes.Give(start=start, end=end, value=given))
    return _Written(start=start, end=end, depth=deepest(value), does=does)


def _jump(word: str) -> Callable[[_Statements, int], _Written]:
    def read(reader: _Statements, start: int) -> _Written:
        reader.expect(";", f"after {word}")
        end = start + len(word)
        if not reader.n_loops and reader.refusal is None:
            reader.refusal = RefusalError(start, end, f"{word} is not in a loop")
        does = _settled(reader, nodes.Leave(start=start, end=end, ends_loop=word == "break"))
        return _Written(start=start, end=end, does=does)

    return read


_COMPOUND: dict[str, Callable[[_Statements, int], _Written]] = {
    "if": _if,
    "for": _for,
    "while": _while,
    "return": _return,
    "break": _jump("break"),
    "continue": _jump("continue"),
}


def _simple(reader: _Statements, *, may_declare: bool) -> _Written:
    token = reader.token
    if token.text in _REFUSED:
        raise RefusalError(token.start, token.end, f"{token.text} is not part of this language", _REFUSED[token.text])
    if token.text == "else":
        raise RefusalError(token.start, token.end, "this else has no if before it")
    is_type = token.text in TYPE_NAMES and not reader.next_is("(")
    if may_declare and (is_type or token.text in ("const", "CONST")):
        return _declaration(reader)
    return _assignment(reader)


def _declaration(reader: _Statements) -> _Written:
    start = reader.token.start
    is_const = reader.take_if("const", "CONST") is not None
    word = reader.token
    if word.text not in TYPE_NAMES:
        raise reader.unexpected("a type is missing", f"the types are {', '.join(TYPE_NAMES)}")
    reader.take()
    parts = [_declarator(reader, TYPE_NAMES[word.text], is_const=is_const)]
    while reader.take_if(","):
        parts.append(_declarator(reader, TYPE_NAMES[word.text], is_const=is_const))
    # the names before one that was refused are known, and so is its own
    does = [one for part in parts for one in part.does] if reader.end_statement() else ()
    depth = max(part.depth for part in parts)
    return _Written(start=start, end=reader.behind, depth=depth, does=does)


def _declarator(reader: _Statements, kind: Type, *, is_const: bool) -> _Written:
    token = reader.token
    if reader.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if token.kind is not Kind.NAME or token.text in RESERVED or token.text in TYPE_NAMES:
        raise reader.unexpected("a name is missing after the type")
    reader.take()
    if reader.at("["):
        raise RefusalError(token.start, token.end, "there are no arrays here", "use vec2, vec3 or vec4")
    if reader.at("("):
        message = "a block cannot define functions"
        raise RefusalError(token.start, token.end, message, "write the code where you need it")
    is_first_wrong = reader.refusal is None
    written = read_expression(reader) if reader.take_if("=") else None
    span = Offsets(token.start, token.end)
    depth = 1 if written is None else deepest(written)
    value = None
    if written is not None:
        value = reader.settle(operators.as_type, written.span, written.value, kind, f"the value of {token.text}")
    elif is_const and reader.refusal is None:
        reader.refusal = RefusalError(*span, f"{token.text} is const and has no value", f"write {token.text} = value")
    does: Sequence[nodes.Statement] = ()
    if is_first_wrong:
        does = _declared(reader, token, kind, value, is_const=is_const)
    return _Written(start=span.start, end=span.end, depth=depth, does=does)


def _declared(
    reader: _Statements, token: Token, kind: Type, value: Typed | None, *, is_const: bool
) -> Sequence[nodes.Statement]:
    # the name is known from its own declaration on, even if its value was refused; not inside of it
    try:
        slot = reader.scope.declare(token, kind, is_const=is_const).slot
    except RefusalError as refusal:
        reader.refusal = refusal
        return ()
    return (nodes.Store(start=token.start, end=token.end, slot=slot, type=kind, value=value, begins=True),)


def _assignment(reader: _Statements) -> _Written:
    start = reader.token.start
    prefix = reader.take_if("++", "--")
    # a target is read as a value first: only names, v.x and v[i] are more than that
    target = read_operand(reader)
    operator = prefix or reader.take_if(*ASSIGNING)
    if operator is None:
        if reader.token.kind is Kind.NAME and reader.behind < reader.token.start:
            raise RefusalError(start, reader.behind, "a type is not known", f"the types are {', '.join(TYPE_NAMES)}")
        raise RefusalError(
            start, reader.behind, "this statement does nothing", "assign its value to a variable, or return it"
        )
    variable = _target(reader, target)
    if operator.text in ("++", "--"):
        span = Offsets(operator.start, operator.end)
        value = Expression(start=span.start, end=span.end, value=operators.number(span, Type.INT, 1))
    elif operator.text[0] in "&|^<>":
        raise RefusalError(
            operator.start, operator.end, f"{operator.text} works on bits, which this language does not have"
        )
    else:
        value = read_expression(reader)
    span, sign = Offsets(start, reader.behind), operator.text[0].replace("=", "")
    does: Sequence[nodes.Statement] = ()
    if variable is not None:
        given = reader.settle(_assigned, span, target, sign, value)
        does = _settled(reader, _stored(span, variable, target.value, given))
    else:
        reader.end_statement()
    return _Written(start=span.start, end=span.end, depth=deepest(target, value), does=does)


def _target(reader: _Statements, target: Expression) -> Variable | None:
    """The variable that takes a value; what is wrong with it comes before what is wrong with its parts."""
    if reader.is_full:
        return None
    try:
        if target.variable is None:
            raise RefusalError(target.start, target.end, "only a variable or its components can get a value")
        variable = reader.scope.find(target.variable)
        if variable.fixed:
            name = target.variable
            message = f"{name.text} {variable.fixed} and cannot be changed"
            raise RefusalError(name.start, name.end, message, "declare a variable of your own")
    except RefusalError as refusal:
        reader.refusal = refusal
        return None
    parts = target.value.components if reader.refusal is None and isinstance(target.value, nodes.Read) else None
    if parts and len(set(parts)) < len(parts):
        reader.refusal = RefusalError(*target.span, "a component is named twice on the left of =")
    return variable


def _assigned(span: Offsets, target: Expression, sign: str, value: Expression) -> Typed:
    """The value that a target takes; `sign` is empty for ``=`` and ``+`` for ``+=`` and ``++``."""
    kind = target.value.type
    if not sign:
        return operators.as_type(value.span, value.value, kind, "the value")
    left, right = target.value, value.value
    law, result = operators.arithmetic_law(sign, left.type, right.type, span)
    if not fits(result, kind):
        message = f"{sign}= gives {operators.a(result)}, and the variable is {operators.a(kind)}"
        raise RefusalError(span.start, span.end, message)
    fold = nodes.Fold(start=span.start, end=span.end, type=result, operands=(left, right), functions=(law,))
    return operators.converted(fold, kind)


def _stored(span: Offsets, variable: Variable, target: Typed, value: Typed) -> nodes.Statement:
    if isinstance(target, nodes.PickAt):
        return nodes.StoreAt(
            start=span.start, end=span.end, slot=variable.slot, type=variable.type, index=target.index, value=value
        )
    components = target.components if isinstance(target, nodes.Read) else None
    return nodes.Store(
        start=span.start,
        end=span.end,
        slot=variable.slot,
        type=variable.type,
        value=value,
        begins=False,
        components=components,
    )
