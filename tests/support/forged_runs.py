"""Runs that somebody changed and sealed anew: every hash agrees, and something is not what the plan gives."""

from __future__ import annotations

import copy
import dataclasses
import functools
import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.engine.run import JobOptions, run_job
from aomc_sky.outputs.manifest import CONVENTIONS, rest_sha256
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from tests.support.verified import change_photons, seal

Forge = Callable[[Path], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class ForgedRun:
    """One forgery: its name, and who makes it of a finished run."""

    name: str
    forge: Forge


def reseal(folder: Path) -> None:
    """Make lengths and hashes of all files, and that of the manifest, agree with what stands there."""
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    for name, entry in manifest["files"].items():
        data = (folder / name).read_bytes() if (folder / name).exists() else b""
        entry |= {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    manifest["run"]["rest_sha256"] = rest_sha256({key: value for key, value in manifest.items() if key != "run"})
    path.write_text(json.dumps(manifest))


def _said(*keys: str | int, change: Callable[[Any], Any]) -> Forge:
    """The manifest says something else below these keys."""

    def forge(folder: Path) -> None:
        path = folder / "manifest.json"
        manifest = json.loads(path.read_text())
        at = functools.reduce(lambda value, key: value[key], keys[:-1], manifest)
        at[keys[-1]] = change(copy.deepcopy(at.get(keys[-1]) if isinstance(at, dict) else at[keys[-1]]))
        path.write_text(json.dumps(manifest))
        reseal(folder)

    return forge


def _counts(change: Callable[[bytes], bytes]) -> Forge:
    def forge(folder: Path) -> None:
        path = folder / "counts.csv"
        path.write_bytes(change(path.read_bytes()))
        reseal(folder)

    return forge


def _other(value: Any) -> Any:
    """A value of the same type that is another one."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + 1 if value < 1 else value * 0.5 if isinstance(value, float) else value - 1
    if value is None:
        return 0.25
    if isinstance(value, str):
        return value + "x"
    return [*value, value[0]] if isinstance(value, list) and value else {**(value or {}), "more": 1.0}


def _forged_counts() -> Iterator[tuple[str, Forge]]:
    lines = functools.partial(bytes.split, sep=b"\n")
    yield "counts hello", _counts(lambda _: b"hello")
    yield "counts empty", _counts(lambda _: b"")
    yield "counts without a line", _counts(lambda data: b"\n".join([*lines(data)[:-2], b""]))
    yield "counts in another order", _counts(lambda data: b"\n".join(_swapped(lines(data))))
    yield "counts with another end", _counts(lambda data: data + b"\n")
    yield "counts with other line ends", _counts(lambda data: data.replace(b"\n", b"\r\n"))
    yield "counts with other masses", _counts(lambda data: data.replace(b",0.", b",0.9"))
    yield "counts with other photons", _counts(_photon_moved)
    yield "counts with other names", _counts(lambda data: data.replace(b"zenith_index", b"theta_index"))
    yield "counts with other wavelengths", _counts(lambda data: data.replace(b"\n1,", b"\n1,9"))


def _swapped(lines: list[bytes]) -> list[bytes]:
    return [lines[0], lines[2], lines[1], *lines[3:]]


def _photon_moved(data: bytes) -> bytes:
    """One photon from a patch to the next: sums stay."""
    lines = data.split(b"\n")
    for k, step in ((1, 1), (2, -1)):
        head, _, n = lines[k].rpartition(b",")
        lines[k] = head + b",%d" % (int(n) + step)
    return b"\n".join(lines)


def _forged_manifests(manifest: dict[str, Any]) -> Iterator[tuple[str, Forge]]:
    for key in CONVENTIONS:
        yield f"convention {key}", _said("conventions", key, change=_other)
    yield "a convention more", _said("conventions", "polarisation", change=lambda _: "none")
    for key, value in manifest["bands"][0].items():
        yield f"band {key}", _said("bands", 0, key, change=lambda _, old=value: _other(old))
    for key, value in manifest["bands"][1].items():
        if key.endswith(("_exact", "_photons", "_nm")) and value is not None:
            yield f"second band {key}", _said("bands", 1, key, change=lambda old: old * (1 + 1e-9))
    yield "a band less", _said("bands", change=lambda bands: bands[:-1])
    yield "bands in another order", _said("bands", change=lambda bands: bands[::-1])
    for key in manifest["options"]["sampling"]:
        yield f"sampling {key}", _said("options", "sampling", key, change=_other)
    yield "footprint", _said("options", "footprint", change=lambda _: ["circle", 1.0, 1.0])
    yield "formats", _said("options", "formats", change=lambda _: ["mcpl"])
    yield "formats twice", _said("options", "formats", change=lambda old: old * 2)
    yield "no options of the scene", _said("options", "scene", change=lambda _: None)
    for key in ("seed", "stream", "schema", "plan_sha256", "total", "components"):
        yield key, _said(key, change=_other)
    yield "a content of another root", _said("content", "root", change=lambda root: root[::-1])
    yield "a root of another band", _said("content", "bands", 0, "root", change=lambda root: root[::-1])
    yield "blocks of another number", _said("content", "bands", 0, "n_blocks", change=lambda n: n + 1)
    yield "no counts among the files", _said("files", change=lambda files: _less(files, "counts.csv"))
    yield "no plan among the files", _said("files", change=lambda files: _less(files, "plan.npz"))
    yield "a version that is none", _said("version", change=lambda _: "the best")
    yield "an input without a hash", _said("inputs", "amc", "sha256", change=lambda _: "none")
    yield "an input with a path", _said("inputs", "amc", "name", change=lambda _: "../amc.inp")
    yield "notes that are numbers", _said("notes", change=lambda _: [1])


def _less(entries: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in entries.items() if key != name}


def _forged_photons() -> Iterator[tuple[str, Forge]]:
    def turned(photons: np.ndarray) -> np.ndarray:
        photons[3, 0], photons[3, 1] = photons[3, 1], photons[3, 0]
        return photons

    def copied(photons: np.ndarray) -> np.ndarray:
        photons[1] = photons[0]
        return photons

    for name, change in (
        ("a photon turned", turned),
        ("a photon twice", copied),
        ("photons reversed", lambda p: p[::-1]),
    ):

        def forge(folder: Path, change: Callable[[np.ndarray], np.ndarray] = change) -> None:
            change_photons(folder, change)
            seal(folder)

        yield name, forge


def forged_runs(folder: Path) -> list[ForgedRun]:
    """Forgeries of a finished run that its plan alone betrays."""
    manifest = json.loads((folder / "manifest.json").read_text())
    found = [*_forged_counts(), *_forged_manifests(manifest), *_forged_photons()]
    return [ForgedRun(name=name, forge=forge) for name, forge in found]


def hidden_forgeries() -> list[ForgedRun]:
    """Forgeries that only the scene's files betray."""
    found = {
        "notes": _said("notes", change=lambda _: ["all is well"]),
        "hash of amc.inp": _said("inputs", "amc", "sha256", change=lambda _: "0" * 64),
        "name of lambbot.inp": _said("inputs", "lambbot", "name", change=lambda _: "other.inp"),
        "an input less": _said("inputs", change=lambda inputs: _less(inputs, "lambbot")),
        "how the scene was read": _said("options", "scene", "lenient", change=_other),
    }
    return [ForgedRun(name=name, forge=forge) for name, forge in found.items()]


PLAN_FORGERIES = ("mass", "wavelength_nm", "seed", "rows")


def run_of_a_forged_plan(what: str, source: PhotonSource, scene: Scene, out: Path) -> None:
    """A whole run of a plan that no scene gives: every file and hash is what this plan gives."""
    arrays = {name: array.copy() for name, array in source.plan.arrays.items()}
    options = dict(source.plan.options)
    if what == "mass":
        cells = np.flatnonzero(arrays["mass"][0])[:2]
        arrays["mass"][0, cells] += [1e-6, -1e-6]
    elif what == "wavelength_nm":
        arrays["wavelength_nm"][0] += 1.0
    elif what == "rows":
        arrays["sky_wavelength_nm"][0] += 1.0
    else:
        arrays, options = dict(scene.source(source.plan.seed + 1).plan.arrays), options | {"seed": source.plan.seed + 1}
    for array in arrays.values():
        array.flags.writeable = False
    forged = PhotonSource(dataclasses.replace(source.plan, arrays=arrays, options=options))
    run_job(forged, scene, out, JobOptions(threads=1))
