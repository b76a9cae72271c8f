"""A run folder that is opened again: its plan as a photon source, and its manifest."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import ForeignOutputError, UsageError
from aomc_sky.outputs.counts import chosen_bands
from aomc_sky.outputs.manifest import read_manifest
from aomc_sky.outputs.run_folder import MANIFEST, PLAN
from aomc_sky.plan.plan import Plan
from aomc_sky.source.read.kind import not_a_run


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredRun:
    """A run that was read from its folder."""

    path: Path  #: the folder, absolute
    source: PhotonSource  #: from the plan alone
    manifest: dict[str, Any] | None  #: of a finished run
    bands: tuple[int, ...]  #: wavebands that the run was asked for [0-based]

    def chosen(self, wavebands: list[int] | None) -> tuple[int, ...]:
        """The named wavebands [1-based], or all of the run, in its order."""
        if not wavebands:
            return self.bands
        for waveband in wavebands:
            if waveband - 1 not in self.bands:
                first = ", ".join(str(band + 1) for band in self.bands[:20]) + (" ..." if len(self.bands) > 20 else "")
                plural = "s" if len(self.bands) > 1 else ""
                raise UsageError(f"waveband {waveband} is not in this run; it has waveband{plural} {first}")
        return tuple(band for band in self.bands if band + 1 in wavebands)


def open_run(path: str | Path) -> StoredRun:
    """Open a run folder.

    InputFileError if there is no run, or if its plan or manifest is damaged. ForeignOutputError if the manifest belongs
    to another plan.
    """
    folder = Path(os.path.abspath(path))
    if not (folder / PLAN).is_file():
        raise not_a_run(Path(path))
    source = PhotonSource.from_plan(Plan.load(folder / PLAN))
    manifest = read_manifest(folder / MANIFEST) if os.path.lexists(folder / MANIFEST) else None
    if manifest is not None and manifest["plan_sha256"] != source.plan.sha256:
        raise ForeignOutputError(
            f"{folder / MANIFEST} belongs to another run (another scene, seed or options) than {PLAN}: plan "
            f"{manifest['plan_sha256'][:16]}, not {source.plan.sha256[:16]}"
        )
    return StoredRun(path=folder, source=source, manifest=manifest, bands=tuple(chosen_bands(source)))
