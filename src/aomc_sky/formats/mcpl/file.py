"""MCPL files: read by the package `mcpl` of the format's authors; length and records are checked here."""

from __future__ import annotations

import contextlib
import gzip
import io
import math
import os
import shutil
import struct
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from aomc_sky.errors import NOWHERE, InputFileError, OutputError
from aomc_sky.extras import optional_module
from aomc_sky.formats.mcpl.header import COUNT_OFFSET, MAGIC, VERSIONS, McplHeader
from aomc_sky.formats.text_file import open_data, refuse
from aomc_sky.record import same_content, short_repr

EXTRA = "mcpl"
BLOCK = 65_536
"""Particles that are read at a time."""
MAX_FAULTS = 20
FIXED_BYTES = 48
"""Length of the part that every head has. [bytes]"""
MAX_HEAD_BYTES = 2**24
MAX_TEXTS = 10_000
"""Comments and blobs that a head may have: the library reads 50 000 in a second."""
DIRECTION_TOLERANCE = 1e-5
"""How far the squares of a direction may be from 1, as libmcpl has it."""
GZIP_MAGIC = b"\x1f\x8b"
_BEGINNINGS = {MAGIC + b"%03d" % version + order for version in VERSIONS for order in (b"L", b"B")}
_WHAT = "an MCPL file"
_PIECE = 1 << 20
_AGAIN = "make it again"
_CUT = "the file is damaged or was cut; make it again"


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class McplParticles:
    """Particles [start, start + n) of a file."""

    start: int  #: Index of the first one in the file
    energy: np.ndarray  #: float64 (n,), kinetic energy. [MeV]
    position: np.ndarray  #: float64 (n, 3), x, y, z. [cm]
    #: float64 (n, 3), travel direction, unit vector. A component differs by at most 7e-7 from the one that was written
    #: in single precision with a length within 3.5e-7 of 1, 2e-15 in double precision with one within 8.5e-16.
    direction: np.ndarray
    time: np.ndarray  #: float64 (n,), time. [ms]
    weight: np.ndarray  #: float64 (n,), statistical weight
    pdg_code: np.ndarray  #: int32 (n,), kind of particle; 22 is a photon
    user_flags: np.ndarray  #: uint32 (n,), flags, 0 where the file has none
    polarisation: np.ndarray  #: float64 (n, 3), polarisation vector, 0 where the file has none

    __eq__ = same_content
    __repr__ = short_repr

    def __len__(self) -> int:
        return int(self.energy.size)


_COLUMNS = tuple(name for name in McplParticles.__slots__ if name != "start")


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class McplFile:
    """A file whose head and length have been checked.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform")
    >>> _ = sky.write_mcpl(scene.source(seed=1), "photons.mcpl")
    >>> file = sky.files.read_mcpl("photons.mcpl")
    >>> len(file), file.particles(0, 10).direction.shape
    (1000, (10, 3))
    """

    path: Path  #: The file
    header: McplHeader  #: Its head
    data_start: int  #: Offset of the first record in the unpacked file. [bytes]
    is_packed: bool = False  #: Whether it is compressed by gzip

    __eq__ = same_content
    __repr__ = short_repr

    def __len__(self) -> int:
        return self.header.n_particles

    def particles(self, start: int = 0, stop: int | None = None) -> McplParticles:
        """Read the particles [start, stop) into memory; those before them are read too. A stop of None is the end.

        InputFileError: a record is not a particle (E805), or the file changed since it was opened (E804).
        """
        parts = list(self.blocks(BLOCK, start, stop)) or [_no_particles(start)]
        if len(parts) == 1:
            return parts[0]
        columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS}
        return McplParticles(start=start, **columns)

    def blocks(self, size: int = BLOCK, start: int = 0, stop: int | None = None) -> Iterator[McplParticles]:
        """Yield the particles [start, stop) in blocks that end at multiples of `size`; see `particles`."""
        if size < 1:
            raise ValueError(f"size must be at least 1, got {size}")
        stop = len(self) if stop is None else stop
        if not 0 <= start <= stop <= len(self):
            raise IndexError(f"particles {start} to {stop} do not exist; the file has particles 0 to {len(self)}")
        if start == stop:
            return
        with contextlib.ExitStack() as stack:
            copy = self.path
            if self.is_packed:  # the library could read packed files by name, but it would leave them open
                packed = stack.enter_context(open_data(self.path, what=_WHAT, code="E801"))
                copy = stack.enter_context(_copied(self.path, _unpacking(packed)))
            file = stack.enter_context(_library_file(self.path, copy, size))
            for first in range(0, stop, size):
                with np.errstate(all="ignore"):  # of numbers that no particle has
                    part_rows = slice(max(start - first, 0), min(stop - first, size))
                    try:
                        block = file.read_block()
                        part = _unpacked(block, part_rows, first + part_rows.start) if part_rows.start < size else None
                    except Exception:  # the library raises its own errors and Python's
                        message = "the file became shorter while it was read"
                        raise _fault(self.path, "E804", message, _AGAIN, "particles") from None
                    if part is not None:
                        _check(self.path, part)
                        yield part


def read_mcpl(path: str | Path) -> McplFile:
    """Open an MCPL file of format 2 or 3, of either byte order and precision, as it is or packed by gzip.

    Parameters
    ----------
    path : str or Path
        The file. Where there is no ``x.mcpl``, ``x.mcpl.gz`` beside it is taken.

    Returns
    -------
    McplFile
        The head; its `blocks` and `particles` read the records.

    Raises
    ------
    InputFileError
        Not an MCPL file (E801, E802), a damaged head (E803), a length that does not fit the number of
        particles (E804), or damage to the compression (E806). A compressed file is unpacked to its end to know.
    MissingExtraError
        The package mcpl is not installed: ``pip install ".[mcpl]"``.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform")
    >>> sky.write_mcpl(scene.source(), "photons.mcpl")
    >>> len(sky.files.read_mcpl("photons.mcpl"))
    100
    """
    optional_module("mcpl", extra=EXTRA)
    path = Path(path)
    if path.name.lower().endswith(".mcpl") and not os.path.lexists(path):
        packed = path.with_name(f"{path.name}.gz")
        path = packed if os.path.exists(packed) else path
    with open_data(path, what=_WHAT, code="E801") as file, _damage_named(path):
        is_packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
        file.seek(0)
        stream = _unpacking(file) if is_packed else file
        start = stream.read(MAX_HEAD_BYTES)
        header, data_start = _header(path, start)
        found = len(start) - data_start
        if is_packed:
            found += _length_of_rest(stream, header.n_particles * header.record.itemsize - found)
        else:
            found = os.fstat(file.fileno()).st_size - data_start
        _require_length(path, header, found, is_packed=is_packed)
    return McplFile(path=path, header=header, data_start=data_start, is_packed=is_packed)


def check_mcpl(path: str | Path) -> None:
    """Read a file to its end and raise its problems: those of the head, or of the first records that have any."""
    for _ in read_mcpl(path).blocks():
        pass


def _header(path: Path, start: bytes) -> tuple[McplHeader, int]:
    """The head as the library reads it from the first bytes of the unpacked file, and its length. [bytes]

    The library believes every number of a head. It gets these bytes alone, and only if the head has few texts.
    """
    if start[:2] == GZIP_MAGIC:
        raise _fault(path, "E802", "the file is compressed with gzip twice", "run gunzip on it once")
    if start[:8] not in _BEGINNINGS:
        message = f"an MCPL file begins with 'MCPL', 002 or 003, and L or B, this one with {repr(start[:8])[1:]}"
        raise _fault(path, "E802", message, "name an MCPL file of format 2 or 3")
    if len(start) < FIXED_BYTES:
        raise _fault(path, "E803", "the file ends in its header", _CUT)
    order = "<" if start[7:8] == b"L" else ">"
    n_particles, n_comments, n_blobs = struct.unpack_from(f"{order}QII", start, COUNT_OFFSET)
    if n_comments + 2 * n_blobs > MAX_TEXTS:
        message = f"the header says {n_comments} comments and {n_blobs} blobs, more than {MAX_TEXTS} texts"
        raise _fault(path, "E803", message, _CUT, "comments")
    with _copied(path, io.BytesIO(start)) as copy, _library_file(path, copy, BLOCK) as file:
        header = McplHeader(
            n_particles=n_particles,  # the library would count the records of a file that was not closed
            source=file.sourcename,
            comments=tuple(file.comments),
            blobs=tuple((key, file.blobs[key]) for key in file.blob_storage_order),
            has_user_flags=file.opt_userflags,
            has_polarisation=file.opt_polarisation,
            is_double=not file.opt_singleprec,
            pdg_code=file.opt_universalpdgcode,
            weight=file.opt_universalweight,
            version=file.version,
            is_little_endian=file.endianness == "L",
        )
        if not 0.0 <= header.weight < math.inf:
            message = f"the weight of all particles is positive and finite, got {header.weight}"
            raise _fault(path, "E803", message, _CUT, "weight")
        length, own = file.particlesize, header.record.itemsize
        if length != own:
            message = f"the header says {length} bytes for a record, its fields have {own}"
            raise _fault(path, "E803", message, _CUT, "particle size")
        return header, file.headersize


def _require_length(path: Path, header: McplHeader, found: int, *, is_packed: bool) -> None:
    """Refuse a file with `found` bytes of records, if its number of particles asks for another length."""
    n_bytes = header.n_particles * header.record.itemsize
    if found == n_bytes:
        return
    held, rest = divmod(found, header.record.itemsize)
    contents = f"{held} records" + (f" and {rest} bytes" if rest else "")
    if is_packed and found > n_bytes:  # the rest was not unpacked
        contents = "more"
    advice = "the file was not closed; mcpltool --repair sets the number" if header.n_particles == 0 else _CUT
    message = f"the header says {header.n_particles}, the file holds {contents}"
    raise _fault(path, "E804", message, advice, "particles")


def _unpacking(packed: BinaryIO) -> BinaryIO:
    return cast(BinaryIO, gzip.GzipFile(fileobj=packed, mode="rb"))


def _length_of_rest(stream: BinaryIO, most: int) -> int:
    """How many bytes are left, or one more than `most`."""
    n_bytes = 0
    while n_bytes <= most and (piece := stream.read(min(_PIECE, most + 1 - n_bytes))):
        n_bytes += len(piece)
    return n_bytes


@contextlib.contextmanager
def _damage_named(path: Path) -> Iterator[None]:
    """Damage to what gzip has packed becomes a problem of this file."""
    try:
        yield
    except EOFError:
        message = "the compressed file ends in the middle"
        raise _fault(path, "E806", message, "it was cut; copy it again") from None
    except (gzip.BadGzipFile, zlib.error) as error:
        reason = str(error).removeprefix("Error ")
        raise _fault(path, "E806", f"the compressed file is damaged: {reason}", _AGAIN) from None


@contextlib.contextmanager
def _copied(path: Path, unpacked: BinaryIO) -> Iterator[Path]:
    """A temporary copy of `path`, or of its beginning: the library opens files by name alone."""
    try:
        folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
    except OSError as error:
        raise OutputError(f"cannot make a temporary folder to read {path}: {error.strerror or error}") from error
    with folder as name:
        copy = Path(name, "copy.mcpl")
        try:
            with _damage_named(path), copy.open("wb") as file:
                shutil.copyfileobj(unpacked, file, _PIECE)
        except OSError as error:
            raise OutputError(f"cannot unpack {path} to {copy}: {error.strerror or error}") from error
        yield copy


@contextlib.contextmanager
def _library_file(path: Path, copy: Path, size: int) -> Iterator[Any]:
    """A file opened by the library, whose prints are dropped; `path` is its name in messages."""
    mcpl = optional_module("mcpl", extra=EXTRA)
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            opened = mcpl.MCPLFile(os.fspath(copy), blocklength=size)
        except Exception as error:  # the library raises its own errors and Python's, whatever the damage is
            reason = str(error) or type(error).__name__
            raise _fault(path, "E803", f"the library of MCPL cannot read it: {reason}", _CUT) from None
    with opened as file:
        yield file


def _unpacked(block: Any, part_rows: slice, start: int) -> McplParticles:
    """Copies of some particles of a block, because the library uses its arrays again."""
    real = {
        "energy": block.ekin,
        "position": block.position,
        "direction": block.direction,
        "time": block.time,
        "weight": block.weight,
        "polarisation": block.polarisation,
    }
    return McplParticles(
        start=start,
        pdg_code=block.pdgcode[part_rows].astype(np.int32),
        user_flags=block.userflags[part_rows].astype(np.uint32),
        **{name: values[part_rows].astype(np.float64) for name, values in real.items()},
    )


def _no_particles(start: int) -> McplParticles:
    numbers, vectors = np.empty(0), np.empty((0, 3))
    return McplParticles(
        start=start, energy=numbers, position=vectors, direction=vectors, time=numbers, weight=numbers,
        pdg_code=np.empty(0, np.int32), user_flags=np.empty(0, np.uint32), polarisation=vectors,
    )  # fmt: skip


def _check(path: Path, part: McplParticles) -> None:
    """Raise for records that are no particles, the first `MAX_FAULTS` in their order."""
    faults: list[tuple[int, str, str]] = []
    for name in ("polarisation", "position", "time", "weight", "energy"):
        is_good = np.isfinite(getattr(part, name))
        is_good = is_good.all(axis=1) if is_good.ndim == 2 else is_good
        faults += [(int(k), name, "not a finite number") for k in np.flatnonzero(~is_good)[:MAX_FAULTS]]
    length = np.square(part.direction).sum(axis=1)
    is_bad = ~(length <= 1.0 + DIRECTION_TOLERANCE)  # format 2 has shorter ones, which libmcpl reads
    faults += [(int(k), "direction", "not a unit vector") for k in np.flatnonzero(is_bad)[:MAX_FAULTS]]
    if faults:
        found = sorted(faults)[:MAX_FAULTS]
        texts = [(f"record {part.start + k}: {message}", name) for k, name, message in found]
        raise InputFileError([NOWHERE.problem(str(path), "E805", text, field=name) for text, name in texts])


def _fault(path: Path, code: str, message: str, advice: str = "", name: str = "") -> InputFileError:
    return refuse(path, message, code=code, advice=advice, name=name)
