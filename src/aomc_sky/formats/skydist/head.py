"""The first two records of skydist.inp, and the declaration after the data of files that we wrote."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.formats.report import Report
from aomc_sky.formats.scanner import ListScanner, Token, list_integer, list_real
from aomc_sky.memory import FREE_BYTES, advice, allowed, shown

MAX_BINS = 2**27
MIN_ROW_BYTES = 8
PATCH_BYTES, BIN_BYTES = 290, 24
"""What a run takes for each patch and for each of its bins: measured for 1e6 to 1.8e7 bins, 1 to 18 wavelengths."""

_NAMES = ("numskyelem", "sky_zenith", "sky_azimuth", "numskywave")
_LOWEST = (1, 1, 0, 1)
_DECLARATION = re.compile(
    rb"^[ \t]*#[ \t]*aomc-sky[ \t]+bins=(equal|degrees)[ \t]+values=(radiance|mass)[ \t\r]*$", re.M
)


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyHead:
    """Counts of the header, the wavelengths, and where the rows start."""

    #: The four numbers of the header; azimuth indices run from 0 to `n_azimuth`
    n_rows: int
    n_zenith: int
    n_azimuth: int
    n_table: int
    wavelength_nm: np.ndarray  #: float64 (n_table,), in file order
    first_row: int  #: Index of the line after the wavelengths. [0-based]
    count_token: Token  #: Where the row count stands


def read_declaration(data: bytes) -> tuple[str, str] | tuple[None, None]:
    """Bins and values that the last lines of a file declare, (None, None) where they do not."""
    found = list(_DECLARATION.finditer(data, max(0, len(data) - 4096)))
    return (found[-1][1].decode(), found[-1][2].decode()) if found else (None, None)


def read_head(lines: list[str], n_bytes: int, report: Report, max_memory_bytes: int | None = None) -> SkyHead | None:
    """Read header and wavelengths; sizes are checked against file and memory before anything is allocated."""
    scanner = ListScanner(lines)
    record = scanner.record(0, 4)
    wanted = min(len(record.tokens) + 1, 4)
    counts = [_read_count(record.tokens, k, lines, report) for k in range(wanted)]
    if wanted < 4 or any(c is None for c in counts):
        return None
    n_rows, n_zenith, n_azimuth, n_table = (int(c) for c in counts if c is not None)
    if not _sizes_are_possible(n_rows, n_zenith, n_azimuth, n_table, n_bytes, record.tokens, lines, report):
        return None
    if not _fits(n_zenith, n_azimuth, n_table, max_memory_bytes, record.tokens[1], lines, report):
        return None
    waves = scanner.record(record.next_line, n_table, over_many_lines=True)
    wavelength = _read_wavelengths(waves.tokens, n_table, lines, report, waves.next_line)
    if wavelength is None:
        return None
    return SkyHead(
        n_rows=n_rows,
        n_zenith=n_zenith,
        n_azimuth=n_azimuth,
        n_table=n_table,
        wavelength_nm=wavelength,
        first_row=waves.next_line,
        count_token=record.tokens[0],
    )


def _read_count(tokens: tuple[Token, ...], k: int, lines: list[str], report: Report) -> int | None:
    if k >= len(tokens):
        last = tokens[-1] if tokens else Token("", 1, 1)
        report.add(
            "E305",
            f"the header has {len(tokens)} numbers, wanted {', '.join(_NAMES)}",
            line=last.line,
            column=last.column + len(last.text),
            name=_NAMES[k],
            text=lines[last.line - 1] if lines else "",
            advice="write four whole numbers in the first line",
        )
        return None
    token = tokens[k]
    value = list_integer(token.text)
    place: dict[str, Any] = {
        "line": token.line,
        "column": token.column,
        "text": lines[token.line - 1],
        "width": max(1, len(token.text)),
    }
    if value is None:
        found = f"'{token.text}'" if token.text else "nothing"
        message = f"found {found}, wanted a whole number"
        report.add("E305", message, name=_NAMES[k], advice="write four whole numbers in the first line", **place)
        return None
    if value < _LOWEST[k]:
        message = f"{value} is not possible, wanted {_LOWEST[k]} or more"
        report.add("E304", message, name=_NAMES[k], advice="correct the header", **place)
        return None
    return value


def _sizes_are_possible(
    n_rows: int,
    n_zenith: int,
    n_azimuth: int,
    n_table: int,
    n_bytes: int,
    tokens: tuple[Token, ...],
    lines: list[str],
    report: Report,
) -> bool:
    def note(k: int, message: str) -> None:
        token = tokens[k]
        report.add(
            "E304",
            message,
            line=token.line,
            column=token.column,
            name=_NAMES[k],
            text=lines[token.line - 1],
            width=len(token.text),
            advice="correct the header",
        )

    possible = True
    if n_table > n_bytes // 2 + 1:
        note(3, f"{n_table} wavelengths do not fit into a file of {n_bytes} bytes")
        possible = False
    bins = n_zenith * (n_azimuth + 1) * n_table
    if bins > MAX_BINS:
        note(1, f"{n_zenith} x {n_azimuth + 1} x {n_table} = {bins} bins are more than {MAX_BINS}")
        possible = False
    # a count that is a little too large is a wrong count (E303); one that no such file could hold is not believed
    if n_rows > max(n_bytes, 64) * 1000:
        note(0, f"{n_rows} rows do not fit into a file of {n_bytes} bytes")
        possible = False
    return possible


def _fits(
    n_zenith: int, n_azimuth: int, n_table: int, limit: int | None, token: Token, lines: list[str], report: Report
) -> bool:
    """Whether the bins fit into memory, those that the file leaves out among them."""
    patches = n_zenith * (n_azimuth + 1)
    wanted = patches * (PATCH_BYTES + BIN_BYTES * n_table)
    if wanted <= max(allowed(limit), FREE_BYTES):
        return True
    report.add(
        "E304",
        f"{n_zenith} x {n_azimuth + 1} x {n_table} = {patches * n_table} bins take about {shown(wanted)} of memory, "
        f"more than the {shown(allowed(limit))} of --max-memory",
        line=token.line,
        column=token.column,
        name=_NAMES[1],
        text=lines[token.line - 1],
        width=len(token.text),
        advice=f"correct the header, or write {advice(wanted)}",
    )
    return False


def _read_wavelengths(
    tokens: tuple[Token, ...], n_table: int, lines: list[str], report: Report, next_line: int
) -> np.ndarray | None:
    before = report.n_errors
    if len(tokens) < n_table:
        last = tokens[-1] if tokens else Token("", min(next_line + 1, max(len(lines), 1)), 1)
        report.add(
            "E303",
            f"the header announces {n_table} wavelengths, {len(tokens)} stand here",
            line=last.line,
            column=last.column + len(last.text),
            name="wavelengths",
            text=lines[last.line - 1] if lines else "",
            advice="write as many wavelengths as the header says",
        )
        return None
    wavelength = np.zeros(n_table)
    first_at: dict[float, int] = {}
    for k, token in enumerate(tokens):
        if report.is_full:
            break
        value = list_real(token.text) if token.text else None
        text = lines[token.line - 1]
        place: dict[str, Any] = {
            "line": token.line,
            "column": token.column,
            "text": text,
            "width": max(1, len(token.text)),
            "advice": "write a number of nm",
        }
        if not token.text:
            report.add("E306", "a wavelength is left out; Fortran leaves it unset", name="wavelengths", **place)
        elif value is None:
            report.add("E305", f"'{token.text}' is not a number", name="wavelengths", **place)
        elif not math.isfinite(value) or value < 0:
            report.add("E302", f"{token.text} is no wavelength", name="wavelengths", **place)
        else:
            first = first_at.setdefault(value, k)
            if first != k:
                report.add(
                    "E308",
                    f"{token.text} nm stands twice, first as number {first + 1}",
                    name="wavelengths",
                    can_downgrade=True,
                    **{**place, "advice": "give every wavelength once"},
                )
            wavelength[k] = value
    return wavelength if report.n_errors == before else None
