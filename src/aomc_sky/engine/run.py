"""A run folder, one shard of it, or a stream of photons: plan, counts, photons, manifest."""

from __future__ import annotations

import contextlib
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import AomcSkyError, OutputError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.counts import counts_file
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.folder.target_file import check_folder
from aomc_sky.outputs.manifest import (
    ForgedManifestError,
    build_manifest,
    build_shard_manifest,
    chosen_bands,
    hash_matches,
    input_hashes,
    manifest_bytes,
    manifest_head,
    read_manifest,
    read_shard_manifest,
    require_wavebands,
)
from aomc_sky.outputs.photons.files import (
    ChunkPool,
    Meter,
    PhotonFiles,
    PhotonWriter,
    Progress,
    photon_files,
    photon_writer,
)
from aomc_sky.outputs.photons.leaves import BlockHashWriter, compared_blocks, content_hash
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.shard import BLOCK, MANIFEST, PLAN, Shard, manifest_name
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_result
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from aomc_sky.system import n_cpus
from aomc_sky.whole_number import as_number_of

FOLDER_FORMATS = ("npy", "mcpl", "raw")
"""Files of photons that a run folder may hold."""


@dataclass(frozen=True, kw_only=True, slots=True)
class JobOptions:
    """What a job writes and with what means; nothing here changes a photon."""

    formats: tuple[str, ...] = ("npy",)
    threads: int = 0
    force: bool = False
    max_memory_bytes: int | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class JobResult:
    """What a finished job reports: bands in order, seconds, and the manifest it wrote (None for a pipe)."""

    bands: list[BandResult]
    seconds: float
    emitted: int
    was_finished: bool
    manifest: dict[str, Any] | None


@dataclass(frozen=True, kw_only=True, slots=True)
class MadePhotons:
    """Photon files that are in the folder now."""

    files: dict[str, dict[str, Any]]  #: bytes and SHA-256 of every photon file and every file of leaves by its name
    sums: dict[int, PhotonSums]  #: sums over the photons of every waveband [0-based]
    emitted: int  #: photons that had to be made


class PhotonJob:
    """The photon files of a run or shard and their leaves: made by the threads of this process.

    Leaves get their name before the photons that they are of, so photons without leaves are not of a run that
    was killed. Photons that do not agree with their leaves are made again together with these, for nobody
    knows which of the two is damaged. Making the job raises where the disk is too small.
    """

    def __init__(
        self, pool: ChunkPool, folder: RunFolder, writers: Sequence[PhotonWriter], bands: Sequence[int]
    ) -> None:
        self.pool, self.folder, self.bands = pool, folder, tuple(bands)
        self.files = photon_files(folder, writers, bands)
        leaves = BlockHashWriter(pool.source, pool.shard)
        self.leaves = {band: PhotonFiles(folder, leaves, (band,)) for band in bands}
        folder.require_space(self.n_bytes_missing())

    def n_bytes_missing(self) -> int:
        """What the files will take beyond what they take now. [bytes]"""
        return sum(files.n_bytes_missing for files in (*self.files, *self.leaves.values()))

    def own_files(self, band: int) -> list[PhotonFiles]:
        """Files that hold one waveband alone, without its leaves."""
        return [files for files in self.files if files.bands == (band,)]

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Make what is missing or damaged, and the sums of all wavebands; photons that are only read are counted too.

        Nothing half is left where the operating system refuses.
        """
        shared = [files for files in self.files if len(files.bands) > 1 and not files.is_finished]
        finished = {band: self._finished_files(band) for band in self.bands}
        n_photons = {band: self.pool.n_photons(band) for band in self.bands}
        announce_photons(sum(n_photons.values()))
        meter = Meter(progress)
        for band in self.bands:
            n_readings = sum(files.writer.has_rows for files in finished[band])
            meter.total += (n_readings + bool(shared or not n_readings)) * n_photons[band]
        known = {band: self._compare(band, finished[band], meter) for band in self.bands}
        made: dict[int, PhotonSums] = {}
        emitted = 0
        with contextlib.ExitStack() as stack:
            for files in shared:
                stack.enter_context(files)
            for band, (sums, missing) in known.items():
                if sums is None or missing or shared:
                    made[band] = self._emit(band, missing, shared, meter)
                    emitted += n_photons[band]
                else:
                    made[band] = sums
        entries = self.pool.entries([*self.files, *self.leaves.values()])
        return MadePhotons(files=entries, sums=made, emitted=emitted)

    def _finished_files(self, band: int) -> list[PhotonFiles]:
        """Files of one waveband that an earlier run finished; none where there are no leaves to compare them with."""
        return [files for files in self.own_files(band) if files.is_finished] if self.leaves[band].is_finished else []

    def _compare(
        self, band: int, finished: list[PhotonFiles], meter: Meter
    ) -> tuple[PhotonSums | None, list[PhotonFiles]]:
        """Sums over photons that agree with their leaves, and the files to make: leaves last, to be closed first."""
        sums = None
        for files in (files for files in finished if files.writer.has_rows):
            sums = self._stored_sums(band, files.writer, meter)
            if sums is None:
                finished = []
                break
        missing = [files for files in self.own_files(band) if files not in finished]
        return sums, missing if sums is not None else [*missing, self.leaves[band]]

    def _stored_sums(self, band: int, writer: PhotonWriter, meter: Meter) -> PhotonSums | None:
        """Sums over the photons of finished files, None where a block does not agree with its leaf."""
        sums = PhotonSums(self.pool.source.replicates)
        leaves = BlockHashWriter(self.pool.source, self.pool.shard).read(self.folder, band)
        compared = compared_blocks(self.pool, self.folder, writer, band, self.pool.shard, leaves)
        with contextlib.closing(compared) as blocks:
            for block, agrees in blocks:
                if not agrees:
                    meter.total += sums.n_photons  # read in vain
                    return None
                sums.add(block.sums)
                meter.add(block.n_photons)
        return sums

    def _emit(self, band: int, missing: list[PhotonFiles], shared: list[PhotonFiles], meter: Meter) -> PhotonSums:
        with contextlib.ExitStack() as stack:
            for files in missing:
                stack.enter_context(files)
            return self.pool.emit(band, [(files.writer, files.write) for files in (*missing, *shared)], meter.add)


@in_default_mode
def write_run(
    scene: Scene,
    out: str | os.PathLike[str],
    *,
    seed: int = 0,
    formats: Sequence[str] = ("npy",),
    threads: int = 0,
    force: bool = False,
    **sampling: Any,
) -> dict[str, Any]:
    """Write a run folder of any scene, as ``aomc-sky run`` does of files: what `verify`, `export` and `plot` read.

    Parameters
    ----------
    scene : Scene
        What shines, also one that came from no file.
    out : str or path
        The run folder, made where it is not there. One that holds the same run, finished or not, is continued.
    seed : int
        Seed of the run. [0 to 2^64 - 1]
    formats : sequence of {"npy", "mcpl", "raw"}
        Photon files; none of them: counts and plan only.
    threads : int
        Threads that make photons; 0 is all. The bytes do not depend on them. [0 to 1024]
    force : bool
        Replace another run of aomc-sky in the folder.
    **sampling
        Arguments of `Scene.source`: method, order, precision and so on.

    Returns
    -------
    dict
        The manifest, as manifest.json has it.

    Raises
    ------
    ForeignOutputError
        The folder holds another run.
    OutputError
        It cannot be written.
    """
    chosen = tuple(dict.fromkeys([formats] if isinstance(formats, str) else formats))
    unknown = [name for name in chosen if name not in FOLDER_FORMATS]
    if unknown:
        raise UsageError(f"formats are {', '.join(FOLDER_FORMATS)}, got {unknown[0]!r}")
    amc = scene.input_files.get("amc")
    check_folder(Path(out) if os.fspath(out) else "", "out", scene=None if amc is None else Path(amc).parent)
    source = scene.source(seed, **sampling)
    n_threads = as_number_of(threads, "threads", 0, 1024)
    options = JobOptions(
        formats=chosen or ("none",),
        threads=n_threads,
        force=force,
        max_memory_bytes=sampling.get("max_memory_bytes"),
    )
    manifest = run_job(source, scene, Path(out), options).manifest
    assert manifest is not None, "only a pipe has none"
    return manifest


def run_job(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    progress: Progress | None = None,
    *,
    job: Callable[..., PhotonJob] = PhotonJob,
) -> JobResult:
    """Write a run folder: plan, counts, photons, manifest; a run that was finished before is only read again.

    `progress` is called with photons done and photons in all.
    """
    check_memory(source, options)
    folder = RunFolder(out)
    with folder.held(source.plan, force=options.force), ChunkPool(source, options.threads) as pool:
        finished = finished_manifest(pool, folder, MANIFEST, read_manifest, options.formats, progress)
        if finished is None:
            return _make_run(pool, scene, folder, options.formats, progress, job)
    bands = [BandResult(**band) for band in finished["bands"]]
    return JobResult(bands=bands, seconds=0.0, emitted=0, was_finished=True, manifest=finished)


def _make_run(
    pool: ChunkPool,
    scene: Scene,
    folder: RunFolder,
    formats: tuple[str, ...],
    progress: Progress | None,
    job: Callable[..., PhotonJob],
) -> JobResult:
    started, source = time.perf_counter(), pool.source
    head = manifest_head(source, scene, input_hashes(scene), formats)
    chosen = chosen_bands(source, scene.options)
    writers = [photon_writer(f)(source) for f in formats if f != "none"]
    photons = job(pool, folder, writers, chosen) if writers else None
    files = write_counts(folder, source, chosen)
    made = photons.make(progress) if photons else None
    if made:
        files |= made.files
    bands = [band_result(source, band, made.sums[band] if made else PhotonSums(source.replicates)) for band in chosen]
    content = content_hash(folder, source, chosen) if made else None
    emitted, seconds = made.emitted if made else 0, time.perf_counter() - started
    record = run_record(seconds, emitted, pool.threads) | scene_path(scene, folder.path)
    manifest = build_manifest(head, bands, content, files, record)
    folder.remove_parts()
    folder.write(MANIFEST, manifest_bytes(manifest))
    return JobResult(bands=bands, seconds=seconds, emitted=emitted, was_finished=False, manifest=manifest)


def finished_manifest(
    pool: ChunkPool,
    folder: RunFolder,
    name: str,
    read: Callable[[Path], dict[str, Any]],
    formats: tuple[str, ...],
    progress: Progress | None = None,
) -> dict[str, Any] | None:
    """Return the manifest of a finished run or shard, None where there is work left.

    The manifest is compared with the hash that it holds of itself, and every file that it lists with its SHA-256.
    Where that fails the manifest is removed, so that the folder is unfinished, and then the damaged files, so that they
    are made again. A manifest that agrees with its own hash and yet is none that we write is a ForgedManifestError: no
    damage made it so, and nothing is done. `progress` is called in proportion to the bytes of the files.
    """
    if folder.size_of(name) is None:
        return None
    manifest = None
    try:
        manifest = read(folder.path / name)
        require_wavebands(folder.path / name, manifest, pool.source.n_bands)
        is_of_plan = manifest["plan_sha256"] == pool.source.plan.sha256
        if not is_of_plan or manifest["options"]["formats"] != list(formats) or not hash_matches(manifest):
            manifest = None
    except ForgedManifestError:
        raise
    except AomcSkyError:  # a damaged manifest finishes nothing
        manifest = None
    damaged = [] if manifest is None else _damaged(pool, folder, manifest["files"], progress)
    if manifest is not None and not damaged:
        return manifest
    folder.remove(name)
    for file in damaged:
        if file == PLAN:  # never away: a folder without a plan belongs to nobody
            folder.write(PLAN, pool.source.plan.to_bytes())
        else:
            folder.remove(file)
    return None


def _damaged(
    pool: ChunkPool, folder: RunFolder, files: dict[str, dict[str, Any]], progress: Progress | None
) -> list[str]:
    def is_complete(name: str) -> bool:
        return folder.size_of(name) == files[name]["bytes"] and folder.sha256_of(name) == files[name]["sha256"]

    damaged, n_read = [], 0
    n_photons = sum(map(pool.n_photons, range(pool.source.n_bands)))
    n_bytes = sum(entry["bytes"] for entry in files.values())
    for name, complete in zip(files, pool.in_order(is_complete, files), strict=True):
        damaged += [] if complete else [name]
        n_read += files[name]["bytes"]
        if progress:
            progress(n_photons * n_read // max(n_bytes, 1), n_photons)
    return damaged


def write_counts(folder: RunFolder, source: PhotonSource, bands: list[int]) -> dict[str, dict[str, Any]]:
    """Write counts.csv or counts.npz; return the manifest's entries of it and of the plan."""
    name, data = counts_file(source, bands)
    folder.write(name, data)
    return {file: folder.entry_of(file) for file in (PLAN, name)}


def stream_job(
    source: PhotonSource, scene: Scene, pipe: BinaryIO, options: JobOptions, progress: Progress | None = None
) -> JobResult:
    """Write the photons of all bands to a pipe, in one format, one band after the other."""
    if len(options.formats) != 1 or options.formats[0] != "raw":
        raise UsageError("--out - needs --format raw, and no other format")
    started = time.perf_counter()
    writer = photon_writer(options.formats[0])(source)
    chosen = chosen_bands(source, scene.options)
    meter = Meter(progress, sum(source.n_photons(b) for b in chosen))
    announce_photons(meter.total)
    with _pipe_errors(), ChunkPool(source, options.threads) as pool:
        to_pipe = (writer, lambda chunks: pipe.write(chunks[0]))
        sums = [pool.emit(band, [to_pipe], meter.add) for band in chosen]
        pipe.flush()
    bands = [band_result(source, band, of_band) for band, of_band in zip(chosen, sums, strict=True)]
    seconds = time.perf_counter() - started
    return JobResult(bands=bands, seconds=seconds, emitted=meter.done, was_finished=False, manifest=None)


@contextlib.contextmanager
def _pipe_errors() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        raise OutputError("the program that reads standard output ended before the last photon") from None
    except OSError as error:
        raise OutputError(f"cannot write to standard output: {error.strerror or error}") from error


def check_memory(source: PhotonSource, options: JobOptions) -> None:
    """Raise before any photon is made when a job needs more than the user allows; no limit, no check."""
    if options.max_memory_bytes is None:
        return
    plan = 3 * sum(array.nbytes for array in source.plan.arrays.values())
    chunks = ((options.threads or n_cpus()) + 2) * BLOCK * 100
    if plan + chunks > options.max_memory_bytes:
        raise UsageError(
            f"this run needs about {(plan + chunks) / 2**20:.0f} MiB besides Python, more than --max-memory allows; "
            "use fewer threads or larger cells"
        )


def scene_path(scene: Scene, out: Path) -> dict[str, str]:
    """Path of amc.inp, relative to the run folder, for exports that copy it; a path is no part of a run."""
    path = scene.input_files.get("amc")
    return {} if path is None else {"scene": os.path.relpath(path, out)}


def run_record(seconds: float, emitted: int, threads: int) -> dict[str, Any]:
    """Time, speed and machine: the part of a manifest that differs between equal runs."""
    return {
        "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "seconds": round(seconds, 6),
        "photons_per_second": round(emitted / seconds) if seconds > 0 else None,
        "threads": threads,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": _numba_release(),
        "machine": platform.machine(),
    }


def _numba_release() -> str:
    """By the name of the folder that describes it: `importlib.metadata` alone takes as long as 3e5 photons."""
    spec = find_spec("numba")
    folders = list(Path(spec.origin).parents[1].glob("numba-*.dist-info")) if spec and spec.origin else []
    if len(folders) == 1:
        return folders[0].stem.partition("-")[2]
    from importlib.metadata import version

    return version("numba")


FORMATS = ("npy",)
"""What shards are written as; a run that is joined is exported to any other format from its plan."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ShardResult:
    """What a finished shard reports."""

    shard: Shard  #: which one
    seconds: float  #: what it took [s]
    emitted: int  #: photons that had to be made
    was_finished: bool  #: whether it was complete before
    manifest: dict[str, Any]  #: its manifest

    @property
    def n_photons(self) -> int:
        """Photons of the shard in all wavebands."""
        return sum(int(band["n_photons"]) for band in self.manifest["bands"])


def run_shard(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    shard: Shard,
    progress: Progress | None = None,
) -> ShardResult:
    """Write one shard into a run folder: the plan of the whole run, the photons of the shard, its manifest.

    Shards may share a folder or have folders of their own; the format is npy. `force` makes this shard again, and
    replaces no other run. A shard that is complete there is only read again. Any number of processes may make one
    shard at once: they make the same bytes, and the last rename holds.
    """
    if options.formats != FORMATS:
        raise UsageError("--shard writes npy alone; join the shards and export the run to other formats")
    check_memory(source, options)
    folder = RunFolder(out)
    with (
        folder.held(source.plan, force=options.force, shard=shard),
        ChunkPool(source, options.threads, shard) as pool,
    ):
        name, read = manifest_name(shard), partial(read_shard_manifest, shard=shard)
        head = manifest_head(source, scene, input_hashes(scene), FORMATS)
        finished = finished_manifest(pool, folder, name, read, FORMATS, progress)
        if finished is not None:
            return ShardResult(shard=shard, seconds=0.0, emitted=0, was_finished=True, manifest=finished)
        started, bands = time.perf_counter(), chosen_bands(source, scene.options)
        made = PhotonJob(pool, folder, [NpyWriter(source, shard)], bands).make(progress)
        seconds = time.perf_counter() - started
        record = run_record(seconds, made.emitted, pool.threads) | scene_path(scene, folder.path)
        manifest = build_shard_manifest(head, source, shard, bands, made.files, record)
        folder.write(name, manifest_bytes(manifest))
    return ShardResult(shard=shard, seconds=seconds, emitted=made.emitted, was_finished=False, manifest=manifest)
