"""Global, diffuse and direct irradiance of one sun: any two say the third, GHI = DHI + DNI cos Z."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError, floats, number, shown_value
from aomc_sky.options import PEREZ

EXTRATERRESTRIAL_NORMAL = 1361.1  #: Solar constant. [W m-2]
OFFSET = 5.0  #: Irradiances from minus this to 0 are an instrument's offset and count as 0. [W m-2]

# Limits in the tests of the Baseline Surface Radiation Network [long2008]. They say how much three measured irradiances
# differ, how far a shaded instrument is above an open one, and how much diffuse light is physically possible.
LOW_SUN_DEG = 75.0  #: Zenith angle beyond which the second number of a pair holds. [deg]
LEAST_SUM = 50.0  #: Irradiances below this are compared as if they were this. [W m-2]
SUM_TOLERANCE = (0.08, 0.15)
DIFFUSE_TOLERANCE = (0.05, 0.10)
#: Factor, power of the cosine, and the rest at the horizon. The rest is 50 W m-2 above the network's, for the sun moves
#: by up to 15 degrees in the hour of a mean value. [W m-2]
DIFFUSE_LIMIT = (0.95, 1.2, 100.0)
GLOBAL_LIMIT = (1.5, 1.2, 100.0)  #: The same of the global irradiance.
_KILOWATTS, _HIGH_SUN_DEG = 2.0, 80.0  #: Irradiances below it under a higher sun are hardly in W m-2. [W m-2, deg]
_KILOJOULES = "3.6 kJ m-2 in an hour are 1 W m-2"
BEAM_TOLERANCE = 1.05  #: The sun's distance (3.4 %) on an unknown date, and the calibration of instruments.


def checked_sun(sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Zenith angle of a sun above the horizon as float64; a SceneError for any other. [rad, 0 to pi/2]"""
    zenith = floats("sun_zenith_rad", sun_zenith_rad)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError(
            "the zenith angle of the sun must be from 0 to pi/2 rad (sun above the horizon), got "
            f"{np.nanmin(zenith):g} to {np.nanmax(zenith):g}",
            "leave out the hours with the sun below the horizon",
        )
    return zenith


def checked_irradiance(name: str, value: ArrayLike) -> np.ndarray:
    """Irradiance as float64; what an unlit instrument shows, down to -5 W m-2, is 0."""
    array = floats(name, value)
    if np.any((array < -OFFSET) | np.isinf(array)):
        raise SceneError(
            f"{name} must be finite and at least -{OFFSET:g} W m-2, the offset of an instrument without light; got "
            f"{np.nanmin(array):g} to {np.nanmax(array):g}",
            "leave out the hours without a measurement",
        )
    return np.maximum(array, 0.0)


def single_irradiance(name: str, value: object) -> float:
    """One irradiance that a sky can have, else a SceneError; -5 W m-2 is what an unlit instrument shows."""
    most = PEREZ[name].high
    with contextlib.suppress(UsageError):  # what is no number gets the same sentence
        if -OFFSET <= (one := number(name, value)) <= most:
            return one
    raise SceneError(f"{name} must be -{OFFSET:g} to {most:g} W m-2, got {shown_value(value)}")


def kilowatts(irradiances: Iterable[float | None], sun_zenith_deg: float) -> str:
    """What to write if the sun is high and all irradiances are tiny: probably they are in kW m-2. Else empty."""
    largest = max((value for value in irradiances if value is not None), default=0.0)
    if not 0 < largest < _KILOWATTS or sun_zenith_deg >= _HIGH_SUN_DEG:
        return ""
    return (
        f"that is no daylight with the sun at a zenith angle of {sun_zenith_deg:.3g} degrees; "
        f"irradiances are in W m-2: write {1000 * largest:g} for {largest:g} kW m-2"
    )


def checked_extraterrestrial(value: ArrayLike) -> np.ndarray:
    """Irradiance outside the atmosphere as float64; a SceneError where it is not positive. [W m-2]"""
    array = floats("extraterrestrial_normal", value)
    if np.any((array <= 0) | np.isinf(array)):
        raise SceneError(
            "extraterrestrial_normal must be positive and finite, 1361.1 W m-2 at the mean distance of the sun"
        )
    return array


def closed_irradiances(
    *,
    ghi: float | None = None,
    dni: float | None = None,
    dhi: float | None = None,
    sun_zenith_deg: float,
    extraterrestrial_normal: float = EXTRATERRESTRIAL_NORMAL,
) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance from two of the three; three are checked, dni and dhi count.

    For the numbers given, DNI is within 4 ulp, DHI within 3 ulp of the larger of GHI and DNI cos Z. An error u of the
    inputs grows: u(DNI)^2 = (u(GHI)^2 + u(DHI)^2) / cos^2 Z + (DNI tan Z u(Z))^2. An error of 1 W m-2 becomes 11 at Z =
    85 and 57 at 89 degrees. For DHI, u(DHI)^2 = u(GHI)^2 + cos^2 Z u(DNI)^2 + (DNI sin Z u(Z))^2. Under a clear sky
    this error is a large part of DHI.

    SceneError: an irradiance is below -5 W m-2 or infinite; DNI is asked for of a sun below the horizon; DHI or DNI cos
    Z is above GHI; one of the three is above its limit for the extraterrestrial irradiance; three values do not agree.
    """
    zenith, cosine = float(sun_zenith_deg), float(sin_cos_deg(sun_zenith_deg)[1])
    outside = float(checked_extraterrestrial(number("extraterrestrial_normal", extraterrestrial_normal)))
    given = (("ghi", ghi), ("dni", dni), ("dhi", dhi))
    known = {name: float(checked_irradiance(name, value)) for name, value in given if value is not None}
    if len(known) < 2:
        raise UsageError(f"two of ghi, dni and dhi make a sky, got {next(iter(known), 'none')}")
    if "dhi" not in known:
        known["dhi"] = _diffuse(known["ghi"], known["dni"], zenith, cosine)
    elif "dni" not in known:
        known["dni"] = _direct(known["ghi"], known["dhi"], zenith, cosine, outside)
    elif "ghi" in known:
        _check_sum(known["ghi"], known["dni"], known["dhi"], zenith, cosine)
    most, most_global = (
        factor * outside * max(cosine, 0.0) ** power + least for factor, power, least in (DIFFUSE_LIMIT, GLOBAL_LIMIT)
    )
    total = known["dhi"] + known["dni"] * max(cosine, 0.0)
    if known["dni"] > BEAM_TOLERANCE * outside:
        raise SceneError(
            f"dni {known['dni']:g} W m-2 is more than any sky lets through, for the sun has {outside:g} outside the "
            f"atmosphere",
            f"check dni and its unit: {_KILOJOULES}",
        )
    if known["dhi"] > most:  # which none of 13 291 real hours has
        raise SceneError(
            f"dhi {known['dhi']:g} W m-2 is more than any sky gives with the sun at a zenith angle of {zenith:.6g} "
            f"degrees, {most:.4g} W m-2 for {outside:g} outside the atmosphere",
            "check dhi, and the time with its zone",
        )
    if total > most_global:
        raise SceneError(
            f"dhi {known['dhi']:g} + dni {known['dni']:g} cos Z is {total:.4g} W m-2, which is more than any sky "
            f"and sun give with the sun at a zenith angle of {zenith:.6g} degrees, {most_global:.4g} W m-2 for "
            f"{outside:g} outside the atmosphere",
            f"check their unit, and the time with its zone: {_KILOJOULES}",
        )
    return known["dni"], known["dhi"]


def dhi_exceeds_ghi(ghi: float | None, dni: float | None, dhi: float | None) -> str:
    """A warning if DHI lies above GHI by no more than instruments differ, else an empty text."""
    if ghi is None or dhi is None or dni is not None or not dhi > max(ghi, 0.0):
        return ""
    return f"dhi {dhi:g} exceeds ghi {ghi:g} W m-2 by no more than instruments differ; dni counts as 0"


def _direct(ghi: float, dhi: float, zenith: float, cosine: float, outside: float) -> float:
    if not (zenith >= 0 and cosine > 0):
        raise SceneError(
            f"ghi and dhi say nothing of the beam of a sun below the horizon: its zenith angle is {zenith:g} degrees",
            "check the time and its zone",
        )
    beam = ghi - dhi
    if beam < -_tolerance_of_sun(DIFFUSE_TOLERANCE, zenith) * max(ghi, LEAST_SUM):
        raise SceneError(
            f"dhi {dhi:g} W m-2 is more than ghi {ghi:g}, so that dni would be negative",
            "give ghi and dhi of the same moment: ghi is the light of sun and sky together",
        )
    direct = max(beam, 0.0) / cosine
    if direct > BEAM_TOLERANCE * outside:
        raise SceneError(
            f"ghi {ghi:g} less dhi {dhi:g} W m-2 is a beam of {direct:.4g} W m-2 with the sun at a zenith angle "
            f"of {zenith:.6g} degrees, and outside the atmosphere it has {outside:g}",
            "check the time, or give dni and dhi",
        )
    return direct


def _diffuse(ghi: float, dni: float, zenith: float, cosine: float) -> float:
    beam = dni * cosine
    diffuse = ghi - beam
    if diffuse < -1e-9 * beam:
        raise SceneError(
            f"dni cos Z is {beam:g} W m-2 (dni {dni:g}, the sun at a zenith angle of {zenith:.6g} degrees) and exceeds "
            f"ghi {ghi:g}, so nothing is left for the sky",
            "give ghi and dni of the same moment",
        )
    return max(diffuse, 0.0)


def _check_sum(ghi: float, dni: float, dhi: float, zenith: float, cosine: float) -> None:
    total, share = dhi + dni * cosine, _tolerance_of_sun(SUM_TOLERANCE, zenith)
    if abs(ghi - total) > share * max(total, LEAST_SUM):
        raise SceneError(
            f"ghi {ghi:g} is not dhi {dhi:g} + dni {dni:g} cos Z = {total:.4g} W m-2 with the sun at a zenith "
            f"angle of {zenith:.6g} degrees; good instruments agree to {100 * share:.0f} % "
            f"({share * LEAST_SUM:g} W m-2 in weak light)",
            "leave out the one that is wrong",
        )


def _tolerance_of_sun(pair: tuple[float, float], zenith: float) -> float:
    return pair[0] if zenith < LOW_SUN_DEG else pair[1]
