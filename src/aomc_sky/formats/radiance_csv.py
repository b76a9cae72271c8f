"""Measured radiances of the sky as a table of text, with a row for each direction."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.directions import to_enu_azimuth_deg
from aomc_sky.errors import Span
from aomc_sky.formats.azimuth import SAY_AZIMUTH, convention_of
from aomc_sky.formats.quote import quote, unused_note, with_texts
from aomc_sky.formats.radiance_unit import SAY_UNIT
from aomc_sky.formats.radiance_words import (
    ANGLE_DEGREES,
    AT_WAVELENGTH,
    COORDINATES,
    GAP_NUMBERS,
    GAPS,
    KEYS,
    LEAST_NM,
    LENGTH_NM,
    MAX_RADIANCE,
    MOST_NM,
    NAMES,
    RADIANCE,
    SAY_ANGLE,
    SAY_COMES_FROM,
    SAY_LENGTH,
    SAY_SUN,
    Stated,
    SunAngles,
    by_wavelength,
    doubt_of_gaps,
    instead,
    may_be_radians,
    meaning_of,
    plain_unit,
    quantity_of,
    say_coordinate,
)
from aomc_sky.formats.report import MAX_PER_VALUE, BadValueError, Report, quoted
from aomc_sky.formats.text_file import cell_span, delimiter_of, read_bytes, split_row
from aomc_sky.formats.units import parse_real

MAX_BYTES = 2**27
_DIGITS = 10  #: Decimals of a degree that are kept, so that radians give back the degrees they came from.

_DECIMAL_LINE = "write --decimal {0} (decimal=), or a line '# decimal: {0}'"
_SUN_LINE = f"{SAY_SUN}, or a line '# sun azimuth: 225 clockwise from north'"
_WHAT = {
    "azimuth": "convention of azimuths",
    "angle_unit": "unit of an angle",
    "wavelength_unit": "unit of a wavelength",
    "radiance_unit": "unit of spectral radiance",
    "decimal": "sign of decimals",
}
_ADVICE = {
    "azimuth": f"{SAY_AZIMUTH}, or a line '# azimuth: clockwise from north'",
    "angle_unit": f"{SAY_ANGLE}, or a line '# angle unit: deg', or name the columns zenith_deg, azimuth_rad and so on",
    "wavelength_unit": f"{SAY_LENGTH}, or a line '# wavelength unit: nm', or name the column wavelength_nm or "
    "wavelength_um",
    "radiance_unit": f"{SAY_UNIT}; or a line '# radiance unit: mW m-2 nm-1 sr-1'",
    "decimal": _DECIMAL_LINE.format("comma"),
}
_NEEDED = {
    "zenith": ("zenith angles", "name it zenith_deg, or elevation_deg"),
    "azimuth": ("azimuths", "name it azimuth_deg"),
    "radiance": ("radiances", "name it radiance, or L_412 and so on for each wavelength [nm]"),
}
_COMMENT = re.compile(r"[\s\"]*(?:[#%!]+|//+)")
_KEY = re.compile(r"\s*([A-Za-z][\w ]*?)\s*[:=][\s,;]*(\S.*?)[\s,;\"]*\Z")  # Excel fills lines up with commas
_MEASURE = re.compile(r"(-?(?:\d+\.?\d*|\.\d+)) *([^\W\d_]*)\b,? *(.*)")
"""A number, its unit, and more words: 225 deg clockwise from north."""
_GROUPED = re.compile(r"[1-9]\d{0,2}(?:\.\d{3})+")
"""A number that may have a separator of thousands."""
_SUN = ("sun_zenith_deg", "sun_azimuth_deg")
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas"}


@dataclass(frozen=True, slots=True)
class _Column:
    """A column that the reader uses; `values` are NaN in gaps."""

    role: str
    unit: str  #: By its name
    wavelength_nm: float | None  #: By its name
    name: str
    index: int
    span: Span
    values: np.ndarray

    @property
    def slot(self) -> str:
        """The quantity that the column gives in the end."""
        return quantity_of(self.role)


def read_radiance_points(
    path: str | Path, stated: Stated, sun: SunAngles = (None, None), other_sun: SunAngles = (None, None)
) -> tuple[dict[str, Any], SunAngles]:
    """Read a table: arguments of `RadianceField.from_points`, NaN in a gap, and the angles of the sun that it states.

    What a caller states comes before what the file states; `other_sun` has the angles of the sun where neither does.
    InputFileError: every problem of the file (E651 to E654).
    """
    stated.check()
    table = _Table(path, stated, dict(zip(_SUN, zip(sun, other_sun, strict=True), strict=True)))
    return table.points(), (table.sun_of_file.get(_SUN[0]), table.sun_of_file.get(_SUN[1]))


def _without_sign(line: str) -> str:
    """The line with blanks in place of its sign of a comment."""
    return _COMMENT.sub(lambda sign: " " * len(sign[0]), line, count=1) if _COMMENT.match(line) else line


class _Table:
    """A file while it is read."""

    def __init__(self, path: str | Path, stated: Stated, sun: dict[str, SunAngles]) -> None:
        data = read_bytes(path, most_bytes=MAX_BYTES, code="E651")
        self.report = Report(path=str(path))
        self.stated, self.sun = stated, sun
        self.sun_of_file: dict[str, float] = {}
        self.head: dict[str, tuple[str, Span]] = {}
        self.texts: dict[int, str] = {}
        self.remarks: list[str] = []
        self.rows: list[tuple[int, str]] = []
        names: tuple[int, str] | None = None  # numpy.savetxt writes them behind a '#' or '%'
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
        for number, line in enumerate(text.split("\n"), start=1):
            line = line.removesuffix("\r")
            if _COMMENT.match(line):
                if not self.rows and (names is None or not self._names_columns(names[1])):
                    names = (number, line)
                self._read_comment(number, line)
            elif line.strip(" ,;\t") and not line.lower().startswith("sep="):
                self.rows.append((number, line))
        first = self.rows[0][1] if self.rows else ""
        is_of_numbers = bool(first) and _is_of_numbers(first)
        if names and (is_of_numbers or (self._names_columns(names[1]) and not self._names_columns(first))):
            self.rows.insert(0, names)
            self.texts.pop(names[0], None)
        self.delimiter = delimiter_of(self.rows[0][1] if self.rows else "", DELIMITERS)

    def _bad(self, span: Span, message: str, advice: str, code: str = "E651") -> None:
        if not any(
            (one.line, one.column, one.message) == (span.line, span.column, message) for one in self.report.problems
        ):
            self.report.at(span, code, message, advice=advice)

    def _read_comment(self, number: int, line: str) -> None:
        text = _without_sign(line)
        match = _KEY.match(text)
        key = KEYS.get(" ".join(match[1].lower().replace("_", " ").split())) if match else None
        if match is None or key is None:
            if any(map(str.isalnum, text)):
                self.texts[number] = text.strip(' \t,;"')
            return
        span = Span(number, match.start(2) + 1, line, len(match[2]))
        if self.head.setdefault(key, (match[2], span))[0] != match[2]:
            self._bad(span, f"{quoted(match[2])} after {quoted(self.head[key][0])}", "keep one of the two lines")

    def _stated(self, key: str, column: _Column | None = None, *, ask: str = "") -> Any:
        """What is stated by the caller, or else by the name of a column and the head, which must not differ.

        None where nothing is stated, or after a question; with `ask` that is the question, at the column.
        """
        given, advice = getattr(self.stated, "azimuth_convention" if key == "azimuth" else key), _ADVICE[key]
        said = [(column.unit, column.span)] if column is not None and column.unit and key != "azimuth" else []
        said += [self.head[key]] if key in self.head else []
        if given is not None:
            self.remarks += [one for text, _ in said for one in instead(key, given, text) if one not in self.remarks]
            return meaning_of(key, given)
        for text, span in said:
            if meaning_of(key, text) is None:
                self._bad(span, f"{quoted(text)} is no {_WHAT[key]} that is read", advice)
            elif meaning_of(key, text) != meaning_of(key, said[0][0]):
                owner = f" of the column {column.name}" if column is not None else ""
                self._bad(span, f"{quoted(text)} beside {quoted(said[0][0])}{owner}", advice)
        if ask and not said and column is not None:
            self._bad(column.span, with_texts(ask, self.texts.values()), advice)
        return meaning_of(key, said[0][0]) if said else None

    def points(self) -> dict[str, Any]:
        """Return the contents of the file, or raise all its problems."""
        columns = self._columns()
        of = {one.slot: one for one in columns}
        angles = {slot: self._angle(of[slot]) for slot in ("zenith", "azimuth") if slot in of}
        sun_zenith, sun_azimuth = self._sun("sun_zenith_deg", 180.0), self._sun("sun_azimuth_deg", 360.0)
        ask = f"nothing says from where the azimuths {quoted(of['azimuth'].name)} count" if "azimuth" in of else ""
        convention = self._stated("azimuth", of.get("azimuth"), ask=ask and f"{ask} and which way")
        light = [one for one in columns if one.role == RADIANCE]
        factor = self._stated("radiance_unit")
        if factor is None and not self.report.has_errors:
            self.remarks.append("no unit of radiance is stated, so the light is relative (--radiance-unit says one)")
        factor = factor or 0.0
        for key in ("angle_unit", "wavelength_unit"):  # which a column may not need
            self._stated(key)
        if not {*_NEEDED} <= {*of}:
            self._close()
        zenith, azimuth = angles["zenith"], angles["azimuth"]
        if convention is not None and convention.is_from_sun and sun_azimuth is None:
            self._bad(of["azimuth"].span, "azimuths count from the sun, but nothing says where it is", _SUN_LINE)
        elif convention is not None:
            azimuth = to_enu_azimuth_deg(azimuth, convention, sun_azimuth)
        azimuth = np.where(np.isnan(azimuth) & (zenith == 0.0), 0.0, azimuth)  # overhead all azimuths are one direction
        reach = np.abs(zenith[np.isfinite(zenith)])
        if np.any(reach > 90.0) and reach.min() >= 90.0:
            message = "no direction is above the horizon; is it where light goes to?"
            self._bad(of["zenith"].span, message, SAY_COMES_FROM)
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
            "remarks": (*quote(self.texts.values()), *self.remarks),
            "convention": convention,
        }

    def _close(self) -> None:
        self.report.problems.sort(key=lambda problem: (problem.line, problem.column))
        self.report.close()

    def _role(self, name: str) -> tuple[str, str, float | None] | None:
        """What a column is, the unit and the wavelength of its name [nm]; None where it is not used."""
        stated = {getattr(self.stated, role): role for role in COORDINATES if getattr(self.stated, role) is not None}
        role, unit = NAMES.get(name.lower(), ("", ""))
        taken = {*map(quantity_of, stated.values())}
        if name in stated:
            return stated[name], unit, None
        match = AT_WAVELENGTH.fullmatch(name)
        is_light = name == self.stated.variable if self.stated.variable else bool(match) or name.lower() == RADIANCE
        if is_light:
            return RADIANCE, "", float(match[1]) if match else None
        return None if not role or quantity_of(role) in taken else (role, unit, None)

    def _names_columns(self, line: str) -> bool:
        """Whether a row names all columns that a table needs."""
        names = split_row(_without_sign(line), delimiter_of(line, DELIMITERS))
        roles = {found[0] for found in map(self._role, names) if found}
        return {"azimuth", RADIANCE} <= roles and not roles.isdisjoint(("zenith", "elevation"))

    def _columns(self) -> list[_Column]:
        """The columns with their numbers; problems are reported."""
        if not self.rows:
            advice = "write names of columns, and a row for each direction"
            self.report.add("E654", "the file has no rows", advice=advice)
            self._close()
        number, line = self.rows.pop(0)
        names = split_row(_without_sign(line), self.delimiter)
        whole = Span(number, 1, line, len(line.rstrip()))
        columns: dict[tuple[str, float | None], _Column] = {}
        unused = []
        for index, text in enumerate(names):
            found = self._role(text)
            if found is None:
                unused += [text] if text else []
                continue
            span = cell_span(number, line, index, self.delimiter)
            one = _Column(*found, text, index, span, np.full(len(self.rows), np.nan))
            first = columns.setdefault((one.slot, one.wavelength_nm), one)
            if first is not one:
                message = f"columns {first.index + 1} and {index + 1} are both {one.slot}"
                self._bad(span, message, f"leave one of them out, or {say_coordinate(one.slot)}")
            elif text.endswith(".1") and text[:-2] in names:
                message = f"{quoted(text)} beside {quoted(text[:-2])}: a second column of that name, as pandas has it?"
                self._bad(span, message, f"leave one of them out, or write {text}0 for this wavelength")
        shown = ", ".join(quoted(text) for text in names[:12])
        stated = {role: getattr(self.stated, role) for role in (*COORDINATES, "variable")}
        for name in filter(None, stated.values()):
            if name not in names:
                self._bad(whole, f"there is no column {quoted(name)} among {shown}", "name a column of the file")
        missing = [slot for slot in _NEEDED if slot not in {slot for slot, _ in columns}]
        for slot in missing if len(names) > 1 else missing[:1]:
            what, advice = _NEEDED[slot]
            free = [text for text in names if self._role(text) is None]
            advice = f"{advice}, or {say_coordinate(slot, free)}"
            if len(names) == 1:
                advice = "write # before lines above the names, and commas, semicolons or tabs between columns"
            self._bad(whole, with_texts(f"there is no column of {what} among {shown}", self.texts.values()), advice)
        self.remarks += unused_note({"columns": unused})
        if not self.rows:
            self.report.add("E654", "the file has no row of numbers", advice="write a row for each direction")
            self._close()
        self._read_rows(list(columns.values()), len(names))
        return list(columns.values())

    def _read_rows(self, columns: list[_Column], n_names: int) -> None:
        width = max((one.index for one in columns), default=0) + 1
        decimal, is_asked = self._stated("decimal") or "", False
        for k, (number, line) in enumerate(self.rows):
            cells = split_row(line, self.delimiter)
            if len(cells) < width or any(cells[n_names:]):
                advice = f"write {DELIMITERS[self.delimiter]} between columns alone, and a name for each column"
                message = f"a row of {len(cells)} columns under {n_names} names"
                self._bad(Span(number, 1, line, len(line)), message, advice, "E652")
                continue
            for one in columns:
                text = cells[one.index]
                try:
                    one.values[k] = _number(text, decimal)
                except BadValueError as problem:
                    span = cell_span(number, line, one.index, self.delimiter)
                    self._bad(span, problem.message, problem.advice, "E652")
                if decimal == "" and self.delimiter != "," and not is_asked and _GROUPED.fullmatch(text):
                    message = f"{quoted(text)} may be {text.replace('.', '')}, with a separator of thousands"
                    advice = f"{_DECIMAL_LINE.format('point')}; else write {text.replace('.', '')}"
                    self._bad(cell_span(number, line, one.index, self.delimiter), message, advice, "E652")
                    is_asked = True
            if self.report.is_full:
                break

    def _refuse(self, column: _Column, is_bad: np.ndarray, allowed: str) -> None:
        """Report numbers of a column outside their range."""
        for k in np.flatnonzero(is_bad)[:MAX_PER_VALUE]:
            number, line = self.rows[k]
            text = quoted(split_row(line, self.delimiter)[column.index])
            message = f"{text} is no {column.role}{' angle' * (column.slot == 'zenith')}"
            span = cell_span(number, line, column.index, self.delimiter)
            self._bad(span, message, f"{allowed}; nothing, nan or -999 is a gap", "E653")

    def _ask_of_gaps(self, light: list[_Column], wavelength: np.ndarray | None) -> None:
        """Ask once whether the largest radiances of a column, at a wavelength, are gaps."""
        nm = np.zeros(len(light) * len(self.rows)) if wavelength is None else wavelength
        for one, own_nm in zip(light, np.split(nm, len(light)), strict=True):
            for k in by_wavelength(own_nm):
                if doubt := doubt_of_gaps([one.values[k]]):
                    number, line = self.rows[int(k[np.nanargmax(one.values[k])])]
                    self._bad(cell_span(number, line, one.index, self.delimiter), *doubt, "E653")
                    return

    def _angle(self, column: _Column) -> np.ndarray:
        """Zenith angles, or azimuths as they count in the file. [deg]"""
        ask = f"nothing says whether {quoted(column.name)} is in degrees or radians"
        scale, is_azimuth = self._stated("angle_unit", column, ask=ask) or np.nan, column.slot == "azimuth"
        if scale == 1.0 and self.stated.angle_unit is None and may_be_radians(column.values, is_azimuth=is_azimuth):
            message = f"angles up to {np.nanmax(column.values):g} degrees; are they radians?"
            self._bad(column.span, message, _ADVICE["angle_unit"])
        angle = np.round(column.values * scale, _DIGITS)
        low, high = (-360, 360) if is_azimuth else (-90, 180)
        self._refuse(column, (angle < low) | (angle > high), f"write {low} to {high} degrees")
        return 90.0 - angle if column.role == "elevation" else angle

    def _sun(self, name: str, high: float) -> float | None:
        """An angle of the sun from a caller or the head. [deg]"""
        given, otherwise = self.sun[name]
        if given is not None or name not in self.head:
            self.remarks += instead(name, given, self.head[name][0]) if name in self.head else []
            return otherwise if given is None else given
        text, span = self.head[name]
        match = _MEASURE.fullmatch(text)
        value = float(match[1]) * ANGLE_DEGREES.get(plain_unit(match[2] or "deg"), np.nan) if match else np.nan
        words = ""
        if match and np.isnan(value):  # 225 clockwise from north
            value, words = float(match[1]), f"{match[2]} "
        words += match[3] if match else ""
        convention = convention_of(words) if name == "sun_azimuth_deg" else None
        is_right = convention is not None and not convention.is_from_sun if name == "sun_azimuth_deg" else not words
        if not is_right or not abs(value) <= high:
            advice = _SUN_LINE if name == "sun_azimuth_deg" else "write '# sun zenith: 40 deg', 0 to 180 degrees"
            self._bad(span, f"{quoted(text)} does not say where the sun is", advice)
            return 0.0
        value = round(value, _DIGITS)
        self.sun_of_file[name] = float(to_enu_azimuth_deg(value, convention)) if convention else value
        return self.sun_of_file[name]

    def _wavelengths(self, light: list[_Column], column: _Column | None) -> np.ndarray | None:
        """Wavelength of each radiance, None where the file has none. [nm]"""
        n = light[0].values.size
        unnamed = [one for one in light if one.wavelength_nm is None]
        if "wavelength" in self.head and (column is not None or len(unnamed) < len(light)):
            self._bad(self.head["wavelength"][1], "a wavelength here, and in the columns", "keep one of the two")
        if len(unnamed) < len(light):
            if unnamed or column is not None:
                advice = f"leave one of the two out, or {say_coordinate(RADIANCE)}"
                self._bad((column or unnamed[0]).span, "other columns have wavelengths in their names", advice)
            for one in light:
                if one.wavelength_nm is not None and not LEAST_NM <= one.wavelength_nm <= MOST_NM:
                    advice = f"write {LEAST_NM:g} to {MOST_NM:g} nm, or another name for what is none"
                    self._bad(one.span, f"{quoted(one.name)} has no wavelength in nm", advice)
            unit = self.stated.wavelength_unit or self.head.get("wavelength_unit", ("nm",))[0]
            if LENGTH_NM.get(plain_unit(unit)) != 1.0:
                self._bad(
                    light[0].span, f"wavelengths in names are in nm, and {quoted(unit)} is stated", "leave it out"
                )
            return np.repeat([one.wavelength_nm or 0.0 for one in light], n)
        if column is not None:
            ask = f"nothing says in which unit {quoted(column.name)} is"
            nm = np.round(column.values * (self._stated("wavelength_unit", column, ask=ask) or np.nan), _DIGITS)
            allowed = f"write {LEAST_NM:g} to {MOST_NM:g} nm, or the unit: --wavelength-unit um (wavelength_unit=)"
            self._refuse(column, (nm < LEAST_NM) | (nm > MOST_NM), allowed)
            return nm
        if "wavelength" not in self.head:
            return None
        text, span = self.head["wavelength"]
        match = _MEASURE.fullmatch(text)
        value = np.nan
        if match and not match[3]:
            line = _Column("wavelength", match[2], None, text, 0, span, np.full(n, value))
            ask = f"nothing says in which unit {quoted(text)} is"
            value = float(match[1]) * (self._stated("wavelength_unit", line, ask=ask) or np.nan)
        if not LEAST_NM <= value <= MOST_NM and not any(one.line == span.line for one in self.report.problems):
            self._bad(span, f"{quoted(text)} is no wavelength", "write '# wavelength: 550 nm', or um for micrometres")
        return np.full(n, value)


def _is_of_numbers(line: str) -> bool:
    """Whether a row has numbers and gaps alone."""
    cells = split_row(line, delimiter_of(line, DELIMITERS))
    return not any(cell.lower() not in GAPS and any(map(str.isalpha, cell[:1])) for cell in cells)


def _number(text: str, decimal: str) -> float:
    """The number of a cell, NaN for a gap."""
    if text.lower() in GAPS:
        return np.nan
    plain = text.replace(",", ".") if decimal == "comma" else text
    if decimal == "comma" and "." in text:
        message = f"{quoted(text)} has a point, and decimals have commas"
        raise BadValueError("E652", message, advice="write the number without a separator of thousands")
    if decimal != "comma" and "," in text:
        digits = text.replace(",", "")
        if "." in text or decimal == "point":
            advice = f"write {digits}, without a separator of thousands"
        elif _GROUPED.fullmatch(text.replace(",", ".")):
            advice = f"write {digits}, or if it is {text.replace(',', '.')}, {_DECIMAL_LINE.format('comma')}"
        else:
            advice = _DECIMAL_LINE.format("comma")
        raise BadValueError("E652", f"{quoted(text)} has a comma", advice=advice)
    try:
        value = parse_real(plain)
    except BadValueError:
        message = f"{quoted(text)} is not a number"
        raise BadValueError("E652", message, advice="write a number, or nothing for a gap") from None
    if abs(value) > MAX_RADIANCE:
        message = f"{quoted(text)} is beyond all ranges"
        raise BadValueError("E652", message, advice="write a smaller number, or nothing for a gap")
    return np.nan if value in GAP_NUMBERS else value
