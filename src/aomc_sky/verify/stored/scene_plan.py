"""A run against the scene that it says it came from: the plan made again from the scene's files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from aomc_sky.outputs.manifest import input_hashes
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.scene import Scene
from aomc_sky.verify.report import Check, VerifyReport, named
from aomc_sky.verify.stored.manifest import OF_THE_MACHINE, WITH_SCENE

TOLERANCE = 1e-12
"""Relative difference of masses and parameters that another processor may compute; counts are compared exactly."""


def with_scene(report: VerifyReport, plan: Plan, manifest: Mapping[str, Any] | None, scene: Scene) -> VerifyReport:
    """A report of a run with the checks that its scene, from the files that the user names, allows.

    The plan is compared with the one that the scene makes with the seed and the sampling of the run, and so is what the
    manifest says of the scene; the manifest is None before shards are merged.
    """
    checks = [_plan_check(plan, scene_plan(plan, scene))]
    if manifest is not None:
        checks.append(_manifest_check(manifest, scene))
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
    wrong = [*_option_differences(plan.options, made.options), *_array_differences(plan, made)]
    if not wrong:
        detail = f"made again from the scene: equal counts, other numbers within {TOLERANCE:g}"
        return Check(name="scene: plan", passed=True, detail=detail)
    return Check(name="scene: plan", passed=False, is_foreign=True, detail=named(wrong))


def _option_differences(found: Mapping[str, Any], expected: Mapping[str, Any]) -> Iterator[str]:
    for name in expected:
        if found.get(name) != expected[name]:
            yield f"{name} is {_short(found.get(name))}, the scene gives {_short(expected[name])}"


def _array_differences(plan: Plan, made: Plan) -> Iterator[str]:
    for name in sorted({*plan.arrays, *made.arrays}):
        found, expected = plan.arrays.get(name), made.arrays.get(name)
        if found is None or expected is None:
            yield f"{name} {'is missing' if found is None else 'does not belong there'}"
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
    place = ", ".join(str(int(k)) for k in np.unravel_index(at, differs.shape))
    text = f"{name}[{place}] is {found.flat[at]!s}, the scene gives {expected.flat[at]!s}"
    hint = " (a run with --iterations wants it here too)" if name == "requested" else ""
    return f"{text}, {int(differs.sum())} of {differs.size} differ{hint}"


def _manifest_check(manifest: Mapping[str, Any], scene: Scene) -> Check:
    expected = {"inputs": input_hashes(scene), "options.scene": dict(scene.options), "notes": list(scene.notes)}
    said = {"inputs": manifest["inputs"], "options.scene": manifest["options"]["scene"], "notes": manifest["notes"]}
    wrong = []
    for key, value in json.loads(json.dumps(expected)).items():
        wrong += list(_value_differences(key, said[key], value))
    if not wrong:
        detail = "names and hashes of its files, how they were read, and notes: as the manifest has them"
        return Check(name="scene: manifest", passed=True, detail=detail)
    return Check(name="scene: manifest", passed=False, detail=named(wrong))


def _value_differences(key: str, found: Any, expected: Any) -> Iterator[str]:
    if isinstance(found, dict) and isinstance(expected, dict):
        for name in [*expected, *(one for one in found if one not in expected)]:
            yield from _value_differences(f"{key}.{name}", found.get(name), expected.get(name))
    elif found != expected:
        yield f"{key} is {_short(found)}, the scene gives {_short(expected)}"


def _short(value: Any) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
