"""Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from aomc_sky.outputs.blocks.blocks import WHOLE, Shard
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.names import PART
from aomc_sky.outputs.photons.files import PhotonWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch


def _little_endian(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data.cast("B")


class NpyWriter(PhotonWriter):
    """Which numpy files a source needs, and their bytes."""

    has_rows = True

    def __init__(self, source: PhotonSource, shard: Shard = WHOLE) -> None:
        self._source, self.shard = source, shard
        self.row_dtype = source.dtype.newbyteorder("<")
        self._columns = {"photons": 3}
        if source.has_positions:
            self._columns["positions"] = 2
        if source.has_weights:
            self._columns["weights"] = 1
        self.widths = tuple(self._columns.values())

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Files of a part; the first holds the directions."""
        return tuple(f"{kind}-{bands[0] + 1:04d}{self.shard.suffix}.npy" for kind in self._columns)

    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Bytes that each file starts with."""
        n = self._n_photons(bands[0])
        return tuple(npy_header(self.row_dtype, (n,) if k == 1 else (n, k)) for k in self.widths)

    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of each finished file. [bytes]"""
        row = self._n_photons(bands[0]) * self.row_dtype.itemsize
        return tuple(len(head) + k * row for head, k in zip(self.headers(bands), self.widths, strict=True))

    def _n_photons(self, band: int) -> int:
        first, end = self.shard.photons(self._source.n_photons(band))
        return end - first

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file."""
        rows = [_little_endian(batch.directions)]
        if "positions" in self._columns:
            assert batch.positions is not None
            rows.append(_little_endian(batch.positions))
        if "weights" in self._columns:
            assert batch.weight is not None
            rows.append(_little_endian(batch.weight.copy()))  # the pool fills the array of the batch again
        return tuple(rows)


def npy_header(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    """Bytes that a little-endian array in C order starts with: magic string, version 1.0 and description."""
    buffer = io.BytesIO()
    description = {"descr": dtype.newbyteorder("<").str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, description)
    return buffer.getvalue()


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
