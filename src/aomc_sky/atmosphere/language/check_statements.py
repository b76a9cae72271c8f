"""Types of statements, scopes, and whether every way through a block ends with a value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from aomc_sky.atmosphere.language import program, syntax
from aomc_sky.atmosphere.language.check_expressions import (
    a,
    arithmetic_law,
    checked,
    checked_as,
    checked_index,
    components_of,
    converted,
    fixed_index,
)
from aomc_sky.atmosphere.language.refusal import Problems, RefusalError
from aomc_sky.atmosphere.language.scope import Scope, Variable
from aomc_sky.atmosphere.language.types import VECTORS, Type, fits


class StatementChecker:
    """Goes through the statements of one block.

    Parameters
    ----------
    scope : Scope
        Names to begin with.
    gives : Type
        What the block gives.
    problems : Problems
        Takes one problem of each statement.
    """

    def __init__(self, scope: Scope, gives: Type, problems: Problems) -> None:
        self._scope = scope
        self._gives = gives
        self._problems = problems
        self._n_loops = 0

    def check(self, body: syntax.Body) -> program.Sequence:
        """Return the block with all types settled.

        Raises
        ------
        InputFileError
            With the problems of all statements.
        """
        statements = self._each(body.statements)
        if not self._problems.found and not _ends(body):
            message = f"the block can end without a value; it gives {a(self._gives)}"
            self._problems.add(RefusalError(body.end, body.end, message, "write return and a value at its end"))
        self._problems.raise_found()
        return program.Sequence(start=body.start, end=body.end, statements=statements)

    def _each(self, nodes: tuple[syntax.Node, ...]) -> tuple[program.Statement, ...]:
        statements: list[program.Statement] = []
        for node in nodes:
            try:
                statements += _CHECKS[type(node)](self, node)
            except RefusalError as refusal:
                self._problems.add(refusal)
        return tuple(statements)

    def _inner(self, node: syntax.Node) -> program.Sequence:
        self._scope.open()
        nodes = node.statements if isinstance(node, syntax.Body) else (node,)
        statements = self._each(nodes)
        self._scope.close()
        return program.Sequence(start=node.start, end=node.end, statements=statements)

    def _body(self, node: syntax.Body) -> list[program.Statement]:
        return [self._inner(node)]

    def _declaration(self, node: syntax.Declaration) -> list[program.Statement]:
        return [self._declared(node, one) for one in node.declarators]

    def _declared(self, node: syntax.Declaration, one: syntax.Declarator) -> program.Statement:
        # the name is known from its own declaration on, even if its value was refused; not inside of it
        refusal, value = None, None
        try:
            if one.value is not None:
                value = checked_as(one.value, self._scope, node.type, f"the value of {one.name}")
            elif node.is_const:
                raise RefusalError(
                    one.start, one.end, f"{one.name} is const and has no value", f"write {one.name} = value"
                )
        except RefusalError as found:
            refusal = found
        variable = self._scope.declare(one, node.type, is_const=node.is_const)
        if refusal is not None:
            raise refusal
        return program.Store(start=one.start, end=one.end, slot=variable.slot, type=node.type, value=value, begins=True)

    def _assignment(self, node: syntax.Assignment) -> list[program.Statement]:
        target = node.target
        base = target.base if isinstance(target, syntax.Member | syntax.Index) else target
        if not isinstance(base, syntax.Name):
            raise RefusalError(target.start, target.end, "only a variable or its components take a value")
        variable = self._scope.find(base)
        if variable.fixed:
            advice = "declare a variable of your own"
            raise RefusalError(base.start, base.end, f"{base.name} {variable.fixed} and cannot be changed", advice)
        index = fixed_index(target, variable.type) if isinstance(target, syntax.Index) else None
        if isinstance(target, syntax.Index) and index is None:
            return [self._store_at(node, target, variable)]
        components: tuple[int, ...] | None = None if index is None else (index,)
        if isinstance(target, syntax.Member):
            components = components_of(target, variable.type)
        return [self._store(node, variable, components)]

    def _store(
        self, node: syntax.Assignment, variable: Variable, components: tuple[int, ...] | None
    ) -> program.Statement:
        if components and len(set(components)) < len(components):
            raise RefusalError(node.target.start, node.target.end, "a component is named twice on the left of =")
        kind = variable.type if components is None else VECTORS.get(len(components), Type.FLOAT)
        value = self._value(node, kind)
        return program.Store(
            start=node.start,
            end=node.end,
            slot=variable.slot,
            type=variable.type,
            value=value,
            begins=False,
            components=components,
        )

    def _store_at(self, node: syntax.Assignment, target: syntax.Index, variable: Variable) -> program.Statement:
        index = checked_index(target, self._scope)
        value = self._value(node, Type.FLOAT)
        return program.StoreAt(
            start=node.start, end=node.end, slot=variable.slot, type=variable.type, index=index, value=value
        )

    def _value(self, node: syntax.Assignment, kind: Type) -> program.Typed:
        if not node.operator:
            return checked_as(node.value, self._scope, kind, "the value")
        left, right = checked(node.target, self._scope), checked(node.value, self._scope)
        law, result = arithmetic_law(node.operator, left.type, right.type, node.start, node.end)
        if not fits(result, kind):
            message = f"{node.operator}= gives {a(result)}, and the variable is {a(kind)}"
            raise RefusalError(node.start, node.end, message)
        fold = program.Fold(start=node.start, end=node.end, type=result, operands=(left, right), functions=(law,))
        return converted(fold, kind)

    def _if(self, node: syntax.If) -> list[program.Statement]:
        cases = []
        for condition, body in node.cases:
            truth = self._condition(condition)
            cases.append((truth, self._inner(body)))
        otherwise = None if node.otherwise is None else self._inner(node.otherwise)
        if any(truth is None for truth, _ in cases):
            return []
        typed = tuple((truth, body) for truth, body in cases if truth is not None)
        return [program.Branch(start=node.start, end=node.end, cases=typed, otherwise=otherwise)]

    def _condition(self, node: syntax.Node) -> program.Typed | None:
        # noted at once, so that the statements behind a wrong condition are looked at too
        try:
            return checked_as(node, self._scope, Type.BOOL, "the condition")
        except RefusalError as refusal:
            self._problems.add(refusal)
            return None

    def _loop(self, node: syntax.Loop) -> list[program.Statement]:
        self._scope.open()
        self._n_loops += 1
        first = self._part(node.first)
        condition = None if node.condition is None else self._condition(node.condition)
        step = self._part(node.step)
        body = self._inner(node.body)
        self._n_loops -= 1
        self._scope.close()
        return [program.Repeat(start=node.start, end=node.end, first=first, condition=condition, step=step, body=body)]

    def _part(self, node: syntax.Node | None) -> program.Sequence | None:
        if node is None:
            return None
        return program.Sequence(start=node.start, end=node.end, statements=self._each((node,)))

    def _return(self, node: syntax.Return) -> list[program.Statement]:
        value = checked_as(node.value, self._scope, self._gives, "the value that is returned")
        return [program.Give(start=node.start, end=node.end, value=value)]

    def _jump(self, node: syntax.Jump) -> list[program.Statement]:
        if not self._n_loops:
            raise RefusalError(node.start, node.end, f"{node.word} stands in no loop")
        return [program.Leave(start=node.start, end=node.end, ends_loop=node.word == "break")]


def _ends(node: syntax.Node | None) -> bool:
    """Whether every way through a statement meets a return; a loop may have no round at all."""
    if isinstance(node, syntax.Body):
        return any(_ends(one) for one in node.statements)
    if isinstance(node, syntax.If):
        return _ends(node.otherwise) and all(_ends(body) for _, body in node.cases)
    return isinstance(node, syntax.Return)


_CHECKS: dict[type, Callable[[StatementChecker, Any], list[program.Statement]]] = {
    syntax.Body: StatementChecker._body,
    syntax.Declaration: StatementChecker._declaration,
    syntax.Assignment: StatementChecker._assignment,
    syntax.If: StatementChecker._if,
    syntax.Loop: StatementChecker._loop,
    syntax.Return: StatementChecker._return,
    syntax.Jump: StatementChecker._jump,
}
