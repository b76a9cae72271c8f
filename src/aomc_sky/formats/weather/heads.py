"""Heads of EPW, TMY2 and TMY3 files: where the station stands, and how a row is cut into its texts."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from aomc_sky.formats.text_file import Report

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z", re.ASCII)

_DATE = re.compile(r"(\d{1,2})/(\d{1,2})/(\d{4})\Z", re.ASCII)
_TIME = re.compile(r"(\d{1,2}):00\Z", re.ASCII)
_N_EPW_HEAD = 8
_EPW_FIELDS = (0, 1, 2, 3, 13, 14, 15)
_MOST_EPW_FIELDS = 35
_EPW_PRESSURE = 9
_COMMAS = "are its decimals written with commas?"
_TMY2_COLUMNS = ((1, 3), (3, 5), (5, 7), (7, 9), (17, 21), (23, 27), (29, 33))
"""From and to, counted from 0: year, month, day, hour, GHI, DNI, DHI."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Site:
    """What the head of a file says, and how its rows are cut.

    `cut` gives the texts of year, month, day, hour, GHI, DNI and DHI, or None for a row that is too short;
    `where` gives the column at which the k-th of them stands, `first_hour` is the lowest label of an hour; `shifted`
    says why the texts of a row are not those of its columns, or nothing.
    """

    place: str
    numbers: tuple[float, float, float]
    first_row: int
    cut: Callable[[str], Sequence[str] | None]
    where: Callable[[str, int], int]
    first_hour: int = 1
    shifted: Callable[[str], str] = lambda _: ""


def _note(report: Report, message: str, name: str, text: str, piece: str) -> None:
    column = max(text.find(piece), 0) + 1
    report.add("E601", message, name=name, line=1, column=column, text=text, width=max(len(piece), 1))


def _site_numbers(pieces: Sequence[str], text: str, report: Report) -> tuple[float, float, float] | None:
    """Latitude, longitude and time zone of a head line; None and a note where one is no such number."""
    found: list[float] = []
    limits = (("latitude", 90.0), ("longitude", 180.0), ("time zone", 14.0))
    for (name, limit), piece in zip(limits, pieces, strict=True):
        piece = piece.strip()
        if not NUMBER.match(piece) or abs(float(piece)) > limit:
            message = f"{piece[:40]!r} is not a number from -{limit:g} to {limit:g}"
            _note(report, message, name, text, piece)
            return None
        found.append(float(piece))
    return found[0], found[1], found[2]


def _fields(line: str) -> list[str]:
    """Fields of a head line; a name in quotes may hold a comma."""
    return next(csv.reader([line]), [""]) or [""]


def _after_commas(fields: Sequence[int]) -> Callable[[str, int], int]:
    def where(text: str, k: int) -> int:
        before = text.split(",")[: fields[k]]
        return sum(map(len, before)) + len(before) + 1

    return where


def epw_head(lines: list[str], report: Report) -> Site | None:
    """The head of an EPW file: eight lines from LOCATION to DATA PERIODS."""
    first = lines[0] if lines else ""
    pieces = _fields(first)
    if pieces[0].strip().upper() != "LOCATION" or len(pieces) < 9:
        advice = "an EPW file begins with LOCATION,city,state,country,source,WMO,latitude,longitude,time zone"
        report.add("E601", "this is not the head of an EPW file", line=1, column=1, text=first, advice=advice)
        return None
    numbers = _site_numbers(pieces[6:9], first, report)
    periods = lines[_N_EPW_HEAD - 1] if len(lines) >= _N_EPW_HEAD else ""
    parts = [part.strip() for part in periods.split(",")]
    if parts[0].upper() != "DATA PERIODS":
        report.add("E601", "line 8 is not the DATA PERIODS line", line=_N_EPW_HEAD, column=1, text=periods)
    elif len(parts) > 2 and parts[2] != "1":
        message = f"{parts[2]} records per hour; hours are read, 1 record each"
        report.add("E601", message, line=_N_EPW_HEAD, column=1, text=periods)
    if numbers is None or report.has_errors:
        return None
    return Site(
        place=pieces[1].strip(),
        numbers=numbers,
        first_row=_N_EPW_HEAD,
        cut=_cut_epw,
        where=_after_commas(_EPW_FIELDS),
        shifted=_shifted_epw,
    )


def _n_fields(text: str) -> int:
    return text.rstrip(", \t").count(",") + 1


def _shifted_epw(text: str) -> str:
    """A decimal comma moves all that follows it by a column; the air pressure shows it before the irradiances do."""
    n_fields = _n_fields(text)
    if n_fields > _MOST_EPW_FIELDS:
        return f"the row has {n_fields} fields, a row of EPW at most {_MOST_EPW_FIELDS}; {_COMMAS}"
    pressure, *others = (piece.strip() for piece in text.split(",", 13)[_EPW_PRESSURE:13])
    if NUMBER.match(pressure) and 0 < float(pressure) < 1000:
        return f"the air pressure in field {_EPW_PRESSURE + 1} is {pressure} Pa; {_COMMAS}"
    for k, piece in enumerate(others, _EPW_PRESSURE + 2):
        if NUMBER.match(piece) and 30_000 <= float(piece) <= 120_000:
            return f"field {k} holds {piece}, which can only be an air pressure; {_COMMAS}"
    return ""


def _cut_epw(text: str) -> Sequence[str] | None:
    pieces = text.split(",", 16)
    return [pieces[k] for k in _EPW_FIELDS] if len(pieces) >= 16 else None


def tmy3_head(lines: list[str], report: Report) -> Site | None:
    """The head of a TMY3 file: the station, and the names of the columns.

    Some programs write the end of a day as 00:00 of the next one, not as 24:00; hour 0 is therefore allowed.
    """
    first = lines[0] if lines else ""
    names = [name.strip() for name in lines[1].split(",")] if len(lines) > 1 else []
    wanted = ("Date (MM/DD/YYYY)", "Time (HH:MM)", "GHI (W/m^2)", "DNI (W/m^2)", "DHI (W/m^2)")
    absent = [name for name in wanted if name not in names]
    pieces = _fields(first)
    if absent or len(pieces) < 6:
        advice = "a TMY3 file has its station in line 1 and the names of its columns in line 2"
        what = f"there is no column {absent[0]!r}" if absent else "line 1 has no latitude and longitude"
        report.add(
            "E601",
            what,
            line=2 if absent else 1,
            column=1,
            text=lines[1] if absent and len(lines) > 1 else first,
            advice=advice,
        )
        return None
    numbers = _site_numbers((pieces[4], pieces[5], pieces[3]), first, report)
    date, time, *irradiance = (names.index(name) for name in wanted)
    n_wanted = max(date, time, *irradiance) + 1

    def cut(text: str) -> Sequence[str] | None:
        row = text.split(",", n_wanted)
        if len(row) < n_wanted:
            return None
        day, hour = _DATE.match(row[date].strip()), _TIME.match(row[time].strip())
        month_day_year = (day[3], day[1], day[2]) if day else (row[date],) * 3
        return [*month_day_year, hour[1] if hour else row[time], *(row[k] for k in irradiance)]

    def shifted(text: str) -> str:
        n_fields = _n_fields(text)
        return f"the row has {n_fields} fields, line 2 names {len(names)}; {_COMMAS}" if n_fields > len(names) else ""

    if numbers is None:
        return None
    where = _after_commas((date, date, date, time, *irradiance))
    return Site(
        place=pieces[1].strip(), numbers=numbers, first_row=2, first_hour=0, cut=cut, where=where, shifted=shifted
    )


def tmy2_head(lines: list[str], report: Report) -> Site | None:
    """The head of a TMY2 file: one line of fixed columns."""
    first = lines[0] if lines else ""
    north, east = first[37:38].upper(), first[45:46].upper()
    parts = [first[a:b].strip() for a, b in ((39, 41), (42, 44), (47, 50), (51, 53))]
    if north not in ("N", "S") or east not in ("E", "W") or not all(part.isdecimal() for part in parts):
        advice = "a TMY2 file has N or S in column 38 and E or W in column 46 of its first line"
        report.add("E601", "this is not the head of a TMY2 file", line=1, column=1, text=first, advice=advice)
        return None
    latitude, longitude = (int(parts[k]) + int(parts[k + 1]) / 60 for k in (0, 2))
    texts = (repr(-latitude if north == "S" else latitude), repr(-longitude if east == "W" else longitude))
    numbers = _site_numbers((*texts, first[33:36]), first, report)
    if numbers is None:
        return None
    return Site(place=first[7:29].strip(), numbers=numbers, first_row=1, cut=_cut_tmy2, where=_where_tmy2)


def _where_tmy2(text: str, k: int) -> int:
    return _TMY2_COLUMNS[k][0] + 1


def _cut_tmy2(text: str) -> Sequence[str] | None:
    if len(text) < _TMY2_COLUMNS[-1][1]:
        return None
    year, *others = (text[start:end] for start, end in _TMY2_COLUMNS)
    return [f"19{year}" if year.isdecimal() else year, *others]
