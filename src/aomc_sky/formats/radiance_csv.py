"""Measured radiances of the sky as a table of text, with a row for each direction."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg
from aomc_sky.errors import Span, UsageError
from aomc_sky.formats.azimuth_words import (
    ASSUMED_AZIMUTH,
    SAY_AZIMUTH,
    UnclearError,
    convention_of,
    given_convention,
    is_on_azimuths,
)
from aomc_sky.formats.radiance_unit import SAY_UNIT, radiance_factor, unit_in
from aomc_sky.formats.radiance_words import (
    ANGLE_DEGREES,
    FROM_HORIZON,
    GAP_NUMBERS,
    GAPS,
    KEYS,
    LEAST_NM,
    LENGTH_NM,
    LOGARITHM,
    MAX_RADIANCE,
    MOST_NM,
    MOST_SAID,
    ON_ZENITHS,
    SAY_ANGLE,
    SAY_COMES_FROM,
    SAY_FACTOR,
    SAY_SUN,
    SAY_WEIGHTED,
    STATED_FACTOR,
    Name,
    by_wavelength,
    doubt_of_gaps,
    have_look_of_degrees,
    may_be_radians,
    name_of_column,
    plain_unit,
    travel_of,
    unit_and_counts,
    weight_of,
)
from aomc_sky.formats.report import MAX_PER_VALUE, BadValueError, Report, printable, quoted
from aomc_sky.formats.text_file import cell_span, delimiter_of, read_bytes, split_row, table_of_program
from aomc_sky.formats.units import parse_real
from aomc_sky.inputs import SURE_NM

MAX_BYTES = 2**27
_DIGITS = 10  #: Decimals of a degree that are kept, so that radians give back the degrees they came from.

_AZIMUTH_LINE = f"{SAY_AZIMUTH}; or a line '# azimuth: clockwise from north', '# azimuth: from the sun'"
_ANGLE_LINE = f"{SAY_ANGLE}, or a line '# angle unit: deg', or name the column zenith_deg"
_ANGLES = "give zenith angles and azimuths in degrees or radians, in columns named zenith_deg or zenith_rad and so on"
_UNIT_LINE = f"{SAY_UNIT}; or a line '# radiance unit: mW m-2 nm-1 sr-1'"
_SUN_LINE = f"{SAY_SUN}, or a line '# sun azimuth: 225 clockwise from north'"
COMMENT = re.compile(r"\s*(?:[#%!]+|//+|;(?!.*;))")
"""Start of a line of comment; a row may begin with an empty column and a semicolon, but has two of them."""
_GROUPED = re.compile(r"[1-9]\d{0,2}(?:[.,]\d{3})+")
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas"}
_RADIANCE_IN = re.compile(
    r"\s*(?:sky |spectral )*(radiance)s?(?: values?| data)? (?:are |is )?(?:given )?in "
    r"(?=.*(?:\b(?:sr|ster\w*|cd|lx|lux|[mu\N{MICRO SIGN}]?W|watts?)\b|m-2|/m))(\S.*?)[\s.]*\Z",
    re.I,
)
"""A line "radiances are in mW m-2 nm-1 sr-1": the key, and the unit."""
_OF_SUN = re.compile(
    r"\s*(?:(?:sun|solar)[ _]azimuth(?:[ _]angle)?|saa)(?:[ _]deg(?:rees)?)? ?(?:[(\[](.*?)[)\]])?"
    r"\s*[:=]?\s*([-+.\d].*?)\s*\Z",
    re.I,
)
"""A line "Sun azimuth (deg from N): 200": words on the value, and the number with more words."""
_MOST_HEAD = 100  #: Lines below the first one in which names are looked for.
_NEEDED = {
    "zenith": ("zenith angles", "name it 'zenith (deg)' or 'elevation (deg)'"),
    "azimuth": ("azimuth", "name it 'azimuth (deg)'"),
    "radiance": ("radiance", "name it 'radiance', or 'L_412' and so on for each wavelength"),
}


@dataclass(frozen=True, slots=True)
class _Column:
    """A column that the reader uses; `values` are NaN in gaps."""

    name: Name
    index: int
    span: Span
    values: np.ndarray


def read_radiance_points(
    path: str | Path,
    *,
    azimuth_convention: AzimuthConvention | str | None = None,
    angle_unit: str | None = None,
    radiance_unit: str | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
) -> dict[str, Any]:
    """Read a table as arguments of `RadianceField.from_points`, NaN in a gap; arguments here win over the file.

    InputFileError: every problem of the file (E651 to E654).
    """
    if angle_unit not in (None, "deg", "rad"):
        raise UsageError(f"angle_unit must be 'deg' or 'rad', got {angle_unit!r}")
    if radiance_unit is not None and radiance_factor(radiance_unit) is None:
        raise UsageError(f"radiance unit {radiance_unit!r} is not known; {SAY_UNIT}")
    given = {"angle": angle_unit, "radiance": radiance_unit}
    sun = {"sun_zenith": sun_zenith_deg, "sun_azimuth": sun_azimuth_deg}
    table = _Table(path, {name: value for name, value in given.items() if value is not None}, sun)
    return table.points(None if azimuth_convention is None else given_convention(azimuth_convention))


def _without_sign(line: str) -> str:
    """The line with blanks in place of its sign of a comment."""
    return COMMENT.sub(lambda sign: " " * len(sign[0]), line, count=1) if COMMENT.match(line) else line


def _has_names(names: list[str]) -> bool:
    """Whether a row names all columns that a table needs."""
    return set(_NEEDED) <= {one.slot for one in map(name_of_column, names) if one}


def _names_columns(line: str) -> bool:
    """Whether a line of comment names all columns that a table needs."""
    return _has_names(split_row(_without_sign(line), delimiter_of(line, DELIMITERS)))


class _Table:
    """A file while it is read."""

    def __init__(self, path: str | Path, given: dict[str, str], sun: dict[str, float | None]) -> None:
        data = read_bytes(path, most_bytes=MAX_BYTES, code="E651")
        self.report = Report(path=str(path))
        self.given, self.sun = given, sun
        self.head: dict[str, tuple[str, Span]] = {}
        self.azimuth_lines: list[tuple[str, Span]] = []
        self.zenith_lines: list[tuple[str, Span]] = []
        self.factor_lines: list[tuple[str, Span]] = []
        self.remarks: list[str] = []
        self.rows: list[tuple[int, str]] = []
        names: tuple[int, str] | None = None  # numpy.savetxt writes them behind a '#' or '%'
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
        for number, line in enumerate(text.split("\n"), start=1):
            line = line.removesuffix("\r")
            if COMMENT.match(line):
                if not self.rows and (names is None or not _names_columns(names[1])):
                    names = (number, line)
                self._read_key(number, line)
            elif line.strip(" ,;\t") and not line.lower().startswith("sep="):
                self.rows.append((number, line))
        if names and self.rows and not re.search("[A-Za-z]{2}", self.rows[0][1].lower().replace("nan", "")):
            self.rows.insert(0, names)
        self.delimiter = delimiter_of(self.rows[0][1] if self.rows else "", DELIMITERS)

    def _bad(self, span: Span, message: str, advice: str, code: str = "E651") -> None:
        self.report.at(span, code, message, advice=advice)

    def _read_key(self, number: int, line: str) -> None:
        text = _without_sign(line)
        match = re.match(r"\s*([A-Za-z][\w ]*?)\s*[:=]\s*(\S.*?)\s*\Z", text) or _RADIANCE_IN.match(text[:MOST_SAID])
        key = KEYS.get(re.sub(r"\W+", "_", match[1].lower())) if match else None
        start = match.start(2) if match and key else len(text) - len(text.lstrip())
        said = text[start:].rstrip()
        if key is None and (unit := unit_in(text[:MOST_SAID])):
            start, said = unit
            self._set("radiance", said, Span(number, start + 1, line, len(said)))
            if found := STATED_FACTOR.search(text[:start] + text[start + len(said) :]):
                self.factor_lines.append((found[0], Span(number, 1, line, len(line.rstrip()))))
            before, after = re.split(r"[,;](?=[^,;]*\Z)", text[:start])[:-1], re.split("[,;]", text[start:])[1:]
            start, said = 0, ",".join([*before, *after]).strip()  # the other parts of the sentence
        elif of_sun := _OF_SUN.match(text[:MOST_SAID]):
            key, start, said = "sun_azimuth", of_sun.start(2), " ".join(filter(None, of_sun.group(2, 1)))
        span = Span(number, start + 1, line, len(text[start:].rstrip()))
        plain = said.replace("_", " ")
        if key == "azimuth" or (key is None and is_on_azimuths(said[:MOST_SAID])):
            self.azimuth_lines.append((said, span))
        elif key is None and (word := travel_of(said)):
            self._bad(span, f"{word!r}: are the directions those that light goes to?", SAY_COMES_FROM)
        elif key is None and (weight := weight_of(said[:MOST_SAID])):
            self._bad(span, f"this line says {weight!r}", SAY_WEIGHTED)
        elif key is None and LOGARITHM.search(said[:MOST_SAID]):
            self._bad(span, f"{quoted(said)}: are these logarithms?", "write radiances, and leave out this line")
        elif key is not None:
            self._set(key, said, span)
        elif key is None and ON_ZENITHS.search(said) and (found := FROM_HORIZON.search(said)):
            self.zenith_lines.append((found[0], span))
        elif key is None and (found := STATED_FACTOR.search(plain)):
            self.factor_lines.append((found[0], span))

    def _set(self, key: str, said: str, span: Span) -> None:
        """Keep what a line says of a subject; another word on it is reported."""
        if self.head.setdefault(key, (said, span))[0] != said:
            self._bad(span, f"{quoted(said)} after {quoted(self.head[key][0])}", "keep one of the two lines")

    def _span(self, number: int, line: str, index: int) -> Span:
        """Position of a cell."""
        return cell_span(number, line, index, self.delimiter)

    def points(self, convention: AzimuthConvention | None) -> dict[str, Any]:
        """Return the contents of the file, or raise all its problems; a convention here wins over the file's."""
        columns = self._columns()
        if not columns or not self.rows:
            self._close()
        of = {one.name.slot: one for one in columns}
        light = [one for one in columns if one.name.role == "radiance"]
        angles = [of["zenith"], of["azimuth"]]
        zenith, azimuth = (self._angle(one, other) for one, other in (angles, angles[::-1]))
        sun_zenith, sun_azimuth = self._sun("sun_zenith", 90.0), self._sun("sun_azimuth", 360.0)
        azimuth = self._converted(azimuth, of["azimuth"], sun_azimuth, convention)
        azimuth = np.where(np.isnan(azimuth) & (zenith == 0.0), 0.0, azimuth)  # overhead all azimuths are one direction
        reach = np.abs(zenith[np.isfinite(zenith)])
        if np.any(reach > 90.0) and reach.min() >= 90.0:
            self._bad(
                of["zenith"].span, "no direction is above the horizon; is it where light goes to?", SAY_COMES_FROM
            )
        factor = self._factor(light)
        wavelength = self._wavelengths(light, of.get("wavelength"))
        for one in light:
            self._refuse(one, one.values < 0, "a radiance is 0 or more")
        self._ask_of_gaps(light, wavelength)
        self._close()
        zenith, azimuth = np.tile(zenith, len(light)), np.tile(azimuth, len(light))
        is_whole = np.isfinite(zenith) & np.isfinite(azimuth)
        is_whole &= True if wavelength is None else np.isfinite(wavelength)
        if not is_whole.all():
            n = np.count_nonzero(~is_whole)
            self.remarks.append(f"{n} radiances without direction or wavelength were left out")
        return {
            "sky_zenith_deg": zenith[is_whole],
            "sky_azimuth_deg": azimuth[is_whole],
            "wavelength_nm": None if wavelength is None else wavelength[is_whole],
            "radiance": np.concatenate([one.values for one in light])[is_whole] * (factor or 1.0),
            "is_absolute": factor > 0,
            "sun_zenith_deg": sun_zenith,
            "sun_azimuth_deg": sun_azimuth,
            "remarks": tuple(self.remarks),
        }

    def _close(self) -> None:
        self.report.problems.sort(key=lambda problem: (problem.line, problem.column))
        self.report.close()

    def _columns(self) -> list[_Column]:
        """The columns with their numbers, none where one is missing; problems are reported."""
        if not self.rows:
            self.report.add(
                "E654", "the file has no rows", advice="write names of columns, and a row for each direction"
            )
            return []
        number, line = self.rows.pop(0)
        names = split_row(_without_sign(line), self.delimiter)
        if layout := self._other_layout(line, names):
            self._bad(Span(number, 1, line, len(line.rstrip())), *layout)
            return []
        names = self._with_units(names)
        columns: dict[tuple[str, float | None], _Column] = {}
        unused = []
        for index, text in enumerate(names):
            name = name_of_column(text)
            span = self._span(number, line, index)
            if name is None:
                unused += [text] if text else []
                if re.match(r"wave_?numbers?\b|frequency\b", text, re.I):
                    self._bad(span, f"{quoted(text)} is no wavelength", "give wavelengths, and radiances per nm")
                elif re.search(r"nadir|(?:\b|_)(?:u?mu|cos\w*)(?:\b|_)", text, re.I):
                    self._bad(span, f"{quoted(text)} is no zenith angle", "write zenith angles, 0 overhead")
                continue
            one = _Column(name, index, span, np.full(len(self.rows), np.nan))
            first = columns.setdefault((name.slot, name.wavelength_nm), one)
            if first is not one:
                message = f"columns {first.index + 1} and {index + 1} are both {name.slot}"
                self._bad(span, message, "give the one that is not meant another name")
        slots, shown = {slot for slot, _ in columns}, ", ".join(quoted(text) for text in names[:12])
        missing = [slot for slot in _NEEDED if slot not in slots]
        for slot in missing:
            what, advice = _NEEDED[slot]
            span = Span(number, 1, line, len(line.rstrip()))
            self._bad(span, f"there is no column of {what} among {shown}", advice)
        if unused:
            self.remarks.append(f"columns not used: {', '.join(map(printable, unused))}")
        if not self.rows:
            self.report.add("E654", "the file has no row of numbers", advice="write a row for each direction")
        if missing:
            return []
        self._read_rows(list(columns.values()), len(names))
        return list(columns.values())

    def _other_layout(self, line: str, names: list[str]) -> tuple[str, str] | None:
        """What a table of another layout is, and what to write; `line` has the names."""
        for sign, what in ((None, "blanks"), ("|", "bars")):
            words = "".join(names).split(sign)
            if len(names) == 1 and sum(name_of_column(word.strip()) is not None for word in words) > 2:
                return f"{what} are between the columns", "separate the columns by commas"
        for later, text in self.rows[:_MOST_HEAD] if not _has_names(names) else ():
            if _has_names(split_row(text, delimiter := delimiter_of(text, DELIMITERS))):
                message = f"the names of the columns are in line {later}, with {DELIMITERS[delimiter]} between them"
                return message, f"write # before every line above line {later}"
        slots = {one.slot for one in map(name_of_column, names) if one}
        other = table_of_program([line, *(text for _, text in self.rows[:_MOST_HEAD])])
        if other and not slots & {"azimuth", "radiance"}:
            return f"this seems to be {other[0]}, no table of radiances", other[1]
        return None

    def _with_units(self, names: list[str]) -> list[str]:
        """The names with the units of a row below them, which is taken away."""
        units = split_row(self.rows[0][1], self.delimiter) if self.rows else []
        is_of_words = [bool(re.search(r"[^\W\d_]|[%°]", unit)) and unit.lower() not in GAPS for unit in units]
        if sum(is_of_words) < len(_NEEDED) or any(re.match(r"[-+]?[\d.]", unit) for unit in units):
            return names
        if any(name_of_column(unit) for unit in units):
            return names  # names again
        self.rows.pop(0)
        units += [""] * (len(names) - len(units))
        plain = [re.sub(r"[(\[](.*)[)\]]", r"\1", unit) if unit[:1] in "([" else unit for unit in units[: len(names)]]
        return [
            f"{name} ({unit})" if unit and "(" not in name else name for name, unit in zip(names, plain, strict=True)
        ]

    def _read_rows(self, columns: list[_Column], n_names: int) -> None:
        width = max((one.index for one in columns), default=0) + 1
        texts: dict[int, list[str]] = {}
        for k, (number, line) in enumerate(self.rows):
            cells = split_row(line, self.delimiter)
            if len(cells) < width or any(cells[n_names:]):
                advice = f"write {DELIMITERS[self.delimiter]} between columns, and a point for decimals"
                message = f"a row of {len(cells)} columns under {n_names} names"
                self._bad(Span(number, 1, line, len(line)), message, advice, "E652")
                continue
            texts[k] = cells
            for one in columns:
                try:
                    one.values[k] = self._number(cells[one.index], one.name.role)
                except BadValueError as problem:
                    span = self._span(number, line, one.index)
                    self._bad(span, problem.message, f"{problem.advice}, or nothing for a gap", "E652")
            if self.report.is_full:
                break
        used = [cells[one.index] for cells in texts.values() for one in columns]
        points = [mark for mark in ",." if any(mark in text and not _GROUPED.fullmatch(text) for text in used)]
        for one in columns:
            if one.name.role in ("radiance", "wavelength"):
                self._refuse_thousands(one.index, texts, points)

    def _refuse_thousands(self, index: int, texts: dict[int, list[str]], points: list[str]) -> None:
        """Ask where 1.050 may be 1050: beside 829, where commas are decimal `points`, or where all commas separate."""
        cells = {k: cells[index] for k, cells in texts.items() if cells[index].lower() not in GAPS}
        for mark, other in (",.", ".,"):
            marked = [k for k, text in cells.items() if mark in text]
            rest = [text for k, text in cells.items() if mark not in text]
            is_whole = self.delimiter + mark != ",." and all(text.isdecimal() and len(text) <= 3 for text in rest)
            is_odd = other in points or mark == self.delimiter or (is_whole and rest)
            if marked and mark not in points and is_odd and all(_GROUPED.fullmatch(cells[k]) for k in marked):
                text, digits = cells[marked[0]], re.sub("[.,]", "", cells[marked[0]])
                beside = f" beside {quoted(rest[0])}" if rest else ""
                message = f"{quoted(text)}{beside} may be {digits}, with a separator of thousands"
                number, line = self.rows[marked[0]]
                advice = f"write {digits}, or {text}0 for the decimal"
                self._bad(self._span(number, line, index), message, advice, "E652")

    def _number(self, text: str, role: str) -> float:
        if text.lower() in GAPS:
            return np.nan
        value = parse_real(text.replace(",", "."))
        is_gap = value in GAP_NUMBERS or (role == "radiance" and value > MAX_RADIANCE)
        if not is_gap and abs(value) > MAX_RADIANCE:
            raise BadValueError("E652", f"{quoted(text)} is beyond all ranges", advice="write a smaller number")
        return np.nan if is_gap else value

    def _refuse(self, column: _Column, is_bad: np.ndarray, allowed: str) -> None:
        """Report numbers of a column outside their range."""
        role = column.name.role
        for k in np.flatnonzero(is_bad)[:MAX_PER_VALUE]:
            number, line = self.rows[k]
            text = quoted(split_row(line, self.delimiter)[column.index])
            message = f"{text} is no {role}{' angle' * (role in ('zenith', 'elevation'))}"
            self._bad(
                self._span(number, line, column.index), message, f"{allowed}; nothing, nan or -999 is a gap", "E653"
            )

    def _ask_of_gaps(self, light: list[_Column], wavelength: np.ndarray | None) -> None:
        """Ask once whether the largest radiances of a column, at a wavelength, are gaps."""
        nm = np.zeros(len(light) * len(self.rows)) if wavelength is None else wavelength
        for one, own_nm in zip(light, np.split(nm, len(light)), strict=True):
            for k in by_wavelength(own_nm):
                if doubt := doubt_of_gaps([one.values[k]]):
                    number, line = self.rows[int(k[np.nanargmax(one.values[k])])]
                    self._bad(self._span(number, line, one.index), *doubt, "E653")
                    return

    def _unit(self, key: str, column: _Column) -> tuple[str, Span]:
        """The unit from an option, the name of a column or the head, and its position."""
        if key in self.given or column.name.unit:
            return self.given.get(key, column.name.unit), column.span
        return self.head.get(key, ("", column.span))

    def _angle(self, column: _Column, other: _Column) -> np.ndarray:
        """Zenith angles, or azimuths as they count in the file. [deg]"""
        unit, span = self._unit("angle", column)
        is_azimuth = column.name.slot == "azimuth"
        unit = unit_and_counts(unit)[0] if is_azimuth else unit
        unit = unit or self.head.get("angle", ("",))[0]
        scale = ANGLE_DEGREES.get(plain_unit(unit))
        if unit and scale is None:
            advice = _ANGLES + "; --azimuth-convention says from where azimuths count" * is_azimuth
            self._bad(span, f"{quoted(unit)} is no unit of an angle that is read", advice)
        elif not unit and not have_look_of_degrees(column.values) and np.any(np.abs(column.values) > 0):
            message, advice = "nothing says whether this is in degrees or radians", _ANGLE_LINE
            if have_look_of_degrees(other.values):
                sizes = [f"{one.name.role} to {np.nanmax(one.values):g}" for one in (column, other)]
                message = f"{message}: {' beside '.join(sizes)}"
                advice = "name the columns by their units: zenith_rad, azimuth_deg"
            self._bad(span, message, advice)
        if scale == 1.0 and "angle" not in self.given and may_be_radians(column.values, is_azimuth=is_azimuth):
            message = f"angles up to {np.nanmax(column.values):g} degrees; are they radians?"
            self._bad(span, message, _ANGLE_LINE)
        if column.name.role == "zenith":
            for word, place in self.zenith_lines[:1]:
                advice = "name a column of elevations 'elevation', and leave out the line for zenith angles"
                self._bad(place, f"zenith angles by the name of the column, but this line says {word!r}", advice)
        angle = np.round(column.values * (scale or 1.0), _DIGITS)
        low, high = (-360, 360) if is_azimuth else (-90, 180)
        self._refuse(column, (angle < low) | (angle > high), f"write {low} to {high} degrees")
        return 90.0 - angle if column.name.role == "elevation" else angle

    def _sun(self, name: str, high: float) -> float | None:
        """An angle of the sun from an option or the head. [deg]"""
        given = self.sun[name]
        if name not in self.head:
            return given
        text, span = self.head[name]
        if given is not None:
            self.remarks.append(f"{name.replace('_', ' ')} {given:.7g} degrees, in place of {quoted(text)} of the file")
            return given
        match = re.fullmatch(r"(-?(?:\d+\.?\d*|\.\d+))\s*(deg(?:rees)?\b|°|rad(?:ians?)?\b|),?\s*(.*)", text)
        unit = plain_unit(match[2] or self.head.get("angle", ("deg",))[0]) if match else ""
        value = round(float(match[1]) * ANGLE_DEGREES.get(unit, np.nan), _DIGITS) if match else np.nan
        is_right = abs(value) <= high and (name == "sun_azimuth" or match[3] == "")  # type: ignore[index]
        convention = None
        if is_right and name == "sun_azimuth":
            try:
                convention = convention_of(match[3])  # type: ignore[index]
            except UnclearError:
                is_right = False
        if not is_right or (convention and convention.is_from_sun):
            advice = _SUN_LINE if name == "sun_azimuth" else "write '# sun zenith: 40 deg', 0 to 90 degrees"
            self._bad(span, f"{quoted(text)} does not say where the sun is", advice)
            return 0.0
        return float(to_enu_azimuth_deg(value, convention)) if convention else value

    def _converted(
        self, azimuth: np.ndarray, column: _Column, sun_azimuth: float | None, given: AzimuthConvention | None
    ) -> np.ndarray:
        """Azimuths from +x towards +y."""
        named = unit_and_counts(column.name.unit)[1]
        said = [*self.azimuth_lines, *([(named, column.span)] if named else [])]
        if column.name.role == "relative azimuth":
            said.append(("relative", column.span))
        span = said[0][1] if said else column.span
        try:
            convention = convention_of(*(text for text, _ in said)) if given is None and said else given
        except UnclearError as error:
            self._bad(span, str(error), _AZIMUTH_LINE)
            return azimuth
        if convention is None:
            self.remarks.append(f"the file {ASSUMED_AZIMUTH}")
            convention = AzimuthConvention.ENU_FROM_EAST
        if convention.is_from_sun and sun_azimuth is None:
            self._bad(span, "azimuths count from the sun, but nothing says where it is", _SUN_LINE)
            return azimuth
        return to_enu_azimuth_deg(azimuth, convention, sun_azimuth)

    def _factor(self, light: list[_Column]) -> float:
        """The unit in W m-2 nm-1 sr-1; 0 for relative radiances."""
        unit, span = self._unit("radiance", light[0])
        factors = [radiance_factor(one.name.unit) if one.name.unit else -1.0 for one in light]
        other = next((one for one, own_factors in zip(light, factors, strict=True) if own_factors != factors[0]), None)
        if not unit and other is None:
            self.remarks.append("the file has no unit of radiance, so its light is relative (--radiance-unit says one)")
            return 0.0
        factor = radiance_factor(unit)
        in_head, place = self.head.get("radiance", (unit, span))
        if "radiance" not in self.given and radiance_factor(in_head) != factor:
            self._bad(place, f"{quoted(in_head)} beside {quoted(unit)} of the column", _UNIT_LINE)
        elif "radiance" not in self.given and self.factor_lines and unit and factor != 0.0:
            word, place = self.factor_lines[0]
            self._bad(place, f"this line says {word!r} besides the unit", SAY_FACTOR)
        elif other is not None and "radiance" not in self.given:
            self._bad(other.span, "columns of radiance have different units", _UNIT_LINE)
        elif factor is None:
            self._bad(span, f"{quoted(unit)} is no unit of spectral radiance", _UNIT_LINE)
        return factor or 0.0

    def _wavelengths(self, light: list[_Column], column: _Column | None) -> np.ndarray | None:
        """Wavelength of each radiance, None where the file has none. [nm]"""
        n = light[0].values.size
        unnamed = [one for one in light if one.name.wavelength_nm is None]
        if len(unnamed) < len(light):
            if unnamed or column is not None:
                advice = "keep one of the two, and give the other columns other names"
                self._bad((column or unnamed[0]).span, "other columns have wavelengths in their names", advice)
            of_names = np.array([one.name.wavelength_nm or 0.0 for one in light])
            said = light[0].span.text[light[0].span.column - 1 :][: light[0].span.width]
            if of_names.min() > SURE_NM and "nm" not in said.lower():
                self._bad(light[0].span, "are these wavelengths angstroms?", "write L_412 or L_412nm for 412 nm")
            return np.repeat(of_names, n)
        if column is not None:
            scale = LENGTH_NM.get(plain_unit(column.name.unit or "nm"))
            if scale is None:
                message = f"{quoted(column.name.unit)} is no unit of a wavelength"
                self._bad(column.span, message, "write wavelength (nm) or wavelength (um)")
                return None
            nm = np.round(column.values * scale, _DIGITS)
            if not column.name.unit and np.nanmin(nm, initial=np.inf) > SURE_NM:
                self._bad(column.span, "are these wavelengths angstroms?", "write wavelength (nm) or wavelength (A)")
            allowed = f"write {LEAST_NM:g} to {MOST_NM:g} nm, or name the column wavelength (um)"
            self._refuse(column, (nm < LEAST_NM) | (nm > MOST_NM), allowed)
            return nm
        if "wavelength" not in self.head:
            return None
        text, span = self.head["wavelength"]
        match = re.fullmatch(r"(\d+(?:\.\d*)?)\s*(\S*)", text)
        value = float(match[1]) * LENGTH_NM.get(plain_unit(match[2] or "nm"), np.nan) if match else np.nan
        if not LEAST_NM <= value <= MOST_NM:
            self._bad(span, f"{quoted(text)} is no wavelength", "write '# wavelength: 550 nm', or um for micrometres")
        return np.full(n, value)
