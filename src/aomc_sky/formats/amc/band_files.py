"""lambbot.inp and difcol.inp: a count, then a row of reals per waveband."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

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


MAX_BANDS = 500


def read_band_rows(
    path: str | Path, names: tuple[str, ...], highest: tuple[float, ...], n_wavebands: int | None, *, lenient: bool
) -> np.ndarray:
    """Rows (n_band, n_column) of a file with one row per waveband, each value from 0 to the `highest` of its column."""
    lines = split_lines(read_bytes(path))
    report = Report(path=str(path), lenient=lenient)
    scanner = ListScanner(lines)
    head = scanner.record(0, 1)
    n_rows = _read_count(head, lines, n_wavebands, report)
    rows = np.zeros((n_rows, len(names)))
    index = head.next_line
    for k in range(n_rows):
        record = scanner.record(index, len(names))
        if not record.tokens and not record.ended_by_slash:
            report.add(
                "E203",
                f"the file ends after {k} of the {n_rows} rows that its first line announces",
                line=max(len(lines), 1),
                column=1,
                text=lines[-1] if lines else "",
                advice="add the missing rows, or correct the count",
            )
            break
        _read_row(record, rows[k], names, highest, lines, report)
        index = record.next_line
        if report.is_full:
            break
    report.close()
    return rows


def _read_count(head: Record, lines: list[str], n_wavebands: int | None, report: Report) -> int:
    token = head.tokens[0] if head.tokens else Token("", 1, 1)
    text = lines[token.line - 1] if lines else ""
    count = list_integer(token.text)
    place: dict[str, Any] = {"line": token.line, "column": token.column, "text": text, "width": max(len(token.text), 1)}
    if count is None or not 1 <= count <= MAX_BANDS:
        found = f"'{token.text}'" if token.text else "nothing"
        message = f"found {found}, wanted the number of wavebands, 1 to {MAX_BANDS}"
        report.add("E204", message, name="count", advice=f"write {n_wavebands or 'their number'}", **place)
        return 0
    if n_wavebands is not None and count != n_wavebands:
        report.add(
            "E201",
            f"the file is for {count} wavebands, amc.inp is for {n_wavebands}",
            name="count",
            advice=f"write {n_wavebands}, or change the last line of amc.inp",
            **place,
        )
    return count


def _read_row(
    record: Record,
    row: np.ndarray,
    names: tuple[str, ...],
    highest: tuple[float, ...],
    lines: list[str],
    report: Report,
) -> None:
    for k, name in enumerate(names):
        if k >= len(record.tokens):
            _report_short(record, len(names), name, lines, report)
            return
        token = record.tokens[k]
        text = lines[token.line - 1]
        place: dict[str, Any] = {
            "line": token.line,
            "column": token.column,
            "text": text,
            "width": max(len(token.text), 1),
        }
        value = list_real(token.text) if token.text else None
        if not token.text:
            message = "the value is left out; Fortran leaves it unset"
            report.add("E205", message, name=name, advice="write every value", **place)
        elif value is None:
            report.add("E204", f"'{token.text}' is not a number", name=name, advice="write a number", **place)
        elif not math.isfinite(value):
            report.add("E202", f"{token.text} is not finite", name=name, advice="write a number", **place)
        elif not 0 <= value <= highest[k]:
            allowed = f"0 to {highest[k]:g}" if math.isfinite(highest[k]) else "0 or more"
            report.add(
                "E202",
                f"{token.text} is outside the range {allowed}",
                name=name,
                advice=f"write {allowed}",
                can_downgrade=True,
                **place,
            )
            row[k] = value
        else:
            row[k] = value
    if record.rest[:1] == "," and record.rest[1:2].isdigit() and "." not in record.tokens[-1].text:
        token = record.tokens[-1]
        report.add(
            "E205",
            f"'{token.text}{record.rest.split()[0]}' has a decimal comma; Fortran reads {token.text}",
            line=token.line,
            column=token.column,
            name=names[-1],
            text=lines[token.line - 1],
            width=len(token.text) + len(record.rest.split()[0]),
            advice=f"write {token.text}.{record.rest.split()[0][1:]}",
        )


def _report_short(record: Record, n_values: int, name: str, lines: list[str], report: Report) -> None:
    last = record.tokens[-1] if record.tokens else Token("", record.next_line, 1)
    if record.ended_by_slash:
        code, message = "E205", f"the slash leaves {name} unset"
    else:
        code, message = "E204", f"the row has {len(record.tokens)} values, wanted {n_values}; {name} is missing"
    report.add(
        code,
        message,
        line=last.line,
        column=last.column + len(last.text),
        name=name,
        text=lines[last.line - 1] if lines else "",
        advice="write all values of a waveband in one line",
    )
