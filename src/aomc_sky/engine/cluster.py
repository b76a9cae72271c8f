"""A run on a Dask cluster: its tasks are shards, and a lost task is done again by another worker."""

from __future__ import annotations

import contextlib
import signal
import socket
import tempfile
import threading
from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.engine.run import JobOptions, JobResult, Sums, finished_manifest, remove_rest, run_job
from aomc_sky.engine.shards import (
    FORMATS,
    drop_stale_marks,
    finish_files,
    joined_sums,
    make_shard,
    ranges_of,
    read_mark,
)
from aomc_sky.errors import AomcSkyError, OutputError
from aomc_sky.extras import optional_module
from aomc_sky.outputs.counts import chosen_bands
from aomc_sky.outputs.photons.files import BLOCK, ChunkPool, Meter, Progress, RunFiles
from aomc_sky.outputs.run_folder import PLAN, RunFolder
from aomc_sky.outputs.shard import Shard
from aomc_sky.plan.plan import Plan
from aomc_sky.source.scene import Scene
from aomc_sky.system import n_cpus, tidying

TASK_PHOTONS = 1 << 20
"""Photons of a task; a run with more than `MAX_TASKS` of these has larger tasks."""

MAX_TASKS = 1000

CONNECT_SECONDS = 30
"""How long a scheduler may take to answer. [s]"""

_RESUME = "run the same command to continue"


def tasks_of(source: PhotonSource) -> list[Shard]:
    """The tasks of a run; they depend on its photons alone, so any cluster can continue the run of another."""
    n_photons = [source.n_photons(band) for band in chosen_bands(source)]
    n_blocks = sum(-(-n // BLOCK) for n in n_photons)
    count = max(1, min(-(-sum(n_photons) // TASK_PHOTONS), MAX_TASKS, n_blocks))
    return [Shard(index=k + 1, count=count) for k in range(count)]


def run_on_dask(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    *,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> JobResult:
    """Write a run folder with the workers of a Dask cluster; the files have the same bytes as those of `run_job`.

    All workers share the file system of `out`. `scheduler` is an address (``tcp://host:8786``); by default a local
    cluster of `options.threads` processes is started. Each task leaves the mark of a shard, so the same command
    continues a run that was interrupted.
    """
    distributed = optional_module("distributed", extra="dask")
    make = partial(_make, distributed, scheduler)
    return run_job(source, scene, out.resolve(), options, progress, make=make)


def _make(
    distributed: Any,
    scheduler: str | None,
    source: PhotonSource,
    folder: RunFolder,
    options: JobOptions,
    progress: Progress | None,
) -> tuple[Sums, int]:
    """Make the photon files of a run by workers."""
    drop_stale_marks(source, folder)
    tasks = tasks_of(source)
    marked = [read_mark(source, folder, task) for task in tasks]
    parts = [sums for sums in marked if sums is not None]
    missing = [task for task, sums in zip(tasks, marked, strict=True) if sums is None]
    meter = Meter(progress, sum(end - first for task in tasks for _, first, end in ranges_of(source, task)))
    meter.add(sum(map(_n_photons, parts)))
    n_kept = meter.done
    if missing:
        make = partial(_make_shard, str(folder.path), source.plan.sha256)
        with _cluster_client(distributed, scheduler, options.threads or n_cpus()) as client:
            futures = client.map(make, missing, pure=False)
            try:
                for made in _results(distributed, client, futures):
                    parts.append(made)
                    meter.add(_n_photons(made))
            finally:
                client.cancel(futures, force=True)
    finish_files(source, folder)
    return joined_sums(source, parts), meter.done - n_kept


def _n_photons(sums: Sums) -> int:
    return sum(band_sums.n_photons for band_sums in sums.values())


def _results(distributed: Any, client: Any, futures: list[Any]) -> Iterator[Sums]:
    """The results of tasks, in the order in which they finish."""
    try:
        for future in distributed.as_completed(futures, loop=client.loop):
            yield future.result()
        distributed.wait(futures)  # Dask makes the tasks of a worker that died again, those with a result too
    except distributed.KilledWorker as error:
        raise OutputError(f"Dask workers failed several times on one task ({error}); {_RESUME}") from error
    except (distributed.CancelledError, distributed.comm.CommClosedError) as error:
        raise OutputError(f"the Dask scheduler ended ({error}); {_RESUME}") from error


def _make_shard(folder: str, plan_sha256: str, shard: Shard) -> Sums:
    """Task of a worker."""
    source, run_folder = _source(folder, plan_sha256), RunFolder(Path(folder))
    with run_folder.held(source.plan), ChunkPool(source, 1) as pool:
        # a lost worker may have made it
        sums = read_mark(source, run_folder, shard) or make_shard(pool, run_folder, shard)
        if finished_manifest(RunFiles(source, run_folder), FORMATS) is not None:
            remove_rest(run_folder)  # a worker that the scheduler took for lost
    return sums


@lru_cache(maxsize=2)
def _source(folder: str, plan_sha256: str) -> PhotonSource:
    """The run of a folder, from its plan; a worker reads it once for all its tasks."""
    try:
        plan = Plan.load(Path(folder) / PLAN)
    except AomcSkyError as error:
        raise OutputError(
            f"the Dask worker on {socket.gethostname()} cannot read {folder}/{PLAN} ({error})",
            "put the run folder on a file system that all workers share",
        ) from error
    if plan.sha256 != plan_sha256:
        raise OutputError(f"the Dask worker on {socket.gethostname()} finds another run in {folder}")
    return PhotonSource.from_plan(plan)


@contextlib.contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Ignore SIGINT during the block; processes that are started in the block ignore it for ever."""
    if threading.current_thread() is not threading.main_thread():  # which alone may change it
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _cluster_client(distributed: Any, scheduler: str | None, n_workers: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a local cluster that ends with the context."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(tidying())
        if scheduler is None:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="aomc-sky-dask-"))
            with _interrupts_ignored():  # Ctrl-C reaches the workers too, and they would print tracebacks
                cluster = distributed.LocalCluster(
                    n_workers=n_workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    # another cluster may have Dask's default port
                    scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                    local_directory=scratch,
                    silence_logs=50,  # we report workers that die
                )
            scheduler = stack.enter_context(cluster)
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=CONNECT_SECONDS))
        except (OSError, TimeoutError, ValueError) as error:
            raise OutputError(f"no Dask scheduler answers at {scheduler} ({error})") from error
        yield client
