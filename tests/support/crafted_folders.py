"""Run folders, shards and years of skies that somebody prepared: manifests that lie, links, pipes, files of others."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.outputs.manifest import rest_sha256

Manifest = dict[str, Any]
Change = Callable[[Manifest], Any]
"""Changes a manifest in place, or returns what stands in its stead: another value, or the bytes of the file."""

SHA = "0" * 64
BAD_NAMES = (
    *("../../victim", "../victim", "/etc/hostname", "{victim}", "..", ".", "", "/", "./photons-0001.npy"),
    *("sub/photons-0001.npy", "photons-0001.npy/", "photons-0001.npy/../../../victim", "photons-0001.npy\0"),
    *("photons-0001.npy\n", "\0", "~/victim", "photons-of-my-cat.jpg", "notes.txt", "photons-0001.npy.part"),
    *("Photons-0001.npy", "photons-1.npy", "\u0660.npy", "\ud800", "a" * 5000, "..\\..\\victim", "photons-00001.npy"),
)
"""Names that no manifest of a run or of a shard holds."""


def sealed(manifest: Manifest) -> Manifest:
    """The manifest with a hash of itself that agrees: what a forger writes, and no failing disk."""
    if isinstance(manifest.get("run"), dict):
        manifest["run"]["rest_sha256"] = rest_sha256({key: value for key, value in manifest.items() if key != "run"})
    return manifest


def written(manifest: Manifest, change: Change, *, seal: bool = True) -> bytes:
    """The bytes of a manifest after a change."""
    changed = copy.deepcopy(manifest)
    result = change(changed)
    if isinstance(result, bytes):
        return result
    found = changed if result is None else result
    return json.dumps(sealed(found) if seal and isinstance(found, dict) else found).encode()


def bad_names(victim: Path) -> Iterator[tuple[str, Change]]:
    """One more file under each bad name."""
    for k, name in enumerate(BAD_NAMES):
        path = name.replace("{victim}", str(victim))
        yield f"name-{k:02d}", lambda m, path=path: m["files"].update({path: {"bytes": 6, "sha256": SHA}})


def put(value: Any, *keys: Any) -> Change:
    """Put a value at a place of a manifest."""

    def change(manifest: Any) -> None:
        for key in keys[:-1]:
            manifest = manifest[key]
        manifest[keys[-1]] = value

    return change


def drop(*keys: Any) -> Change:
    """Take a member out."""

    def change(manifest: Any) -> None:
        for key in keys[:-1]:
            manifest = manifest[key]
        del manifest[keys[-1]]

    return change


ANY_MANIFEST: dict[str, Change] = {
    "text-as-bytes": lambda m: m["files"][min(m["files"])].update(bytes="twelve"),
    "number-as-text": lambda m: m["files"][min(m["files"])].update(bytes="12"),
    "negative-bytes": lambda m: m["files"][min(m["files"])].update(bytes=-1),
    "half-bytes": lambda m: m["files"][min(m["files"])].update(bytes=12.5),
    "bytes-1e300": lambda m: m["files"][min(m["files"])].update(bytes=1e300),
    "bytes-10-to-the-40": lambda m: m["files"][min(m["files"])].update(bytes=10**40),
    "bytes-true": lambda m: m["files"][min(m["files"])].update(bytes=True),
    "bytes-null": lambda m: m["files"][min(m["files"])].update(bytes=None),
    "sha-a-list": lambda m: m["files"][min(m["files"])].update(sha256=["0"]),
    "sha-short": lambda m: m["files"][min(m["files"])].update(sha256="00"),
    "sha-a-path": lambda m: m["files"][min(m["files"])].update(sha256="../../victim"),
    "file-more-keys": lambda m: m["files"][min(m["files"])].update(path="../../victim"),
    "file-a-number": lambda m: m["files"].update({min(m["files"]): 3}),
    "files-a-list": put(["../../victim"], "files"),
    "files-null": put(None, "files"),
    "no-files": drop("files"),
    "no-plan-hash": drop("plan_sha256"),
    "plan-hash-a-number": put(7, "plan_sha256"),
    "seed-a-text": put("one", "seed"),
    "seed-negative": put(-1, "seed"),
    "seed-too-large": put(2**64, "seed"),
    "notes-a-text": put("none", "notes"),
    "notes-a-number-inside": put([3], "notes"),
    "notes-half-a-pair": put(["\udead"], "notes"),
    "version-a-dict": put({}, "version"),
    "version-endless": put("1" * 100_000, "version"),
    "options-null": put(None, "options"),
    "options-scene-a-list": put([], "options", "scene"),
    "wavebands-text": put("1", "options", "scene", "wavebands"),
    "wavebands-of-texts": put(["1"], "options", "scene", "wavebands"),
    "wavebands-zero": put([0], "options", "scene", "wavebands"),
    "wavebands-true": put([True], "options", "scene", "wavebands"),
    "wavebands-beyond": put([4], "options", "scene", "wavebands"),
    "wavebands-huge": put([10**30], "options", "scene", "wavebands"),
    "no-formats": drop("options", "formats"),
    "formats-other": put(["exe"], "options", "formats"),
    "formats-a-text": put("npy", "options", "formats"),
    "bands-null": put(None, "bands"),
    "bands-numbers": put([1, 2], "bands"),
    "band-999999999": put(999_999_999, "bands", 0, "waveband"),
    "band-beyond": put(4, "bands", 0, "waveband"),
    "band-0": put(0, "bands", 0, "waveband"),
    "band-negative": put(-1, "bands", 0, "waveband"),
    "band-a-text": put("1", "bands", 0, "waveband"),
    "band-1.0": put(1.0, "bands", 0, "waveband"),
    "band-twice": put(2, "bands", 0, "waveband"),
    "band-more-keys": put("../../victim", "bands", 0, "file"),
    "band-fewer-keys": drop("bands", 0, "waveband"),
    "components-empty": put([], "components"),
    "inputs-a-path": put({"amc": {"name": "../../victim", "sha256": SHA}}, "inputs"),
    "inputs-nul": put({"amc": {"name": "amc\0.inp", "sha256": SHA}}, "inputs"),
    "inputs-a-list": put([], "inputs"),
    "run-a-list": put([], "run"),
    "scene-nul": put("a\0b", "run", "scene"),
    "scene-a-number": put(3, "run", "scene"),
    "schema-other": put("aomc-sky-manifest/99", "schema"),
    "schema-a-list": put([], "schema"),
    "more-keys": put(1, "more"),
    "a-list": lambda m: [m],
    "a-number": lambda m: 5,
    "a-text": lambda m: "manifest",
    "nothing": lambda m: None if m.clear() else {},
    "empty-file": lambda m: b"",
    "not-json": lambda m: b"\x93NUMPY",
    "utf-16": lambda m: json.dumps(m).encode("utf-16"),
    "latin-1": lambda m: json.dumps(m).encode()[:-1] + b', "\xe9": 1}',
    "nan": lambda m: json.dumps(m).encode()[:-1] + b', "run": NaN}',
    "infinity": lambda m: json.dumps(m).encode()[:-1] + b', "run": {"seconds": -Infinity}}',
    "1e999": lambda m: json.dumps({**m, "run": {}}).encode()[:-3] + b'{"seconds": 1e999}}',
    "key-twice": lambda m: json.dumps(m).encode()[:-1] + b', "files": {}}',
    "file-twice": lambda m: (
        json.dumps(m).encode().replace(b'"files": {', b'"files": {"plan.npz": 1, "plan.npz": 2, ', 1)
    ),
    "nested-40": lambda m: m["options"]["scene"].update(deep=json.loads("[" * 40 + "]" * 40)),
    "nested-100000": lambda m: b"[" * 100_000 + b"]" * 100_000,
    "nested-100000-objects": lambda m: b'{"a":' * 100_000 + b"1" + b"}" * 100_000,
    "digits-100000": lambda m: b'{"seed": ' + b"9" * 100_000 + b"}",
    "five-million-values": lambda m: b"[" + b"0," * 5_000_000 + b"0]",
    "cut": lambda m: json.dumps(m).encode()[:-20],
    "nul-bytes": lambda m: b"\0" * 1000,
}
"""Changes that neither the manifest of a run nor that of a shard survives."""

RUN_MANIFEST: dict[str, Change] = {
    "total-a-text": put("300", "total"),
    "total-huge": put(2**70, "total"),
    "content-a-list": put([], "content"),
    "content-band-beyond": put(999_999_999, "content", "bands", 0, "waveband"),
    "content-band-twice": put(2, "content", "bands", 0, "waveband"),
    "content-root-a-number": put(1, "content", "root"),
    "content-blocks-a-text": put("1", "content", "bands", 0, "n_blocks"),
    "launched-a-text": put("100", "bands", 0, "launched"),
    "wavelength-a-text": put("550", "bands", 0, "wavelength_nm"),
    "wavelength-true": put(True, "bands", 0, "wavelength_nm"),
    "mean-cosine-2": put(2, "bands", 0, "mean_cosine_exact"),
    "component-irradiance-a-list": put([1], "bands", 0, "component_irradiance_W_m2_nm"),
    "variance-1": put(1, "bands", 0, "eo_variance_is_finite"),
    "replicates-0": put(0, "options", "sampling", "replicates"),
    "lists-a-shard": lambda m: m["files"].update({"photons-0001.k1-of-2.npy": {"bytes": 6, "sha256": SHA}}),
    "lists-itself": lambda m: m["files"].update({"manifest.json": {"bytes": 6, "sha256": SHA}}),
    "lists-a-year": lambda m: m["files"].update({"counts.npy": {"bytes": 6, "sha256": SHA}}),
    "is-of-a-shard": put("aomc-sky-shard/1", "schema"),
}
"""Changes of the manifest of a whole run."""

SHARD_MANIFEST: dict[str, Change] = {
    "lists-another-shard": lambda m: m["files"].update({"photons-0001.k2-of-3.npy": {"bytes": 6, "sha256": SHA}}),
    "lists-the-whole-run": lambda m: m["files"].update({"photons-0001.npy": {"bytes": 6, "sha256": SHA}}),
    "lists-the-plan": lambda m: m["files"].update({"plan.npz": {"bytes": 6, "sha256": SHA}}),
    "lists-a-manifest": lambda m: m["files"].update({"manifest.k1-of-3.json": {"bytes": 6, "sha256": SHA}}),
    "index-2": put(2, "shard", "index"),
    "count-4": put(4, "shard", "count"),
    "index-0": put(0, "shard", "index"),
    "index-a-text": put("1", "shard", "index"),
    "count-huge": put(10**9, "shard", "count"),
    "shard-null": put(None, "shard"),
    "first-photon-negative": put(-1, "bands", 0, "first_photon"),
    "photons-a-text": put("7", "bands", 0, "n_photons"),
    "is-of-a-run": put("aomc-sky-manifest/1", "schema"),
}
"""Changes of the manifest of a shard."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Odd:
    """Something that is no regular file of the folder: how it is made under a name, for a file outside."""

    name: str
    make: Callable[[Path, Path], None]


def _link_to_copy(path: Path, outside: Path) -> None:
    (outside / path.name).write_bytes(path.read_bytes())
    path.unlink()
    path.symlink_to(outside / path.name)


def _in_place_of(make: Callable[[Path, Path], object]) -> Callable[[Path, Path], None]:
    def put_there(path: Path, outside: Path) -> None:
        path.unlink()
        make(path, outside)

    return put_there


ODD = (
    Odd(name="link-to-a-copy", make=_link_to_copy),
    Odd(name="link-to-the-victim", make=_in_place_of(lambda path, outside: path.symlink_to("../outside/victim"))),
    Odd(name="link-to-nothing", make=_in_place_of(lambda path, outside: path.symlink_to(outside / "new"))),
    Odd(name="link-to-a-folder", make=_in_place_of(lambda path, outside: path.symlink_to(outside))),
    Odd(name="link-to-zeros", make=_in_place_of(lambda path, outside: path.symlink_to("/dev/zero"))),
    Odd(name="link-to-itself", make=_in_place_of(lambda path, outside: path.symlink_to(path.name))),
    Odd(name="pipe", make=_in_place_of(lambda path, outside: os.mkfifo(path))),
    Odd(name="folder", make=_in_place_of(lambda path, outside: path.mkdir())),
)
"""What can stand under a name instead of a file."""
