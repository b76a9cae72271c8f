"""Sun and sky from a time and a place, or from an hour of a weather file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import InputWarning, SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import COEFFICIENT_NAMES
from aomc_sky.formats.sky_toml.sections import PerezSection, SunSection
from aomc_sky.options import AMOUNTS, MOMENT, WEATHER_FILES, listed, say
from aomc_sky.skies.perez.irradiances import EXTRATERRESTRIAL_NORMAL

if TYPE_CHECKING:
    from aomc_sky.formats.weather import WeatherTable
    from aomc_sky.source.light.sun_position import SunPosition

_PLACE = ("latitude_deg", "longitude_deg")

ANGLE_DECIMALS = 9
"""Decimals of the sun's angles in degrees, so that the last bit of a library's sine does not change the run."""
IRRADIANCE_DECIMALS = 6


@dataclass(frozen=True, kw_only=True, slots=True)
class Moment:
    """The sun of one moment, and the irradiances of its hour where a file has them."""

    sun_zenith_deg: float  #: as it is seen, with refraction [0 to 180]
    true_zenith_deg: float  #: without refraction, for rays that are straight [0 to 180]
    sun_azimuth_deg: float  #: from +x (east) towards +y (north) [0 to 360)
    extraterrestrial_normal: float  #: on a plane that faces the sun outside the atmosphere [W m-2]
    origin: str  #: who says so, for notes and messages
    source: dict[str, Any]  #: the same as JSON values
    irradiances: dict[str, float] = field(default_factory=dict)  #: dni and dhi of the hour of a file [W m-2]
    path: str | None = None  #: of the weather file
    names: tuple[str, ...] = ()  #: the inputs of `MOMENT` that were given

    @property
    def sun(self) -> SunSection:
        """Where the sun is."""
        return SunSection(zenith_deg=self.sun_zenith_deg, azimuth_deg=self.sun_azimuth_deg, origin=self.origin)

    @property
    def perez(self) -> PerezSection:
        """The irradiances of the hour of a file."""
        return PerezSection(dni=self.irradiances.get("dni"), dhi=self.irradiances.get("dhi"), origin=self.origin)

    @property
    def where(self) -> str:
        """The line of the file."""
        return f"{self.path}:{self.source['line']}"

    @property
    def distance_factor(self) -> float:
        """Of the sun's irradiance at the Earth's mean distance."""
        return self.extraterrestrial_normal / EXTRATERRESTRIAL_NORMAL

    def require_sun(self) -> None:
        """Raise a SceneError for a sun below the horizon."""
        if self.sun_zenith_deg >= 90:
            below = self.sun_zenith_deg - 90
            raise SceneError(
                f"at {self.source['time']} the sun is {below:.2f} degrees below the horizon there",
                "take an hour of the "
                "day, and see that latitude is north, longitude east, and the time in the zone that it names",
            )


def moment_of(given: Mapping[str, Any], perez: Mapping[str, Any], sun: Mapping[str, Any]) -> Moment | None:
    """The moment of a caller who says it by keys of `MOMENT`; None without a time and a weather file.

    Two answers to one question are refused: angles of the `sun`, and beside a file amounts of the `perez` sky.
    """
    for name in given:
        if name not in MOMENT:
            raise UsageError(f"weather has no input {name!r}; the inputs are {', '.join(MOMENT)}")
    others = [name for name in ("zenith_deg", "azimuth_deg") if name in sun]
    place, kinds = ([name for name in names if name in given] for names in (_PLACE, WEATHER_FILES))
    if len(kinds) > 1:
        raise UsageError(f"{listed(kinds)}: take one weather file")
    if kinds:
        others += [name for name in AMOUNTS if name in perez]
        others += ["coefficients"] * any(name in perez for name in COEFFICIENT_NAMES)
        others += [name for name in ("time", *_PLACE, "altitude_m") if name in given]
        if others:
            raise UsageError(f"{listed(others[:1])} contradicts {listed(kinds)}, which gives the sun and the sky")
        if "row" not in given:
            raise UsageError(f"{listed(kinds)} needs {say('{row:N}')}, one hour of the file, from 1")
        return _moment_of_row(given[kinds[0]], kinds[0].removeprefix("weather"), given["row"], (kinds[0], "row"))
    if "row" in given:
        raise UsageError(say("{row} needs {weather:FILE}"))
    if "time" not in given:
        if place:
            raise UsageError(f"{listed(place[:1])} needs {say('{time}')}")
        return None
    if others:
        raise UsageError(say("{time} says where the sun is; leave out {zenith_deg} and {azimuth_deg}"))
    if not {"latitude_deg", "longitude_deg"} <= set(given):
        raise UsageError(say("{time} needs {latitude_deg} and {longitude_deg}"))
    return _moment_of_time(**given, names=tuple(given))


def _moment_of_time(time: Any, *, names: tuple[str, ...], **place: float) -> Moment:
    from aomc_sky.source.light.sun_position import utc

    return moments_of_times(np.atleast_1d(utc(time)), **place, names=names)[0]


def moments_of_times(
    times: np.ndarray, latitude_deg: float, longitude_deg: float, altitude_m: float = 0.0, *, names: tuple[str, ...]
) -> list[Moment]:
    """The sun of a place at times in UTC, datetime64[s] (n,); `names` are the inputs that say so."""
    from aomc_sky.source.light.sun_position import SunPosition, sun_position

    if not times.size:
        return []
    found = sun_position(times, latitude_deg, longitude_deg, altitude_m)
    latitude_deg, longitude_deg, altitude_m = float(latitude_deg), float(longitude_deg), float(altitude_m)
    place = f"latitude {latitude_deg:g}, longitude {longitude_deg:g}"
    source = {"latitude_deg": latitude_deg, "longitude_deg": longitude_deg}
    if altitude_m:
        source["altitude_m"], place = altitude_m, f"{place}, altitude {altitude_m:g} m"
    moments = []
    for k, text in enumerate(np.datetime_as_string(times, timezone="UTC").tolist()):
        position = SunPosition(**{one.name: getattr(found, one.name)[k] for one in fields(found)})
        moments.append(_moment(position, f"{text}, {place}", {"time": text, **source}, names=names))
    return moments


def _moment(position: SunPosition[float], origin: str, source: dict[str, Any], **others: Any) -> Moment:
    angles = ("apparent_zenith_deg", "zenith_deg", "azimuth_deg")
    seen, true, azimuth = (round(float(getattr(position, name)), ANGLE_DECIMALS) for name in angles)
    return Moment(
        sun_zenith_deg=seen,
        true_zenith_deg=true,
        sun_azimuth_deg=azimuth % 360.0,
        extraterrestrial_normal=round(float(position.extraterrestrial_normal), IRRADIANCE_DECIMALS),
        origin=origin,
        source={**source, "true_zenith_deg": true},
        **others,
    )


def _moment_of_row(path: str | Path, kind: str, row: int, names: tuple[str, ...]) -> Moment:
    """One hour of a file, its sun at the middle; the row counts from 1."""
    from aomc_sky.formats.weather import HOUR, read_weather
    from aomc_sky.source.light.sun_position import sun_position
    from aomc_sky.whole_number import as_index

    k = as_index(row, "a row") - 1
    table = read_weather(path, kind, row=k)
    if not 0 <= k < table.line.size:
        word = say(f"{{row:{k + 1}}}")
        raise UsageError(f"{word} does not exist; {table.path} has rows 1 to {table.line.size}")
    where = f"{table.path}:{table.line[k]}"
    position = sun_position(table.midpoint[k], table.latitude_deg, table.longitude_deg)
    if float(position.apparent_zenith_deg) >= 90:
        below = float(position.apparent_zenith_deg) - 90
        word = say(f"{{row:{k + 1}}}")
        night = f"the sun is {below:.2f} degrees below the horizon at the middle of that hour"
        raise SceneError(f"{where}: {word}: {night}{_day_near(table, k)}")
    source = {
        "weather": table.path,
        "line": int(table.line[k]),
        "row": k + 1,
        "place": table.station,
        "latitude_deg": table.latitude_deg,
        "longitude_deg": table.longitude_deg,
        "hour": [str(np.datetime_as_string(t, timezone="UTC")) for t in (table.start[k], table.start[k] + HOUR)],
        "sun_at": str(np.datetime_as_string(table.midpoint[k], timezone="UTC")),
    }
    moment = _moment(position, f"{Path(table.path).name}, row {k + 1}", source, path=table.path, names=names)
    dni, dhi = hour_irradiances(table, k, moment.sun_zenith_deg, moment.extraterrestrial_normal)
    moment.irradiances.update(dni=dni, dhi=dhi)
    return moment


def _day_near(table: WeatherTable, k: int) -> str:
    """The row nearest to a night's that has a sun and light, as advice."""
    from aomc_sky.source.light.sun_position import sun_position

    rows = np.arange(max(k - 24, 0), min(k + 25, table.line.size))
    light = np.stack([table.ghi, table.dni, table.dhi])[:, rows]
    rows = rows[~np.isnat(table.start[rows]) & (np.isfinite(light).sum(axis=0) >= 2) & (light > 0).any(axis=0)]
    zenith = sun_position(table.midpoint[rows], table.latitude_deg, table.longitude_deg).apparent_zenith_deg
    days = rows[zenith < 90]
    return "" if days.size == 0 else f"; the nearest row with light is {int(days[np.argmin(np.abs(days - k))]) + 1}"


def hour_irradiances(
    table: WeatherTable, index: int, sun_zenith_deg: float, extraterrestrial_normal: float
) -> tuple[float, float]:
    """DNI and DHI of an hour, one of them from GHI if the file lacks it; a SceneError without two of them. [W m-2]

    The sky is made from DNI and DHI as they are. A warning says if the GHI of the hour is not their sum: the sun moves
    during an hour, and means need not fit one position.
    """
    from aomc_sky.skies.perez.irradiances import closed_irradiances

    where = f"{table.path}:{table.line[index]}"
    given = table.irradiances(index)
    if len(given) < 2:
        has = "none" if not given else f"only {next(iter(given)).upper()}"
        raise SceneError(f"{where}: row {index + 1} has {has} of GHI, DNI and DHI; two of them make a sky")
    sun = {"sun_zenith_deg": sun_zenith_deg, "extraterrestrial_normal": extraterrestrial_normal}
    try:
        used = {name: given[name] for name in ("dni", "dhi")} if len(given) == 3 else given
        dni, dhi = closed_irradiances(**used, **sun)
    except SceneError as error:
        raise SceneError(f"{where}: {error}") from None
    try:
        closed_irradiances(**given, **sun)
    except SceneError as error:
        warnings.warn(f"{where}: {error} (here DNI and DHI of the hour are used)", InputWarning, stacklevel=2)
    return dni, dhi
