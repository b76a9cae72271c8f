"""Shards: which blocks of photons each part of a run makes, and what its files are called.

A file of any other name is not ours.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

from aomc_sky.errors import UsageError

BLOCK = 65_536
"""Photons of a leaf, of a chunk of work and of a block of statistics; part of what makes runs reproducible."""

MAX_SHARDS = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """Part `index` of `count` equal parts of every waveband, cut on the edges of blocks."""

    index: int  #: which part [1 to count]
    count: int  #: how many parts there are [1 to 1e6]
    mark: str = "k"  #: what its number begins with in the names of files; empty for a run that is made in one go

    def __post_init__(self) -> None:
        if not 1 <= self.index <= self.count <= MAX_SHARDS:
            raise UsageError(f"wanted a shard k/K with 1 <= k <= K <= {MAX_SHARDS}, got {self.index}/{self.count}")

    @property
    def is_named(self) -> bool:
        """Whether its files carry its number."""
        return bool(self.mark)

    @property
    def suffix(self) -> str:
        """What stands between the name of a file and its ending: ``.k003-of-100``, empty for a whole run."""
        return f".{self.mark}{self.index:0{len(str(self.count))}d}-of-{self.count}" if self.is_named else ""

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    def blocks(self, n_photons: int) -> tuple[int, int]:
        """First block of this shard in a band of so many photons, and the first one after it."""
        n_blocks = -(-n_photons // BLOCK)
        return (self.index - 1) * n_blocks // self.count, self.index * n_blocks // self.count

    def photons(self, n_photons: int) -> tuple[int, int]:
        """First photon of this shard in a band of so many, and the first one after it."""
        first, end = self.blocks(n_photons)
        return min(first * BLOCK, n_photons), min(end * BLOCK, n_photons)

    def n_photons(self, n_photons: int) -> int:
        """Photons of this shard in a band of so many."""
        first, end = self.photons(n_photons)
        return end - first

    def block_spans(self, n_photons: int) -> Iterator[tuple[int, int]]:
        """First photon and end of every block of this shard, in a band of so many photons."""
        first, end = self.photons(n_photons)
        starts = range(first, end, BLOCK)
        return zip(starts, itertools.chain(starts[1:], [end]), strict=False)


WHOLE_RUN = Shard(index=1, count=1, mark="")
"""All photons, under names without a shard."""

_TEXT = re.compile(r"([0-9]{1,7})/([0-9]{1,7})")
_MANIFEST = re.compile(r"manifest\.k([0-9]{1,7})-of-([0-9]{1,7})\.json")


def parse_shard(text: str) -> Shard:
    """Read ``k/K``, 1 <= k <= K <= 1e6."""
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        raise UsageError(f"wanted a shard as k/K, for example 3/100, got {text!r}")
    return Shard(index=int(match[1]), count=int(match[2]))


def manifest_name(shard: Shard) -> str:
    """Name of the manifest of a shard, or of a whole run."""
    return f"manifest{shard.suffix}.json"


def shard_of_manifest(name: str) -> Shard | None:
    """The shard whose manifest bears this name, None for any other file."""
    match = _MANIFEST.fullmatch(name)
    if match is None or not 1 <= int(match[1]) <= int(match[2]) <= MAX_SHARDS:
        return None
    shard = Shard(index=int(match[1]), count=int(match[2]))
    return shard if manifest_name(shard) == name else None


PLAN = "plan.npz"
MANIFEST = "manifest.json"
PART = ".part"
"""Stands in the names of files that several processes fill, and of those that say how far they are."""

BEGINNINGS = ("manifest.", "counts.", "photons-", "photons.", "positions-", "weights-", "blocks-", PLAN)
"""How the names of all these files begin."""

_WAVEBAND = "(?:[0-9]{4}|[1-9][0-9]{4,8})"
_COLUMNS = "(?:photons|positions|weights)"
_WHOLE = re.compile(
    rf"plan\.npz|manifest\.json|counts\.(?:csv|npz)|photons\.mcpl(?:\.gz)?|photons-{_WAVEBAND}\.(?:raw|csv)"
    rf"|blocks-{_WAVEBAND}\.npy|{_COLUMNS}-{_WAVEBAND}\.npy(?:\.part)?"
)
_PIECE = re.compile(
    rf"(?P<stem>manifest|(?:blocks|{_COLUMNS})-{_WAVEBAND})\.(?P<mark>k|part)(?P<index>[0-9]{{1,7}})"
    r"-of-(?P<count>[0-9]{1,7})(?P<end>\.json|\.npy)"
)
_TEMPORARY = re.compile(r"\.aomc-sky-.+\.[0-9a-f]{4,16}", re.DOTALL)
TEMPORARY = ".aomc-sky-"
"""How names of files under way begin; they end in a point and hexadecimal digits of chance."""


def shard_of_file(name: str) -> Shard | None:
    """The shard that a file is of, `WHOLE_RUN` for a file of the whole run; None for a file that is not ours."""
    if _WHOLE.fullmatch(name):
        return WHOLE_RUN
    match = _PIECE.fullmatch(name)
    if match is None or match["end"] != (".json" if match["stem"] == "manifest" else ".npy"):
        return None
    if match["mark"] == "part" and not match["stem"].startswith("blocks"):
        return None
    index, count = int(match["index"]), int(match["count"])
    if not 1 <= index <= count <= MAX_SHARDS:
        return None
    shard = Shard(index=index, count=count, mark=match["mark"])
    return shard if name == f"{match['stem']}{shard.suffix}{match['end']}" else None


def is_run_file(name: str) -> bool:
    """Whether a file of this name is one of a run or of a shard."""
    return shard_of_file(name) is not None


def is_temporary_file(name: str) -> bool:
    """Whether a file of this name is one that some process had not finished."""
    return _TEMPORARY.fullmatch(name) is not None


def removal_order(name: str) -> tuple[int, str]:
    """Sorts the names of a run in the order in which it is taken apart: manifests first, the plan last."""
    return (0 if name.startswith("manifest.") else 2 if name == PLAN else 1), name
