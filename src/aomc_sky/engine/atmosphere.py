"""One atmosphere under several suns: checked, solved, and written as tables with a report."""

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
from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.formats.sky_toml.sections import MoonDirection
from aomc_sky.formats.text_file import read_bytes, write_atomically, write_bytes_atomically
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.run_folder import create_folder
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

_MOST_VALUES = 500_000_000
"""Radiances of one table; more would not fit into the memory of a small machine."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TableRequest:
    """The contents of a table of an atmosphere; where None is allowed, the description decides."""

    path: str  #: the description
    sun_zenith_deg: tuple[float, ...] | None  #: rising; by default evenly from 0 to 90 [deg, 0 to 108]
    sun_azimuth_deg: float = 0.0  #: from +x towards +y [deg]
    wavelength_nm: tuple[float, ...] | None = None  #: each the nearest of the description; by default all [nm]
    method: str = "auto"  #: as `aomc_sky.skies.atmosphere.sky.method.chosen_method` has it
    n_orders: int | None = None  #: most interactions that count
    n_paths: int | None = None  #: backward paths per direction and wavelength; `solve_sky` decides
    seed: int = 0  #: of the paths
    bins: tuple[int, int] | None = None  #: equal bins of zenith and azimuth, of the description or 45 and 180
    allow_paths: tuple[str, ...] = ()  #: more folders below which tables of the description may lie
    saves: Saves = field(default_factory=Saves)  #: what the netCDF file holds besides radiances and irradiances
    significand_bits: int | None = None  #: of float32 in the netCDF file, which else has float64 [1 to 24]
    moon: MoonDirection = field(default_factory=MoonDirection)  #: where the Moon hides part of the sun; empty: no Moon
    ground_luminance_cd_m2: float = 0.0  #: light that the ground emits [0 or more]


@dataclass(frozen=True, kw_only=True, slots=True)
class AtmosphereTable:
    """A description that was evaluated, and its skies once they are solved."""

    request: TableRequest
    medium: Medium
    report: MediumReport
    sun_zenith_deg: tuple[float, ...]  #: rising [deg]
    bins: tuple[int, int]  #: equal bins of zenith and azimuth
    sizes: Mapping[str, int]  #: texture sizes and numbers of points of the description
    glow: np.ndarray | None  #: radiance of a ground of 1 cd m-2, if described [W m-2 sr-1 nm-1]; float64 (n_wl,)
    methods: tuple[str, ...]  #: "order1" or "sos" for each sun
    skies: tuple[AtmosphereSky, ...] = ()  #: one for each sun; empty before the solution
    seconds: float = 0.0  #: time of the solution [s]


def prepare_table(request: TableRequest) -> AtmosphereTable:
    """Read and check everything, and solve nothing.

    UsageError names all suns that the method cannot solve, and refuses tables that are too large; SceneError in deep
    night.
    """
    description = read_atmo(request.path, allow_paths=request.allow_paths)
    medium, report = read_medium(description, request.wavelength_nm)
    sizes = description.sizes
    suns = _suns_of(sizes) if request.sun_zenith_deg is None else request.sun_zenith_deg
    rows = max(sizes[ZENITH_ROWS] // 2, 1) if ZENITH_ROWS in sizes else DEFAULT_BINS[0]
    columns = sizes.get(AZIMUTH_COLUMNS, DEFAULT_BINS[1])
    bins = request.bins or (min(rows, MOST_BINS), min(columns, MOST_BINS))
    glow = report.ground_glow
    lights: list[Lights] = []
    refused: list[tuple[float, UsageError]] = []
    for degrees in suns:
        try:
            how = _how(request, medium, report, degrees)
            lights.append(chosen_lights(medium, float(np.deg2rad(degrees)), **how))
        except UsageError as error:
            refused.append((degrees, error))
    if refused:
        named = ", ".join(f"{degrees:g}" for degrees, _ in refused)
        raise UsageError(f"--sun-zenith {named}: {refused[0][1]}")
    methods = [one.method for one in lights]
    check_saves(request.saves, methods=methods, glow=glow)
    n_directions = bins[0] * bins[1] + (MOST_SOURCES if request.saves.source else 0)
    n_values = sum(min(one.n_orders, 8) for one in lights) * medium.wavelength_nm.size * n_directions
    if n_values > _MOST_VALUES:
        raise UsageError(
            f"the table would hold {n_values:.3g} radiances, {_MOST_VALUES:g} is the most",
            "ask for fewer suns, wavelengths or bins",
        )
    return AtmosphereTable(
        request=request,
        medium=medium,
        report=report,
        sun_zenith_deg=suns,
        bins=bins,
        sizes=sizes,
        glow=glow,
        methods=tuple(methods),
    )


def _suns_of(sizes: Mapping[str, int]) -> tuple[float, ...]:
    """Zenith angles of as many suns as a description asks for, evenly from 0 to 90. [deg]"""
    if SUNS not in sizes:
        raise UsageError(f'--sun-zenith all: the description has no "{SUNS}"')
    if sizes[SUNS] > MOST_SUNS:
        raise UsageError(f'--sun-zenith all: "{SUNS}" is {sizes[SUNS]}, {MOST_SUNS} is the most')
    return tuple(round(float(sun), 10) for sun in np.linspace(0.0, 90.0, sizes[SUNS]))


def _how(request: TableRequest, medium: Medium, report: MediumReport, sun_zenith_deg: float) -> dict[str, Any]:
    """Arguments of `AtmosphereSky`: the method, an eclipse, and a glowing ground."""
    return {
        "method": request.method,
        "n_orders": request.n_orders,
        "n_paths": request.n_paths,
        "seed": request.seed,
        "moon": moon_of_direction(request.moon, medium, report, sun_zenith_deg, request.sun_azimuth_deg),
        "ground_radiance": glow_of_luminance(request.ground_luminance_cd_m2, report, request.path),
    }


def solve_table(table: AtmosphereTable, *, progress: Callable[[int, int], None] | None = None) -> AtmosphereTable:
    """Solve a table for every sun; `progress` is called with skies done and skies in all."""
    started, request = time.perf_counter(), table.request
    skies: list[AtmosphereSky] = []
    for degrees in table.sun_zenith_deg:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelLimitWarning)  # `prepare_table` has warned of low suns
            sky = AtmosphereSky(
                medium=table.medium,
                sun_zenith_deg=degrees,
                sun_azimuth_deg=request.sun_azimuth_deg,
                grid=PatchGrid.regular(*table.bins),
                **_how(request, table.medium, table.report, degrees),
            )
        skies.append(sky)
        if progress is not None:
            progress(len(skies), len(table.sun_zenith_deg))
    return dataclasses.replace(table, skies=tuple(skies), seconds=time.perf_counter() - started)


NETCDF_NAME = "atmosphere.nc"
REPORT_NAME = "report.json"
REPORT_HEAD = '{\n "description": '
"""The first characters of each report."""

SKYDIST_NAME = "skydist.inp"
DESCRIPTION_NAME = "params.atmo"


def write_table(table: AtmosphereTable, folder: Path, *, netcdf: bool = True) -> dict[str, str]:
    """Write the solved skies, each file complete or not at all, the report last; returns the path of each file by role.

    Roles are "netcdf", "report", "description" (a copy, as CalcMySky keeps one), and "skydist" for one sun,
    "skydist SUN" for several.
    """
    written: dict[str, Path] = {}
    create_folder(folder)
    for sky in table.skies:
        if np.any(sky.patch_mean > 0):
            name = f"sun_{sky.sun_zenith_deg:g}" if len(table.skies) > 1 else ""
            create_folder(folder / name)
            written[f"skydist {name}".strip()] = path = folder / name / SKYDIST_NAME
            write_atmosphere_skydist(sky, path)
    if netcdf:
        written["netcdf"] = folder / NETCDF_NAME
        write_netcdf(table, written["netcdf"])
    written |= {"description": folder / DESCRIPTION_NAME, "report": folder / REPORT_NAME}
    write_bytes_atomically(written["description"], read_bytes(table.request.path))
    write_atomically(written["report"], json.dumps(table_report(table), indent=1, allow_nan=False) + "\n")
    return {role: str(path) for role, path in written.items()}


def write_netcdf(table: AtmosphereTable, path: Path) -> None:
    """Write the solved skies as one netCDF file, atomically; `[sky] table` of sky.toml reads that of one sun."""
    write_atmosphere_netcdf(
        table.skies,
        path,
        description=table.request.path,
        saves=table.request.saves,
        glow=table.glow,
        n_glow_rows=max(table.sizes.get(GLOW_ROWS, 2 * _GLOW_ROWS) // 2, 1),
        significand_bits=table.request.significand_bits,
    )


def table_report(table: AtmosphereTable) -> dict[str, Any]:
    """The species of a table, and the irradiances and estimated errors of its suns, as JSON values."""
    report, medium = table.report, table.medium
    suns = zip(table.sun_zenith_deg, table.methods, strict=True)
    unsolved = [{"sun_zenith_deg": degrees, "method": method} for degrees, method in suns]
    return {
        "description": table.request.path,
        "version": aomc_sky.__version__,
        "wavelength_nm": medium.wavelength_nm.tolist(),
        "optical_depth": {name: rows.tolist() for name, rows in report.optical_depth.items()},
        "phase_norm": {name: rows.tolist() for name, rows in report.phase_norm.items()},
        "phase_norm_error": {name: rows.tolist() for name, rows in report.phase_norm_error.items()},
        "dropped": list(report.dropped),
        "notes": list(medium.texts),
        "ground_albedo": medium.ground_albedo.tolist(),
        "sun_angular_radius_deg": float(np.rad2deg(medium.sun_angular_radius_rad)),
        "bins": list(table.bins),
        "sizes": dict(sorted(table.sizes.items())),
        "suns": [_sun_report(sky) for sky in table.skies] or unsolved,
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
        **({"seed": sky.seed} if sky.seed else {}),
        "paths_error": solved.resolution_error if solved.n_paths else None,
        "visible_share": solved.visible_share,
        "direct_irradiance": sky.direct_irradiance.tolist(),
        "diffuse_irradiance": sky.diffuse_irradiance.tolist(),
        "truncation": None if solved.later_orders is None else solved.truncation.tolist(),
        "largest_relative_error": relative.max(axis=1).tolist(),
        "patch_change": sky.patch_change,
    }
