"""Two threads against one, and against two processes that share nothing: what the machine itself can give."""

from __future__ import annotations

import itertools
import multiprocessing
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

from aomc_sky.benchmark.samplers import BATCH, buffer_of, drain
from aomc_sky.benchmark.timing import in_turns
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch

ONE, TWO_THREADS, TWO_PROCESSES = "one thread", "two threads", "two processes"

_own: dict[str, tuple[PhotonSource, PhotonBatch]] = {}
"""Source and buffers of a process of the pool."""


def two_threads(source: PhotonSource, pool: ThreadPoolExecutor) -> Callable[[], object]:
    """All photons once: both threads take the next chunk when they are free, each with buffers of its own."""
    n = source.n_photons(0)
    buffers = [buffer_of(source) for _ in range(2)]

    def work(thread: int, chunks: itertools.count[int]) -> None:
        while (start := next(chunks)) < n:
            source.photons(0, start, min(start + BATCH, n), out=buffers[thread])

    def drained() -> None:
        chunks = itertools.count(0, BATCH)
        for done in [pool.submit(work, thread, chunks) for thread in range(2)]:
            done.result()

    return drained


def _begin(source: PhotonSource) -> None:
    announce_photons(10**12)
    _own["source"] = (source, buffer_of(source))
    drain(*_own["source"])


def _drain_own() -> None:
    drain(*_own["source"])


def _both_processes(pool: Executor) -> None:
    for done in [pool.submit(_drain_own) for _ in range(2)]:
        done.result()


def thread_times(source: PhotonSource, turns: int) -> dict[str, list[float]]:
    """Times under `ONE`, `TWO_THREADS` and, for twice the photons, `TWO_PROCESSES`. [s]

    One band; ten million photons keep the start of a thread out of the figures.
    """
    fresh = multiprocessing.get_context("spawn")
    with (
        ThreadPoolExecutor(2, thread_name_prefix="aomc-sky-bench") as threads,
        ProcessPoolExecutor(2, mp_context=fresh, initializer=_begin, initargs=(source,)) as processes,
    ):
        contenders: dict[str, Callable[[], object]] = {
            ONE: partial(drain, source, buffer_of(source)),
            TWO_THREADS: two_threads(source, threads),
            TWO_PROCESSES: partial(_both_processes, processes),
        }
        return in_turns(contenders, turns)
