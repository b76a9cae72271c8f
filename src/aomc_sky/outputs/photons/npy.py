"""Photons as numpy arrays: writes them, and reads rows of directions from any program."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.errors import UsageError
from aomc_sky.formats.text_file import open_data, refuse
from aomc_sky.outputs.photons.files import FileLayout, PhotonFile, PhotonRows, PhotonWriter, block_spans
from aomc_sky.system import open_regular

HEAD_BYTES = 4096
"""Length of the head. Blocks of photons begin on pages after it, so that two machines never write to one page."""

_HEAD_READERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonsNpy:
    """A closed file whose head and length have been checked."""

    path: Path
    dtype: np.dtype  #: float32 or float64, of either byte order
    n_photons: int  #: rows
    n_columns: int  #: 3: ux, uy, uz; 4: also the weight; 1: one number for each photon
    data_start: int  #: position of the first number [bytes]
    is_by_columns: bool  #: in Fortran order, as numpy.save writes the transpose of three rows

    def blocks(self) -> Iterator[np.ndarray]:
        """Yield all rows as they are stored, shape (n, n_columns)."""
        with open_regular(self.path) as file:
            for start, stop in block_spans(0, self.n_photons):
                if self.is_by_columns:
                    firsts = range(start, self.n_photons * self.n_columns, self.n_photons)
                    rows = np.stack([self._numbers(file, first, stop - start) for first in firsts], axis=-1)
                else:
                    n = (stop - start) * self.n_columns
                    rows = self._numbers(file, start * self.n_columns, n).reshape(-1, self.n_columns)
                is_finite = np.isfinite(rows).all(axis=1)
                if not is_finite.all():
                    message = f"row {start + int(is_finite.argmin())}: not finite numbers"
                    raise refuse(self.path, message, code="E904", advice="make the file again")
                yield rows

    def _numbers(self, file: BinaryIO, first: int, n: int) -> np.ndarray:
        # no memory map: if a mapped file shrinks, the process crashes
        file.seek(self.data_start + first * self.dtype.itemsize)
        data = file.read(n * self.dtype.itemsize)
        if len(data) != n * self.dtype.itemsize:
            raise refuse(self.path, "the file became shorter while it was read", code="E903")
        return np.frombuffer(data, self.dtype)


def read_photons_npy(path: str | Path, *, n_columns: tuple[int, ...] = (3, 4)) -> PhotonsNpy:
    """Open a numpy file of photons, version 1 or 2 of the format.

    `n_columns` are the allowed numbers per photon; 1 means an array of one dimension.
    """
    path = Path(path)
    with open_data(path, what="a .npy file", code="E901") as file:
        size = os.fstat(file.fileno()).st_size
        shape, fortran_order, dtype = _read_head(file, path)
        start = file.tell()
    columns = 1 if len(shape) == 1 else shape[1] if len(shape) == 2 else 0
    is_float = dtype.kind == "f" and dtype.itemsize in (4, 8)
    if columns not in n_columns or not is_float:
        shapes = " or ".join("(n,)" if k == 1 else f"(n, {k})" for k in n_columns)
        advice = f"write an array of float32 or float64 and shape {shapes}: travel directions ux, uy, uz, "
        advice += "then the weight where there are weights"
        raise refuse(path, f"an array of {dtype} and shape {shape}", code="E902", advice=advice)
    n_bytes, expected = size - start, shape[0] * columns * dtype.itemsize
    if n_bytes != expected:
        message = f"{n_bytes} bytes of data, but the header says {shape[0]} rows, {expected} bytes"
        raise refuse(path, message, code="E903", advice="make the file again")
    return PhotonsNpy(
        path=path,
        dtype=dtype,
        n_photons=shape[0],
        n_columns=columns,
        data_start=start,
        is_by_columns=fortran_order and columns > 1,
    )


def _read_head(file: BinaryIO, path: Path) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        version = np.lib.format.read_magic(file)
        return _HEAD_READERS[version](file)
    except Exception:  # whatever numpy and Python's tokenizer say of a damaged head
        message = "not a numpy file of version 1 or 2, or its header is damaged"
        raise refuse(path, message, code="E902", advice="write it with numpy.save") from None


def _npy_rows(photons: PhotonsNpy, weights: PhotonsNpy | None) -> Iterator[PhotonRows]:
    weight_rows = None if weights is None else weights.blocks()
    start = 0
    for rows in photons.blocks():
        weight = rows[:, 3] if photons.n_columns == 4 else None
        if weight_rows is not None:
            weight = next(weight_rows)[:, 0]
        yield PhotonRows(start=start, direction=rows[:, :3], weight=weight)
        start += len(rows)


def _little_endian(array: np.ndarray) -> memoryview:
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data.cast("B")


class NpyWriter(PhotonWriter):
    """The numpy files of a source, and their bytes."""

    names = ("photons-{:04d}.npy", "positions-{:04d}.npy", "weights-{:04d}.npy", "stokes-{:04d}.npy")

    def __init__(self, source: PhotonSource) -> None:
        super().__init__(source)
        widths = (3, 2 * source.has_positions, 1 * source.has_weights, 2 * source.has_polarisation)
        kinds = zip((*[source.dtype] * 3, np.dtype(np.float32)), widths, strict=True)
        self._columns = {name: kind for name, kind in zip(self.names, kinds, strict=True) if kind[1]}

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files of a waveband; the first holds the directions."""
        n, files = self.source.launched[bands[0]], []
        for name, (dtype, width) in self._columns.items():
            head = _head(dtype, (n, width) if width > 1 else (n,))
            files.append(FileLayout(name.format(bands[0] + 1), head, width * dtype.itemsize, n))
        return tuple(files)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file."""
        rows = [_little_endian(batch.directions)]
        if self.source.has_positions:
            assert batch.positions is not None
            rows.append(_little_endian(batch.positions))
        if self.source.has_weights:
            assert batch.weight is not None
            rows.append(_little_endian(batch.weight))
        if batch.q is not None and batch.u is not None:
            rows.append(_little_endian(np.stack([batch.q, batch.u], axis=-1)))
        return tuple(rows)

    @staticmethod
    def read(path: Path, wavelength_nm: np.ndarray, bands: tuple[int, ...], weights: str | Path | None) -> PhotonFile:
        """Open a file of rows ux, uy, uz; weights come from a fourth column or from a file of their own."""
        photons = read_photons_npy(path)
        if not bands and wavelength_nm.size > 1:
            n_bands = wavelength_nm.size
            raise UsageError(f"the scene has {n_bands} wavebands: name the waveband of the photons with --waveband")
        if len(bands) > 1:
            raise UsageError("a .npy file holds photons of one waveband: give one --waveband")
        weight_rows = None if weights is None else read_photons_npy(weights, n_columns=(1,))
        if weight_rows is not None and photons.n_columns == 4:
            raise UsageError(f"{path} has weights in its fourth column: leave --weights out")
        if weight_rows is not None and weight_rows.n_photons != photons.n_photons:
            message = f"{weight_rows.n_photons} weights for the {photons.n_photons} photons of {path}"
            raise refuse(weight_rows.path, message, code="E903")
        return PhotonFile(path=path, rows={band: partial(_npy_rows, photons, weight_rows) for band in bands or (0,)})


def _head(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    """Head of a little-endian array in C order, version 1.0 of the format, filled up with spaces."""
    text = f"{{'descr': {dtype.newbyteorder('<').str!r}, 'fortran_order': False, 'shape': {shape!r}, }}"
    start = np.lib.format.magic(1, 0)
    n_left = HEAD_BYTES - len(start) - 2
    return start + n_left.to_bytes(2, "little") + text.ljust(n_left - 1).encode("ascii") + b"\n"
