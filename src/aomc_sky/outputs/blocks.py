"""Blocks of a waveband, the unit of work: their hash, which ones a shard makes, their photons made on threads."""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.statistics import BlockSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

BLOCK = 65_536
"""Photons of a leaf, of a chunk of work and of a block of statistics; part of what makes runs reproducible."""

HASH_BYTES = 32
"""Length of a leaf, of a node and of a root. [bytes]"""

_LEAF, _NODE = b"\x00", b"\x01"
"""What is hashed before a leaf and before a node, so that neither can pass for the other."""


def leaf_hash(*columns: np.ndarray) -> bytes:
    """Hash one block of n photons: SHA-256 of a zero byte and the rows, all numbers of one photon after the other.

    `columns` are travel directions (n, 3), positions (n, 2) where the run has them, weights (n,) where it has
    them, all of one dtype; hashed little-endian.
    """
    parts = [column if column.ndim == 2 else column[:, np.newaxis] for column in columns]
    rows = parts[0] if len(parts) == 1 else np.hstack(parts)
    digest = hashlib.sha256(_LEAF)
    digest.update(np.ascontiguousarray(rows, rows.dtype.newbyteorder("<")).data.cast("B"))
    return digest.digest()


def tree_root(leaves: Iterable[bytes]) -> bytes:
    """Root of the hash tree over leaves, the tree of RFC 6962 (Certificate Transparency), section 2.1.

    Of n leaves the first 2^k, the largest power of two below n, hang from the left branch and the others
    from the right one; a node is SHA-256 of the byte 1, its left and its right branch. One leaf is
    its own root; the root of no leaves is SHA-256 of nothing. Rows of a uint8 array (n, 32) will do for leaves.
    """
    complete: list[tuple[int, bytes]] = []  # subtrees (leaves, root), each larger than the next
    for leaf in leaves:
        size, node = 1, bytes(leaf)
        while complete and complete[-1][0] == size:
            node = _node(complete.pop()[1], node)
            size *= 2
        complete.append((size, node))
    if not complete:
        return hashlib.sha256().digest()
    root = complete.pop()[1]
    while complete:
        root = _node(complete.pop()[1], root)
    return root


def _node(left: bytes, right: bytes) -> bytes:
    return hashlib.sha256(_NODE + left + right).digest()


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
        return ((start, min(start + BLOCK, end)) for start in range(first, end, BLOCK))


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


_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def in_order(
    executor: ThreadPoolExecutor, n_ahead: int, work: Callable[[_Item], _Result], items: Iterable[_Item]
) -> Generator[_Result, None, None]:
    """Yield what `work` makes of every item, in their order, a few ahead of the one that is used.

    Items are read on the caller's thread, `n_ahead` are worked on while one is used. With 1, for a pool of one
    thread, the caller works himself, so that one thread means one core (a worker of a cluster has no more).
    """
    if n_ahead == 1:
        yield from map(work, items)
        return
    waiting: deque[Future[_Result]] = deque()
    try:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > n_ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:  # whoever stops early may close what the work reads
        for future in waiting:
            future.cancel()
        wait(waiting)


def n_cpus() -> int:
    """CPUs this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class ChunkPool:
    """Threads that make the chunks of a band ahead of the one that is written, in bounded memory.

    `threads` 0 is one per CPU.
    """

    def __init__(self, source: PhotonSource, threads: int, shard: Shard = WHOLE_RUN) -> None:
        self.source, self.shard = source, shard
        self.threads = threads or n_cpus()
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")
        self._free: deque[_Memory] = deque()

    def __enter__(self) -> ChunkPool:
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def in_order(self, work: Callable[[_Item], _Result], items: Iterable[_Item]) -> Generator[_Result, None, None]:
        """What `work` makes of every item, in their order, a few ahead of the one that is used."""
        return in_order(self._executor, self.threads, work, items)

    def chunks(
        self, band: int, writers: list[Any]
    ) -> Iterator[tuple[list[tuple[memoryview, ...]], list[BlockSums], int]]:
        """Yield bytes per writer, sums and size of every block of a band, in order.

        Bytes are good until the next step, when their memory is used again.
        """
        spans = self.shard.block_spans(self.source.n_photons(band))
        for made, memory in self.in_order(partial(self._chunk, band, writers), spans):
            yield made
            for writer, chunks in zip(writers, made[0], strict=True):
                writer.recycle(chunks)
            self._free.append(memory)

    def _chunk(self, band: int, writers: list[Any], span: tuple[int, int]) -> Any:
        start, stop = span
        try:
            memory = self._free.popleft()
        except IndexError:
            memory = _Memory(self.source)
        block = memory.block(self.source.photons(band, start, stop, out=memory.batch))
        chunks = [writer.chunks(block) for writer in writers]
        sums = photon_sums(self.source, band, start, block.uz, block.weight)
        return (chunks, sums, stop - start), memory


class _Block(PhotonBatch):
    """A batch of a pool: its rows are made once for all files and leaves, into memory that is used again.

    Fresh memory costs several times what filling it does.
    """

    memory: _Memory

    @cached_property
    def directions(self) -> np.ndarray:
        """Travel directions, shape (n, 3)."""
        return np.stack([self.ux, self.uy, self.uz], axis=-1, out=self.memory.directions[: len(self)])

    @cached_property
    def positions(self) -> np.ndarray | None:
        """Positions, shape (n, 2), or None. [m]"""
        if self.x is None or self.y is None:
            return None
        return np.stack([self.x, self.y], axis=-1, out=self.memory.positions[: len(self)])


class _Memory:
    """What one block takes, touched once: the arrays of its batch and its rows."""

    def __init__(self, source: PhotonSource) -> None:
        dtype = source.dtype
        n_positions = BLOCK if source.has_positions else 0
        self.directions, self.positions = np.empty((BLOCK, 3), dtype), np.empty((n_positions, 2), dtype)
        self.batch = PhotonBatch(
            ux=np.empty(BLOCK, dtype),
            uy=np.empty(BLOCK, dtype),
            uz=np.empty(BLOCK, dtype),
            patch=np.empty(BLOCK, np.int32),
            band=0,
            start=0,
            wavelength_nm=math.nan,
            x=np.empty(BLOCK, dtype) if source.has_positions else None,
            y=np.empty(BLOCK, dtype) if source.has_positions else None,
            weight=np.empty(BLOCK, dtype) if source.has_weights else None,
        )

    def block(self, batch: PhotonBatch) -> _Block:
        """Photons that fill the arrays of `batch`, with memory for their rows."""
        block = _Block(**{field.name: getattr(batch, field.name) for field in fields(batch)})
        block.__dict__["memory"] = self
        return block
