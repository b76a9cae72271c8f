"""One atmosphere under several suns: asked for, checked, then solved."""

from __future__ import annotations

import dataclasses
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from aomc_sky.atmosphere.medium import Medium
from aomc_sky.atmosphere.sky.method import Lights, chosen_lights
from aomc_sky.engine.atmosphere.keys import bins_of, suns_of
from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.formats.sky_toml.keys import MoonDirection
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.tables.atmosphere_saves import MOST_SOURCES, Saves, check_saves
from aomc_sky.skies.atmosphere import AtmosphereSky
from aomc_sky.source.atmospheres.medium import MediumReport, read_medium, warn_of_outside
from aomc_sky.source.atmospheres.night_lights import SkyLights, lights_of

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
    method: str = "auto"  #: as `aomc_sky.atmosphere.sky.method.chosen_method` has it
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
    bins = request.bins or bins_of(description.sizes)
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


def _lights_of(request: TableRequest, medium: Medium, report: MediumReport, sun_zenith_deg: float) -> SkyLights:
    return lights_of(
        request.moon,
        request.ground_luminance_cd_m2,
        medium,
        report,
        sun_zenith_deg,
        request.path,
        sun_azimuth_deg=request.sun_azimuth_deg,
    )


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
