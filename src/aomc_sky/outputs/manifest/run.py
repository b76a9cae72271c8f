"""manifest.json: what a finished run holds. Everything about time and machine stands under ``run``."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import aomc_sky
from aomc_sky.errors import OutputError
from aomc_sky.outputs.blocks.shard import WHOLE
from aomc_sky.outputs.blocks.statistics import BandResult
from aomc_sky.outputs.manifest.file import load_manifest, manifest_error, rest_sha256
from aomc_sky.outputs.names import MANIFEST, PLAN, YEAR_FILES, shard_of_file
from aomc_sky.regular_file import open_regular
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene

SCHEMA = "aomc-sky-manifest/1"

CONVENTIONS = {
    "direction": "travel direction of the photon, unit vector (ux, uy, uz)",
    "frame": "x east, y north, z up; a sky photon has uz < 0",
    "azimuth": "0 is +x, growing towards +y",
    "positions": "metres, origin at the centre of the footprint",
    "indices": "zenith index from 1, azimuth index as in skydist.inp, waveband from 1",
}


def input_hashes(scene: Scene) -> dict[str, dict[str, str]]:
    """Name and SHA-256 of every file that the scene came from."""
    return {role: input_hash(Path(path)) for role, path in sorted(scene.input_files.items())}


def input_hash(path: Path) -> dict[str, str]:
    """Name and SHA-256 of an input file."""
    try:
        with open_regular(path) as file:
            return {"name": path.name, "sha256": hashlib.file_digest(file, "sha256").hexdigest()}
    except OSError as error:
        raise OutputError(f"cannot read {path} a second time: {error.strerror or error}") from error


def manifest_head(
    source: PhotonSource, scene: Scene, inputs: dict[str, dict[str, str]], formats: tuple[str, ...]
) -> dict[str, Any]:
    """What a manifest says of the run whatever photons it has: the same for all shards."""
    return build_head(
        source,
        version=aomc_sky.__version__,
        inputs=inputs,
        scene_options=dict(scene.options),
        formats=formats,
        notes=scene.notes,
    )


def build_head(
    source: PhotonSource, *, version: Any, inputs: Any, scene_options: Any, formats: Sequence[str], notes: Sequence[str]
) -> dict[str, Any]:
    """`manifest_head` from a plan and from what a plan does not know, in the fixed order of keys."""
    return {
        "schema": SCHEMA,
        "version": version,
        "stream": STREAM_VERSION,
        "seed": source.plan.seed,
        "plan_sha256": source.plan.sha256,
        "inputs": inputs,
        "conventions": CONVENTIONS,
        "options": {
            "scene": scene_options,
            "sampling": {
                k: source.plan.options[k]
                for k in ("method", "allocation", "placement", "order", "precision", "weights")
            }
            | {"replicates": source.replicates},
            "footprint": source.plan.options["footprint"],
            "formats": list(formats),
        },
        "components": list(source.plan.component_names),
        "notes": list(notes),
    }


def require_wavebands(path: str | Path, manifest: dict[str, Any], n_bands: int) -> None:
    """Raise unless a manifest of a run or of a shard names wavebands of its plan alone, each once (E964)."""
    named = {"bands": [band["waveband"] for band in manifest["bands"]]}
    named["options.scene.wavebands"] = manifest["options"]["scene"].get("wavebands") or []
    if manifest.get("content") is not None:
        named["content.bands"] = [band["waveband"] for band in manifest["content"]["bands"]]
    for key, wavebands in named.items():
        beyond = [waveband for waveband in wavebands if waveband > n_bands]
        if beyond:
            message = f"{key} names waveband {beyond[0]}; {PLAN} has {n_bands}"
            raise manifest_error(path, "E964", message, manifest)
        if key != "options.scene.wavebands" and len(set(wavebands)) < len(wavebands):
            raise manifest_error(path, "E964", f"{key} names a waveband twice", manifest)


def chosen_bands(source: PhotonSource, scene_options: Mapping[str, Any]) -> list[int]:
    """Wavebands that a scene, or the manifest of its run, asks for. [0-based]"""
    wavebands = scene_options.get("wavebands")
    return [b - 1 for b in wavebands] if wavebands else list(range(source.n_bands))


def add_run_record(rest: dict[str, Any], run: dict[str, Any]) -> dict[str, Any]:
    """A manifest and its ``run``, which knows the hash of all the rest."""
    return rest | {"run": run | {"rest_sha256": rest_sha256(rest)}}


def build_manifest(
    head: dict[str, Any],
    bands: list[BandResult],
    content: dict[str, Any] | None,
    files: dict[str, dict[str, Any]],
    run: dict[str, Any],
) -> dict[str, Any]:
    """Put the manifest together; equal scene, seed and options give equal text aside from ``run``."""
    rest = head | {
        "bands": [asdict(band) for band in bands],
        "total": sum(band.launched for band in bands),
        "content": content,
        "files": dict(sorted(files.items())),
    }
    return add_run_record(rest, run)


def manifest_bytes(manifest: dict[str, Any]) -> bytes:
    """The manifest as text, keys in a fixed order."""
    return (json.dumps(manifest, indent=1, allow_nan=False) + "\n").encode()


def read_manifest(path: str | Path) -> dict[str, Any]:
    """Read the manifest of a run: as `load_manifest`, and E963 where it lists a file of a shard."""
    manifest = load_manifest(path, "manifest.schema.json")
    for name in manifest["files"]:
        if shard_of_file(name) != WHOLE or name in (MANIFEST, *YEAR_FILES[1:-1]):
            raise manifest_error(path, "E963", f"{name!r} is no file that the manifest of a run lists", manifest)
    return manifest
