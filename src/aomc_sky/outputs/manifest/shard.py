"""``manifest.k003-of-100.json``: what one finished shard of a run holds, and what joining the shards must know."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from aomc_sky.outputs.blocks.shard import Shard
from aomc_sky.outputs.manifest.file import load_manifest, manifest_error
from aomc_sky.outputs.manifest.run import SCHEMA, add_run_record
from aomc_sky.outputs.names import shard_of_file
from aomc_sky.source.photon_source import PhotonSource

SHARD_SCHEMA = "aomc-sky-shard/1"


def build_shard_manifest(
    head: dict[str, Any],
    source: PhotonSource,
    shard: Shard,
    bands: Sequence[int],
    files: dict[str, dict[str, Any]],
    run: dict[str, Any],
) -> dict[str, Any]:
    """Put the manifest of a shard together; that of the whole run begins with the same `head`."""
    rest = head | {
        "schema": SHARD_SCHEMA,
        "shard": {"index": shard.index, "count": shard.count},
        "bands": [_band(source, shard, band) for band in bands],
        "files": dict(sorted(files.items())),
    }
    return add_run_record(rest, run)


def _band(source: PhotonSource, shard: Shard, band: int) -> dict[str, int]:
    first, end = shard.photons(source.n_photons(band))
    return {"waveband": band + 1, "first_photon": first, "n_photons": end - first}


def read_shard_manifest(path: str | Path, shard: Shard) -> dict[str, Any]:
    """Read the manifest of this shard as `load_manifest`; E963 where it is of another one or lists its files."""
    manifest = load_manifest(path, "shard_manifest.schema.json")
    index, count = manifest["shard"]["index"], manifest["shard"]["count"]
    if (index, count) != (shard.index, shard.count):
        raise manifest_error(path, "E963", f"this is the manifest of shard {index}/{count}")
    for name in manifest["files"]:
        if shard_of_file(name) != shard or name.startswith("manifest."):
            raise manifest_error(path, "E963", f"{name!r} is no photon file of shard {shard}", manifest)
    return manifest


def head_of(shard_manifest: dict[str, Any]) -> dict[str, Any]:
    """What the manifest of the whole run begins with, from that of any of its shards."""
    own = ("shard", "bands", "files", "run")
    return {key: value for key, value in shard_manifest.items() if key not in own} | {"schema": SCHEMA}
