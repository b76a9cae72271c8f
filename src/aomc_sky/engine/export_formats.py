"""The formats of ``export`` by name; the command line reads them without the code that writes them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, SOURCE, SOURCE_FILE


@dataclass(frozen=True, kw_only=True, slots=True)
class Export:
    """A format."""

    make: str  #: "module:function" that writes it and returns the files and whether they were there
    file_name: str = ""  #: in a folder, where it is one file; empty: it is a folder
    endings: tuple[str, ...] = ()  #: of names that are a file
    is_strict: bool = False  #: a name with another ending is no folder
    holds_all: bool = False  #: wavebands, always
    is_scalar: bool = False  #: light without polarisation


_FILES = {
    "mcpl": Export(make="aomc_sky.engine.export:export_mcpl", file_name="photons.mcpl", endings=(".mcpl",)),
    "netcdf": Export(
        make="aomc_sky.engine.export:export_netcdf", file_name="counts.nc", endings=(".nc",), holds_all=True
    ),
    "aomc": Export(make="aomc_sky.engine.export:export_aomc", is_scalar=True),
    "envmap": Export(
        make="aomc_sky.engine.export:export_envmap", endings=(".npy", ".hdr", ".exr"), is_strict=True, is_scalar=True
    ),
    SOURCE: Export(
        make="aomc_sky.engine.export:export_source",
        file_name=SOURCE_FILE,
        endings=(Path(SOURCE_FILE).suffix,),
        holds_all=True,
    ),
}


def exports() -> dict[str, Export]:
    """The formats by name: those of photons, as a run writes them, and those above.

    Not raw: its files have no head, and only the manifest of a run says what their numbers are.
    """
    photons = Export(make="aomc_sky.engine.export:export_photons")
    return {name: photons for name in PHOTON_FORMATS if name != "raw"} | _FILES
