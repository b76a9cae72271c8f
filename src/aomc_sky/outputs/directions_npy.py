"""Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import BinaryIO

import numpy as np

from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch


def _header(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    buffer = io.BytesIO()
    description = {"descr": dtype.newbyteorder("<").str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, description)
    return buffer.getvalue()


def _little_endian(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data.cast("B")


class NpyWriter:
    """Which numpy files a source needs, and their bytes.

    Parameters
    ----------
    source : PhotonSource
        Where the photons come from.
    """

    is_exact = True
    """Whether the file holds the photons to the last bit."""

    def __init__(self, source: PhotonSource) -> None:
        self._source = source
        self._dtype = source.dtype
        self._columns = {"photons": 3}
        if source.has_positions:
            self._columns["positions"] = 2
        if source.has_weights:
            self._columns["weights"] = 1

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: every one has its own."""
        return [(band,) for band in bands]

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Files of a part; the first holds the directions."""
        return tuple(f"{kind}-{bands[0] + 1:04d}.npy" for kind in self._columns)

    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Bytes that each file starts with."""
        n = self._source.n_photons(bands[0])
        return tuple(_header(self._dtype, (n,) if k == 1 else (n, k)) for k in self._columns.values())

    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of each finished file. [bytes]"""
        row = self._source.n_photons(bands[0]) * self._dtype.itemsize
        parts = zip(self.headers(bands), self._columns.values(), strict=True)
        return tuple(len(head) + k * row for head, k in parts)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file."""
        rows = [_little_endian(batch.directions)]
        if "positions" in self._columns:
            assert batch.positions is not None
            rows.append(_little_endian(batch.positions))
        if "weights" in self._columns:
            assert batch.weight is not None
            rows.append(_little_endian(batch.weight))
        return tuple(rows)

    def recycle(self, chunks: tuple[memoryview, ...]) -> None:
        """Nothing: every batch has memory of its own."""

    def stored_uz(self, file: BinaryIO, band: int, block: int) -> Iterator[np.ndarray]:
        """Uz of a waveband from its finished file of directions, block by block."""
        file.seek(len(self.headers((band,))[0]))
        yield from read_blocks(file, self._dtype.newbyteorder("<"), 3, self._source.n_photons(band), block)


def read_blocks(file: BinaryIO, dtype: np.dtype, n_columns: int, n_photons: int, block: int) -> Iterator[np.ndarray]:
    """Third column of rows of numbers, block by block, in native byte order."""
    for start in range(0, n_photons, block):
        n = min(block, n_photons - start)
        data = file.read(n * n_columns * dtype.itemsize)
        if len(data) != n * n_columns * dtype.itemsize:
            raise OSError("the file became shorter while it was read")
        yield np.frombuffer(data, dtype).reshape(n, n_columns)[:, 2].astype(dtype.newbyteorder("="))
