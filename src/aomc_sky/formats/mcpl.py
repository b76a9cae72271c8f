"""MCPL files (Monte Carlo Particle Lists, formats 2 and 3): the head at once, the particles block by block."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from aomc_sky.errors import InputFileError, Problem
from aomc_sky.formats.mcpl_directions import unpack
from aomc_sky.formats.mcpl_header import McplHeader
from aomc_sky.formats.mcpl_parse import McplFault, parse_header
from aomc_sky.formats.mcpl_records import record_faults

BLOCK = 65_536
"""Particles that are read at a time. [about 10 MB with everything unpacked]"""
MAX_FAULTS = 20


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
    """A file whose head and length have been checked; nothing is held open.

    Parameters
    ----------
    path : Path
        The file.
    header : McplHeader
        What its head says.
    data_start : int
        Where the first record begins. [bytes]
    """

    path: Path
    header: McplHeader
    data_start: int

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
            A record is no particle (E805), or the file changed since it was opened (E804).
        """
        stop = len(self) if stop is None else stop
        if not 0 <= start <= stop <= len(self):
            raise IndexError(f"particles {start} to {stop} do not exist; the file has particles 0 to {len(self)}")
        records = self.records(start, stop)
        faults = record_faults(records, self.header, start, MAX_FAULTS)
        if faults:
            raise _error(self.path, faults)
        return _unpacked(records, self.header, start)

    def blocks(self, size: int = BLOCK) -> Iterator[McplParticles]:
        """Yield all particles in blocks of `size`, the last one shorter; see `particles`."""
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        for start in range(0, len(self), size):
            yield self.particles(start, min(start + size, len(self)))

    def records(self, start: int, stop: int) -> np.ndarray:
        """The stored records [start, stop) as they are, with the fields of `McplHeader.record`."""
        record = self.header.record
        with _opened(self.path) as (file, _):
            file.seek(self.data_start + start * record.itemsize)
            # not a memory map: a file that shrinks under a map ends the process
            data = file.read((stop - start) * record.itemsize)
        if len(data) != (stop - start) * record.itemsize:
            raise _error(self.path, [McplFault("E804", "particles", "the file became shorter while it was read")])
        return np.frombuffer(data, record) if data else np.empty(0, record)


def read_mcpl(path: str | Path) -> McplFile:
    """Open an MCPL file of format 2 or 3, of either byte order and precision.

    Parameters
    ----------
    path : str or Path
        The file, not compressed.

    Returns
    -------
    McplFile
        The head; its `blocks` and `particles` read the records.

    Raises
    ------
    InputFileError
        Not an MCPL file (E801, E802), a damaged head (E803), or a length that does not fit the
        number of particles (E804).
    """
    path = Path(path)
    with _opened(path) as (file, size):
        try:
            header, data_start = parse_header(file, size)
        except McplFault as fault:
            raise _error(path, [fault]) from None
    return McplFile(path=path, header=header, data_start=data_start)


def check_mcpl(path: str | Path) -> None:
    """Read a file to its end and raise its problems: those of the head, or of the first records that have any."""
    for _ in read_mcpl(path).blocks():
        pass


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[tuple[BinaryIO, int]]:
    """A regular file and its size; a pipe, a device or a folder would block or never end."""
    advice = "give the path of an MCPL file"
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise _error(path, [McplFault("E801", "", f"the file cannot be opened: {reason}", advice)]) from None
    status = os.fstat(handle)
    if not stat.S_ISREG(status.st_mode):
        os.close(handle)
        raise _error(path, [McplFault("E801", "", "not a regular file", advice)])
    with os.fdopen(handle, "rb") as file:
        yield file, status.st_size


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


__all__ = ["McplFile", "McplHeader", "McplParticles", "check_mcpl", "read_mcpl"]
