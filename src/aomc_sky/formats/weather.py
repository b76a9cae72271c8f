"""Hourly weather files: EPW, TMY2 and TMY3. When each hour began, and its irradiances.

In all three files the hour label, 1 to 24 in local standard time, is the END of the 60 minutes of the irradiances. Some
libraries keep this end for TMY3, and subtract an hour for EPW and TMY2. Here an hour is always the interval
[start, start + 1 h) in UTC.
"""

from __future__ import annotations

import calendar
import contextlib
import csv
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputFileError, Span
from aomc_sky.formats.report import BadValueError, Report
from aomc_sky.formats.text_file import read_bytes, refuse, split_lines

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z", re.ASCII)

_DATE = re.compile(r"(\d{1,2})/(\d{1,2})/(\d{4})\Z", re.ASCII)
_TIME = re.compile(r"(\d{1,2}):00\Z", re.ASCII)
_N_EPW_HEAD = 8
_EPW_FIELDS = (0, 1, 2, 3, 13, 14, 15)
_EPW_PRESSURE = 9
_COMMAS, _POINTS = "are its decimals written with commas?", "write decimal points"
_TMY2_COLUMNS = ((1, 3), (3, 5), (5, 7), (7, 9), (17, 21), (23, 27), (29, 33))
"""From and to, counted from 0: year, month, day, hour, GHI, DNI, DHI."""
HOUR = np.timedelta64(3600, "s")
MAX_IRRADIANCE = 2000.0
"""Above the sun's irradiance outside the atmosphere, and above any cloud edge. [W m-2]"""
_MAX_BYTES = 64 * 2**20
_NAMES = ("year", "month", "day", "hour", "GHI", "DNI", "DHI")
_EXPECTED = ("a year", "a month", "a day", "a whole hour", *["an irradiance"] * 3)
_FIRST_IRRADIANCE = 4
_MISSING_FROM = 9999.0
_MISSING_TMY3 = -9900.0


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


def read_weather(path: str | Path, kind: str) -> WeatherTable:
    """Read a weather file of kind epw, tmy2 or tmy3, rows in file order. Cost: about 0.2 s for a year of hours."""
    lines = _lines(path)
    layout = _HEADS[kind](lines, path)
    line, values = _rows(lines, layout, path)
    year, month, day, hour = values[:4].astype(np.int64)
    dates = (year - 1970).astype("M8[Y]").astype("M8[M]") + (month - 1)
    local = (dates.astype("M8[D]") + (day - 1)).astype("M8[s]") + (hour - 1) * HOUR
    latitude, longitude, offset = layout.position
    values += 0.0  # some files write -0.00 at night
    start = local - np.timedelta64(round(offset * 3600), "s")
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


def _rows(lines: list[str], layout: Layout, path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Lines and values (7, n_row) of all rows; InputFileError with all problems."""
    report = Report(path=str(path))
    numbers: list[int] = []
    values: list[list[float]] = []
    for number, text in enumerate(lines[layout.first_row :], start=layout.first_row + 1):
        if text.strip():
            try:
                values.append(_row(text, layout))
                numbers.append(number)
            except BadValueError as problem:
                report.bad_value(Span(number, 1, text), problem)
        if report.is_full:
            break
    if not values and not report.has_errors:
        report.at(Span(max(len(lines), 1), 1, ""), "E604", "the file ends before the first hour")
    report.close()
    return np.array(numbers, dtype=np.int64), np.array(values, dtype=np.float64).reshape(-1, len(_NAMES)).T


def _row(text: str, layout: Layout) -> list[float]:
    """The seven values of a row, missing irradiances NaN."""
    row: list[float] = []
    pieces = layout.cut(text)

    def bad(k: int, code: str, message: str) -> BadValueError:
        offset, field = pieces[k]
        return BadValueError(code, f"{_NAMES[k]}: {message}", offset=offset, width=len(field.strip()))

    for k, (_, field) in enumerate(pieces):
        piece, is_irradiance = field.strip(), k >= _FIRST_IRRADIANCE
        value = float(piece) if NUMBER.match(piece) else math.nan
        if is_irradiance and (not piece or value == _MISSING_TMY3 or value >= _MISSING_FROM):
            value = math.nan
        elif math.isnan(value):
            raise bad(k, "E602", f"{piece[:40]!r} is not {_EXPECTED[k]}")
        elif is_irradiance and not 0 <= value <= MAX_IRRADIANCE:
            raise bad(k, "E603", f"{piece} is outside 0 to {MAX_IRRADIANCE:g} W m-2")
        row.append(value)
    wrong = _wrong_date(row, layout.first_hour)
    if wrong is not None:
        raise bad(wrong, "E602", f"there is no {_NAMES[wrong]} {row[wrong]:g} here")
    return row


def _wrong_date(row: list[float], first_hour: int) -> int | None:
    """Index of the impossible part of a date, None for a date that exists."""
    year, month, day, hour = row[:4]
    for k, value, low, high in ((0, year, 1800, 2200), (1, month, 1, 12), (3, hour, first_hour, 24)):
        if not (low <= value <= high and value == int(value)):
            return k
    n_days = calendar.monthrange(int(year), int(month))[1]
    return None if 1 <= day <= n_days and day == int(day) else 2


Pieces = list[tuple[int, str]]
"""Texts of year, month, day, hour, GHI, DNI and DHI, and how many characters stand before each in its row."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Layout:
    """Contents of the head of a file, and the function that cuts its rows (`BadValueError` for a bad row)."""

    station: str
    position: tuple[float, float, float]  #: Latitude and longitude [deg], and local standard time minus UTC [h]
    first_row: int
    cut: Callable[[str], Pieces]
    first_hour: int = 1  #: Lowest label of an hour


def _no_head(path: str | Path, number: int, text: str, message: str, advice: str = "") -> InputFileError:
    return refuse(path, message, code="E601", advice=advice, span=Span(number, 1, text))


def _position(pieces: Sequence[str], text: str, path: str | Path) -> tuple[float, float, float]:
    """Latitude, longitude and time zone of a head line."""
    found: list[float] = []
    limits = {"latitude": 90.0, "longitude": 180.0, "time zone": 14.0}
    for (name, limit), piece in zip(limits.items(), map(str.strip, pieces), strict=True):
        if not NUMBER.match(piece) or abs(float(piece)) > limit:
            span = Span(1, max(text.find(piece), 0) + 1, text, max(len(piece), 1))
            message = f"{piece[:40]!r} is not a number from -{limit:g} to {limit:g}"
            raise refuse(path, message, code="E601", name=name, span=span)
        found.append(float(piece))
    return found[0], found[1], found[2]


def _fields(line: str) -> list[str]:
    """Fields of a head line; a name in quotes may hold a comma."""
    return next(csv.reader([line]), [""]) or [""]


def _cut_at_commas(text: str, n_needed: int, most: int, of_whom: str, kind: str) -> Pieces:
    """The first fields of a row with their offsets; a decimal comma makes more of them than there are columns."""
    n_fields = text.rstrip(", \t").count(",") + 1
    if n_fields > most:
        message = f"the row has {n_fields} fields, {of_whom}; {_COMMAS}"
        raise BadValueError("E602", message, advice=_POINTS)
    pieces, offset = [], 0
    for field in text.split(",", n_needed)[:n_needed]:
        pieces.append((offset, field))
        offset += len(field) + 1
    if len(pieces) < n_needed:
        raise _too_short(kind)
    return pieces


def _too_short(kind: str) -> BadValueError:
    return BadValueError("E602", f"the row is shorter than a row of {kind} with DNI and DHI")


def epw_head(lines: list[str], path: str | Path) -> Layout:
    """The head of an EPW file: eight lines from LOCATION to DATA PERIODS."""
    first = lines[0] if lines else ""
    pieces = _fields(first)
    if pieces[0].strip().upper() != "LOCATION" or len(pieces) < 9:
        advice = "an EPW file begins with LOCATION,city,state,country,source,WMO,latitude,longitude,time zone"
        raise _no_head(path, 1, first, "this is not the header of an EPW file", advice)
    position = _position(pieces[6:9], first, path)
    periods = lines[_N_EPW_HEAD - 1] if len(lines) >= _N_EPW_HEAD else ""
    parts = [part.strip() for part in periods.split(",")]
    if parts[0].upper() != "DATA PERIODS":
        raise _no_head(path, _N_EPW_HEAD, periods, "line 8 is not the DATA PERIODS line")
    if len(parts) > 2 and parts[2] != "1":
        raise _no_head(path, _N_EPW_HEAD, periods, f"{parts[2]} records per hour; hours are read, 1 record each")
    return Layout(station=pieces[1].strip(), position=position, first_row=_N_EPW_HEAD, cut=_cut_epw)


def _cut_epw(text: str) -> Pieces:
    """Also finds a decimal comma before the irradiances, by the air pressure, which it moves by a column."""
    fields = _cut_at_commas(text, 16, 35, "a row of EPW at most 35", "EPW")
    pressure, *others = (field.strip() for _, field in fields[_EPW_PRESSURE:13])
    message = ""
    if NUMBER.match(pressure) and 0 < float(pressure) < 1000:
        message = f"the air pressure in field {_EPW_PRESSURE + 1} is {pressure} Pa"
    for k, piece in enumerate(others, _EPW_PRESSURE + 2):
        if not message and NUMBER.match(piece) and 30_000 <= float(piece) <= 120_000:
            message = f"field {k} holds {piece}, which can only be an air pressure"
    if message:
        raise BadValueError("E602", f"{message}; {_COMMAS}", advice=_POINTS)
    return [fields[k] for k in _EPW_FIELDS]


def tmy3_head(lines: list[str], path: str | Path) -> Layout:
    """The head of a TMY3 file: the station, and the names of the columns.

    Some programs write the end of a day as 00:00 of the next one, not as 24:00; hour 0 is therefore allowed.
    """
    first = lines[0] if lines else ""
    names = [name.strip() for name in lines[1].split(",")] if len(lines) > 1 else []
    needed = ("Date (MM/DD/YYYY)", "Time (HH:MM)", "GHI (W/m^2)", "DNI (W/m^2)", "DHI (W/m^2)")
    advice = "a TMY3 file has its station in line 1 and the names of its columns in line 2"
    if absent := [name for name in needed if name not in names]:
        raise _no_head(path, 2, lines[1] if len(lines) > 1 else first, f"there is no column {absent[0]!r}", advice)
    pieces = _fields(first)
    if len(pieces) < 6:
        raise _no_head(path, 1, first, "line 1 has no latitude and longitude", advice)
    position = _position((pieces[4], pieces[5], pieces[3]), first, path)
    date, time, *irradiance = (names.index(name) for name in needed)

    def cut(text: str) -> Pieces:
        n_needed = max(date, time, *irradiance) + 1
        row = _cut_at_commas(text, n_needed, len(names), f"line 2 names {len(names)}", "TMY3")
        day, hour = _DATE.match(row[date][1].strip()), _TIME.match(row[time][1].strip())
        parts = [day[3], day[1], day[2]] if day else [row[date][1]] * 3
        of_hour = hour[1] if hour else row[time][1]
        return [*((row[date][0], part) for part in parts), (row[time][0], of_hour), *(row[k] for k in irradiance)]

    return Layout(station=pieces[1].strip(), position=position, first_row=2, first_hour=0, cut=cut)


def tmy2_head(lines: list[str], path: str | Path) -> Layout:
    """The head of a TMY2 file: one line of fixed columns."""
    first = lines[0] if lines else ""
    north, east = first[37:38].upper(), first[45:46].upper()
    parts = [first[a:b].strip() for a, b in ((39, 41), (42, 44), (47, 50), (51, 53))]
    if north not in ("N", "S") or east not in ("E", "W") or not all(part.isdecimal() for part in parts):
        advice = "a TMY2 file has N or S in column 38 and E or W in column 46 of its first line"
        raise _no_head(path, 1, first, "this is not the header of a TMY2 file", advice)
    latitude, longitude = (int(parts[k]) + int(parts[k + 1]) / 60 for k in (0, 2))
    texts = (repr(-latitude if north == "S" else latitude), repr(-longitude if east == "W" else longitude))
    position = _position((*texts, first[33:36]), first, path)
    return Layout(station=first[7:29].strip(), position=position, first_row=1, cut=_cut_tmy2)


def _cut_tmy2(text: str) -> Pieces:
    if len(text) < _TMY2_COLUMNS[-1][1]:
        raise _too_short("TMY2")
    (at, year), *others = ((start, text[start:end]) for start, end in _TMY2_COLUMNS)
    return [(at, f"19{year}" if year.isdecimal() else year), *others]


_HEADS: dict[str, Callable[[list[str], str | Path], Layout]] = {"epw": epw_head, "tmy2": tmy2_head, "tmy3": tmy3_head}
