"""The photon formats by name: the only place that knows them all."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from aomc_sky.errors import UsageError

PHOTON_FORMATS = {
    "csv": "aomc_sky.outputs.photons.csv:CsvWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "raw": "aomc_sky.outputs.photons.raw:RawWriter",
}
"""Name of a photon format -> "module:Class"; "none" writes counts and plan only."""


def photon_writer(name: str) -> Any:
    """Return the writer class of a photon format."""
    target = PHOTON_FORMATS.get(name)
    if target is None:
        raise UsageError(f"there is no photon format {name!r}; the formats are {', '.join(PHOTON_FORMATS)} and none")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)
