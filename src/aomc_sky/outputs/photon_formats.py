"""Photon formats by name. A format is one file in `photons`, which is imported when it is needed."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

from aomc_sky.errors import UsageError

PHOTON_FORMATS = {
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "raw": "aomc_sky.outputs.photons.raw:RawWriter",
    "csv": "aomc_sky.outputs.photons.csv:CsvWriter",
}
"""Name of a photon format -> "module:Class", in the order of manifests; "none" writes counts and plan only."""

FOLDER_FORMATS = tuple(name for name in PHOTON_FORMATS if name != "csv")
"""Formats in a run folder; csv is for export alone."""

WAVEBAND = "(?:[0-9]{4}|[1-9][0-9]{4,8})"
"""Pattern of the number of a waveband in the name of a file."""


def photon_writer(name: str) -> Any:
    """The writer class of a photon format."""
    target = PHOTON_FORMATS.get(name)
    if target is None:
        raise UsageError(f"there is no photon format {name!r}; the formats are {', '.join(PHOTON_FORMATS)} and none")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)


def file_pattern(*formats: str) -> str:
    """Pattern of the names of all files of these formats."""
    names = [re.escape(name) for key in formats for name in photon_writer(key).names]
    return "|".join(name.replace(re.escape("{:04d}"), WAVEBAND) for name in names)
