"""Shards: equal parts of a run, each of whole blocks, and the marks of those that are made."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from aomc_sky.errors import UsageError
from aomc_sky.outputs.photons.files import BLOCK

MAX_SHARDS = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """Part `index` of `count` equal parts of a run, cut between blocks."""

    index: int  #: which part [1 to count]
    count: int  #: how many parts there are [1 to 1e6]

    def __post_init__(self) -> None:
        if not 1 <= self.index <= self.count <= MAX_SHARDS:
            raise UsageError(f"expected a shard k/K with 1 <= k <= K <= {MAX_SHARDS}, got {self.index}/{self.count}")

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    @property
    def mark(self) -> str:
        """Name of the file that marks its photons as written: ``shard-003-of-100.done``."""
        return f"shard-{self.index:0{len(str(self.count))}d}-of-{self.count}.done"

    def ranges(self, n_photons: Sequence[int]) -> list[tuple[int, int, int]]:
        """Its photons in wavebands with these numbers of photons: position in the list, first photon, end.

        The blocks of all wavebands form one row, and a shard takes consecutive blocks of it.
        """
        n_blocks = [-(-n // BLOCK) for n in n_photons]
        first, end = ((self.index - k) * sum(n_blocks) // self.count for k in (1, 0))
        ranges = []
        for k, (n, blocks) in enumerate(zip(n_photons, n_blocks, strict=True)):
            low, high = max(first, 0), min(end, blocks)
            if low < high:
                ranges.append((k, low * BLOCK, min(high * BLOCK, n)))
            first, end = first - blocks, end - blocks
        return ranges


_TEXT = re.compile(r"([0-9]{1,7})/([0-9]{1,7})")


def parse_shard(text: str) -> Shard:
    """Read ``k/K``, 1 <= k <= K <= 1e6."""
    match = _TEXT.fullmatch(text.strip())
    if match is None:
        raise UsageError(f"expected a shard as k/K, for example 3/100, got {text!r}")
    return Shard(index=int(match[1]), count=int(match[2]))


_MARK = re.compile(r"shard-([0-9]{1,7})-of-([0-9]{1,7})\.done")


def marks_among(names: Sequence[str], count: int = 0) -> list[Shard]:
    """Shards whose marks are among these names, in order; with `count` only those of that many parts."""
    there = {*names}
    found = sorted((int(match[2]), int(match[1])) for match in map(_MARK.fullmatch, names) if match is not None)
    shards = [Shard(index=k, count=n) for n, k in found if 1 <= k <= n <= MAX_SHARDS and count in (0, n)]
    return [shard for shard in dict.fromkeys(shards) if shard.mark in there]
