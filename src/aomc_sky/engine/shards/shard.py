"""One shard of a run: part k of K of its photons, made anywhere, with no coordinator."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from aomc_sky.engine.finished import finished_manifest
from aomc_sky.engine.job import PhotonJob, Progress
from aomc_sky.engine.run import JobOptions, check_memory, run_record, scene_path
from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.blocks.shard import Shard, manifest_name
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest.run import chosen_bands, input_hashes, manifest_bytes, manifest_head
from aomc_sky.outputs.manifest.shard import build_shard_manifest, read_shard_manifest
from aomc_sky.outputs.photons.npy import NpyWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Origin:
    """What a shard must know of the scene besides the plan."""

    head: dict[str, Any]  #: what the manifests of all shards, and of the run, begin with
    scene_path: dict[str, str]  #: of amc.inp, if it is a file
    bands: tuple[int, ...]  #: wavebands of the run [0-based]


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
    replaces no other run. A shard that stands there complete is only read again. Any number of processes may make one
    shard at once: they make the same bytes, and the last rename holds.
    """
    if options.formats != FORMATS:
        raise UsageError("--shard writes npy alone; join the shards and export the run to other formats")
    check_memory(source, options)
    folder = RunFolder(out)
    with folder.held(source.plan, force=options.force, shard=shard):
        origin = origin_of(source, scene, folder)
        return make_shard(source, folder, shard, origin, threads=options.threads, progress=progress)


def origin_of(source: PhotonSource, scene: Scene, folder: RunFolder) -> Origin:
    """What the shards of a run must know of its scene."""
    return Origin(
        head=manifest_head(source, scene, input_hashes(scene), FORMATS),
        scene_path=scene_path(scene, folder.path),
        bands=tuple(chosen_bands(source, scene.options)),
    )


def make_shard(
    source: PhotonSource,
    folder: RunFolder,
    shard: Shard,
    origin: Origin,
    *,
    threads: int = 0,
    progress: Progress | None = None,
) -> ShardResult:
    """Write one shard into a folder that is claimed for the plan, as `run_shard` does."""
    name = manifest_name(shard)
    with ChunkPool(source, threads, shard) as pool:
        read = partial(read_shard_manifest, shard=shard)
        finished = finished_manifest(pool, folder, name, read, FORMATS, progress)
        if finished is not None:
            return ShardResult(shard=shard, seconds=0.0, emitted=0, was_finished=True, manifest=finished)
        started = time.perf_counter()
        made = PhotonJob(pool, folder, [NpyWriter(source, shard)], list(origin.bands)).make(progress)
        seconds = time.perf_counter() - started
        record = run_record(seconds, made.emitted, pool.threads) | origin.scene_path
        manifest = build_shard_manifest(origin.head, source, shard, origin.bands, made.files, record)
        folder.write(name, manifest_bytes(manifest))
    return ShardResult(shard=shard, seconds=seconds, emitted=made.emitted, was_finished=False, manifest=manifest)
