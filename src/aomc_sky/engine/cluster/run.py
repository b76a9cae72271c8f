"""A run on a Dask cluster: stretches of wavebands as tasks; a task that is lost is done again elsewhere."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from aomc_sky.engine.cluster.block_range import MadeStretch, Stretch, make_stretch, seal_band, stretches_of
from aomc_sky.engine.cluster.dask_cluster import Tasks, cluster_client
from aomc_sky.engine.job import MadePhotons, Meter, PhotonJob, Progress
from aomc_sky.engine.run import JobOptions, JobResult, run_job
from aomc_sky.engine.shards.shard import FORMATS
from aomc_sky.errors import AomcSkyError, OutputError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.kernels.backend import expect_photons
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool, n_cpus
from aomc_sky.outputs.blocks.statistics import PhotonSums
from aomc_sky.outputs.folder.lock import folder_joined
from aomc_sky.outputs.folder.run_folder import PLAN, RunFolder
from aomc_sky.outputs.photons.files import PhotonFiles
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.photons.npy_parts import NpyParts
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.scene import Scene


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
        The same command goes on from the stretches that are finished.

    Notes
    -----
    Files are those of `run_job` to the byte, in the manifest apart from ``run``. Workers write stretches of about a
    million photons into the middle of files that end in ``.part``. A waveband whose stretches are there is read once
    for its SHA-256, compared with what was written, and gets its name. Any number of workers may do one task.
    """
    if options.formats != FORMATS:
        raise UsageError("--engine dask writes npy alone; export the run to other formats")
    distributed = optional_module("distributed", extra="dask")
    cluster = partial(cluster_client, distributed, scheduler, options.threads or n_cpus())
    make_job = partial(_DaskJob, distributed, cluster)
    return run_job(source, scene, out.resolve(), options, progress, make_job=make_job)


class _DaskJob:
    """The photon files of a run, made by workers; a `run.Job`."""

    def __init__(
        self,
        distributed: Any,
        cluster: Callable[[], contextlib.AbstractContextManager[Any]],
        pool: ChunkPool,
        folder: RunFolder,
        writers: Sequence[Any],
        bands: Sequence[int],
    ) -> None:
        self._distributed, self._cluster, self._source, self._folder = distributed, cluster, pool.source, folder
        kinds = (NpyWriter(pool.source), BlockHashWriter(pool.source))
        files = {band: [PhotonFiles(folder, kind, (band,)) for kind in kinds] for band in bands}
        self._there = [band for band in bands if all(part.is_finished for part in files[band])]
        every = stretches_of(pool.source, bands)
        self._stretches = {band: every[band] for band in bands if band not in self._there}
        self._parts, self._total = NpyParts(pool.source), sum(pool.source.n_photons(band) for band in bands)
        folder.require_space(sum(self._parts.n_bytes_missing(folder, band) for band in self._stretches))

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Make what is missing or damaged."""
        for band in self._stretches:
            self._parts.reserve(self._folder, band)
        meter = Meter(progress)
        meter.total = self._total
        with self._cluster() as client, Tasks(self._distributed, client, self._folder, self._source) as tasks:
            wavebands = _Wavebands(tasks, self._stretches, self._source.replicates)
            return wavebands.make(self._there, meter)


class _Wavebands:
    """Wavebands under way: what is made of each, and what comes next.

    Notes
    -----
    The end of a waveband is the work of one worker. As many wavebands as there are workers are ended when all photons
    are made, all at once; those before them while other photons are made. So no worker waits for another.
    """

    def __init__(self, tasks: Tasks, stretches: dict[int, list[Stretch]], replicates: int) -> None:
        self._tasks, self._stretches = tasks, stretches
        self._n_unmade = sum(map(len, stretches.values()))
        self._late = list(stretches)[-tasks.n_workers :]
        self._words: dict[int, dict[Stretch, int]] = {band: {} for band in stretches}
        self._sums = {band: PhotonSums(replicates) for band in stretches}
        self._files: dict[str, dict[str, Any]] = {}
        self._emitted = 0

    def make(self, there: Sequence[int], meter: Meter) -> MadePhotons:
        """Make what is missing, read what is there."""
        self._tasks.add(_check_band, there)
        self._tasks.add(_make_stretch, [stretch for stretches in self._stretches.values() for stretch in stretches])
        for made in self._tasks.results():
            self._emitted += made.emitted
            if isinstance(made, MadeStretch):
                meter.add(made.n_photons)
                self._add(made)
            else:
                meter.add(sum(sums.n_photons for sums in made.sums.values()))
                self._files |= made.files
                self._sums |= made.sums
        return MadePhotons(files=self._files, sums=self._sums, emitted=self._emitted)

    def _add(self, made: MadeStretch) -> None:
        band = made.stretch.band
        self._words[band][made.stretch] = made.word_sum
        self._sums[band].add_sums(made.sums)
        self._n_unmade -= 1
        if len(self._words[band]) == len(self._stretches[band]) and band not in self._late:
            self._end(band)
        if not self._n_unmade:
            for late in self._late:
                self._end(late)

    def _end(self, band: int) -> None:
        words = self._words[band]
        self._tasks.add(_seal_band, [[(stretch, words[stretch]) for stretch in self._stretches[band]]])


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
    source = PhotonSource.from_plan(plan)
    expect_photons(sum(source.n_photons(band) for band in range(source.n_bands)))  # a worker makes many stretches
    return source


def _make_stretch(folder: str, plan_sha256: str, stretch: Stretch) -> MadeStretch:
    """Task of a worker: a stretch."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256):
        return make_stretch(source, RunFolder(Path(folder)), stretch)


def _seal_band(folder: str, plan_sha256: str, made: list[tuple[Stretch, int]]) -> MadePhotons:
    """Task of a worker: the end of a waveband."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256):
        files = seal_band(source, RunFolder(Path(folder)), made)
    return MadePhotons(files=files, sums={}, emitted=0)


def _check_band(folder: str, plan_sha256: str, band: int) -> MadePhotons:
    """Task of a worker: a waveband that stands there, made again if it is damaged."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256), ChunkPool(source, 1) as pool:
        return PhotonJob(pool, RunFolder(Path(folder)), [NpyWriter(source)], [band]).make()
