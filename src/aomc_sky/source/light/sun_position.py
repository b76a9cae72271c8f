"""Where the sun stands, and how much it gives outside the atmosphere: pvlib's numbers in our conventions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.skies.perez.irradiances import EXTRATERRESTRIAL_NORMAL

_AIR = {"altitude": 0.0, "pressure": 101_325.0, "temperature": 12.0}
_EARLIEST, _LATEST = np.datetime64("1800-01-01"), np.datetime64("2200-01-01")


@dataclass(frozen=True, kw_only=True, slots=True)
class SunPosition:
    """The sun at given times and one place: arrays of the shape of the times."""

    zenith_deg: np.ndarray  #: true, without refraction [deg, 0 to 180]
    apparent_zenith_deg: np.ndarray  #: as seen: air of 101 325 Pa, 12 degrees C lifts the sun by 0.5 at the horizon
    azimuth_deg: np.ndarray  #: from +x (east) towards +y (north) [deg, 0 to 360)
    extraterrestrial_normal: np.ndarray  #: on a surface that faces the sun outside the atmosphere [W m-2]


def sun_position(time: ArrayLike, latitude_deg: float, longitude_deg: float) -> SunPosition:
    """Zenith angles, azimuth and extraterrestrial irradiance of the sun, at times in UTC [datetime64, 1800 to 2199].

    The angles are those of the algorithm of Reda and Andreas (2004), uncertainty 0.0003 degrees; the irradiance is
    1361.1 W m-2 times the distance factor of Spencer (1971). Light comes from the apparent zenith angle, and air masses
    are functions of it; it is the true one from 0.83 degrees below the horizon down. Position at sea level, north and
    east positive. [deg]
    """
    times = np.asarray(time, dtype="datetime64[s]")
    if not (abs(latitude_deg) <= 90 and abs(longitude_deg) <= 180):
        raise UsageError(
            f"latitude must lie within -90 to 90 and longitude within -180 to 180 degrees, "
            f"got {latitude_deg} and {longitude_deg}"
        )
    if np.any(np.isnat(times)) or np.any(times < _EARLIEST) or np.any(times >= _LATEST):
        raise UsageError("the sun's position is known for the years 1800 to 2199")
    pandas, pvlib = optional_module("pandas", extra="weather"), optional_module("pvlib", extra="weather")
    index = pandas.DatetimeIndex(times.ravel()).tz_localize("UTC")
    site = (float(latitude_deg), float(longitude_deg))
    angles = pvlib.solarposition.get_solarposition(index, *site, method="nrel_numpy", **_AIR)
    day = times.ravel().astype("M8[D]")
    day_of_year = (day - day.astype("M8[Y]")).astype(np.int64) + 1
    constant = {"solar_constant": EXTRATERRESTRIAL_NORMAL, "method": "spencer"}
    extraterrestrial = pvlib.irradiance.get_extra_radiation(day_of_year, **constant)
    azimuth = to_enu_azimuth_deg(angles["azimuth"].to_numpy(), AzimuthConvention.NORTH_CLOCKWISE)
    return SunPosition(
        zenith_deg=angles["zenith"].to_numpy(dtype=np.float64).reshape(times.shape),
        apparent_zenith_deg=angles["apparent_zenith"].to_numpy(dtype=np.float64).reshape(times.shape),
        azimuth_deg=azimuth.reshape(times.shape),
        extraterrestrial_normal=np.asarray(extraterrestrial, dtype=np.float64).reshape(times.shape),
    )
