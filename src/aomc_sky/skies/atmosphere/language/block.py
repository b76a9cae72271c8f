"""A code block as a function of many altitudes or cosines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import InputFileError, SourceText
from aomc_sky.skies.atmosphere.language.lexer import Problems, RefusalError, Span
from aomc_sky.skies.atmosphere.language.statements import Body, Statement
from aomc_sky.skies.atmosphere.language.values import Run, Type

# lanes that are worked out together: bounds the memory of MAX_VARIABLES vectors, and stays in the cache
_LANES = 4096


@dataclass(frozen=True, kw_only=True, slots=True)
class Block:
    """A code block that was read; calling it evaluates it. Pure: equal arguments give equal bits."""

    source: SourceText  #: the block as written
    subject: str  #: what it gives, for messages: ``number density of "ozone"``
    gives: Type
    argument: str  #: what it is a function of
    unit: str  #: of the argument, for messages; may be empty
    given: tuple[str, ...]  #: names that have values from outside
    n_variables: int
    body: Statement

    def __call__(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """Values at altitudes or cosines (n,): shape (n,), or (n_component, n) where the block gives a vector.

        They may be infinite or NaN. An InputFileError where the block has no defined value at one of the arguments.
        """
        return np.concatenate([self._run(part, given).result for part in _parts(argument)], axis=-1)

    def trace(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """A number (n,) uint64 for the way that each argument takes through the block.

        The block is smooth between neighbours of equal numbers: they take the same branch of every condition and of
        every function with a bend (``abs``, ``min``, ``floor``). The numbers are hashes; two different ways are equal
        with a probability of 5e-20.
        """
        return np.concatenate([self._run(part, given, traces=True).trace for part in _parts(argument)])

    def _run(self, lanes: np.ndarray, given: Mapping[str, np.ndarray | float], *, traces: bool = False) -> Run:
        values = [np.asarray(given[name], np.float64)[..., None] for name in self.given]
        run = Run(
            values=[*values, lanes] + [lanes] * (self.n_variables - len(values) - 1),
            result=np.zeros((self.gives.size, lanes.size) if self.gives.is_vector else lanes.size),
            where=lambda lane: f"{self.argument} {lanes[lane]:.12g} {self.unit}".rstrip(),
            trace=np.zeros(lanes.size, np.uint64) if traces else None,
        )
        try:
            with np.errstate(all="ignore"):
                self.body.run(run, np.ones(lanes.size, np.bool_))
        except RefusalError as refusal:
            raise self._refused(refusal) from None
        return run

    def _refused(self, refusal: RefusalError) -> InputFileError:
        problems = Problems(self.source, self.subject)
        problems.add(refusal)
        return InputFileError(problems.found)

    def refused_at(self, argument: float | None, message: str, advice: str = "") -> InputFileError:
        """Return the error for a wrong value, at one argument or (None) as a whole."""
        first = len(self.source.text) - len(self.source.text.lstrip())
        if argument is not None:
            message = f"{message}, {self.argument} {argument:.12g} {self.unit}".rstrip()
        return self._refused(RefusalError(Span(first, first + 1), message, advice))


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
    """Read a code block: the body of a GLSL function of one float. An InputFileError has all its problems.

    `given` are the names that it can read, with their types; `hints` are names that it cannot read, with what to do
    about them. A block becomes functions of this package that call each other; its text never reaches Python or a
    compiler.
    """
    body = Body(Problems(source, subject), gives, given or {}, argument, hints or {})
    statement = body.read()
    return Block(
        source=source,
        subject=subject,
        gives=gives,
        argument=argument,
        unit=unit,
        given=tuple(given or {}),
        n_variables=body.n_variables,
        body=statement,
    )
