"""Solve one atmosphere under several suns, and write the skies into a folder."""

from __future__ import annotations

import dataclasses
import json
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.atmosphere.lights import chosen_lights
from aomc_sky.atmosphere.medium import Medium
from aomc_sky.engine.atmosphere_keys import bins_of, glow_rows, size_report, suns_of
from aomc_sky.errors import ModelLimitWarning, OutputError, UsageError
from aomc_sky.formats.atmo import read_atmo
from aomc_sky.formats.moon_place import MoonPlace
from aomc_sky.formats.text_file import read_bytes, write_atomically, write_bytes_atomically
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.atmosphere_saves import MOST_SOURCES, Saves, check_saves, saved_variables
from aomc_sky.outputs.atmosphere_table import write_atmosphere_netcdf, write_atmosphere_skydist
from aomc_sky.skies.atmosphere import AtmosphereSky
from aomc_sky.source.atmosphere_medium import MediumReport, read_medium
from aomc_sky.source.night_lights import lights_of

NETCDF_NAME = "atmosphere.nc"
REPORT_NAME = "report.json"
SKYDIST_NAME = "skydist.inp"
DESCRIPTION_NAME = "params.atmo"
_MOST_VALUES = 500_000_000
"""Radiances of one table; more would not fit into the memory of a small machine."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TableRequest:
    """What a table of an atmosphere is to hold.

    Parameters
    ----------
    path : str
        The description.
    sun_zenith_deg : tuple of float or None
        Zenith angles of the sun, rising; None is as many from 0 to 90 as the description says. [deg, 0 to 108]
    sun_azimuth_deg : float
        Azimuth of the sun, from +x towards +y. [deg]
    wavelength_nm : tuple of float or None
        Wavelengths, each the nearest of the description; None is all. [nm]
    method : str
        As `aomc_sky.atmosphere.method.chosen_method` has it.
    n_orders : int or None
        Most interactions that count; None is what the description says.
    n_paths : int or None
        Backward paths of each direction and wavelength; None is as many as `solve_sky` finds right.
    bins : (int, int) or None
        Equal bins of zenith and azimuth; None is those of the description, or 45 and 180.
    allow_paths : tuple of str
        Folders below which tables of the description may lie, besides its own.
    saves : Saves
        What the netCDF file holds besides radiances and irradiances.
    significand_bits : int or None
        Of the numbers in the netCDF file, then in float32; None is float64. [1 to 24]
    moon : MoonPlace
        Where the Moon hides part of the sun; empty: no Moon.
    ground_luminance_cd_m2 : float
        Of the ground's own light. [0 or more]
    """

    path: str
    sun_zenith_deg: tuple[float, ...] | None
    sun_azimuth_deg: float = 0.0
    wavelength_nm: tuple[float, ...] | None = None
    method: str = "auto"
    n_orders: int | None = None
    n_paths: int | None = None
    bins: tuple[int, int] | None = None
    allow_paths: tuple[str, ...] = ()
    saves: Saves = field(default_factory=Saves)
    significand_bits: int | None = None
    moon: MoonPlace = field(default_factory=MoonPlace)
    ground_luminance_cd_m2: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class AtmosphereTable:
    """A description, evaluated, and its skies once they are solved.

    Parameters
    ----------
    request : TableRequest
        What was asked for.
    medium : Medium
        The atmosphere.
    report : MediumReport
        What became of the species.
    sun_zenith_deg : tuple of float
        Zenith angles of the sun, rising. [deg]
    bins : (int, int)
        Equal bins of zenith and azimuth.
    sizes : mapping of str to int
        Texture sizes and numbers of points of the description.
    glow : ndarray, float64, shape (n_wl,), or None
        Radiance of a ground of 1 cd m-2, where the description has it. [W m-2 sr-1 nm-1]
    methods : tuple of str
        "order1" or "sos" of each sun.
    skies : tuple of AtmosphereSky
        Of each sun; empty before the solution.
    seconds : float
        Time of the solution. [s]
    """

    request: TableRequest
    medium: Medium
    report: MediumReport
    sun_zenith_deg: tuple[float, ...]
    bins: tuple[int, int]
    sizes: Mapping[str, int]
    glow: np.ndarray | None
    methods: tuple[str, ...]
    skies: tuple[AtmosphereSky, ...] = ()
    seconds: float = 0.0


def prepare_table(request: TableRequest) -> AtmosphereTable:
    """Read and check everything, solve nothing.

    Parameters
    ----------
    request : TableRequest
        What is wanted.

    Returns
    -------
    AtmosphereTable
        Without skies.

    Raises
    ------
    InputFileError
        Everything that is wrong with the description and its files.
    UsageError
        Suns that the method is not good for, all of them named; a table too large.
    SceneError
        Deep night.
    """
    description = read_atmo(request.path, allow_paths=request.allow_paths)
    medium, report = read_medium(description, request.wavelength_nm)
    suns = suns_of(description.sizes) if request.sun_zenith_deg is None else request.sun_zenith_deg
    bins = request.bins or bins_of(description.sizes)
    glow = None if description.ground_glow is None else description.ground_glow[report.wavelength_index]
    methods, refused = [], []
    for degrees in suns:
        try:
            lights = chosen_lights(
                medium, float(np.deg2rad(degrees)), method=request.method, n_orders=request.n_orders,
                n_paths=request.n_paths,
                **lights_of(
                    request.moon, request.ground_luminance_cd_m2, medium, report, degrees, request.path,
                    sun_azimuth_deg=request.sun_azimuth_deg,
                ),
            )  # fmt: skip
            methods.append(lights.method)
        except UsageError as error:
            refused.append((degrees, error))
    if refused:
        named = ", ".join(f"{degrees:g}" for degrees, _ in refused)
        raise UsageError(f"--sun-zenith {named}: {refused[0][1]}")
    check_saves(request.saves, wavelength_nm=medium.wavelength_nm, methods=methods, glow=glow)
    n_places = bins[0] * bins[1] + (MOST_SOURCES if request.saves.source else 0)
    n_values = len(methods) * medium.wavelength_nm.size * min(lights.n_orders, 8) * n_places
    if n_values > _MOST_VALUES:
        raise UsageError(
            f"the table would hold {n_values:.3g} radiances, {_MOST_VALUES:g} is the most; ask for fewer suns, "
            "wavelengths or bins"
        )
    return AtmosphereTable(
        request=request,
        medium=medium,
        report=report,
        sun_zenith_deg=suns,
        bins=bins,
        sizes=description.sizes,
        glow=glow,
        methods=tuple(methods),
    )


def solve_table(table: AtmosphereTable, *, progress: Callable[[int, int], None] | None = None) -> AtmosphereTable:
    """Solve for every sun.

    Parameters
    ----------
    table : AtmosphereTable
        From `prepare_table`.
    progress : callable, optional
        Gets the number of skies that are done, and of all.

    Returns
    -------
    AtmosphereTable
        With skies.
    """
    started, skies = time.perf_counter(), []
    for degrees in table.sun_zenith_deg:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelLimitWarning)  # `prepare_table` has told of low suns
            skies.append(_sky(table, degrees))
        if progress is not None:
            progress(len(skies), len(table.sun_zenith_deg))
    return dataclasses.replace(table, skies=tuple(skies), seconds=time.perf_counter() - started)


def _sky(table: AtmosphereTable, sun_zenith_deg: float) -> AtmosphereSky:
    request = table.request
    return AtmosphereSky(
        medium=table.medium,
        sun_zenith_deg=sun_zenith_deg,
        sun_azimuth_deg=request.sun_azimuth_deg,
        method=request.method,
        n_orders=request.n_orders,
        n_paths=request.n_paths,
        grid=PatchGrid.regular(*table.bins),
        **lights_of(
            request.moon,
            request.ground_luminance_cd_m2,
            table.medium,
            table.report,
            sun_zenith_deg,
            request.path,
            sun_azimuth_deg=request.sun_azimuth_deg,
        ),
    )


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
        _make_folder(target)
        write_atmosphere_skydist(sky, target / SKYDIST_NAME)
        written["skydist" if len(table.skies) == 1 else f"skydist {name}"] = str(target / SKYDIST_NAME)
    _make_folder(folder)
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


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def table_report(table: AtmosphereTable) -> dict[str, Any]:
    """What a table rests on and how good it is: JSON values.

    Parameters
    ----------
    table : AtmosphereTable
        With or without skies.

    Returns
    -------
    dict
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
