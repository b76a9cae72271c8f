"""Spectra as two columns of numbers, and their means over the bins of a wavelength grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aomc_sky.errors import Span
from aomc_sky.formats.report import BadValueError, Report, outside, quoted
from aomc_sky.formats.text_file import read_bytes
from aomc_sky.formats.units import parse_real

MAX_BYTES = 2**22
MAX_POINTS = 2**17
MAX_WAVELENGTH_NM = 1e9
MAX_VALUE = 1e30
"""Far beyond every range of the format, and small enough that no sum of values overflows."""


MOST_COMMENTS, MOST_SAID = 100, 1000  #: Comments that are kept, and characters of each.


@dataclass(frozen=True, kw_only=True, slots=True)
class Spectrum:
    """A spectrum that is linear between its points."""

    wavelength_nm: np.ndarray  #: float64 (n,), strictly rising, two or more
    value: np.ndarray  #: float64 (n,), in the unit that the user of the file expects
    head: tuple[str, ...] = ()  #: Comments above the first row, without their sign


def read_spectrum_csv(path: str | Path) -> Spectrum:
    """Read a table of wavelength [nm] and value, separated by a comma; blank lines and lines with ``#`` are left out.

    InputFileError: every problem of the file, E401 for a row of another form, E404 for a number beyond all ranges.
    """
    report = Report(path=str(path))
    head: list[str] = []
    rows = read_rows(path, report, _row, ("wavelength", "wavelength in nm, value"), MAX_POINTS, head)
    report.close()
    table = np.array(rows, np.float64)
    table.flags.writeable = False
    return Spectrum(wavelength_nm=table[:, 0], value=table[:, 1], head=tuple(head))


def _row(cells: list[str]) -> list[float]:
    if len(cells) != 2:
        advice = "write wavelength in nm, comma, value"
        raise BadValueError("E401", f"a row of {len(cells)} columns where two are expected", advice=advice)
    return numbers(cells, (0.0, MAX_WAVELENGTH_NM), (-MAX_VALUE, MAX_VALUE))


def read_rows(
    path: str | Path,
    report: Report,
    row_of: Callable[[list[str]], list[float] | None],
    names: tuple[str, str],
    most: int,
    head: list[str] | None = None,
) -> list[list[float]]:
    """Read rows of numbers whose first ones rise; what is wrong is reported, also fewer than two rows or too many.

    `row_of` has the numbers of the cells of a line, or None for a line of another kind; `names` are those of the first
    column, and of all. Comments above the first row are added to `head`.
    """
    lines = read_bytes(path, most_bytes=MAX_BYTES, code="E401").decode("utf-8", "surrogateescape").split("\n")
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            if head is not None and not rows and len(head) < MOST_COMMENTS:
                head.append(line.strip().lstrip("#")[:MOST_SAID])
            continue
        cells = line.split(",")
        try:
            row = row_of(cells)
            if row is None:
                continue
            rows.append(row)
            if len(rows) > 1 and not rows[-2][0] < row[0]:
                message = f"{names[0]} {row[0]:g} is not above {rows[-2][0]:g}"
                raise BadValueError("E401", message, advice="sort the rows", width=len(cells[0]))
        except BadValueError as problem:
            report.bad_value(Span(number, 1, line.rstrip("\r"), len(line)), problem)
        if report.is_full or len(rows) > most:
            break
    if len(rows) > most:
        report.add("E401", f"the file has more than {most} rows", advice="write fewer")
    elif len(rows) < 2 and not report.has_errors:
        message = f"the file has {len(rows)} row{'s' * (len(rows) != 1)} of numbers"
        report.add("E401", message, advice=f"write two or more: {names[1]}")
    return rows


def numbers(cells: list[str], first: tuple[float, float], others: tuple[float, float], offset: int = 0) -> list[float]:
    """Numbers of the cells of a line inside their ranges; `offset` is where the cells begin."""
    values = []
    for k, cell in enumerate(cells):
        low, high = others if k else first
        text, start = cell.strip(), offset + len(cell) - len(cell.lstrip())
        value = parse_real(text, offset=start)
        if not low <= value <= high:
            raise outside(quoted(text), f"{low:g} to {high:g}", offset=start, width=len(text))
        values.append(value)
        offset += len(cell) + 1
    return values


def bin_means(spectrum: Spectrum, wavelength_nm: np.ndarray) -> np.ndarray:
    """Mean of a piecewise-linear spectrum over the bin around every wavelength of an even grid, which its data contain.

    The bin of w is [w - d/2, w + d/2] with the step d of the grid, cut at the ends of the data. A single wavelength has
    a bin of width 0. The error is at most 6 ulp for values of one sign and the edges of the bin in float64,
    by exact sums of trapezoids.
    """
    x, y = spectrum.wavelength_nm, spectrum.value
    n = len(wavelength_nm)
    half = (wavelength_nm[-1] - wavelength_nm[0]) / (n - 1) / 2.0 if n > 1 else 0.0
    low = np.maximum(wavelength_nm - half, x[0])
    high = np.minimum(wavelength_nm + half, x[-1])
    ends = np.stack((_at(spectrum, low), _at(spectrum, high)), axis=1)
    first, last = np.searchsorted(x, low, "right"), np.searchsorted(x, high, "left")
    means = ends[:, 0].copy()
    for k in range(n):
        if low[k] < high[k]:
            knots = np.concatenate((low[k : k + 1], x[first[k] : last[k]], high[k : k + 1]))
            values = np.concatenate((ends[k, :1], y[first[k] : last[k]], ends[k, 1:]))
            areas = np.diff(knots) * (0.5 * values[1:] + 0.5 * values[:-1])
            means[k] = math.fsum(areas.tolist()) / (high[k] - low[k])
    return means


def _at(spectrum: Spectrum, wavelength_nm: np.ndarray) -> np.ndarray:
    """Value at wavelengths inside the data, counted from the nearer of its two neighbours."""
    x, y = spectrum.wavelength_nm, spectrum.value
    k = np.clip(np.searchsorted(x, wavelength_nm, "right") - 1, 0, len(x) - 2)
    step = x[k + 1] - x[k]
    share = (wavelength_nm - x[k]) / step
    rest = (x[k + 1] - wavelength_nm) / step
    return np.asarray(y[k] * rest + y[k + 1] * share)
