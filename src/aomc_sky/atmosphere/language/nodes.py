"""Types of values, and the tree of a code block with all types settled: the parser makes it, the evaluator runs it."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


class Type(enum.Enum):
    """Type of a value: a truth, a whole number of 32 bits, a real number, two to four real numbers."""

    BOOL = "bool"
    INT = "int"
    FLOAT = "float"
    VEC2 = "vec2"
    VEC3 = "vec3"
    VEC4 = "vec4"

    @property
    def n_components(self) -> int:
        """Number of numbers in it, 1 for a scalar."""
        return {Type.VEC2: 2, Type.VEC3: 3, Type.VEC4: 4}.get(self, 1)

    @property
    def is_vector(self) -> bool:
        """Whether it has components."""
        return self.n_components > 1

    @property
    def is_number(self) -> bool:
        """Whether arithmetic takes it as a scalar."""
        return self in (Type.INT, Type.FLOAT)


VECTORS = {2: Type.VEC2, 3: Type.VEC3, 4: Type.VEC4}


def fits(given: Type, expected: Type) -> bool:
    """Whether a value of one type may stand where another is expected: the same, or a whole number as a real one."""
    return given is expected or (given is Type.INT and expected is Type.FLOAT)


def joined(left: Type, right: Type) -> Type | None:
    """Return the type that both values can take without loss, None where there is none."""
    if fits(left, right):
        return right
    return left if fits(right, left) else None


def of_arithmetic(left: Type, right: Type) -> Type | None:
    """Return the type of left + right, - or * or /; None where GLSL has no such operation."""
    if Type.BOOL in (left, right):
        return None
    if left.is_vector and right.is_vector:
        return left if left is right else None
    if left.is_vector:
        return left
    return right if right.is_vector else joined(left, right)


@dataclass(frozen=True, kw_only=True, slots=True)
class Function:
    """One operation on values of known types."""

    name: str  #: as a user writes it
    apply: Callable[..., Any]
    faults: tuple[tuple[Callable[..., Any], str], ...] = ()  #: lanes where GLSL leaves the result open, and what to say
    #: whole numbers that change where the law goes over to another branch: between lanes of equal numbers it is smooth
    decides: Callable[..., Any] | None = None


class Offsets(NamedTuple):
    """Where something stands in the text."""

    start: int
    end: int


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
