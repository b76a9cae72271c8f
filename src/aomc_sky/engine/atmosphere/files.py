"""The files of a solved table of an atmosphere, its report among them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.engine.atmosphere.keys import glow_rows, size_report
from aomc_sky.engine.atmosphere.table import AtmosphereTable
from aomc_sky.formats.text_file import read_bytes, write_atomically, write_bytes_atomically
from aomc_sky.outputs.folder.run_folder import create_folder
from aomc_sky.outputs.tables.atmosphere import write_atmosphere_netcdf, write_atmosphere_skydist
from aomc_sky.outputs.tables.atmosphere_saves import saved_variables
from aomc_sky.skies.atmosphere import AtmosphereSky

NETCDF_NAME = "atmosphere.nc"
REPORT_NAME = "report.json"
REPORT_HEAD = '{\n "description": '
"""How a report of ours begins."""

SKYDIST_NAME = "skydist.inp"
DESCRIPTION_NAME = "params.atmo"


def write_table(table: AtmosphereTable, folder: Path, *, netcdf: bool = True) -> dict[str, str]:
    """Write what was solved, every file whole or not at all, the report last; return the path of each file by its role.

    Roles are "netcdf", "report", "description" (a copy, as CalcMySky keeps one), and "skydist" of one sun,
    "skydist SUN" of several.
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


def table_report(table: AtmosphereTable) -> dict[str, Any]:
    """What a table, with or without skies, rests on and how good it is: JSON values.

    Species with optical depths and norms of their phase functions, what was dropped; per sun the irradiances,
    the truncation, the estimated errors and the time.
    """
    report, medium = table.report, table.medium
    return {
        "description": table.request.path,
        "version": aomc_sky.__version__,
        "wavelength_nm": medium.wavelength_nm.tolist(),
        "optical_depth": {name: rows.tolist() for name, rows in report.optical_depth.items()},
        "phase_norm": {name: rows.tolist() for name, rows in report.phase_norm.items()},
        "dropped": list(report.dropped),
        "ground_albedo": medium.ground_albedo.tolist(),
        "sun_angular_radius_deg": float(np.rad2deg(medium.sun_angular_radius_rad)),
        "bins": list(table.bins),
        "sizes": size_report(table.sizes),
        "suns": [
            {"sun_zenith_deg": degrees, "method": method}
            for degrees, method in zip(table.sun_zenith_deg, table.methods, strict=True)
        ]
        if not table.skies
        else [_sun_report(sky) for sky in table.skies],
        "seconds": table.seconds,
    }


def _sun_report(sky: AtmosphereSky) -> dict[str, Any]:
    solved = sky.solved
    radiance = sky.patch_mean.sum(axis=1)
    relative = np.divide(sky.patch_error, radiance, out=np.zeros_like(radiance), where=radiance > 0)
    return {
        "sun_zenith_deg": sky.sun_zenith_deg,
        "method": solved.method,
        "reason": solved.reason or None,
        "orders": solved.n_orders,
        "paths": solved.n_paths or None,
        "paths_error": solved.resolution_error if solved.n_paths else None,
        "visible_share": solved.visible_share,
        "direct_irradiance": sky.direct_irradiance.tolist(),
        "diffuse_irradiance": sky.diffuse_irradiance.tolist(),
        "truncation": None if solved.more is None else solved.truncation.tolist(),
        "largest_relative_error": relative.max(axis=1).tolist(),
        "series_error": solved.series_error,
        "patch_change": sky.patch_change,
        "seconds": dict(solved.seconds),
    }
