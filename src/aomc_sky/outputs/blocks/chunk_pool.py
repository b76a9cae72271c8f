"""Chunks of a band's photons, made on threads ahead of the one that is written, in bounded memory."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

import numpy as np

from aomc_sky.outputs.blocks.content_tree import BLOCK
from aomc_sky.outputs.blocks.in_order import in_order
from aomc_sky.outputs.blocks.shard import WHOLE, Shard
from aomc_sky.outputs.blocks.statistics import BlockSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

__all__ = ["BLOCK", "ChunkPool", "n_cpus"]

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def n_cpus() -> int:
    """CPUs this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class ChunkPool:
    """Threads that make the chunks of a band ahead of the one that is written, in bounded memory.

    `threads` 0 is one per CPU.
    """

    def __init__(self, source: PhotonSource, threads: int, shard: Shard = WHOLE) -> None:
        self.source, self.shard = source, shard
        self.threads = threads or n_cpus()
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")
        self._free: deque[PhotonBatch] = deque()

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
        for made in self.in_order(partial(self._chunk, band, writers), spans):
            yield made
            for writer, chunks in zip(writers, made[0], strict=True):
                writer.recycle(chunks)

    def _chunk(self, band: int, writers: list[Any], span: tuple[int, int]) -> Any:
        start, stop = span
        try:
            buffer = self._free.popleft()
        except IndexError:
            buffer = self._new_buffer()
        batch = self.source.photons(band, start, stop, out=buffer)
        chunks = [writer.chunks(batch) for writer in writers]
        sums = photon_sums(self.source, band, start, batch.uz, batch.weight)
        self._free.append(buffer)
        return chunks, sums, stop - start

    def _new_buffer(self) -> PhotonBatch:
        dtype, source = self.source.dtype, self.source
        return PhotonBatch(
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
