"""Names that a block may read and write, by the braces they live in."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from aomc_sky.atmosphere.language.functions import BUILT_INS
from aomc_sky.atmosphere.language.lexer import Token
from aomc_sky.atmosphere.language.nodes import Type
from aomc_sky.atmosphere.language.refusal import RefusalError

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
