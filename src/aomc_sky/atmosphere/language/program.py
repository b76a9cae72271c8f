"""A code block with all types settled: what the checker makes and the evaluator runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.language.functions import Function
from aomc_sky.atmosphere.language.types import Type


@dataclass(frozen=True, kw_only=True, slots=True)
class Typed:
    """An expression: its place in the text and the type of its value."""

    start: int
    end: int
    type: Type


@dataclass(frozen=True, kw_only=True, slots=True)
class Constant(Typed):
    """A literal."""

    value: np.ndarray


@dataclass(frozen=True, kw_only=True, slots=True)
class Read(Typed):
    """The value of a variable, or of some components of it."""

    slot: int
    components: tuple[int, ...] | None
    name: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Operation(Typed):
    """A function of values."""

    function: Function
    operands: tuple[Typed, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Fold(Typed):
    """Values joined from the left; `functions[i]` joins what there is with ``operands[i + 1]``."""

    functions: tuple[Function, ...]
    operands: tuple[Typed, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Logic(Typed):
    """``&&`` (stops at False) or ``||`` (stops at True)."""

    stops_at: bool
    operands: tuple[Typed, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Choose(Typed):
    """The value of the first case whose condition holds, else the last value."""

    cases: tuple[tuple[Typed, Typed], ...]
    otherwise: Typed


@dataclass(frozen=True, kw_only=True, slots=True)
class Pick(Typed):
    """Some components of a vector."""

    base: Typed
    components: tuple[int, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class PickAt(Typed):
    """The component of a vector that a whole number names."""

    base: Typed
    index: Typed


@dataclass(frozen=True, kw_only=True, slots=True)
class Statement:
    """Something that is done; its place in the text."""

    start: int
    end: int


@dataclass(frozen=True, kw_only=True, slots=True)
class Store(Statement):
    """Put a value into a variable that begins here, into a known one, or into some components of it.

    `value` None begins a variable without one.
    """

    slot: int
    type: Type
    value: Typed | None
    begins: bool
    components: tuple[int, ...] | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class StoreAt(Statement):
    """Put a number into the component of a vector that a whole number names."""

    slot: int
    type: Type
    index: Typed
    value: Typed


@dataclass(frozen=True, kw_only=True, slots=True)
class Sequence(Statement):
    """One after the other."""

    statements: tuple[Statement, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Branch(Statement):
    """The statements of the first case whose condition holds, else the last ones."""

    cases: tuple[tuple[Typed, Statement], ...]
    otherwise: Statement | None


@dataclass(frozen=True, kw_only=True, slots=True)
class Repeat(Statement):
    """A loop."""

    first: Statement | None
    condition: Typed | None
    step: Statement | None
    body: Statement


@dataclass(frozen=True, kw_only=True, slots=True)
class Give(Statement):
    """End the block with a value."""

    value: Typed


@dataclass(frozen=True, kw_only=True, slots=True)
class Leave(Statement):
    """End the round of the innermost loop, or the loop."""

    ends_loop: bool
