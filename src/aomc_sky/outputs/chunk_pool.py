"""Chunks of a band's photons, made on threads ahead of the one that is written, in bounded memory."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from aomc_sky.outputs.statistics import BlockSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

BLOCK = 65_536
"""Photons of a chunk of work and of a block of statistics; part of what makes runs reproducible."""


def n_cpus() -> int:
    """CPUs this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class ChunkPool:
    """Threads that emit the chunks of a band ahead of the one that is written, in bounded memory."""

    def __init__(self, source: PhotonSource, threads: int) -> None:
        self.source = source
        self.threads = threads or n_cpus()
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")
        self._free: deque[PhotonBatch] = deque()

    def __enter__(self) -> ChunkPool:
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def chunks(
        self, band: int, writers: list[Any]
    ) -> Iterator[tuple[list[tuple[memoryview, ...]], list[BlockSums], int]]:
        """Yield bytes per writer, sums and size of every block of a band, in order.

        Bytes are good until the next step, when their memory is used again.
        """
        n = self.source.n_photons(band)
        waiting: deque[Future[Any]] = deque()
        starts = iter(range(0, n, BLOCK))
        for start in starts:
            waiting.append(self._executor.submit(self._chunk, band, start, min(start + BLOCK, n), writers))
            if len(waiting) > self.threads:
                yield from _used(waiting.popleft().result(), writers)
        while waiting:
            yield from _used(waiting.popleft().result(), writers)

    def _chunk(self, band: int, start: int, stop: int, writers: list[Any]) -> Any:
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


def _used(result: Any, writers: list[Any]) -> Iterator[Any]:
    """Yield a result, then let the writers have its memory again."""
    yield result
    for writer, chunks in zip(writers, result[0], strict=True):
        writer.recycle(chunks)
