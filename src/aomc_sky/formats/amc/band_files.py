"""lambbot.inp and difcol.inp: a count, then a row of reals per waveband."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from aomc_sky.formats.report import Report
from aomc_sky.formats.scanner import ListScanner, Record, Token, list_integer, list_real
from aomc_sky.formats.text_file import read_bytes, split_lines

_NAMES = (
    "wavelength",
    "bottom reflectance",
    "bottom specular fraction",
    "target reflectance",
    "target specular fraction",
)
MAX_BANDS = 500
_HIGHEST = (inf, 1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class LambbotTable:
    """Wavelengths [nm] and fractions [0 to 1], float64, shape (n_band,); target columns may be None."""

    wavelength_nm: np.ndarray
    bottom_reflectance: np.ndarray
    bottom_specular_fraction: np.ndarray
    target_reflectance: np.ndarray | None = None
    target_specular_fraction: np.ndarray | None = None


def read_lambbot(
    path: str | Path, *, n_wavebands: int | None = None, has_target: bool = False, lenient: bool = False
) -> LambbotTable:
    """Read lambbot.inp; `n_wavebands` is the count that amc.inp announces, to be compared.

    With `has_target` there are five columns instead of three; with `lenient` values outside their range are warnings.
    """
    n_columns = 5 if has_target else 3
    rows = read_band_rows(path, _NAMES[:n_columns], _HIGHEST[:n_columns], n_wavebands, lenient=lenient)
    rows.flags.writeable = False
    target = (rows[:, 3], rows[:, 4]) if has_target else (None, None)
    return LambbotTable(
        wavelength_nm=rows[:, 0],
        bottom_reflectance=rows[:, 1],
        bottom_specular_fraction=rows[:, 2],
        target_reflectance=target[0],
        target_specular_fraction=target[1],
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class DifcolTable:
    """`direct_fraction` [0 to 1] and `intensity` [0 or more, relative], float64, shape (n_band,)."""

    direct_fraction: np.ndarray
    intensity: np.ndarray


def read_difcol(path: str | Path, *, n_wavebands: int | None = None, lenient: bool = False) -> DifcolTable:
    """Read difcol.inp; `n_wavebands` is the count that amc.inp announces, to be compared.

    `lenient` is there for symmetry: a fraction outside 0 to 1 or a negative intensity stays an error, for no photons
    can be shared out by it.
    """
    rows = read_band_rows(path, ("direct fraction", "intensity"), (1.0, inf), n_wavebands, lenient=False)
    rows.flags.writeable = False
    return DifcolTable(direct_fraction=rows[:, 0], intensity=rows[:, 1])


def read_band_rows(
    path: str | Path, names: tuple[str, ...], highest: tuple[float, ...], n_wavebands: int | None, *, lenient: bool
) -> np.ndarray:
    """Rows (n_band, n_column) of a file with one row per waveband, each value from 0 to the `highest` of its column."""
    lines = split_lines(read_bytes(path))
    report = Report(path=str(path), lenient=lenient)
    scanner = ListScanner(lines)
    head = scanner.record(0, 1)
    n_rows = _read_count(head.tokens[0] if head.tokens else scanner.absent(1), n_wavebands, report)
    rows = np.zeros((n_rows, len(names)))
    index = head.next_line
    for k in range(n_rows):
        record = scanner.record(index, len(names))
        if not record.tokens and not record.ended_by_slash:
            message = f"the file ends after {k} of the {n_rows} rows that its first line announces"
            end = scanner.absent(max(len(lines), 1))
            report.at(end, "E203", message, advice="add the missing rows, or correct the count")
            break
        _read_row(record, rows[k], names, highest, report)
        if len(record.tokens) < len(names):
            last = record.tokens[-1] if record.tokens else scanner.absent(record.next_line)
            _report_short(record, last, names, report)
        else:
            _check_comma(record, names[-1], report)
        index = record.next_line
        if report.is_full:
            break
    report.close()
    return rows


def _read_count(token: Token, n_wavebands: int | None, report: Report) -> int:
    count = list_integer(token.word)
    if count is None or not 1 <= count <= MAX_BANDS:
        found = f"'{token.word}'" if token.word else "nothing"
        message = f"found {found}, wanted the number of wavebands, 1 to {MAX_BANDS}"
        report.at(token, "E204", message, name="count", advice=f"write {n_wavebands or 'their number'}")
        return 0
    if n_wavebands is not None and count != n_wavebands:
        message = f"the file is for {count} wavebands, amc.inp is for {n_wavebands}"
        advice = f"write {n_wavebands}, or change the last line of amc.inp"
        report.at(token, "E201", message, name="count", advice=advice)
    return count


def _read_row(
    record: Record, row: np.ndarray, names: tuple[str, ...], highest: tuple[float, ...], report: Report
) -> None:
    for k, (name, token) in enumerate(zip(names, record.tokens, strict=False)):
        value = list_real(token.word) if token.word else None
        if not token.word:
            message = "the value is left out; Fortran leaves it unset"
            report.at(token, "E205", message, name=name, advice="write every value")
        elif value is None:
            report.at(token, "E204", f"'{token.word}' is not a number", name=name, advice="write a number")
        elif not math.isfinite(value):
            report.at(token, "E202", f"{token.word} is not finite", name=name, advice="write a number")
        else:
            if not 0 <= value <= highest[k]:
                allowed = f"0 to {highest[k]:g}" if math.isfinite(highest[k]) else "0 or more"
                message, advice = f"{token.word} is outside the range {allowed}", f"write {allowed}"
                report.at(token, "E202", message, name=name, advice=advice, can_downgrade=True)
            row[k] = value


def _check_comma(record: Record, name: str, report: Report) -> None:
    token = record.tokens[-1]
    if record.rest[:1] == "," and record.rest[1:2].isdigit() and "." not in token.word:
        rest = record.rest.split()[0]
        message = f"'{token.word}{rest}' has a decimal comma; Fortran reads {token.word}"
        span, advice = token.part(0, len(token.word) + len(rest)), f"write {token.word}.{rest[1:]}"
        report.at(span, "E205", message, name=name, advice=advice)


def _report_short(record: Record, last: Token, names: tuple[str, ...], report: Report) -> None:
    n_values = len(record.tokens)
    name = names[n_values]
    if record.ended_by_slash:
        code, message = "E205", f"the slash leaves {name} unset"
    else:
        code, message = "E204", f"the row has {n_values} values, wanted {len(names)}; {name} is missing"
    report.at(last.behind, code, message, name=name, advice="write all values of a waveband in one line")
