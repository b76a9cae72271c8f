"""A run folder, opened again: its plan as a photon source, and what its manifest says."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import ForeignOutputError, SceneError, UsageError
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import chosen_bands, read_manifest
from aomc_sky.outputs.shard import MANIFEST, PLAN
from aomc_sky.plan.plan import Plan
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
    """Open a run folder; InputFileError where there is no run, or its plan or manifest is damaged.

    ForeignOutputError where the manifest is of another plan.
    """
    folder = RunFolder(Path(os.path.abspath(path)))
    if not (folder.path / PLAN).is_file():
        raise not_a_run(Path(path), "aomc-sky run --out")
    source = PhotonSource.from_plan(Plan.load(folder.path / PLAN))
    manifest = read_manifest(folder.path / MANIFEST) if os.path.lexists(folder.path / MANIFEST) else None
    if manifest is not None and manifest["plan_sha256"] != source.plan.sha256:
        raise ForeignOutputError(
            f"{folder.path / MANIFEST} belongs to another run (another scene, seed or options) than {PLAN}: plan "
            f"{manifest['plan_sha256'][:16]}, not {source.plan.sha256[:16]}"
        )
    return StoredRun(path=folder.path, source=source, manifest=manifest, bands=tuple(chosen_bands(source)))


def scene_file(named: str | Path) -> Path:
    """amc.inp of a scene that the user names, by itself or by its folder."""
    path = Path(os.path.abspath(named))
    path = path / "amc.inp" if path.is_dir() else path
    if not path.is_file():
        raise SceneError(f"{named}: there is no amc.inp here")
    return path
