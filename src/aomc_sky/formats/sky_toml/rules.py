"""Kinds of values of sky.toml: what each accepts, what is wrong with another one, and how it is read."""

from __future__ import annotations

import datetime
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from aomc_sky.formats.report import nearest

LATEST_S = 253_402_300_799.0
EARLIEST_S = -62_135_596_800.0
"""Seconds since 1970-01-01 UTC of the first and the last second of the years 1 to 9999."""

_MAX_TEXT = 1000
_TIMES = "write 2026-06-21T23:30:00Z, 2026-06-22T01:30:00+02:00, or seconds since 1970-01-01 UTC"


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong with a value: code, what was found, what to write."""

    code: str
    message: str
    advice: str


class Rule(Protocol):
    """What a key accepts."""

    def faults(self, value: object) -> list[Fault]:
        """Everything that is wrong with a value."""
        ...

    def read(self, value: Any) -> Any:
        """A value without faults, in the form in which it is used."""
        ...


@dataclass(frozen=True, kw_only=True, slots=True)
class Range:
    """A number with low <= value <= high, or below high where `is_open`."""

    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False

    def holds(self, value: float) -> bool:
        """Whether a value lies inside."""
        return self.low <= value < self.high if self.is_open else self.low <= value <= self.high

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return [Fault("E703", f"{shown_value(value)} is not a number", f"write a number, {self}")]
        if not abs(value) <= sys.float_info.max:  # whole numbers of TOML have no limit
            return [Fault("E704", f"{shown_value(value)} is not finite", f"write {self}")]
        if not self.holds(value):
            message = f"{shown_value(value)} is outside the range {self}"
            return [Fault("E704", message, f"write {self}")]
        return []

    def read(self, value: Any) -> float:
        """See `Rule`."""
        return float(value)

    def __str__(self) -> str:
        if self.high == math.inf:
            return f"{self.low:g} or more"
        return f"{self.low:g} to {'below ' if self.is_open else ''}{self.high:g}"


@dataclass(frozen=True, kw_only=True, slots=True)
class Count:
    """A whole number, low <= value <= high."""

    low: int
    high: int

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        advice = f"write a whole number, {self.low} to {self.high}"
        if isinstance(value, bool) or not isinstance(value, int):
            return [Fault("E703", f"{shown_value(value)} is not a whole number", advice)]
        if not self.low <= value <= self.high:
            message = f"{shown_value(value)} is outside the range {self.low} to {self.high}"
            return [Fault("E704", message, advice)]
        return []

    def read(self, value: Any) -> int:
        """See `Rule`."""
        return int(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class Flag:
    """true or false."""

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        if isinstance(value, bool):
            return []
        message = f"{shown_value(value)} is neither true nor false"
        return [Fault("E703", message, "write true or false")]

    def read(self, value: Any) -> bool:
        """See `Rule`."""
        return bool(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class Choice:
    """One of a few words."""

    words: tuple[str, ...]

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        advice = f"write {joined([_quoted(word) for word in self.words])}"
        if not isinstance(value, str):
            return [Fault("E703", f"{shown_value(value)} is not a word", advice)]
        if value in self.words:
            return []
        return [Fault("E704", f"{shown_value(value)} is not one of the known words", advice)]

    def read(self, value: Any) -> str:
        """See `Rule`."""
        return str(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyName:
    """A sky of our own, or one that another package has registered."""

    words: tuple[str, ...]  #: Our own

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        if not isinstance(value, str):
            return Choice(words=self.words).faults(value)
        if value in self.words:
            return []
        from aomc_sky.sky_plugins import installed_skies  # a look through all packages

        installed = installed_skies()
        if value in installed.plugins:
            return []
        names = [*map(_quoted, self.words), *(f'"{plugin.name}"' for plugin in installed.plugins.values())]
        if value in installed.refused and value not in self.words:
            return [Fault("E704", installed.refused[value], f"write {joined(names)}")]
        best = nearest(value, (*self.words, *installed.plugins))
        message = f"there is no sky model {shown_value(value)}; the nearest is {best}"
        return [Fault("E704", message, f"write {joined(names)}, or install the package that has it")]

    def read(self, value: Any) -> str:
        """See `Rule`."""
        return str(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class Text:
    """A text that is not empty; `what` it is, for messages."""

    what: str

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        advice = f"write {self.what} in quotes"
        if not isinstance(value, str):
            return [Fault("E703", f"{shown_value(value)} is not a text", advice)]
        if not value or "\0" in value or len(value) > _MAX_TEXT:
            return [Fault("E704", f"{shown_value(value)} is not {self.what}", advice)]
        return []

    def read(self, value: Any) -> str:
        """See `Rule`."""
        return str(value)


@dataclass(frozen=True, kw_only=True, slots=True)
class Time:
    """A point in time with its zone; read as seconds since 1970-01-01 UTC."""

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        if isinstance(value, (int, float)):
            rule = Range(low=EARLIEST_S, high=LATEST_S)
            return [Fault(fault.code, fault.message, _TIMES) for fault in rule.faults(value)]
        moment = _moment(value)
        if moment is None:
            return [Fault("E703", f"{shown_value(value)} is not a date with a time of day", _TIMES)]
        if moment.utcoffset() is None:
            return [Fault("E703", f"{shown_value(value)} has no time zone", _TIMES)]
        if not EARLIEST_S <= self.read(value) <= LATEST_S:
            message = f"{shown_value(value)} is outside the years 1 to 9999 in UTC"
            return [Fault("E704", message, _TIMES)]
        return []

    def read(self, value: Any) -> float:
        """See `Rule`."""
        if isinstance(value, (int, float)):
            return float(value)
        moment = _moment(value)
        assert moment is not None, "a value without faults"
        since = moment - datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
        return since / datetime.timedelta(seconds=1)


@dataclass(frozen=True, kw_only=True, slots=True)
class Several:
    """An array of values of one rule, or where `or_one` is true a single value of it, read as a tuple."""

    rule: Rule
    or_one: bool = False

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        if not isinstance(value, list):
            if self.or_one:
                return self.rule.faults(value)
            advice = f"write an array, [{value!r}]" if isinstance(value, (int, float)) else "write an array"
            return [Fault("E703", f"{shown_value(value)} is not an array", advice)]
        if not value:
            return [Fault("E704", "the array is empty", "write a value, or leave the key out")]
        return [fault for element in value for fault in self.rule.faults(element)]

    def read(self, value: Any) -> tuple[Any, ...]:
        """See `Rule`."""
        return tuple(self.rule.read(element) for element in (value if isinstance(value, list) else [value]))


@dataclass(frozen=True, kw_only=True, slots=True)
class Indices:
    """A table of names and whole numbers from 0; read as pairs."""

    def faults(self, value: object) -> list[Fault]:
        """See `Rule`."""
        advice = "write names of dimensions and indices from 0, { stokes = 0 }"
        if not isinstance(value, dict):
            return [Fault("E703", f"{shown_value(value)} is not a table", advice)]
        wrong = [one for one in value.values() if isinstance(one, bool) or not isinstance(one, int) or one < 0]
        return [Fault("E704", f"{shown_value(one)} is not a whole number from 0", advice) for one in wrong[:1]]

    def read(self, value: Any) -> tuple[tuple[str, int], ...]:
        """See `Rule`."""
        return tuple((str(name), int(index)) for name, index in value.items())


def _moment(value: object) -> datetime.datetime | None:
    """A date with time of day, as TOML has it or as ISO 8601 text."""
    if isinstance(value, datetime.datetime):
        return value
    if not isinstance(value, str):
        return None
    try:
        moment = datetime.datetime.fromisoformat(value.strip())
    except ValueError:
        return None
    has_time = len(value.strip()) > len("2026-06-21")
    return moment if has_time else None


def moment_text(unix_time_s: float) -> str:
    """A time that `Time` read, in ISO 8601 and UTC."""
    moment = datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=unix_time_s)
    return f"{moment.isoformat()}Z"


def _quoted(word: str) -> str:
    return f'"{word}"'


def shown_value(value: object) -> str:
    """A value as a message shows it: short, and as TOML has it."""
    if isinstance(value, (bool, dict, list)):
        return {bool: str(value).lower(), dict: "a table", list: "an array"}[type(value)]
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def joined(words: Sequence[str]) -> str:
    """Words of a choice for a person: a, b or c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
