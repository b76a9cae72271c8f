"""The bytes of an MCPL file from its begin to its end, whether they are stored as they are or packed by gzip."""

from __future__ import annotations

import contextlib
import gzip
import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

from aomc_sky.formats.mcpl.header import McplFault
from aomc_sky.regular_file import FileKindError, open_regular

GZIP_MAGIC = b"\x1f\x8b"
MOST_TIMES = 1032
"""How many times as long what deflate unpacks can be: a length of 258 bytes takes two bits."""

_ADVICE = "give the path of an MCPL file"
_PIECE = 1 << 20


def existing_path(path: Path) -> Path:
    """The file of this name, or the compressed one that stands in its place (``photons.mcpl.gz``)."""
    packed = path.with_name(f"{path.name}.gz") if path.name.lower().endswith(".mcpl") else path
    return packed if packed != path and not os.path.lexists(path) and os.path.exists(packed) else path


class McplBytes:
    """An open file, read from its begin on.

    Of a packed file nothing is known but what was unpacked: pieces are bounded, and its end is its length.
    """

    def __init__(self, file: BinaryIO) -> None:
        size = os.fstat(file.fileno()).st_size
        self.is_packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
        file.seek(0)
        self.most_bytes = (size + 1) * MOST_TIMES if self.is_packed else size
        """Length; of a packed file the most that it can hold. [bytes]"""
        self._file = cast(BinaryIO, gzip.GzipFile(fileobj=file, mode="rb")) if self.is_packed else file
        self.position = 0

    def read(self, n: int) -> bytes:
        """The next bytes, fewer only at the end of the file; McplFault (E806) for a packed one that is damaged."""
        try:
            data = self._file.read(n)
        except EOFError:
            raise McplFault("E806", "", "the compressed file ends in the middle", "it was cut; copy it again") from None
        except (gzip.BadGzipFile, zlib.error) as error:
            reason = str(error).removeprefix("Error ")
            raise McplFault("E806", "", f"the compressed file is damaged: {reason}", "make it again") from None
        self.position += len(data)
        return data

    def skip_to(self, position: int) -> None:
        """Go to a byte further on; a packed file is unpacked on the way."""
        if not self.is_packed:
            self._file.seek(position)
            self.position = position
            return
        while self.position < position and self.read(min(_PIECE, position - self.position)):
            pass


@contextlib.contextmanager
def opened(path: Path) -> Iterator[McplBytes]:
    """A regular file, McplFault (E801) where there is none; a pipe, a device or a folder would block or never end."""
    try:
        file = open_regular(path)
    except FileKindError:
        raise McplFault("E801", "", "not a regular file", _ADVICE) from None
    except OSError as error:
        raise McplFault("E801", "", f"the file cannot be opened: {error.strerror or error}", _ADVICE) from None
    with file:
        yield McplBytes(file)
