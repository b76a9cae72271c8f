"""Syntax tree of a code block, before types: what the parser makes and the checker reads.

Every node knows where it stands (`start`, `end`: offsets in the text) and how many nodes lie on the longest way down
from it (`depth`), so that no reader of the tree needs more stack than MAX_NESTING allows. Operators of one
precedence stand side by side in one `Chain`: a sum of thousands of terms is one node deep.
"""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.atmosphere.language.refusal import RefusalError
from aomc_sky.atmosphere.language.types import Type

MAX_NESTING = 100


@dataclass(frozen=True, kw_only=True, slots=True)
class Node:
    """Anything with a place."""

    start: int
    end: int
    depth: int = 1

    def __post_init__(self) -> None:
        if self.depth > MAX_NESTING:
            message = f"operators and statements lie more than {MAX_NESTING} deep in each other here"
            raise RefusalError(self.start, self.start + 1, message, "give parts of it names of their own")


@dataclass(frozen=True, kw_only=True, slots=True)
class Number(Node):
    """A literal: True and False too."""

    type: Type
    value: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Name(Node):
    """A name that is read."""

    name: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Unary(Node):
    """``+``, ``-`` or ``!`` before a value."""

    operator: str
    operand: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Chain(Node):
    """Operands with operators of one precedence between them, worked out from the left."""

    operands: tuple[Node, ...]
    operators: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Choice(Node):
    """``a ? x : b ? y : z``: conditions with their values, and the last value."""

    cases: tuple[tuple[Node, Node], ...]
    otherwise: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Call(Node):
    """A function or a constructor with its arguments."""

    name: str
    arguments: tuple[Node, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Member(Node):
    """``v.xyz``."""

    base: Node
    letters: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Index(Node):
    """``v[i]``."""

    base: Node
    index: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Declarator(Node):
    """One name of a declaration."""

    name: str
    value: Node | None


@dataclass(frozen=True, kw_only=True, slots=True)
class Declaration(Node):
    """``const float a = 1, b = 2;``."""

    type: Type
    is_const: bool
    declarators: tuple[Declarator, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Assignment(Node):
    """``target op value``, where `operator` is empty for ``=`` and ``+`` for ``+=`` and ``++``."""

    target: Node
    operator: str
    value: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Body(Node):
    """Statements between braces."""

    statements: tuple[Node, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class If(Node):
    """``if`` with all its ``else if``, and the last ``else``."""

    cases: tuple[tuple[Node, Node], ...]
    otherwise: Node | None


@dataclass(frozen=True, kw_only=True, slots=True)
class Loop(Node):
    """``for`` and ``while``; an absent condition holds for ever."""

    first: Node | None
    condition: Node | None
    step: Node | None
    body: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Return(Node):
    """``return value;``."""

    value: Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Jump(Node):
    """``break`` or ``continue``."""

    word: str


def deepest(*nodes: Node | None) -> int:
    """Return the depth of a node above these."""
    return 1 + max((node.depth for node in nodes if node is not None), default=0)
