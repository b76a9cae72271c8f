"""Manifests: what a finished run or shard holds. Everything about time and machine is under ``run``."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any

import aomc_sky
from aomc_sky.errors import InputFileError, OutputError, Problem
from aomc_sky.outputs.json_schema import first_fault, parse_json
from aomc_sky.outputs.shard import MANIFEST, PLAN, WHOLE_RUN, Shard, shard_of_file
from aomc_sky.outputs.statistics import BandResult
from aomc_sky.regular_file import FileKindError, open_regular, read_regular
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene

MAX_MANIFEST_BYTES = 1 << 26
"""More than 40 000 wavebands take."""

_ADVICE = "remove the file and run the command that made it again, or name another folder"


class ForgedManifestError(InputFileError):
    """A manifest that no damage made so: it agrees with its own hash but is none of ours, or names files elsewhere."""


def rest_sha256(rest: dict[str, Any]) -> str:
    """SHA-256 of a manifest without its ``run``: JSON text with sorted keys, without white space."""
    return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def hash_matches(manifest: dict[str, Any]) -> bool:
    """Whether a manifest agrees with the hash that it holds of itself."""
    rest = {key: value for key, value in manifest.items() if key != "run"}
    run = manifest.get("run")
    return isinstance(run, dict) and run.get("rest_sha256") == rest_sha256(rest)


def load_manifest(path: str | Path, schema_file: str) -> dict[str, Any]:
    """Read a manifest and hold it against a schema that ships with the package (``manifest.schema.json``).

    InputFileError where it is not a regular file (E961), no JSON or too much of it (E100), or not what the schema
    allows (E962); this one a ForgedManifestError where the manifest agrees with its own hash, or names a file outside
    its folder.
    """
    try:
        manifest = parse_json(read_regular(path, MAX_MANIFEST_BYTES, follow_links=False))
    except FileKindError as error:
        raise manifest_error(path, "E961", error.reason) from None
    except OSError as error:
        raise manifest_error(path, "E100", f"cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise manifest_error(path, "E100", f"not a readable manifest ({error})") from None
    fault = first_fault(manifest, _schema(schema_file)) or _text_fault(manifest)
    if fault:
        raise manifest_error(path, "E962", f"not a manifest of aomc-sky: {fault}", manifest)
    return dict(manifest)


def manifest_error(path: str | Path, code: str, message: str, manifest: Any = None) -> InputFileError:
    """The error of a manifest as a whole; one of its own class where no damage can have made it so."""
    is_forged = isinstance(manifest, dict) and (hash_matches(manifest) or _names_files_elsewhere(manifest))
    kind = ForgedManifestError if is_forged else InputFileError
    return kind([Problem(path=str(path), line=0, column=0, code=code, field="", message=message, advice=_ADVICE)])


def _names_files_elsewhere(manifest: dict[str, Any]) -> bool:
    """Whether a name leads out of the folder, and no byte that has changed makes one of ours such a name."""
    files = manifest.get("files")
    paths = [PurePosixPath(name) for name in files] if isinstance(files, dict) else []
    return any(".." in path.parts or (path.is_absolute() and len(path.parts) > 2) for path in paths)


@lru_cache
def _schema(name: str) -> dict[str, Any]:
    from importlib import resources

    return dict(json.loads((resources.files("aomc_sky.outputs") / name).read_text("utf-8")))


def _text_fault(manifest: dict[str, Any]) -> str:
    """Texts that no terminal can show; names of files and folders may hold any bytes."""
    parts = {key: value for key, value in manifest.items() if key not in ("inputs", "run")}
    try:
        json.dumps(parts, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        return "half a surrogate pair in a text"
    return ""


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
        if shard_of_file(name) != WHOLE_RUN or name == MANIFEST:
            raise manifest_error(path, "E963", f"{name!r} does not belong in the manifest of a run", manifest)
    return manifest


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
            raise manifest_error(path, "E963", f"{name!r} is not a photon file of shard {shard}", manifest)
    return manifest


def head_of(shard_manifest: dict[str, Any]) -> dict[str, Any]:
    """What the manifest of the whole run begins with, from that of any of its shards."""
    own = ("shard", "bands", "files", "run")
    return {key: value for key, value in shard_manifest.items() if key not in own} | {"schema": SCHEMA}
