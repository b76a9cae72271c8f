"""Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband."""

from __future__ import annotations

import contextlib
import io
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.photons.files import FileLayout, PhotonWriter
from aomc_sky.outputs.shard import PART, WHOLE_RUN, Shard
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch
from aomc_sky.system import write_at


def _little_endian(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data.cast("B")


class NpyWriter(PhotonWriter):
    """Which numpy files a source needs, and their bytes."""

    has_rows = True

    def __init__(self, source: PhotonSource, shard: Shard = WHOLE_RUN) -> None:
        super().__init__(source, shard)
        self.row_dtype = source.dtype.newbyteorder("<")
        self._columns = {"photons": 3}
        if source.has_positions:
            self._columns["positions"] = 2
        if source.has_weights:
            self._columns["weights"] = 1
        self.widths = tuple(self._columns.values())

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files of a waveband; the first holds the directions."""
        n, end = self.shard.n_photons(self.source.n_photons(bands[0])), f"{bands[0] + 1:04d}{self.suffix}.npy"
        return tuple(
            npy_layout(f"{kind}-{end}", self.row_dtype, (n,) if width == 1 else (n, width))
            for kind, width in self._columns.items()
        )

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file."""
        rows = [_little_endian(batch.directions)]
        if "positions" in self._columns:
            assert batch.positions is not None
            rows.append(_little_endian(batch.positions))
        if "weights" in self._columns:
            assert batch.weight is not None
            rows.append(_little_endian(batch.weight.copy()))  # a pool fills the array of the batch again
        return tuple(rows)


@lru_cache(maxsize=64)  # asked for with every block that is read
def npy_layout(name: str, dtype: np.dtype, shape: tuple[int, ...]) -> FileLayout:
    """The file of a little-endian array in C order; its head is magic string, version 1.0 and description."""
    buffer = io.BytesIO()
    description = {"descr": dtype.newbyteorder("<").str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, description)
    head = buffer.getvalue()
    return FileLayout(name, head, len(head) + math.prod(shape) * dtype.itemsize)


Put = Callable[[int, Sequence[memoryview]], None]
"""Writes the rows of photons from this one on into each file."""


class NpyParts(NpyWriter):
    """The files of `NpyWriter` for a whole run, under names that end in ``.part``."""

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files of a waveband under their names on the way."""
        return tuple(replace(layout, name=layout.name + PART) for layout in super().layouts(bands))

    def n_bytes_missing(self, folder: RunFolder, band: int) -> int:
        """What the files of a waveband will take beyond what they take now. [bytes]"""
        files = self.layouts((band,))
        return sum(max(file.size - folder.n_bytes_on_disk(file.name), 0) for file in files)

    def reserve(self, folder: RunFolder, band: int) -> None:
        """Make the files of a waveband at their full length, where they are not there yet."""
        for file in self.layouts((band,)):
            if not (folder.holds(file.name, file.head, file.size) and folder.has_one_name(file.name)):
                folder.reserve(file.name, file.head, file.size)

    @contextlib.contextmanager
    def filling(self, folder: RunFolder, band: int) -> Iterator[Put]:
        """Open the files of a waveband; what was put is on the disk when the context ends."""
        files = self.layouts((band,))
        widths = [width * self.row_dtype.itemsize for width in self.widths]
        with contextlib.ExitStack() as stack:
            handles = [stack.enter_context(folder.filling(file.name)) for file in files]

            def put(first: int, rows: Sequence[memoryview]) -> None:
                for file, handle, width, data in zip(files, handles, widths, rows, strict=True):
                    try:
                        _write(handle, data, len(file.head) + first * width)
                    except OSError as error:  # reported here, for other files are open around it
                        raise os_error("write", folder.path / file.name, error) from error

            yield put


def _write(handle: int, data: memoryview, offset: int) -> None:
    while data:
        done = write_at(handle, data, offset)
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
