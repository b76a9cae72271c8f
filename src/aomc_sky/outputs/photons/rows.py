"""Photons as rows of numbers: numpy arrays (npy), bare float32 records (raw), text in columns of fixed width (csv)."""

from __future__ import annotations

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.errors import OutputError
from aomc_sky.outputs.photons.files import FileLayout, PhotonWriter

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


_RECORD = np.dtype("<f4")


def _rows(batch: PhotonBatch) -> np.ndarray:
    columns = [batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight]
    return np.stack([c for c in columns if c is not None], axis=-1)


class RawWriter(PhotonWriter):
    """Which raw files a source needs, and their bytes."""

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The file of a waveband: no head, records of float32 start at once."""
        width = 3 + 2 * self.source.has_positions + self.source.has_weights
        n = self.source.n_photons(bands[0])
        return (FileLayout(f"photons-{bands[0] + 1:04d}.raw", b"", width * _RECORD.itemsize, n),)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Records of a batch."""
        rows = _rows(batch).astype(_RECORD, copy=False)
        return (rows.data.cast("B") if rows.size else memoryview(b""),)


_DIGITS = {4: 8, 8: 16}
"""Digits after the point that tell every float32 and every float64 from its neighbours, by bytes."""

_OTHER_CHARACTERS = len("+1.e+00") + len(",")


class CsvWriter(PhotonWriter):
    """Which CSV files a source needs, and their bytes.

    A number is a sign, a digit, a point, 8 digits (float32) or 16 (float64), and an exponent of two
    digits: reading it back gives the same bits, and the length of a file is known before it is made.
    """

    def __init__(self, source: PhotonSource) -> None:
        super().__init__(source)
        columns = ["ux", "uy", "uz"]
        columns += ["x_m", "y_m"] if source.has_positions else []
        columns += ["weight"] if source.has_weights else []
        digits = _DIGITS[source.dtype.itemsize]
        self._head = (",".join(columns) + "\n").encode("ascii")
        self._row = ",".join([f"%+.{digits}e"] * len(columns)) + "\n"
        self._row_bytes = len(columns) * (digits + _OTHER_CHARACTERS)

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The file of a waveband; its head names the columns."""
        n = self.source.n_photons(bands[0])
        return (FileLayout(f"photons-{bands[0] + 1:04d}.csv", self._head, self._row_bytes, n),)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Lines of a batch."""
        text = (self._row * len(batch)) % tuple(_rows(batch).ravel().tolist())
        if len(text) != len(batch) * self._row_bytes:
            raise OutputError("a position or weight lies outside 1e-99 to 1e99 and does not fit the columns")
        return (memoryview(text.encode("ascii")),)
