"""Statements: a block is the body of a function, read in one pass; every way through it ends with a value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from aomc_sky.skies.atmosphere.language.expressions import ASSIGNING, NO_OPERATORS, TYPE_NAMES, Expressions, Value, law
from aomc_sky.skies.atmosphere.language.lexer import Kind, Problems, RefusalError, Span, Token, read_tokens
from aomc_sky.skies.atmosphere.language.values import Array, Run, Type

_NO_STATEMENTS = {
    **dict.fromkeys(("for", "while", "do"), "there are no loops; write the terms one by one"),
    "switch": "write it with if and else",
    "else": "it has no if before it",
    "}": "it has no { before it in the block; remove it",
}
_TYPES = f"the types are {', '.join(TYPE_NAMES)}"
_WORDS = {*_NO_STATEMENTS, *TYPE_NAMES, "if", "return", "const", "CONST", "true", "false"}


class Statement(NamedTuple):
    """A statement: `run` takes the lanes that it concerns, and returns those that go on behind it."""

    run: Callable[[Run, Array], Array]
    ends: bool = False  #: every way through it returns a value


class Body(Expressions):
    """Reads the statements of a block that gives a value of some type."""

    def __init__(
        self, problems: Problems, gives: Type, given: Mapping[str, Type], argument: str, hints: Mapping[str, str]
    ) -> None:
        super().__init__(read_tokens(problems), given, argument, hints)
        self._problems = problems
        self._gives = gives
        self._lost: set[str] = set()  # names of declarations that were refused: one message is enough

    def read(self) -> Statement:
        """Read the whole block; an InputFileError has one problem of every statement that is wrong."""
        body = self._sequence()
        if not self._problems.found and not body.ends:
            message = f"the block can end without a value; it must return {self._gives.named}"
            self._problems.add(RefusalError(self.token.span, message, "write return and a value at its end"))
        self._problems.raise_found()
        return body

    def _sequence(self, opened: Token | None = None) -> Statement:
        """Read statements up to the brace that closes the opened one, or to the end; what is wrong is noted."""
        statements: list[Statement] = []
        while self.token.kind is not Kind.END and not (opened and self.at("}")):
            start = self._index
            try:
                statements.append(self._statement())
            except RefusalError as refusal:
                if self._problems.source.text[slice(*refusal.span)] not in self._lost:
                    self._problems.add(refusal)
                self._skip_statement()
                passed = self._tokens[start : self._index]
                declared = {b.text for a, b in pairwise(passed) if a.kind is b.kind is Kind.NAME}
                self._lost |= declared - self._names[-1].keys()
        if opened and not self.take_if("}"):
            message = "this { is not closed in the block"
            self._problems.add(RefusalError(opened.span, message, "write } after its statements"))

        def run(run: Run, mask: Array) -> Array:
            for one in statements:
                mask = one.run(run, mask)
                if not mask.any():
                    break
            return mask

        return Statement(run, ends=any(one.ends for one in statements))

    def _skip_statement(self) -> None:
        """Go behind the statement that could not be read: its ``;`` or the braces that it opened, and its else."""
        n_open = 0
        while self.token.kind is not Kind.END and not (n_open <= 0 and self.at("}")):
            token = self.take()
            n_open += {"{": 1, "(": 1, "}": -1, ")": -1}.get(token.text, 0)
            if n_open <= 0 and token.text in (";", "}") and not self.at("else"):
                return

    def _statement(self) -> Statement:
        token = self.token
        with self.deeper():
            if self.take_if(";"):
                return Statement(lambda run, mask: mask)
            if self.take_if("{"):
                with self.braces():
                    return self._sequence(token)
            if self.take_if("if"):
                return self._if()
            if self.take_if("return"):
                statement = self._return()
            elif self.at("const", "CONST") or (self.at(*TYPE_NAMES) and self.after.text != "("):
                statement = self._declaration()
            else:
                statement = self._assignment()
        self.expect(";", "at the end of the statement")
        return statement

    def _if(self) -> Statement:
        cases: list[tuple[Value, Statement]] = []
        otherwise: Statement | None = None
        has_case = True
        while has_case:
            self.expect("(", "after if")
            condition = self.expression().as_type(Type.BOOL, "the condition")
            self.expect(")", "after the condition")
            cases.append((condition, self._inner()))
            has_else = self.take_if("else")
            has_case = has_else is not None and self.take_if("if") is not None
            if has_else and not has_case:
                otherwise = self._inner()

        def run(run: Run, mask: Array) -> Array:
            goes_on = np.zeros_like(mask)
            for condition, body in cases:
                truth = condition.run(run, mask)
                taken = mask & truth
                if taken.any():
                    goes_on |= body.run(run, taken)
                mask = mask & ~truth
                if not mask.any():
                    return goes_on
            return goes_on | (mask if otherwise is None else otherwise.run(run, mask))

        return Statement(run, ends=otherwise is not None and all(body.ends for _, body in [*cases, (None, otherwise)]))

    def _inner(self) -> Statement:
        with self.braces():
            return self._statement()

    def _return(self) -> Statement:
        if self.at(";"):
            raise self.unexpected("return has no value", "write return and a value")
        value = self.expression().as_type(self._gives, "the value that is returned")

        def run(run: Run, mask: Array) -> Array:
            np.copyto(run.result, value.run(run, mask), where=mask)
            return np.zeros_like(mask)

        return Statement(run, ends=True)

    def _declaration(self) -> Statement:
        is_const = self.take_if("const", "CONST") is not None
        kind = TYPE_NAMES.get(self.token.text)
        if kind is None:
            raise self.unexpected("a type is missing", _TYPES)
        self.take()
        parts = [self._declarator(kind, is_const=is_const)]
        while self.take_if(","):
            parts.append(self._declarator(kind, is_const=is_const))

        def run(run: Run, mask: Array) -> Array:
            for part in parts:
                part(run, mask)
            return mask

        return Statement(run)

    def _declarator(self, kind: Type, *, is_const: bool) -> Callable[[Run, Array], None]:
        token = self.token
        if "[" in (token.text, self.after.text):
            raise RefusalError(token.span, "there are no arrays here", "use vec2, vec3 or vec4")
        if token.kind is not Kind.NAME or token.text in _WORDS:
            raise self.unexpected("a name is missing after the type")
        self.take()
        if self.at("("):
            raise RefusalError(token.span, "a block cannot define functions", "write the code where you need it")
        value = None
        try:
            if self.take_if("="):
                value = self.expression().as_type(kind, f"the value of {token.text[:60]}")
            elif is_const:
                message = f"{token.text[:60]} is const and has no value"
                raise RefusalError(token.span, message, f"write {token.text[:60]} = value")
        finally:
            # the name is known behind its own declaration, even if its value was refused
            variable = self.declare(token, kind, is_const=is_const, may_be_empty=value is None)

        def run(run: Run, mask: Array) -> None:
            shape = (kind.size, 1) if kind.is_vector else (1,)
            run.values[variable.slot] = np.full(shape, np.nan) if value is None else value.run(run, mask)

        return run

    def _assignment(self) -> Statement:
        token = self.token
        if token.text in _NO_STATEMENTS:
            if self.at("}"):
                self.take()
            raise RefusalError(token.span, f"{token.text} cannot stand here", _NO_STATEMENTS[token.text])
        if token.kind is self.after.kind is Kind.NAME:
            raise RefusalError(token.span, "a type is not known", _TYPES)
        # a target is read as a value first
        target = self.operand()
        operator = self.token
        if operator.text in NO_OPERATORS:
            message = f"the operator {operator.text} is not part of this language"
            raise RefusalError(operator.span, message, NO_OPERATORS[operator.text])
        if operator.text not in ASSIGNING:
            message = "this statement does nothing"
            raise RefusalError(target.span, message, "assign its value to a variable, or return it")
        self.take()
        return self._stored(target, operator.text[:-1])

    def _stored(self, target: Value, sign: str) -> Statement:
        variable, components = target.variable, target.components
        if variable is None:
            raise RefusalError(target.span, "only a variable or its components can get a value")
        if variable.fixed:
            span = Span(target.span.start, target.span.start + len(variable.name))
            message = f"{variable.name} {variable.fixed} and cannot be changed"
            raise RefusalError(span, message, "declare a variable of your own")
        if components and len(set(components)) < len(components):
            raise RefusalError(target.span, "a component is named twice on the left of =")
        value = self.expression()
        span = Span(target.span.start, value.span.end)
        if not sign:
            value = value.as_type(target.type, "the value")
            work_out = value.run
        else:
            function, kind = law(sign, target.type, value.type, span)
            if kind.joined(target.type) is not target.type:
                message = f"{sign}= gives {kind.named}, and the variable is {target.type.named}"
                raise RefusalError(span, message)

            def work_out(run: Run, mask: Array) -> Array:
                return run.apply(span, kind, function, [target.run(run, mask), value.run(run, mask)], mask)

        def run(run: Run, mask: Array) -> Array:
            run.store(variable.slot, components, work_out(run, mask), mask)
            return mask

        return Statement(run)
