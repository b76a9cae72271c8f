"""Photon formats by name. A format is one file in `photons`, which is imported when it is needed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aomc_sky.emission.photon_source import PhotonSource

PHOTON_FORMATS = {
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "raw": "aomc_sky.outputs.photons.raw:RawWriter",
    "csv": "aomc_sky.outputs.photons.csv:CsvWriter",
}
"""Name of a photon format, in which its files end -> "module:Class", in the order of manifests."""

FOLDER_FORMATS = tuple(name for name in PHOTON_FORMATS if name != "csv")
"""Formats of photons in a run folder; csv is for export alone."""

SOURCE, SOURCE_FILE = "source", "source.sky"
"""The format that holds no photons, but their source for other codes; and its file in a run folder."""

RUN_FORMATS = (*FOLDER_FORMATS, SOURCE)
"""What a run writes."""


def photon_writer(name: str) -> Any:
    """The writer class of a photon format."""
    module, _, attribute = PHOTON_FORMATS[name].partition(":")
    return getattr(import_module(module), attribute)


def columns_of(source: PhotonSource) -> tuple[str, ...]:
    """The numbers of a photon in a raw file and in a csv file, in their order."""
    position = ("x_m", "y_m") if source.has_positions else ()
    weight = ("weight",) if source.has_weights else ()
    stokes = ("q", "u") if source.has_polarisation else ()
    return ("ux", "uy", "uz", *position, *weight, *stokes)
