"""A run or shard that was finished before: its manifest, if every file still is what it says."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError
from aomc_sky.outputs.chunk_pool import ChunkPool
from aomc_sky.outputs.run_folder import PLAN, RunFolder


def finished_manifest(
    pool: ChunkPool,
    folder: RunFolder,
    name: str,
    read: Callable[[Path], dict[str, Any]],
    formats: tuple[str, ...],
) -> dict[str, Any] | None:
    """Return the manifest of a finished run of this plan and these formats, None where there is work left.

    Every file that the manifest lists is read and compared with its SHA-256. Where that fails the manifest is
    removed, so that the folder is unfinished, and then the damaged files, so that they are made again.
    """
    if folder.size_of(name) is None:
        return None
    manifest = None
    with contextlib.suppress(AomcSkyError):  # a damaged manifest finishes nothing
        manifest = read(folder.path / name)
        if manifest["plan_sha256"] != pool.source.plan.sha256 or manifest["options"]["formats"] != list(formats):
            manifest = None
    damaged = [] if manifest is None else _damaged(pool, folder, manifest["files"])
    if manifest is not None and not damaged:
        return manifest
    folder.remove(name)
    for file in damaged:
        if file == PLAN:  # never away: a folder without a plan belongs to nobody
            folder.write(PLAN, pool.source.plan.to_bytes())
        else:
            folder.remove(file)
    return None


def _damaged(pool: ChunkPool, folder: RunFolder, files: dict[str, dict[str, Any]]) -> list[str]:
    def is_whole(name: str) -> bool:
        return folder.size_of(name) == files[name]["bytes"] and folder.sha256_of(name) == files[name]["sha256"]

    return [name for name, whole in zip(files, pool.in_order(is_whole, files), strict=True) if not whole]
