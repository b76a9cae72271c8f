"""Which files of a folder a run of ours made: those beside a plan of ours, and those that a manifest of ours lists."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Collection
from pathlib import Path

import numpy as np

from aomc_sky.errors import InputFileError
from aomc_sky.outputs.names import MANIFEST, PLAN
from aomc_sky.outputs.manifest.file import load_manifest
from aomc_sky.regular_file import open_regular

_MAX_OPTIONS_BYTES = 1 << 20
_SCHEMAS = {True: ("manifest.schema.json", "year_manifest.schema.json"), False: ("shard_manifest.schema.json",)}


def made_by_us(folder: Path, names: Collection[str]) -> set[str]:
    """The names that a run or a year of ours made, among names that are known to be of the kind of ours.

    All of them beside a plan of ours, of whatever version of the package; without one, those that a whole
    manifest lists, that manifest, and a plan that is damaged.
    """
    if PLAN in names and is_our_plan(folder / PLAN):
        return set(names)
    found = {PLAN} if _is_cut_archive(folder / PLAN) else set()
    for name in names:
        if name.startswith("manifest."):
            listed = _listed(folder / name)
            found |= listed and {name, *listed}
    return found & set(names)


def is_our_plan(path: Path) -> bool:
    """Whether a file is a plan of ours, of whatever version, whole or not."""
    try:
        with open_regular(path, follow_links=False) as file, zipfile.ZipFile(file) as members:
            if members.getinfo("options.npy").file_size > _MAX_OPTIONS_BYTES:
                return False
            data = members.read("options.npy")
        text = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False).tobytes()
        return str(json.loads(text)["stream"]).startswith("aomc-sky")
    except Exception:  # zipfile, zlib, numpy and json each have their own
        return False


def _is_cut_archive(path: Path) -> bool:
    """Whether a file begins like an archive and is none: what a failing disk makes of a plan, and nobody by hand."""
    try:
        with open_regular(path, follow_links=False) as file:
            return file.read(2) == b"PK" and not zipfile.is_zipfile(file)
    except OSError:
        return False


def _listed(manifest: Path) -> set[str]:
    """Files that a manifest lists, none where it is no manifest of ours."""
    for schema in _SCHEMAS[manifest.name == MANIFEST]:
        try:
            return set(load_manifest(manifest, schema)["files"])
        except InputFileError:
            continue
    return set()
