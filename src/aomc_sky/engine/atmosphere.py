"""One atmosphere under several suns: asked for, checked, solved, and written as tables with a report."""

from __future__ import annotations

import dataclasses
import json
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.formats.sky_toml.keys import MoonDirection
from aomc_sky.formats.text_file import read_bytes, write_atomically, write_bytes_atomically
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.folder.run_folder import create_folder
from aomc_sky.outputs.tables.atmosphere import (
    MOST_SOURCES,
    Saves,
    check_saves,
    write_atmosphere_netcdf,
    write_atmosphere_skydist,
)
from aomc_sky.skies.atmosphere.description.medium import (
    MediumReport,
    glow_of_luminance,
    moon_of_direction,
    read_medium,
    warn_of_outside,
)
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.model import DEFAULT_BINS, AtmosphereSky
from aomc_sky.skies.atmosphere.sky.method import Lights, chosen_lights

_GLOW_ROWS = 18
MOST_BINS = 3600
MOST_SUNS = 1000

ZENITH_ROWS = "scattering texture size for vza"
AZIMUTH_COLUMNS = "scattering texture size for dot(view,sun)"
SUNS = "scattering texture size for sza"
GLOW_ROWS = "light pollution texture size for vza"


def suns_of(sizes: Mapping[str, int]) -> tuple[float, ...]:
    """Zenith angles of as many suns as a description asks for, evenly from 0 to 90. [deg]

    UsageError where the description does not say how many, or more than 1000.
    """
    if SUNS not in sizes:
        raise UsageError(f'--sun-zenith all: the description has no "{SUNS}"')
    if sizes[SUNS] > MOST_SUNS:
        raise UsageError(f'--sun-zenith all: "{SUNS}" is {sizes[SUNS]}, {MOST_SUNS} is the most')
    return tuple(round(float(sun), 10) for sun in np.linspace(0.0, 90.0, sizes[SUNS]))


_MOST_VALUES = 500_000_000
"""Radiances of one table; more would not fit into the memory of a small machine."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TableRequest:
    """What a table of an atmosphere is to hold."""

    path: str  #: the description
    #: zenith angles of the sun, rising; None is as many from 0 to 90 as the description says [deg, 0 to 108]
    sun_zenith_deg: tuple[float, ...] | None
    sun_azimuth_deg: float = 0.0  #: azimuth of the sun, from +x towards +y [deg]
    #: wavelengths, each the nearest of the description; None is all [nm]
    wavelength_nm: tuple[float, ...] | None = None
    method: str = "auto"  #: as `aomc_sky.skies.atmosphere.sky.method.chosen_method` has it
    n_orders: int | None = None  #: most interactions that count; None is what the description says
    #: backward paths of each direction and wavelength; None is as many as `solve_sky` finds right
    n_paths: int | None = None
    #: equal bins of zenith and azimuth; None is those of the description, or 45 and 180
    bins: tuple[int, int] | None = None
    allow_paths: tuple[str, ...] = ()  #: folders below which tables of the description may lie, besides its own
    saves: Saves = field(default_factory=Saves)  #: what the netCDF file holds besides radiances and irradiances
    #: of the numbers in the netCDF file, then in float32; None is float64 [1 to 24]
    significand_bits: int | None = None
    moon: MoonDirection = field(default_factory=MoonDirection)  #: where the Moon hides part of the sun; empty: no Moon
    ground_luminance_cd_m2: float = 0.0  #: of the ground's own light [0 or more]


@dataclass(frozen=True, kw_only=True, slots=True)
class AtmosphereTable:
    """A description, evaluated, and its skies once they are solved."""

    request: TableRequest  #: what was asked for
    medium: Medium  #: the atmosphere
    report: MediumReport  #: what became of the species
    sun_zenith_deg: tuple[float, ...]  #: zenith angles of the sun, rising [deg]
    bins: tuple[int, int]  #: equal bins of zenith and azimuth
    sizes: Mapping[str, int]  #: texture sizes and numbers of points of the description
    #: radiance of a ground of 1 cd m-2, where the description has it [W m-2 sr-1 nm-1]; float64 (n_wl,)
    glow: np.ndarray | None
    methods: tuple[str, ...]  #: "order1" or "sos" of each sun
    skies: tuple[AtmosphereSky, ...] = ()  #: of each sun; empty before the solution
    seconds: float = 0.0  #: time of the solution [s]


def prepare_table(request: TableRequest) -> AtmosphereTable:
    """Read and check everything, solve nothing: a table without skies.

    UsageError for suns that the method is not good for, all of them named, and for a table too large; SceneError in
    deep night.
    """
    description = read_atmo(request.path, allow_paths=request.allow_paths)
    medium, report = read_medium(description, request.wavelength_nm)
    if request.wavelength_nm is not None:
        warn_of_outside(description, request.wavelength_nm)
    suns = suns_of(description.sizes) if request.sun_zenith_deg is None else request.sun_zenith_deg
    rows, columns = description.sizes.get(ZENITH_ROWS), description.sizes.get(AZIMUTH_COLUMNS, DEFAULT_BINS[1])
    rows = DEFAULT_BINS[0] if rows is None else max(rows // 2, 1)
    bins = request.bins or (min(rows, MOST_BINS), min(columns, MOST_BINS))
    glow = None if description.ground_glow is None else description.ground_glow[report.wavelength_index]
    lights = [_chosen(request, medium, report, degrees) for degrees in suns]
    refused = [
        (degrees, outcome) for degrees, outcome in zip(suns, lights, strict=True) if isinstance(outcome, UsageError)
    ]
    if refused:
        named = ", ".join(f"{degrees:g}" for degrees, _ in refused)
        raise UsageError(f"--sun-zenith {named}: {refused[0][1]}")
    chosen = [outcome for outcome in lights if isinstance(outcome, Lights)]
    methods = [outcome.method for outcome in chosen]
    check_saves(request.saves, wavelength_nm=medium.wavelength_nm, methods=methods, glow=glow)
    _check_size(request, medium, chosen, bins)
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


def _chosen(request: TableRequest, medium: Medium, report: MediumReport, sun_zenith_deg: float) -> Lights | UsageError:
    """What lights the air under one sun, and how it is solved; or why not."""
    try:
        return chosen_lights(
            medium,
            float(np.deg2rad(sun_zenith_deg)),
            method=request.method,
            n_orders=request.n_orders,
            n_paths=request.n_paths,
            **_lights_of(request, medium, report, sun_zenith_deg),
        )
    except UsageError as error:
        return error


def _lights_of(request: TableRequest, medium: Medium, report: MediumReport, sun_zenith_deg: float) -> dict[str, Any]:
    """The arguments of `AtmosphereSky` for an eclipse and a glowing ground."""
    return {
        "moon": moon_of_direction(request.moon, medium, report, sun_zenith_deg, request.sun_azimuth_deg),
        "ground_radiance": glow_of_luminance(request.ground_luminance_cd_m2, report, request.path),
    }


def _check_size(request: TableRequest, medium: Medium, chosen: Sequence[Lights], bins: tuple[int, int]) -> None:
    """Refuse a table that would not fit into the memory of a small machine."""
    n_places = bins[0] * bins[1] + (MOST_SOURCES if request.saves.source else 0)
    n_values = sum(min(lights.n_orders, 8) for lights in chosen) * medium.wavelength_nm.size * n_places
    if n_values > _MOST_VALUES:
        raise UsageError(
            f"the table would hold {n_values:.3g} radiances, {_MOST_VALUES:g} is the most; ask for fewer suns, "
            "wavelengths or bins"
        )


def solve_table(table: AtmosphereTable, *, progress: Callable[[int, int], None] | None = None) -> AtmosphereTable:
    """Solve a table of `prepare_table` for every sun; `progress` gets the number of skies that are done, and of all."""
    started, skies = time.perf_counter(), []
    for degrees in table.sun_zenith_deg:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelLimitWarning)  # `prepare_table` has warned of low suns
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
        **_lights_of(request, table.medium, table.report, sun_zenith_deg),
    )


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
        write_netcdf(table, folder / NETCDF_NAME)
        written["netcdf"] = str(folder / NETCDF_NAME)
    write_bytes_atomically(folder / DESCRIPTION_NAME, read_bytes(table.request.path))
    written["description"] = str(folder / DESCRIPTION_NAME)
    write_atomically(str(folder / REPORT_NAME), json.dumps(table_report(table), indent=1, allow_nan=False) + "\n")
    written["report"] = str(folder / REPORT_NAME)
    return written


def write_netcdf(table: AtmosphereTable, path: Path) -> None:
    """Write what was solved as one netCDF file, atomically; `[sky] table` of sky.toml reads that of one sun."""
    request = table.request
    write_atmosphere_netcdf(
        table.skies,
        path,
        description=request.path,
        saves=request.saves,
        glow=table.glow,
        n_glow_rows=max(table.sizes.get(GLOW_ROWS, 2 * _GLOW_ROWS) // 2, 1),
        significand_bits=request.significand_bits,
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
        "phase_norm_error": {name: rows.tolist() for name, rows in report.phase_norm_error.items()},
        "dropped": list(report.dropped),
        "ground_albedo": medium.ground_albedo.tolist(),
        "sun_angular_radius_deg": float(np.rad2deg(medium.sun_angular_radius_rad)),
        "bins": list(table.bins),
        "sizes": dict(sorted(table.sizes.items())),
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
