"""MCPL files: checked here, then read block by block by the package `mcpl` of the format's authors."""

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
from aomc_sky.formats.mcpl.header import MAGIC, VERSIONS, McplHeader
from aomc_sky.formats.text_file import open_data, refuse
from aomc_sky.record import same_content, short_repr

EXTRA = "mcpl"
BLOCK = 65_536
"""Particles that are read at a time."""
MAX_FAULTS = 20
FIXED_BYTES = 48
"""Length of the part that every head has. [bytes]"""
MAX_HEAD_BYTES = 2**24
MAX_TEXTS = 100_000
"""Comments and blobs that a head may have."""
DIRECTION_TOLERANCE = 1e-5
"""How far the squares of a direction may be from 1, as libmcpl has it."""
GZIP_MAGIC = b"\x1f\x8b"
MOST_TIMES = 1032
"""Largest ratio of unpacked to packed length with deflate: two bits stand for 258 bytes."""
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
    >>> file = sky.read_mcpl("photons.mcpl")
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
        with _library_file(self, size) as file:
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
    >>> len(sky.read_mcpl("photons.mcpl"))
    100
    """
    optional_module("mcpl", extra=EXTRA)
    path = Path(path)
    packed = path.with_name(f"{path.name}.gz")
    if path.name.lower().endswith(".mcpl") and not os.path.lexists(path) and os.path.exists(packed):
        path = packed
    with open_data(path, what="an MCPL file", code="E801") as file:
        size = os.fstat(file.fileno()).st_size
        is_packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
        file.seek(0)
        if not is_packed:
            head = _Head(path, file, size)
            head.require_length(size)
        else:
            with _damage_named(path):
                stream = cast(BinaryIO, gzip.GzipFile(fileobj=file, mode="rb"))
                head = _Head(path, stream, MOST_TIMES * (size + 1))
                head.require_packed_length(stream)
    return McplFile(path=path, header=head.header, data_start=head.position, is_packed=is_packed)


def check_mcpl(path: str | Path) -> None:
    """Read a file to its end and raise its problems: those of the head, or of the first records that have any."""
    for _ in read_mcpl(path).blocks():
        pass


class _Head:
    """The head, and the length of the file that follows from it: the library does not check them."""

    def __init__(self, path: Path, file: BinaryIO, most_bytes: int) -> None:
        self.path, self.file, self.most_bytes, self.position = path, file, most_bytes, 0
        version, self.order = self._version_and_order()
        form = f"{self.order}QIIIIIiII"
        numbers = struct.unpack(form, self._take(FIXED_BYTES - 8, "the first 48 bytes"))
        n, n_comments, n_blobs, flags, polarised, single, pdg, length, weighed = numbers
        for name, value in (
            ("user flags", flags),
            ("polarisation", polarised),
            ("precision", single),
            ("weight", weighed),
        ):
            if value not in (0, 1):
                raise _fault(path, "E803", f"the switch is 0 or 1, got {value}", _CUT, name)
        weight = struct.unpack(f"{self.order}d", self._take(8, "weight"))[0] if weighed else 0.0
        if weighed and not (math.isfinite(weight) and weight > 0):
            message = f"the weight of all particles is positive and finite, got {weight}"
            raise _fault(path, "E803", message, _CUT, "weight")
        n_texts = n_comments + 2 * n_blobs
        if 4 * (n_texts + 1) > min(most_bytes, MAX_HEAD_BYTES) - self.position or n_texts > MAX_TEXTS:
            message = f"the header says {n_comments} comments and {n_blobs} blobs, more than it can hold"
            raise _fault(path, "E803", message, _CUT, "comments")
        source = self._text("name of the source")
        comments = tuple(self._text(f"comment {k}") for k in range(n_comments))
        keys = [self._text(f"key {k}") for k in range(n_blobs)]
        self.header = McplHeader(
            n_particles=n,
            source=source,
            comments=comments,
            blobs=tuple((key, self._piece(f"blob {key!r}")) for key in keys),
            has_user_flags=bool(flags),
            has_polarisation=bool(polarised),
            is_double=not single,
            pdg_code=pdg,
            weight=weight,
            version=version,
            is_little_endian=self.order == "<",
        )
        self.record_bytes = self.header.record.itemsize
        if length != self.record_bytes:
            message = f"the header says {length} bytes for a record, its fields have {self.record_bytes}"
            raise _fault(path, "E803", message, _CUT, "particle size")

    def _version_and_order(self) -> tuple[int, str]:
        start = self.file.read(8)
        self.position = len(start)
        if start[:2] == GZIP_MAGIC:
            raise _fault(self.path, "E802", "the file is compressed with gzip twice", "run gunzip on it once")
        if start[:4] != MAGIC:
            begin = repr(start[:4])[1:] if start else "nothing"
            message = f"an MCPL file begins with 'MCPL', this one with {begin}"
            raise _fault(self.path, "E802", message, "name an MCPL file")
        digits, order = start[4:7], start[7:8]
        if len(start) == 8 and digits not in [b"%03d" % version for version in VERSIONS]:
            shown = digits.decode("ascii", "backslashreplace")
            raise _fault(self.path, "E802", f"versions 002 and 003 can be read, this is {shown!r}", name="version")
        if len(start) == 8 and order not in (b"L", b"B"):
            message = f"expected L or B in byte 8, got {repr(order)[1:]}"
            raise _fault(self.path, "E802", message, _CUT, "byte order")
        return (int(digits) if len(start) == 8 else 0), ("<" if order == b"L" else ">")

    def _take(self, n: int, name: str) -> bytes:
        left = self.most_bytes - self.position
        if n > left:
            raise _fault(self.path, "E803", f"expected {n} bytes, but {left} bytes are left in the file", _CUT, name)
        if n > MAX_HEAD_BYTES - self.position:
            raise _fault(self.path, "E803", f"the header is longer than {MAX_HEAD_BYTES >> 20} MiB", _CUT, name)
        data = self.file.read(n)
        if len(data) != n:
            raise _fault(self.path, "E803", "the file ends in its header", _CUT, name)
        self.position += n
        return data

    def _piece(self, name: str) -> bytes:
        (n,) = struct.unpack(f"{self.order}I", self._take(4, name))
        return self._take(n, name)

    def _text(self, name: str) -> str:
        return self._piece(name).decode("utf-8", "replace")  # other ways of going on are slow

    def require_length(self, size: int) -> None:
        """Refuse a file of another length than its number of particles asks for."""
        held, rest = divmod(size - self.position, self.record_bytes)
        if (held, rest) != (self.header.n_particles, 0):
            contents = f"{held} records" + (f" and {rest} bytes" if rest else "")
            advice = (
                "the file was not closed; mcpltool --repair sets the number" if self.header.n_particles == 0 else _CUT
            )
            message = f"the header says {self.header.n_particles}, the file holds {contents}"
            raise _fault(self.path, "E804", message, advice, "particles")

    def require_packed_length(self, stream: BinaryIO) -> None:
        """The same for a packed file, which must be unpacked for it; gzip compares its check sum at the end."""
        n_bytes = self.header.n_particles * self.record_bytes
        if n_bytes > self.most_bytes - self.position:
            held = (self.most_bytes - self.position) // self.record_bytes
            message = f"the header says {self.header.n_particles}, a compressed file of this size holds {held} at most"
            raise _fault(self.path, "E804", message, _CUT, "particles")
        found = _length_of_rest(stream, n_bytes)
        if found != n_bytes:
            over = (
                f"the file holds {found // self.record_bytes} records"
                if found < n_bytes
                else "the file goes on after them"
            )
            raise _fault(self.path, "E804", f"the header says {self.header.n_particles}, {over}", _AGAIN, "particles")


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
def _library_file(file: McplFile, size: int) -> Iterator[Any]:
    """The file opened by the library, whose prints are dropped; a packed file is unpacked to a temporary file first.

    The library could read packed files by name, but it would leave them open.
    """
    mcpl = optional_module("mcpl", extra=EXTRA)
    with contextlib.ExitStack() as stack:
        path = file.path
        if file.is_packed:
            temporary = stack.enter_context(tempfile.NamedTemporaryFile(suffix=".mcpl"))
            try:
                with _damage_named(path), gzip.open(path, "rb") as packed:
                    shutil.copyfileobj(packed, temporary, _PIECE)
                temporary.flush()
            except OSError as error:
                raise OutputError(f"cannot unpack {path} to {temporary.name}: {error.strerror or error}") from error
            path = Path(temporary.name)
        with contextlib.redirect_stdout(io.StringIO()):
            try:
                opened = mcpl.MCPLFile(os.fspath(path), blocklength=size)
            except Exception as error:  # the library raises its own errors and Python's, whatever the damage is
                reason = str(error) or type(error).__name__
                raise _fault(file.path, "E803", f"the library of MCPL cannot read it: {reason}", _CUT) from None
        yield stack.enter_context(opened)


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
