"""The header of skydist.inp: its four counts, and the wavelengths."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from aomc_sky.formats.aomc.scanner import ListScanner, Record, Token, ask_unit
from aomc_sky.formats.report import Report, beyond_memory
from aomc_sky.grid import MAX_PATCHES

MAX_BINS = MAX_PATCHES
PATCH_BYTES, BIN_BYTES = 290, 24
"""Memory of a run for each patch and for each of its bins: measured for 1e6 to 1.8e7 bins, 1 to 18 wavelengths."""

COUNTS = ("numskyelem", "sky_zenith", "sky_azimuth", "numskywave")
_LOWEST = (1, 1, 0, 1)
_ADVICE = "write four whole numbers in the first line"
_TWICE = "list every wavelength once"
#: A row of plain numbers; possessive, so that nothing is tried twice. Groups are greedy: Python 3.11.2 matches wrongly
#: where a possessive group gives up half-way. Nothing follows them that would make a greedy one try again.
ROW = (
    r"[ \t]*+([0-9]{1,8}+)[ \t]++([0-9]{1,8}+)[ \t]++([0-9]{1,8}+)[ \t]++"
    r"([+-]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[eE][+-]?[0-9]++)?)[ \t\r]*+"
)
PLAIN_ROW = re.compile(rf"{ROW}\Z")


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
    n_swallowed: int  #: How many lines of wavelengths, but for the first, read as rows
    count_tokens: tuple[Token, ...]  #: The four numbers of the header

    @property
    def bounds(self) -> tuple[tuple[int, int], ...]:
        """Lowest and highest value of the three indices of a row."""
        return (1, self.n_table), (1, self.n_zenith), (0, self.n_azimuth)


def read_head(lines: list[str], n_bytes: int, report: Report, max_memory_bytes: int | None = None) -> SkyHead | None:
    """Read header and wavelengths; sizes are checked against file and memory before anything is allocated."""
    scanner = ListScanner(lines)
    record = scanner.record(0, 4)
    counts = _read_counts(record, scanner, report)
    if counts is None:
        return None
    n_rows, n_zenith, n_azimuth, n_table = counts
    before = report.n_errors
    _check_sizes(counts, n_bytes, max_memory_bytes, record.tokens, report)
    if report.n_errors > before:
        return None
    waves = scanner.record(record.next_line, n_table, over_many_lines=True)
    if len(waves.tokens) < n_table:
        end = min(waves.next_line + 1, max(len(lines), 1))
        last = waves.tokens[-1] if waves.tokens else scanner.absent(end)
        message = f"the header says {n_table} wavelengths, but there are {len(waves.tokens)}"
        advice = "write as many wavelengths as the header says"
        report.at(last.behind, "E303", message, name="wavelengths", advice=advice)
        return None
    wavelength = _read_wavelengths(waves, report)
    if wavelength is None:
        return None
    if waves.n_more:
        message = f"the header says {n_table} wavelengths, but there are {n_table + waves.n_more}"
        advice = f"write {n_table + waves.n_more}, or remove the numbers behind the last wavelength"
        report.at(record.tokens[3], "E303", message, name=COUNTS[3], advice=advice, can_downgrade=True)
    return SkyHead(
        n_rows=n_rows,
        n_zenith=n_zenith,
        n_azimuth=n_azimuth,
        n_table=n_table,
        wavelength_nm=wavelength,
        first_row=waves.next_line,
        n_swallowed=_rows_among({token.line: token.text for token in waves.tokens}, n_zenith, n_azimuth, n_table),
        count_tokens=record.tokens,
    )


def _read_counts(record: Record, scanner: ListScanner, report: Report) -> tuple[int, int, int, int] | None:
    """The four counts of the header."""
    if record.is_text:
        message = f"found '{record.tokens[0].word}', expected {', '.join(COUNTS)}"
        report.at(record.tokens[0], "E305", message, advice=f"{_ADVICE}, and no text before them")
        return None
    pairs = zip(record.tokens, record.integers(), strict=True)
    counts = [_read_header_count(k, token, value, report) for k, (token, value) in enumerate(pairs)]
    if len(counts) < 4:
        last = record.tokens[-1] if record.tokens else scanner.absent(1)
        message = f"the header has {len(counts)} numbers, expected {', '.join(COUNTS)}"
        report.at(last.behind, "E305", message, name=COUNTS[len(counts)], advice=_ADVICE)
        return None
    if any(c is None for c in counts):
        return None
    if record.n_more >= (counts[3] or 1):  # they may be the wavelengths
        message = f"the header has {4 + record.n_more} numbers; Fortran reads {', '.join(COUNTS)}"
        report.at(record.behind, "E305", message, advice=_ADVICE, can_downgrade=True)
        if report.has_errors:
            return None
    n_rows, n_zenith, n_azimuth, n_table = (int(c) for c in counts if c is not None)
    return n_rows, n_zenith, n_azimuth, n_table


def _rows_among(lines: dict[int, str], *bounds: int) -> int:
    """How many of some lines, but for the first, have the numbers of a row."""
    rows = [PLAIN_ROW.match(text) for text in list(lines.values())[1:]]
    n_zenith, n_azimuth, n_table = bounds
    return sum(
        row is not None and int(row[1]) <= n_table and int(row[2]) <= n_zenith and int(row[3]) <= n_azimuth
        for row in rows
    )


def _read_header_count(k: int, token: Token, value: int | None, report: Report) -> int | None:
    if value is None:
        found = f"'{token.word}'" if token.word else "nothing"
        report.at(token, "E305", f"found {found}, expected a whole number", name=COUNTS[k], advice=_ADVICE)
        return None
    if value < _LOWEST[k]:
        message = f"{value} is not possible, expected {_LOWEST[k]} or more"
        report.at(token, "E304", message, name=COUNTS[k], advice="correct the header")
        return None
    return value


def _check_sizes(
    counts: tuple[int, int, int, int], n_bytes: int, limit: int | None, tokens: tuple[Token, ...], report: Report
) -> None:
    """Report sizes that the file or the memory cannot hold; a table in memory has the bins that the file leaves out."""
    n_rows, n_zenith, n_azimuth, n_table = counts
    patches, before = n_zenith * (n_azimuth + 1), report.n_errors
    correct = "correct the header" if tokens[0].line == tokens[3].line else _ADVICE  # a short line took from the next

    def note(k: int, message: str, advice: str = correct) -> None:
        report.at(tokens[k], "E304", message, name=COUNTS[k], advice=advice)

    if n_table > n_bytes // 2 + 1:
        note(3, f"{n_table} wavelengths do not fit into a file of {n_bytes} bytes")
    bins = f"{n_zenith} x {n_azimuth + 1} x {n_table} = {patches * n_table} bins"
    if patches * n_table > MAX_BINS:
        note(1, f"{bins} are too many; the limit is {MAX_BINS}")
    # a count that is a little too large is a wrong count (E303); this one is impossible for such a file
    if n_rows > max(n_bytes, 64) * 1000:
        note(0, f"{n_rows} rows do not fit into a file of {n_bytes} bytes")
    too_large = beyond_memory(patches * (PATCH_BYTES + BIN_BYTES * n_table), limit)
    if too_large is not None and report.n_errors == before:
        note(1, f"{bins} take {too_large.message}", f"{correct}, or {too_large.advice}")


def _read_wavelengths(record: Record, report: Report) -> np.ndarray | None:
    if record.has_comma and (comma := record.decimal_comma(at_end=False)) is not None:
        _, span, message, advice = comma
        report.at(span, "E306", message, name="wavelengths", advice=advice)
        return None
    before = report.n_errors
    wavelength = np.zeros(len(record.tokens))
    first_at: dict[float, int] = {}
    for k, (token, value) in enumerate(zip(record.tokens, record.reals(), strict=True)):
        if report.is_full:
            break
        if value is not None and math.isfinite(value) and value >= 0:
            first = first_at.setdefault(value, k)
            if first != k:
                message, advice = f"{token.word} nm is listed twice, first as number {first + 1}", _TWICE
                report.at(token, "E308", message, name="wavelengths", advice=advice, can_downgrade=True)
            wavelength[k] = value
            continue
        if not token.word:
            code, message = "E306", "a wavelength is missing; Fortran does not set it"
        elif value is None:
            code, message = "E305", f"'{token.word}' is not a number"
        else:
            code, message = "E302", f"{token.word} is not a wavelength"
        report.at(token, code, message, name="wavelengths", advice="write a number of nm")
    if report.n_errors == before:
        ask_unit(list(zip(record.tokens, wavelength.tolist(), strict=True)), "E302", report)
    return wavelength if report.n_errors == before else None
