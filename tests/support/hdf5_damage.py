"""What a hostile hand does to an HDF5 file.

To one of its datasets: the first functions take the open file, the dataset's name and its shape. To its bytes: the
others take the path of a good file.
"""

import zlib
from pathlib import Path

import numpy as np


def external_storage(file, name, shape):
    """Its numbers lie in the file secret.bin."""
    del file[name]
    file.create_dataset(name, shape=shape, dtype="f4", external=[("secret.bin", 0, 4 * shape[0] * shape[1])])


def external_link(file, name, shape):
    """It is a dataset of the file secret.h5."""
    import h5py  # tests that do without it load this file, too

    del file[name]
    file[name] = h5py.ExternalLink("secret.h5", "/curves")


def virtual(file, name, shape):
    """It looks into a dataset of the file secret.h5."""
    import h5py

    del file[name]
    layout = h5py.VirtualLayout(shape=shape, dtype="f4")
    layout[:] = h5py.VirtualSource("secret.h5", "curves", shape=shape)
    file.create_virtual_dataset(name, layout)


def sparse(file, name, shape):
    """It declares 10^15 rows and stores none."""
    del file[name]
    file.create_dataset(name, shape=(10**15, shape[1]), dtype="f4", chunks=(1, shape[1]))


def bomb(file, name, shape, n_bytes):
    """Its one compressed chunk holds far more bytes than it declares."""
    del file[name]
    data = file.create_dataset(name, shape, "f4", chunks=shape, compression="gzip")
    data.id.write_direct_chunk((0, 0), zlib.compress(bytes(n_bytes)))


def write_secrets(shape):
    """The files of other people that links and external storage lead to."""
    import h5py

    values = np.full(shape, 123.0, "f4")
    with h5py.File("secret.h5", "w") as file:
        file["curves"] = values
    Path("secret.bin").write_bytes(values.tobytes())


def cut(path):
    """It ends after 3000 bytes."""
    path.write_bytes(path.read_bytes()[:3000])


def random_bytes(path):
    """It holds no byte of its own."""
    path.write_bytes(np.random.default_rng(5).bytes(50_000))


def random_bytes_behind_the_signature(path):
    """Only its signature is left."""
    path.write_bytes(path.read_bytes()[:8] + np.random.default_rng(6).bytes(50_000))


def empty(path):
    """It has no byte."""
    path.write_bytes(b"")
