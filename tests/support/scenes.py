"""Small scenes written into a test's own folder."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.support.shared import INPUTS


def copy_scene(name: str, folder: Path) -> Path:
    """Copy a scene of inputs/ into `folder` and return its amc.inp."""
    target = folder / name
    shutil.copytree(INPUTS / name, target, ignore=shutil.ignore_patterns("aomc-sky-out"))
    return target / "amc.inp"


def change_config(amc_inp: Path, **values: object) -> None:
    """Write amc.inp again with other values."""
    from dataclasses import replace

    from aomc_sky.formats.amc import read_amc, write_amc

    write_amc(replace(read_amc(amc_inp), **values), amc_inp)


def run_bytes(folder: Path) -> dict[str, bytes]:
    """Bytes of every file of a run folder; of the manifest, what does not tell of time."""
    import json

    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    manifest = json.loads(files["manifest.json"])
    del manifest["run"]
    files["manifest.json"] = json.dumps(manifest).encode()
    return files
