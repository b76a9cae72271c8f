"""Phase functions in CSV files beside a description: angle, and one value for all wavelengths or one for each."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np

from aomc_sky.errors import Span
from aomc_sky.formats.report import BadValueError, Gathered, Report, outside, quoted
from aomc_sky.formats.spectrum_csv import MAX_BYTES, MAX_VALUE
from aomc_sky.formats.text_file import read_bytes
from aomc_sky.formats.units import parse_real
from aomc_sky.skies.atmosphere.description.keys import HIGHEST_NM, LOWEST_NM
from aomc_sky.skies.atmosphere.phase_table import PhaseTable

MAX_ANGLES = 2**14
MAX_COLUMNS = 256
_HEAD = "write angle, 400, 550, 700 above the numbers: the wavelengths in nm"


def read_phase_csv(path: str, *, shown: str, text: str) -> PhaseTable:
    """Read a table of angle [deg] and value, with a row of wavelengths where there are several columns of values.

    Lines that are blank or begin with ``#`` are left out. InputFileError with every problem: E401 for another form or
    order, E404 for a number outside its range, E408 where the angles do not go from 0 to 180.
    """
    lines = read_bytes(path, most_bytes=MAX_BYTES, code="E401").decode("utf-8", "surrogateescape").split("\n")
    report = Report(path=shown)
    wavelength: list[float] | None = None
    rows: list[list[float]] = []
    for number, line in enumerate((one.rstrip("\r") for one in lines), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = line.split(",")
        try:
            if wavelength is None and not rows and cells[0].split()[:1] == ["angle"]:
                wavelength = _wavelengths(cells)
                continue
            _check_width(cells, len(wavelength) if wavelength else 1, has_head=wavelength is not None)
            row = _numbers(cells, (0.0, 180.0), (0.0, MAX_VALUE))
            if rows and not rows[-1][0] < row[0]:
                message = f"angle {row[0]:g} is not above {rows[-1][0]:g}"
                raise BadValueError("E401", message, advice="sort the rows", width=len(cells[0]))
            rows.append(row)
        except BadValueError as first:
            for problem in (first, *first.more):
                report.bad_value(Span(number, 1, line, len(line)), problem)
        if report.is_full or len(rows) > MAX_ANGLES:
            break
    if not report.has_errors:
        _check_rows(rows, report)
    report.close()
    table = np.array(rows, np.float64)
    table.flags.writeable = False
    known = np.array(wavelength if wavelength else [0.0], np.float64)
    return PhaseTable(path=shown, text=text, angle_deg=table[:, 0], wavelength_nm=known, value=table[:, 1:].T)


def _wavelengths(cells: list[str]) -> list[float]:
    if not 2 <= len(cells) <= MAX_COLUMNS + 1:
        raise BadValueError("E401", f"{len(cells) - 1} wavelengths after the word angle", advice=_HEAD)
    values = _numbers(["0", *cells[1:]], (0.0, 0.0), (LOWEST_NM, HIGHEST_NM), first=len(cells[0]))[1:]
    if any(not low < high for low, high in pairwise(values)):
        raise BadValueError("E401", "the wavelengths do not rise", advice="sort the columns")
    return values


def _check_width(cells: list[str], n_column: int, *, has_head: bool) -> None:
    if len(cells) == n_column + 1:
        return
    advice = "write angle in degrees, comma, value"
    if has_head:
        advice = "write the angle and one value for each wavelength"
    elif len(cells) > 2:
        advice = _HEAD
    message = f"a row of {len(cells)} column{'s' * (len(cells) != 1)} where {n_column + 1} are expected"
    raise BadValueError("E401", message, advice=advice)


def _numbers(
    cells: list[str], angle: tuple[float, float], others: tuple[float, float], *, first: int | None = None
) -> list[float]:
    """Numbers of a row inside their ranges; `first` is the width of the first cell where it was another one."""
    gathered, values, offset = Gathered(), [], 0
    for k, cell in enumerate(cells):
        start = offset + len(cell) - len(cell.lstrip())
        value = gathered.attempt(partial(_number, cell.strip(), start, angle if k == 0 else others))
        values.append(0.0 if value is None else value)
        offset += (first if k == 0 and first is not None else len(cell)) + 1
        if gathered.is_full:
            break
    gathered.close()
    return values


def _number(text: str, offset: int, limits: tuple[float, float]) -> float:
    value = parse_real(text, offset=offset)
    if not limits[0] <= value <= limits[1]:
        raise outside(quoted(text), f"{limits[0]:g} to {limits[1]:g}", offset=offset, width=len(text))
    return value


def _check_rows(rows: list[list[float]], report: Report) -> None:
    """Report what is wrong with a table whose rows are right one by one."""
    if len(rows) > MAX_ANGLES:
        report.add("E401", f"the file has more than {MAX_ANGLES} angles", advice="write fewer")
    elif len(rows) < 2:
        message = f"the file has {len(rows)} row{'s' * (len(rows) != 1)} of numbers"
        report.add("E401", message, advice="write two or more: angle in degrees, value")
    elif rows[0][0] != 0.0 or rows[-1][0] != 180.0:
        message = f"the angles go from {rows[0][0]:g} to {rows[-1][0]:g} degrees"
        report.add("E408", message, advice="write rows from 0, straight on, to 180, straight back")
    elif not all(any(row[k] for row in rows) for k in range(1, len(rows[0]))):
        report.add("E404", "a column of zeros, which cannot be normalised", advice="write one that scatters some light")
