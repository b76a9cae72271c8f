"""Reading a text file with checks of kind, size, encoding and line ends; and writing a file atomically."""

from __future__ import annotations

import contextlib
import csv
import os
import re
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from aomc_sky.errors import NOWHERE, InputFileError, OutputError, Span
from aomc_sky.system import FileKindError, appearing, open_regular, prepare_target

MAX_LINE_BYTES = 65_536
MAX_FILE_BYTES = 2**31
UNSIZED_BYTES = 2**20
"""Most bytes of a file whose stated size is smaller, such as a file of /proc."""

_BOM_UTF8 = b"\xef\xbb\xbf"
_LONE_RETURN = re.compile(rb"\r(?!\n|\Z)")
_BOMS_OTHER = (b"\xff\xfe", b"\xfe\xff")


def refuse(
    path: str | Path, message: str, *, advice: str = "", code: str = "E100", name: str = "", span: Span = NOWHERE
) -> InputFileError:
    """Return the error for a file that cannot be read further."""
    return InputFileError([span.problem(str(path), code, message, field=name, advice=advice)])


def open_data(path: str | Path, *, what: str, code: str) -> BinaryIO:
    """Open a regular file for reading; `what` it should be, and the code of the error, for messages."""
    advice = f"give the path of {what}"
    try:
        file = open_regular(path)
        if os.fstat(file.fileno()).st_size == 0 and file.read(1) is None:  # nothing yet, and no end: /proc/kmsg
            file.close()
            raise FileKindError(path, "a file without an end")
        return file
    except FileKindError:
        raise refuse(path, "not a regular file", advice=advice, code=code) from None
    except PermissionError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}") from error
    except OSError as error:
        reason = error.strerror or error
        raise refuse(path, f"the file cannot be opened: {reason}", advice=advice, code=code) from None


def read_bytes(path: str | Path, *, most_bytes: int = MAX_FILE_BYTES, code: str = "E101") -> bytes:
    """Return the bytes of a regular file, without a UTF-8 byte order mark; `code` is that of a file too large.

    InputFileError where it is missing, not a regular file (a FIFO is never opened), too large, UTF-16, has NUL bytes, a
    carriage return inside a line, or a line beyond 64 kB; OutputError where the operating system refuses.
    """
    is_of_fortran = os.fspath(path).lower().endswith(".inp")
    try:
        status = os.stat(path)
    except FileNotFoundError:
        raise refuse(path, "there is no such file") from None
    except NotADirectoryError:
        raise refuse(path, "a part of this path is not a folder") from None
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "not a regular file"
        raise refuse(path, f"this is {kind}, expected a text file")
    if status.st_size > most_bytes:
        raise refuse(path, f"the file has {status.st_size} bytes; at most {most_bytes} are read", code=code)
    try:
        data = _bounded_bytes(path, max(status.st_size, UNSIZED_BYTES), is_of_fortran=is_of_fortran)
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error
    data = data.removeprefix(_BOM_UTF8)
    if b"\r" in data and (lone_return := _LONE_RETURN.search(data)):
        # Fortran ends the line here, most editors do not
        message = "there is a carriage return inside a line" + ("; Fortran ends the line here" if is_of_fortran else "")
        raise _refuse_byte(path, data, lone_return.start(), message, "save the file with LF or CR LF line ends")
    return data


def _refuse_byte(
    path: str | Path, data: bytes, offset: int, message: str, advice: str, earlier_lines: int = 0
) -> InputFileError:
    """Return the E101 error for the byte at `offset`, shown in its line."""
    start = data.rfind(b"\n", 0, offset) + 1
    end = data.find(b"\n", offset)
    text = data[start : min(len(data) if end < 0 else end, offset + 200)]
    line = earlier_lines + data.count(b"\n", 0, offset) + 1
    return refuse(
        path, message, advice=advice, code="E101", span=Span(line, offset - start + 1, text.decode("latin-1"))
    )


def _bounded_bytes(path: str | Path, most: int, *, is_of_fortran: bool) -> bytes:
    """Read at most so much, in pieces, so that a gigabyte without a line end is refused after the first one."""
    pieces: list[bytes] = []
    open_line, n_bytes = 0, 0
    with open_regular(path) as file:
        while (piece := file.read(1 << 20)) != b"":
            n_bytes += len(piece or b"")
            if piece is None or n_bytes > most:  # nothing there yet, and no end either: /proc/kmsg
                raise refuse(path, f"the file has no end: it goes on after {n_bytes} bytes", code="E101")
            if not pieces and piece.startswith(_BOMS_OTHER):
                message = "the file is UTF-16" + (", which Fortran cannot read" if is_of_fortran else "")
                advice = "save it as plain text (UTF-8)"
                raise refuse(path, message, advice=advice, code="E101", span=Span(1, 1, ""))
            if (nul := piece.find(b"\0")) >= 0:
                advice = "save it as plain text (UTF-8)"
                raise _refuse_byte(path, piece, nul, "a NUL byte; this is not a text file", advice, _count(pieces))
            long_line = _long_line(piece, open_line)
            if long_line is not None:
                message = f"the line is longer than {MAX_LINE_BYTES} bytes"
                number = _count(pieces) + piece.count(b"\n", 0, long_line) + 1
                raise refuse(path, message, advice="end every line", code="E101", span=Span(number, 1, ""))
            last = piece.rfind(b"\n")
            open_line = open_line + len(piece) if last < 0 else len(piece) - last - 1
            pieces.append(piece)
    return b"".join(pieces)


def _count(pieces: list[bytes]) -> int:
    return sum(piece.count(b"\n") for piece in pieces)


def _long_line(piece: bytes, open_line: int) -> int | None:
    """Start of the first line beyond the limit in the piece (0 if it started before), or None."""
    start = -open_line
    while start + MAX_LINE_BYTES < len(piece):
        # the last line end inside the allowed length: everything before it is short enough
        end = piece.rfind(b"\n", max(start, 0), start + MAX_LINE_BYTES + 1)
        if end < 0:
            return max(start, 0)
        start = end + 1
    return None


def split_lines(data: bytes) -> list[str]:
    """Lines without their ends (LF or CR LF), one character per byte, as Fortran counts columns."""
    lines = data.decode("latin-1").split("\n")
    if lines and lines[-1] == "":
        lines.pop()
    return [line[:-1] if line.endswith("\r") else line for line in lines]


_QUOTED = re.compile(r'"(?:[^"]|"")*"')


def split_row(line: str, delimiter: str = ",") -> list[str]:
    """Cells of a row without blanks around them; a cell in quotes may hold the delimiter."""
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]


def delimiter_of(line: str, delimiters: Iterable[str]) -> str:
    """The first of some delimiters that is in a row outside of quotes; a comma where none is."""
    outside = _QUOTED.sub("", line)
    return next((one for one in delimiters if one in outside), ",")


def cell_span(number: int, line: str, index: int, delimiter: str = ",") -> Span:
    """Position of a cell of `split_row`, without its quotes."""
    parts = _QUOTED.sub(lambda cell: "x" * len(cell[0]), line).split(delimiter)  # as long, and without delimiters
    index = min(index, len(parts) - 1)  # of a row whose quotes do not close
    start = sum(len(part) + 1 for part in parts[:index])
    cell = line[start : start + len(parts[index])]
    start += len(cell) - len(cell.lstrip(' "'))
    return Span(number, start + 1, line, max(len(cell.strip(' "')), 1))


def read_lines(path: str | Path) -> list[str]:
    """Lines of a text file; see `read_bytes` and `split_lines`."""
    return split_lines(read_bytes(path))


def lines_at(path: str | Path, numbers: Iterable[int]) -> dict[int, str]:
    """Texts of some lines of a file that was read before, as far as it can be read again. [lines from 1]"""
    needed = set(numbers)
    texts: dict[int, str] = {}
    with contextlib.suppress(OSError), open_regular(path) as file:
        for number, data in enumerate(file, 1):
            if number in needed:
                texts[number] = split_lines(data)[0]
                if len(texts) == len(needed):
                    break
    return texts


def write_atomically(path: str | Path, text: str) -> None:
    """Write a small text file; see `write_bytes_atomically`."""
    write_bytes_atomically(path, text.encode("ascii"))


def write_bytes_atomically(path: str | Path, data: bytes) -> None:
    """Write a file that appears when it is complete; an OutputError has changed nothing."""
    prepare_target(Path(path))
    with appearing(Path(path)) as file:
        file.write(data)
