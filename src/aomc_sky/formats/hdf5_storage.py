"""Checks of an HDF5 file before its data are read: that they are in this file, and how large they can be.

h5py runs in this process, so these checks do not protect against a file that attacks h5py itself.
"""

from __future__ import annotations

import math
import zlib
from importlib import import_module
from typing import Any

UNPACKED_BYTES = 64 << 20
"""Bytes that a file may declare beyond a multiple of its size. [bytes]"""
HARMLESS_BYTES = 16 << 20
"""A compressed chunk of at most this unpacked size is not inspected. [bytes]"""
_MOST_TIMES = 1032  # deflate: a length of 258 bytes takes two bits
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3


class RefusedError(Exception):
    """Data that are not read: code, what was found, what to write."""

    def __init__(self, code: str, message: str, advice: str) -> None:
        self.code, self.message, self.advice = code, message, advice
        super().__init__(message)


def allowed_bytes(n_bytes_of_file: int) -> int:
    """Bytes that a file of this size may declare: numbers pack to a half or a quarter, seldom to less."""
    return min(100 * n_bytes_of_file, 4 * n_bytes_of_file + UNPACKED_BYTES)


def declared_bytes(item: Any) -> int:
    """Bytes that a dataset or an attribute declares, as an exact whole number; 0 for one without values."""
    return math.prod(item.shape) * int(item.dtype.itemsize) if item.shape is not None else 0


def require_hard_link(group: Any, name: str) -> None:
    """Refuse a link to a name or to another file before it is followed (E502)."""
    h5py = import_module("h5py")  # an extra
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise RefusedError(
            "E502",
            "a link to a name or to another file; only data in this file itself are read",
            "copy the data into the file (h5copy -f soft,ext)",
        )


def require_own_data(dataset: Any) -> None:
    """Refuse a dataset whose numbers lie in another file (E502)."""
    if dataset.is_virtual or dataset.external:
        raise RefusedError("E502", "its data are in another file", "write the data into the file (h5repack)")


def require_size(n_bytes: int, budget: int, allowed: int, what: str) -> None:
    """Refuse data larger than the rest of the budget of the file (E503)."""
    if n_bytes > budget:
        raise RefusedError(
            "E503",
            f"{what} of {n_bytes} bytes is declared; of a file of this size {allowed} bytes in all are read",
            "write only the rows that the file has, with less compression (h5repack -f NONE)",
        )


def require_plain_chunks(dataset: Any, allowed: int) -> None:
    """Refuse filters other than gzip, shuffle and fletcher32, and chunks that unpack to more than they declare (E503).

    A filter is code of others, and gzip packs zeros a thousandfold.
    """
    plan = dataset.id.get_create_plist()
    filters = [plan.get_filter(k)[0] for k in range(plan.get_nfilters())]
    rest = [f for f in filters if f != _SHUFFLE]
    if len(filters) > 3 or rest not in ([], [_DEFLATE], [_DEFLATE, _FLETCHER32], [_FLETCHER32]):
        advice = "h5repack -f GZIP=6, or -f NONE"
        raise RefusedError("E503", f"filters {filters}; gzip with shuffle and fletcher32 are read", advice)
    if dataset.chunks is None:
        return
    n_bytes = math.prod(dataset.chunks) * int(dataset.dtype.itemsize)
    require_size(n_bytes, allowed, allowed, "a chunk")
    if _DEFLATE not in filters:
        return
    chunks: list[Any] = []
    dataset.id.chunk_iter(chunks.append)
    for chunk in chunks:
        is_packed = not chunk.filter_mask & (1 << filters.index(_DEFLATE))
        if is_packed and _MOST_TIMES * chunk.size > max(n_bytes, HARMLESS_BYTES):
            require_size(chunk.size, allowed, allowed, "a stored chunk")
            _, data = dataset.id.read_direct_chunk(chunk.chunk_offset)
            if len(zlib.decompressobj().decompress(data, n_bytes + 1)) > n_bytes:
                message = "a compressed chunk holds more bytes than it declares"
                raise RefusedError("E503", message, "make the file again")
