"""Hourly weather files: EPW, TMY2 and TMY3. When each hour began, and its irradiances.

In all three files the hour label, 1 to 24 in local standard time, is the END of the 60 minutes of the irradiances. Some
libraries keep this end for TMY3, and subtract an hour for EPW and TMY2. Here an hour is always the interval
[start, start + 1 h) in UTC.
"""

from __future__ import annotations

import calendar
import contextlib
import math
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputFileError, InputWarning, Span
from aomc_sky.formats.report import BadValueError, Report
from aomc_sky.formats.text_file import (
    cell_span,
    read_bytes,
    refuse,
    split_lines,
    split_row,
    table_of_program,
)

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z", re.ASCII)

_DATE = re.compile(r"(\d{1,2})/(\d{1,2})/(\d{4})\Z", re.ASCII)
_TIME = re.compile(r"(\d{1,2}):00\Z", re.ASCII)
_N_EPW_HEAD = 8
_EPW_FIELDS = (0, 1, 2, 3, 13, 14, 15)
_EPW_MINUTE = 4
_EPW_PRESSURE = 9
_N_LOCATION = 10
_COMMAS, _POINTS = "are its decimals written with commas?", "write decimal points"
_TMY2_COLUMNS = ((1, 3), (3, 5), (5, 7), (7, 9), (17, 21), (23, 27), (29, 33))
"""From and to, counted from 0: year, month, day, hour, GHI, DNI, DHI."""
HOUR = np.timedelta64(3600, "s")
MAX_IRRADIANCE = 2000.0
"""Above the sun's irradiance outside the atmosphere, and above any cloud edge. [W m-2]"""
OFFSET = -5.0
"""Irradiances from here to 0 are those of an instrument's offset at night, and count as 0. [W m-2]"""
_MAX_BYTES = 64 * 2**20
_ZONE_H = 3.0  #: Most that the zone differs from the sun's time, on land [h]
_NAMES = ("year", "month", "day", "hour", "GHI", "DNI", "DHI")
_EXPECTED = ("a year", "a month", "a day", "a whole hour", *["an irradiance"] * 3)
_FIRST_IRRADIANCE = 4
_MISSING_FROM = 9999.0
_MISSING_TMY3 = -9900.0


_SAY_PARTS = ("a year of 1800 to 2200", "a month of 1 to 12", "a day of that month", "a whole hour of 1 to 24")
_SAY_MISSING = "write 9999 (-9900 in TMY3) for a missing value"
_SAY_UNIT = "write means of the hour in W m-2 (3.6 kJ m-2 in an hour are 1 W m-2), or 9999 for a missing value"
_SAY_HOURS = "hours are 1 to 24, the ends of their 60 minutes: add 1 to all hours of a file of 0 to 23"
_HEAD_LINES = "an EPW file has eight lines from LOCATION to DATA PERIODS, then its hours"
_MEANS = "write means of whole hours"
_SAY_TIMES = "times are 01:00 to 24:00, the ends of their 60 minutes: add an hour to all of them"


class _HourZeroError(BadValueError):
    """A row of hour 0, which tells that all hours of the file count otherwise."""


@dataclass(frozen=True, kw_only=True, slots=True)
class WeatherTable:
    """The contents of a weather file that a sky needs."""

    path: str
    station: str  #: Name of the station as the file has it
    #: Position, north and east positive. [deg, -90 to 90 and -180 to 180]
    latitude_deg: float
    longitude_deg: float
    line: np.ndarray  #: int64 (n_row,), where each row stood. [1-based]
    start: np.ndarray  #: datetime64[s] (n_row,), in UTC; the hour is [start, start + 1 h)
    #: float64 (n_row,): global horizontal, direct normal and diffuse horizontal irradiance, means over the hour;
    #: NaN where missing. [W m-2, 0 to 2000]
    ghi: np.ndarray
    dni: np.ndarray
    dhi: np.ndarray

    def irradiances(self, index: int) -> dict[str, float]:
        """Those of ghi, dni and dhi that a row has. [0-based; W m-2]"""
        values = {"ghi": self.ghi, "dni": self.dni, "dhi": self.dhi}
        return {name: float(array[index]) for name, array in values.items() if not np.isnan(array[index])}

    @property
    def midpoint(self) -> np.ndarray:
        """Middle of each hour in UTC, datetime64[s]: the sun's position there counts for the hour."""
        return self.start + HOUR // 2


def read_weather(path: str | Path, kind: str, *, row: int | None = None) -> WeatherTable:
    """Read a weather file of kind epw, tmy2 or tmy3, rows in file order. Cost: about 0.2 s for a year of hours.

    With a `row` [0-based] it alone must be right: others that are not have no time and no irradiances.
    """
    lines = _lines(path)
    layout = _HEADS[kind](lines, path)
    line, values = _rows(lines, layout, path, row)
    is_right = np.isfinite(values[:_FIRST_IRRADIANCE]).all(axis=0)
    year, month, day, hour = np.where(is_right, values[:4], [[1970], [1], [1], [1]]).astype(np.int64)
    dates = (year - 1970).astype("M8[Y]").astype("M8[M]") + (month - 1)
    local = (dates.astype("M8[D]") + (day - 1)).astype("M8[s]") + (hour - 1) * HOUR
    latitude, longitude, offset = layout.position
    values += 0.0  # some files write -0.00 at night
    start = np.where(is_right, local - np.timedelta64(round(offset * 3600), "s"), np.datetime64("NaT"))
    for array in (line, start, values):
        array.flags.writeable = False
    return WeatherTable(
        path=str(path),
        station=layout.station,
        latitude_deg=latitude,
        longitude_deg=longitude,
        line=line,
        start=start,
        ghi=values[4],
        dni=values[5],
        dhi=values[6],
    )


def _lines(path: str | Path) -> list[str]:
    """Lines of the text: UTF-8 with or without its mark, else Latin-1, in which old files have their stations."""
    data = read_bytes(path, most_bytes=_MAX_BYTES)
    with contextlib.suppress(UnicodeDecodeError):
        return [line.removesuffix("\r") for line in data.decode().removesuffix("\n").split("\n")] if data else []
    return split_lines(data)


def _rows(lines: list[str], layout: Layout, path: str | Path, one_row: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Lines and values (7, n_row) of all rows; InputFileError with all problems, or those of `one_row`."""
    report = Report(path=str(path))
    texts = [(number, text) for number, text in enumerate(lines, 1) if number > layout.first_row and text.strip()]
    values = np.full((len(texts), len(_NAMES)), np.nan)
    for k, (number, text) in enumerate(texts):
        try:
            _read_row(text, layout, values[k])
        except BadValueError as problem:
            values[k, _FIRST_IRRADIANCE:] = np.nan
            if one_row in (None, k) or isinstance(problem, _HourZeroError):
                report.bad_value(Span(number, 1, text), problem)
        if report.is_full:
            break
    if texts and layout.first_hour == values[0, 3] == 0.0:
        number, text = texts[0]
        message = "the first row is of 00:00: do the hours begin at their times?"
        report.at(Span(number, 1, text, len(text)), "E602", message, advice=_SAY_TIMES)
    if not texts:
        report.at(
            Span(max(len(lines), 1), 1, ""),
            "E604",
            "the file ends before the first hour",
            advice="add a row for each hour",
        )
    is_again = np.all(values[1:, :_FIRST_IRRADIANCE] == values[:-1, :_FIRST_IRRADIANCE], axis=1)
    again = [k for k in np.flatnonzero(is_again).tolist() if one_row in (None, k, k + 1)]
    if again and not report.has_errors:
        number, text = texts[again[0] + 1]
        message = f"hour {values[again[0], 3]:g} comes twice in a row; hours are read, 1 row each"
        report.at(Span(number, 1, text, len(text)), "E602", message, advice=_MEANS)
    report.close()
    return np.array([number for number, _ in texts], dtype=np.int64), values.T.copy()


def _read_row(text: str, layout: Layout, row: np.ndarray) -> None:
    """Put the seven values of a row into `row`; missing irradiances stay NaN."""

    def bad(
        k: int, code: str, message: str, advice: str = "", kind: type[BadValueError] = BadValueError
    ) -> BadValueError:
        span = layout.place(text, k)
        return kind(code, f"{_NAMES[k]}: {message}", advice=advice, offset=span.column - 1, width=span.width)

    for k, field in enumerate(layout.cut(text)):
        piece, is_irradiance = field.strip(), k >= _FIRST_IRRADIANCE
        value = float(piece) if NUMBER.match(piece) else math.nan
        if is_irradiance and (not piece or value == _MISSING_TMY3 or value >= _MISSING_FROM):
            continue
        if math.isnan(value):
            raise bad(k, "E602", f"{piece[:40]!r} is not {_EXPECTED[k]}", _advice(k))
        if is_irradiance and not OFFSET <= value <= MAX_IRRADIANCE:
            advice = _SAY_MISSING if value < 0 else _SAY_UNIT
            raise bad(k, "E603", f"{piece} is outside 0 to {MAX_IRRADIANCE:g} W m-2", advice)
        row[k] = max(value, 0.0) if is_irradiance else value
    wrong = _wrong_date(row[:_FIRST_IRRADIANCE].tolist(), layout.first_hour)
    if wrong is not None:
        is_zero = _NAMES[wrong] == "hour" and row[wrong] == 0.0
        how = (_SAY_HOURS, _HourZeroError) if is_zero else (_advice(wrong), BadValueError)
        problem = bad(wrong, "E602", f"there is no {_NAMES[wrong]} {row[wrong]:g} here", *how)
        row[:] = np.nan
        raise problem


def _advice(k: int) -> str:
    """What to write for a value of a row; a date of TMY3 is one text."""
    date = ", a date of TMY3 as 06/21/2003" * (k < _FIRST_IRRADIANCE - 1)
    return _SAY_MISSING if k >= _FIRST_IRRADIANCE else f"write {_SAY_PARTS[k]}{date}"


def _wrong_date(row: list[float], first_hour: int) -> int | None:
    """Index of the impossible part of a date, None for a date that exists."""
    year, month, day, hour = row
    for k, value, low, high in ((0, year, 1800, 2200), (1, month, 1, 12), (3, hour, first_hour, 24)):
        if not (low <= value <= high and value == int(value)):
            return k
    n_days = calendar.monthrange(int(year), int(month))[1]
    return None if 1 <= day <= n_days and day == int(day) else 2


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """Contents of the head of a file, and how its rows are cut."""

    station: str
    position: tuple[float, float, float]  #: Latitude and longitude [deg], and local standard time minus UTC [h]
    first_row: int
    #: Texts of year, month, day, hour, GHI, DNI and DHI of a row; `BadValueError` for a bad row.
    cut: Callable[[str], list[str]]
    place: Callable[[str, int], Span]  #: Where one of these texts is in the row.
    first_hour: int = 1  #: Lowest label of an hour


def _no_head(path: str | Path, number: int, text: str, message: str, advice: str = "") -> InputFileError:
    return refuse(path, message, code="E601", advice=advice, span=Span(number, 1, text))


def _other_kind(lines: list[str], kind: str, advice: str) -> str:
    """The advice for a file that is none of its kind, or what it seems to be and what to write."""
    what, say = table_of_program(lines) or (kind, "")
    return advice if kind in what else f"this seems to be {what}: {say}"


def _position(pieces: Sequence[str], text: str, path: str | Path) -> tuple[float, float, float]:
    """Latitude, longitude and time zone of a head line; a zone that is not that of the longitude is warned of."""
    found: list[float] = []
    limits = {"latitude": 90.0, "longitude": 180.0, "time zone": 14.0}
    for (name, limit), piece in zip(limits.items(), map(str.strip, pieces), strict=True):
        span = Span(1, max(text.find(piece), 0) + 1, text, max(len(piece), 1))
        if not NUMBER.match(piece) or abs(float(piece)) > limit:
            message = f"{piece[:40]!r} is not a number from -{limit:g} to {limit:g}"
            advice = "write hours from UTC" if name == "time zone" else "write degrees with a decimal point"
            advice = f"{advice}, {'north' if name == 'latitude' else 'east'} positive"
            raise refuse(path, message, advice=advice, code="E601", name=name, span=span)
        found.append(float(piece))
    latitude, longitude, zone = found
    away = abs((longitude / 15.0 - zone + 12.0) % 24.0 - 12.0)
    if away > _ZONE_H:
        message = (
            f"{zone:g} hours from UTC at longitude {longitude:g}, where the sun is {away:.1f} hours from that time"
        )
        advice = "longitude is east positive, the zone too"
        problem = span.problem(str(path), "E601", message, field="time zone", advice=advice, is_error=False)
        warnings.warn(problem.render(), InputWarning, stacklevel=5)
    return latitude, longitude, zone


def _cut_at_commas(text: str, n_needed: int, most: int, owner: str, kind: str) -> list[str]:
    """The first fields of a row; a decimal comma makes more of them than there are columns."""
    fields = split_row(text.rstrip(", \t"))
    if len(fields) > most:
        message = f"the row has {len(fields)} fields, {owner}; {_COMMAS}"
        raise BadValueError("E602", message, advice=_POINTS)
    if len(fields) < n_needed:
        raise _too_short(kind)
    return fields


def _too_short(kind: str) -> BadValueError:
    message = f"the row is shorter than a row of {kind} with DNI and DHI"
    return BadValueError("E602", message, advice="write all columns of the row, 9999 for what is not known")


def epw_head(lines: list[str], path: str | Path) -> Layout:
    """The head of an EPW file: eight lines from LOCATION to DATA PERIODS."""
    first = lines[0] if lines else ""
    pieces = split_row(first.rstrip(", "))
    layout = "LOCATION,city,state,country,source,WMO,latitude,longitude,time zone,elevation"
    if not pieces or pieces[0].upper() != "LOCATION":
        advice = f"an EPW file begins with {layout}"
        advice = _other_kind(lines, "EPW", advice)
        raise _no_head(path, 1, first, "this is not the header of an EPW file", advice)
    if len(pieces) != _N_LOCATION:
        message = f"LOCATION has {len(pieces)} entries, {_N_LOCATION} are needed"
        raise _no_head(path, 1, first, message, f"write {layout}, nothing between two commas for what is not known")
    position = _position(pieces[6:9], first, path)
    periods = lines[_N_EPW_HEAD - 1] if len(lines) >= _N_EPW_HEAD else ""
    parts = split_row(periods) or [""]
    if parts[0].upper() != "DATA PERIODS":
        raise _no_head(path, _N_EPW_HEAD, periods, "line 8 is not the DATA PERIODS line", _HEAD_LINES)
    if len(parts) > 2 and parts[2] != "1":
        raise _no_head(
            path, _N_EPW_HEAD, periods, f"{parts[2]} records per hour; hours are read, 1 record each", _MEANS
        )
    for number, text in enumerate(lines[_N_EPW_HEAD:], _N_EPW_HEAD + 1):
        minute = text.split(",", _EPW_MINUTE + 1)[_EPW_MINUTE:][:1]
        if minute and NUMBER.match(minute[0].strip()) and float(minute[0]) not in (0.0, 60.0):
            span = cell_span(number, text, _EPW_MINUTE)
            message = (
                f"minute {minute[0].strip()}: rows of less than an hour; hours are read, 1 row each, minute 0 or 60"
            )
            raise refuse(path, message, code="E602", advice=_MEANS, span=span)
    return Layout(station=pieces[1], position=position, first_row=_N_EPW_HEAD, cut=_cut_epw, place=_place_epw)


def _cut_epw(text: str) -> list[str]:
    """Also finds a decimal comma or a missing field before the irradiances, by the air pressure, which it moves."""
    fields = _cut_at_commas(text, 16, 35, "a row of EPW at most 35", "EPW")
    pressure, *others = fields[_EPW_PRESSURE:13]
    message = ""
    if NUMBER.match(pressure) and 0 < float(pressure) < 1000:
        message = f"the air pressure in field {_EPW_PRESSURE + 1} is {pressure} Pa"
    for k, piece in enumerate(others, _EPW_PRESSURE + 2):
        if not message and NUMBER.match(piece) and 30_000 <= float(piece) <= 120_000:
            message = f"field {k} holds {piece}, which can only be an air pressure"
    if message:
        raise BadValueError("E602", f"{message}; {_COMMAS}", advice=_POINTS)
    if NUMBER.match(before := fields[_EPW_PRESSURE - 1]) and 30_000 <= float(before) <= 120_000:
        message = (
            f"field {_EPW_PRESSURE} holds {before}, which can only be an air pressure: a field before it is missing"
        )
        raise BadValueError("E602", message, advice="write nothing between two commas for what is not known")
    return [fields[k] for k in _EPW_FIELDS]


def _place_epw(text: str, k: int) -> Span:
    return cell_span(1, text, _EPW_FIELDS[k])


def tmy3_head(lines: list[str], path: str | Path) -> Layout:
    """The head of a TMY3 file: the station, and the names of the columns.

    Some programs write the end of a day as 00:00 of the next one, not as 24:00; hour 0 is therefore allowed.
    """
    first = lines[0] if lines else ""
    names = split_row(lines[1]) if len(lines) > 1 else []
    needed = ("Date (MM/DD/YYYY)", "Time (HH:MM)", "GHI (W/m^2)", "DNI (W/m^2)", "DHI (W/m^2)")
    if twice := [name for name in needed if names.count(name) > 1]:
        raise _no_head(path, 2, lines[1], f"column {twice[0]!r} comes twice", "keep the one that is meant")
    advice = "a TMY3 file has its station in line 1 and the names of its columns in line 2"
    if absent := [name for name in needed if name not in names]:
        advice = _other_kind(lines, "TMY3", advice)
        raise _no_head(path, 2, lines[1] if len(lines) > 1 else first, f"there is no column {absent[0]!r}", advice)
    pieces = split_row(first)
    if len(pieces) < 6:
        raise _no_head(path, 1, first, "line 1 has no latitude and longitude", advice)
    position = _position((pieces[4], pieces[5], pieces[3]), first, path)
    date, time, *irradiance = (names.index(name) for name in needed)
    places = [*[date] * 3, time, *irradiance]

    def cut(text: str) -> list[str]:
        row = _cut_at_commas(text, max(places) + 1, len(names), f"line 2 names {len(names)}", "TMY3")
        day, hour = _DATE.match(row[date]), _TIME.match(row[time])
        parts = [day[3], day[1], day[2]] if day else [row[date]] * 3
        return [*parts, hour[1] if hour else row[time], *(row[k] for k in irradiance)]

    def place(text: str, k: int) -> Span:
        return cell_span(1, text, places[k])

    return Layout(station=pieces[1], position=position, first_row=2, first_hour=0, cut=cut, place=place)


def tmy2_head(lines: list[str], path: str | Path) -> Layout:
    """The head of a TMY2 file: one line of fixed columns."""
    first = lines[0] if lines else ""
    north, east = first[37:38].upper(), first[45:46].upper()
    parts = [first[a:b].strip() for a, b in ((39, 41), (42, 44), (47, 50), (51, 53))]
    if north not in ("N", "S") or east not in ("E", "W") or not all(part.isdecimal() for part in parts):
        advice = "a TMY2 file has N or S in column 38 and E or W in column 46 of its first line"
        advice = _other_kind(lines, "TMY2", advice)
        raise _no_head(path, 1, first, "this is not the header of a TMY2 file", advice)
    latitude, longitude = (int(parts[k]) + int(parts[k + 1]) / 60 for k in (0, 2))
    texts = (repr(-latitude if north == "S" else latitude), repr(-longitude if east == "W" else longitude))
    position = _position((*texts, first[33:36]), first, path)
    return Layout(station=first[7:29].strip(), position=position, first_row=1, cut=_cut_tmy2, place=_place_tmy2)


def _cut_tmy2(text: str) -> list[str]:
    if len(text) < _TMY2_COLUMNS[-1][1]:
        raise _too_short("TMY2")
    year, *others = (text[start:end] for start, end in _TMY2_COLUMNS)
    return [f"19{year}" if year.isdecimal() else year, *others]


def _place_tmy2(text: str, k: int) -> Span:
    start, end = _TMY2_COLUMNS[k]
    return Span(1, start + 1, text, max(len(text[start:end].strip()), 1))


_HEADS: dict[str, Callable[[list[str], str | Path], Layout]] = {"epw": epw_head, "tmy2": tmy2_head, "tmy3": tmy3_head}
