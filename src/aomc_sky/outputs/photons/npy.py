"""Photons as numpy files: directions (n, 3), positions (n, 2), weights (n,), one set per waveband."""

from __future__ import annotations

import numpy as np

from aomc_sky.outputs.photons.files import FileLayout, PhotonWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

HEAD_BYTES = 4096
"""Length of the head. Blocks of photons then begin on pages, so that two machines never write into one page."""


def _little_endian(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data.cast("B")


class NpyWriter(PhotonWriter):
    """Which numpy files a source needs, and their bytes."""

    def __init__(self, source: PhotonSource) -> None:
        super().__init__(source)
        self._columns = {"photons": 3}
        if source.has_positions:
            self._columns["positions"] = 2
        if source.has_weights:
            self._columns["weights"] = 1

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files of a waveband; the first holds the directions."""
        n, dtype = self.source.n_photons(bands[0]), self.source.dtype
        return tuple(
            FileLayout(
                f"{kind}-{bands[0] + 1:04d}.npy",
                _head(dtype, (n,) if width == 1 else (n, width)),
                width * dtype.itemsize,
                n,
            )
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


def _head(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    """Head of a little-endian array in C order, version 1.0 of the format, filled up with spaces."""
    text = f"{{'descr': {dtype.newbyteorder('<').str!r}, 'fortran_order': False, 'shape': {shape!r}, }}"
    start = np.lib.format.magic(1, 0)
    n_left = HEAD_BYTES - len(start) - 2
    return start + n_left.to_bytes(2, "little") + text.ljust(n_left - 1).encode("ascii") + b"\n"
