"""The head of a numpy file, as `numpy.save` writes it."""

from __future__ import annotations

import io

import numpy as np


def npy_header(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    """Bytes that a little-endian array in C order starts with.

    Parameters
    ----------
    dtype : dtype
        Of the numbers.
    shape : tuple of int
        Of the array.

    Returns
    -------
    bytes
        Magic string, version 1.0 and description.
    """
    buffer = io.BytesIO()
    description = {"descr": dtype.newbyteorder("<").str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, description)
    return buffer.getvalue()
