"""Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband."""

from __future__ import annotations

import io

import numpy as np

from aomc_sky.outputs.blocks.shard import WHOLE, Shard
from aomc_sky.outputs.photons.writer import PhotonWriter
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
