"""Keys of sky.toml: the rule that returns a good value and refuses a bad one, and the keys that belong together."""

from __future__ import annotations

import dataclasses
import datetime
import math
import os
import re
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from numbers import Real
from typing import Any

from aomc_sky.errors import Problem
from aomc_sky.formats.report import BadValueError, Gathered, nearest_text
from aomc_sky.options import FIELD, LIGHTS, LOBES, SECTIONS, Kind, Option

LATEST_S = 253_402_300_799.0
EARLIEST_S = -62_135_596_800.0
"""Seconds since 1970-01-01 UTC of the first and the last second of the years 1 to 9999."""

_MAX_TEXT = 1000
_TIMES = "write 2026-06-21T23:30:00Z, 2026-06-22T01:30:00+02:00, or seconds since 1970-01-01 UTC"

_DATE = re.compile(r"(?:19|20)\d\d(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])(?:[0-2]\d[0-5]\d)?\Z")
"""Digits of a date such as 20260621, with or without hours and minutes."""

Rule = Callable[[object], Any]
"""Returns a good value in the form of later use; BadValueError (E703, E704) for any other value."""


def _range_text(low: float, high: float) -> str:
    return f"{low:g} or more" if high == math.inf else f"{low:g} to {high:g}"


def number(low: float = -math.inf, high: float = math.inf) -> Rule:
    """A number with low <= value <= high."""

    def read(value: object) -> float:
        allowed = _range_text(low, high)
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


_FILES = dict.fromkeys(
    (".nc", ".nc4", ".csv", ".tsv", ".txt", ".dat"),
    'write table = "{0}" below [sky] of sky.toml, or alone: aomc-sky run {0}',
)
_FILES[".atmo"] = 'write file = "{0}" below [atmosphere] of sky.toml'
"""Ending of a file that describes a sky -> where its name stands."""


def sky_name(words: Sequence[str]) -> Rule:
    """A sky of our own, one of the `words`, or one that another package has registered."""

    def read(value: object) -> str:
        if not isinstance(value, str) or value in words:
            return str(choice(words)(value))
        from aomc_sky.formats.sky_models import installed_skies  # a look through all packages

        installed = installed_skies()
        if value in installed.plugins:
            return value
        if advice := _FILES.get(os.path.splitext(value)[1].lower()):
            raise BadValueError(
                "E704", f"{shown_value(value)} is a file, not the name of a sky", advice=advice.format(value)
            )
        names = joined([_quoted(name) for name in (*words, *installed.plugins)])
        if value in installed.refused:
            raise BadValueError("E704", installed.refused[value], advice=f"write {names}")
        near = nearest_text(value, [name for name in (*words, *installed.plugins) if name != "none"])
        message = f"there is no sky model {shown_value(value)}{near}"
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
    from aomc_sky.formats.azimuth import AZIMUTH_FORMS, convention_of

    words = str(text("words such as 'clockwise from north'")(value))
    if convention_of(words) is None:
        raise BadValueError(
            "E704", f"{shown_value(words)} is no convention of azimuths", advice=f"write {AZIMUTH_FORMS}"
        )
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
            seconds = float(number(EARLIEST_S, LATEST_S)(value))
            if _DATE.match(str(value)):
                raise BadValueError("E704", f"{value} would be the time {moment_text(seconds)} (a date?)")
            return seconds
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
        good = tuple(gathered.attempt(partial(_element, rule, k, value)) for k in range(len(value)))
        gathered.close()
        return good

    return read


def _element(rule: Rule, index: int, values: list[object]) -> Any:
    """The value of an element of an array; the message of a bad one says which it is."""
    try:
        return rule(values[index])
    except BadValueError as problem:
        if len(values) > 1:
            problem.message = f"value {index + 1}: {problem.message}"
        raise


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


def shares(value: object) -> dict[str, float]:
    """Read a table of names and numbers above 0, at most 1."""
    advice = "write names of components and their shares of the photons, { direct = 0.2 }"
    if not isinstance(value, dict):
        raise BadValueError("E703", f"{shown_value(value)} is not a table", advice=advice)
    for one in value.values():
        if isinstance(one, bool) or not isinstance(one, (int, float)) or not 0 < one <= 1:
            raise BadValueError("E704", f"{shown_value(one)} is no share, above 0 and at most 1", advice=advice)
    return {str(name): float(one) for name, one in value.items()}


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


COEFFICIENT_NAMES = ("a", "b", "c", "d", "e")
SETS = (("dni", "dhi"), ("ghi", "dni"), ("ghi", "dhi"), ("ghi", "dni", "dhi"), ("epsilon", "delta"), COEFFICIENT_NAMES)
"""A Perez sky needs exactly one of these sets. With three irradiances, ghi is only checked."""

SKY_TOML = "sky.toml"
"""The name under which the file is the origin of something."""

SPECTRL2 = "spectrl2"
"""The spectrum that divides each waveband between beam and sky."""

_GROUPS = (("dni", "dhi", "ghi"), ("epsilon", "delta"), COEFFICIENT_NAMES)
_SETS_TEXT = "dni + dhi, ghi + dni, ghi + dhi, epsilon + delta, or a, b, c, d, e"

_MOST_OF_SUN = 20.0
"""A spectral irradiance that no sun gives: it has 2.3 W m-2 nm-1 outside the atmosphere."""


def spectral_irradiance(value: object) -> float:
    """Read an irradiance per nm; one that is too large for the sun by a factor is in another unit."""
    if isinstance(value, (int, float)) and _MOST_OF_SUN < value < 10_000:
        message = f"{shown_value(value)} W m-2 nm-1 is more than the sun has outside the atmosphere, 2.3 at most"
        advice = f"write {value / 1000:g} for {value:g} mW m-2 nm-1, and an irradiance per nm"
        raise BadValueError("E704", message, advice=advice)
    return float(number(0, _MOST_OF_SUN)(value))


_SPECTRUM = several(spectral_irradiance)
DIFFUSE_MODELS = ("perez", "uniform", "none")
"""Our laws of the diffuse sky; "none": neither sun nor sky, the backgrounds alone shine."""
INTERPOLATIONS = LOBES["interpolation"].words
SOLVERS = SECTIONS["atmosphere"]["method"].words
"""Ways to solve an atmosphere."""

GLOW_KEY = "ground_luminance_cd_m2"
"""Key of [atmosphere]: how bright the ground is without the sun."""

FIELD_KEYS = (*(row.own_name for row in FIELD.values() if row.section), "zenith", "elevation", "azimuth", "wavelength")
"""Keys of [sky] beside table: what the file does not say, as `TabulatedSky.from_xarray` has it."""

POLARISATION = "polarisation"
"""Key of [sky]: largest degree of Rayleigh's pattern on the light of any sky with a sun."""

PREFIX = "moon_"


MOON_KEYS = tuple(name for name in LIGHTS if name != GLOW_KEY)
"""Keys of [atmosphere] that place the Moon."""

_TWICE = (("moon_zenith_deg", "moon_zenith_offset_deg"), ("moon_azimuth_deg", "moon_azimuth_offset_deg"))

_RULES: dict[Kind, Callable[[Option], Rule]] = {
    Kind.SWITCH: lambda row: flag,
    Kind.WORD: lambda row: choice(row.words),
    Kind.NUMBER: lambda row: number(row.low, row.high),
    Kind.COUNT: lambda row: count(int(row.low), int(row.high)),
    Kind.TEXT: lambda row: text("a name" if row.value == "NAME" else row.text),
    Kind.NAMES: lambda row: several(text("a name"), or_one=True),
    Kind.SKY: lambda row: sky_name(DIFFUSE_MODELS),
    Kind.INDEX: lambda row: indices,
    Kind.SIGNS: lambda row: signs,
    Kind.SHARES: lambda row: shares,
    Kind.AZIMUTHS: lambda row: azimuth_words,
    Kind.RADIANCE_UNIT: lambda row: unit_of_radiance,
    Kind.MOMENT: lambda row: time,
    Kind.SPECTRUM: lambda row: _SPECTRUM,
}
"""Kind of a row with a section -> the rule of its values."""

KEYS: dict[str, dict[str, Rule]] = {
    section: {
        key: _RULES[row.kind](row)
        for name, row in rows.items()
        for key in (COEFFICIENT_NAMES if name == "coefficients" else (name,))
    }
    for section, rows in SECTIONS.items()
}
"""Sections of sky.toml and what each key of them accepts."""


def aerosol(value: object) -> Any:
    """A word of sky.toml, or numbers: a record or a mapping that `aomc_sky.ClearSky` checks."""
    if isinstance(value, Mapping) or (dataclasses.is_dataclass(value) and not isinstance(value, type)):
        return value
    try:
        return KEYS["clear_sky"]["aerosol"](value)
    except BadValueError as problem:
        problem.advice += ", or give an Aerosol(...)"
        raise


RULES = {**KEYS, "clear_sky": {**KEYS["clear_sky"], "aerosol": aerosol}}
"""The same in Python, where an aerosol may be numbers."""

REPEATED = ("background",)
"""Sections that may stand any number of times, as [[section]]."""
REQUIRED = {"background": ("file", "time"), "atmosphere": ("file",)}
"""Keys without which a section says nothing."""
PER_WAVEBAND = {"sky": ("diffuse_irradiance", "direct_irradiance")}
"""Arrays with a value for each waveband."""
PATHS = {"sky": ("table",), "background": ("file",), "atmosphere": ("file",)}
"""Keys that name a file, relative to the folder of sky.toml."""


GHI_ALONE = "add dhi or dni, measured or estimated (pvlib.irradiance.erbs); under an overcast dhi is ghi"
"""What to write in place of ghi alone."""


def set_problem(names: Collection[str]) -> Problem | None:
    """The problem of keys of [perez] that are not one of the `SETS`."""
    names = [name for name in names if any(name in group for group in _GROUPS)]
    if not names or any(set(names) == set(complete) for complete in SETS):
        return None
    groups = [[name for name in group if name in names] for group in _GROUPS]
    touched = [group for group in groups if group]
    if len(touched) > 1:
        shown = " and ".join("/".join(group) for group in touched)
        return _contradiction(f"{shown} describe the same sky twice", f"keep one of {_SETS_TEXT}")
    named = touched[0]
    if named == ["ghi"]:
        return _contradiction("ghi alone does not say how much of it is the beam", GHI_ALONE)
    expected = next(complete for complete in SETS if set(named) <= set(complete))
    missing = ", ".join(name for name in expected if name not in named)
    alternative = {"dni": " (or ghi)", "dhi": " (or ghi)", "ghi": " (or dhi)"}.get(named[0], "")
    return _contradiction(f"{', '.join(named)} without {missing}", f"add {missing}{alternative}")


def _contradiction(message: str, advice: str) -> Problem:
    return Problem(code="E705", message=message, advice=advice)


def value_problem(section: str, name: str, value: object) -> Problem | None:
    """The first fault of a value."""
    try:
        RULES[section][name](value)
    except BadValueError as problem:
        return Problem(code=problem.code, message=problem.message, advice=problem.advice, field=name)
    return None


def moon_problem(names: Collection[str]) -> Problem | None:
    """The problem of `MOON_KEYS` that are not one position."""
    for pair in _TWICE:
        if all(name in names for name in pair):
            return _contradiction(f"{pair[0]} and {pair[1]} say the same thing twice", f"remove {pair[1]}")
    if names and not any(name in names for pair in _TWICE for name in pair):
        advice = "add moon_zenith_offset_deg = 0, or moon_zenith_deg"
        return _contradiction("moon_distance_km without a direction of the Moon", advice)
    return None


def plain_number(value: object) -> object:
    """A real number of any library as a float of Python; anything else as it is."""
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else value
    except (OverflowError, TypeError):  # whole numbers above the largest float64; times of numpy, which it calls whole
        return value
