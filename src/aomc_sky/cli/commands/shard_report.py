"""The texts of shards: what ``run --shard`` and ``merge`` print."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from aomc_sky.cli.commands.run_report import band_table, effort_text, notes_text

if TYPE_CHECKING:
    from aomc_sky.engine.shards.merge import MergeResult
    from aomc_sky.engine.shards.shard import ShardResult
    from aomc_sky.source.photon_source import PhotonSource
    from aomc_sky.source.scene import Scene


def shard_text(scene: Scene, source: PhotonSource, result: ShardResult, folder: Path, *, verbose: bool) -> str:
    """What a shard prints when it is done."""
    bands = result.manifest["bands"]
    plural = "s" if len(bands) > 1 else ""
    what = "shard" if result.was_finished else ""
    lines = [
        *notes_text(scene, source, verbose=verbose),
        f"shard {result.shard}: {result.n_photons} photons in {len(bands)} waveband{plural}, seed {source.plan.seed}",
        *(f"waveband {band['waveband']}: {_span(band['first_photon'], band['n_photons'])}" for band in bands[:40]),
        *([f"... and {len(bands) - 40} more wavebands"] if len(bands) > 40 else []),
        *([effort_text(result.emitted, result.seconds, what=what)] if result.n_photons else []),
        f"plan {source.plan.sha256[:16]}, folder {folder}",
    ]
    return "\n".join(lines)


def _span(first: int, n_photons: int) -> str:
    return f"photons {first} to {first + n_photons - 1}" if n_photons else "no photons (more shards than blocks)"


def merge_text(result: MergeResult) -> str:
    """What a merge prints when it is done."""
    launched = sum(band.launched for band in result.bands)
    lines = [band_table(result.bands), ""]
    if result.was_finished:
        lines.append("this run was joined before and stands here whole; nothing was done again")
    else:
        shards = f"{result.n_shards} shard{'s' if result.n_shards > 1 else ''}"
        lines.append(f"{launched} photons of {shards} joined in {result.seconds:.2f} s, every block checked")
    if result.removed:
        lines.append(f"{result.removed} files of shards removed")
    content = result.manifest["content"]["root"][:16]
    lines.append(f"plan {result.manifest['plan_sha256'][:16]}, content {content}, folder {result.folder}")
    return "\n".join(lines)
