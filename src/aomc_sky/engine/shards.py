"""Shards of a run: each writes its photons into files of full size, and the last one finishes the run."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable
from functools import cache, partial
from pathlib import Path
from typing import Any

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.engine.run import (
    JobOptions,
    JobResult,
    Sums,
    as_stored,
    check_memory,
    finish_run,
    finished_manifest,
    remove_rest,
    write_counts,
)
from aomc_sky.errors import UsageError
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.counts import chosen_bands
from aomc_sky.outputs.manifest import scene_part, stated_of
from aomc_sky.outputs.photons.files import ChunkPool, Meter, PhotonFiles, Progress, RunFiles, block_spans
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.outputs.run_folder import PART, RunFolder
from aomc_sky.outputs.shard import Shard, marks_among
from aomc_sky.outputs.statistics import PhotonSums
from aomc_sky.source.scene import Scene
from aomc_sky.system import n_cpus

FORMATS = ("npy",)
"""What shards write; `export` turns a finished run into any other format."""

MAX_MARK_BYTES = 1 << 26


def run_shard(
    source: PhotonSource,
    scene: Scene,
    out: Path,
    options: JobOptions,
    shard: Shard,
    progress: Progress | None = None,
) -> JobResult:
    """Make the photons of one shard in the folder of the run; the last shard finishes the run.

    A shard with a mark is not made again, and a finished run is not changed. Several processes may make the same shard
    at once: they write the same bytes.
    """
    if options.force:
        raise UsageError("--force would remove what other shards made", "remove the folder, or leave --force out")
    check_memory(source, options)
    folder, started, emitted = RunFolder(out), time.perf_counter(), 0
    source = as_stored(source, folder)
    missing: list[Shard] = []
    files, of_scene = RunFiles(source, folder), cache(partial(scene_part, scene))
    with folder.held(source.plan, lambda: stated_of(of_scene())):
        manifest = finished_manifest(files, FORMATS)
        was_finished = manifest is not None
        if manifest is None:
            drop_stale_marks(source, folder)
            if read_mark(source, folder, shard) is None:
                with ChunkPool(source, options.threads) as pool:
                    made = make_shard(pool, folder, shard, progress)
                emitted = sum(band_sums.n_photons for band_sums in made.values())
            sums, missing = marked_sums(source, folder, shard.count)
            if not missing:
                finish_files(source, folder)
                manifest = finish_run(files, of_scene(), sums)
            elif (manifest := finished_manifest(files, FORMATS)) is not None:
                missing = []
        if manifest is not None:
            remove_rest(folder)  # another process finished the run, or was killed at its last step
    return JobResult(
        seconds=time.perf_counter() - started,
        emitted=emitted,
        was_finished=was_finished,
        manifest=manifest,
        threads=options.threads or n_cpus(),
        shard=shard,
        ranges=ranges_of(source, shard),
        missing=missing,
    )


def ranges_of(source: PhotonSource, shard: Shard) -> list[tuple[int, int, int]]:
    """Photons of a shard: waveband [0-based], first photon, end."""
    bands = chosen_bands(source)
    return [(bands[k], first, end) for k, first, end in shard.ranges([source.n_photons(band) for band in bands])]


def make_shard(pool: ChunkPool, folder: RunFolder, shard: Shard, progress: Progress | None = None) -> Sums:
    """Write the photons of a shard into the files of the run, then its mark; returns the sums over the photons."""
    source, ranges = pool.source, ranges_of(pool.source, shard)
    writer, meter = NpyWriter(source), Meter(progress, sum(end - first for _, first, end in ranges))
    row_bytes = sum(layout.row_bytes for layout in writer.layouts((0,)))
    layouts = [layout for band, _, _ in ranges for layout in writer.layouts((band,))]
    unwritten = sum(max(layout.size - folder.space_of(layout.name + PART), 0) for layout in layouts)
    needed = min(meter.total * row_bytes, unwritten)
    folder.require_space(needed, "finished shards are kept; run this one again when there is space")
    announce_photons(meter.total)
    sums = {}
    for band, first, end in ranges:
        files = PhotonFiles(folder, writer, (band,))
        files.reserve()
        with files.filling() as write:
            sums[band] = pool.emit(band, [(writer, write)], meter.add, block_spans(first, end))
    mark = {
        "plan_sha256": source.plan.sha256,
        "shard": shard.index,
        "of": shard.count,
        "bands": [{"waveband": band + 1, **band_sums.as_json()} for band, band_sums in sums.items()],
    }
    folder.write(shard.mark, json.dumps({"mark": mark, "sha256": _sha256(mark)}).encode())
    return sums


def _sha256(mark: Any) -> str:
    return hashlib.sha256(json.dumps(mark).encode()).hexdigest()


def read_mark(source: PhotonSource, folder: RunFolder, shard: Shard) -> Sums | None:
    """Sums over the photons of a shard, from its mark, or None without a valid mark of this run."""
    try:
        with folder.reading(shard.mark) as file:
            stored = json.loads(file.read(MAX_MARK_BYTES))
        mark = stored["mark"]
        if stored["sha256"] != _sha256(mark) or mark["plan_sha256"] != source.plan.sha256:
            return None
        if (mark["shard"], mark["of"]) != (shard.index, shard.count):
            return None  # a copy under another name
        sums = {band["waveband"] - 1: PhotonSums.from_json(band, source.replicates) for band in mark["bands"]}
    except Exception:  # whatever is in the file: the shard is made again
        return None
    expected = {band: end - first for band, first, end in ranges_of(source, shard)}
    return sums if {band: band_sums.n_photons for band, band_sums in sums.items()} == expected else None


def marked_sums(source: PhotonSource, folder: RunFolder, count: int) -> tuple[Sums, list[Shard]]:
    """Sums over all photons of `count` shards, from their marks, and the shards without a mark."""
    shards = [Shard(index=k + 1, count=count) for k in range(count)]
    marked = {*marks_among(folder.names(), count)}
    missing = [shard for shard in shards if shard not in marked]
    found = {} if missing else {shard: read_mark(source, folder, shard) for shard in shards}
    missing += [shard for shard, sums in found.items() if sums is None]
    return joined_sums(source, filter(None, found.values())), missing


def joined_sums(source: PhotonSource, parts: Iterable[Sums]) -> Sums:
    """Sums over the photons of several shards together."""
    sums = {band: PhotonSums(source.replicates) for band in chosen_bands(source)}
    for part in parts:
        for band, band_sums in part.items():
            sums[band].add_sums(band_sums)
    return sums


def finish_files(source: PhotonSource, folder: RunFolder) -> None:
    """Give the filled files their final names, make those of wavebands without photons, and write the counts."""
    for band in chosen_bands(source):
        files = PhotonFiles(folder, NpyWriter(source), (band,))
        if not source.n_photons(band):
            files.reserve()
        for layout in files.missing:
            folder.finish(layout.name)
    write_counts(source, folder)


def drop_stale_marks(source: PhotonSource, folder: RunFolder) -> None:
    """Remove marks whose files are gone or have another size.

    Marks are listed before files, and the temporary name of a file is tried before its final name: another process may
    make and rename files at the same time.
    """
    shards = marks_among(folder.names())
    layouts = {band: NpyWriter(source).layouts((band,)) for band in chosen_bands(source) if shards}
    there = {
        band
        for band, files in layouts.items()
        if all(f.size in (folder.size_of(f.name + PART), folder.size_of(f.name)) for f in files)
    }
    for shard in shards:
        if not {band for band, _, _ in ranges_of(source, shard)} <= there:
            folder.remove(shard.mark)
