"""The head of an MCPL file: what it says, its bytes, and the layout of the records behind it."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

MAGIC = b"MCPL"
VERSIONS = (2, 3)
COUNT_OFFSET = 8
"""Where the number of particles stands. [bytes]"""
FIXED_BYTES = 48
"""Length of the part that every head has. [bytes]"""
MAX_TEXT = 65_535
"""Longest comment or name that libmcpl writes; it cuts the rest off. [bytes]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class McplHeader:
    """What the head of an MCPL file says.

    Parameters
    ----------
    n_particles : int
        Records in the file. [0 to 2^64 - 1]
    source : str
        Name of the program that made the file.
    comments : tuple of str
        Text for persons; what is not UTF-8 is replaced when it is read.
    blobs : tuple of (str, bytes)
        Data under a key each.
    has_user_flags, has_polarisation : bool
        Whether records carry them.
    is_double : bool
        Floats are float64, otherwise float32.
    pdg_code : int
        Kind of all particles (22 is a photon), 0 where every record has its own.
    weight : float
        Weight of all particles, 0.0 where every record has its own.
    version : int
        Version of the format, which tells how directions are packed. [2 or 3]
    is_little_endian : bool
        Order of the bytes of every number.
    """

    n_particles: int
    source: str = "unknown"
    comments: tuple[str, ...] = ()
    blobs: tuple[tuple[str, bytes], ...] = ()
    has_user_flags: bool = False
    has_polarisation: bool = False
    is_double: bool = False
    pdg_code: int = 0
    weight: float = 0.0
    version: int = 3
    is_little_endian: bool = True

    @property
    def record(self) -> np.dtype:
        """Type of a record: fields `polarisation`, `position`, `packed`, `time`, `weight`, `pdg_code`, `user_flags`."""
        order = "<" if self.is_little_endian else ">"
        real = np.dtype(f"{order}f{8 if self.is_double else 4}")
        triple: tuple[np.dtype, tuple[int, ...]] = (real, (3,))
        fields = [
            (self.has_polarisation, "polarisation", *triple),
            (True, "position", *triple),
            (True, "packed", *triple),
            (True, "time", real, ()),
            (self.weight == 0.0, "weight", real, ()),
            (self.pdg_code == 0, "pdg_code", np.dtype(f"{order}i4"), ()),
            (self.has_user_flags, "user_flags", np.dtype(f"{order}u4"), ()),
        ]
        return np.dtype([(name, kind, shape) for is_there, name, kind, shape in fields if is_there])


def encode_header(header: McplHeader) -> bytes:
    """Bytes of a head, as libmcpl writes it.

    Parameters
    ----------
    header : McplHeader
        What the head shall say; comments and names of at most `MAX_TEXT` bytes.
    """
    order = "<" if header.is_little_endian else ">"
    numbers = struct.pack(
        f"{order}QIIIIIiII",
        header.n_particles,
        len(header.comments),
        len(header.blobs),
        header.has_user_flags,
        header.has_polarisation,
        not header.is_double,
        header.pdg_code,
        header.record.itemsize,
        header.weight != 0.0,
    )
    weight = struct.pack(f"{order}d", header.weight) if header.weight != 0.0 else b""
    texts = [header.source, *header.comments, *(key for key, _ in header.blobs)]
    pieces = [*(_text(text) for text in texts), *(data for _, data in header.blobs)]
    start = MAGIC + f"{header.version:03d}{'L' if header.is_little_endian else 'B'}".encode()
    return start + numbers + weight + b"".join(struct.pack(f"{order}I", len(p)) + p for p in pieces)


def _text(text: str) -> bytes:
    data = text.encode()
    if len(data) > MAX_TEXT or b"\0" in data:
        raise ValueError(f"texts in the head have at most {MAX_TEXT} bytes and no NUL, got {len(data)} bytes")
    return data
