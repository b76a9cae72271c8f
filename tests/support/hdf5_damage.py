"""What a hostile hand does to a dataset of an HDF5 file; each takes the open file, the dataset's name and its shape."""

from __future__ import annotations

import zlib
from typing import Any

Shape = tuple[int, int]


def external_storage(file: Any, name: str, shape: Shape) -> None:
    """Its numbers lie in the file secret.bin."""
    del file[name]
    file.create_dataset(name, shape=shape, dtype="f4", external=[("secret.bin", 0, 4 * shape[0] * shape[1])])


def external_link(file: Any, name: str, shape: Shape) -> None:
    """It is a dataset of the file secret.h5."""
    import h5py  # tests that do without it load this file, too

    del file[name]
    file[name] = h5py.ExternalLink("secret.h5", "/curves")


def virtual(file: Any, name: str, shape: Shape) -> None:
    """It looks into a dataset of the file secret.h5."""
    import h5py

    del file[name]
    layout = h5py.VirtualLayout(shape=shape, dtype="f4")
    layout[:] = h5py.VirtualSource("secret.h5", "curves", shape=shape)
    file.create_virtual_dataset(name, layout)


def sparse(file: Any, name: str, shape: Shape) -> None:
    """It declares 10^15 rows and stores none."""
    del file[name]
    file.create_dataset(name, shape=(10**15, shape[1]), dtype="f4", chunks=(1, shape[1]))


def bomb(file: Any, name: str, shape: Shape, n_bytes: int) -> None:
    """Its one compressed chunk holds far more bytes than it declares."""
    del file[name]
    data = file.create_dataset(name, shape, "f4", chunks=shape, compression="gzip")
    data.id.write_direct_chunk((0, 0), zlib.compress(bytes(n_bytes)))
