"""Photon formats by name. A format is one file in `photons`, which is imported when it is needed."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from aomc_sky.emission.photon_source import PhotonSource

PHOTON_FORMATS = {
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "raw": "aomc_sky.outputs.photons.raw:RawWriter",
    "csv": "aomc_sky.outputs.photons.csv:CsvWriter",
}
"""Name of a photon format -> "module:Class" of its writer, in the order of manifests.

The names of files in a run folder, the files that --force removes, those that `verify` reads, and the choices of `run`
and `export` follow from it.
"""

RunFormatWord = Literal["npy", "mcpl", "raw", "source"]
"""What `run_formats` gives, for type checkers."""

SOURCE, SOURCE_FILE = "source", "source.sky"
"""The format that holds no photons, but their source for other codes; and its file in a run folder."""

WAVEBAND = "(?:[0-9]{4}|[1-9][0-9]{4,8})"
"""Pattern of the number of a waveband in the name of a file."""


def run_formats() -> list[str]:
    """What a run writes; csv is for export alone."""
    return [*(name for name in PHOTON_FORMATS if name != "csv"), SOURCE]


def photon_writer(name: str) -> Any:
    """The writer class of a photon format."""
    module, _, attribute = PHOTON_FORMATS[name].partition(":")
    return getattr(import_module(module), attribute)


def formats_of(file_names: Iterable[str]) -> dict[str, str]:
    """The format of each name that a file of photons has. Once no name is left, no further format is imported."""
    left: set[str] = {*file_names}
    found: dict[str, str] = {}
    for name in PHOTON_FORMATS:
        own = {file for file in left if _pattern(photon_writer(name).names).fullmatch(file)}
        found |= dict.fromkeys(own, name)
        left -= own
        if not left:
            break
    return found


@cache
def _pattern(names: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile("|".join(map(re.escape, names)).replace(re.escape("{:04d}"), WAVEBAND))


def columns_of(source: PhotonSource) -> tuple[str, ...]:
    """The numbers of a photon in a raw file and in a csv file, in their order."""
    position = ("x_m", "y_m") if source.has_positions else ()
    weight = ("weight",) if source.has_weights else ()
    stokes = ("q", "u") if source.has_polarisation else ()
    return ("ux", "uy", "uz", *position, *weight, *stokes)
