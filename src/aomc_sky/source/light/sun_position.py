"""Position of the sun and its irradiance outside the atmosphere: pvlib's numbers in our conventions."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg
from aomc_sky.errors import AomcSkyError, UsageError, number, shown_value, unmasked
from aomc_sky.extras import optional_module
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.perez.irradiances import EXTRATERRESTRIAL_NORMAL

_AIR = {"altitude": 0.0, "pressure": 101_325.0, "temperature": 12.0}
_LOWEST_M, _HIGHEST_M = -500.0, 9000.0
_EARLIEST, _LATEST = np.datetime64("1800"), np.datetime64("2199")
_LEAP_SECOND = re.compile(r"(\d\d:\d\d):60(?!\d)")


Numbers = TypeVar("Numbers", float, np.ndarray)


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class SunPosition(Generic[Numbers]):
    """The sun at one place: numbers for one time, else arrays of the shape of the times."""

    zenith_deg: Numbers  #: true, without refraction [deg, 0 to 180]
    apparent_zenith_deg: Numbers  #: as seen: air of 101 325 Pa, 12 degrees C lifts the sun by 0.5 at the horizon
    azimuth_deg: Numbers  #: from +x (east) towards +y (north) [deg, 0 to 360)
    extraterrestrial_normal: Numbers  #: on a surface that faces the sun outside the atmosphere [W m-2]

    __eq__ = same_content
    __repr__ = short_repr


def utc(time: str | datetime.datetime | np.datetime64) -> np.datetime64:
    """A time that names its zone, in UTC, to the second; datetime64 is UTC already."""
    if isinstance(time, np.datetime64):
        year = time.astype("datetime64[Y]")  # before seconds, which overflow
        if np.isnat(time):
            raise UsageError("a time is missing (NaT)", "leave it out")
        if not _EARLIEST <= year <= _LATEST:
            raise UsageError(f"the sun's position is known for the years 1800 to 2199, got {year}")
        return time.astype("datetime64[s]")
    if not isinstance(time, (str, datetime.datetime)):
        raise _no_time(time)
    if isinstance(time, str) and (leap := _LEAP_SECOND.search(time)):
        raise UsageError(f"time {time} is in a leap second, which clocks of computers leave out", f"write {leap[1]}:59")
    try:
        text = re.sub("z$", "Z", time.strip()) if isinstance(time, str) else ""
        moment = time if isinstance(time, datetime.datetime) else datetime.datetime.fromisoformat(text)
    except ValueError:
        raise _no_time(time) from None
    if moment != moment:  # NaT of pandas
        raise UsageError("a time is missing (NaT)", "leave it out")
    if moment.tzinfo is None:
        text = moment.isoformat(timespec="seconds" if moment.second else "minutes")
        raise UsageError(
            f"time {time} does not say its time zone", f"write {text}Z for UTC, or an offset such as +02:00"
        )
    try:
        return np.datetime64(moment.astimezone(datetime.UTC).replace(tzinfo=None), "s")
    except OverflowError:
        raise UsageError(f"time {time} lies outside the years 1 to 9999 in UTC") from None


def _no_time(given: object) -> UsageError:
    return UsageError(
        "time must be in ISO 8601 with its zone, for example 2026-06-21T09:30:00Z or 2026-06-21T11:30:00+02:00, "
        f"or datetime64; got {shown_value(given)}"
    )


def times_utc(given: ArrayLike | Sequence[str | datetime.datetime] | str | datetime.datetime) -> np.ndarray:
    """Times of a caller in UTC, datetime64[s]: each text, each datetime and an index of pandas says its zone."""
    if hasattr(given, "tz_localize") and getattr(getattr(given, "dt", given), "tz", 0) is None:
        raise UsageError(
            "the times of pandas do not say their time zone",
            "write times.tz_localize('UTC') of an index, times.dt.tz_localize('UTC') of a column",
        )
    if given is None or isinstance(given, (str, datetime.date)):
        return np.asarray(utc(given))
    try:
        array = np.asarray(unmasked("time", given))
    except ValueError:  # rows of several lengths
        raise _no_time(given) from None
    if array.dtype.kind not in "MOU":
        raise _no_time(given)
    if array.dtype.kind != "M":
        return np.array([utc(one) for one in array.ravel().tolist()], "datetime64[s]").reshape(array.shape)
    if array.size:  # the first and the last, or NaT
        utc(array.min()), utc(array.max())
    return array.astype("datetime64[s]")


@overload
def sun_position(  # type: ignore[overload-overlap]  # one time is array_like, too
    time: str | datetime.datetime | np.datetime64, latitude_deg: float, longitude_deg: float, altitude_m: float = 0.0
) -> SunPosition[float]: ...
@overload
def sun_position(
    time: ArrayLike, latitude_deg: float, longitude_deg: float, altitude_m: float = 0.0
) -> SunPosition[np.ndarray]: ...
def sun_position(
    time: ArrayLike | str | datetime.datetime, latitude_deg: float, longitude_deg: float, altitude_m: float = 0.0
) -> SunPosition[Any]:
    """Position of the sun, and its irradiance outside the atmosphere; needs the extra `weather`.

    Light comes from the apparent zenith angle, and air masses depend on it. It equals the true zenith angle if the sun
    is 0.83 degrees below the horizon or lower.

    Parameters
    ----------
    time : str, datetime, or array_like of these or of datetime64
        ISO 8601 with its zone (``2026-06-21T09:30:00Z``), a datetime with its zone, or datetime64 in UTC. [1800 to
        2199]
    latitude_deg, longitude_deg : float
        The place, north and east positive. [deg, -90 to 90 and -180 to 180]
    altitude_m : float
        Its height above the sea; the air above it bends the light. [m, -500 to 9000]

    Returns
    -------
    SunPosition
        `zenith_deg` without refraction, `apparent_zenith_deg` as it is seen, `azimuth_deg` from +x (east) towards +y
        (north), `extraterrestrial_normal` in W m-2: numbers for one time, else arrays of the shape of `time`.

    Raises
    ------
    UsageError
        A time without zone or outside the years, or no place on Earth.
    MissingExtraError
        pvlib is not installed.

    Notes
    -----
    Accuracy: the angles are those of the algorithm of Reda and Andreas (2004), uncertainty 0.0003 degrees, as pvlib
    has it, for air of 12 degrees C. It takes 67 s between terrestrial and universal time, as in 2014. That moves the
    sun by up to 0.0001 degrees from 2000 to 2030, 0.0009 from 1800 to 2050, 0.002 in 2100 and 0.005 in 2199. The
    irradiance is 1361.1 W m-2 times the distance factor of Spencer (1971).

    Examples
    --------
    >>> sun = sky.sun_position("2026-06-21T12:00Z", latitude_deg=54.0, longitude_deg=8.0)
    >>> print(f"{sun.apparent_zenith_deg:.1f} {sun.azimuth_deg:.1f}")
    31.1 256.5
    """
    times = times_utc(time)
    for name, value in (("latitude", latitude_deg), ("longitude", longitude_deg), ("altitude", altitude_m)):
        try:
            number(name, value)
        except AomcSkyError:
            words = "in m" if name == "altitude" else "of degrees, north and east positive"
            raise UsageError(f"{name} must be a number {words}, got {shown_value(value)}") from None
    if not _LOWEST_M <= altitude_m <= _HIGHEST_M:
        raise UsageError(f"altitude must lie within {_LOWEST_M:g} and {_HIGHEST_M:g} m, got {altitude_m}")
    if not (abs(latitude_deg) <= 90 and abs(longitude_deg) <= 180):
        raise UsageError(
            f"latitude must lie within -90 to 90 and longitude within -180 to 180 degrees, "
            f"got {latitude_deg} and {longitude_deg}"
        )
    pandas, pvlib = optional_module("pandas", extra="weather"), optional_module("pvlib", extra="weather")
    index = pandas.DatetimeIndex(times.ravel()).tz_localize("UTC")
    site = (float(latitude_deg), float(longitude_deg))
    air = dict(_AIR)
    if altitude_m:
        air |= {"altitude": float(altitude_m), "pressure": float(pvlib.atmosphere.alt2pres(altitude_m))}
    angles = pvlib.solarposition.get_solarposition(index, *site, method="nrel_numpy", **air)
    day = times.ravel().astype("M8[D]")
    day_of_year = (day - day.astype("M8[Y]")).astype(np.int64) + 1
    constant = {"solar_constant": EXTRATERRESTRIAL_NORMAL, "method": "spencer"}
    extraterrestrial = pvlib.irradiance.get_extra_radiation(day_of_year, **constant)
    azimuth = to_enu_azimuth_deg(angles["azimuth"].to_numpy(), AzimuthConvention.NORTH_CLOCKWISE)
    return SunPosition(
        zenith_deg=angles["zenith"].to_numpy(dtype=np.float64).reshape(times.shape)[()],
        apparent_zenith_deg=angles["apparent_zenith"].to_numpy(dtype=np.float64).reshape(times.shape)[()],
        azimuth_deg=azimuth.reshape(times.shape)[()],
        extraterrestrial_normal=np.asarray(extraterrestrial, dtype=np.float64).reshape(times.shape)[()],
    )
