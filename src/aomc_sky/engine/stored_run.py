"""A run folder, opened again: its plan as a photon source, and what its manifest knows."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError, InputFileError, OutputError, SceneError, UsageError
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import read_manifest, require_wavebands
from aomc_sky.outputs.shard import MANIFEST, PLAN
from aomc_sky.regular_file import open_regular
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.read.kind import not_a_run


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredRun:
    """A run as its folder has it."""

    path: Path  #: the folder, absolute
    source: PhotonSource  #: from the plan alone
    manifest: dict[str, Any] | None  #: None where the run is unfinished
    bands: tuple[int, ...]  #: wavebands that the run was asked for [0-based]

    def chosen(self, wavebands: list[int] | None) -> tuple[int, ...]:
        """Wavebands for a job, in the order of the run: those named [1-based], or all of the run."""
        if not wavebands:
            return self.bands
        for waveband in wavebands:
            if waveband - 1 not in self.bands:
                raise UsageError(f"waveband {waveband} is not in this run; it has {_named(self.bands)}")
        return tuple(band for band in self.bands if band + 1 in wavebands)


def _named(bands: tuple[int, ...]) -> str:
    first = ", ".join(str(b + 1) for b in bands[:20])
    return f"waveband{'s' if len(bands) > 1 else ''} {first}{' ...' if len(bands) > 20 else ''}"


def open_run(path: str | Path) -> StoredRun:
    """Open a run folder.

    InputFileError where there is no run, or its plan or manifest is damaged.
    """
    folder = Path(os.path.abspath(path))
    require_run(Path(path), "aomc-sky run --out")
    try:
        source = PhotonSource.from_plan(Plan.load(folder / PLAN))
        manifest = read_manifest(folder / MANIFEST) if os.path.lexists(folder / MANIFEST) else None
        if manifest is not None:
            require_wavebands(folder / MANIFEST, manifest, source.n_bands)
    except (InputFileError, OutputError):
        raise
    except AomcSkyError as error:
        raise refuse(path, str(error), advice="make the run again into another folder") from error
    if manifest is not None and manifest["plan_sha256"] != source.plan.sha256:
        raise refuse(path, f"{MANIFEST} belongs to another plan than {PLAN}", advice="make the run again")
    return StoredRun(path=folder, source=source, manifest=manifest, bands=_bands(source, manifest))


def require_run(folder: Path, maker: str) -> None:
    """Raise where a path is not the folder of a run; `maker` is the command that writes one."""
    if folder.is_dir():
        RunFolder(folder).require_regular_files()
    if not (folder / PLAN).is_file():
        raise not_a_run(folder, maker)


def _bands(source: PhotonSource, manifest: dict[str, Any] | None) -> tuple[int, ...]:
    if manifest is not None:
        return tuple(int(band["waveband"]) - 1 for band in manifest["bands"])
    requested = tuple(b for b in range(source.n_bands) if source.plan.arrays["requested"][b] > 0)
    return requested or tuple(range(source.n_bands))


def scene_file(run: StoredRun, named: str | Path | None) -> Path | None:
    """amc.inp of the scene that a run came from, None where it is not found.

    What the user gave, amc.inp or its folder; else amc.inp where it stood when the run was made, or in the folder
    above the run, if it still has the contents that the run read.
    """
    if named is not None:
        path = Path(os.path.abspath(named))
        path = path / "amc.inp" if path.is_dir() else path
        if not path.is_file():
            raise SceneError(f"{named}: there is no amc.inp here")
        return path
    if run.manifest is None:
        return None
    recorded = run.manifest["run"].get("scene") if isinstance(run.manifest.get("run"), dict) else None
    candidates = [run.path / recorded] if isinstance(recorded, str) else []
    hashes = run.manifest.get("inputs", {})
    expected = {"amc.inp": hashes.get("amc", {}).get("sha256"), "lambbot.inp": hashes.get("lambbot", {}).get("sha256")}
    for path in (*candidates, run.path.parent / "amc.inp"):
        folder = Path(os.path.normpath(path)).parent
        if all(_sha256(folder / name) == digest for name, digest in expected.items()):
            return folder / "amc.inp"
    return None


def _sha256(path: Path) -> str:
    try:
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
