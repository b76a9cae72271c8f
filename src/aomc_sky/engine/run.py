"""A run folder, or a stream of photons: plan, counts, photons, manifest."""

from __future__ import annotations

import contextlib
import json
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import InputFileError, OutputError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.counts import COUNTS_FILES, counts_file
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.folder.target_file import check_folder
from aomc_sky.outputs.manifest import build_manifest, chosen_bands, manifest_bytes, read_manifest, scene_part
from aomc_sky.outputs.photon_formats import FOLDER_FORMATS, photon_writer
from aomc_sky.outputs.photons.files import (
    ChunkPool,
    Meter,
    Progress,
    complete_formats,
    photon_files,
    run_files,
    stored_files,
)
from aomc_sky.outputs.shard import BLOCK, MANIFEST, PART, is_run_file
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_result
from aomc_sky.progress import is_free, progress_bar
from aomc_sky.source.scene import Scene
from aomc_sky.system import n_cpus
from aomc_sky.whole_number import as_number_of


@dataclass(frozen=True, kw_only=True, slots=True)
class JobOptions:
    """What a job writes and with what means; nothing here changes a photon."""

    formats: tuple[str, ...] = ("npy",)
    threads: int = 0
    force: bool = False
    max_memory_bytes: int | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class JobResult:
    """What a finished job reports: bands in order, seconds, photons made, and the manifest (None for a pipe)."""

    bands: list[BandResult]
    seconds: float
    emitted: int
    was_finished: bool
    manifest: dict[str, Any] | None
    threads: int = 0


Sums = dict[int, PhotonSums]
"""Sums over the photons of each waveband. [0-based]"""

Make = Callable[[PhotonSource, RunFolder, Sequence[str], JobOptions, Progress | None], tuple[Sums, int]]
"""Writes counts and photons of some formats; returns the sums of all wavebands and how many photons were made."""


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

    On a terminal and in notebooks a bar shows the progress of what takes longer than a second; TQDM_DISABLE=1 in the
    environment shows none.

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

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="overcast")
    >>> result = sky.write_run(scene, "cloudy", seed=1)
    >>> np.load("cloudy/photons-0001.npy").shape
    (1000, 3)
    """
    chosen = tuple(dict.fromkeys([formats] if isinstance(formats, str) else formats))
    unknown = [name for name in chosen if name not in FOLDER_FORMATS]
    if unknown:
        raise UsageError(f"formats are {', '.join(FOLDER_FORMATS)}, got {unknown[0]!r}")
    amc = scene.input_files.get("amc")
    check_folder(Path(out) if os.fspath(out) else "", "out", scene=None if amc is None else Path(amc).parent)
    n_threads = as_number_of(threads, "threads", 0, 1024)
    options = JobOptions(
        formats=chosen or ("none",),
        threads=n_threads,
        force=force,
        max_memory_bytes=sampling.get("max_memory_bytes"),
    )
    with progress_bar(enabled=is_free()) as progress:
        manifest = run_job(scene.source(seed, **sampling), scene, Path(out), options, progress).manifest
    assert manifest is not None, "only a pipe has none"
    return manifest


def run_job(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    progress: Progress | None = None,
    *,
    make: Make | None = None,
) -> JobResult:
    """Write a run folder: plan, counts, photons, manifest. Nothing of a run that was finished before is made again.

    `progress` is called with photons done and photons in all. `make` fills the photon files, by default the threads of
    this process.
    """
    check_memory(source, options)
    folder, started = RunFolder(out), time.perf_counter()
    with folder.held(source.plan, force=options.force):
        manifest = finished_manifest(source, folder, options.formats)
        was_finished, emitted = manifest is not None, 0
        if manifest is None:
            sums, emitted = (make or make_photons)(source, folder, options.formats, options, progress)
            manifest = finish_run(source, scene, folder, sums)
    return JobResult(
        bands=[BandResult(**band) for band in manifest["bands"]],
        seconds=time.perf_counter() - started,
        emitted=emitted,
        was_finished=was_finished,
        manifest=manifest,
        threads=options.threads or n_cpus(),
    )


def make_photons(
    source: PhotonSource, folder: RunFolder, formats: Sequence[str], options: JobOptions, progress: Progress | None
) -> tuple[Sums, int]:
    """Write the counts, and make the photon files that are missing on the threads of this process.

    A file under its final name with the right size is kept and not read: its photons are made once more for their sums.
    """
    bands = chosen_bands(source)
    writers = [photon_writer(name)(source) for name in formats if name != "none"]
    files = photon_files(folder, writers, bands)
    missing = [of_part for of_part in files if of_part.missing]
    folder.require_space(sum(of_part.n_bytes_missing for of_part in missing))
    write_counts(source, folder)
    if not files and not complete_formats(stored_files(source, folder, bands)):
        return {band: PhotonSums(source.replicates) for band in bands}, 0
    meter = Meter(progress, sum(source.n_photons(band) for band in bands))
    announce_photons(meter.total)
    sums = {}
    with ChunkPool(source, options.threads) as pool, contextlib.ExitStack() as stack:
        shared = [(f.writer, stack.enter_context(f.writing())) for f in missing if len(f.bands) > 1]
        for band in bands:
            with contextlib.ExitStack() as of_band:
                own = [(f.writer, of_band.enter_context(f.writing())) for f in missing if f.bands == (band,)]
                sums[band] = pool.emit(band, [*own, *shared], meter.add)
    return sums, meter.done


def write_counts(source: PhotonSource, folder: RunFolder) -> None:
    """Write counts.csv or counts.npz."""
    name, data = counts_file(source, chosen_bands(source))
    folder.write(name, data)


def finish_run(source: PhotonSource, scene: Scene, folder: RunFolder, sums: Sums) -> dict[str, Any]:
    """Write the manifest, and remove what was needed on the way. Whoever does it writes the same bytes."""
    bands = chosen_bands(source)
    results = [band_result(source, band, sums[band]) for band in bands]
    stored = stored_files(source, folder, bands)
    manifest = build_manifest(source, scene_part(scene), results, complete_formats(stored), run_files(folder, stored))
    data = manifest_bytes(manifest)
    folder.write(MANIFEST, data)
    remove_rest(folder)
    return dict(json.loads(data))  # what a later call reads


def remove_rest(folder: RunFolder) -> None:
    """Remove the marks of shards and what they fill, once the run is finished."""
    for name in folder.names():
        if name.endswith((PART, ".done")) and is_run_file(name):
            folder.remove(name)


def finished_manifest(source: PhotonSource, folder: RunFolder, formats: Sequence[str]) -> dict[str, Any] | None:
    """The manifest of a run that has all files of some formats; None where there is work left. No photon is read."""
    if folder.size_of(MANIFEST) is None:
        return None
    try:
        manifest = read_manifest(folder.path / MANIFEST)
    except InputFileError:
        return None
    stored, files = stored_files(source, folder, chosen_bands(source)), manifest["files"]
    is_known = all(size == files.get(name, {}).get("bytes") for name, size in run_files(folder, stored).items())
    has_counts = any(name in files and folder.size_of(name) is not None for name in COUNTS_FILES)
    is_complete = {*formats} - {"none"} <= {*complete_formats(stored)}
    is_same = manifest["plan_sha256"] == source.plan.sha256
    return manifest if is_same and is_known and has_counts and is_complete else None


def stream_job(
    source: PhotonSource, scene: Scene, pipe: BinaryIO, options: JobOptions, progress: Progress | None = None
) -> JobResult:
    """Write the photons of all bands to a pipe, in one format, one band after the other."""
    if len(options.formats) != 1 or options.formats[0] != "raw":
        raise UsageError("--out - needs --format raw, and no other format")
    started = time.perf_counter()
    writer = photon_writer(options.formats[0])(source)
    chosen = chosen_bands(source)
    meter = Meter(progress, sum(source.n_photons(b) for b in chosen))
    announce_photons(meter.total)
    with _pipe_errors(), ChunkPool(source, options.threads) as pool:
        to_pipe = (writer, lambda band, start, chunks: pipe.write(chunks[0]))
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


def run_record(seconds: float, emitted: int, threads: int) -> dict[str, Any]:
    """Time, speed and machine of a command: printed, and no part of the files."""
    from importlib.metadata import version

    return {
        "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "seconds": round(seconds, 6),
        "photons_per_second": round(emitted / seconds) if seconds > 0 else None,
        "threads": threads,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": version("numba"),
        "machine": platform.machine(),
    }
