"""Hourly weather files: EPW, TMY2 and TMY3. When each hour began, and its irradiances.

In all three files the hour label, 1 to 24 in local standard time, is the END of the 60 minutes of the irradiances. Some
libraries keep this end for TMY3, and subtract an hour for EPW and TMY2. Here an hour is always the interval
[start, start + 1 h) in UTC.
"""

from __future__ import annotations

import calendar
import math
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputFileError, InputWarning, Span
from aomc_sky.formats.report import BadValueError, Report
from aomc_sky.formats.text_file import cell_span, read_bytes, refuse, split_row

HOUR = np.timedelta64(3600, "s")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z", re.ASCII)
_DATE = re.compile(r"(\d{1,2})/(\d{1,2})/(\d{4})\Z", re.ASCII)
_TIME = re.compile(r"(\d{1,2}):00\Z", re.ASCII)
_TMY3_NAMES = ("Date (MM/DD/YYYY)", "Time (HH:MM)", "GHI (W/m^2)", "DNI (W/m^2)", "DHI (W/m^2)")
_TMY2_COLUMNS = ((1, 3), (3, 5), (5, 7), (7, 9), (17, 21), (23, 27), (29, 33))
"""From and to, counted from 0, of the seven values of a row: year, month, day, hour, GHI, DNI, DHI."""
_LIGHT = 4  #: Index of the first irradiance among them
_MISSING_FROM, _MISSING_TMY3 = 9999.0, -9900.0
_ZONE_H = 3.0  #: Most that the zone differs from the sun's time, on land [h]

_SAY_HEAD = {
    "epw": "an EPW file has eight lines, LOCATION,city,state,country,source,WMO,latitude,longitude,time zone,elevation "
    "to DATA PERIODS, then means of whole hours; write nothing between two commas for what is not known",
    "tmy2": "a TMY2 file has N or S in column 38 and E or W in column 46 of its first line",
    "tmy3": "a TMY3 file has its station in line 1 and the names of its columns in line 2",
}
_SAY_DATE = "write a date that exists, in TMY3 as 06/21/2003"
_SAY_HOUR = "hours are 1 to 24 (01:00 to 24:00), the ends of their 60 minutes: add 1 to all hours of a file of 0 to 23"
_SAY_LIGHT = "write means of the hour in W m-2 (3.6 kJ m-2 in an hour are 1 W m-2), or 9999 (-9900 in TMY3) if missing"
_SAY_ROW = "write all columns of the row, decimals with points, 9999 for what is not known"
_SAY_MEANS = "write means of whole hours"

#: Lowest and highest value, what it is, and what to write. 2000 W m-2 are more than the sun outside the atmosphere and
#: any cloud edge; from -5 to 0 an irradiance is the offset of an instrument at night, and counts as 0.
_VALUES = {
    "year": (1800.0, 2200.0, "a year of 1800 to 2200", _SAY_DATE),
    "month": (1.0, 12.0, "a month of 1 to 12", _SAY_DATE),
    "day": (1.0, 31.0, "a day of that month", _SAY_DATE),
    "hour": (0.0, 24.0, "a whole hour of 1 to 24", _SAY_HOUR),
    **dict.fromkeys(("GHI", "DNI", "DHI"), (-5.0, 2000.0, "an irradiance of 0 to 2000 W m-2", _SAY_LIGHT)),
}


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


@dataclass(frozen=True, kw_only=True, slots=True)
class _Text:
    """The lines of a file, and the kind that it should be."""

    path: str | Path
    kind: str
    lines: list[str]

    def line(self, number: int) -> str:
        """A line, empty behind the end. [1-based]"""
        return self.lines[number - 1] if number <= len(self.lines) else ""

    @property
    def kind_of_head(self) -> str:
        """The kind that the first lines name; empty for TMY2, whose head has no name."""
        return "epw" if self.line(1).upper().startswith("LOCATION,") else "tmy3" * (_TMY3_NAMES[0] in self.line(2))

    def bad_head(self, number: int, message: str) -> InputFileError:
        """The error for a line of the head; the advice is another option where the head is of another kind."""
        kind = self.kind_of_head or self.kind
        advice = (
            _SAY_HEAD[kind] if kind == self.kind else f"the head is of {kind.upper()}: write --weather FILE --row N"
        )
        return refuse(self.path, message, code="E601", advice=advice, span=Span(number, 1, self.line(number)))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Layout:
    """What the head of a file says."""

    station: str
    position: tuple[float, float, float]  #: Latitude and longitude [deg], and local standard time minus UTC [h]
    n_head: int  #: Lines of the head
    places: Sequence[int]  #: Of the seven values among the fields of a row
    n_fields: int  #: Most fields of a row


def read_weather(path: str | Path, kind: str = "", *, row: int | None = None) -> WeatherTable:
    """Read a weather file of kind epw, tmy2 or tmy3, by default that of its head, rows in file order.

    Cost: about 0.2 s for a year of hours.

    With a `row` [0-based] it alone must be right: others that are not have no time and no irradiances.
    """
    data = read_bytes(path, most_bytes=64 * 2**20)
    try:
        text = data.decode()
    except UnicodeDecodeError:  # old files have their stations so
        text = data.decode("latin-1")
    file = _Text(path=path, kind=kind, lines=[line.removesuffix("\r") for line in text.removesuffix("\n").split("\n")])
    file = replace(file, kind=kind or file.kind_of_head or "tmy2")
    layout = _HEADS[file.kind](file)
    line, values = _rows(file, layout, row)
    is_right = np.isfinite(values[:_LIGHT]).all(axis=0)
    year, month, day, hour = np.where(is_right, values[:_LIGHT], [[1970], [1], [1], [1]]).astype(np.int64)
    dates = (year - 1970).astype("M8[Y]").astype("M8[M]") + (month - 1)
    local = (dates.astype("M8[D]") + (day - 1)).astype("M8[s]") + (hour - 1) * HOUR
    latitude, longitude, offset = layout.position
    start = np.where(is_right, local - np.timedelta64(round(offset * 3600), "s"), np.datetime64("NaT"))
    for array in (line, start, values):
        array.flags.writeable = False
    place = {"latitude_deg": latitude, "longitude_deg": longitude}
    ghi, dni, dhi = values[_LIGHT:]
    return WeatherTable(
        path=str(path), station=layout.station, **place, line=line, start=start, ghi=ghi, dni=dni, dhi=dhi
    )


def _rows(file: _Text, layout: _Layout, one_row: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Lines and values (7, n_row) of all rows; InputFileError with all problems, or those of `one_row`."""
    report = Report(path=str(file.path))
    texts = [(number, text) for number, text in enumerate(file.lines, 1) if number > layout.n_head and text.strip()]
    values = np.full((len(texts), len(_VALUES)), np.nan)
    for k, (number, text) in enumerate(texts):
        try:
            _read_row(text, file.kind, layout, values[k])
        except BadValueError as problem:
            values[k, _LIGHT:] = np.nan
            if one_row in (None, k):
                report.bad_value(Span(number, 1, text), problem)
        if values[k, 3] == 0.0 and (k == 0 or file.kind != "tmy3"):  # then all hours of the file count otherwise
            message = "hour: there is no hour 0 here: do the hours begin at their labels?"
            report.at(_place(number, text, file.kind, layout.places[3]), "E602", message, advice=_SAY_HOUR)
        if report.is_full:
            break
    if not texts:
        message, advice = "the file ends before the first hour", "add a row for each hour"
        report.at(Span(len(file.lines), 1, ""), "E604", message, advice=advice)
    is_again = np.all(values[1:, :_LIGHT] == values[:-1, :_LIGHT], axis=1)
    for k in np.flatnonzero(is_again).tolist():
        if one_row in (None, k, k + 1) and not report.has_errors:
            number, text = texts[k + 1]
            message = f"hour {values[k, 3]:g} comes twice in a row; hours are read, 1 row each"
            report.at(Span(number, 1, text, len(text)), "E602", message, advice=_SAY_MEANS)
    report.close()
    return np.array([number for number, _ in texts], dtype=np.int64), values.T.copy()


def _read_row(text: str, kind: str, layout: _Layout, row: np.ndarray) -> None:
    """Put the seven values of a row into `row`, up to the first bad one; missing irradiances stay NaN."""
    for k, (piece, (name, rule)) in enumerate(zip(_cut(text, kind, layout), _VALUES.items(), strict=True)):
        low, high, what, advice = rule
        value = float(piece) if _NUMBER.match(piece) else math.nan
        if k >= _LIGHT and (not piece or value == _MISSING_TMY3 or value >= _MISSING_FROM):
            continue
        if name == "day":
            high = calendar.monthrange(int(row[0]), int(row[1]))[1]
        if not low <= value <= high or (k < _LIGHT and not value.is_integer()):
            code = "E602" if k < _LIGHT or math.isnan(value) else "E603"
            span, message = _place(1, text, kind, layout.places[k]), f"{name}: {piece[:40]!r} is not {what}"
            raise BadValueError(code, message, advice=advice, offset=span.column - 1, width=span.width)
        row[k] = value if k < _LIGHT else max(value, 0.0) + 0.0  # some files write -0.00 at night


def _cut(text: str, kind: str, layout: _Layout) -> list[str]:
    """Texts of the seven values of a row.

    A decimal comma makes more fields than there are columns; it, and a missing field, move the air pressure of EPW.
    """
    if kind == "tmy2":
        fields = [text[start:end].strip() for start, end in _TMY2_COLUMNS if end <= len(text)]
    else:
        fields = split_row(text.rstrip(", \t"))
    least = max(layout.places) + 1
    if not least <= len(fields) <= layout.n_fields:
        is_few, most = len(fields) < least, f"{layout.n_fields} at most; are its decimals written with commas?"
        message = f"the row has {len(fields)} fields, {f'{least} are needed' if is_few else most}"
        raise BadValueError("E602", message, advice=_SAY_ROW)
    values = [fields[place] for place in layout.places]
    if kind == "tmy2":
        values[0] = f"19{values[0]}"
    elif kind == "tmy3":
        if date := _DATE.match(values[0]):
            values[:3] = date.group(3, 1, 2)
        if time := _TIME.match(values[3]):
            values[3] = time[1]
    for number, piece in enumerate(fields[8:13] if kind == "epw" else (), 9):
        value = float(piece) if _NUMBER.match(piece) else math.nan
        if 0 < value < 1000 if number == 10 else 30_000 <= value <= 120_000:
            message = f"field {number} is {piece}, the air pressure in Pa belongs in field 10: is a field missing"
            raise BadValueError("E602", f"{message}, or a decimal written with a comma?", advice=_SAY_ROW)
    return values


def _place(number: int, text: str, kind: str, place: int) -> Span:
    """Where a field of a row is."""
    if kind != "tmy2":
        return cell_span(number, text, place)
    start, end = _TMY2_COLUMNS[place]
    return Span(number, start + 1, text, end - start)


def _position(file: _Text, pieces: Sequence[str]) -> tuple[float, float, float]:
    """Latitude, longitude and time zone of line 1; a zone that is not that of the longitude is warned of."""
    found, text = [], file.line(1)
    advice = "write degrees and hours from UTC with a decimal point, north and east positive"
    limits = {"latitude": 90.0, "longitude": 180.0, "time zone": 14.0}
    for (name, limit), piece in zip(limits.items(), map(str.strip, pieces), strict=True):
        span = Span(1, max(text.find(piece), 0) + 1, text, max(len(piece), 1))
        if not _NUMBER.match(piece) or abs(float(piece)) > limit:
            message = f"{piece[:40]!r} is not a number from -{limit:g} to {limit:g}"
            raise refuse(file.path, message, advice=advice, code="E601", name=name, span=span)
        found.append(float(piece))
    latitude, longitude, zone = found
    away = abs((longitude / 15.0 - zone + 12.0) % 24.0 - 12.0)
    if away > _ZONE_H:
        message = f"{zone:g} hours from UTC at longitude {longitude:g}, where the sun is {away:.1f} hours from that"
        problem = span.problem(str(file.path), "E601", message, field="time zone", advice=advice, is_error=False)
        warnings.warn(problem.render(), InputWarning, stacklevel=5)
    return latitude, longitude, zone


def _epw(file: _Text) -> _Layout:
    """The head of an EPW file: eight lines from LOCATION to DATA PERIODS."""
    place, periods = split_row(file.line(1).rstrip(", ")), split_row(file.line(8))
    if len(place) != 10 or place[0].upper() != "LOCATION":
        raise file.bad_head(1, f"line 1 is not LOCATION with 10 entries, it has {len(place)}")
    position = _position(file, place[6:9])
    if "".join(periods[:1]).upper() != "DATA PERIODS" or periods[2:3] not in ([], ["1"]):
        raise file.bad_head(8, "line 8 is not DATA PERIODS with one record per hour")
    for number, text in enumerate(file.lines[8:], 9):
        minute = "".join(text.split(",", 5)[4:5]).strip()
        if _NUMBER.match(minute) and float(minute) not in (0.0, 60.0):
            message = f"minute {minute}: rows of less than an hour; hours are read, 1 row each, minute 0 or 60"
            raise refuse(file.path, message, code="E602", advice=_SAY_MEANS, span=cell_span(number, text, 4))
    return _Layout(station=place[1], position=position, n_head=8, places=(0, 1, 2, 3, 13, 14, 15), n_fields=35)


def _tmy3(file: _Text) -> _Layout:
    """The head of a TMY3 file: the station, and the names of the columns.

    Some programs write the end of a day as 00:00 of the next one, not as 24:00; hour 0 is therefore allowed.
    """
    station, names = split_row(file.line(1)), split_row(file.line(2))
    if wrong := [name for name in _TMY3_NAMES if names.count(name) != 1]:
        raise file.bad_head(2, f"there are {names.count(wrong[0])} columns {wrong[0]!r}, 1 is needed")
    if len(station) < 6:
        raise file.bad_head(1, "line 1 has no latitude and longitude")
    position = _position(file, (station[4], station[5], station[3]))
    date, *others = map(names.index, _TMY3_NAMES)
    places = (date, date, date, *others)
    return _Layout(station=station[1], position=position, n_head=2, places=places, n_fields=len(names))


def _tmy2(file: _Text) -> _Layout:
    """The head of a TMY2 file: one line of fixed columns."""
    first = file.line(1)
    north, east = first[37:38].upper(), first[45:46].upper()
    parts = [first[start:end].strip() for start, end in ((39, 41), (42, 44), (47, 50), (51, 53))]
    if north not in ("N", "S") or east not in ("E", "W") or not all(part.isdecimal() for part in parts):
        raise file.bad_head(1, "this is not the header of a TMY2 file")
    latitude, longitude = (int(parts[k]) + int(parts[k + 1]) / 60 for k in (0, 2))
    texts = (f"{'-' * (north == 'S')}{latitude!r}", f"{'-' * (east == 'W')}{longitude!r}", first[33:36])
    position = _position(file, texts)
    return _Layout(station=first[7:29].strip(), position=position, n_head=1, places=range(7), n_fields=7)


_HEADS: dict[str, Callable[[_Text], _Layout]] = {"epw": _epw, "tmy2": _tmy2, "tmy3": _tmy3}
