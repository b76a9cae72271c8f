"""Names that a block may read and write, by the braces they live in."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass

from aomc_sky.atmosphere.language.functions import BUILT_INS
from aomc_sky.atmosphere.language.refusal import RefusalError
from aomc_sky.atmosphere.language.syntax import Declarator, Name
from aomc_sky.atmosphere.language.types import Type

MAX_VARIABLES = 500


@dataclass(frozen=True, kw_only=True, slots=True)
class Variable:
    """A name with its type; `slot` is where the evaluator keeps its value."""

    name: str
    type: Type
    slot: int
    fixed: str = ""


class Scope:
    """Blocks of names, the innermost last.

    Parameters
    ----------
    given : mapping of str to Type
        Names with values that a block reads and cannot change.
    argument : str
        The float that the block is a function of; the block may change it, as in GLSL.
    hints : mapping of str to str
        Names that other blocks have and this one has not, with what to do instead.
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

    def open(self) -> None:
        """Begin a pair of braces."""
        self._frames.append({})

    def close(self) -> None:
        """End them, and the names inside."""
        self._frames.pop()

    def declare(self, declarator: Declarator, kind: Type, *, is_const: bool) -> Variable:
        """Begin a variable in the innermost braces."""
        name = declarator.name
        if name in self._frames[-1]:
            message = f"{name} is declared twice" if name != self.argument.name else f"{name} is the block's argument"
            raise RefusalError(declarator.start, declarator.end, message, "take another name, or leave out the type")
        if self.n_slots >= MAX_VARIABLES:
            raise RefusalError(declarator.start, declarator.end, f"the block has more than {MAX_VARIABLES} variables")
        self._frames[-1][name] = self._new(name, kind, "is const" if is_const else "")
        return self._frames[-1][name]

    def find(self, name: Name) -> Variable:
        """Return the variable that a name means, or refuse the name with the nearest known one."""
        for frame in reversed(self._frames):
            if name.name in frame:
                return frame[name.name]
        raise RefusalError(name.start, name.end, f"the name {name.name[:60]} is not known", self._advice(name.name))

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
