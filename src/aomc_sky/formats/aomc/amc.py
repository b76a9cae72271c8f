"""The files of the AOMC program: amc.inp, lambbot.inp and difcol.inp.

amc.inp has one value in each line, in fixed columns from column 49 on: 30 lines, or 31 in the older layout. Both
lambbot.inp and difcol.inp have a count, then a row of reals for each waveband.
"""

from __future__ import annotations

import dataclasses
import enum
import math
import re
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import Span
from aomc_sky.formats.aomc.scanner import (
    ListScanner,
    Record,
    Token,
    ask_unit,
    is_thousands,
    list_integer,
    list_real,
    no_number,
    values_of,
)
from aomc_sky.formats.report import Report
from aomc_sky.formats.text_file import read_lines
from aomc_sky.wavebands import Wavebands

FIRST_COLUMN = 49
MOST_ITERATIONS = 2**62
MAX_BANDS = 500

_START = FIRST_COLUMN - 1
_LABEL = re.compile(r"\s*(\d{1,2})\s*\)")
_NUMBER_CHARACTERS = frozenset("0123456789+-.eEdD")
_POLAR_CAP_INDEX = 11
_COLUMNS = (
    "wavelength",
    "bottom reflectance",
    "bottom specular fraction",
    "target reflectance",
    "target specular fraction",
)
_OWN_LINE = "write each row in a line of its own"
_HIGHEST = (inf, 1.0, 1.0, 1.0, 1.0)


class LightSource(enum.IntEnum):
    """Line 2 of amc.inp: the model's own source, or a sky file."""

    MODEL = 0
    FILE = 1


class FootprintCode(enum.IntEnum):
    """Number of each shape of the lit area of the sea surface."""

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


@dataclass(frozen=True, slots=True)
class Field:
    """One line of amc.inp."""

    name: str  #: Attribute of `AmcConfig`
    title: str  #: Name for a person
    label: str  #: Text before the value and its colon; only its number is checked
    low: float
    high: float
    decimals: int | None = None  #: d of Fw.d; an integer has None
    words: str = ""  #: The range in words, where low and high do not say it
    width: int = 8  #: Columns of the value, from column 49
    is_odd: bool = False  #: Even numbers but 0 are refused

    @property
    def allowed(self) -> str:
        """The range in words."""
        return self.words or f"{self.low:g} to {self.high:g}"

    def is_allowed(self, value: float) -> bool:
        """Whether a value lies in the range."""
        return self.low <= value <= self.high and not (self.is_odd and value and value % 2 == 0)


_FLAG: dict[str, Any] = {"low": 0, "high": 1, "words": "0 or 1", "width": 1}

_POLAR_CAP = Field("use_polar_cap", "polar cap flag", "           Use polar cap as grid?(yes=1, no=0)", **_FLAG)

_FIELDS = (
    Field("iterations", "iterations", "1)Iterations", 1, MOST_ITERATIONS, words="1 or more", width=12),
    Field("light_source", "light source", "2)Light source from model(0) or file(1)", **_FLAG),
    Field("direct_azimuth_deg", "direct azimuth", " a) direct azimuth angle(deg)", 0, 359),
    Field("direct_zenith_deg", "direct zenith", " b) direct zenith angle(deg)", 0, 89),
    Field("n_constituents", "constituents", "3)number of system constituents", 1, 20),
    Field("depth_m", "depth", "4)depth (M)", 0, 10_000, 2, width=12),
    Field("side_m", "side", "5)side boundaries (M)", 0, 100_000, 2, width=12),
    Field("n_recording_layers", "recording layers", "6)Number of depth recording layers", 0, 500),
    Field("layer_thickness_m", "layer thickness", "  a) Thickness of each recording layer", -1, 500, 4, width=12),
    Field("n_alpha_intervals", "alpha intervals", "7)# of alpha intervals to bin (MAX=180)", 1, 180),
    Field("n_phi_intervals", "phi intervals", "8)# of phi intervals to bin (MAX=180)", 1, 360),
    Field("interval_type", "interval type", "           Interval type (ang = 1,cos = 0)", **_FLAG),
    Field("log_absorption", "absorption log", "9)X,Y,Z for absorption (yes=1,no=0)", **_FLAG),
    Field("log_bottom", "bottom log", "10)BOT.-output(yes=1,no=0)", **_FLAG),
    Field("log_side", "side log", "11)SIDE-output(yes=1,no=0)", **_FLAG),
    Field("spf_from_file", "SPF from file", "12)SPF from file? (yes=1,no=0)", **_FLAG),
    Field("n_spf_angles", "SPF angles", "   a) Number of angles", 0, 360),
    Field("n_concentration_layers", "concentration layers", "13)# of concentration dependent layers", 1, 100),
    Field(
        "n_grid_cells",
        "grid cells",
        "14)Number of cells in X-Y direction(0=NOGRID)",
        0,
        101,
        words="0 or an odd number up to 101",
        is_odd=True,
    ),
    Field("cell_size_m", "cell size", "      Cell size (in unit meters)", 0, 100_000, 6, width=12),
    Field("surfer_output", "Surfer output", "      Output to Surfer format (yes=1,no=0)", **_FLAG),
    Field("footprint", "footprint", "15)Light source: point[1],circle[2],rect.[3]", 1, 3, words="1, 2 or 3", width=1),
    Field("circle_diameter_m", "circle diameter", "    a)If circle, define diameter", 0, 1e7, 6, width=12),
    Field("rectangle_x_m", "rectangle dX", "    b)If rectangle, define dX", 0, 1e7, 6, width=12),
    Field("rectangle_y_m", "rectangle dY", "    c)          and define dY", 0, 1e7, 6, width=12),
    Field("bottom_target", "bottom target", "16)Bottom target: NO[0],YES[1]", **_FLAG),
    Field("target_x_m", "target dX", "      define dX", 0, 1e7, 6, width=12),
    Field("target_y_m", "target dY", "      define dY", 0, 1e7, 6, width=12),
    Field("normalize_to_water", "normalisation", "17)Normalize output to air(0) or water(1)", **_FLAG),
    Field("n_wavebands", "wavebands", "18)Number of wavebands (minimum = 1)", 1, 500),
)


def fields_of_layout(with_polar_cap: bool) -> tuple[Field, ...]:
    """Fields in file order: 30, or 31 with the older layout's polar cap flag."""
    if not with_polar_cap:
        return _FIELDS
    return (*_FIELDS[:_POLAR_CAP_INDEX], _POLAR_CAP, *_FIELDS[_POLAR_CAP_INDEX:])


def has_polar_cap_line(lines: list[str]) -> bool:
    """Whether line 12 carries the label of the older layout."""
    return len(lines) > _POLAR_CAP_INDEX and "polar cap" in lines[_POLAR_CAP_INDEX][: FIRST_COLUMN - 1].lower()


_FLAGS = ("use_polar_cap", "log_absorption", "log_bottom", "log_side", "spf_from_file", "surfer_output",
          "bottom_target")  # fmt: skip
_KINDS: dict[str, Any] = {"light_source": LightSource, "footprint": FootprintCode, **dict.fromkeys(_FLAGS, bool)}


def read_amc(path: str | Path, *, lenient: bool = False) -> AmcConfig:
    """Read amc.inp as Fortran does, and refuse values that a person would read differently.

    With `lenient` such a value is the one of Fortran, with a warning. Values that Fortran refuses stay errors.
    """
    lines = read_lines(path)
    report = Report(path=str(path), lenient=lenient, counts_bytes=True)
    values = read_fields(lines, fields_of_layout(has_polar_cap_line(lines)), report)
    report.close()
    return AmcConfig(**{name: _KINDS.get(name, lambda v: v)(value) for name, value in values.items()})


def read_fields(lines: list[str], fields: tuple[Field, ...], report: Report) -> dict[str, int | float]:
    """Read every field; problems go to the report, fields with one are left out."""
    if _is_displaced(lines, fields, report) and not report.lenient:
        return {}
    values: dict[str, int | float] = {}
    for reading in _readings(lines, fields):
        value = _checked(reading, report)
        if value is not None:
            values[reading.field.name] = value
    if len(lines) < len(fields):
        end, missing = Span(max(1, len(lines)), 1, lines[-1] if lines else ""), fields[len(lines)]
        message = f"the file ends after line {len(lines)}; {len(fields)} lines are needed, the next is {missing.title}"
        label = f"{missing.label:<{FIRST_COLUMN - 3}}:".strip()
        advice = f"add the line '{label}' and those after it"
        report.at(end, "E105", message, name=missing.title, advice=advice)
    return values


def _is_displaced(lines: list[str], fields: tuple[Field, ...], report: Report) -> bool:
    """Whether a numbered label is in a wrong line, because a line is missing or too many."""
    labels = [_LABEL.match(field.label) for field in fields]
    own_line = {m[1]: k for k, m in enumerate(labels) if m}
    for index, line in enumerate(lines[: len(fields)]):
        label = _LABEL.match(line[:_START])
        if not label or own_line.get(label[1], index) == index:
            continue
        # a single mistyped label does not mean a displaced line: the next numbered label decides
        own = own_line[label[1]]
        if not _next_label_agrees(lines, own_line, index, index - own):
            continue
        if index > own:
            what, extra = "one line too many", _extra_line(lines, own_line, index)
            span = Span(extra + 1, 1, lines[extra], max(1, len(lines[extra].rstrip())))
        else:
            what, span = "one line missing", Span(index + 1, label.start(1) + 1, line, len(label[1]) + 1)
        message = f"there is {what}: label '{label[1]})' is in line {index + 1}, but belongs in line {own + 1}"
        advice = f"{len(fields)} lines are needed, in the order of docs/formats/amc.md"
        report.at(span, "E105", message, advice=advice, can_downgrade=True)
        return True
    return False


def _extra_line(lines: list[str], own_line: dict[str, int], index: int) -> int:
    """The line that is too many before a displaced label: a blank one, else the one right before it."""
    first = index
    while first > 0:
        label = _LABEL.match(lines[first - 1][:_START])
        if label and own_line.get(label[1]) == first - 1:
            break
        first -= 1
    blank = [k for k in range(first, index) if not lines[k].strip()]
    return blank[0] if blank else max(index - 1, 0)


def _next_label_agrees(lines: list[str], own_line: dict[str, int], index: int, shift: int) -> bool:
    for later in range(index + 1, min(len(lines), index + 8)):
        label = _LABEL.match(lines[later][:_START])
        if label and label[1] in own_line:
            return later - own_line[label[1]] == shift
    return True


@dataclass(frozen=True, kw_only=True, slots=True)
class _Reading:
    """A line as Fortran reads it, and as a person reads it."""

    field: Field
    span: Span  #: The number that a person sees
    token: str  #: Its text; empty where there is none
    value: int | float | None  #: Value that Fortran reads in its columns, or None if it refuses them
    meant: int | float | None  #: Value that a person reads

    @property
    def text(self) -> str:
        """The columns that Fortran reads."""
        return self.span.text[_START : _START + self.field.width]

    @property
    def edit_descriptor(self) -> str:
        """How Fortran reads them."""
        f = self.field
        return f"I{f.width}" if f.decimals is None else f"F{f.width}.{f.decimals}"


def _readings(lines: list[str], fields: tuple[Field, ...]) -> list[_Reading]:
    """The lines of the fields, read in both ways."""
    pairs = list(zip(lines, fields, strict=False))
    seen = [_what_a_person_reads(line, field) for line, field in pairs]
    columns = [line[_START : _START + field.width] for line, field in pairs]
    words = [token.removesuffix(",") for token, _ in seen]  # no number ends with a comma
    values = values_of(columns, words, [field.decimals for _, field in pairs])
    readings = []
    for number, ((line, field), (token, column), both) in enumerate(zip(pairs, seen, values, strict=True), start=1):
        span = Span(number, column, line, max(len(token), 1))
        readings.append(_Reading(field=field, span=span, token=token, value=both[0], meant=both[1]))
    return readings


def _checked(reading: _Reading, report: Report) -> int | float | None:
    """The value of a line; a wrong one is reported and gives None."""
    field, value, meant = reading.field, reading.value, reading.meant

    def note(code: str, message: str, advice: str, *, can_downgrade: bool = False) -> None:
        advice += _column_remark(reading.span.text[:_START]) if code != "E102" else ""
        report.at(reading.span, code, message, name=field.title, advice=advice, can_downgrade=can_downgrade)

    if value is None or not math.isfinite(value):
        expected = "a whole number" if field.decimals is None else "a finite number with a decimal point"
        message = f"'{reading.text.strip(' ')}' is not {expected} (Fortran {reading.edit_descriptor})"
        is_followed = meant is not None and len(reading.text) > len(reading.token) and field.width > 1
        note("E107", message, _example(reading) + is_followed * f", and blanks up to column {_START + field.width}")
        return None
    if meant is None or meant != value:
        code, message = _difference(reading, value)
        advice = _example(reading, has_place=code == "E108")
        if code == "E109" and meant is not None and field.decimals is None and field.is_allowed(value):
            advice += f", or {value}"  # the digits of 100 000 belong together, those of 12 1 do not
        note(code, message, advice, can_downgrade=True)
        if report.has_errors and not report.lenient:
            return None
    lenient_thickness = field.name == "layer_thickness_m" and not report.lenient
    if not field.is_allowed(value) or (lenient_thickness and value != -1 and not value > 0):
        allowed = "-1 or above 0 up to 500" if field.name == "layer_thickness_m" else field.allowed
        shown = f"{value:g}" if field.decimals is not None else f"{value}"
        note("E102", f"{shown} is outside the range {allowed}", f"write {allowed}")
        return None
    return value


def _what_a_person_reads(line: str, field: Field) -> tuple[str, int]:
    """The number a person sees in a line and its 1-based column, or an empty text."""
    end = _START + field.width
    inside = [k for k in range(_START, min(end, len(line))) if line[k] not in " \t"]
    if inside:
        first, last = inside[0], inside[0]
    else:
        beyond = [k for k in range(end, len(line)) if line[k] not in " \t"]
        before = line[:_START].rstrip()
        if before and before[-1] in _NUMBER_CHARACTERS and (":" in before or "\t" in before):
            first = last = len(before) - 1
        elif beyond:
            first = last = beyond[0]
        else:
            return "", FIRST_COLUMN
    while first > 0 and line[first - 1] in _NUMBER_CHARACTERS:
        first -= 1
    ends = " \t(!#;" if field.width == 1 else " \t"  # Fortran reads no further, and neither does a person
    while last + 1 < len(line) and line[last + 1] not in ends:
        last += 1
    return line[first : last + 1], first + 1


def _difference(reading: _Reading, value: float) -> tuple[str, str]:
    """Code and message where Fortran and a person disagree."""
    field, token, column = reading.field, reading.token, reading.span.column
    shown = f"{value}" if field.decimals is None else f"{value:.{field.decimals}f}"
    if field.decimals is not None and value != 0 and float(shown) != value:
        shown = f"{value:g}"
    reads = f"Fortran {reading.edit_descriptor} reads it as {shown}"
    if not token:
        return "E106", f"the value is missing; Fortran {reading.edit_descriptor} reads a blank as 0"
    last = _START + field.width
    if column < FIRST_COLUMN or column + len(token) - 1 > last:
        code = "E103" if field.width == 1 else "E108"
        columns = f"column {FIRST_COLUMN}" if field.width == 1 else f"columns {FIRST_COLUMN} to {last}"
        return code, f"'{token}' is not in {columns}; {reads}"
    if field.decimals is not None and "." not in token and reading.meant is not None:
        return "E104", f"'{token}' has no decimal point; {reads}"
    return "E109", f"'{reading.text.strip()}' can be read in two ways; {reads}"


def _example(reading: _Reading, *, has_place: bool = False) -> str:
    field = reading.field
    where = f"in column {FIRST_COLUMN}" if field.width == 1 else f"from column {FIRST_COLUMN} on"
    meant = _likely(reading.token, field) if reading.meant is None else [reading.meant]
    texts = [str(one) if field.decimals is None else repr(float(one)) for one in meant if field.is_allowed(one)]
    texts = [text if "." in text else text.replace("e", ".0e") for text in texts]
    if not texts:
        return f"write {field.allowed} {where}"
    if len(texts[0]) > field.width:
        return f"write a number of at most {field.width} characters"
    return f"write {', or '.join(texts)}" + (f" {where}" if field.width == 1 or has_place else "")


def _likely(word: str, field: Field) -> list[int | float]:
    """What a person may mean by a word that Fortran does not read so: 1e6 and 1,000,000 are counts, 0,5 is a length."""
    texts = [word.replace(",", ".")] * (field.decimals is not None or "," not in word)
    numbers = [list_real(text) for text in [*texts, *[word.replace(",", "")] * is_thousands(word)]]
    good = [one for one in numbers if one is not None and math.isfinite(one)]
    return list(good) if field.decimals is not None else [int(one) for one in good if one == int(one)]


def _column_remark(label: str) -> str:
    """Why columns before the value are not those of an editor."""
    letter = next((one for one in label.encode("latin-1").decode(errors="ignore") if not one.isascii()), "")
    if "\t" in label:
        return "; to Fortran a tab is one column"
    return f"; to Fortran a letter such as {letter} is {len(letter.encode())} columns" if letter else ""


def read_lambbot(
    path: str | Path, *, n_wavebands: int | None = None, has_target: bool = False, lenient: bool = False
) -> Wavebands:
    """Read lambbot.inp; `n_wavebands` is the count that amc.inp announces, to be compared.

    With `has_target` there are five columns instead of three; with `lenient` values outside their range are warnings.
    """
    n_columns = 5 if has_target else 3
    rows = read_band_rows(path, _COLUMNS[:n_columns], _HIGHEST[:n_columns], n_wavebands, lenient=lenient)
    return Wavebands(**dict(zip((field.name for field in dataclasses.fields(Wavebands)), rows.T, strict=False)))


@dataclass(frozen=True, kw_only=True, slots=True)
class DifcolTable:
    """`direct_fraction` [0 to 1] and `intensity` [0 or more, relative], float64, shape (n_band,)."""

    direct_fraction: np.ndarray
    intensity: np.ndarray


def read_difcol(path: str | Path, *, n_wavebands: int | None = None, lenient: bool = False) -> DifcolTable:
    """Read difcol.inp; `n_wavebands` is the count that amc.inp announces, to be compared.

    With `lenient` more rows than the count are a warning.
    """
    rows = read_band_rows(path, ("direct fraction", "intensity"), (1.0, inf), n_wavebands, lenient=lenient)
    rows.flags.writeable = False
    return DifcolTable(direct_fraction=rows[:, 0], intensity=rows[:, 1])


def read_band_rows(
    path: str | Path, names: tuple[str, ...], highest: tuple[float, ...], n_wavebands: int | None, *, lenient: bool
) -> np.ndarray:
    """Rows (n_band, n_column) of a file with one row per waveband, each value from 0 to the `highest` of its column."""
    lines = read_lines(path)
    report = Report(path=str(path), lenient=lenient, counts_bytes=True)
    scanner = ListScanner(lines)
    head = scanner.record(0, 1)
    count = head.tokens[0] if head.tokens else scanner.absent(1)
    n_rows = _read_count(count, n_wavebands, report)
    is_joined = n_rows > 0 and head.n_more >= len(names)  # whether a line goes on with the numbers of a row
    if is_joined:
        message = "a row is behind the count; Fortran ignores it"
        report.at(head.behind, "E204", message, advice=_OWN_LINE, can_downgrade=True)
    rows = np.zeros((n_rows, len(names)))
    index = head.next_line
    first: list[Token] = []
    n_short = 0  # rows in pieces, which cannot be counted
    while len(first) < n_rows:
        record = scanner.record(index, len(names))
        if not record.tokens and not record.ended_by_slash:
            message = f"the first line says {n_rows} rows, but the file ends after {len(first)}"
            end = scanner.absent(max(len(lines), 1))
            advice = _OWN_LINE if is_joined else "add the missing rows, or correct the count"
            report.at(end, "E203", message, advice=advice)
            break
        if record.is_text:
            message = f"'{record.tokens[0].word}' is not a row; Fortran stops here"
            report.at(record.tokens[0], "E204", message, advice="remove the line, or write it after the rows")
            index = record.tokens[0].line
            if report.is_full:
                break
            continue
        is_joined |= record.n_more >= len(names)
        _read_row(record, rows[len(first)], names, highest, report)
        first.append(record.tokens[0] if record.tokens else scanner.absent(record.next_line))
        if len(record.tokens) < len(names):
            _report_short(record, record.tokens[-1] if record.tokens else first[-1], names, report)
            n_short += 1
        index = record.next_line
        if report.is_full:
            break
    if n_rows and len(first) == n_rows and not n_short:
        _report_more_rows(count, n_rows, len(names), "\n".join(lines[index:]), report)
    if names[0] == _COLUMNS[0]:
        ask_unit(list(zip(first, rows[:, 0].tolist(), strict=False)), "E202", report)
    report.close()
    return rows


def _report_more_rows(count: Token, n_rows: int, n_columns: int, rest: str, report: Report) -> None:
    """Report lines after the last row that hold a row's numbers and no text."""
    row = rf"^[ \t]*+(?:[+-]?[.0-9][.0-9eEdDqQ+-]*+[ \t,;\r]*+){{{n_columns},}}+$"
    n_more = len(re.findall(row, rest, re.MULTILINE))
    if n_more:
        message = f"the first line says {n_rows} rows, but the file has {n_rows + n_more}"
        advice = f"remove the last ones, or write {n_rows + n_more} here and in the last line of amc.inp"
        report.at(count, "E203", message, name="count", advice=advice, can_downgrade=True)


def _read_count(token: Token, n_wavebands: int | None, report: Report) -> int:
    count = list_integer(token.word)
    if count is None or not 1 <= count <= MAX_BANDS:
        found = f"'{token.word}'" if token.word else "nothing"
        message = f"found {found}, expected the number of wavebands, 1 to {MAX_BANDS}"
        report.at(token, "E204", message, name="count", advice=f"write {n_wavebands or 'the number of wavebands'}")
        return 0
    if n_wavebands is not None and count != n_wavebands:
        message = f"the file is for {count} wavebands, amc.inp is for {n_wavebands}"
        advice = f"write {n_wavebands}, or change the last line of amc.inp"
        report.at(token, "E201", message, name="count", advice=advice)
    return count


def _read_row(
    record: Record, row: np.ndarray, names: tuple[str, ...], highest: tuple[float, ...], report: Report
) -> None:
    comma = record.decimal_comma() if record.has_comma and len(record.tokens) == len(names) else None
    if comma is not None:
        column, span, message, advice = comma
        report.at(span, "E205", message, name=names[column], advice=advice)
        return
    for k, (name, token, value) in enumerate(zip(names, record.tokens, record.reals(), strict=False)):
        if not token.word:
            message = "the value is missing; Fortran does not set it"
            report.at(token, "E205", message, name=name, advice="write every value")
        elif value is None:
            message, advice = no_number(token.word, is_short=len(record.tokens) < len(names))
            report.at(token, "E204", message, name=name, advice=advice)
        elif not math.isfinite(value):
            report.at(token, "E202", f"{token.word} is not finite", name=name, advice="write a number")
        else:
            if not 0 <= value <= highest[k]:
                allowed = f"0 to {highest[k]:g}" if math.isfinite(highest[k]) else "0 or more"
                message, advice = f"{token.word} is outside the range {allowed}", f"write {allowed}"
                may_pass = names[0] == _COLUMNS[0] and value > 0  # no scene has less than no light
                report.at(token, "E202", message, name=name, advice=advice, can_downgrade=may_pass)
            row[k] = value


def _report_short(record: Record, last: Token, names: tuple[str, ...], report: Report) -> None:
    n_values = len(record.tokens)
    span, name, advice = last.behind, names[n_values], "write all values of a waveband in one line"
    if record.ended_by_slash:
        code, message, advice = "E205", f"the row ends at the slash; {name} is not set", f"{advice}, without a slash"
    elif record.first_word is not None:
        return  # reported as such
    else:
        code, message = "E204", f"the row has {n_values} values, expected {len(names)}; {name} is missing"
    report.at(span, code, message, name=name, advice=advice)
