"""manifest.json: what a finished run holds. Everything about time and machine stands under ``run``."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import NoneType
from typing import Any

import aomc_sky
from aomc_sky.errors import AomcSkyError, OutputError
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


@dataclass(frozen=True, kw_only=True, slots=True)
class BandResult:
    """One waveband of a run, in the order of the printed table.

    Means of the photons are None where none were emitted, standard errors besides where there are no
    replicates. `ed_photons` is the mean weight w, `eo_photons` the mean of w / mu: planar and scalar
    irradiance in units of what one photon of weight 1 stands for. Where absolute units are known
    `irradiance_W_m2_nm` is the planar irradiance of all components together.
    """

    waveband: int
    wavelength_nm: float
    sky_wavelength_nm: float | None
    requested: int
    launched: int
    residual: int
    mean_cosine_exact: float | None
    mean_cosine_photons: float | None
    ed_over_eo_exact: float | None
    ed_over_eo_photons: float | None
    horizon_loss: float = 0.0
    irradiance_W_m2_nm: float | None = None  # noqa: N815
    component_irradiance_W_m2_nm: dict[str, float] | None = None  # noqa: N815
    ed_photons: float | None = None
    eo_photons: float | None = None
    mean_cosine_standard_error: float | None = None
    ed_over_eo_standard_error: float | None = None
    ed_standard_error: float | None = None
    eo_standard_error: float | None = None
    eo_variance_is_finite: bool = True


def finite(value: float) -> float | None:
    """The value, or None where JSON has no number for it."""
    return value if math.isfinite(value) else None


def input_hashes(scene: Scene) -> dict[str, dict[str, str]]:
    """Name and SHA-256 of every file that the scene came from."""
    return {role: input_hash(Path(path)) for role, path in sorted(scene.input_files.items())}


def input_hash(path: Path) -> dict[str, str]:
    """Name and SHA-256 of an input file."""
    try:
        return {"name": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
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


def chosen_bands(source: PhotonSource, scene_options: Mapping[str, Any]) -> list[int]:
    """Wavebands that a scene, or the manifest of its run, asks for. [0-based]"""
    wanted = scene_options.get("wavebands")
    return [b - 1 for b in wanted] if wanted else list(range(source.n_bands))


def with_record(rest: dict[str, Any], run: dict[str, Any]) -> dict[str, Any]:
    """A manifest and its ``run``, which knows the hash of all the rest."""
    return rest | {"run": run | {"rest_sha256": rest_sha256(rest)}}


def rest_sha256(rest: Mapping[str, Any]) -> str:
    """SHA-256 of a manifest without ``run``: of its JSON text with sorted keys and without white space."""
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def is_as_written(manifest: Mapping[str, Any]) -> bool:
    """Whether all of a manifest but ``run`` is what ``run`` says."""
    rest = {key: value for key, value in manifest.items() if key != "run"}
    run = manifest.get("run")
    return isinstance(run, dict) and run.get("rest_sha256") == rest_sha256(rest)


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
    return with_record(rest, run)


def manifest_bytes(manifest: dict[str, Any]) -> bytes:
    """The manifest as text, keys in a fixed order."""
    return (json.dumps(manifest, indent=1, allow_nan=False) + "\n").encode()


def read_manifest(path: str | Path) -> dict[str, Any]:
    """Read a manifest.

    Raises
    ------
    AomcSkyError
        Missing, damaged, or of another kind.
    """
    manifest = read_json(path, SCHEMA, {"bands": list, "content": dict | NoneType})
    try:
        _ = [BandResult(**band) for band in manifest["bands"]]
        _ = [
            (band["waveband"], band["n_blocks"], band["root"])
            for band in (manifest["content"] or {"bands": []})["bands"]
        ]
    except (KeyError, TypeError) as error:
        raise AomcSkyError(f"{path} is not a whole manifest ({error})") from error
    return manifest


def read_json(path: str | Path, schema: str, parts: dict[str, Any]) -> dict[str, Any]:
    """Read a manifest of one schema that has `manifest_head`, files, and these parts of these types."""
    try:
        manifest = json.loads(Path(path).read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        raise AomcSkyError(f"{path} is not a readable manifest ({error})") from error
    wanted = {"plan_sha256": str, "seed": int, "options": dict, "files": dict, "notes": list} | parts
    if not isinstance(manifest, dict) or manifest.get("schema") != schema:
        raise AomcSkyError(f"{path} is not a manifest of schema {schema}")
    wrong = [key for key, kind in wanted.items() if not isinstance(manifest.get(key, ...), kind)]
    if wrong:
        raise AomcSkyError(f"{path} is not a whole manifest ({wrong[0]})")
    try:
        _ = manifest["options"]["formats"], [(e["bytes"], e["sha256"]) for e in manifest["files"].values()]
    except (KeyError, TypeError, AttributeError) as error:
        raise AomcSkyError(f"{path} is not a whole manifest ({error})") from error
    return manifest
