"""Write a run folder (plan, counts, photons, manifest), or a stream of photons."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Unpack

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AomcSkyError, InputFileError, OutputError, UsageError, require_kind
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.report import more_memory
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.counts import COUNTS_FILES, chosen_bands, counts_file, in_columns_of
from aomc_sky.outputs.manifest import (
    build_manifest,
    differences,
    manifest_again,
    manifest_bytes,
    read_manifest,
    scene_part,
    stated_of,
)
from aomc_sky.outputs.photon_formats import SOURCE, SOURCE_FILE, RunFormatWord, photon_writer, run_formats
from aomc_sky.outputs.photons.files import (
    BLOCK,
    ChunkPool,
    Meter,
    PhotonFiles,
    Progress,
    RunFiles,
    emit_photons,
    missing_files,
    require_space,
    total_size,
)
from aomc_sky.outputs.run_folder import MANIFEST, PART, PLAN, RunFolder, check_folder, is_run_file
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_results
from aomc_sky.plan.options import Sampling
from aomc_sky.plan.plan import Plan, read_stated
from aomc_sky.progress import is_free, progress_bar
from aomc_sky.source.scene import Scene
from aomc_sky.system import drop_leftovers, n_cpus
from aomc_sky.whole_number import as_number_of

if TYPE_CHECKING:
    from aomc_sky.outputs.shard import Shard


@dataclass(frozen=True, kw_only=True, slots=True)
class JobOptions:
    """Formats, threads and limits of a job; they change no photon."""

    formats: tuple[str, ...] = ("npy",)
    threads: int = 0
    force: bool = False
    max_memory_bytes: int | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class JobResult:
    """The report of a finished job or shard."""

    bands: Sequence[BandResult] = ()  #: in order; none of a shard
    seconds: float
    emitted: int  #: photons that were made
    was_finished: bool = False  #: whether the whole run was finished before
    manifest: dict[str, Any] | None = None  #: of a finished run in a folder
    threads: int = 0
    shard: Shard | None = None  #: the part that was made, if not the whole run
    ranges: Sequence[tuple[int, int, int]] = ()  #: of the shard: waveband [0-based], first photon, end
    missing: Sequence[Shard] = ()  #: shards that are not made yet


Sums = dict[int, PhotonSums]
"""Sums over the photons of each waveband. [0-based]"""

Make = Callable[[PhotonSource, RunFolder, JobOptions, Progress | None], tuple[Sums, int]]
"""Writes counts and photons; returns the sums of all wavebands and how many photons were made."""


@in_default_mode
def write_run(
    scene: Scene,
    out: str | os.PathLike[str],
    *,
    seed: int = 0,
    formats: RunFormatWord | Sequence[RunFormatWord] = ("npy",),
    threads: int = 0,
    force: bool = False,
    **sampling: Unpack[Sampling],
) -> dict[str, Any]:
    """Write a run folder of any scene, as ``aomc-sky run`` does; `verify`, `export` and `plot` read it.

    Parameters
    ----------
    scene : Scene
        The light, from files or made in Python.
    out : str or path
        The run folder; it is made if it does not exist. A folder with the same run, finished or not, is continued.
    seed : int
        Seed of the run. [0 to 2^64 - 1]
    formats : sequence of {"npy", "mcpl", "raw", "source"}
        Photon files, or the source for other codes (`write_source`); an empty sequence: counts and plan only.
    threads : int
        Threads that make photons; 0 is all. The bytes do not depend on them. [0 to 1024]
    force : bool
        Replace another run of aomc-sky in the folder.
    **sampling
        Arguments of `Scene.source`: method, order, precision and so on.

    On a terminal and in notebooks a bar shows the progress after a second; TQDM_DISABLE=1 in the environment turns it
    off.

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
    require_kind(scene, Scene, "write_run(scene, out, seed=1)")
    several = not isinstance(formats, str) and isinstance(formats, Iterable)
    chosen: tuple[Any, ...] = tuple(dict.fromkeys(formats if several else [formats]))
    for name in chosen:
        if name not in run_formats():
            raise UsageError(f"formats are {', '.join(run_formats())}, got {name!r}")
    amc = scene.input_files.get("amc")
    check_folder(Path(out) if os.fspath(out) else "", "out", scene=None if amc is None else Path(amc).parent)
    n_threads, memory = as_number_of(threads, "threads", 0, 1024), sampling.get("max_memory_bytes")
    options = JobOptions(formats=chosen or ("none",), threads=n_threads, force=force, max_memory_bytes=memory)
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
    """Write a run folder: plan, counts, photons, manifest. A finished run is not made again.

    `progress` is called with photons done and photons in all. `make` fills the photon files; by default the threads of
    this process do.
    """
    check_memory(source, options)
    folder, started = RunFolder(out), time.perf_counter()
    if not options.force:
        source = as_stored(source, folder)
    files, of_scene = RunFiles(source, folder), cache(partial(scene_part, scene))  # its files are read when it is asked
    chosen = [part for name in options.formats if name not in ("none", SOURCE) for part in files.of(name)]
    with folder.held(source.plan, lambda: stated_of(of_scene()), force=options.force, n_bytes=total_size(chosen)):
        manifest = finished_manifest(files, options.formats)
        was_finished, emitted = manifest is not None, 0
        if manifest is None:
            if make is not None:
                sums, emitted = make(source, folder, options, progress)
            else:
                sums, emitted = make_photons(files, chosen, options, progress)
            manifest = finish_run(files, of_scene(), sums)
    return JobResult(
        bands=[BandResult(**band) for band in manifest["bands"]],
        seconds=time.perf_counter() - started,
        emitted=emitted,
        was_finished=was_finished,
        manifest=manifest,
        threads=options.threads or n_cpus(),
    )


def as_stored(source: PhotonSource, folder: RunFolder) -> PhotonSource:
    """The run in a folder, if it is this one: masses made on another processor may differ in their last digits."""
    if folder.size_of(PLAN) is None:
        return source
    try:
        stored = Plan.load(folder.path / PLAN)
    except AomcSkyError:  # `held` says why
        return source
    is_other = stored.sha256 != source.plan.sha256 and stored.agrees(source.plan)
    return PhotonSource.from_plan(stored) if is_other else source


def make_photons(
    files: RunFiles, chosen: Sequence[PhotonFiles], options: JobOptions, progress: Progress | None
) -> tuple[Sums, int]:
    """Write the counts, and make the missing photon files on the threads of this process.

    A file with its final name and the right size is kept and not read. Its photons are made once more for their sums.
    """
    source, missing = files.source, missing_files(chosen)
    require_space(missing)
    write_counts(source, files.folder)
    if SOURCE in options.formats:
        files.folder.write(SOURCE_FILE, source.to_bytes())
    if not chosen and not {*files.stored()[0]} - {SOURCE}:
        return {band: PhotonSums(source.replicates) for band in files.bands}, 0
    return emit_photons(source, missing, files.bands, options.threads, progress), source.total


def finish_run(files: RunFiles, scene_entries: dict[str, Any], sums: Sums) -> dict[str, Any]:
    """Write the manifest, and remove temporary files. Every process writes the same bytes."""
    results = band_results(files.source, {band: sums[band] for band in files.bands})
    stated = stated_of(scene_entries)
    if read_stated(files.folder.path / PLAN) != stated:  # the run was begun by another version, or with other comments
        files.folder.write(PLAN, files.source.plan.to_bytes(stated))
    data = manifest_bytes(build_manifest(files.source, scene_entries, results, *files.stored()))
    files.folder.write(MANIFEST, data)
    remove_rest(files.folder)
    return dict(json.loads(data))  # as a later call reads it


def remove_rest(folder: RunFolder) -> None:
    """Remove the marks and partial files of shards from a finished run, and what killed processes left."""
    drop_leftovers(folder.path, is_run_file)
    rest = [name for name in folder.names() if name.endswith((PART, ".done")) and is_run_file(name)]
    if rest:
        folder.remove(*rest)


def write_counts(source: PhotonSource, folder: RunFolder) -> None:
    """Write the counts, as text or, of very many rows, as arrays; no file of the other kind stays."""
    name, data = counts_file(source)
    folder.write(name, data)
    for other in COUNTS_FILES:
        if other != name and folder.size_of(other) is not None:
            folder.remove(other)


def finished_manifest(files: RunFiles, formats: Sequence[str]) -> dict[str, Any] | None:
    """The manifest of a run that has all files of these formats, or None if work is left.

    No photon is read: counts, sizes of files, and all that the manifest says besides means over photons, are compared.
    """
    folder = files.folder
    if folder.size_of(MANIFEST) is None:
        return None
    try:
        manifest = read_manifest(folder.path / MANIFEST)
    except InputFileError:
        return None
    complete, stored = files.stored()
    expected = manifest_again(files.source, manifest, {}, complete, stored)
    if not {*formats} - {"none"} <= {*complete} or next(differences(manifest, expected), None):
        return None
    name, counts = counts_file(files.source)
    if [one for one in COUNTS_FILES if one in stored] != [name]:
        return None
    with folder.reading(name) as file:
        found = file.read(len(counts) + 1)
    return manifest if found == in_columns_of(found, counts) else None


def stream_job(source: PhotonSource, pipe: BinaryIO, threads: int, progress: Progress | None = None) -> JobResult:
    """Write the photons of all bands to a pipe as raw records, one band after the other."""
    started = time.perf_counter()
    writer = photon_writer("raw")(source)
    chosen = chosen_bands(source)
    meter = Meter(progress, source.total)
    announce_photons(meter.total)
    try:
        with ChunkPool(source, threads) as pool:
            to_pipe = (writer, lambda band, start, chunks: pipe.write(chunks[0]))
            sums = {band: pool.emit(band, [to_pipe], meter.add) for band in chosen}
            pipe.flush()
    except BrokenPipeError:
        raise OutputError("the program that reads standard output ended before the last photon") from None
    except OSError as error:
        raise OutputError(f"cannot write to standard output: {error.strerror or error}") from error
    bands = band_results(source, sums)
    seconds = time.perf_counter() - started
    return JobResult(bands=bands, seconds=seconds, emitted=meter.done, threads=threads or n_cpus())


def check_memory(source: PhotonSource, options: JobOptions) -> None:
    """Raise, before any photon is made, if a job needs more memory than the user allows."""
    if options.max_memory_bytes is None:
        return
    plan = 3 * sum(array.nbytes for array in source.plan.members().values())
    chunks = ((options.threads or n_cpus()) + 2) * BLOCK * 100
    if plan + chunks > options.max_memory_bytes:
        raise UsageError(
            f"this run needs about {(plan + chunks) / 2**20:.0f} MiB besides Python, more than --max-memory allows",
            f"use fewer threads or larger cells, or {more_memory(plan + chunks)}",
        )
