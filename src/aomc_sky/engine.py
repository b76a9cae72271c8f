"""Every job: photons in chunks on threads, written in order, statistics that no split can change."""

from __future__ import annotations

import contextlib
import hashlib
import math
import os
import platform
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs import photon_writer
from aomc_sky.outputs.counts_csv import counts_file
from aomc_sky.outputs.manifest import BandResult, build_manifest, finite, manifest_bytes, read_manifest
from aomc_sky.outputs.run_folder import MANIFEST, PLAN, RunFolder
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch
from aomc_sky.source.scene import Scene

BLOCK = 65_536
"""Photons of a chunk of work and of a block of statistics; part of what makes runs reproducible."""

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


class _Sums:
    """Means of mu and 1/mu over blocks, combined exactly."""

    def __init__(self) -> None:
        self.mu: list[float] = []
        self.inverse: list[float] = []

    def add(self, sums: tuple[float, float]) -> None:
        self.mu.append(sums[0])
        self.inverse.append(sums[1])

    def means(self, n: int) -> tuple[float | None, float | None]:
        """Mean cosine and Ed/Eo of n photons."""
        if n == 0 or not self.mu:
            return None, None
        total = math.fsum(self.inverse) if all(map(math.isfinite, self.inverse)) else math.inf
        return math.fsum(self.mu) / n, n / total


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
    chosen = _chosen_bands(source, scene)
    name, data = counts_file(source, chosen)
    folder.write(name, data)
    files = {PLAN: _entry(folder, PLAN), name: _entry(folder, name)}
    writers = {f: photon_writer(f)(source) for f in options.formats if f != "none"}
    sums = {band: _Sums() for band in chosen}
    with _Pool(source, options.threads) as pool:
        emitted = _write_photons(pool, folder, writers, chosen, sums, files, progress)
    bands = [band_result(source, band, sums[band]) for band in chosen]
    seconds = time.perf_counter() - started
    run = _run_record(seconds, emitted, pool.threads)
    manifest = build_manifest(source, scene, bands, dict(sorted(files.items())), options.formats, run)
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
    sums = {band: _Sums() for band in chosen}
    total, done = sum(source.n_photons(b) for b in chosen), 0
    with _Pool(source, options.threads) as pool:
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


def _chosen_bands(source: PhotonSource, scene: Scene) -> list[int]:
    wanted = scene.options.get("wavebands")
    return [b - 1 for b in wanted] if wanted else list(range(source.n_bands))


def band_result(source: PhotonSource, band: int, sums: _Sums | None = None) -> BandResult:
    """Compare the photons of a band with the exact values of its masses."""
    arrays, moments = source.plan.arrays, source.exact_moments(band)
    requested, launched = int(arrays["requested"][band]), source.n_photons(band)
    mean_cosine, ratio = (None, None) if sums is None else sums.means(launched)
    return BandResult(
        waveband=band + 1,
        wavelength_nm=float(arrays["wavelength_nm"][band]),
        sky_wavelength_nm=finite(float(arrays["sky_wavelength_nm"][band])),
        requested=requested,
        launched=launched,
        residual=launched - requested,
        mean_cosine_exact=finite(moments.mean_mu),
        mean_cosine_photons=mean_cosine,
        ed_over_eo_exact=finite(moments.planar_over_scalar),
        ed_over_eo_photons=ratio,
    )


def _entry(folder: RunFolder, name: str) -> dict[str, Any]:
    return {"bytes": folder.size_of(name), "sha256": folder.sha256_of(name)}


def _finished(folder: RunFolder, source: PhotonSource, formats: tuple[str, ...]) -> dict[str, Any] | None:
    """The manifest of a finished run of this plan and these formats whose files are all there."""
    if folder.size_of(MANIFEST) is None:
        return None
    manifest = read_manifest(folder.path / MANIFEST)
    same = manifest["plan_sha256"] == source.plan.sha256 and manifest["options"]["formats"] == list(formats)
    whole = all(folder.size_of(name) == entry["bytes"] for name, entry in manifest["files"].items())
    if same and whole:
        return manifest
    (folder.path / MANIFEST).unlink()  # the folder is unfinished again until the new manifest stands
    return None


def _write_photons(
    pool: _Pool,
    folder: RunFolder,
    writers: dict[str, Any],
    bands: list[int],
    sums: dict[int, _Sums],
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
            writer = next(iter(writers.values()))
            for uz in writer.stored_uz(str(folder.path / writer.names(band)[0]), BLOCK):
                sums[band].add(_block_sums(uz))
            done += n
            if progress:
                progress(done, total)
    return emitted


def _is_there(folder: RunFolder, writer: Any, band: int, n: int) -> bool:
    """Whether all files of a band are finished; names appear only when files are complete."""
    return all(folder.size_of(name) == size for name, size in zip(writer.names(band), writer.sizes(n), strict=True))


def _write_band(
    pool: _Pool, folder: RunFolder, writers: list[Any], band: int, sums: _Sums, files: dict[str, dict[str, Any]]
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


def _block_sums(uz: np.ndarray) -> tuple[float, float]:
    """Sums of mu and 1/mu over a block; the plain and the compiled form add in the same order."""
    if "aomc_sky.kernels.emit" in sys.modules:
        from aomc_sky.kernels.statistics import block_sums

        return block_sums(uz)
    from aomc_sky.kernels import plain

    return plain.block_sums(uz)


class _Pool:
    """Threads that emit the chunks of a band ahead of the one that is written, in bounded memory."""

    def __init__(self, source: PhotonSource, threads: int) -> None:
        self.source = source
        self.threads = threads or len(os.sched_getaffinity(0))
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")
        self._free: deque[PhotonBatch] = deque()

    def __enter__(self) -> _Pool:
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def chunks(
        self, band: int, writers: list[Any]
    ) -> Iterator[tuple[list[tuple[memoryview, ...]], tuple[float, float], int]]:
        """Yield bytes per writer, sums and size of every block of a band, in order."""
        n = self.source.n_photons(band)
        waiting: deque[Future[Any]] = deque()
        starts = iter(range(0, n, BLOCK))
        for start in starts:
            waiting.append(self._executor.submit(self._chunk, band, start, min(start + BLOCK, n), writers))
            if len(waiting) > self.threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()

    def _chunk(self, band: int, start: int, stop: int, writers: list[Any]) -> Any:
        try:
            buffer = self._free.popleft()
        except IndexError:
            buffer = self._new_buffer()
        batch = self.source.photons(band, start, stop, out=buffer)
        chunks = [writer.chunks(batch) for writer in writers]
        sums = _block_sums(batch.uz)
        self._free.append(buffer)
        return chunks, sums, stop - start

    def _new_buffer(self) -> PhotonBatch:
        dtype, source = self.source.dtype, self.source
        return PhotonBatch(
            ux=np.empty(BLOCK, dtype),
            uy=np.empty(BLOCK, dtype),
            uz=np.empty(BLOCK, dtype),
            patch=np.empty(BLOCK, np.int32),
            band=0,
            start=0,
            wavelength_nm=math.nan,
            x=np.empty(BLOCK, dtype) if source.has_positions else None,
            y=np.empty(BLOCK, dtype) if source.has_positions else None,
            weight=np.empty(BLOCK, dtype) if source.has_weights else None,
        )


def _check_memory(source: PhotonSource, options: JobOptions) -> None:
    if options.max_memory_bytes is None:
        return
    plan = 3 * sum(array.nbytes for array in source.plan.arrays.values())
    chunks = (options.threads or len(os.sched_getaffinity(0)) + 2) * BLOCK * 100
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
