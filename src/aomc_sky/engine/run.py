"""Every job: photons in chunks on threads, written in order, statistics that no split can change."""

from __future__ import annotations

import contextlib
import hashlib
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
from aomc_sky.outputs.run_folder import MANIFEST, PLAN, RunFolder
from aomc_sky.outputs.statistics import PhotonSums, band_result, block_sums
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
    folder.require_space(_bytes_missing(folder, source, writers, chosen))
    name, data = counts_file(source, chosen)
    folder.write(name, data)
    files = {PLAN: _entry(folder, PLAN), name: _entry(folder, name)}
    sums = {band: PhotonSums() for band in chosen}
    expect_photons(sum(source.n_photons(b) for b in chosen) if writers else 0)
    with ChunkPool(source, options.threads) as pool:
        emitted = _write_photons(pool, folder, writers, chosen, sums, files, progress)
    bands = [band_result(source, band, sums[band]) for band in chosen]
    seconds = time.perf_counter() - started
    run = _run_record(seconds, emitted, pool.threads)
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
    sums = {band: PhotonSums() for band in chosen}
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


def _bytes_missing(folder: RunFolder, source: PhotonSource, writers: dict[str, Any], bands: list[int]) -> int:
    """Length of the photon files that are still to be made. [bytes]"""
    missing = 0
    for writer in writers.values():
        for band in bands:
            sizes = writer.sizes(source.n_photons(band))
            missing += sum(
                size for name, size in zip(writer.names(band), sizes, strict=True) if folder.size_of(name) != size
            )
    return missing


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
    writers: dict[str, Any],
    bands: list[int],
    sums: dict[int, PhotonSums],
    files: dict[str, dict[str, Any]],
    progress: Progress | None,
) -> int:
    source = pool.source
    total = sum(source.n_photons(b) for b in bands) if writers else 0
    done = emitted = 0
    for band in bands:
        n = source.n_photons(band)
        missing = {f: w for f, w in writers.items() if not _is_there(folder, w, band, n)}
        for name in (name for w in writers.values() for name in w.names(band) if w not in missing.values()):
            files[name] = _entry(folder, name)
        if missing:
            emitted += n
            for m in _write_band(pool, folder, list(missing.values()), band, sums[band], files):
                done += m
                if progress:
                    progress(done, total)
        elif writers:
            _count_again(pool, folder, list(writers.values()), band, sums[band])
            done += n
            if progress:
                progress(done, total)
    return emitted


def _count_again(pool: ChunkPool, folder: RunFolder, writers: list[Any], band: int, sums: PhotonSums) -> None:
    """Take the statistics of a finished band from its file, or from the plan where the file is rounded."""
    exact = next((w for w in writers if w.is_exact), None)
    if exact is None:
        for _, block, _ in pool.chunks(band, []):
            sums.add(block)
        return
    with folder.reading(exact.names(band)[0]) as file:
        for uz in exact.stored_uz(file, pool.source.n_photons(band), BLOCK):
            sums.add(block_sums(uz))


def _is_there(folder: RunFolder, writer: Any, band: int, n: int) -> bool:
    """Whether all files of a band are finished; names appear only when files are complete."""
    return all(folder.size_of(name) == size for name, size in zip(writer.names(band), writer.sizes(n), strict=True))


def _write_band(
    pool: ChunkPool,
    folder: RunFolder,
    writers: list[Any],
    band: int,
    sums: PhotonSums,
    files: dict[str, dict[str, Any]],
) -> Iterator[int]:
    n = pool.source.n_photons(band)
    names = [name for w in writers for name in w.names(band)]
    heads = [head for w in writers for head in w.headers(n)]
    digests = [hashlib.sha256(head) for head in heads]
    with contextlib.ExitStack() as stack:
        streams = [stack.enter_context(folder.stream(name)) for name in names]
        for stream, head in zip(streams, heads, strict=True):
            stream.write(head)
        for chunks, block, m in pool.chunks(band, writers):
            flat = [chunk for of_writer in chunks for chunk in of_writer]
            for stream, digest, chunk in zip(streams, digests, flat, strict=True):
                stream.write(chunk)
                digest.update(chunk)
            sums.add(block)
            yield m
    for name, digest in zip(names, digests, strict=True):
        files[name] = {"bytes": folder.size_of(name), "sha256": digest.hexdigest()}


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
