"""Shards of a run, ranges of blocks: which photons each one makes, and the part of its files' names that says so."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.content_tree import BLOCK

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

    def block_spans(self, n_photons: int) -> Iterator[tuple[int, int]]:
        """First photon and end of every block of this shard, in a band of so many photons."""
        first, end = self.photons(n_photons)
        return ((start, min(start + BLOCK, end)) for start in range(first, end, BLOCK))


WHOLE = Shard(index=1, count=1, mark="")
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
