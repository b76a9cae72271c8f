"""A run folder, one shard of it, or a stream of photons: plan, counts, photons, manifest."""

from __future__ import annotations

import contextlib
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from aomc_sky.engine.job import PhotonJob, Progress, finished_manifest
from aomc_sky.errors import OutputError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.blocks import BLOCK, ChunkPool, Shard, manifest_name, n_cpus
from aomc_sky.outputs.counts import counts_file
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.folder.target_file import check_folder
from aomc_sky.outputs.manifest import (
    build_manifest,
    build_shard_manifest,
    chosen_bands,
    input_hashes,
    manifest_bytes,
    manifest_head,
    read_manifest,
    read_shard_manifest,
)
from aomc_sky.outputs.names import MANIFEST, PLAN
from aomc_sky.outputs.photons.files import photon_writer
from aomc_sky.outputs.photons.leaves import content_hash
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_result
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
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


def write_counts(folder: RunFolder, source: PhotonSource, bands: list[int]) -> dict[str, dict[str, Any]]:
    """Write counts.csv or counts.npz; return the manifest's entries of it and of the plan."""
    name, data = counts_file(source, bands)
    folder.write(name, data)
    return {file: {"bytes": folder.size_of(file), "sha256": folder.sha256_of(file)} for file in (PLAN, name)}


def stream_job(
    source: PhotonSource, scene: Scene, pipe: BinaryIO, options: JobOptions, progress: Progress | None = None
) -> JobResult:
    """Write the photons of all bands to a pipe, in one format, one band after the other."""
    if len(options.formats) != 1 or options.formats[0] != "raw":
        raise UsageError("--out - needs --format raw, and no other format")
    started = time.perf_counter()
    writer = photon_writer(options.formats[0])(source)
    chosen = chosen_bands(source, scene.options)
    sums = {band: PhotonSums(source.replicates) for band in chosen}
    total, done = sum(source.n_photons(b) for b in chosen), 0
    announce_photons(total)
    with _pipe_errors(), ChunkPool(source, options.threads) as pool:
        for band in chosen:
            for chunks, block, n in pool.chunks(band, [writer]):
                pipe.write(chunks[0][0])
                sums[band].add(block)
                done += n
                if progress:
                    progress(done, total)
        pipe.flush()
    bands = [band_result(source, band, sums[band]) for band in chosen]
    seconds = time.perf_counter() - started
    return JobResult(bands=bands, seconds=seconds, emitted=done, was_finished=False, manifest=None)


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
    from importlib.metadata import version

    return {
        "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "seconds": round(seconds, 6),
        "photons_per_second": round(emitted / seconds) if seconds > 0 else None,
        "threads": threads,
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
        "machine": platform.machine(),
    }


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
