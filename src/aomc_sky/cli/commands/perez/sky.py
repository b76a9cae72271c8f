"""Which sky the options of ``aomc-sky perez`` describe."""

from __future__ import annotations

import argparse
import datetime
import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky
from aomc_sky.source.light.sun_position import SOLAR_CONSTANT, sun_position

_SUN_OPTIONS = ("sun_zenith", "sun_azimuth", "time", "latitude", "longitude")
_SKY_OPTIONS = ("dni", "dhi", "ghi", "epsilon", "delta", "coefficients")


@dataclass(frozen=True, kw_only=True, slots=True)
class FoundSky:
    """A sky, what it came from, and the masses of its patches."""

    sky: PerezSky
    sun_zenith_deg: float  #: as it is seen, with refraction
    sun_azimuth_deg: float  #: from +x towards +y
    dni: float | None  #: where it is known [W m-2]
    dhi: float | None  #: where it is known [W m-2]
    extraterrestrial_normal: float  #: what Delta was computed with [W m-2]
    source: dict[str, Any]  #: where sun and irradiances came from: JSON values
    mass: np.ndarray  #: (n_patch,)
    warnings: tuple[str, ...]  #: what the model had to limit


def resolve(arguments: argparse.Namespace, kind: str | None) -> FoundSky:
    """Find the sky, and say in warnings what its model had to limit."""
    if kind is not None:
        sun, inputs, source = _from_weather(arguments, kind)
    else:
        if arguments.row is not None:
            raise UsageError("--row needs a weather file: --epw, --tmy2 or --tmy3")
        sun, source = _sun(arguments)
        inputs = _inputs(arguments, sun[0])
    extraterrestrial = sun[2] if arguments.extraterrestrial is None else arguments.extraterrestrial
    if not extraterrestrial > 0:
        raise UsageError(f"--extraterrestrial must be positive, got {extraterrestrial:g}")
    return _modelled(arguments, sun, inputs, extraterrestrial, source)


def _modelled(
    arguments: argparse.Namespace,
    sun: tuple[float, float, float],
    inputs: dict[str, Any],
    extraterrestrial: float,
    source: dict[str, Any],
) -> FoundSky:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = PerezSky(
            sun_zenith_rad=math.radians(sun[0]),
            sun_azimuth_rad=math.radians(sun[1]),
            limits=arguments.limits,
            air_mass=arguments.air_mass,
            extraterrestrial_normal=extraterrestrial,
            **inputs,
        )
        mass = sky.patch_mass(PatchGrid.regular(*arguments.bins))
    texts = tuple(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)))
    for text in texts:
        warnings.warn(text, ModelLimitWarning, stacklevel=2)
    return FoundSky(
        sky=sky,
        sun_zenith_deg=sun[0],
        sun_azimuth_deg=sun[1],
        dni=inputs.get("dni"),
        dhi=inputs.get("dhi"),
        extraterrestrial_normal=extraterrestrial,
        source=source,
        mass=mass,
        warnings=texts,
    )


def _from_weather(
    arguments: argparse.Namespace, kind: str
) -> tuple[tuple[float, float, float], dict[str, Any], dict[str, Any]]:
    """Sun, inputs and origin of one row of a weather file."""
    from aomc_sky.formats.weather import read_weather

    refuse_given(arguments, (*_SUN_OPTIONS, *_SKY_OPTIONS), f"--{kind}")
    if arguments.row is None:
        raise UsageError(f"--{kind} needs --row N (one hour) or --every hour (all of them, into --out)")
    table = read_weather(getattr(arguments, kind), kind)
    if not 1 <= arguments.row <= table.n_rows:
        raise UsageError(f"--row {arguments.row} does not exist; {table.path} has rows 1 to {table.n_rows}")
    k = arguments.row - 1
    where = f"{table.path}:{table.line[k]}"
    if table.is_missing[k]:
        raise SceneError(f"{where}: row {arguments.row} has no DNI or no DHI")
    found = sun_position(table.midpoint[k], table.latitude_deg, table.longitude_deg)
    zenith, dni, dhi = float(found.apparent_zenith_deg), float(table.dni[k]), float(table.dhi[k])
    if zenith >= 90:
        raise SceneError(
            f"{where}: the sun stands {zenith - 90:.2f} degrees below the horizon at the middle of the hour"
        )
    if dhi == 0:
        raise SceneError(f"{where}: DHI is 0, so there is no light in the sky")
    source = {
        "weather": table.path,
        "line": int(table.line[k]),
        "row": arguments.row,
        "place": table.station,
        "latitude_deg": table.latitude_deg,
        "longitude_deg": table.longitude_deg,
        "hour": [str(np.datetime_as_string(t, timezone="UTC")) for t in (table.start[k], table.end[k])],
        "sun_at": str(np.datetime_as_string(table.midpoint[k], timezone="UTC")),
        "true_zenith_deg": float(found.zenith_deg),
    }
    sun = (zenith, float(found.azimuth_deg), float(found.extraterrestrial_normal))
    return sun, {"dni": dni, "dhi": dhi}, source


def refuse_given(arguments: argparse.Namespace, names: tuple[str, ...], because: str) -> None:
    """Raise for the first option that is given beside one that already says it."""
    for name in names:
        if getattr(arguments, name) is not None:
            raise UsageError(f"--{name.replace('_', '-')} contradicts {because}, which says the sun and the sky")


def _sun(arguments: argparse.Namespace) -> tuple[tuple[float, float, float], dict[str, Any]]:
    """Zenith angle, azimuth and extraterrestrial irradiance, and where they came from."""
    place = [name for name in ("latitude", "longitude") if getattr(arguments, name) is not None]
    if arguments.time is None:
        if place:
            raise UsageError(f"--{place[0]} needs --time")
        if arguments.sun_zenith is None:
            raise UsageError("where is the sun? write --sun-zenith, or --time, --latitude and --longitude")
        if not 0 <= arguments.sun_zenith < 90:
            raise SceneError(
                f"a sky needs the sun above the horizon, 0 to below 90 degrees, got {arguments.sun_zenith:g}"
            )
        return (arguments.sun_zenith, (arguments.sun_azimuth or 0.0) % 360.0, SOLAR_CONSTANT), {}
    if arguments.sun_zenith is not None or arguments.sun_azimuth is not None:
        raise UsageError("--time says where the sun is; leave out --sun-zenith and --sun-azimuth")
    if len(place) < 2:
        raise UsageError("--time needs --latitude and --longitude")
    time = _utc(arguments.time)
    found = sun_position(time, arguments.latitude, arguments.longitude)
    zenith = float(found.apparent_zenith_deg)
    if zenith >= 90:
        raise SceneError(f"at {arguments.time} the sun stands {zenith - 90:.2f} degrees below the horizon there")
    source = {
        "time": str(np.datetime_as_string(time, timezone="UTC")),
        "latitude_deg": arguments.latitude,
        "longitude_deg": arguments.longitude,
        "true_zenith_deg": float(found.zenith_deg),
    }
    return (zenith, float(found.azimuth_deg), float(found.extraterrestrial_normal)), source


def _utc(text: str) -> np.datetime64:
    """A time with its offset, in UTC."""
    try:
        time = datetime.datetime.fromisoformat(text)
    except ValueError:
        raise UsageError(f"--time wants ISO 8601, for example 2026-06-21T09:30:00Z, got {text!r}") from None
    if time.tzinfo is None:
        raise UsageError(
            f"--time {text} does not say its time zone; write {text}Z for UTC, or an offset such as +02:00"
        )
    try:
        return np.datetime64(time.astimezone(datetime.UTC).replace(tzinfo=None), "s")
    except OverflowError:
        raise UsageError(f"--time {text} lies outside the years 1 to 9999 in UTC") from None


def _inputs(arguments: argparse.Namespace, sun_zenith_deg: float) -> dict[str, Any]:
    """Arguments of `PerezSky` from the options of the sky."""
    from aomc_sky.formats.sky_toml.keys import COEFFICIENT_NAMES
    from aomc_sky.source.light.inputs import given_inputs

    given = {name: getattr(arguments, name) for name in _SKY_OPTIONS if name != "coefficients"}
    if arguments.coefficients is not None:
        given.update(zip(COEFFICIENT_NAMES, arguments.coefficients, strict=True))
    section = given_inputs(given, None, None).perez
    if section.coefficients is not None:
        return {"coefficients": section.coefficients}
    if section.epsilon is not None:
        return {"epsilon": section.epsilon, "delta": section.delta}
    if section.dni is None:
        raise UsageError(
            "which sky? write --dni and --dhi, --ghi and --dni, --epsilon and --delta, or --coefficients a b c d e"
        )
    dhi = section.dhi
    if dhi is None:
        assert section.ghi is not None  # one of the complete sets
        from aomc_sky.skies.perez.functions import diffuse_from_global

        dhi = float(diffuse_from_global(section.ghi, section.dni, math.radians(sun_zenith_deg)))
    if dhi == 0:
        raise SceneError("the diffuse irradiance is 0, so there is no light in the sky")
    return {"dni": section.dni, "dhi": dhi}
