"""Values of a description file that stand in one line: from text to numbers, or a problem with its place."""

from __future__ import annotations

import re
from functools import partial

import numpy as np

from aomc_sky.formats.atmo.keys import FORMAT_VERSION, MAX_INTEGER, Integer, Quantity, Real, Word
from aomc_sky.formats.bad_value import BadValueError, Gathered, quoted
from aomc_sky.formats.sky_toml.keys import nearest
from aomc_sky.formats.units import Dimension, parse_quantity, parse_real

MAX_WAVELENGTHS = 4096
"""More would say nothing new of spectra that are means over bins, and cost memory in every table."""

LOWEST_NM, HIGHEST_NM = 100, 100_000
_WHOLE = re.compile(r"\+?[0-9]+\Z", re.ASCII)
_RANGE_PART = re.compile(r"(\s*(min|max|count)\s*=\s*)(.*)\Z", re.DOTALL)


def parse_integer(text: str) -> int:
    """Read a whole number without sign; longer ones than 20 digits count as 10^20."""
    if not _WHOLE.match(text):
        message = f"{quoted(text)} is not a whole number" if text else "the value is missing"
        raise BadValueError("E401", message, advice="write digits alone")
    digits = text.lstrip("+0")
    return int(digits or "0") if len(digits) <= 20 else 10**20


def size_value(text: str, rule: Integer) -> int:
    """Read the size of a texture or a number of points."""
    value = parse_integer(text)
    if not 1 <= value <= MAX_INTEGER:
        raise BadValueError("E404", f"{quoted(text)} is outside 1 to {MAX_INTEGER}", advice="write 1 or more")
    if rule.is_even and value % 2:
        raise BadValueError("E404", f"{value} is odd", advice=f"write an even number, such as {value + 1}")
    return value


def real_value(text: str, rule: Real) -> float:
    """Read a number without unit."""
    value = parse_real(text)
    if not rule.low <= value <= rule.high:
        shown = f"{rule.low:.10g} to {rule.high:.10g}"
        raise BadValueError("E404", f"{quoted(text)} is outside {shown}", advice=f"write {shown}")
    return value


def quantity_value(text: str, rule: Quantity) -> float:
    """Read a number with a unit. [m or m2]"""
    value = parse_quantity(text, rule.dimension)
    if not rule.low <= value <= rule.high:
        raise BadValueError("E404", f"{quoted(text)} is outside {rule.shown}", advice=f"write {rule.shown}")
    return float(value)


def word_value(text: str, rule: Word) -> str:
    """Read one of some words."""
    if text not in rule.words:
        best = nearest(text, rule.words)
        message = f"{quoted(text)} is not known; the nearest is {best}"
        raise BadValueError("E404", message, advice=f"write one of {', '.join(rule.words)}")
    return text


def version_value(text: str) -> int:
    """Read the version of the format; there is one."""
    value = parse_integer(text)
    if value != FORMAT_VERSION:
        message = f"{quoted(text)} is another version; this program reads {FORMAT_VERSION}"
        advice = f"write version: {FORMAT_VERSION}, if the rest of the file is of that version"
        raise BadValueError("E406", message, advice=advice)
    return value


def wavelength_values(text: str) -> np.ndarray:
    """Read ``min=400nm,max=700nm,count=16``: an even grid. [nm]

    Raises
    ------
    BadValueError
        E401: a part that is missing, unknown, twice there or no number; E404: outside 100 to 100 000 nm, min not
        below max (a single wavelength: not equal to it), a count of 0 or beyond `MAX_WAVELENGTHS`.
    """
    parts: dict[str, tuple[str, int]] = {}
    offset = 0
    for item in text.split(","):
        match = _RANGE_PART.match(item)
        shown = item.strip()
        if match is None or match[2] in parts:
            message = f"{quoted(shown)} is not min=, max= or count=" if match is None else f"{match[2]}= stands twice"
            advice = "write min=400nm,max=700nm,count=16"
            raise BadValueError("E401", message, advice=advice, offset=offset, width=len(item))
        parts[match[2]] = (match[3], offset + len(match[1]))
        offset += len(item) + 1
    missing = [name for name in ("min", "max", "count") if name not in parts]
    if missing:
        raise BadValueError("E401", f"no {' and no '.join(missing)}", advice="write min=400nm,max=700nm,count=16")
    gathered = Gathered()
    low, high = (gathered.attempt(partial(_limit_nm, name, *parts[name])) for name in ("min", "max"))
    count = gathered.attempt(partial(_count, *parts["count"]))
    gathered.close()
    assert low is not None and high is not None and count is not None, "no problems"  # noqa: PT018
    if low > high or (low == high) != (count == 1):
        advice = "write equal min and max, or a larger count" if count == 1 else "write min below max"
        raise BadValueError("E404", f"min {low:g} nm, max {high:g} nm, count {count}", advice=advice)
    grid = np.linspace(low, high, count)
    grid.flags.writeable = False
    return grid


def _limit_nm(name: str, text: str, offset: int) -> float:
    if text != text.rstrip():
        message = f"a blank behind the value of {name}"
        raise BadValueError("E401", message, advice="remove the blank", offset=offset + len(text.rstrip()), width=1)
    try:
        value = parse_quantity(text, Dimension.LENGTH) * 10**9
    except BadValueError as problem:
        message = f"{name}: {problem.message}"
        place = offset + problem.offset
        raise BadValueError(
            problem.code, message, advice=problem.advice, offset=place, width=problem.width or max(len(text), 1)
        ) from None
    if not LOWEST_NM <= value <= HIGHEST_NM:
        shown = f"{LOWEST_NM} nm to {HIGHEST_NM} nm"
        raise BadValueError(
            "E404",
            f"{name}: {quoted(text)} is outside {shown}",
            advice=f"write {shown}",
            offset=offset,
            width=len(text),
        )
    return float(value)


def _count(text: str, offset: int) -> int:
    shown = text.strip()
    if not (shown.isascii() and shown.isdigit()):
        raise BadValueError(
            "E401",
            f"count: {quoted(shown)} is not a whole number",
            advice="write digits alone",
            offset=offset,
            width=max(len(shown), 1),
        )
    count = parse_integer(shown)
    if not 1 <= count <= MAX_WAVELENGTHS:
        message = f"count: {quoted(shown)} is outside 1 to {MAX_WAVELENGTHS}"
        raise BadValueError("E404", message, advice=f"write 1 to {MAX_WAVELENGTHS}", offset=offset, width=len(shown))
    return count
