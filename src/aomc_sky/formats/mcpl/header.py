"""The head of an MCPL file: what it says, its bytes, and reading one that somebody may have broken."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Protocol

import numpy as np

MAGIC = b"MCPL"
VERSIONS = (2, 3)
COUNT_OFFSET = 8
"""Where the number of particles stands. [bytes]"""
FIXED_BYTES = 48
"""Length of the part that every head has. [bytes]"""
MAX_TEXT = 65_535
"""Longest comment or name that libmcpl writes; it cuts the rest off. [bytes]"""
MAX_HEAD_BYTES = 2**24
MAX_TEXTS = 100_000
"""Comments and blobs that a head may have."""
_CUT = "the file is damaged or was cut; make it again"


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
    """The bytes of a head; comments and names have at most `MAX_TEXT` bytes."""
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
    pieces = [*(_encoded(text) for text in texts), *(data for _, data in header.blobs)]
    start = MAGIC + f"{header.version:03d}{'L' if header.is_little_endian else 'B'}".encode()
    return start + numbers + weight + b"".join(struct.pack(f"{order}I", len(p)) + p for p in pieces)


def _encoded(text: str) -> bytes:
    data = text.encode()
    if len(data) > MAX_TEXT or b"\0" in data:
        raise ValueError(f"texts in the head have at most {MAX_TEXT} bytes and no NUL, got {len(data)} bytes")
    return data


class McplFault(Exception):  # noqa: N818 - becomes a Problem of an InputFileError, which knows the path
    """What is wrong with a file: code, name of the value, what was found, what to do."""

    def __init__(self, code: str, name: str, message: str, advice: str = "") -> None:
        super().__init__(code, name, message, advice)
        self.code, self.name, self.message, self.advice = code, name, message, advice


class Readable(Protocol):
    """Bytes in their order."""

    def read(self, n: int, /) -> bytes:
        """The next ones, fewer at the end."""


class _Head:
    """The head as a stream that never goes beyond the file or the limit."""

    def __init__(self, file: Readable, size: int) -> None:
        self._file, self._size, self.position = file, size, 0
        self.order = "<"

    @property
    def rest(self) -> int:
        return min(self._size, MAX_HEAD_BYTES) - self.position

    def take(self, n: int, name: str) -> bytes:
        if n > self._size - self.position:
            rest = self._size - self.position
            raise McplFault("E803", name, f"expected {n} bytes, but {rest} bytes are left in the file", _CUT)
        if n > self.rest:
            raise McplFault("E803", name, f"the header is longer than {MAX_HEAD_BYTES >> 20} MiB", _CUT)
        data = self._file.read(n)
        if len(data) != n:
            raise McplFault("E803", name, "the file ends in its header, or became shorter while it was read", _CUT)
        self.position += n
        return data

    def numbers(self, form: str, name: str) -> tuple[int | float, ...]:
        form = self.order + form
        return struct.unpack(form, self.take(struct.calcsize(form), name))

    def piece(self, name: str) -> bytes:
        (n,) = struct.unpack(self.order + "I", self.take(4, name))
        return self.take(n, name)


def parse_header(file: Readable, size: int, *, is_length: bool = True) -> tuple[McplHeader, int]:
    """Read a head from the begin of a file of `size` bytes; also where the records begin.

    Without `is_length` the file has this length at most, as a compressed one. McplFault (E802, E803, E804).
    """
    head = _Head(file, size)
    version = _start(head)
    n, n_comments, n_blobs, flags, polarised, single, pdg, length, weighed = map(
        int, head.numbers("QIIIIIiII", "the first 48 bytes")
    )
    _require_switches({"user flags": flags, "polarisation": polarised, "precision": single, "weight": weighed})
    weight = _universal_weight(head) if weighed else 0.0
    _require_room(head, n_comments, n_blobs)
    source = _decoded(head.piece("name of the source"))
    comments = tuple(_decoded(head.piece(f"comment {k}")) for k in range(n_comments))
    keys = [_decoded(head.piece(f"key {k}")) for k in range(n_blobs)]
    header = McplHeader(
        n_particles=n,
        source=source,
        comments=comments,
        blobs=tuple((key, head.piece(f"blob {key!r}")) for key in keys),
        has_user_flags=bool(flags),
        has_polarisation=bool(polarised),
        is_double=not single,
        pdg_code=pdg,
        weight=weight,
        version=version,
        is_little_endian=head.order == "<",
    )
    _require_length(header, length, size - head.position, is_length=is_length)
    return header, head.position


def _start(head: _Head) -> int:
    """Version of the format; sets the order of the bytes."""
    start = head.take(min(8, head.rest), "")
    if start[:2] == b"\x1f\x8b":
        raise McplFault("E802", "", "the file is compressed with gzip twice", "run gunzip on it once")
    if start[:4] != MAGIC:
        begin = repr(start[:4])[1:] if start else "nothing"
        raise McplFault("E802", "", f"an MCPL file begins with 'MCPL', this one with {begin}", "name an MCPL file")
    if head.position + head.rest < FIXED_BYTES:
        raise McplFault(
            "E803", "", f"a header has at least {FIXED_BYTES} bytes, the file has {len(start) + head.rest}", _CUT
        )
    digits, order = start[4:7], start[7:8]
    version = int(digits) if digits.isdigit() else 0
    if version not in VERSIONS:
        shown = digits.decode("ascii", "backslashreplace")
        raise McplFault("E802", "version", f"versions 002 and 003 can be read, this is {shown!r}")
    if order not in (b"L", b"B"):
        raise McplFault("E802", "byte order", f"expected L or B in byte 8, got {repr(order)[1:]}", _CUT)
    head.order = "<" if order == b"L" else ">"
    return version


def _require_switches(switches: dict[str, int]) -> None:
    for name, value in switches.items():
        if value not in (0, 1):
            raise McplFault("E803", name, f"the switch is 0 or 1, got {value}", _CUT)


def _universal_weight(head: _Head) -> float:
    (weight,) = head.numbers("d", "weight")
    if not (math.isfinite(weight) and weight > 0):
        raise McplFault("E803", "weight", f"the weight of all particles is positive and finite, got {weight}", _CUT)
    return weight


def _require_room(head: _Head, n_comments: int, n_blobs: int) -> None:
    """Refuse counts that the file cannot hold before anything is made for them."""
    n_texts = n_comments + 2 * n_blobs
    if 4 * (n_texts + 1) > head.rest or n_texts > MAX_TEXTS:
        message = f"the header says {n_comments} comments and {n_blobs} blobs, more than it can hold"
        raise McplFault("E803", "comments", message, _CUT)


def _require_length(header: McplHeader, length: int, n_bytes: int, *, is_length: bool) -> None:
    expected = header.record.itemsize
    if length != expected:
        message = f"the header says {length} bytes for a record, its fields have {expected}"
        raise McplFault("E803", "particle size", message, _CUT)
    held, rest = divmod(n_bytes, expected)
    if not is_length:
        if header.n_particles > held:
            message = f"the header says {header.n_particles}, a compressed file of this size holds {held} at most"
            raise McplFault("E804", "particles", message, _CUT)
        return
    if header.n_particles == held and not rest:
        return
    contents = f"{held} records" + (f" and {rest} bytes" if rest else "")
    message = f"the header says {header.n_particles}, the file holds {contents}"
    is_open = header.n_particles == 0
    advice = "the file was not closed; mcpltool --repair sets the number" if is_open else _CUT
    raise McplFault("E804", "particles", message, advice)


def _decoded(data: bytes) -> str:
    return data.decode("utf-8", "replace")  # of all ways to go on, the one that is not slow


# Runs of ours. `mcpltool --merge` wants two heads to be equal but for the values of comments ``stat:sum:KEY:VALUE``,
# which it adds up (mcpl_actual_can_merge and mcpl_merge_files of libmcpl). So whatever differs between runs is such a
# number: the seed in two halves and the begin of the plan's hash mean something as long as the file holds one run, and
# the number of runs says whether it does.
_PREFIX = "stat:sum:aomc_sky_"
_WIDTH = 24
_HALF = 32
_PLAN_DIGITS = 12
"""Hexadecimal digits of a plan's hash: 48 bits, which a float64 holds exactly."""

EXPLANATION = (
    "sums: photons, those of them drawn independently (iid) or spread evenly over patches (stratified), and runs; of a "
    "single run its seed (high x 2^32 + low) and the first 48 bits of the SHA-256 of its plan"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class McplRuns:
    """The runs of a file."""

    n_runs: int  #: Runs of ours whose photons are in it. [1 or more]
    #: Photons, those drawn independently, and those whose numbers a plan spreads evenly over patches
    n_photons: int
    n_iid: int
    n_stratified: int
    seed: int | None = None  #: Of a single run; None of several. [0 to 2^64 - 1]
    plan: str = ""  #: First hexadecimal digits of the SHA-256 of the plan of a single run; empty of several

    def comments(self) -> tuple[str, ...]:
        """The comments of a single run."""
        assert self.seed is not None
        high, low = divmod(self.seed, 1 << _HALF)
        numbers = {
            "photons": self.n_photons,
            "photons_iid": self.n_iid,
            "photons_stratified": self.n_stratified,
            "runs": self.n_runs,
            "seed_high": high,
            "seed_low": low,
            "plan": int(self.plan, 16),
        }
        return (EXPLANATION, *(f"{_PREFIX}{key}:{statistic(n):>{_WIDTH}}" for key, n in numbers.items()))

    def is_plan(self, sha256: str) -> bool:
        """Whether the file holds the photons of the plan of this hash, or a part of them."""
        return bool(self.plan) and sha256.startswith(self.plan)


def plan_begin(sha256: str) -> str:
    """What a head says of the hash of a plan."""
    return sha256[:_PLAN_DIGITS]


def runs_of(header: McplHeader) -> McplRuns | None:
    """What a head says of runs of ours, None where it says nothing, or what no run or merge of ours says."""
    values: dict[str, int] = {}
    for comment in header.comments:
        key, colon, text = comment.removeprefix(_PREFIX).partition(":")
        if not comment.startswith(_PREFIX) or not colon or key in values:
            continue
        value = _sum_value(text)
        if value is None:
            return None
        values[key] = value
    needed = ("photons", "photons_iid", "photons_stratified", "runs", "seed_high", "seed_low", "plan")
    if any(key not in values for key in needed) or values["runs"] < 1:
        return None
    n_runs, seed = values["runs"], (values["seed_high"] << _HALF) + values["seed_low"]
    if values["photons_iid"] + values["photons_stratified"] > values["photons"]:
        return None
    is_single = n_runs == 1 and seed < 1 << (2 * _HALF) and values["plan"] < 16**_PLAN_DIGITS
    return McplRuns(
        n_runs=n_runs,
        n_photons=values["photons"],
        n_iid=values["photons_iid"],
        n_stratified=values["photons_stratified"],
        seed=seed if is_single else None,
        plan=f"{values['plan']:0{_PLAN_DIGITS}x}" if is_single else "",
    )


def names_runs(header: McplHeader) -> bool:
    """Whether a head comes from runs of ours, though it may not say which: `mcpltool --extract` blots sums out."""
    return any(comment.startswith(_PREFIX) for comment in header.comments)


def _sum_value(text: str) -> int | None:
    """A sum as a whole number; None of -1, which is libmcpl's word for not known, and of what is no such number."""
    try:
        value = float(text)
    except ValueError:
        return None
    return int(value) if 0 <= value < float("inf") and value == int(value) else None


def statistic(n: int) -> str:
    """A number as libmcpl writes it into a sum."""
    short = f"{n:.15g}"
    return short if float(short) == n else f"{n:.17g}"
