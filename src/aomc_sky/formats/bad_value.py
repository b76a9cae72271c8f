"""What is wrong with a piece of a value, before it is known where in which file the value stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

MAX_PER_VALUE = 20
"""Problems of one value that are told; a list of thousands of words is better told once."""


class BadValueError(Exception):
    """Raised by the parsers of values; the reader of the file adds path, line and column.

    Parameters
    ----------
    code : str
        As in `aomc_sky.errors.Problem`.
    message, advice : str
        What was found and what was allowed; what to write instead.
    offset, width : int
        First offending character of the value and how many to underline; width 0 is the whole value.

    Attributes
    ----------
    more : tuple of BadValueError
        Further problems of the same value, `MAX_PER_VALUE` at most.
    """

    def __init__(self, code: str, message: str, *, advice: str = "", offset: int = 0, width: int = 0) -> None:
        self.code = code
        self.message = message
        self.advice = advice
        self.offset = offset
        self.width = width
        self.more: tuple[BadValueError, ...] = ()
        super().__init__(message)


class Gathered:
    """Problems of the parts of one value, all raised together."""

    def __init__(self) -> None:
        self._problems: list[BadValueError] = []

    def attempt(self, parse: Callable[[], T]) -> T | None:
        """What a part says, or None where it is bad."""
        try:
            return parse()
        except BadValueError as problem:
            self._problems.append(problem)
            return None

    @property
    def is_full(self) -> bool:
        """Whether enough is told."""
        return len(self._problems) >= MAX_PER_VALUE

    def close(self) -> None:
        """Raise the first problem, with the others behind it."""
        if self._problems:
            first, *rest = self._problems
            first.more = tuple(rest)
            raise first


def quoted(text: str) -> str:
    """A piece of a file as a message shows it: in quotes, short, without what would disturb a terminal."""
    shown = text if len(text) <= 40 else f"{text[:37]}..."
    return "'" + "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown) + "'"
