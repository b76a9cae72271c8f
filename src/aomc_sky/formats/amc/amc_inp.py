"""amc.inp: 30 fixed-column values, one per line, from column 49 on (31 in the older layout)."""

from __future__ import annotations

import enum
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.errors import Span
from aomc_sky.formats.amc.layout import FIRST_COLUMN, Field, fields_of_layout, has_polar_cap_line
from aomc_sky.formats.report import Report
from aomc_sky.formats.scanner import fixed_integer, fixed_real, list_integer, list_real
from aomc_sky.formats.text_file import read_bytes, split_lines

_LABEL = re.compile(r"\s*(\d{1,2})\s*\)")
_START = FIRST_COLUMN - 1
_NUMBER_CHARACTERS = frozenset("0123456789+-.eEdD")


class LightSource(enum.IntEnum):
    """Line 2 of amc.inp: the model's own source, or a sky file."""

    MODEL = 0
    FILE = 1


class FootprintCode(enum.IntEnum):
    """The number that stands for a shape of the lit area of the sea surface."""

    POINT = 1
    CIRCLE = 2
    RECTANGLE = 3


@dataclass(frozen=True, kw_only=True, slots=True)
class AmcConfig:
    """The values of amc.inp as the AOMC program reads them; see docs/formats/amc.md for each.

    Lengths are in metres, angles in degrees; `use_polar_cap` is None in the 30-line layout.
    """

    iterations: int
    light_source: LightSource
    direct_azimuth_deg: int
    direct_zenith_deg: int
    n_constituents: int
    depth_m: float
    side_m: float
    n_recording_layers: int
    layer_thickness_m: float
    n_alpha_intervals: int
    n_phi_intervals: int
    use_polar_cap: bool | None = None
    interval_type: int
    log_absorption: bool
    log_bottom: bool
    log_side: bool
    spf_from_file: bool
    n_spf_angles: int
    n_concentration_layers: int
    n_grid_cells: int
    cell_size_m: float
    surfer_output: bool
    footprint: FootprintCode
    circle_diameter_m: float
    rectangle_x_m: float
    rectangle_y_m: float
    bottom_target: bool
    target_x_m: float
    target_y_m: float
    normalize_to_water: int
    n_wavebands: int


_KINDS: dict[str, Any] = {
    "light_source": LightSource,
    "footprint": FootprintCode,
    "use_polar_cap": bool,
    "log_absorption": bool,
    "log_bottom": bool,
    "log_side": bool,
    "spf_from_file": bool,
    "surfer_output": bool,
    "bottom_target": bool,
}


def read_amc(path: str | Path, *, lenient: bool = False) -> AmcConfig:
    """Read amc.inp as Fortran does, and refuse what a person would read differently.

    With `lenient` the value of Fortran is taken there, with a warning; what Fortran itself refuses stays an error.
    """
    lines = split_lines(read_bytes(path))
    report = Report(path=str(path), lenient=lenient)
    values = read_fields(lines, fields_of_layout(has_polar_cap_line(lines)), report)
    report.close()
    return AmcConfig(**{name: _KINDS.get(name, lambda v: v)(value) for name, value in values.items()})


def read_fields(lines: list[str], fields: tuple[Field, ...], report: Report) -> dict[str, int | float]:
    """Read every field; problems go to the report, fields with one are left out."""
    if _is_displaced(lines, fields, report) and not report.lenient:
        return {}
    values: dict[str, int | float] = {}
    for index, field in enumerate(fields):
        if index >= len(lines):
            end = Span(max(1, len(lines)), 1, lines[-1] if lines else "")
            message = f"the file ends after line {len(lines)}; {len(fields)} lines are wanted, next is {field.title}"
            advice = f"add the lines from '{field.label.strip()}' on"
            report.at(end, "E105", message, name=field.title, advice=advice)
            break
        value = _read_line(lines[index], index + 1, field, report)
        if value is not None:
            values[field.name] = value
    return values


def _is_displaced(lines: list[str], fields: tuple[Field, ...], report: Report) -> bool:
    """Whether a numbered label stands in a line that is not its own: a line is missing or too many."""
    wanted = [_LABEL.match(field.label) for field in fields]
    own_line = {m[1]: k for k, m in enumerate(wanted) if m}
    for index, line in enumerate(lines[: len(fields)]):
        found = _LABEL.match(line[:_START])
        if not found or own_line.get(found[1], index) == index:
            continue
        # one label that a person mistyped is no displaced line: the next numbered label decides
        shift = index - own_line[found[1]]
        if not _next_label_agrees(lines, own_line, index, shift):
            continue
        own = own_line[found[1]]
        if shift > 0:
            what, extra = "a line too many", _extra_line(lines, own_line, index)
            span = Span(extra + 1, 1, lines[extra], max(1, len(lines[extra].rstrip())))
        else:
            what, span = "a line missing", Span(index + 1, found.start(1) + 1, line, len(found[1]) + 1)
        message = f"there is {what}: label '{found[1]})' stands in line {index + 1} and belongs in line {own + 1}"
        advice = f"{len(fields)} lines are wanted, in the order of docs/formats/amc.md"
        report.at(span, "E105", message, advice=advice, can_downgrade=True)
        return True
    return False


def _extra_line(lines: list[str], own_line: dict[str, int], index: int) -> int:
    """The line that is too many before a displaced label: a blank one, else the one right before it."""
    first = index
    while first > 0:
        found = _LABEL.match(lines[first - 1][:_START])
        if found and own_line.get(found[1]) == first - 1:
            break
        first -= 1
    blank = [k for k in range(first, index) if not lines[k].strip()]
    return blank[0] if blank else max(index - 1, 0)


def _next_label_agrees(lines: list[str], own_line: dict[str, int], index: int, shift: int) -> bool:
    for later in range(index + 1, min(len(lines), index + 8)):
        found = _LABEL.match(lines[later][:_START])
        if found and found[1] in own_line:
            return later - own_line[found[1]] == shift
    return True


def _read_line(line: str, number: int, field: Field, report: Report) -> int | float | None:
    text = line[_START : _START + field.width]
    value = fixed_integer(text) if field.decimals is None else fixed_real(text, field.decimals)
    token, column = _what_a_person_reads(line, field)
    meant = _number(token, field)
    kind = f"I{field.width}" if field.decimals is None else f"F{field.width}.{field.decimals}"
    span = Span(number, column, line, max(len(token), 1))

    def note(code: str, message: str, advice: str, *, can_downgrade: bool) -> None:
        report.at(span, code, message, name=field.title, advice=advice, can_downgrade=can_downgrade)

    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        wanted = "a whole number" if field.decimals is None else "a finite number with a decimal point"
        note("E107", f"'{text.strip()}' is not {wanted} (Fortran {kind})", _example(field, meant), can_downgrade=False)
        return None
    if meant is None or meant != value:
        code, message = _difference(line, token, column, value, meant, field, kind)
        note(code, message, _example(field, meant), can_downgrade=True)
        if report.has_errors and not report.lenient:
            return None
    lenient_thickness = field.name == "layer_thickness_m" and not report.lenient
    if not field.is_allowed(value) or (lenient_thickness and value != -1 and not value > 0):
        allowed = "-1 or above 0 up to 500" if field.name == "layer_thickness_m" else field.allowed
        shown = f"{value:g}" if field.decimals is not None else f"{value}"
        note("E102", f"{shown} is outside the range {allowed}", f"write {allowed}", can_downgrade=False)
        return None
    return value


def _what_a_person_reads(line: str, field: Field) -> tuple[str, int]:
    """The number a person sees in a line and its 1-based column; empty where there is none."""
    end = _START + field.width
    inside = [k for k in range(_START, min(end, len(line))) if line[k] not in " \t"]
    if inside:
        first, last = inside[0], inside[0]
    else:
        beyond = [k for k in range(end, len(line)) if line[k] not in " \t"]
        before = line[:_START].rstrip()
        if before and before[-1] in _NUMBER_CHARACTERS and ":" in before:
            first = last = len(before) - 1
        elif beyond:
            first = last = beyond[0]
        else:
            return "", FIRST_COLUMN
    while first > 0 and line[first - 1] in _NUMBER_CHARACTERS:
        first -= 1
    while last + 1 < len(line) and line[last + 1] not in " \t":
        last += 1
    return line[first : last + 1], first + 1


def _number(token: str, field: Field) -> int | float | None:
    """Value of what a person reads; a trailing comma is no part of it."""
    text = token[:-1] if token.endswith(",") else token
    return list_integer(text) if field.decimals is None else list_real(text)


def _difference(
    line: str, token: str, column: int, value: float, meant: float | None, field: Field, kind: str
) -> tuple[str, str]:
    """Code and message where Fortran and a person disagree."""
    shown = f"{value}" if field.decimals is None else f"{value:.{field.decimals}f}"
    if field.decimals is not None and value != 0 and float(shown) != value:
        shown = f"{value:g}"
    reads = f"Fortran {kind} reads it as {shown}"
    if not token:
        return "E106", f"the value is missing; Fortran {kind} reads a blank as 0"
    inside = column >= FIRST_COLUMN and column + len(token) - 1 <= _START + field.width
    if not inside:
        code = "E103" if field.width == 1 else "E108"
        columns = f"column {FIRST_COLUMN}" if field.width == 1 else f"columns {FIRST_COLUMN} to {_START + field.width}"
        return code, f"'{token}' does not stand in {columns}; {reads}"
    if field.decimals is not None and "." not in token and meant is not None:
        return "E104", f"'{token}' has no decimal point; {reads}"
    return "E109", f"'{line[_START : _START + field.width].strip()}' can be read in two ways; {reads}"


def _example(field: Field, meant: float | None) -> str:
    where = f"in column {FIRST_COLUMN}" if field.width == 1 else f"from column {FIRST_COLUMN} on"
    if meant is None or not math.isfinite(meant) or not field.is_allowed(meant):
        return f"write {field.allowed} {where}"
    text = str(meant) if field.decimals is None else repr(float(meant))
    if len(text) > field.width:
        return f"write a number of at most {field.width} characters"
    return f"write {text}" + (f" {where}" if field.width == 1 else "")
