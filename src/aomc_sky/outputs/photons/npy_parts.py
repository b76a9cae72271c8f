"""Numpy files that several processes fill: names until they are whole, and how to write into their middle."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from aomc_sky.outputs.folder.run_folder import PART, RunFolder, os_error
from aomc_sky.outputs.photons.npy import NpyWriter

Put = Callable[[int, Sequence[memoryview]], None]
"""Writes the rows of photons from this one on into each file."""


class NpyParts(NpyWriter):
    """The files of `NpyWriter` for a whole run, under names that end in ``.part``."""

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Files of a part; the first holds the directions."""
        return tuple(name + PART for name in super().names(bands))

    def n_bytes_missing(self, folder: RunFolder, band: int) -> int:
        """What the files of a waveband will take beyond what they take now. [bytes]"""
        files = zip(self.names((band,)), self.sizes((band,)), strict=True)
        return sum(max(size - folder.n_bytes_on_disk(name), 0) for name, size in files)

    def reserve(self, folder: RunFolder, band: int) -> None:
        """Make the files of a waveband at their full length, where they are not there yet."""
        for name, head, size in zip(self.names((band,)), self.headers((band,)), self.sizes((band,)), strict=True):
            is_there = folder.size_of(name) == size and folder.has_one_name(name)
            if not is_there or folder.head_of(name, len(head)) != head:
                folder.reserve(name, head, size)

    @contextlib.contextmanager
    def filling(self, folder: RunFolder, band: int) -> Iterator[Put]:
        """Open the files of a waveband; what was put is on the disk when the context ends."""
        names, heads = self.names((band,)), self.headers((band,))
        widths = [width * self.row_dtype.itemsize for width in self.widths]
        with contextlib.ExitStack() as stack:
            handles = [stack.enter_context(folder.filling(name)) for name in names]

            def put(first: int, rows: Sequence[memoryview]) -> None:
                for name, handle, head, width, data in zip(names, handles, heads, widths, rows, strict=True):
                    try:
                        _write(handle, data, len(head) + first * width)
                    except OSError as error:  # reported here, for other files are open around it
                        raise os_error("write", folder.path / name, error) from error

            yield put


def _write(handle: int, data: memoryview, offset: int) -> None:
    while data:
        done = os.pwrite(handle, data, offset)
        data, offset = data[done:], offset + done


def word_sum(pieces: Iterable[bytes | memoryview]) -> int:
    """Sum of the 64-bit words of rows, modulo 2**64: it shows a changed word at a twentieth of the price of a hash.

    Every piece but the last of a file is a whole number of words, so that any division into pieces has one sum.
    """
    total = 0
    for piece in pieces:
        n_words = len(piece) // 8
        total += int(np.frombuffer(piece, "<u8", count=n_words).sum())
        total += int.from_bytes(piece[8 * n_words :], "little")
    return total % (1 << 64)
