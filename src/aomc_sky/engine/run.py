"""Every job: photons in chunks on threads, written in order, statistics that no split can change."""

from __future__ import annotations

import contextlib
import os
import platform
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from aomc_sky.errors import AomcSkyError, OutputError, UsageError
from aomc_sky.outputs import photon_writer
from aomc_sky.outputs.chunk_pool import BLOCK, ChunkPool, n_cpus
from aomc_sky.outputs.counts_csv import counts_file
from aomc_sky.outputs.manifest import BandResult, build_manifest, input_hashes, manifest_bytes, read_manifest
from aomc_sky.outputs.photon_files import PhotonFiles, photon_files
from aomc_sky.outputs.run_folder import MANIFEST, PLAN, RunFolder
from aomc_sky.outputs.statistics import PhotonSums, band_result, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from aomc_sky.source.start_up import expect_photons

Progress = Callable[[int, int], None]


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


def run_job(
    source: PhotonSource, scene: Scene, out: Path, options: JobOptions, progress: Progress | None = None
) -> JobResult:
    """Write a run folder: plan, counts, photons, manifest.

    Parameters
    ----------
    source, scene : PhotonSource, Scene
        The settled run and what it came from.
    out : Path
        The run folder.
    options : JobOptions
        Formats, threads, limits.
    progress : callable, optional
        Called with photons done and photons in all.

    Returns
    -------
    JobResult
        A run that was finished before is only read again.
    """
    _check_memory(source, options)
    folder = RunFolder(out)
    folder.claim(source.plan, force=options.force)
    finished = _finished(folder, source, options.formats)
    if finished is not None:
        bands = [BandResult(**band) for band in finished["bands"]]
        return JobResult(bands=bands, seconds=0.0, emitted=0, was_finished=True, manifest=finished)
    started = time.perf_counter()
    inputs = input_hashes(scene)
    chosen = _chosen_bands(source, scene)
    writers = {f: photon_writer(f)(source) for f in options.formats if f != "none"}
    photons = photon_files(folder, list(writers.values()), chosen)
    folder.require_space(sum(part.n_bytes_missing for part in photons))
    name, data = counts_file(source, chosen)
    folder.write(name, data)
    files = {PLAN: _entry(folder, PLAN), name: _entry(folder, name)}
    sums = {band: PhotonSums(source.replicates) for band in chosen}
    expect_photons(sum(source.n_photons(b) for b in chosen) if writers else 0)
    with ChunkPool(source, options.threads) as pool:
        emitted = _write_photons(pool, folder, photons, chosen, sums, progress)
    for part in photons:
        files |= part.entries()
    bands = [band_result(source, band, sums[band]) for band in chosen]
    seconds = time.perf_counter() - started
    run = _run_record(seconds, emitted, pool.threads) | _scene_place(scene, out)
    manifest = build_manifest(source, scene, inputs, bands, dict(sorted(files.items())), options.formats, run)
    folder.write(MANIFEST, manifest_bytes(manifest))
    return JobResult(bands=bands, seconds=seconds, emitted=emitted, was_finished=False, manifest=manifest)


def stream_job(
    source: PhotonSource, scene: Scene, pipe: BinaryIO, options: JobOptions, progress: Progress | None = None
) -> JobResult:
    """Write the photons of all bands to a pipe, in one format, one band after the other."""
    if len(options.formats) != 1 or options.formats[0] != "raw":
        raise UsageError("--out - needs --format raw, and no other format")
    started = time.perf_counter()
    writer = photon_writer(options.formats[0])(source)
    chosen = _chosen_bands(source, scene)
    sums = {band: PhotonSums(source.replicates) for band in chosen}
    total, done = sum(source.n_photons(b) for b in chosen), 0
    expect_photons(total)
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
        raise OutputError("the program that read standard output went away before the last photon") from None
    except OSError as error:
        raise OutputError(f"cannot write to standard output: {error.strerror or error}") from error


def _chosen_bands(source: PhotonSource, scene: Scene) -> list[int]:
    wanted = scene.options.get("wavebands")
    return [b - 1 for b in wanted] if wanted else list(range(source.n_bands))


def _entry(folder: RunFolder, name: str) -> dict[str, Any]:
    return {"bytes": folder.size_of(name), "sha256": folder.sha256_of(name)}


def _finished(folder: RunFolder, source: PhotonSource, formats: tuple[str, ...]) -> dict[str, Any] | None:
    """The manifest of a finished run of this plan and these formats whose files are all there."""
    if folder.size_of(MANIFEST) is None:
        return None
    with contextlib.suppress(AomcSkyError):  # a damaged manifest finishes nothing
        manifest = read_manifest(folder.path / MANIFEST)
        same = manifest["plan_sha256"] == source.plan.sha256 and manifest["options"]["formats"] == list(formats)
        whole = all(folder.size_of(name) == entry["bytes"] for name, entry in manifest["files"].items())
        if same and whole:
            return manifest
    folder.remove(MANIFEST)  # the folder is unfinished again until the new manifest stands
    return None


def _write_photons(
    pool: ChunkPool,
    folder: RunFolder,
    photons: list[PhotonFiles],
    bands: list[int],
    sums: dict[int, PhotonSums],
    progress: Progress | None,
) -> int:
    """Make the photon files that are missing and the statistics of all bands; return the photons emitted."""
    source = pool.source
    total = sum(source.n_photons(b) for b in bands) if photons else 0
    done = emitted = 0
    missing = [part for part in photons if not part.is_finished]
    finished = [part for part in photons if part not in missing]
    with contextlib.ExitStack() as stack:
        shared = [stack.enter_context(part) for part in missing if len(part.bands) > 1]
        for band in bands:
            own = [part for part in missing if part.bands == (band,)]
            if own or shared:
                emitted += source.n_photons(band)
                steps = _write_band(pool, own, shared, band, sums[band])
            elif photons:
                steps = _count_again(pool, folder, finished, band, sums[band])
            else:
                continue
            for n in steps:
                done += n
                if progress:
                    progress(done, total)
    return emitted


def _count_again(
    pool: ChunkPool, folder: RunFolder, finished: list[PhotonFiles], band: int, sums: PhotonSums
) -> Iterator[int]:
    """Take the statistics of a finished band from its file, or from the plan where that is rounded or weighted."""
    exact = next((part.writer for part in finished if part.bands == (band,) and part.writer.is_exact), None)
    if exact is None or pool.source.has_weights:
        for _, block, n in pool.chunks(band, []):
            sums.add(block)
            yield n
        return
    with folder.reading(exact.names((band,))[0]) as file:
        start = 0
        for uz in exact.stored_uz(file, band, BLOCK):
            sums.add(photon_sums(pool.source, band, start, uz, None))
            start += uz.size
            yield uz.size


def _write_band(
    pool: ChunkPool, own: list[PhotonFiles], shared: list[PhotonFiles], band: int, sums: PhotonSums
) -> Iterator[int]:
    with contextlib.ExitStack() as stack:
        parts = [*(stack.enter_context(part) for part in own), *shared]
        for chunks, block, n in pool.chunks(band, [part.writer for part in parts]):
            for part, chunk in zip(parts, chunks, strict=True):
                part.write(chunk)
            sums.add(block)
            yield n


def _check_memory(source: PhotonSource, options: JobOptions) -> None:
    if options.max_memory_bytes is None:
        return
    plan = 3 * sum(array.nbytes for array in source.plan.arrays.values())
    chunks = ((options.threads or n_cpus()) + 2) * BLOCK * 100
    if plan + chunks > options.max_memory_bytes:
        raise UsageError(
            f"this run needs about {(plan + chunks) / 2**20:.0f} MiB besides Python, more than --max-memory allows; "
            "run fewer wavebands at a time with --waveband"
        )


def _scene_place(scene: Scene, out: Path) -> dict[str, str]:
    """Where amc.inp stands, seen from the run folder, for exports that copy it; a place is no part of a run."""
    path = scene.input_files.get("amc")
    return {} if path is None else {"scene": os.path.relpath(path, out)}


def _run_record(seconds: float, emitted: int, threads: int) -> dict[str, Any]:
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
