"""Photons in a numpy file: rows of travel directions, with a weight in a fourth column where there is one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.formats.text_file import open_data, refuse
from aomc_sky.regular_file import open_regular

BLOCK = 65_536
"""Rows that are read at a time."""

_HEAD_READERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonsNpy:
    """A file whose head and length have been checked; nothing is held open."""

    path: Path
    dtype: np.dtype  #: float32 or float64, of either byte order
    n_photons: int  #: Rows
    n_columns: int  #: 3: ux, uy, uz; 4: the weight besides; 1: one number for each photon
    data_start: int  #: Where the first row begins. [bytes]

    def __len__(self) -> int:
        return self.n_photons

    def blocks(self, size: int = BLOCK) -> Iterator[np.ndarray]:
        """Yield all rows as they are stored, shape (n, n_columns), in blocks of `size`, the last one shorter."""
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        with open_regular(self.path) as file:
            file.seek(self.data_start)
            for start in range(0, self.n_photons, size):
                yield self._block(file, start, min(size, self.n_photons - start))

    def _block(self, file: BinaryIO, start: int, n: int) -> np.ndarray:
        # not a memory map: a file that shrinks under a map ends the process
        data = file.read(n * self.n_columns * self.dtype.itemsize)
        if len(data) != n * self.n_columns * self.dtype.itemsize:
            raise refuse(self.path, "the file became shorter while it was read", code="E903")
        rows = np.frombuffer(data, self.dtype).reshape(n, self.n_columns)
        is_finite = np.isfinite(rows)
        if not is_finite.all():
            row = start + int((~is_finite).any(axis=1).argmax())
            raise refuse(self.path, f"row {row}: not finite numbers", code="E904", advice="make the file again")
        return rows


def read_photons_npy(path: str | Path, *, n_columns: tuple[int, ...] = (3, 4)) -> PhotonsNpy:
    """Open a numpy file of photons, version 1 or 2 of the format, in C order; its `blocks` reads the rows.

    `n_columns` are the numbers per photon that are allowed; 1 stands for an array of one dimension.
    """
    path = Path(path)
    with open_data(path, what="a .npy file", code="E901") as file:
        size = os.fstat(file.fileno()).st_size
        shape, fortran_order, dtype = _head(file, path)
        start = file.tell()
    columns = 1 if len(shape) == 1 else shape[1] if len(shape) == 2 else 0
    is_float = dtype.kind == "f" and dtype.itemsize in (4, 8)
    if columns not in n_columns or not is_float or (fortran_order and columns > 1):
        order = ", Fortran order" if fortran_order else ""
        shapes = " or ".join("(n,)" if k == 1 else f"(n, {k})" for k in n_columns)
        advice = f"write an array of float32 or float64 and shape {shapes} in C order: travel directions ux, uy, uz, "
        advice += "then the weight where there are weights"
        raise refuse(path, f"an array of {dtype} and shape {shape}{order}", code="E902", advice=advice)
    n_bytes, expected = size - start, shape[0] * columns * dtype.itemsize
    if n_bytes != expected:
        message = f"{n_bytes} bytes of data, but the header says {shape[0]} rows, {expected} bytes"
        raise refuse(path, message, code="E903", advice="make the file again")
    return PhotonsNpy(path=path, dtype=dtype, n_photons=shape[0], n_columns=columns, data_start=start)


def _head(file: BinaryIO, path: Path) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        version = np.lib.format.read_magic(file)
        return _HEAD_READERS[version](file)
    except (KeyError, ValueError, OSError):
        message = "not a numpy file of version 1 or 2, or its header is damaged"
        raise refuse(path, message, code="E902", advice="write it with numpy.save") from None
