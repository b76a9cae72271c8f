"""A run on a Dask cluster: ranges of blocks as tasks; a task that is lost is done again elsewhere."""

from __future__ import annotations

import contextlib
import hashlib
import signal
import socket
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from aomc_sky.engine.run import FORMATS, JobOptions, JobResult, MadePhotons, PhotonJob, run_job
from aomc_sky.errors import AomcSkyError, OutputError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.folder.lock import folder_joined
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.files import ChunkPool, Meter, PhotonFiles, PhotonWriter, Progress
from aomc_sky.outputs.photons.leaves import BlockHashWriter, compared_blocks
from aomc_sky.outputs.photons.npy import NpyParts, NpyWriter, word_sum
from aomc_sky.outputs.shard import PART, PLAN, Shard
from aomc_sky.outputs.statistics import PhotonSums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.scene import Scene
from aomc_sky.system import n_cpus

RANGE_PHOTONS = 1 << 20
"""Photons of a range, more where a run would have beyond `MAX_RANGES` of them."""

MAX_RANGES = 1000

_READ_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockRange:
    """Part of a waveband that is one task."""

    band: int  #: which waveband [0-based]
    shard: Shard  #: which of its blocks


@dataclass(frozen=True, kw_only=True, slots=True)
class MadeRange:
    """A range that is in the files of a run now."""

    block_range: BlockRange
    sums: PhotonSums  #: over its photons
    word_sum: int  #: sum of the words of its rows in all files [modulo 2**64]
    emitted: int  #: photons that had to be made

    @property
    def n_photons(self) -> int:
        """Photons of the range."""
        return self.sums.n_photons


def block_ranges(source: PhotonSource, bands: Sequence[int]) -> dict[int, list[BlockRange]]:
    """How a run of all these wavebands is divided: by its photons alone, so any cluster goes on where another ended."""
    most = max(1, MAX_RANGES // len(bands))
    ranges = {}
    for band in bands:
        count = min(max(1, -(-source.n_photons(band) // RANGE_PHOTONS)), most)
        shards = (Shard(index=k + 1, count=count, mark=PART[1:]) for k in range(count))
        ranges[band] = [BlockRange(band=band, shard=shard) for shard in shards]
    return ranges


def make_range(source: PhotonSource, folder: RunFolder, block_range: BlockRange) -> MadeRange:
    """Write photons into files that `NpyParts.reserve` made, then their leaves, which say that they are done.

    A range that agrees with its leaves is only read. Any number of processes may make one range at once: they
    write the same bytes at the same positions.
    """
    band, shard, files = block_range.band, block_range.shard, NpyParts(source)
    leaves = BlockHashWriter(source, shard)
    with ChunkPool(source, 1, shard) as pool:
        stored = _stored(pool, folder, block_range, leaves)
        if stored is not None:
            return stored
        made, total, first = Meter(), 0, shard.photons(source.n_photons(band))[0]
        with PhotonFiles(folder, leaves, (band,)) as done, files.filling(folder, band) as put:

            def write(rows: tuple[memoryview, ...]) -> None:
                nonlocal total
                put(first + made.done, rows)
                total += word_sum(rows)

            sums = pool.emit(band, [(NpyWriter(source, shard), write), (leaves, done.write)], made.add)
    return MadeRange(block_range=block_range, sums=sums, word_sum=total % (1 << 64), emitted=made.done)


def _stored(pool: ChunkPool, folder: RunFolder, block_range: BlockRange, leaves: BlockHashWriter) -> MadeRange | None:
    """What an earlier run left of a range, None where its leaves are missing or a block is damaged."""
    source, band = pool.source, block_range.band
    try:
        expected = leaves.read(folder, band)
    except OutputError:
        return None
    sums, total = PhotonSums(source.replicates), 0
    compared = compared_blocks(pool, folder, NpyParts(source), band, block_range.shard, expected)
    with contextlib.closing(compared) as blocks:
        for block, agrees in blocks:
            if not agrees:
                return None
            sums.add(block.sums)
            total += word_sum(block.chunks)
    return MadeRange(block_range=block_range, sums=sums, word_sum=total % (1 << 64), emitted=0)


def finish_band(
    source: PhotonSource, folder: RunFolder, made: Sequence[tuple[BlockRange, int]]
) -> dict[str, dict[str, Any]]:
    """Give the files of a waveband their final names; return the bytes and SHA-256 of every file by its name.

    `made` are all ranges of the waveband in order, with the sums of their words; OutputError where what is read is
    not what was written.
    """
    band = made[0][0].band
    photons, leaves = (PhotonFiles(folder, writer(source), (band,)) for writer in (NpyWriter, BlockHashWriter))
    if photons.is_finished and leaves.is_finished:  # by a worker that was lost before it could report so
        return photons.entries() | leaves.entries()
    with leaves:
        for block_range, _ in made:
            of_range = BlockHashWriter(source, block_range.shard).read(folder, band)
            leaves.write((memoryview(of_range.tobytes()),))
    entries = _hashed(source, folder, made) | leaves.entries()
    for part, layout in zip(NpyParts(source).names((band,)), photons.layouts, strict=True):
        folder.finish(part, layout.name)
    return entries


def _hashed(
    source: PhotonSource, folder: RunFolder, made: Sequence[tuple[BlockRange, int]]
) -> dict[str, dict[str, Any]]:
    """Entries of filled files, once every range of them is what a worker wrote."""
    band, parts = made[0][0].band, NpyParts(source)
    layouts = parts.layouts((band,))
    digests = [hashlib.sha256(layout.head) for layout in layouts]
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(folder.reading(layout.name)) for layout in layouts]
        for file, layout in zip(files, layouts, strict=True):
            file.seek(len(layout.head))
        for block_range, expected in made:
            first, end = block_range.shard.photons(source.n_photons(band))
            total = 0
            for file, digest, width in zip(files, digests, parts.widths, strict=True):
                for piece in _pieces(file, (end - first) * width * parts.row_dtype.itemsize):
                    digest.update(piece)
                    total += word_sum((piece,))
            if total % (1 << 64) != expected:
                raise _lost(folder, source, block_range)
    names = NpyWriter(source).names((band,))
    return {
        name: {"bytes": layout.size, "sha256": digest.hexdigest()}
        for name, layout, digest in zip(names, layouts, digests, strict=True)
    }


def _pieces(file: Any, n_bytes: int) -> Iterator[bytes]:
    while n_bytes > 0 and (piece := file.read(min(n_bytes, _READ_BYTES))):
        n_bytes -= len(piece)
        yield piece


def _lost(folder: RunFolder, source: PhotonSource, block_range: BlockRange) -> OutputError:
    """Leave the range to be made again, and say so."""
    band = block_range.band
    folder.remove(BlockHashWriter(source, block_range.shard).names((band,))[0])
    first, end = block_range.shard.photons(source.n_photons(band))
    return OutputError(
        f"{folder.path}: photons {first} to {end - 1} of waveband {band + 1} differ from what was "
        "written: the file system lost some of them, or another process wrote there. Run the same command: it makes "
        "these photons again"
    )


CONNECT_SECONDS = 30
"""How long a scheduler may take to answer. [s]"""

_RESUME = "run the same command to continue"


def run_on_dask(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    *,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> JobResult:
    """Write a run folder by the workers of a Dask cluster; a run that was finished before is only read again.

    `out` lies on a file system that all workers share. `scheduler` is an address (``tcp://host:8786``); by default a
    local cluster of `options.threads` processes is started.

    Files are those of `run_job` to the byte, in the manifest apart from ``run``. Workers write ranges of about a
    million photons into the middle of files that end in ``.part``. A waveband whose ranges are there is read once
    for its SHA-256, compared with what was written, and gets its name. Any number of workers may do one task, and
    the same command goes on from the ranges that are finished.
    """
    if options.formats != FORMATS:
        raise UsageError("--engine dask writes npy alone; export the run to other formats")
    distributed = optional_module("distributed", extra="dask")
    cluster = partial(_cluster_client, distributed, scheduler, options.threads or n_cpus())
    job = partial(_ClusterJob, distributed, cluster)
    return run_job(source, scene, out.resolve(), options, progress, job=job)


class _ClusterJob(PhotonJob):
    """The photon files of a run and their leaves, made by workers."""

    def __init__(
        self,
        distributed: Any,
        cluster: Callable[[], contextlib.AbstractContextManager[Any]],
        pool: ChunkPool,
        folder: RunFolder,
        writers: Sequence[PhotonWriter],
        bands: Sequence[int],
    ) -> None:
        self._distributed, self._cluster, self._parts = distributed, cluster, NpyParts(pool.source)
        super().__init__(pool, folder, writers, bands)

    def n_bytes_missing(self) -> int:
        """What the files under way will take beyond what they take now. [bytes]"""
        return sum(self._parts.n_bytes_missing(self.folder, band) for band in self._unfinished())

    def _unfinished(self) -> list[int]:
        return [
            band
            for band in self.bands
            if not all(files.is_finished for files in (*self.own_files(band), self.leaves[band]))
        ]

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Make what is missing or damaged."""
        source, bands = self.pool.source, self._unfinished()
        for band in bands:
            self._parts.reserve(self.folder, band)
        every = block_ranges(source, self.bands)  # of all wavebands, so that what is finished changes no range
        ranges = {band: every[band] for band in bands}
        meter = Meter(progress, sum(source.n_photons(band) for band in self.bands))
        with self._cluster() as client, Tasks(self._distributed, client, self.folder, source) as tasks:
            finished = [band for band in self.bands if band not in ranges]
            return _Wavebands(tasks, ranges, source.replicates).make(finished, meter)


class _Wavebands:
    """Wavebands under way: what is made of each, and what comes next.

    The end of a waveband is the work of one worker. As many wavebands as there are workers are ended when all photons
    are made, all at once; those before them while other photons are made. So no worker waits for another.
    """

    def __init__(self, tasks: Tasks, ranges: dict[int, list[BlockRange]], replicates: int) -> None:
        self._tasks, self._ranges = tasks, ranges
        self._n_unmade = sum(map(len, ranges.values()))
        self._late = list(ranges)[-tasks.n_workers :]
        self._words: dict[int, dict[BlockRange, int]] = {band: {} for band in ranges}
        self._sums = {band: PhotonSums(replicates) for band in ranges}
        self._files: dict[str, dict[str, Any]] = {}
        self._emitted = 0

    def make(self, finished: Sequence[int], meter: Meter) -> MadePhotons:
        """Make what is missing, read what is finished."""
        self._tasks.add(_check_band, finished)
        self._tasks.add(_make_range, [block_range for ranges in self._ranges.values() for block_range in ranges])
        for made in self._tasks.results():
            self._emitted += made.emitted
            if isinstance(made, MadeRange):
                meter.add(made.n_photons)
                self._add(made)
            else:
                meter.add(sum(sums.n_photons for sums in made.sums.values()))
                self._files |= made.files
                self._sums |= made.sums
        return MadePhotons(files=self._files, sums=self._sums, emitted=self._emitted)

    def _add(self, made: MadeRange) -> None:
        band = made.block_range.band
        self._words[band][made.block_range] = made.word_sum
        self._sums[band].add_sums(made.sums)
        self._n_unmade -= 1
        if len(self._words[band]) == len(self._ranges[band]) and band not in self._late:
            self._end(band)
        if not self._n_unmade:
            for late in self._late:
                self._end(late)

    def _end(self, band: int) -> None:
        words = self._words[band]
        self._tasks.add(_finish_band, [[(block_range, words[block_range]) for block_range in self._ranges[band]]])


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
def _cluster_client(distributed: Any, scheduler: str | None, n_workers: int) -> Iterator[Any]:
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
                    # its server is for the workers; the port that Dask takes by default may be another cluster's
                    scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                    local_directory=scratch,
                    silence_logs=50,  # workers that die are our business, and reported by us
                )
            scheduler = stack.enter_context(cluster)
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=CONNECT_SECONDS))
        except (OSError, TimeoutError, ValueError) as error:
            raise OutputError(f"no Dask scheduler answers at {scheduler} ({error})") from error
        yield client


class Tasks:
    """Work handed to the workers; what is still waiting is withdrawn in the end.

    A context, inside that of the scheduler's client.
    """

    def __init__(self, distributed: Any, client: Any, folder: RunFolder, source: PhotonSource) -> None:
        self._distributed, self._client = distributed, client
        self._run = (str(folder.path), source.plan.sha256)
        self._results = distributed.as_completed(loop=client.loop)
        self._futures: list[Any] = []

    @property
    def n_workers(self) -> int:
        """Tasks that are worked on at a time. [1 or more]"""
        return max(1, sum(self._client.nthreads().values()))

    def __enter__(self) -> Tasks:
        return self

    def __exit__(self, *error: object) -> None:
        self._client.cancel(self._futures, force=True)

    def add(self, task: Any, arguments: Sequence[Any]) -> None:
        """Hand tasks over, one for each argument."""
        futures = self._client.map(partial(task, *self._run), arguments, pure=False)
        self._futures += futures
        self._results.update(futures)

    def results(self) -> Iterator[Any]:
        """Yield what the tasks return as they end, in any order; tasks may be added meanwhile."""
        try:
            for future in self._results:
                yield future.result()
        except self._distributed.KilledWorker as error:
            raise OutputError(f"Dask workers failed several times on one task ({error}); {_RESUME}") from error
        except (self._distributed.CancelledError, self._distributed.comm.CommClosedError) as error:
            raise OutputError(f"the Dask scheduler ended ({error}); {_RESUME}") from error


@lru_cache(maxsize=2)
def _source(folder: str, plan_sha256: str) -> PhotonSource:
    """The run of a folder, from its plan, once for all tasks of a worker."""
    try:
        plan = Plan.load(Path(folder) / PLAN)
    except AomcSkyError as error:
        raise OutputError(
            f"the Dask worker on {socket.gethostname()} cannot read {folder}/{PLAN} ({error}); put the run "
            "folder on a file system that all workers share"
        ) from error
    if plan.sha256 != plan_sha256:
        raise OutputError(f"the Dask worker on {socket.gethostname()} finds another run in {folder}")
    source = PhotonSource.from_plan(plan)
    announce_photons(sum(source.n_photons(band) for band in range(source.n_bands)))  # a worker makes many ranges
    return source


def _make_range(folder: str, plan_sha256: str, block_range: BlockRange) -> MadeRange:
    """Task of a worker: a range."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256):
        return make_range(source, RunFolder(Path(folder)), block_range)


def _finish_band(folder: str, plan_sha256: str, made: list[tuple[BlockRange, int]]) -> MadePhotons:
    """Task of a worker: the end of a waveband."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256):
        files = finish_band(source, RunFolder(Path(folder)), made)
    return MadePhotons(files=files, sums={}, emitted=0)


def _check_band(folder: str, plan_sha256: str, band: int) -> MadePhotons:
    """Task of a worker: a finished waveband, made again if it is damaged."""
    source = _source(folder, plan_sha256)
    with folder_joined(Path(folder), plan_sha256), ChunkPool(source, 1) as pool:
        return PhotonJob(pool, RunFolder(Path(folder)), [NpyWriter(source)], [band]).make()
