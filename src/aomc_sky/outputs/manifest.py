"""manifest.json: the contents of a finished run. Its bytes depend on scene, plan and files alone."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import aomc_sky
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import OutputError
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.counts import chosen_bands
from aomc_sky.outputs.photon_formats import columns_of
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_results
from aomc_sky.plan.plan import OTHER_PROCESSOR
from aomc_sky.plan.streams import STREAM_VERSION
from aomc_sky.source.scene import Scene
from aomc_sky.system import FileKindError, open_regular, read_regular

MAX_MANIFEST_BYTES = 1 << 26
"""More than the manifest of 40 000 wavebands needs."""

SCHEMA = "aomc-sky-manifest/2"

RAW_NUMBERS = "float32, little-endian"
"""The numbers of a raw file."""

_PHOTONS = tuple(field.name for field in fields(BandResult) if field.name.endswith(("_photons", "_standard_error")))
"""Results that need the photons themselves."""

CONVENTIONS = {
    "direction": "travel direction of the photon, unit vector (ux, uy, uz)",
    "frame": "x east, y north, z up; a sky photon has uz < 0",
    "azimuth": "0 is +x, growing towards +y",
    "positions": "metres, origin at the centre of the footprint",
    "indices": "zenith index from 1, azimuth index as in skydist.inp, waveband from 1",
}
STOKES = {"stokes": "q = Q/I and u = U/I in the plane of the vertical and the ray, q > 0 for an electric vector in it"}
"""A further convention of runs whose light is polarised."""


def input_hashes(scene: Scene) -> dict[str, dict[str, str]]:
    """Name and SHA-256 of every file of the scene."""
    hashes = {}
    for role, path in sorted(scene.input_files.items()):
        try:
            with open_regular(path) as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise OutputError(f"cannot read {path} a second time: {error.strerror or error}") from error
        hashes[role] = {"name": Path(path).name, "sha256": digest}
    return hashes


def scene_part(scene: Scene) -> dict[str, Any]:
    """The part of a manifest that describes the scene."""
    return {"inputs": input_hashes(scene), "scene": dict(scene.options), "notes": list(scene.notes)}


def stated_of(scene_entries: Mapping[str, Any], version: str = aomc_sky.__version__) -> dict[str, str]:
    """Digests of the parts of a manifest that do not follow from the plan, by name: what plan.npz states of them."""
    parts = {"version": version, "options.scene": scene_entries["scene"], "notes": scene_entries["notes"]}
    parts |= {f"inputs.{role}": entry for role, entry in scene_entries["inputs"].items()}
    return {name: hashlib.sha256(json.dumps(part, sort_keys=True).encode()).hexdigest() for name, part in parts.items()}


def part_of_scene(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """`scene_part` as a manifest has it."""
    return {"inputs": manifest["inputs"], "scene": manifest["options"]["scene"], "notes": manifest["notes"]}


def build_manifest(
    source: PhotonSource,
    scene_entries: Mapping[str, Any],
    bands: Sequence[BandResult],
    formats: Sequence[str],
    files: Mapping[str, tuple[int, str]],
    version: str = aomc_sky.__version__,
) -> dict[str, Any]:
    """The manifest; `scene_entries` comes from `scene_part`, `files` have their sizes and formats. [bytes]"""
    options = source.plan.options
    sampling = ("method", "allocation", "placement", "order", "precision", "weights")
    return {
        "schema": SCHEMA,
        "version": version,
        "stream": STREAM_VERSION,
        "seed": source.plan.seed,
        "plan_sha256": source.plan.sha256,
        "inputs": scene_entries["inputs"],
        "conventions": CONVENTIONS | (STOKES if source.has_polarisation else {}),
        "options": {
            "scene": scene_entries["scene"],
            "sampling": {name: options[name] for name in sampling}
            | {"replicates": source.replicates}
            | {name: options[name] for name in ("bias", "importance") if name in options},
            "footprint": options["footprint"],
            "formats": list(formats) or ["none"],
        },
        "components": list(source.plan.component_names),
        "notes": scene_entries["notes"],
        "bands": [asdict(band) for band in bands],
        "total": sum(band.launched for band in bands),
        "files": {
            name: {"bytes": size, "numbers": RAW_NUMBERS, "columns": list(columns_of(source))}  # it has no head
            if format_of_file == "raw"
            else {"bytes": size}
            for name, (size, format_of_file) in sorted(files.items())
        },
    }


def manifest_bytes(manifest: Mapping[str, Any]) -> bytes:
    """The manifest as text, keys in a fixed order."""
    return (json.dumps(manifest, indent=1, allow_nan=False) + "\n").encode()


def manifest_again(
    source: PhotonSource,
    found: Mapping[str, Any],
    sums: Mapping[int, PhotonSums],
    formats: Sequence[str],
    files: Mapping[str, tuple[int, str]],
) -> dict[str, Any]:
    """A manifest as it follows from the plan. The part of the scene, and photons without sums, are those found."""
    bands, stored = chosen_bands(source), {band["waveband"]: band for band in found["bands"]}
    results = band_results(source, {band: sums.get(band) or PhotonSums(source.replicates) for band in bands})
    for k, band in enumerate(bands):
        if formats and band not in sums and band + 1 in stored:
            results[k] = replace(results[k], **{name: stored[band + 1][name] for name in _PHOTONS})
    made = build_manifest(source, part_of_scene(found), results, formats, files, version=found["version"])
    return dict(json.loads(json.dumps(made)))


def differences(found: Any, expected: Any, path: str = "", source: str = "expected") -> Iterator[str]:
    """Values below `path` that differ from what is expected."""
    if isinstance(found, dict) and isinstance(expected, dict):
        for key in [*expected, *(key for key in found if key not in expected)]:
            name = f"{path}.{key}" if path else key
            if key not in found or key not in expected:
                yield f"{name} is {'missing' if key not in found else 'not ' + source}"
            else:
                yield from differences(found[key], expected[key], name, source)
    elif isinstance(found, list) and isinstance(expected, list) and len(found) == len(expected):
        for k, pair in enumerate(zip(found, expected, strict=True)):
            yield from differences(*pair, f"{path}[{k}]", source)
    elif not _is_same(found, expected):
        yield f"{path} is {_shown(found)}, {source} {_shown(expected)}"


def _is_same(found: Any, expected: Any) -> bool:
    if type(found) in (int, float) and type(expected) in (int, float) and float in (type(found), type(expected)):
        return math.isclose(found, expected, rel_tol=OTHER_PROCESSOR)
    return type(found) is type(expected) and bool(found == expected)


def _shown(value: Any) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def read_manifest(path: str | Path) -> dict[str, Any]:
    """Read the manifest of a run and check the types of its values; InputFileError if it is not one of ours.

    Only `aomc-sky verify` checks whether the values are true.
    """
    advice = "remove the file and run the command that made it again, or name another folder"
    try:
        data = read_regular(path, MAX_MANIFEST_BYTES, follow_links=False)
        manifest = json.loads(data, parse_constant=_refuse_constant)
        is_ours = _is_manifest(manifest)
    except FileKindError as error:
        raise refuse(path, error.reason, code="E961", advice=advice) from None
    except OSError as error:
        raise refuse(path, f"cannot be read: {error.strerror}", code="E100", advice=advice) from None
    except (RecursionError, ValueError) as error:
        why = error if isinstance(error, ValueError) else "nested too deeply"
        raise refuse(path, f"not a readable manifest ({why})", code="E100", advice=advice) from None
    except Exception:  # keys and types that no manifest has, numbers beyond floats
        is_ours = False
    if not is_ours:
        raise refuse(path, "not a manifest of this version of aomc-sky", code="E962", advice=advice)
    return dict(manifest)


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _is_manifest(manifest: Any) -> bool:
    options, files = manifest["options"], manifest["files"].items()
    texts = [*(manifest[key] for key in ("version", "stream", "plan_sha256")), *manifest["components"]]
    texts += [*manifest["notes"], *options["formats"], options["sampling"]["allocation"], *(name for name, _ in files)]
    texts += [text for _, entry in files for text in (entry.get("numbers", ""), *entry.get("columns", []))]
    numbers = [manifest["seed"], manifest["total"], options["sampling"]["replicates"]]
    numbers += [entry["bytes"] for _, entry in files]
    return (
        manifest["schema"] == SCHEMA
        and isinstance(manifest["inputs"], dict)
        and isinstance(options["scene"], dict)
        and all(isinstance(text, str) for text in texts)
        and all(_fits(number, "int") for number in numbers)
        and all(_is_band(band) for band in manifest["bands"])
    )


def _is_band(band: dict[str, Any]) -> bool:
    types = {field.name: str(field.type) for field in fields(BandResult)}
    return band.keys() == types.keys() and all(_fits(band[name], kind) for name, kind in types.items())


def _fits(value: Any, kind: str) -> bool:
    if value is None:
        return kind.endswith("None")
    if kind.startswith("dict"):
        return all(_fits(number, "float") for number in value.values())
    if kind == "bool" or kind.startswith("int"):
        return type(value).__name__ == kind.split()[0] and abs(value) < 1 << 64
    return type(value) in (int, float) and math.isfinite(value)
