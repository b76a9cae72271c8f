"""The rows of skydist.inp: plain ones through numpy's text reader, others slowly, with a message for each fault."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from aomc_sky.errors import Span
from aomc_sky.formats.report import Report
from aomc_sky.formats.scanner import ListScanner, Record, Token, list_integer, list_real
from aomc_sky.formats.skydist.head import MIN_ROW_BYTES, SkyHead

_PLAIN_BYTES = b"0123456789+-.eE \t\r\n"
MAX_LINES_AFTER = 50  # a comment and a few blank lines; more of them is a matter for the slow reader
_PIECE_BYTES = 1 << 22
_ROW = np.dtype([("wave", np.int64), ("zenith", np.int64), ("azimuth", np.int64), ("value", np.float64)])
_HOW: dict[str, Any] = {"dtype": _ROW, "comments": "#", "usecols": (0, 1, 2, 3), "ndmin": 1, "encoding": "latin-1"}
_NAMES = ("wavelength index", "zenith index", "azimuth index", "value")
_PLAIN_ROW = re.compile(
    r"[ \t]*([0-9]{1,9})[ \t]+([0-9]{1,9})[ \t]+([0-9]{1,9})[ \t]+"
    r"([0-9]{1,40}(?:\.[0-9]{0,40})?(?:[eE][+-]?[0-9]{1,3})?)[ \t\r]*\Z"
)


def read_rows_fast(data: bytes, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    """Read all rows, or return None where anything is not plain: the slow reader then says what.

    Accepts only what `read_rows` accepts without a message, with equal results.
    """
    if head.n_rows * MIN_ROW_BYTES > len(data) + 1:
        return None
    start = _offset_after(data, head.first_row)
    stop = _end_of_rows(data, head.n_rows, start) if start >= 0 else -1
    if stop < 0 or not _nothing_but_a_note(data, stop):
        return None
    if data[start:stop].translate(None, _PLAIN_BYTES):
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy before 2 reads 1.0 as an integer, with a warning
            pieces = [np.loadtxt(io.BytesIO(piece), **_HOW) for piece in _pieces(data, start, stop)]
    except (ValueError, Warning):
        return None
    rows = np.concatenate(pieces) if pieces else np.zeros(0, _ROW)
    if rows.size != head.n_rows:
        return None
    return _table(rows, head)


def _pieces(data: bytes, start: int, stop: int) -> Iterator[bytes]:
    """Whole lines; between two pieces other threads come to work, such as one that shows how long it takes."""
    while start < stop:
        end = data.find(b"\n", min(start + _PIECE_BYTES, stop), stop) + 1 or stop
        yield data[start:end]
        start = end


def _table(rows: np.ndarray, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    wave, zenith, azimuth, value = (rows[name] for name in ("wave", "zenith", "azimuth", "value"))
    inside = (
        wave.min() >= 1
        and wave.max() <= head.n_table
        and zenith.min() >= 1
        and zenith.max() <= head.n_zenith
        and azimuth.min() >= 0
        and azimuth.max() <= head.n_azimuth
    )
    if not inside or not np.all(np.isfinite(value)) or value.min() < 0:
        return None
    shape = (head.n_table, head.n_zenith, head.n_azimuth + 1)
    cell = ((wave - 1) * shape[1] + (zenith - 1)) * shape[2] + azimuth
    line = np.zeros(shape, dtype=np.int32)
    line.ravel()[cell] = np.arange(head.first_row + 1, head.first_row + 1 + rows.size, dtype=np.int32)
    radiance = np.zeros(shape)
    radiance.ravel()[cell] = value  # of a patch that stands more than once, the last line holds
    if not np.array_equal(radiance.ravel()[cell], value):  # its values differ: the slow reader says where
        return None
    return radiance, line


def _offset_after(data: bytes, n_lines: int) -> int:
    """Offset after the first `n_lines` lines, -1 if the data end before."""
    end = 0
    for _ in range(n_lines):
        end = data.find(b"\n", end) + 1
        if end == 0:
            return -1
    return end


def _end_of_rows(data: bytes, n_lines: int, start: int) -> int:
    """Offset after `n_lines` more line ends, -1 in doubt; the last line may lack its end."""
    n_after = data.count(b"\n", start) - n_lines
    if n_after < 0:
        return len(data) if n_after == -1 and not data.endswith(b"\n") else -1
    if n_after > MAX_LINES_AFTER:
        return -1
    end = len(data)
    for _ in range(n_after + 1):
        end = data.rfind(b"\n", start, end)
    return end + 1


def _nothing_but_a_note(data: bytes, stop: int) -> bool:
    """Whether nothing follows the data, or only a comment: otherwise rows have to be counted."""
    rest = data[stop : stop + 4096].lstrip()
    return not rest or rest.startswith(b"#")


def read_rows(lines: list[str], head: SkyHead, report: Report) -> tuple[np.ndarray, np.ndarray]:
    """Values (n_table, n_zenith, n_azimuth + 1), and the line of each, 0 where absent; problems go to the report."""
    shape = (head.n_table, head.n_zenith, head.n_azimuth + 1)
    radiance, line = np.zeros(shape), np.zeros(shape, dtype=np.int32)
    scanner = ListScanner(lines)
    index = head.first_row
    n_read = 0
    while n_read < head.n_rows and not report.is_full:
        if _take_plain(index, lines, radiance, line, report):
            index += 1
            n_read += 1
            continue
        record = scanner.record(index, 4)
        if not record.tokens and not record.ended_by_slash:
            break
        if len(record.tokens) < 4:
            last = record.tokens[-1] if record.tokens else scanner.absent(max(record.next_line, 1))
            _report_short(record, last, report)
        elif (entry := _read_row(record, head, report)) is not None:
            _store(entry, record.tokens[0], radiance, line, report)
        index = record.next_line
        n_read += 1
    if not report.is_full:
        _check_count(n_read, index, scanner, head, report)
    return radiance, line


def _take_plain(index: int, lines: list[str], radiance: np.ndarray, line: np.ndarray, report: Report) -> bool:
    """Store a row of four plain numbers that nothing is wrong with, as most rows of a broken file are; else False."""
    plain = _PLAIN_ROW.match(lines[index]) if index < len(lines) else None
    if plain is None:
        return False
    wave, zenith, azimuth, value = int(plain[1]), int(plain[2]), int(plain[3]), float(plain[4])
    n_table, n_zenith, n_columns = line.shape
    if not (1 <= wave <= n_table and 1 <= zenith <= n_zenith and azimuth < n_columns and value < math.inf):
        return False
    where = (wave - 1, zenith - 1, azimuth)
    if line[where] and radiance[where] != value:
        first = Span(index + 1, plain.start(1) + 1, lines[index])
        _store((wave, zenith, azimuth, value), first, radiance, line, report)
        return True
    radiance[where] = value
    line[where] = index + 1
    return True


def _read_row(record: Record, head: SkyHead, report: Report) -> tuple[int, int, int, float] | None:
    before = report.n_errors
    highest = (head.n_table, head.n_zenith, head.n_azimuth)
    lowest = (1, 1, 0)
    found: list[int] = []
    for k in range(3):
        token = record.tokens[k]
        value = list_integer(token.word)
        if not token.word:
            advice = "write every value" if not record.ended_by_slash else "write the values out"
            message = "the value is left out; Fortran leaves the old one"
            report.at(token, "E306", message, name=_NAMES[k], advice=advice)
        elif value is None:
            message = f"'{token.word}' is not a whole number"
            report.at(token, "E305", message, name=_NAMES[k], advice="write a whole number")
        elif not lowest[k] <= value <= highest[k]:
            message = f"{value} is outside {lowest[k]} to {highest[k]}, which the header allows"
            advice = f"write {lowest[k]} to {highest[k]}, or correct the header"
            report.at(token, "E301", message, name=_NAMES[k], advice=advice)
        else:
            found.append(value)
    number = _read_value(record, report)
    if number is None or len(found) < 3 or report.n_errors > before:
        return None
    return found[0], found[1], found[2], number


def _read_value(record: Record, report: Report) -> float | None:
    before, token = record.tokens[2:4]
    number = list_real(token.word) if token.word else None
    if token.word and (token.line, token.column) == (before.line, before.column):
        message = "the repeat count runs from the indices into the value, which Fortran refuses"
        report.at(token, "E305", message, name=_NAMES[3], advice="write the value out")
        return None
    rest = record.rest.split()[0] if record.rest[:1] == "," and record.rest[1:2].isdigit() else ""
    if not token.word:
        message = "the value is left out; Fortran leaves the old one"
        report.at(token, "E306", message, name=_NAMES[3], advice="write every value")
        return None
    if number is None:
        report.at(token, "E305", f"'{token.word}' is not a number", name=_NAMES[3], advice="write a number")
        return None
    if rest and "." not in token.word:
        span = token.part(0, len(token.word) + len(rest))
        message = f"'{token.word}{rest}' has a decimal comma; Fortran reads {token.word}"
        report.at(span, "E306", message, name=_NAMES[3], advice=f"write {token.word}.{rest[1:]}")
        return None
    if not math.isfinite(number) or number < 0:
        message = f"{token.word} cannot be a radiance nor a share of photons; both are finite and not negative"
        report.at(token, "E302", message, name=_NAMES[3], advice="write 0 or a positive number")
        return None
    return number


def _report_short(record: Record, last: Token, report: Report) -> None:
    n_values = len(record.tokens)
    if record.ended_by_slash:
        code, message = "E306", f"the slash leaves {_NAMES[n_values]} unset"
    else:
        code, message = "E305", f"the row has {n_values} values, wanted 4 (wavelength, zenith, azimuth, value)"
    advice = "write the four values of a row in one line"
    report.at(last.behind, code, message, name=_NAMES[n_values], advice=advice)


def _store(
    entry: tuple[int, int, int, float], first: Span, radiance: np.ndarray, line: np.ndarray, report: Report
) -> None:
    wave, zenith, azimuth, value = entry
    where = (wave - 1, zenith - 1, azimuth)
    earlier = int(line[where])
    if earlier and radiance[where] != value:
        row = first.part(0, len(first.text.rstrip()) - first.column + 1)
        message = f"this patch has {value:g} here and {radiance[where]:g} in line {earlier}"
        advice = "give every patch once; with --lenient the last one wins"
        report.at(row, "E309", message, advice=advice, can_downgrade=True)
    radiance[where] = value
    line[where] = first.line


def _check_count(n_read: int, index: int, scanner: ListScanner, head: SkyHead, report: Report) -> None:
    extra = 0
    while n_read == head.n_rows:
        record = scanner.record(index, 4)
        tokens = record.tokens
        is_row = len(tokens) == 4 and all(list_integer(t.word) is not None for t in tokens[:3])
        if not is_row or list_real(tokens[3].word) is None:
            break
        extra += 1
        index = record.next_line
    if extra or n_read < head.n_rows:
        message = f"the header announces {head.n_rows} rows, the file has {n_read + extra}"
        advice = f"write {n_read + extra}"
        report.at(head.count_token, "E303", message, name="numskyelem", advice=advice, can_downgrade=True)
