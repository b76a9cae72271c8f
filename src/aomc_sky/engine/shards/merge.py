"""Shards of a run, joined into the files that the run makes in one go, every block checked on its way."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.engine.finished import finished_manifest
from aomc_sky.engine.job import Progress
from aomc_sky.engine.run import run_record, write_counts
from aomc_sky.engine.shards.copy import copy_shards
from aomc_sky.engine.shards.shard import FORMATS
from aomc_sky.engine.shards.shard_set import ShardSet, StoredShard, gather_shards
from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.blocks.shard import manifest_name
from aomc_sky.outputs.blocks.statistics import BandResult, band_result
from aomc_sky.outputs.folder.run_folder import MANIFEST, RunFolder
from aomc_sky.outputs.manifest.run import (
    build_manifest,
    chosen_bands,
    manifest_bytes,
    read_manifest,
    require_wavebands,
)
from aomc_sky.outputs.manifest.shard import head_of
from aomc_sky.outputs.photons.leaves import content_hash
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, slots=True)
class MergeResult:
    """What joining reports: the folder of the whole run, its bands and manifest, seconds, files of shards removed."""

    folder: Path
    bands: list[BandResult]
    n_shards: int
    seconds: float
    was_finished: bool
    removed: int
    manifest: dict[str, Any]


def merge_shards(
    runs: Sequence[Path],
    out: Path | None = None,
    *,
    remove_shards: bool = False,
    threads: int = 0,
    progress: Progress | None = None,
) -> MergeResult:
    """Join all shards of a run into the files of a run that was made in one go.

    Parameters
    ----------
    runs : sequence of Path
        Folders that hold the shards.
    out : Path, optional
        Folder of the whole run; the folder of the shards itself where there is one only.
    remove_shards : bool
        Remove the files of the shards when everything else is written.
    threads : int
        0 for one per CPU.
    progress : callable, optional
        Called with photons done and photons in all.

    Returns
    -------
    MergeResult
        A run that was joined before is only read again.

    Raises
    ------
    UsageError
        Several folders, and no `out`.
    ShardError
        Shards are missing, overlap, or are damaged; each is named, with the block.
    ForeignOutputError
        Shards of different runs, or `out` belongs to another one.
    OutputError
        The operating system refuses; nothing half is left, nor an empty folder.

    Notes
    -----
    Bytes are those of `run_job` with the format npy, in the manifest apart from ``run``. What the manifest says of
    the scene's files is taken from shard 1.
    """
    if out is None and len({path.resolve() for path in runs}) > 1:
        raise UsageError("shards of several folders need --out, the folder of the whole run")
    started = time.perf_counter()
    found = gather_shards(runs)
    source, folder = PhotonSource.from_plan(found.plan), RunFolder(out or runs[0])
    for stored in found.shards:
        require_wavebands(stored.folder.path / manifest_name(stored.shard), stored.manifest(), source.n_bands)
    with ChunkPool(source, threads) as pool:
        manifest = _joined_before(pool, folder, progress)
        was_finished = manifest is not None
        if manifest is None:
            found.require_whole()
            with folder.given_back_on_failure(), folder.held(found.plan, force=False):
                manifest = _join(pool, folder, found, started, progress)
    removed = _remove(found.plan, found.shards) if remove_shards else 0
    return MergeResult(
        folder=folder.path,
        bands=[BandResult(**band) for band in manifest["bands"]],
        n_shards=len(found.shards),
        seconds=time.perf_counter() - started,
        was_finished=was_finished,
        removed=removed,
        manifest=manifest,
    )


def _joined_before(pool: ChunkPool, folder: RunFolder, progress: Progress | None) -> dict[str, Any] | None:
    if folder.size_of(MANIFEST) is None:
        return None
    with folder.held(pool.source.plan, force=False):
        return finished_manifest(pool, folder, MANIFEST, read_manifest, FORMATS, progress)


def _join(
    pool: ChunkPool, folder: RunFolder, found: ShardSet, started: float, progress: Progress | None
) -> dict[str, Any]:
    source, head = pool.source, head_of(found.shards[0].manifest())
    bands = chosen_bands(source, head["options"]["scene"])
    copied = copy_shards(pool, folder, found.shards, bands, progress)
    files = write_counts(folder, source, bands) | copied.files
    results = [band_result(source, band, copied.sums[band]) for band in bands]
    record = run_record(time.perf_counter() - started, 0, pool.threads) | {"shards": len(found.shards)}
    record |= _scene_place(found.shards[0], folder.path)
    manifest = build_manifest(head, results, content_hash(folder, source, bands), files, record)
    folder.write(MANIFEST, manifest_bytes(manifest))
    return manifest


def _scene_place(stored: StoredShard, folder: Path) -> dict[str, str]:
    """Where amc.inp stands, seen from the folder of the whole run."""
    run = stored.manifest().get("run")
    place = run.get("scene") if isinstance(run, dict) else None
    return {"scene": os.path.relpath(stored.folder.path / place, folder)} if isinstance(place, str) else {}


def _remove(plan: Plan, shards: Sequence[StoredShard]) -> int:
    """Remove the files of shards, each manifest last: whoever is killed here finds by it what is left to remove."""
    removed, folders = 0, {stored.folder.path.resolve(): stored.folder for stored in shards}
    for path, folder in folders.items():
        with folder.held(plan, force=False):
            for stored in (stored for stored in shards if stored.folder.path.resolve() == path):
                for name in (*stored.manifest()["files"], manifest_name(stored.shard)):
                    if folder.size_of(name) is not None:
                        folder.remove(name)
                        removed += 1
    return removed
