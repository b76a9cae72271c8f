"""The files of a solved table of an atmosphere."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from aomc_sky.engine.atmosphere.keys import glow_rows
from aomc_sky.engine.atmosphere.report import table_report
from aomc_sky.engine.atmosphere.table import AtmosphereTable
from aomc_sky.formats.text_file import read_bytes, write_atomically, write_bytes_atomically
from aomc_sky.outputs.folder.run_folder import create_folder
from aomc_sky.outputs.tables.atmosphere import write_atmosphere_netcdf, write_atmosphere_skydist
from aomc_sky.outputs.tables.atmosphere_saves import saved_variables

NETCDF_NAME = "atmosphere.nc"
REPORT_NAME = "report.json"
REPORT_HEAD = '{\n "description": '
"""How a report of ours begins."""

SKYDIST_NAME = "skydist.inp"
DESCRIPTION_NAME = "params.atmo"


def write_table(table: AtmosphereTable, folder: Path, *, netcdf: bool = True) -> dict[str, str]:
    """Write what was solved; every file whole or not at all, the report last.

    Parameters
    ----------
    table : AtmosphereTable
        From `solve_table`.
    folder : Path
        Made where it is not there.
    netcdf : bool
        Write atmosphere.nc too.

    Returns
    -------
    dict
        Path of each file by its role: "netcdf", "report", "description" (a copy, as CalcMySky keeps one), and "skydist"
        of one sun, "skydist SUN" of several.

    Raises
    ------
    OutputError
        The operating system refuses.
    MissingExtraError
        xarray or h5netcdf is not installed.
    """
    written: dict[str, str] = {}
    lit = [sky for sky in table.skies if np.any(sky.patch_mean > 0)]
    for sky in lit:
        name = f"sun_{sky.sun_zenith_deg:g}"
        target = folder if len(table.skies) == 1 else folder / name
        create_folder(target)
        write_atmosphere_skydist(sky, target / SKYDIST_NAME)
        written["skydist" if len(table.skies) == 1 else f"skydist {name}"] = str(target / SKYDIST_NAME)
    create_folder(folder)
    if netcdf:
        _write_netcdf(table, folder / NETCDF_NAME)
        written["netcdf"] = str(folder / NETCDF_NAME)
    write_bytes_atomically(folder / DESCRIPTION_NAME, read_bytes(table.request.path))
    written["description"] = str(folder / DESCRIPTION_NAME)
    write_atomically(str(folder / REPORT_NAME), json.dumps(table_report(table), indent=1, allow_nan=False) + "\n")
    written["report"] = str(folder / REPORT_NAME)
    return written


def _write_netcdf(table: AtmosphereTable, path: Path) -> None:
    request = table.request
    more = saved_variables(table.skies, request.saves, glow=table.glow, n_glow_rows=glow_rows(table.sizes))
    write_atmosphere_netcdf(
        table.skies, path, description=request.path, more=more, significand_bits=request.significand_bits
    )
