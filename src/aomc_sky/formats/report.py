"""Problems of a file, gathered to its end, and texts of their messages."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TypeVar

from aomc_sky.errors import NOWHERE, InputFileError, InputWarning, Problem, Span

T = TypeVar("T")

MAX_PROBLEMS = 200
MAX_PER_VALUE = 20
"""Problems that are reported for one value."""


@dataclass(kw_only=True, slots=True)
class Report:
    """Problems of one file, gathered until the file has been read to its end."""

    path: str  #: Path of the file, as the user named it
    lenient: bool = False  #: Problems that may be downgraded become warnings
    downgrade: frozenset[str] = frozenset()  #: Codes that become warnings in any case
    counts_bytes: bool = False  #: Columns and texts of the file are those of its bytes, as Fortran has them
    problems: list[Problem] = field(default_factory=list)
    n_errors: int = 0
    #: Whether there are enough errors to stop reading; warnings alone never stop a reader
    is_full: bool = field(init=False, default=False)

    def add(self, code: str, message: str, *, name: str = "", advice: str = "", is_warning: bool = False) -> None:
        """Note a problem of the file as a whole."""
        self.at(NOWHERE, code, message, name=name, advice=advice, is_warning=is_warning)

    def at(
        self,
        span: Span,
        code: str,
        message: str,
        *,
        name: str = "",
        advice: str = "",
        can_downgrade: bool = False,
        is_warning: bool = False,
    ) -> None:
        """Note a problem at a piece of the file; `can_downgrade` lets --lenient turn it into a warning."""
        is_error = not is_warning and not (can_downgrade and self.lenient) and code not in self.downgrade
        self.n_errors += is_error
        self.is_full = self.has_errors and len(self.problems) >= MAX_PROBLEMS - 1
        if len(self.problems) >= MAX_PROBLEMS and not (is_error and self.n_errors == 1):
            return  # enough for a person; but the only error among warnings is never lost
        if self.counts_bytes and not span.text.isascii():
            start, message = span.column - 1, _as_typed(message)
            column, width = (len(_as_typed(part)) for part in (span.text[:start], span.text[start:][: span.width]))
            span = Span(span.line, column + 1, _as_typed(span.text), max(width, 1))
        problem = span.problem(self.path, code, message, field=name, advice=advice, is_error=is_error)
        self.problems.append(problem)

    def bad_value(self, span: Span, problem: BadValueError, *, name: str = "") -> None:
        """Note the problem of the value in `span`."""
        part = span.part(problem.offset, problem.width or span.width)
        self.at(part, problem.code, problem.message, name=name, advice=problem.advice)

    @property
    def has_errors(self) -> bool:
        """Whether anything noted so far is an error."""
        return self.n_errors > 0

    def close(self) -> None:
        """Raise all errors at once, or emit the warnings."""
        errors = [p for p in self.problems if p.is_error]
        if errors:
            raise InputFileError(errors)
        for problem in self.problems:
            warnings.warn(problem.render(), InputWarning, stacklevel=3)


def _as_typed(text: str) -> str:
    """A text whose characters are bytes, as an editor shows it where these are UTF-8."""
    try:
        return text.encode("latin-1").decode()
    except UnicodeError:
        return text


class BadValueError(Exception):
    """The problem of a piece of a value; the reader of the file adds path, line and column.

    `offset` is the first offending character of the value, `width` how many to underline, 0 for the whole value.
    """

    def __init__(self, code: str, message: str, *, advice: str = "", offset: int = 0, width: int = 0) -> None:
        self.code = code
        self.message = message
        self.advice = advice
        self.offset = offset
        self.width = width
        self.more: tuple[BadValueError, ...] = ()  #: Further problems of the same value, `MAX_PER_VALUE` at most
        super().__init__(message)


class Gathered:
    """Problems of the parts of one value, all raised together."""

    def __init__(self) -> None:
        self._problems: list[BadValueError] = []

    def attempt(self, parse: Callable[[], T]) -> T | None:
        """The value of a part, or None if it is bad."""
        try:
            return parse()
        except BadValueError as problem:
            self._problems.append(problem)
            return None

    @property
    def is_full(self) -> bool:
        """Whether enough is reported."""
        return len(self._problems) >= MAX_PER_VALUE

    def close(self) -> None:
        """Raise the first problem, with the others behind it."""
        if self._problems:
            first, *rest = self._problems
            first.more = tuple(rest)
            raise first


MEMORY_BYTES = 2**31
"""Most memory for the arrays of a scene by default: a limit of its files, not of the machine."""
_FREE_BYTES = 2**24  # Python itself takes more


def beyond_memory(n_bytes: int, limit_bytes: int | None) -> Problem | None:
    """The problem of arrays larger than the limit of memory."""
    limit = MEMORY_BYTES if limit_bytes is None else limit_bytes
    if n_bytes <= max(limit, _FREE_BYTES):
        return None
    size, most = (f"{n / 2**20:.0f} MiB" if n < 2**30 else f"{n / 2**30:.1f} GiB" for n in (n_bytes, limit))
    message = f"about {size} of memory, more than the {most} of --max-memory"
    return Problem(code="usage", message=message, advice=more_memory(2 * n_bytes))


def more_memory(n_bytes: int) -> str:
    """Advice to allow as much memory, on the command line and in Python."""
    gigabytes = -(-n_bytes // 2**30)
    return f"write --max-memory {gigabytes}G (in Python max_memory_bytes={gigabytes} * 2**30)"


def outside(shown: str, allowed: str, *, offset: int = 0, width: int = 0) -> BadValueError:
    """The problem of a value outside its range."""
    return BadValueError("E404", f"{shown} is outside {allowed}", advice=f"write {allowed}", offset=offset, width=width)


def quoted(text: str) -> str:
    """A piece of a file as a message shows it: in quotes, short, without what would disturb a terminal."""
    shown = text if len(text) <= 40 else f"{text[:37]}..."
    return "'" + "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown) + "'"


def printable(name: str) -> str:
    """A name from a file, harmless for a terminal and of a length that can be read."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name[:200])
    return shown if len(name) <= 200 else f"{shown}..."


LIKELY = 0.65
"""How alike two names are if one was probably meant for the other. [0 to 1]"""


def nearest(name: str, known: Collection[str], *, at_least: float = 0.0) -> str:
    """The most similar known name; "" below `at_least`."""
    return next(iter(get_close_matches(name[:40].lower(), known, n=1, cutoff=at_least)), "")


def nearest_text(name: str, known: Collection[str]) -> str:
    """What a message adds about a name that is not known: the most similar one; empty if none is alike."""
    best = nearest(name, known, at_least=LIKELY)
    return f"; the nearest is {best}" if best else ""
