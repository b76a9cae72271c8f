"""Hourly weather files: EPW, TMY2 and TMY3. When each hour began, and its irradiances.

In all three files the hour label, 1 to 24 in local standard time, marks the END of the 60 minutes over
which the irradiances were gathered. (Libraries that turn labels into time stamps keep the end for TMY3 and
subtract an hour for EPW and TMY2.) Here an hour is the interval [start, start + 1 h) in UTC, whatever the file.
"""

from __future__ import annotations

import calendar
import enum
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.formats.text_file import Report, read_bytes, refuse, split_lines
from aomc_sky.formats.weather.heads import NUMBER, Site, epw_head, tmy2_head, tmy3_head

HOUR = np.timedelta64(3600, "s")
MAX_IRRADIANCE = 2000.0
"""More than the sun gives outside the atmosphere, and than any cloud edge adds. [W m-2]"""

_MAX_BYTES = 64 * 2**20
_NAMES = ("year", "month", "day", "hour", "GHI", "DNI", "DHI")
_WANTED = ("a year", "a month", "a day", "a whole hour", *["an irradiance"] * 3)
_FIRST_IRRADIANCE = 4
_MISSING_FROM = 9999.0
_MISSING_TMY3 = -9900.0


class WeatherFormat(enum.Enum):
    """The kind of a weather file."""

    EPW = "epw"
    TMY2 = "tmy2"
    TMY3 = "tmy3"


@dataclass(frozen=True, kw_only=True, slots=True)
class WeatherTable:
    """The contents of a weather file that a sky needs.

    Parameters
    ----------
    path : str
        The file, for messages.
    kind : WeatherFormat
        Its format.
    place : str
        Name of the station as the file has it.
    latitude_deg, longitude_deg : float
        Position, north and east positive. [deg, -90 to 90 and -180 to 180]
    utc_offset_h : float
        Local standard time minus UTC. [h, -14 to 14]
    line : ndarray, int64, shape (n_row,)
        Line of the file that each row stood in. [1-based]
    start : ndarray, datetime64[s], shape (n_row,)
        Start of the hour in UTC; the hour is [start, start + 1 h).
    dni, dhi, ghi : ndarray, float64, shape (n_row,)
        Direct normal, diffuse horizontal and global horizontal irradiance, means over the hour;
        0 where missing. [W m-2, 0 to 2000]
    is_missing : ndarray, bool, shape (n_row,)
        Whether the file marks DNI or DHI as missing. A missing GHI alone is no harm.
    """

    path: str
    kind: WeatherFormat
    place: str
    latitude_deg: float
    longitude_deg: float
    utc_offset_h: float
    line: np.ndarray
    start: np.ndarray
    dni: np.ndarray
    dhi: np.ndarray
    ghi: np.ndarray
    is_missing: np.ndarray

    @property
    def n_rows(self) -> int:
        """Number of hours."""
        return int(self.start.size)

    @property
    def end(self) -> np.ndarray:
        """End of each hour in UTC, datetime64[s]."""
        return self.start + HOUR

    @property
    def midpoint(self) -> np.ndarray:
        """Middle of each hour in UTC, the time at which the sun's position stands for the hour, datetime64[s]."""
        return self.start + HOUR // 2


def read_weather(path: str | Path, kind: WeatherFormat | str) -> WeatherTable:
    """Read a weather file.

    Parameters
    ----------
    path : str or Path
        The file.
    kind : WeatherFormat or {"epw", "tmy2", "tmy3"}
        Its format.

    Returns
    -------
    WeatherTable
        Arrays are read-only; rows in file order.

    Raises
    ------
    InputFileError
        Every problem of the file, with its line.

    Cost
    ----
    About 0.2 s for a year of hours.
    """
    kind = WeatherFormat(kind)
    lines = split_lines(_bounded(path))
    report = Report(path=str(path))
    site = _HEADS[kind](lines, report)
    if site is None:
        report.close()
        raise AssertionError("a head that cannot be read leaves an error")
    line, values = _rows(lines, site, kind, report)
    report.close()
    return _table(str(path), kind, site, line, values)


def _bounded(path: str | Path) -> bytes:
    try:
        size = os.stat(path).st_size
    except (OSError, ValueError):
        size = 0  # read_bytes says what is wrong
    if size > _MAX_BYTES:
        message = f"the file has {size} bytes; a weather file of hours has at most {_MAX_BYTES}"
        raise refuse(path, message, code="E101")
    return read_bytes(path)


def _table(path: str, kind: WeatherFormat, site: Site, line: np.ndarray, values: np.ndarray) -> WeatherTable:
    year, month, day, hour = values[:4].astype(np.int64)
    dates = (year - 1970).astype("M8[Y]").astype("M8[M]") + (month - 1)
    local = (dates.astype("M8[D]") + (day - 1)).astype("M8[s]") + (hour - 1) * HOUR
    latitude, longitude, offset = site.numbers
    irradiance = values[4:]
    missing = np.isnan(irradiance)
    irradiance = np.where(missing, 0.0, irradiance) + 0.0  # some files write -0.00 at night
    arrays = {
        "line": line,
        "start": local - np.timedelta64(round(offset * 3600), "s"),
        "ghi": irradiance[0].copy(),
        "dni": irradiance[1].copy(),
        "dhi": irradiance[2].copy(),
        "is_missing": missing[1] | missing[2],
    }
    for array in arrays.values():
        array.flags.writeable = False
    return WeatherTable(
        path=path,
        kind=kind,
        place=site.place,
        latitude_deg=latitude,
        longitude_deg=longitude,
        utc_offset_h=offset,
        **arrays,
    )


def _rows(lines: list[str], site: Site, kind: WeatherFormat, report: Report) -> tuple[np.ndarray, np.ndarray]:
    """Lines and values (7, n_row) of all rows; problems go to the report."""
    numbers: list[int] = []
    values: list[list[float]] = []
    for index in range(site.first_row, len(lines)):
        text = lines[index]
        if not text.strip():
            continue
        row = _row(text, site, kind, index + 1, report)
        if report.is_full:
            break
        if row is not None:
            numbers.append(index + 1)
            values.append(row)
    if not values and not report.has_errors:
        report.add("E604", "the file ends before its first hour", line=max(len(lines), 1), column=1)
    return np.array(numbers, dtype=np.int64), np.array(values, dtype=np.float64).reshape(-1, len(_NAMES)).T


def _row(text: str, site: Site, kind: WeatherFormat, line: int, report: Report) -> list[float] | None:
    """The seven values of a row, missing irradiances NaN; None and a note where it cannot be read."""
    pieces = site.cut(text)
    if pieces is None:
        message = f"the row is shorter than a row of {kind.name} with DNI and DHI"
        report.add("E602", message, line=line, column=1, text=text)
        return None
    if shifted := site.shifted(text):
        report.add("E602", shifted, line=line, column=1, text=text, advice="write decimal points")
        return None
    row: list[float] = []
    problem: tuple[str, str, int] | None = None
    for k, piece in enumerate(pieces):
        piece = piece.strip()
        if k >= _FIRST_IRRADIANCE and (not piece or _is_missing(piece, kind)):
            row.append(np.nan)
        elif not NUMBER.match(piece):
            problem = ("E602", f"{piece[:40]!r} is not {_WANTED[k]}", k)
            break
        else:
            row.append(float(piece))
            if k >= _FIRST_IRRADIANCE and not 0 <= row[k] <= MAX_IRRADIANCE:
                problem = ("E603", f"{piece} is outside 0 to {MAX_IRRADIANCE:g} W m-2", k)
                break
    else:
        wrong = _wrong_date(row, site.first_hour)
        problem = None if wrong is None else ("E602", f"there is no {_NAMES[wrong]} {row[wrong]:g} here", wrong)
    if problem is None:
        return row
    code, message, k = problem
    width = max(len(pieces[k].strip()), 1)
    report.add(code, message, name=_NAMES[k], line=line, column=site.where(text, k), text=text, width=width)
    return None


def _is_missing(piece: str, kind: WeatherFormat) -> bool:
    if not NUMBER.match(piece):
        return False
    value = float(piece)
    return value == _MISSING_TMY3 if kind is WeatherFormat.TMY3 else value >= _MISSING_FROM


def _wrong_date(row: list[float], first_hour: int) -> int | None:
    """Which part of a date no calendar has, None for a date that exists."""
    year, month, day, hour = row[:4]
    for k, value, low, high in ((0, year, 1800, 2200), (1, month, 1, 12), (3, hour, first_hour, 24)):
        if not (low <= value <= high and value == int(value)):
            return k
    n_days = calendar.monthrange(int(year), int(month))[1]
    return None if 1 <= day <= n_days and day == int(day) else 2


_HEADS: dict[WeatherFormat, Callable[[list[str], Report], Site | None]] = {
    WeatherFormat.EPW: epw_head,
    WeatherFormat.TMY2: tmy2_head,
    WeatherFormat.TMY3: tmy3_head,
}
