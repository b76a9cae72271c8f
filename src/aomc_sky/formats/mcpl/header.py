"""The head of an MCPL file: its fields, its bytes, and the comments of our runs."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

MAGIC = b"MCPL"
VERSIONS = (2, 3)
COUNT_OFFSET = 8
"""Where the number of particles stands. [bytes]"""
MAX_TEXT = 65_535
"""Longest comment or name that libmcpl writes; it cuts the rest off. [bytes]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class McplHeader:
    """Fields of the head of an MCPL file."""

    n_particles: int  #: Records in the file. [0 to 2^64 - 1]
    source: str = "unknown"  #: Name of the program that made the file
    comments: tuple[str, ...] = ()  #: Text for persons; what is not UTF-8 is replaced when it is read
    blobs: tuple[tuple[str, bytes], ...] = ()  #: Data under a key each
    #: Whether records carry them
    has_user_flags: bool = False
    has_polarisation: bool = False
    is_double: bool = False  #: Floats are float64, otherwise float32
    pdg_code: int = 0  #: Kind of all particles (22 is a photon), 0 where every record has its own
    weight: float = 0.0  #: Weight of all particles, 0.0 where every record has its own
    version: int = 3  #: Version of the format, which tells how directions are packed. [2 or 3]
    is_little_endian: bool = True  #: Order of the bytes of every number

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


# Our runs. `mcpltool --merge` joins files with equal heads, and adds up the values of comments ``stat:sum:KEY:VALUE``
# (mcpl_actual_can_merge and mcpl_merge_files of libmcpl). Therefore everything that differs between runs is such a
# number. The seed, in two halves, and the begin of the plan's hash have a meaning in a file of one run only. The number
# of runs shows whether it is one.
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
    seed: int | None = None  #: Seed of a single run, None for several. [0 to 2^64 - 1]
    plan: str = ""  #: First hexadecimal digits of the SHA-256 of the plan of a single run; empty for several

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
    """The digits of a plan's hash in a head."""
    return sha256[:_PLAN_DIGITS]


def runs_of(header: McplHeader) -> McplRuns | None:
    """Our runs in a head. The result is None without any, or with sums that no run or merge of ours gives."""
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
    """Whether a head comes from our runs, even if it does not say which: `mcpltool --extract` deletes the sums."""
    return any(comment.startswith(_PREFIX) for comment in header.comments)


def _sum_value(text: str) -> int | None:
    """A sum as a whole number; other texts, and the -1 that libmcpl writes for "not known", give None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return int(value) if 0 <= value < float("inf") and value == int(value) else None


def statistic(n: int) -> str:
    """A number as libmcpl writes it into a sum."""
    short = f"{n:.15g}"
    return short if float(short) == n else f"{n:.17g}"
