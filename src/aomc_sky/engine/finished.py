"""A run or shard that was finished before: its manifest, if every file still is what it says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from aomc_sky.engine.job import Progress
from aomc_sky.errors import AomcSkyError
from aomc_sky.outputs.blocks.chunk_pool import ChunkPool
from aomc_sky.outputs.folder.run_folder import PLAN, RunFolder
from aomc_sky.outputs.manifest.file import ForgedManifestError, hash_matches
from aomc_sky.outputs.manifest.run import require_wavebands


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
    spans = (pool.shard.photons(pool.source.n_photons(band)) for band in range(pool.source.n_bands))
    n_photons, n_bytes = sum(end - first for first, end in spans), sum(entry["bytes"] for entry in files.values())
    for name, complete in zip(files, pool.in_order(is_complete, files), strict=True):
        damaged += [] if complete else [name]
        n_read += files[name]["bytes"]
        if progress:
            progress(n_photons * n_read // max(n_bytes, 1), n_photons)
    return damaged
