"""skydist.inp: radiances or masses over zenith and azimuth indices, for one or more wavelengths."""

from __future__ import annotations

import enum
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from aomc_sky.errors import SceneError, Span, member_of, require_kind
from aomc_sky.formats.aomc.scanner import (
    ListScanner,
    Record,
    Token,
    list_integer,
    list_real,
    no_number,
)
from aomc_sky.formats.aomc.sky_head import COUNTS, PLAIN_ROW, ROW, SkyHead, read_head
from aomc_sky.formats.report import MAX_PROBLEMS, Report
from aomc_sky.formats.text_file import read_bytes, split_lines, write_atomically
from aomc_sky.record import same_content

BinsWord = Literal["equal", "degrees"]
ValuesWord = Literal["radiance", "mass"]


class Bins(enum.Enum):
    """Meaning of the indices: numbers of equal bins, or whole degrees."""

    EQUAL = "equal"
    DEGREES = "degrees"


class Values(enum.Enum):
    """Meaning of the listed values: radiances, or masses (shares of the photons)."""

    RADIANCE = "radiance"
    MASS = "mass"


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class SkyTable:
    """The contents of skydist.inp.

    Parameters
    ----------
    wavelength_nm : ndarray, float64, shape (n_table,)
        Wavelengths in file order. [nm]
    radiance : ndarray, float64, shape (n_table, n_zenith, n_azimuth + 1)
        Listed values at [wavelength, zenith index - 1, azimuth index], absent ones 0. [0 or more]
    line : ndarray, int32, shape of `radiance`
        Line that each value stood in, 0 where absent; all 0 by default.
    declared_bins : Bins or None
    declared_values : Values or None
        What the comment after the data says, in files that we wrote.
    path : str
        The file, for messages.

    Examples
    --------
    >>> table = sky.files.read_skydist("inputs/sparse_sky/skydist.inp")
    >>> table.radiance.shape
    (3, 30, 72)
    """

    wavelength_nm: np.ndarray
    radiance: np.ndarray
    line: np.ndarray = None  # type: ignore[assignment]
    declared_bins: Bins | None = None
    declared_values: Values | None = None
    path: str = ""

    if TYPE_CHECKING:  # what may be given; the fields above are what it becomes

        def __init__(
            self,
            *,
            wavelength_nm: np.ndarray,
            radiance: np.ndarray,
            line: np.ndarray | None = None,
            declared_bins: Bins | BinsWord | None = None,
            declared_values: Values | ValuesWord | None = None,
            path: str = "",
        ) -> None: ...

    __eq__ = same_content

    def __repr__(self) -> str:
        n, n_zenith, n_azimuth = self.radiance.shape
        return f"<SkyTable: {n} wavelength{'s' * (n != 1)}, {n_zenith} x {n_azimuth} values, path {self.path!r}>"

    def __post_init__(self) -> None:
        shape, n_wl = np.shape(self.radiance), np.size(self.wavelength_nm)
        if len(shape) != 3 or shape[0] != n_wl:
            raise SceneError(f"{n_wl} wavelength(s) have radiances of shape ({n_wl}, n_zenith, n_azimuth), got {shape}")
        for name, kind in (("declared_bins", Bins), ("declared_values", Values)):
            if (given := getattr(self, name)) is not None:
                object.__setattr__(self, name, member_of(kind, given, name))
        if self.line is None:
            object.__setattr__(self, "line", np.zeros(shape, np.int32))


def read_skydist(
    path: str | Path,
    *,
    lenient: bool = False,
    downgrade: frozenset[str] = frozenset(),
    max_memory_bytes: int | None = None,
) -> SkyTable:
    """Read skydist.inp.

    Parameters
    ----------
    path : str or Path
        The file.
    lenient : bool
        A wrong row count, and duplicates that differ (the last one wins), become warnings.
    downgrade : frozenset of str
        Codes that become warnings in any case (E308 under --compat aomc).
    max_memory_bytes : int, optional
        Refuse a table that takes more, its absent bins included, before it takes any; 2 GiB by default. [bytes]

    Returns
    -------
    SkyTable
        Arrays are read-only.

    Raises
    ------
    InputFileError
        Every problem of the file, with line and column.

    Cost
    ----
    A third of the time of numpy.loadtxt; a file that does not pass its checks is read again to say why.

    Examples
    --------
    >>> table = sky.files.read_skydist("inputs/clear_day/skydist.inp")
    >>> print(table.wavelength_nm)
    [440. 550. 670.]
    """
    data = read_bytes(path)
    for end in (data.find(b"\n", _HEAD_BYTES), None):  # a short piece is usually enough
        report = Report(path=str(path), lenient=lenient, downgrade=downgrade, counts_bytes=True)
        if (head := read_head(split_lines(data[:end]), len(data), report, max_memory_bytes)) is not None:
            break
    if head is None:
        report.close()
        raise AssertionError("a head that cannot be read leaves an error")
    radiance, line = read_rows_fast(data, head) or read_rows(split_lines(data), head, report)
    tail = max(0, len(data) - 4096)
    declared = _DECLARATION.findall(data, tail)
    bins, values = (word.decode() for word in declared[-1]) if declared else ("", "")
    for note in _NOTE.finditer(data, tail):
        if not _DECLARATION.match(note[0]):
            span = Span(data.count(b"\n", 0, note.start()) + 1, 1, text := split_lines(note[0])[0], len(text))
            advice = "write # aomc-sky bins=equal|degrees values=radiance|mass, or remove the line"
            report.at(span, "E305", "this note on bins and values is not understood", advice=advice, can_downgrade=True)
    report.close()
    for array in (radiance, line, head.wavelength_nm):
        array.flags.writeable = False
    return SkyTable(
        wavelength_nm=head.wavelength_nm,
        radiance=radiance,
        line=line,
        declared_bins=Bins(bins) if bins else None,
        declared_values=Values(values) if values else None,
        path=str(path),
    )


def write_skydist(
    table: SkyTable,
    path: str | Path,
    *,
    bins: Bins | BinsWord = Bins.EQUAL,
    values: Values | ValuesWord = Values.RADIANCE,
) -> None:
    """Write skydist.inp; reading it back gives the same float64 values, bins and meaning.

    Parameters
    ----------
    table : SkyTable
        What to write; zeros are left out.
    path : str or Path
        The file, replaced atomically.
    bins, values : {"equal", "degrees"}, {"radiance", "mass"}
        Stand in a comment after the data, which AOMC ignores and `read_skydist` obeys.

    Examples
    --------
    >>> sky.files.write_skydist(
    ...     sky.files.read_skydist("inputs/sparse_sky/skydist.inp"), "copy.inp"
    ... )
    >>> sky.files.read_skydist("copy.inp").radiance.shape
    (3, 30, 72)
    """
    bins, values = member_of(Bins, bins, "bins"), member_of(Values, values, "values")
    require_kind(table, SkyTable, "sky.files.write_skydist(sky.files.read_skydist('skydist.inp'), 'copy.inp')")
    n_table, n_zenith, n_columns = table.radiance.shape
    wave, zenith, azimuth = np.nonzero(table.radiance)
    value = table.radiance[wave, zenith, azimuth]
    head = f"{value.size} {n_zenith} {n_columns - 1} {n_table}\n"
    wavelengths = " ".join(repr(float(w)) for w in table.wavelength_nm)
    rows = [
        f"{w} {z} {a} {v!r}\n"
        for w, z, a, v in zip((wave + 1).tolist(), (zenith + 1).tolist(), azimuth.tolist(), value.tolist(), strict=True)
    ]
    note = f"# aomc-sky bins={bins.value} values={values.value}\n"
    write_atomically(path, "".join([head, wavelengths, "\n", *rows, note]))


_HEAD_BYTES = 262_144
"""A piece of this length, up to a line end, holds the header and the wavelengths of nearly every file."""
MIN_ROW_BYTES = 8
_OWN_LINE = "write each row in a line of its own"
_DECLARATION = re.compile(
    rb"^[ \t]*#[ \t]*aomc-sky[ \t]+bins=(equal|degrees)[ \t]+values=(radiance|mass)[ \t\r]*$", re.M
)

_NOTE = re.compile(rb"^[ \t]*#[ \t]*aomc-sky[ \t].*\b(?:bins|values)[ \t]*=.*$", re.M)


_PIECE_ROWS = 1 << 14  # what is made of them stays in the cache, and other threads come to work between two pieces
_COLUMNS = ("wavelength index", "zenith index", "azimuth index", "value")
#: A line of four numbers after other text: a row that is not counted
_LATE_ROW = re.compile(
    rb"^[ \t]*+[0-9]++[ \t,;]++[0-9]++[ \t,;]++[0-9]++[ \t,;]++[+-]?\.?[0-9][0-9.eEdDqQ+-]*+[ \t\r]*+$", re.M
)
_PLAIN_ROWS = re.compile(rf"(?:{ROW}(?:\n|\Z)){{1,{_PIECE_ROWS}}}".encode())


def read_rows_fast(data: bytes, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    """Read all rows, or return None for a row that is not plain: then the slow reader reports the problem.

    It accepts only rows that `read_rows` accepts without a message, with equal results.
    """
    if head.n_rows * MIN_ROW_BYTES > len(data) + 1:
        return None
    start = 0
    for _ in range(head.first_row):
        start = data.find(b"\n", start) + 1 or len(data)
    rows, start = plain_rows(data, start)
    rest = data[start:].lstrip()
    if len(rows) != head.n_rows or (rest and (not rest.startswith(b"#") or _LATE_ROW.search(rest))):
        return None  # rows have to be counted
    return _scattered(rows[:, :3].astype(np.int64).T, rows[:, 3], head)


def plain_rows(data: bytes, start: int = 0) -> tuple[np.ndarray, int]:
    """Numbers float64 (n, 4) of the lines from `start` on that have four plain numbers each, and where they end.

    Three whole numbers have at most eight digits and no sign; blanks separate the numbers.
    """
    pieces = [np.empty((0, 4))]
    while (piece := _PLAIN_ROWS.match(data, start)) is not None:
        pieces.append(np.fromiter(map(float, piece[0].split()), np.float64).reshape(-1, 4))
        start = piece.end()
    return np.concatenate(pieces), start


def _scattered(index: np.ndarray, value: np.ndarray, head: SkyHead) -> tuple[np.ndarray, np.ndarray] | None:
    wave, zenith, azimuth = index  # without signs
    inside = (
        wave.min() >= 1
        and wave.max() <= head.n_table
        and zenith.min() >= 1
        and zenith.max() <= head.n_zenith
        and azimuth.max() <= head.n_azimuth
    )
    if not inside or not np.all(np.isfinite(value)) or value.min() < 0:
        return None
    shape = (head.n_table, head.n_zenith, head.n_azimuth + 1)
    cell = ((wave - 1) * shape[1] + (zenith - 1)) * shape[2] + azimuth
    line = np.zeros(shape, dtype=np.int32)
    line.ravel()[cell] = np.arange(head.first_row + 1, head.first_row + 1 + value.size, dtype=np.int32)
    radiance = np.zeros(shape)
    radiance.ravel()[cell] = value  # of a patch that stands more than once, the last line holds
    if not np.array_equal(radiance.ravel()[cell], value):  # its values differ: the slow reader says where
        return None
    return radiance, line


def read_rows(lines: list[str], head: SkyHead, report: Report) -> tuple[np.ndarray, np.ndarray]:
    """Values (n_table, n_zenith, n_azimuth + 1), and the line of each, 0 where absent; problems go to the report."""
    shape = (head.n_table, head.n_zenith, head.n_azimuth + 1)
    radiance, line = np.zeros(shape), np.zeros(shape, dtype=np.int32)
    scanner = ListScanner(lines)
    index = head.first_row
    n_read = 0
    joined: list[Span] = []  # where a second row begins in a line
    is_counted = True  # rows cannot be counted where one is in pieces
    while n_read < head.n_rows and not report.is_full:
        if _take_plain(index, lines, radiance, line, report):
            index += 1
            n_read += 1
            continue
        record = scanner.record(index, 4)
        if not record.tokens and not record.ended_by_slash:
            break
        if record.is_text:
            first = record.tokens[0]
            message = f"'{first.word}' is not a row; Fortran stops here"
            report.at(first, "E305", message, advice="remove the line, or write it after the rows")
            index = first.line
            continue
        if len(record.tokens) < 4:
            last = record.tokens[-1] if record.tokens else scanner.absent(max(record.next_line, 1))
            _report_short(record, last, report)
            is_counted = False
        elif record.n_more and record.n_more % 4 == 0 and _is_place(record.rest.replace(",", " ").split(), head):
            joined.append(record.behind)
        if len(record.tokens) == 4 and (entry := _read_row(record, head, report)) is not None:
            _store(entry, record.tokens[0], radiance, line, report)
        index = record.next_line
        n_read += 1
    if n_read == head.n_rows:
        for span in joined[:MAX_PROBLEMS]:
            message, advice = "a second row in the line; Fortran ignores it", _OWN_LINE
            report.at(span, "E305", message, advice=advice, can_downgrade=True)
    if not report.is_full and is_counted and (report.lenient or not joined or n_read < head.n_rows):
        _check_count(n_read, index, scanner, head, report, is_joined=bool(joined))
    return radiance, line


def _is_place(words: list[str], head: SkyHead) -> bool:
    """Whether the first three words are the indices of a patch."""
    indices = [list_integer(word) for word in words[:3]]
    return all(k is not None and low <= k <= high for k, (low, high) in zip(indices, head.bounds, strict=True))


def _take_plain(index: int, lines: list[str], radiance: np.ndarray, line: np.ndarray, report: Report) -> bool:
    """Store a row of four good plain numbers, as most rows of a broken file are; otherwise return False."""
    plain = PLAIN_ROW.match(lines[index]) if index < len(lines) else None
    if plain is None:
        return False
    wave, zenith, azimuth, value = int(plain[1]), int(plain[2]), int(plain[3]), float(plain[4])
    n_table, n_zenith, n_columns = line.shape
    if not (1 <= wave <= n_table and 1 <= zenith <= n_zenith and azimuth < n_columns and 0 <= value < math.inf):
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
    comma = record.decimal_comma(at_end=False)
    if comma is not None and comma[0] < 3:
        k, span, message, _ = comma
        report.at(span, "E306", message, name=_COLUMNS[k], advice="write a whole number")
        return None
    indices: list[int] = []
    for k, (lowest, highest) in enumerate(head.bounds):
        token = record.tokens[k]
        value = list_integer(token.word)
        if not token.word:
            _report_missing(record, k, report)
        elif value is None:
            message = f"'{token.word}' is not a whole number"
            report.at(token, "E305", message, name=_COLUMNS[k], advice="write a whole number")
        elif not lowest <= value <= highest:
            message = f"{value} is outside {lowest} to {highest}, the range in the header"
            advice = f"write {lowest} to {highest}, or correct the header"
            report.at(token, "E301", message, name=_COLUMNS[k], advice=advice)
        else:
            indices.append(value)
    number = _read_value(record, report)
    return None if number is None or len(indices) < 3 else (indices[0], indices[1], indices[2], number)


def _read_value(record: Record, report: Report) -> float | None:
    before, token = record.tokens[2:4]
    number = list_real(token.word)
    span: Span = token
    if not token.word:
        _report_missing(record, 3, report)
        return None
    if (token.line, token.column) == (before.line, before.column):
        code, advice = "E305", "write the value out"
        message = "the repeat count covers an index and the value; Fortran refuses this"
    elif number is None:
        code, (message, advice) = "E305", no_number(token.word, is_short=False)
    elif (comma := record.decimal_comma()) is not None:
        code, (_, span, message, advice) = "E306", comma
    elif not math.isfinite(number) or number < 0:
        code, advice = "E302", "write 0 or a positive number"
        message = f"{token.word} cannot be a radiance or a share of photons: both are finite and not negative"
    else:
        return number
    report.at(span, code, message, name=_COLUMNS[3], advice=advice)
    return None


def _report_missing(record: Record, k: int, report: Report) -> None:
    advice = "write the values out" if record.ended_by_slash and k < 3 else "write every value"
    message = "the value is missing; Fortran keeps the previous one"
    report.at(record.tokens[k], "E306", message, name=_COLUMNS[k], advice=advice)


def _report_short(record: Record, last: Token, report: Report) -> None:
    n_values = len(record.tokens)
    span, name, advice = last.behind, _COLUMNS[n_values], "write the four values of a row in one line"
    if record.ended_by_slash:
        code, message, advice = "E306", f"the row ends at the slash; {name} is not set", f"{advice}, without a slash"
    elif (word := record.first_word) is not None:
        code, span, name, message, advice = "E305", word, "", *no_number(word.word, is_short=True)
    else:
        code, message = "E305", f"the row has {n_values} values, expected 4 (wavelength, zenith, azimuth, value)"
        advice += ", with blanks between them"
    report.at(span, code, message, name=name, advice=advice)


def _store(
    entry: tuple[int, int, int, float], first: Span, radiance: np.ndarray, line: np.ndarray, report: Report
) -> None:
    wave, zenith, azimuth, value = entry
    where = (wave - 1, zenith - 1, azimuth)
    earlier = int(line[where])
    if earlier and radiance[where] != value:
        row = first.part(0, len(first.text.rstrip()) - first.column + 1)
        here, before = (repr(float(one)).removesuffix(".0") for one in (value, radiance[where]))
        message = f"this patch has {here} here and {before} in line {earlier}"
        advice = "list every patch once; with --lenient the last value is used"
        report.at(row, "E309", message, advice=advice, can_downgrade=True)
    radiance[where] = value
    line[where] = first.line


def _check_count(
    n_read: int, index: int, scanner: ListScanner, head: SkyHead, report: Report, *, is_joined: bool
) -> None:
    extra, lines = 0, scanner.lines
    while n_read == head.n_rows:
        if index < len(lines) and PLAIN_ROW.match(lines[index]):  # the scanner takes 10 us for a row
            extra += 1
            index += 1
            continue
        record = scanner.record(index, 4)
        tokens = record.tokens
        is_row = len(tokens) == 4 and all(list_integer(t.word) is not None for t in tokens[:3])
        if not is_row or list_real(tokens[3].word) is None:
            extra += len(_LATE_ROW.findall("\n".join(lines[index:]).encode("latin-1")))
            break
        extra += 1
        index = record.next_line
    found = n_read + extra
    if found == head.n_rows:
        return
    message = f"the header says {head.n_rows} rows, the file has {found}"
    token, name, advice = head.count_tokens[0], COUNTS[0], f"write {found}" if found else "add the rows"
    if is_joined:
        advice = _OWN_LINE
    if head.n_swallowed and head.n_swallowed == head.n_rows - found:
        n_table = head.n_table - 4 * head.n_swallowed
        message = f"the header says {head.n_table} wavelengths, but {n_table} stand before the rows"
        token, name, advice = head.count_tokens[3], COUNTS[3], f"write {n_table}"
    report.at(token, "E303", message, name=name, advice=advice, can_downgrade=True)
