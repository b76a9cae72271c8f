"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3): the head at once, the particles block by block."""

from __future__ import annotations

import contextlib
import gzip
import os
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np

from aomc_sky.errors import InputFileError, Problem
from aomc_sky.formats.mcpl.header import McplFault, McplHeader, parse_header
from aomc_sky.regular_file import FileKindError, open_regular

BLOCK = 65_536
"""Particles that are read at a time. [about 10 MB with everything unpacked]"""
MAX_FAULTS = 20
_PIECE = 1 << 20
GZIP_MAGIC = b"\x1f\x8b"
MOST_TIMES = 1032
"""How many times as long what deflate unpacks can be: a length of 258 bytes takes two bits."""

_ADVICE = "give the path of an MCPL file"


@dataclass(frozen=True, kw_only=True, slots=True)
class McplParticles:
    """Particles [start, start + n) of a file.

    Parameters
    ----------
    start : int
        Index of the first one in the file.
    energy : ndarray, float64, shape (n,)
        Kinetic energy. [MeV]
    position : ndarray, float64, shape (n, 3)
        x, y, z. [cm]
    direction : ndarray, float64, shape (n, 3)
        Travel direction, unit vector. A component differs by at most 6e-7 from the one that was
        written in single precision with a length within 3e-7 of 1, 1.4e-15 in double precision
        with one within 6e-16.
    time : ndarray, float64, shape (n,)
        Time. [ms]
    weight : ndarray, float64, shape (n,)
        Statistical weight.
    pdg_code : ndarray, int32, shape (n,)
        Kind of particle; 22 is a photon.
    user_flags : ndarray, uint32, shape (n,)
        Flags, 0 where the file has none.
    polarisation : ndarray, float64, shape (n, 3)
        Polarisation vector, 0 where the file has none.
    """

    start: int
    energy: np.ndarray
    position: np.ndarray
    direction: np.ndarray
    time: np.ndarray
    weight: np.ndarray
    pdg_code: np.ndarray
    user_flags: np.ndarray
    polarisation: np.ndarray

    def __len__(self) -> int:
        return int(self.energy.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class McplFile:
    """A file whose head and length have been checked, the length of a compressed one when it is read to its end.

    Parameters
    ----------
    path : Path
        The file.
    header : McplHeader
        What its head says.
    data_start : int
        Where the first record begins, in what a compressed file unpacks to. [bytes]
    is_packed : bool
        Whether it is compressed by gzip.
    """

    path: Path
    header: McplHeader
    data_start: int
    is_packed: bool = False

    def __len__(self) -> int:
        return self.header.n_particles

    def particles(self, start: int = 0, stop: int | None = None) -> McplParticles:
        """Read the particles [start, stop), all of them into memory.

        Parameters
        ----------
        start, stop : int
            Range of indices; None is the end. [0 <= start <= stop <= n_particles]

        Raises
        ------
        InputFileError
            A record is no particle (E805), the file changed since it was opened or holds another number of
            particles (E804), or a compressed file is damaged (E806).
        """
        start, stop = self._range(start, stop)
        return self._particles(self.records(start, stop), start)

    def blocks(self, size: int = BLOCK, start: int = 0, stop: int | None = None) -> Iterator[McplParticles]:
        """Yield the particles [start, stop) in blocks of `size`, the last one shorter; see `particles`.

        A compressed file is unpacked once on the way, and its end is looked at where `stop` is its last particle.
        """
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        start, stop = self._range(start, stop)
        first = start
        for records in self._record_blocks(size, start, stop):
            yield self._particles(records, first)
            first += records.size

    def records(self, start: int, stop: int) -> np.ndarray:
        """The stored records [start, stop) as they are, with the fields of `McplHeader.record`."""
        return next(self._record_blocks(max(stop - start, 1), start, stop), np.empty(0, self.header.record))

    def _range(self, start: int, stop: int | None) -> tuple[int, int]:
        stop = len(self) if stop is None else stop
        if not 0 <= start <= stop <= len(self):
            raise IndexError(f"particles {start} to {stop} do not exist; the file has particles 0 to {len(self)}")
        return start, stop

    def _record_blocks(self, size: int, start: int, stop: int) -> Iterator[np.ndarray]:
        record = self.header.record
        with _faults_named(self.path), opened(self.path) as file:
            file.skip_to(self.data_start + start * record.itemsize)
            for first in range(start, stop, size):
                n = min(size, stop - first)
                # not a memory map: a file that shrinks under a map ends the process
                data = file.read(n * record.itemsize)
                if len(data) != n * record.itemsize:
                    raise _cut(file, first + len(data) // record.itemsize, len(self))
                if first + n == len(self):
                    _require_end(file, len(self))
                yield np.frombuffer(data, record)

    def _particles(self, records: np.ndarray, start: int) -> McplParticles:
        faults = record_faults(records, self.header, start, MAX_FAULTS)
        if faults:
            raise _error(self.path, faults)
        return _unpacked(records, self.header, start)


def read_mcpl(path: str | Path) -> McplFile:
    """Open an MCPL file of format 2 or 3, of either byte order and precision, as it is or packed by gzip.

    Parameters
    ----------
    path : str or Path
        The file. Where there is no ``x.mcpl``, ``x.mcpl.gz`` beside it is taken.

    Returns
    -------
    McplFile
        The head; its `blocks` and `particles` read the records, of a compressed file in a stream.

    Raises
    ------
    InputFileError
        Not an MCPL file (E801, E802), a damaged head (E803), a length that does not fit the number of
        particles (E804; of a compressed file when its end is read), or damage to the compression (E806).
    """
    path = existing_path(Path(path))
    with _faults_named(path), opened(path) as file:
        header, data_start = parse_header(file, file.most_bytes, is_length=not file.is_packed)
        if header.n_particles == 0 and file.is_packed:
            _require_end(file, 0)
        return McplFile(path=path, header=header, data_start=data_start, is_packed=file.is_packed)


def holds(path: Path, head: bytes, n_bytes: int) -> bool:
    """Whether a file is whole, holds or unpacks to so many bytes, and begins with these."""
    try:
        with opened(path) as file:
            begin = file.read(len(head))
            while file.read(_PIECE):
                pass
            return begin == head and file.position == n_bytes
    except McplFault:
        return False


def _cut(file: McplBytes, n_held: int, n: int) -> McplFault:
    if not file.is_packed:
        return McplFault("E804", "particles", "the file became shorter while it was read")
    return McplFault("E804", "particles", f"the header says {n}, the file holds {n_held} records", "make it again")


def _require_end(file: McplBytes, n: int) -> None:
    """Raise where a packed file goes on; at its end gzip compares its check sum."""
    if file.is_packed and file.read(1):
        raise McplFault("E804", "particles", f"the header says {n}, the file goes on after them", "make it again")


def check_mcpl(path: str | Path) -> None:
    """Read a file to its end and raise its problems: those of the head, or of the first records that have any."""
    for _ in read_mcpl(path).blocks():
        pass


@contextlib.contextmanager
def _faults_named(path: Path) -> Iterator[None]:
    """Faults become problems of this file."""
    try:
        yield
    except McplFault as fault:
        raise _error(path, [fault]) from None


def _error(path: Path, faults: list[McplFault]) -> InputFileError:
    return InputFileError(
        [
            Problem(path=str(path), line=0, column=0, code=f.code, field=f.name, message=f.message, advice=f.advice)
            for f in faults
        ]
    )


def _unpacked(records: np.ndarray, header: McplHeader, start: int) -> McplParticles:
    n = records.size
    packed = records["packed"].astype(np.float64)
    energy, direction = unpack(packed, header.version)
    weight = records["weight"].astype(np.float64) if header.weight == 0.0 else np.full(n, header.weight)
    return McplParticles(
        start=start,
        energy=energy,
        position=records["position"].astype(np.float64),
        direction=direction,
        time=records["time"].astype(np.float64),
        weight=weight,
        pdg_code=records["pdg_code"].astype(np.int32)
        if header.pdg_code == 0
        else np.full(n, header.pdg_code, np.int32),
        user_flags=records["user_flags"].astype(np.uint32) if header.has_user_flags else np.zeros(n, np.uint32),
        polarisation=records["polarisation"].astype(np.float64) if header.has_polarisation else np.zeros((n, 3)),
    )


def existing_path(path: Path) -> Path:
    """The file of this name, or the compressed one that stands in its place (``photons.mcpl.gz``)."""
    packed = path.with_name(f"{path.name}.gz") if path.name.lower().endswith(".mcpl") else path
    return packed if packed != path and not os.path.lexists(path) and os.path.exists(packed) else path


class McplBytes:
    """An open file, read from its begin on.

    Of a packed file nothing is known but what was unpacked: pieces are bounded, and its end is its length.
    """

    def __init__(self, file: BinaryIO) -> None:
        size = os.fstat(file.fileno()).st_size
        self.is_packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
        file.seek(0)
        self.most_bytes = (size + 1) * MOST_TIMES if self.is_packed else size
        """Length; of a packed file the most that it can hold. [bytes]"""
        self._file = cast(BinaryIO, gzip.GzipFile(fileobj=file, mode="rb")) if self.is_packed else file
        self.position = 0

    def read(self, n: int) -> bytes:
        """The next bytes, fewer only at the end of the file; McplFault (E806) for a packed one that is damaged."""
        try:
            data = self._file.read(n)
        except EOFError:
            raise McplFault("E806", "", "the compressed file ends in the middle", "it was cut; copy it again") from None
        except (gzip.BadGzipFile, zlib.error) as error:
            reason = str(error).removeprefix("Error ")
            raise McplFault("E806", "", f"the compressed file is damaged: {reason}", "make it again") from None
        self.position += len(data)
        return data

    def skip_to(self, position: int) -> None:
        """Go to a byte further on; a packed file is unpacked on the way."""
        if not self.is_packed:
            self._file.seek(position)
            self.position = position
            return
        while self.position < position and self.read(min(_PIECE, position - self.position)):
            pass


@contextlib.contextmanager
def opened(path: Path) -> Iterator[McplBytes]:
    """A regular file, McplFault (E801) where there is none; a pipe, a device or a folder would block or never end."""
    try:
        file = open_regular(path)
    except FileKindError:
        raise McplFault("E801", "", "not a regular file", _ADVICE) from None
    except OSError as error:
        raise McplFault("E801", "", f"the file cannot be opened: {error.strerror or error}", _ADVICE) from None
    with file:
        yield McplBytes(file)


DIRECTION_TOLERANCE = 1e-5
"""How far the squares of a direction may be from 1, as libmcpl has it."""


def unpack(packed: np.ndarray, version: int) -> tuple[np.ndarray, np.ndarray]:
    """Energies [MeV] (n,) and unit vectors (n, 3) of packed triples (n, 3), float64.

    A triple is two numbers of the direction, octahedral in version 2 and an adaptive projection in version 3, and the
    energy with the sign of the third.
    """
    return (_octahedral if version == 2 else _adaptive)(packed)


def _adaptive(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smaller components as they are, with 1/z in the place of the largest; its sign is that of the energy."""
    a, b, c = packed.T
    is_x, is_y = np.abs(a) > 1.0, np.abs(b) > 1.0
    is_y &= ~is_x
    first = np.where(is_x, b, a)
    with np.errstate(divide="ignore"):
        second = np.where(is_x, 1.0 / a, np.where(is_y, 1.0 / b, b))
    largest = np.copysign(np.sqrt(np.maximum(0.0, 1.0 - (first * first + second * second))), c)
    direction = np.empty_like(packed)
    direction[:, 0] = np.where(is_x, largest, a)
    direction[:, 1] = np.where(is_y, largest, b)
    direction[:, 2] = np.where(is_x | is_y, second, largest)
    return np.abs(c), direction


def _octahedral(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = packed.T
    z = 1.0 - np.abs(a) - np.abs(b)
    is_lower = z < 0
    x = np.where(is_lower, (1.0 - np.abs(b)) * np.where(a >= 0.0, 1.0, -1.0), a)
    y = np.where(is_lower, (1.0 - np.abs(a)) * np.where(b >= 0.0, 1.0, -1.0), b)
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    direction = np.stack([x * scale, y * scale, z * scale], axis=-1)
    direction[np.signbit(c), 2] = 0.0  # the sign of the energy marks a horizontal direction
    return np.abs(c), direction


def record_faults(records: np.ndarray, header: McplHeader, start: int, limit: int) -> list[McplFault]:
    """What is wrong with stored records, at most `limit` faults in their order; `start` is the index of the first."""
    faults: list[tuple[int, str, str]] = []
    for name in ("polarisation", "position", "time", "weight"):
        if name in (records.dtype.names or ()) and not _is_surely_finite(records[name]):
            is_bad = ~np.isfinite(records[name])
            faults += _first(is_bad.any(axis=1) if is_bad.ndim == 2 else is_bad, name, "not a finite number", limit)
    first, second, energy = (records["packed"][:, k].astype(np.float64) for k in range(3))
    faults += _first(~np.isfinite(energy), "energy", "not a finite number", limit)
    faults += _first(_no_direction(first, second, header.version), "direction", "not a unit vector", limit)
    faults.sort()
    return [McplFault("E805", name, f"record {start + k}: {what}") for k, name, what in faults[:limit]]


def _is_surely_finite(values: np.ndarray) -> bool:
    """Whether a look at the sum says so, which spares the look at each; a sum of large numbers says nothing."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(values.sum(dtype=np.float64)))


def _first(is_bad: np.ndarray, name: str, what: str, limit: int) -> list[tuple[int, str, str]]:
    return [(int(k), name, what) for k in np.flatnonzero(is_bad)[:limit]]


def _no_direction(a: np.ndarray, b: np.ndarray, version: int) -> np.ndarray:
    """Whether the two numbers of a direction come from no unit vector; also where one is not a number."""
    if version == 2:
        return ~((np.abs(a) <= 1.0 + DIRECTION_TOLERANCE) & (np.abs(b) <= 1.0 + DIRECTION_TOLERANCE))
    is_x = np.abs(a) > 1.0
    is_y = ~is_x & (np.abs(b) > 1.0)
    with np.errstate(divide="ignore", over="ignore"):  # 1/z is infinite where z is 0
        first, second = np.where(is_x, 1.0 / a, a), np.where(is_y, 1.0 / b, b)
        return ~(first * first + second * second <= 1.0 + DIRECTION_TOLERANCE)
