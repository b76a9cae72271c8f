"""The hours of a weather file as scenes to come: what every hour needs, settled before the first one."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import Component, scaled
from aomc_sky.errors import AomcSkyError, SceneError, UsageError
from aomc_sky.formats.weather import WeatherTable
from aomc_sky.grid import PatchGrid
from aomc_sky.sampling.allocation import MAX_PHOTONS
from aomc_sky.sampling.streams import MAX_SEED, STREAM_VERSION, checked_seed, stream_key
from aomc_sky.source.light.sun_position import sun_position
from aomc_sky.source.light.weather import ANGLE_DECIMALS, IRRADIANCE_DECIMALS, hour_irradiances
from aomc_sky.source.plan.laws import Arrays, PlanRuleError, naming, shown
from aomc_sky.source.plan.plan import Plan, member_names, read_plan_file
from aomc_sky.source.plan.schema import (
    LARGE,
    Member,
    Rules,
    check_each,
    check_range,
    check_shape,
    check_stream,
    is_whole,
)

if TYPE_CHECKING:
    from aomc_sky.skies.perez.sky import PerezSky

SCHEMA = "aomc-sky-year/1"

MAX_CELLS = 2**27
"""Patches of an hour: as many as a table may have."""


class HourState(enum.IntEnum):
    """What an hour holds; the number is part of a year's plan.npz and never changes."""

    SKY = 0
    NIGHT = 1
    NO_DIFFUSE = 2
    MISSING = 3


MEMBERS = {
    "line": Member(dtype="<i8", shape=("n_row",), low=1, high=2**31),
    "start_s": Member(dtype="<i8", shape=("n_row",), low=-(2**62), high=2**62),
    "sun_zenith_deg": Member(dtype="<f8", shape=("n_row",), low=0.0, high=180.0),
    "sun_azimuth_deg": Member(dtype="<f8", shape=("n_row",), low=-360.0, high=720.0),
    "extraterrestrial_normal": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE),
    "dni": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE, may_be_nan=True),
    "dhi": Member(dtype="<f8", shape=("n_row",), low=0.0, high=LARGE, may_be_nan=True),
    "state": Member(dtype="|i1", shape=("n_row",), low=min(HourState), high=max(HourState)),
}
"""All arrays of the plan of a year; NaN is a value that the weather file does not have."""


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 80 and value.isprintable()


def _are_bins(value: Any) -> bool:
    is_pair = isinstance(value, list) and len(value) == 2 and all(map(is_whole(1, MAX_CELLS), value))
    return is_pair and value[0] * value[1] <= MAX_CELLS


def _is_site(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(type(x) in (int, float) and abs(x) <= 360 for x in value)


OPTIONS: Rules = {
    "schema": (lambda value: value == SCHEMA, SCHEMA),
    "stream": (lambda value: isinstance(value, str), "the version of the random streams"),
    "seed": (is_whole(0, MAX_SEED), "a whole number from 0 to 2^64 - 1"),
    "iterations": (is_whole(1, 2**62), "a whole number from 1 to 2^62"),
    "bins": (_are_bins, f"two whole numbers of bins, at most {MAX_CELLS} patches"),
    "limits": (_is_text, "a name"),
    "air_mass": (_is_text, "a name"),
    "with_beam": (lambda value: type(value) is bool, "true or false"),
    "site": (_is_site, "latitude, longitude and hours from UTC"),
}


def check_year(arrays: Arrays, options: Mapping[str, Any]) -> None:
    """Raise E952 to E955 unless these are the arrays and options of a year."""
    for name in [*MEMBERS, *arrays]:
        if name not in arrays:
            raise PlanRuleError("E952", name, "this array is missing; it belongs to the plan of a year of skies")
        if name not in MEMBERS:
            raise PlanRuleError("E952", shown(name), "is not an array of the plan of a year of skies")
    check_stream(options)
    check_each(options, OPTIONS)
    lengths: dict[str, int] = {}
    for name, member in MEMBERS.items():
        check_shape(name, arrays[name], member, lengths)
        check_range(name, arrays[name], member)


@dataclass(frozen=True, kw_only=True, slots=True)
class YearPlan:
    """The settled part of a year of skies."""

    #: (n_row,) each: `line` of the weather file, `start_s` of the hour (Unix time), `state`, and at the middle of the
    #: hour `sun_zenith_deg` (with refraction), `sun_azimuth_deg`, `extraterrestrial_normal`, `dni`, `dhi` [W m-2]
    arrays: dict[str, np.ndarray]
    #: `schema`, `stream`, `seed`, `iterations`, `bins`, `limits`, `air_mass`, `with_beam`, the site: JSON values
    options: dict[str, Any]

    @property
    def n_rows(self) -> int:
        """Number of hours, those without a sky among them."""
        return int(self.arrays["state"].size)

    @property
    def sky_rows(self) -> np.ndarray:
        """Rows that have a sky, in order; the k-th row of counts belongs to the k-th of them. [0-based]"""
        return np.flatnonzero(self.arrays["state"] == HourState.SKY)

    @property
    def iterations(self) -> int:
        """Photons of every hour that has a sky."""
        return int(self.options["iterations"])

    @property
    def with_beam(self) -> bool:
        """Whether the first cell is the direct beam."""
        return bool(self.options["with_beam"])

    @property
    def grid(self) -> PatchGrid:
        """The patches of every hour."""
        return PatchGrid.regular(*self.options["bins"])

    @property
    def n_cells(self) -> int:
        """Cells of every hour: the beam where there is one, then the patches, zenith-major."""
        n_zenith, n_azimuth = self.options["bins"]
        return int(n_zenith * n_azimuth) + self.with_beam

    @property
    def sha256(self) -> str:
        """Name of the year: a hash of all arrays and options."""
        return Plan(arrays=self.arrays, options=self.options).sha256

    def to_bytes(self) -> bytes:
        """The plan as the bytes of an npz file; equal plans give equal bytes."""
        return Plan(arrays=self.arrays, options=self.options).to_bytes()

    @classmethod
    def load(cls, path: str | Path) -> YearPlan:
        """Read the plan of a year; E951 to E955: the file is missing, damaged, or the plan of something else."""
        arrays, options = read_plan_file(path)
        with naming(str(path)):
            check_year(arrays, options)
        return cls(arrays=arrays, options=options)

    def hour_seed(self, row: int) -> int:
        """Seed of one hour, so that no two hours share random numbers. [0 to 2^64 - 1]"""
        return stream_key(int(self.options["seed"]), f"hour {row + 1}")

    def direct_fraction(self, row: int) -> float:
        """Share of the direct beam in the photons of an hour, DNI cos Z / (DNI cos Z + DHI); 0 without a beam."""
        if not self.with_beam:
            return 0.0
        direct = self.arrays["dni"][row] * np.cos(np.deg2rad(self.arrays["sun_zenith_deg"][row]))
        return float(direct / (direct + self.arrays["dhi"][row]))

    def sky(self, row: int, grid: PatchGrid | None = None) -> PerezSky:
        """The sky of one row; a SceneError where it has none. [0-based]"""
        from aomc_sky.skies.perez.sky import PerezSky

        arrays = self.arrays
        state = HourState(int(arrays["state"][row]))
        if state is not HourState.SKY:
            raise SceneError(f"row {row + 1} of the weather file has no sky to sample: {state_text(state)}")
        return PerezSky(
            sun_zenith_rad=float(np.deg2rad(arrays["sun_zenith_deg"][row])),
            sun_azimuth_rad=float(np.deg2rad(arrays["sun_azimuth_deg"][row])),
            dni=float(arrays["dni"][row]),
            dhi=float(arrays["dhi"][row]),
            limits=self.options["limits"],
            extraterrestrial_normal=float(arrays["extraterrestrial_normal"][row]),
            air_mass=self.options["air_mass"],
            grid=grid,
        )

    def components(self, row: int, grid: PatchGrid, wavelength_nm: np.ndarray) -> tuple[Component, ...]:
        """What shines in one hour, the beam first where there is one."""
        sky: tuple[Component, ...] = self.sky(row, grid).lower(wavelength_nm)
        fraction = self.direct_fraction(row)
        if not self.with_beam:
            return sky
        from aomc_sky.skies.direct_beam import DirectBeam

        zenith, azimuth = (float(self.arrays[name][row]) for name in ("sun_zenith_deg", "sun_azimuth_deg"))
        beam = DirectBeam(sun_zenith_deg=zenith, sun_azimuth_deg=azimuth).lower(wavelength_nm)
        return (
            *scaled(beam, fraction),
            *scaled(sky, 1 - fraction),
        )


def is_year_plan(path: str | Path) -> bool:
    """Whether a plan.npz is that of a year, by the names of its arrays; False where it cannot be read."""
    try:
        return "start_s" in member_names(path)
    except AomcSkyError:
        return False


def state_text(state: HourState) -> str:
    """A state as it stands in index.csv."""
    return state.name.lower().replace("_", "-")


def plan_year(
    table: WeatherTable,
    *,
    iterations: int,
    seed: int = 0,
    bins: tuple[int, int] = (45, 180),
    limits: str = "radiance",
    air_mass: str = "kasten-young-1989",
    with_beam: bool = False,
) -> YearPlan:
    """Settle a year: the sun of every hour, and which hours have a sky; `iterations` photons of each that has one.

    The sun is where it is seen: the beam, DNI cos Z and the air mass have its apparent zenith angle. An hour is night
    when the sun's centre is seen below the horizon at its middle. DNI or DHI that a row lacks follows from its GHI;
    where it cannot, the hour is missing. Angles are rounded to 1e-9 degrees, so that the last
    bit of a library's sine is not another year. `with_beam`: the photons of an hour are shared out over beam (DNI cos
    Z) and sky (DHI).
    """
    if not 1 <= iterations <= MAX_PHOTONS:
        raise UsageError(f"iterations must lie within 1 and 2^62, got {iterations}")
    sun = sun_position(table.midpoint, table.latitude_deg, table.longitude_deg)
    zenith = np.round(sun.apparent_zenith_deg, ANGLE_DECIMALS)
    state = np.full(table.n_rows, int(HourState.SKY), dtype=np.int8)
    state[table.dhi <= 0] = HourState.NO_DIFFUSE
    state[table.is_missing] = HourState.MISSING
    state[zenith >= 90] = HourState.NIGHT
    extraterrestrial = np.round(sun.extraterrestrial_normal, IRRADIANCE_DECIMALS)
    dni, dhi = table.dni.copy(), table.dhi.copy()
    for row in np.flatnonzero(table.is_missing & (table.missing.sum(axis=0) == 1) & (state != HourState.NIGHT)):
        try:
            dni[row], dhi[row] = hour_irradiances(table, int(row), float(zenith[row]), float(extraterrestrial[row]))
            state[row] = HourState.SKY if dhi[row] > 0 else HourState.NO_DIFFUSE
        except SceneError:
            state[row] = HourState.MISSING
    arrays = {
        "line": table.line,
        "start_s": table.start.astype(np.int64),
        "sun_zenith_deg": zenith,
        "sun_azimuth_deg": np.round(sun.azimuth_deg, ANGLE_DECIMALS),
        "extraterrestrial_normal": extraterrestrial,
        "dni": dni,
        "dhi": dhi,
        "state": state,
    }
    options = {
        "schema": SCHEMA,
        "stream": STREAM_VERSION,
        "seed": checked_seed(seed),
        "iterations": int(iterations),
        "bins": [int(n) for n in bins],
        "limits": limits,
        "air_mass": air_mass,
        "with_beam": bool(with_beam),
        "site": [table.latitude_deg, table.longitude_deg, table.utc_offset_h],
    }
    return YearPlan(
        arrays=_frozen({name: np.ascontiguousarray(array) for name, array in arrays.items()}), options=options
    )


def _frozen(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    for array in arrays.values():
        array.flags.writeable = False
    return arrays
