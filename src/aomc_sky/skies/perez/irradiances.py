"""Global, diffuse and direct irradiance of one sun: any two say the third, GHI = DHI + DNI cos Z."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.inputs import PEREZ

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
BEAM_TOLERANCE = 1.05  #: The sun's distance (3.4 %) on an unknown date, and the calibration of instruments.


def checked_sun(sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Zenith angle of a sun above the horizon as float64; a SceneError for any other. [rad, 0 to pi/2]"""
    zenith = np.asarray(sun_zenith_rad, dtype=np.float64)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError(
            "the zenith angle of the sun must be from 0 to pi/2 rad (sun above the horizon), got "
            f"{zenith.min():g} to {zenith.max():g}; leave out the hours with the sun below the horizon"
        )
    return zenith


def checked_irradiance(name: str, value: ArrayLike) -> np.ndarray:
    """Irradiance as float64; what an unlit instrument shows, down to -5 W m-2, is 0."""
    array = np.asarray(value, dtype=np.float64)
    if np.any((array < -OFFSET) | np.isinf(array)):
        raise SceneError(
            f"{name} must be finite and at least -{OFFSET:g} W m-2, the offset of an instrument without light; got "
            f"{np.nanmin(array):g} to {np.nanmax(array):g}; leave out the hours without a measurement"
        )
    return np.maximum(array, 0.0)


def check_single_irradiance(name: str, value: object) -> None:
    """Refuse what is not one irradiance that a sky can have; -5 W m-2 is what an unlit instrument shows."""
    number, most = np.asarray(value), PEREZ[name].high
    if number.ndim or number.dtype.kind not in "iuf" or not -OFFSET <= number <= most:
        raise SceneError(f"{name} must be -{OFFSET:g} to {most:g} W m-2, got {value!r}")


def checked_extraterrestrial(value: ArrayLike) -> np.ndarray:
    """Irradiance outside the atmosphere as float64; a SceneError where it is not positive. [W m-2]"""
    array = np.asarray(value, dtype=np.float64)
    if np.any(array <= 0):
        raise SceneError("extraterrestrial_normal must be positive, 1361.1 W m-2 at the mean distance of the sun")
    return array


def closed_irradiances(
    *,
    ghi: ArrayLike | None = None,
    dni: ArrayLike | None = None,
    dhi: ArrayLike | None = None,
    sun_zenith_deg: ArrayLike,
    extraterrestrial_normal: ArrayLike = EXTRATERRESTRIAL_NORMAL,
) -> tuple[np.ndarray, np.ndarray]:
    """Direct normal and diffuse horizontal irradiance from two of the three; three are checked, dni and dhi count.

    NaN comes out only where NaN went in. For the numbers given, DNI is within 4 ulp, DHI within 3 ulp of the larger of
    GHI and DNI cos Z. An error u of the inputs grows: u(DNI)^2 = (u(GHI)^2 + u(DHI)^2) / cos^2 Z + (DNI tan Z u(Z))^2.
    An error of 1 W m-2 becomes 11 at Z = 85 and 57 at 89 degrees. For DHI, u(DHI)^2 = u(GHI)^2 + cos^2 Z u(DNI)^2 +
    (DNI sin Z u(Z))^2. Under a clear sky this error is a large part of DHI.

    SceneError: an irradiance is below -5 W m-2 or infinite; DNI is asked for of a sun below the horizon; DHI or DNI cos
    Z is above GHI; DNI or DHI is above its limit for the extraterrestrial irradiance; three values do not agree.
    """
    zenith = np.asarray(sun_zenith_deg, dtype=np.float64)
    cosine = sin_cos_deg(zenith)[1]
    extraterrestrial = checked_extraterrestrial(extraterrestrial_normal)
    names = [name for name, value in (("ghi", ghi), ("dni", dni), ("dhi", dhi)) if value is not None]
    if len(names) < 2:
        raise UsageError(f"two of ghi, dni and dhi make a sky, got {names[0] if names else 'none'}")
    if dhi is None:
        assert ghi is not None
        assert dni is not None
        direct = checked_irradiance("dni", dni)
        diffuse = _diffuse(checked_irradiance("ghi", ghi), direct, zenith, cosine)
    else:
        diffuse = checked_irradiance("dhi", dhi)
        if dni is None:
            assert ghi is not None
            direct = _direct(checked_irradiance("ghi", ghi), diffuse, zenith, cosine, extraterrestrial)
        else:
            direct = checked_irradiance("dni", dni)
            if ghi is not None:
                _check_sum(checked_irradiance("ghi", ghi), direct, diffuse, zenith, cosine)
    check_diffuse(diffuse, zenith, extraterrestrial)
    return direct, diffuse


def check_diffuse(
    dhi: ArrayLike, sun_zenith_deg: ArrayLike, extraterrestrial_normal: ArrayLike = EXTRATERRESTRIAL_NORMAL
) -> None:
    """Refuse more diffuse light than 0.95 E0 cos^1.2 Z + 100 W m-2, which 13 291 real hours do not reach."""
    factor, power, least = DIFFUSE_LIMIT
    zenith = np.asarray(sun_zenith_deg, dtype=np.float64)
    outside = np.asarray(extraterrestrial_normal, dtype=np.float64)
    limit = factor * outside * np.maximum(sin_cos_deg(zenith)[1], 0.0) ** power + least
    bad = np.asarray(dhi) > limit
    if np.any(bad):
        value, most, sun, solar = _first(bad, dhi, limit, zenith, outside)
        raise SceneError(
            f"dhi {value:g} W m-2 is more than any sky gives with the sun at a zenith angle of {sun:.6g} degrees, "
            f"{most:.4g} W m-2 for {solar:g} outside the atmosphere; check dhi, and the time with its zone"
        )


def dhi_exceeds_ghi(ghi: float | None, dni: float | None, dhi: float | None) -> str:
    """A warning if DHI lies above GHI by no more than instruments differ, else an empty text."""
    if ghi is None or dhi is None or dni is not None or not dhi > max(ghi, 0.0):
        return ""
    return f"dhi {dhi:g} exceeds ghi {ghi:g} W m-2 by no more than instruments differ; dni counts as 0"


def _direct(
    ghi: np.ndarray, dhi: np.ndarray, zenith: np.ndarray, cosine: np.ndarray, extraterrestrial: np.ndarray
) -> np.ndarray:
    low = ~((zenith >= 0) & (cosine > 0)) & ~np.isnan(zenith)
    if np.any(low):
        (sun,) = _first(low, zenith)
        raise SceneError(
            f"ghi and dhi say nothing of the beam of a sun below the horizon: its zenith angle is {sun:g} degrees; "
            "check the time and its zone"
        )
    beam = ghi - dhi
    bad = beam < -_of_sun(DIFFUSE_TOLERANCE, zenith) * np.maximum(ghi, LEAST_SUM)
    if np.any(bad):
        total, diffuse = _first(bad, ghi, dhi)
        raise SceneError(
            f"dhi {diffuse:g} W m-2 is more than ghi {total:g}, so that dni would be negative; give ghi and dhi of the "
            "same moment: ghi is the light of sun and sky together"
        )
    with np.errstate(over="ignore"):
        direct = np.maximum(beam, 0.0) / cosine
    bad = direct > BEAM_TOLERANCE * extraterrestrial
    if np.any(bad):
        total, diffuse, value, sun, outside = _first(bad, ghi, dhi, direct, zenith, extraterrestrial)
        raise SceneError(
            f"ghi {total:g} less dhi {diffuse:g} W m-2 is a beam of {value:.4g} W m-2 with the sun at a zenith angle "
            f"of {sun:.6g} degrees, and outside the atmosphere it has {outside:g}; check the time, or give dni and dhi"
        )
    return direct


def _diffuse(ghi: np.ndarray, dni: np.ndarray, zenith: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    beam = dni * cosine
    diffuse = ghi - beam
    bad = diffuse < -1e-9 * beam
    if np.any(bad):
        total, direct, part, sun = _first(bad, ghi, dni, beam, zenith)
        raise SceneError(
            f"dni cos Z is {part:g} W m-2 (dni {direct:g}, the sun at a zenith angle of {sun:.6g} degrees) and exceeds "
            f"ghi {total:g}, so nothing is left for the sky; give ghi and dni of the same moment"
        )
    return np.maximum(diffuse, 0.0)


def _check_sum(ghi: np.ndarray, dni: np.ndarray, dhi: np.ndarray, zenith: np.ndarray, cosine: np.ndarray) -> None:
    total = dhi + dni * cosine
    tolerance = _of_sun(SUM_TOLERANCE, zenith)
    bad = np.abs(ghi - total) > tolerance * np.maximum(total, LEAST_SUM)
    if np.any(bad):
        given, direct, diffuse, part, sun, share = _first(bad, ghi, dni, dhi, total, zenith, tolerance)
        raise SceneError(
            f"ghi {given:g} is not dhi {diffuse:g} + dni {direct:g} cos Z = {part:.4g} W m-2 with the sun at a zenith "
            f"angle of {sun:.6g} degrees; good instruments agree to {100 * share:.0f} % "
            f"({share * LEAST_SUM:g} W m-2 in weak light); leave out the one that is wrong"
        )


def _of_sun(pair: tuple[float, float], zenith: np.ndarray) -> np.ndarray:
    return np.where(zenith < LOW_SUN_DEG, *pair)


def _first(bad: np.ndarray, *values: ArrayLike) -> list[float]:
    """The values at the first place where something is bad, for its message."""
    bad, *arrays = np.broadcast_arrays(bad, *values)
    return [float(array[bad][0]) for array in arrays]
