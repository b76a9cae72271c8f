"""Kinds of values of sky.toml: each is a function that returns a good value and refuses a bad one."""

from __future__ import annotations

import datetime
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from aomc_sky.formats.report import BadValueError, Gathered, nearest
from aomc_sky.inputs import Input

LATEST_S = 253_402_300_799.0
EARLIEST_S = -62_135_596_800.0
"""Seconds since 1970-01-01 UTC of the first and the last second of the years 1 to 9999."""

_LIKELY = 0.6  # likeness of a name from which it is named as the nearest
_MAX_TEXT = 1000
_TIMES = "write 2026-06-21T23:30:00Z, 2026-06-22T01:30:00+02:00, or seconds since 1970-01-01 UTC"

Rule = Callable[[object], Any]
"""Returns a good value in the form of later use; BadValueError (E703, E704) for any other value."""


def range_text(low: float, high: float) -> str:
    """A range for a person."""
    return f"{low:g} or more" if high == math.inf else f"{low:g} to {high:g}"


def number(low: float = -math.inf, high: float = math.inf) -> Rule:
    """A number with low <= value <= high."""

    def read(value: object) -> float:
        allowed = range_text(low, high)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise BadValueError("E703", f"{shown_value(value)} is not a number", advice=f"write a number, {allowed}")
        if not abs(value) <= sys.float_info.max:  # whole numbers of TOML have no limit
            raise BadValueError("E704", f"{shown_value(value)} is not finite", advice=f"write {allowed}")
        if not low <= value <= high:
            message = f"{shown_value(value)} is outside the range {allowed}"
            raise BadValueError("E704", message, advice=f"write {allowed}")
        return float(value)

    return read


def count(low: int, high: int) -> Rule:
    """A whole number with low <= value <= high."""

    def read(value: object) -> int:
        advice = f"write a whole number, {low} to {high}"
        if isinstance(value, bool) or not isinstance(value, int):
            raise BadValueError("E703", f"{shown_value(value)} is not a whole number", advice=advice)
        if not low <= value <= high:
            message = f"{shown_value(value)} is outside the range {low} to {high}"
            raise BadValueError("E704", message, advice=advice)
        return value

    return read


def flag(value: object) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        raise BadValueError("E703", f"{shown_value(value)} is neither true nor false", advice="write true or false")
    return value


def choice(words: Sequence[str]) -> Rule:
    """One of a few words."""

    def read(value: object) -> str:
        advice = f"write {joined([_quoted(word) for word in words])}"
        if not isinstance(value, str):
            raise BadValueError("E703", f"{shown_value(value)} is not a word", advice=advice)
        if value not in words:
            raise BadValueError("E704", f"{shown_value(value)} is not one of the known words", advice=advice)
        return value

    return read


_FILES: tuple[tuple[tuple[str, ...], str, str], ...] = (
    ((".nc", ".nc4", ".csv", ".tsv"), "a field or a measured sky is a file, not the name of a sky",
     'write table = "{0}" below [sky] of sky.toml, or alone: aomc-sky run {0}'),
    ((".atmo", "atmosphere"), "an atmosphere is a description in a file, not the name of a sky",
     'write file = "FILE.atmo" below [atmosphere] of sky.toml'),
    ((".py",), "a function of Python is not the name of a sky",
     "give it to sky.weather_scene(sky=...), or install it as a sky model: docs/howto/own_sky.md"),
)  # fmt: skip
_HYDROLIGHT = ("hydrolight", "ecolight", "hcnrad")


def sky_name(words: Sequence[str]) -> Rule:
    """A sky of our own, one of the `words`, or one that another package has registered."""

    def read(value: object) -> str:
        if not isinstance(value, str) or value in words:
            return str(choice(words)(value))
        from aomc_sky.formats.sky_models import installed_skies  # a look through all packages

        installed = installed_skies()
        if value in installed.plugins:
            return value
        if value.lower() in _HYDROLIGHT:
            message = f"there is no sky model {shown_value(value)}: HydroLight's pattern of the sky is harrison-coombes"
            raise BadValueError("E704", message, advice='write "harrison-coombes"')
        for endings, message, advice in _FILES:
            if value.lower().endswith(endings):
                raise BadValueError("E704", f"{shown_value(value)}: {message}", advice=advice.format(value))
        names = joined([_quoted(name) for name in (*words, *installed.plugins)])
        if value in installed.refused:
            raise BadValueError("E704", installed.refused[value], advice=f"write {names}")
        best = nearest(value, [name for name in (*words, *installed.plugins) if name != "none"], at_least=_LIKELY)
        message = f"there is no sky model {shown_value(value)}{f'; the nearest is {best}' if best else ''}"
        raise BadValueError("E704", message, advice=f"write {names}, or install the package that has it")

    return read


def text(what: str) -> Rule:
    """A text that is not empty; `what` it is, for messages."""

    def read(value: object) -> str:
        advice = f"write {what} in quotes"
        if not isinstance(value, str):
            raise BadValueError("E703", f"{shown_value(value)} is not a text", advice=advice)
        if not value or "\0" in value or len(value) > _MAX_TEXT:
            raise BadValueError("E704", f"{shown_value(value)} is not {what}", advice=advice)
        return value

    return read


def azimuth_words(value: object) -> str:
    """Words on where azimuths count from."""
    from aomc_sky.formats.azimuth_words import AZIMUTH_FORMS, UnclearError, convention_of

    words = str(text("words such as 'clockwise from north'")(value))
    try:
        convention_of(words)
    except UnclearError as error:
        raise BadValueError("E704", str(error), advice=f"write {AZIMUTH_FORMS}") from None
    return words


def unit_of_radiance(value: object) -> str:
    """A unit of spectral radiance, or "relative"."""
    from aomc_sky.formats.radiance_unit import radiance_factor

    unit = str(text("a unit such as 'W m-2 nm-1 sr-1'")(value))
    if radiance_factor(unit) is None:
        message = f"{shown_value(unit)} is no unit of spectral radiance"
        raise BadValueError(
            "E704", message, advice='write "mW m-2 nm-1 sr-1", another unit of this kind, or "relative"'
        )
    return unit


def time(value: object) -> float:
    """Read a point in time with its zone, as seconds since 1970-01-01 UTC."""
    if isinstance(value, (int, float)):
        try:
            return float(number(EARLIEST_S, LATEST_S)(value))
        except BadValueError as problem:
            problem.advice = _TIMES
            raise
    moment = _moment(value)
    if moment is None:
        raise BadValueError("E703", f"{shown_value(value)} is not a date with a time of day", advice=_TIMES)
    if moment.utcoffset() is None:
        raise BadValueError("E703", f"{shown_value(value)} has no time zone", advice=_TIMES)
    since = moment - datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
    seconds = since / datetime.timedelta(seconds=1)
    if not EARLIEST_S <= seconds <= LATEST_S:
        raise BadValueError("E704", f"{shown_value(value)} is outside the years 1 to 9999 in UTC", advice=_TIMES)
    return seconds


def several(rule: Rule, *, or_one: bool = False) -> Rule:
    """An array of values of one rule, or where `or_one` is true a single value of it, read as a tuple."""

    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list):
            if or_one:
                return (rule(value),)
            advice = f"write an array, [{value!r}]" if isinstance(value, (int, float)) else "write an array"
            raise BadValueError("E703", f"{shown_value(value)} is not an array", advice=advice)
        if not value:
            raise BadValueError("E704", "the array is empty", advice="write a value, or leave the key out")
        gathered = Gathered()
        good = tuple(gathered.attempt(partial(rule, element)) for element in value)
        gathered.close()
        return good

    return read


def signs(value: object) -> tuple[float, float]:
    """Read an array of two signs."""
    if not isinstance(value, list) or len(value) != 2 or any(type(one) is bool or one not in (1, -1) for one in value):
        advice = "write [1, -1] with the sign of Q and that of U"
        raise BadValueError("E704", "not an array of two signs, 1 or -1", advice=advice)
    return float(value[0]), float(value[1])


def indices(value: object) -> tuple[tuple[str, int], ...]:
    """Read a table of names and whole numbers from 0, as pairs."""
    advice = "write names of dimensions and indices from 0, { stokes = 0 }"
    if not isinstance(value, dict):
        raise BadValueError("E703", f"{shown_value(value)} is not a table", advice=advice)
    for one in value.values():
        if isinstance(one, bool) or not isinstance(one, int) or one < 0:
            raise BadValueError("E704", f"{shown_value(one)} is not a whole number from 0", advice=advice)
    return tuple((str(name), index) for name, index in value.items())


def rules_of(rows: Mapping[str, Input]) -> dict[str, Rule]:
    """Rule of each key of some inputs of the light."""
    return {
        name: flag if row.is_switch else choice(row.words) if row.words else number(row.low, row.high)
        for name, row in rows.items()
    }


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
