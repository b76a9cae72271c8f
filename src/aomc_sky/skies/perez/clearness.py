"""What the Perez sky is made from: clearness and brightness of the sky, from irradiances and the sun."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.perez.elementary import power
from aomc_sky.skies.perez.table import EPSILON_EDGES

EXTRATERRESTRIAL_NORMAL = 1361.1  #: Solar constant. [W m-2]

OFFSET = 5.0  #: Negative irradiances down to minus this are an instrument's offset and count as 0. [W m-2]

# offset, reach and 1e4 power of cos Z + offset (reach - Z in degrees)^-power
_AIR_MASS = {"kasten-young-1989": (0.50572, 96.07995, 16364.0), "kasten-1966": (0.15, 93.885, 12530.0)}

_KAPPA = 1.041


def checked_sun(sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Zenith angle of a sun above the horizon as float64; a SceneError for any other. [rad, 0 to pi/2]"""
    zenith = np.asarray(sun_zenith_rad, dtype=np.float64)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError(
            "the sun's zenith angle must lie in 0 to pi/2 rad (sun above the horizon), got "
            f"{zenith.min():g} to {zenith.max():g}; leave out the hours with the sun down"
        )
    return zenith


def _irradiance(name: str, value: ArrayLike) -> np.ndarray:
    """Irradiance as float64; what an unlit instrument shows, down to -5 W m-2, is 0."""
    array = np.asarray(value, dtype=np.float64)
    if np.any((array < -OFFSET) | np.isinf(array)):
        raise SceneError(
            f"{name} must be finite and not below the offset of an unlit instrument, -{OFFSET:g} W m-2; got "
            f"{np.nanmin(array):g} to {np.nanmax(array):g}; leave out the hours without a measurement"
        )
    return np.maximum(array, 0.0)


def sky_clearness(dni: ArrayLike, dhi: ArrayLike, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Sky clearness epsilon, eq. (4), with 1.041 Z^3 and Z in radians.

    Parameters
    ----------
    dni : array_like
        Direct normal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    dhi : array_like
        Diffuse horizontal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]

    Returns
    -------
    ndarray, float64
        Broadcast of the arguments. [1 to inf] Without diffuse light it is infinite, without any light 1.

    Raises
    ------
    SceneError
        An irradiance is below -5 W m-2 or infinite, or the sun is below the horizon.

    Notes
    -----
    Accuracy: 3 ulp. Written as 1 + (dni/dhi) / (1 + 1.041 Z^3), which keeps a tiny dni.
    """
    direct, diffuse = np.broadcast_arrays(_irradiance("dni", dni), _irradiance("dhi", dhi))
    zenith = checked_sun(sun_zenith_rad)
    ratio = np.where(np.isnan(direct), np.nan, np.where(direct > 0, np.inf, 0.0))
    with np.errstate(over="ignore"):
        ratio = np.divide(direct, diffuse, out=ratio, where=diffuse != 0)
    return 1.0 + ratio / (1.0 + _KAPPA * zenith * zenith * zenith)


def relative_air_mass(sun_zenith_rad: ArrayLike, *, formula: str = "kasten-young-1989") -> np.ndarray:
    """Relative optical air mass at sea level.

    Parameters
    ----------
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to where the formula ends, beyond pi/2]
    formula : {"kasten-young-1989", "kasten-1966"}
        The paper takes the first [kasten1989]; gendaylit takes the second, 0.15 (93.885 - Z)^-1.253.

    Returns
    -------
    ndarray, float64
        1 overhead, 37.92 (36.51) at the horizon.

    Raises
    ------
    SceneError
        The sun is so far below the horizon (96.08 or 93.885 degrees) that the formula has no value.
    """
    if formula not in _AIR_MASS:
        raise UsageError(f"air_mass must be one of {', '.join(map(repr, _AIR_MASS))}, got {formula!r}")
    offset, reach, exponent = _AIR_MASS[formula]
    zenith = np.asarray(sun_zenith_rad, dtype=np.float64)
    degrees = np.rad2deg(zenith)
    if np.any((degrees < 0) | (degrees >= reach)):
        raise SceneError(f"the air mass of {formula} exists for a sun at zenith angles 0 to {reach} degrees")
    return 1.0 / (sin_cos_deg(degrees)[1] + offset * power(reach - degrees, np.full_like(degrees, -exponent)))


def sky_brightness(
    dhi: ArrayLike,
    sun_zenith_rad: ArrayLike,
    *,
    extraterrestrial_normal: ArrayLike = EXTRATERRESTRIAL_NORMAL,
    air_mass: str = "kasten-young-1989",
) -> np.ndarray:
    """Sky brightness Delta, eq. (5): air mass x dhi / extraterrestrial_normal.

    Parameters
    ----------
    dhi : array_like
        Diffuse horizontal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]
    extraterrestrial_normal : array_like
        Irradiance on a plane that faces the sun outside the atmosphere, on that day. [W m-2]
    air_mass : {"kasten-young-1989", "kasten-1966"}
        Formula of the air mass.

    Returns
    -------
    ndarray, float64
        Broadcast of the arguments. [0 or more]
    """
    extraterrestrial = np.asarray(extraterrestrial_normal, dtype=np.float64)
    if np.any(extraterrestrial <= 0):
        raise SceneError("extraterrestrial_normal must be positive, 1361.1 W m-2 at the mean distance of the sun")
    mass = relative_air_mass(checked_sun(sun_zenith_rad), formula=air_mass)
    return mass * _irradiance("dhi", dhi) / extraterrestrial


def diffuse_from_global(ghi: ArrayLike, dni: ArrayLike, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Diffuse horizontal irradiance that closes ghi = dhi + dni cos Z.

    Parameters
    ----------
    ghi, dni : array_like
        Global horizontal and direct normal irradiance. [W m-2, 0 or more; -5 to 0 counts as 0]
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]

    Returns
    -------
    ndarray, float64
        Broadcast of the arguments; rounding below zero gives 0. [W m-2]

    Raises
    ------
    SceneError
        dni cos Z exceeds ghi by more than rounding.
    """
    total, direct = _irradiance("ghi", ghi), _irradiance("dni", dni)
    beam = direct * sin_cos_deg(np.rad2deg(checked_sun(sun_zenith_rad)))[1]
    diffuse = total - beam
    if np.any(diffuse < -1e-9 * beam):
        raise SceneError(
            "dni cos Z exceeds ghi, so nothing is left for the sky; check that ghi is the global horizontal "
            "and dni the direct normal irradiance of the same hour"
        )
    return np.maximum(diffuse, 0.0)


def epsilon_bin(epsilon: ArrayLike) -> np.ndarray:
    """Bin of the sky clearness, 0 to 7: lower edges belong to the bin, values below 1 to the first.

    Parameters
    ----------
    epsilon : array_like
        Sky clearness; not NaN. [1 to inf]

    Returns
    -------
    ndarray, int64
        Row of Table 1.
    """
    clearness = np.asarray(epsilon, dtype=np.float64)
    if np.any(np.isnan(clearness)):
        raise SceneError("a sky clearness that is not a number has no bin")
    return np.searchsorted(np.array(EPSILON_EDGES[1:]), clearness, side="right")
