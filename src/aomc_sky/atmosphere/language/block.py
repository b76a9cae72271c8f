"""A code block as a function of many altitudes or cosines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.language.evaluate import Evaluator
from aomc_sky.atmosphere.language.nodes import Sequence, Type
from aomc_sky.atmosphere.language.refusal import Problems, RefusalError
from aomc_sky.atmosphere.language.scope import Scope, Variable
from aomc_sky.atmosphere.language.statements import read_body
from aomc_sky.errors import SourceText

# lanes that are worked out together: bounds the memory of MAX_VARIABLES vectors, and stays in the cache
_LANES = 4096


@dataclass(frozen=True, kw_only=True, slots=True)
class Block:
    """A checked code block; calling it evaluates it. Pure: equal arguments give equal bits."""

    source: SourceText  #: the block as it stands in its file
    subject: str  #: what it gives, for messages: ``number density of "ozone"``
    gives: Type
    argument: Variable  #: what it is a function of
    unit: str  #: of the argument, for messages; may be empty
    given: tuple[Variable, ...]  #: names that have values from outside
    body: Sequence
    n_slots: int  #: number of its variables

    def __call__(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """Values at altitudes or cosines (n,): shape (n,), or (n_component, n) where the block gives a vector.

        They are not looked at: they may be infinite or NaN. An InputFileError where the block has no defined value at
        one of the arguments, or takes too many steps. Accuracy: IEEE float64 for ``+ - * /`` and sqrt, in the order
        written; about 1 ulp for other functions.
        """
        return np.concatenate([self._run(part, given).result for part in _parts(argument)], axis=-1)

    def trace(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """A number (n,) uint64 for the way that each argument takes through the block.

        Where two neighbours have equal numbers, they take the same branch of every condition and of every function
        with a bend (``abs``, ``min``, ``floor``): the block is smooth between them. The numbers are hashes; two
        different ways are equal with a probability of 5e-20.
        """
        return np.concatenate([self._run(part, given, traces=True).trace for part in _parts(argument)])

    def _run(self, lanes: np.ndarray, given: Mapping[str, np.ndarray | float], *, traces: bool = False) -> Evaluator:
        def where(lane: int) -> str:
            return f"{self.argument.name} {lanes[lane]:.12g}{' ' if self.unit else ''}{self.unit}"

        run = Evaluator(self.gives, self.n_slots, lanes.size, where, traces=traces)
        run.give(self.argument.slot, lanes)
        for variable in self.given:
            kind = np.int64 if variable.type is Type.INT else np.float64
            run.give(variable.slot, np.asarray(given[variable.name], dtype=kind)[..., None])
        try:
            run.run(self.body)
        except RefusalError as refusal:
            raise self.refused(refusal) from None
        return run

    def refused(self, refusal: RefusalError) -> Exception:
        """Return the error that says a refusal with the place of the block in its file."""
        problems = Problems(self.source, self.subject)
        problems.add(refusal)
        return problems.error()

    def refused_at(self, argument: float | None, message: str, advice: str = "") -> Exception:
        """Return the error for a value that nobody can take, at one argument or (None) as a whole."""
        first = len(self.source.text) - len(self.source.text.lstrip())
        if argument is not None:
            message = f"{message}, {self.argument.name} {argument:.12g} {self.unit}".rstrip()
        return self.refused(RefusalError(first, first + 1, message, advice))


def _parts(argument: np.ndarray) -> list[np.ndarray]:
    # the variables of one part are let go before the next begins
    lanes = np.asarray(argument, dtype=np.float64).ravel()
    return [lanes[start : start + _LANES] for start in range(0, max(lanes.size, 1), _LANES)]


def read_block(
    source: SourceText,
    *,
    subject: str,
    gives: Type,
    argument: str,
    unit: str = "",
    given: Mapping[str, Type] | None = None,
    hints: Mapping[str, str] | None = None,
) -> Block:
    """Read a code block: a body of a GLSL function of one float, of at most 64 KiB.

    `given` are the names that it can read, with their types; `hints` names that it cannot read, with what to do about
    them; `subject` and `unit` stand in messages. An InputFileError has all its problems.

    The text is data from first to last: a lexer and a parser of our own make a tree of it, and nothing that a block
    says is ever handed to Python or to a compiler.
    """
    problems = Problems(source, subject)
    scope = Scope(given or {}, argument, hints or {})
    body = read_body(problems, scope, gives)
    return Block(
        source=source,
        subject=subject,
        gives=gives,
        argument=scope.argument,
        unit=unit,
        given=scope.given,
        body=body,
        n_slots=scope.n_slots,
    )
