"""The first two records of skydist.inp, and the declaration after the data of files that we wrote."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from aomc_sky import memory
from aomc_sky.formats.report import Report
from aomc_sky.formats.scanner import ListScanner, Token, list_integer, list_real

MAX_BINS = 2**27
MIN_ROW_BYTES = 8
PATCH_BYTES, BIN_BYTES = 290, 24
"""What a run takes for each patch and for each of its bins: measured for 1e6 to 1.8e7 bins, 1 to 18 wavelengths."""

_NAMES = ("numskyelem", "sky_zenith", "sky_azimuth", "numskywave")
_LOWEST = (1, 1, 0, 1)
_ADVICE = "write four whole numbers in the first line"
_TWICE = "give every wavelength once"
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
    counts = [_read_count(k, token, report) for k, token in enumerate(record.tokens)]
    if len(counts) < 4:
        last = record.tokens[-1] if record.tokens else scanner.absent(1)
        message = f"the header has {len(counts)} numbers, wanted {', '.join(_NAMES)}"
        report.at(last.behind, "E305", message, name=_NAMES[len(counts)], advice=_ADVICE)
        return None
    if any(c is None for c in counts):
        return None
    n_rows, n_zenith, n_azimuth, n_table = (int(c) for c in counts if c is not None)
    if not _sizes_are_possible(n_rows, n_zenith, n_azimuth, n_table, n_bytes, record.tokens, report):
        return None
    if not _fits(n_zenith, n_azimuth, n_table, max_memory_bytes, record.tokens[1], report):
        return None
    waves = scanner.record(record.next_line, n_table, over_many_lines=True)
    if len(waves.tokens) < n_table:
        end = min(waves.next_line + 1, max(len(lines), 1))
        last = waves.tokens[-1] if waves.tokens else scanner.absent(end)
        message = f"the header announces {n_table} wavelengths, {len(waves.tokens)} stand here"
        advice = "write as many wavelengths as the header says"
        report.at(last.behind, "E303", message, name="wavelengths", advice=advice)
        return None
    wavelength = _read_wavelengths(waves.tokens, report)
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


def _read_count(k: int, token: Token, report: Report) -> int | None:
    value = list_integer(token.word)
    if value is None:
        found = f"'{token.word}'" if token.word else "nothing"
        report.at(token, "E305", f"found {found}, wanted a whole number", name=_NAMES[k], advice=_ADVICE)
        return None
    if value < _LOWEST[k]:
        message = f"{value} is not possible, wanted {_LOWEST[k]} or more"
        report.at(token, "E304", message, name=_NAMES[k], advice="correct the header")
        return None
    return value


def _sizes_are_possible(
    n_rows: int, n_zenith: int, n_azimuth: int, n_table: int, n_bytes: int, tokens: tuple[Token, ...], report: Report
) -> bool:
    before = report.n_errors

    def note(k: int, message: str) -> None:
        report.at(tokens[k], "E304", message, name=_NAMES[k], advice="correct the header")

    if n_table > n_bytes // 2 + 1:
        note(3, f"{n_table} wavelengths do not fit into a file of {n_bytes} bytes")
    bins = n_zenith * (n_azimuth + 1) * n_table
    if bins > MAX_BINS:
        note(1, f"{n_zenith} x {n_azimuth + 1} x {n_table} = {bins} bins are more than {MAX_BINS}")
    # a count that is a little too large is a wrong count (E303); one that no such file could hold is not believed
    if n_rows > max(n_bytes, 64) * 1000:
        note(0, f"{n_rows} rows do not fit into a file of {n_bytes} bytes")
    return report.n_errors == before


def _fits(n_zenith: int, n_azimuth: int, n_table: int, limit: int | None, token: Token, report: Report) -> bool:
    """Whether the bins fit into memory, those that the file leaves out among them."""
    patches = n_zenith * (n_azimuth + 1)
    n_bytes = patches * (PATCH_BYTES + BIN_BYTES * n_table)
    if n_bytes <= max(memory.allowed(limit), memory.FREE_BYTES):
        return True
    message = (
        f"{n_zenith} x {n_azimuth + 1} x {n_table} = {patches * n_table} bins take about {memory.shown(n_bytes)} "
        f"of memory, more than the {memory.shown(memory.allowed(limit))} of --max-memory"
    )
    report.at(token, "E304", message, name=_NAMES[1], advice=f"correct the header, or write {memory.advice(n_bytes)}")
    return False


def _read_wavelengths(tokens: tuple[Token, ...], report: Report) -> np.ndarray | None:
    before = report.n_errors
    wavelength = np.zeros(len(tokens))
    first_at: dict[float, int] = {}
    for k, token in enumerate(tokens):
        if report.is_full:
            break
        value = list_real(token.word) if token.word else None
        if value is not None and math.isfinite(value) and value >= 0:
            first = first_at.setdefault(value, k)
            if first != k:
                message, advice = f"{token.word} nm stands twice, first as number {first + 1}", _TWICE
                report.at(token, "E308", message, name="wavelengths", advice=advice, can_downgrade=True)
            wavelength[k] = value
            continue
        if not token.word:
            code, message = "E306", "a wavelength is left out; Fortran leaves it unset"
        elif value is None:
            code, message = "E305", f"'{token.word}' is not a number"
        else:
            code, message = "E302", f"{token.word} is no wavelength"
        report.at(token, code, message, name="wavelengths", advice="write a number of nm")
    return wavelength if report.n_errors == before else None
