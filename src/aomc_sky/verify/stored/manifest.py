"""The manifest, the file of counts and the plan, made again: from the plan and the files, and from the scene."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.counts import COUNTS_FILES, counts_file, counts_name
from aomc_sky.outputs.manifest import (
    build_head,
    build_manifest,
    build_shard_manifest,
    chosen_bands,
    input_hashes,
    rest_sha256,
)
from aomc_sky.outputs.photons.leaves import content_hash
from aomc_sky.outputs.shard import PLAN
from aomc_sky.outputs.statistics import BandResult, PhotonSums, band_result
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.scene import Scene
from aomc_sky.verify.report import Check, VerifyReport, named
from aomc_sky.verify.stored.parts import RunPart

NAME = "manifest"

TOLERANCE = 1e-12
"""Relative difference of numbers that another processor may compute; counts are compared exactly."""

_SHA256 = re.compile(r"[0-9a-f]{64}")
_VERSION = re.compile(r"\d+(\.\d+)+([.+-]?[0-9A-Za-z]+)*")

_OF_PHOTONS = tuple(field.name for field in fields(BandResult) if field.name.endswith(("_photons", "_standard_error")))
"""What only the photons themselves show."""

SumsOfBands = Mapping[int, PhotonSums]
"""Sums over the photons of wavebands that were read and are whole. [0-based]"""


def manifest_check(part: RunPart, sums: SumsOfBands) -> Check:
    """Build the manifest again from the plan and the files, and compare every key except ``run``.

    `sums` are those of wavebands that were read and are undamaged; of the others the means of photons are not compared.
    What a plan does not know is compared in form: the version of the package, names and hashes of the scene's files,
    how the scene was read, and notes. The hash under ``run``, of all that is not under ``run``, covers them as well;
    one who computes it again is seen by `with_scene` alone.
    """
    found = part.manifest
    wrong = [*_malformed(found), *_differences(found, _expected(part, sums), "")]
    if not wrong:
        what = f"of shard {part.shard} " if part.shard.is_named else ""
        return Check(name=NAME, passed=True, detail=f"{what}agrees with the plan and the files")
    return Check(name=NAME, passed=False, detail=named(wrong))


def _expected(part: RunPart, sums: SumsOfBands) -> dict[str, Any]:
    found, source = part.manifest, part.source
    options = found["options"]
    head = build_head(
        source,
        version=found.get("version"),
        inputs=found.get("inputs"),
        scene_options=options.get("scene"),
        formats=options["formats"],
        notes=found["notes"],
    )
    bands = expected_bands(part)
    files = _expected_files(part, bands)
    run = found.get("run")
    record = run if isinstance(run, dict) else {}
    if part.shard.is_named:
        expected = build_shard_manifest(head, source, part.shard, bands, files, record)
    else:
        results = [_band(part, band, sums.get(band)) for band in bands]
        expected = build_manifest(head, results, _expected_content(part, bands), files, record)
    if "rest_sha256" in record:  # of what was found, so that a change of what is not known is seen
        rest = {key: value for key, value in found.items() if key != "run"}
        return expected | {"run": record | {"rest_sha256": rest_sha256(rest)}}
    return expected | {"run": record}


def expected_bands(part: RunPart) -> list[int]:
    """Wavebands that the scene's options ask for; those of the manifest where they make no sense."""
    scene = part.manifest["options"].get("scene")
    bands = chosen_bands(part.source, scene) if isinstance(scene, dict) and _are_bands(scene.get("wavebands")) else []
    is_known = bool(bands) and all(0 <= band < part.source.n_bands for band in bands)
    return bands if is_known else list(part.bands)


def _are_bands(wavebands: Any) -> bool:
    return wavebands is None or (isinstance(wavebands, list) and all(isinstance(w, int) for w in wavebands))


def _expected_files(part: RunPart, bands: list[int]) -> dict[str, dict[str, Any]]:
    """Entries of the files that a run has; hashes and lengths are compared with the files elsewhere."""
    writers = [part.writer(name) for name in part.formats]
    names = [name for writer in writers for own in writer.parts(bands) for name in writer.names(own)]
    if writers:
        names += [name for band in bands for name in part.leaves.names((band,))]
    if not part.shard.is_named:
        names += [PLAN, counts_name(part.source, bands)]
    nothing = {"bytes": None, "sha256": None}
    entries = {name: part.manifest["files"].get(name, nothing) for name in names}
    return {name: {key: entry[key] for key in ("bytes", "sha256")} for name, entry in entries.items()}


def _expected_content(part: RunPart, bands: list[int]) -> dict[str, Any] | None:
    if not part.formats:
        return None
    try:
        return content_hash(part.folder, part.source, bands)
    except OutputError:  # the files of leaves are damaged, which has a line of its own
        content: dict[str, Any] = part.manifest["content"]
        return content


def _band(part: RunPart, band: int, sums: PhotonSums | None) -> BandResult:
    """What a waveband ought to say; of its photons what it does say, where they are not known."""
    if sums is not None or not part.formats:
        return band_result(part.source, band, sums or PhotonSums(part.source.replicates))
    result = asdict(band_result(part.source, band, PhotonSums(part.source.replicates)))
    recorded = {entry["waveband"]: entry for entry in part.manifest["bands"]}.get(band + 1, result)
    return BandResult(**result | {name: recorded.get(name, result[name]) for name in _OF_PHOTONS})


def _differences(found: Any, expected: Any, path: str) -> Iterator[str]:
    """Keys below `path` that differ, with both values."""
    if isinstance(found, dict) and isinstance(expected, dict):
        for key in [*expected, *(key for key in found if key not in expected)]:
            name = f"{path}.{key}" if path else key
            if key not in found:
                yield f"{name} is missing"
            elif key not in expected:
                yield f"{name} is not expected"
            else:
                yield from _differences(found[key], expected[key], name)
    elif isinstance(found, list) and isinstance(expected, list | tuple) and len(found) == len(expected):
        for k, pair in enumerate(zip(found, expected, strict=True)):
            yield from _differences(*pair, f"{path}[{k}]")
    elif not _is_same(found, expected):
        yield f"{path} is {_shown(found)}, not {_shown(expected)}"


def _is_same(found: Any, expected: Any) -> bool:
    if isinstance(found, bool) or isinstance(expected, bool):
        return found is expected
    if isinstance(found, float) and isinstance(expected, int | float):
        return math.isclose(found, expected, rel_tol=TOLERANCE)
    return type(found) is type(expected) and bool(found == expected)


def _malformed(found: Mapping[str, Any]) -> Iterator[str]:
    """Keys whose values no plan knows and that have not even the form of what belongs there."""
    version, inputs, notes = found.get("version"), found.get("inputs"), found.get("notes")
    if not isinstance(version, str) or not _VERSION.fullmatch(version):
        yield f"version is {_shown(version)}, which is not a version"
    formats = found["options"]["formats"]
    if len(set(formats)) != len(formats):
        yield f"options.formats is {_shown(formats)}, which names a format twice"
    if not isinstance(found["options"].get("scene"), dict):
        yield "options.scene is not an object"
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        yield "notes is not a list of texts"
    if not isinstance(inputs, dict):
        yield "inputs is not an object"
        return
    for role, entry in inputs.items():
        is_entry = isinstance(entry, dict) and set(entry) == {"name", "sha256"}
        if not is_entry or not all(isinstance(value, str) for value in entry.values()):
            yield f"inputs.{role} is not a name and a SHA-256"
        elif not _SHA256.fullmatch(entry["sha256"]):
            yield f"inputs.{role}.sha256 is {_shown(entry['sha256'])}, which is not a SHA-256"
        elif entry["name"] in ("", ".", "..") or "/" in entry["name"]:
            yield f"inputs.{role}.name is {_shown(entry['name'])}, which is not a file name"


WITHOUT_SCENE = (
    "that the plan comes from the scene and the seed that were meant",
    "the version, notes, names and hashes of the scene's files, and how they were read",
)
"""What a folder that was sealed anew may say as it likes; `verify RUN --scene amc.inp` compares the most of it."""

WITH_SCENE = ("that this seed was meant", "the version")
"""What is left when the scene's files are there."""

OF_THE_MACHINE = "times, speed and machine"


def counts_check(part: RunPart) -> Check:
    """Make the file of counts again, compare it byte for byte and name the first line that differs."""
    name, expected = counts_file(part.source, expected_bands(part))
    try:
        with part.folder.reading(name) as file:
            found = file.read(len(expected) + 1)
    except OutputError:
        return Check(name="counts file", passed=False, detail=f"{name} is missing")
    if found == expected:
        return Check(name="counts file", passed=True, detail=f"{name} agrees with the plan, byte for byte")
    if name != COUNTS_FILES[0]:
        return Check(name="counts file", passed=False, detail=f"{name} differs from the plan")
    lines = zip([*found.split(b"\n"), b""], [*expected.split(b"\n"), b""], strict=False)
    line = next((k for k, (one, other) in enumerate(lines, 1) if one != other), 0)
    return Check(name="counts file", passed=False, detail=f"{name} differs from the plan, from line {line} on")


def with_scene(report: VerifyReport, plan: Plan, manifest: Mapping[str, Any] | None, scene: Scene) -> VerifyReport:
    """A report of a run with the checks that its scene, from the files that the user names, allows.

    The plan is compared with the one that the scene makes with the seed and the sampling of the run, and so is what the
    manifest says of the scene; the manifest is None before shards are merged.
    """
    checks = [_plan_check(plan, scene_plan(plan, scene))]
    if manifest is not None:
        checks.append(_scene_manifest_check(manifest, scene))
    return replace(report, checks=(*report.checks, *checks), unvouched=(*WITH_SCENE, OF_THE_MACHINE))


def scene_plan(plan: Plan, scene: Scene) -> Plan:
    """The plan of a scene with the seed and the sampling options of another plan."""
    options = plan.options
    names = ("method", "allocation", "placement", "order", "precision", "weights", "replicates")
    chosen = {name: options[name] for name in names}
    return scene.source(plan.seed, **chosen).plan


def _plan_check(plan: Plan, made: Plan) -> Check:
    if plan.sha256 == made.sha256:
        detail = f"made again from the scene with seed {plan.seed}: the same, {plan.sha256[:16]}"
        return Check(name="scene: plan", passed=True, detail=detail)
    wrong = [*_scene_differences(plan.options, made.options), *_array_differences(plan, made)]
    if not wrong:
        detail = f"made again from the scene: equal counts, other numbers within {TOLERANCE:g}"
        return Check(name="scene: plan", passed=True, detail=detail)
    return Check(name="scene: plan", passed=False, is_foreign=True, detail=named(wrong))


def _array_differences(plan: Plan, made: Plan) -> Iterator[str]:
    for name in sorted({*plan.arrays, *made.arrays}):
        found, expected = plan.arrays.get(name), made.arrays.get(name)
        if found is None or expected is None:
            yield f"{name} {'is missing' if found is None else 'is not expected'}"
        elif found.shape != expected.shape:
            yield f"{name} has shape {found.shape}, the scene gives {expected.shape}"
        elif found.dtype.kind == "f":
            near = np.isclose(found, expected, rtol=TOLERANCE, atol=TOLERANCE, equal_nan=True)
            if not near.all():
                yield _first_difference(name, found, expected, ~near)
        elif not np.array_equal(found, expected):
            yield _first_difference(name, found, expected, found != expected)


def _first_difference(name: str, found: np.ndarray, expected: np.ndarray, differs: np.ndarray) -> str:
    at = int(np.argmax(differs))
    position = ", ".join(str(int(k)) for k in np.unravel_index(at, differs.shape))
    text = f"{name}[{position}] is {found.flat[at]!s}, the scene gives {expected.flat[at]!s}"
    hint = " (for a run made with --iterations, give it here too)" if name == "requested" else ""
    return f"{text}, {int(differs.sum())} of {differs.size} differ{hint}"


def _scene_manifest_check(manifest: Mapping[str, Any], scene: Scene) -> Check:
    expected = {"inputs": input_hashes(scene), "options.scene": dict(scene.options), "notes": list(scene.notes)}
    recorded = {"inputs": manifest["inputs"], "options.scene": manifest["options"]["scene"], "notes": manifest["notes"]}
    wrong = list(_scene_differences(recorded, json.loads(json.dumps(expected))))
    if not wrong:
        detail = "names and hashes of its files, how they were read, and notes agree with the manifest"
        return Check(name="scene: manifest", passed=True, detail=detail)
    return Check(name="scene: manifest", passed=False, detail=named(wrong))


def _scene_differences(found: Any, expected: Any, path: str = "") -> Iterator[str]:
    """Values below `path` that differ from what the scene gives."""
    if isinstance(found, dict) and isinstance(expected, dict):
        for name in [*expected, *(name for name in found if name not in expected)]:
            yield from _scene_differences(found.get(name), expected.get(name), f"{path}.{name}" if path else name)
    elif found != expected:
        yield f"{path} is {_shown(found)}, the scene gives {_shown(expected)}"


def _shown(value: Any) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
