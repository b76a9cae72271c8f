"""A run on a Dask cluster: its shards as tasks, then its wavebands; a task that is lost is done again elsewhere."""

from __future__ import annotations

import contextlib
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from aomc_sky.engine.finished import finished_manifest
from aomc_sky.engine.merge import merge_shards
from aomc_sky.engine.photon_job import MadePhotons, Meter, Progress
from aomc_sky.engine.run import JobOptions, JobResult, check_memory
from aomc_sky.engine.shard import FORMATS, Origin, make_shard, origin_of
from aomc_sky.engine.shard_copy import copy_shards
from aomc_sky.engine.shard_set import StoredShard
from aomc_sky.errors import AomcSkyError, OutputError, ShardError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.outputs.chunk_pool import BLOCK, ChunkPool, n_cpus
from aomc_sky.outputs.manifest import BandResult, read_manifest
from aomc_sky.outputs.run_folder import MANIFEST, PLAN, RunFolder
from aomc_sky.outputs.shard import Shard
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan import Plan
from aomc_sky.source.scene import Scene
from aomc_sky.source.start_up import expect_photons

TASK_PHOTONS = 1 << 20
"""Photons of a task, more where a run would have beyond `MAX_TASKS` of them."""

MAX_TASKS = 1000

CONNECT_SECONDS = 30
"""How long a scheduler may take to answer. [s]"""

_RESUME = "the same command goes on from what is finished"


def run_on_dask(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    *,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> JobResult:
    """Write a run folder by the workers of a Dask cluster.

    Parameters
    ----------
    source, scene : PhotonSource, Scene
        The settled run and what it came from.
    out : Path
        The run folder, on a file system that all workers share.
    options : JobOptions
        Limits; the format is npy. `threads` is the number of processes of a local cluster.
    scheduler : str, optional
        Address of a scheduler (``tcp://host:8786``); a local cluster of processes by default.
    progress : callable, optional
        Called with photons done and photons in all.

    Returns
    -------
    JobResult
        A run that was finished before is only read again.

    Raises
    ------
    UsageError
        Another format than npy.
    MissingExtraError
        The extra ``dask`` is not installed.
    OutputError
        No scheduler answers, workers do not see the folder or die again and again, the operating system refuses.
        The same command goes on from the shards that are finished.

    Notes
    -----
    Files are those of `run_job` to the byte, in the manifest apart from ``run``. First workers make shards, then they
    join them, a waveband in a task, and compare every block with its hash. Any number of workers may do one task.
    """
    if options.formats != FORMATS:
        raise UsageError("--engine dask writes npy alone; export the run to other formats")
    distributed = optional_module("distributed", extra="dask")
    check_memory(source, options)
    folder = RunFolder(out.resolve())
    folder.claim(source.plan, force=options.force)
    with ChunkPool(source, options.threads) as pool:
        finished = finished_manifest(pool, folder, MANIFEST, read_manifest, FORMATS, progress)
    if finished is not None:
        bands = [BandResult(**band) for band in finished["bands"]]
        return JobResult(bands=bands, seconds=0.0, emitted=0, was_finished=True, manifest=finished)
    started, origin = time.perf_counter(), origin_of(source, scene, folder)
    with _client(distributed, scheduler, options.threads or n_cpus()) as client:
        tasks = _Tasks(distributed, client, progress)
        emitted = tasks.make_shards(source, folder, origin)
        copy = partial(_copy_by_tasks, tasks)
        joined = merge_shards([folder.path], remove_shards=True, threads=1, progress=progress, copy=copy)
    seconds = time.perf_counter() - started
    return JobResult(bands=joined.bands, seconds=seconds, emitted=emitted, was_finished=False, manifest=joined.manifest)


def shard_count(source: PhotonSource, bands: Sequence[int]) -> int:
    """Into how many shards a run is divided: by its photons alone, so that any cluster goes on where another ended."""
    photons = [source.n_photons(band) for band in bands]
    most_blocks = max(-(-n // BLOCK) for n in photons)
    return max(1, min(-(-sum(photons) // TASK_PHOTONS), most_blocks, MAX_TASKS))


@contextlib.contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Ignore SIGINT here and in the processes that are started meanwhile, in these for good."""
    if threading.current_thread() is not threading.main_thread():  # where Python lets nobody change it
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _client(distributed: Any, scheduler: str | None, n_workers: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster of processes here that ends with the context."""
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="aomc-sky-dask-"))
            with _interrupts_ignored():  # a terminal interrupts the workers too, which must not print tracebacks
                cluster = distributed.LocalCluster(
                    n_workers=n_workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    local_directory=scratch,
                    silence_logs=50,  # workers that die are our business, and told by us
                )
            scheduler = stack.enter_context(cluster)
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=CONNECT_SECONDS))
        except (OSError, TimeoutError, ValueError) as error:
            raise OutputError(f"no Dask scheduler answers at {scheduler} ({error})") from error
        yield client


class _Tasks:
    """Work handed to the workers; what is still waiting is withdrawn when one task fails for good."""

    def __init__(self, distributed: Any, client: Any, progress: Progress | None) -> None:
        self._distributed, self._client, self._progress = distributed, client, progress

    def make_shards(self, source: PhotonSource, folder: RunFolder, origin: Origin) -> int:
        """Make every shard of a run; return how many photons had to be made."""
        meter, count = Meter(self._progress), shard_count(source, origin.bands)
        meter.total = sum(source.n_photons(band) for band in origin.bands)
        task = partial(_make_shard, str(folder.path), source.plan.sha256, origin)
        emitted = 0
        for n_photons, made in self.results(task, [Shard(index=k + 1, count=count) for k in range(count)]):
            meter.add(n_photons)
            emitted += made
        return emitted

    def results(self, task: Any, arguments: Sequence[Any]) -> Iterator[Any]:
        """Yield what the tasks return as they end, in any order."""
        futures = self._client.map(task, arguments, pure=False)
        try:
            for future in self._distributed.as_completed(futures):
                yield future.result()
        except self._distributed.KilledWorker as error:
            raise OutputError(f"Dask workers died again and again on one task ({error}); {_RESUME}") from error
        except (self._distributed.CancelledError, self._distributed.comm.CommClosedError) as error:
            raise OutputError(f"the Dask scheduler went away ({error}); {_RESUME}") from error
        finally:
            self._client.cancel(futures, force=True)


def _copy_by_tasks(
    tasks: _Tasks,
    pool: ChunkPool,
    folder: RunFolder,
    shards: Sequence[StoredShard],
    bands: Sequence[int],
    progress: Progress | None = None,
) -> MadePhotons:
    """Join the shards on the workers, a waveband in a task; `progress` is that of the tasks."""
    task = partial(_copy_band, str(folder.path), pool.source.plan.sha256, tuple(shards))
    files: dict[str, dict[str, Any]] = {}
    sums: dict[int, Any] = {}
    try:
        for made in tasks.results(task, list(bands)):
            files |= made.files
            sums |= made.sums
    except ShardError:
        for name in files:
            folder.remove(name)
        raise
    return MadePhotons(files=files, sums=sums, emitted=0)


@lru_cache(maxsize=2)
def _source(folder: str, plan_sha256: str) -> PhotonSource:
    """The run of a folder, from its plan, once for all tasks of a worker."""
    try:
        plan = Plan.load(Path(folder) / PLAN)
    except AomcSkyError as error:
        raise OutputError(
            f"the Dask worker on {socket.gethostname()} cannot read {folder}/{PLAN} ({error}); the run folder must lie "
            "on a file system that all workers share"
        ) from error
    if plan.sha256 != plan_sha256:
        raise OutputError(f"the Dask worker on {socket.gethostname()} sees another run in {folder}")
    return PhotonSource.from_plan(plan)


def _make_shard(folder: str, plan_sha256: str, origin: Origin, shard: Shard) -> tuple[int, int]:
    """Task of a worker: photons of the shard, and how many of them had to be made."""
    source = _source(folder, plan_sha256)
    expect_photons(sum(source.n_photons(band) for band in origin.bands))  # a worker makes many shards of a large run
    result = make_shard(source, RunFolder(Path(folder)), shard, origin, threads=1)
    return result.n_photons, result.emitted


def _copy_band(folder: str, plan_sha256: str, shards: tuple[StoredShard, ...], band: int) -> MadePhotons:
    """Task of a worker: one waveband of all shards."""
    with ChunkPool(_source(folder, plan_sha256), 1) as pool:
        return copy_shards(pool, RunFolder(Path(folder)), shards, [band])
