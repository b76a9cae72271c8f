"""An atmosphere description is read and solved in given directions."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import given_angle
from aomc_sky.errors import SceneError, UsageError, floats, number
from aomc_sky.formats.sky_toml.keys import PREFIX
from aomc_sky.formats.sky_toml.sections import MoonDirection, moon_direction
from aomc_sky.progress import is_free, status_line
from aomc_sky.skies.atmosphere.description.medium import (
    glow_of_luminance,
    moon_of_direction,
    read_medium,
)
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.sky.method import SolverWord
from aomc_sky.skies.atmosphere.sky.solve import AtmosphereResult, solve
from aomc_sky.source.light.said import checked_lights
from aomc_sky.wavebands import nearest_wavelength_index

_PER_WAVELENGTH = (
    "wavelength_nm",
    "radiance",
    "radiance_by_order",
    "standard_error",
    "direct_irradiance",
    "diffuse_irradiance",
    "truncation",
)


def solve_atmosphere(
    path: str | os.PathLike[str],
    *,
    wavelength_nm: ArrayLike,
    sun_zenith_deg: float | None = None,
    sky_zenith_deg: ArrayLike | None = None,
    azimuth_from_sun_deg: ArrayLike | None = None,
    method: SolverWord = "auto",
    orders: int | None = None,
    paths: int | None = None,
    seed: int = 0,
    moon: Mapping[str, float] | None = None,
    ground_luminance_cd_m2: float = 0.0,
    allow_paths: Sequence[str | os.PathLike[str]] = (),
    sun_zenith_rad: float | None = None,
    sky_zenith_rad: ArrayLike | None = None,
    azimuth_from_sun_rad: ArrayLike | None = None,
) -> AtmosphereResult:
    """Radiance of the clear sky of an atmosphere description, seen from sea level.

    Parameters
    ----------
    path : str or path
        The description, a .atmo file.
    wavelength_nm : array_like, shape (n_wl,)
        Wavelengths; each gets the nearest one of the description, which `result.wavelength_nm` says; an `InputWarning`
        where that is more than 1 nm away. [nm]
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun. [deg, 0 to 108]
    sky_zenith_deg, or sky_zenith_rad : array_like, shape (n_zenith,)
        Zenith angles looked into. [deg, 0 to 90]
    azimuth_from_sun_deg, or azimuth_from_sun_rad : array_like, shape (n_azimuth,)
        Azimuths looked into, 0 into that of the sun. [deg]
    method : {"auto", "order1", "sos", "mc"}
        "order1": light scattered once. "sos": successive orders of scattering too. "mc": these by backward
        paths through shells, for any sun. "auto": "order1" where one order is asked for, "sos" for a sun 10 degrees
        above the horizon and higher, else "mc".
    orders : int, optional
        Most interactions of light with air and ground that count; the description's by default. [1 or more]
    paths : int, optional
        Backward paths of "mc" and of a glowing ground in each direction and at each wavelength; four times as many
        halve the error. By default 65536 in the directions asked for, fewer where they are more than 512.
        [8 to 2^32 - 1]
    seed : int
        Of the random numbers of the paths. Solutions of several seeds scatter by `result.standard_error`. [0 to 2^64 -
        1]
    moon : mapping, optional
        The Moon before the sun: "zenith_deg" or "zenith_offset_deg" from the sun's, "azimuth_deg" from the sun's
        azimuth, both by default the sun's; "distance_km" from the observer, by default what the description's
        Earth-Moon distance gives. None: no Moon.
    ground_luminance_cd_m2 : float
        Of a ground that gives off light of the colour that the description says; with it the sun may stand at any
        zenith angle to 180 degrees. [cd m-2, 0 or more]
    allow_paths : sequence of str or path
        Folders below which tables of the description may lie, besides its own.

    Returns
    -------
    AtmosphereResult
        For the solar irradiance of the description, wavelengths and directions in the order asked.

    Raises
    ------
    InputFileError
        Everything that is wrong with the description and its files.
    UsageError
        Angles out of range, or a sun that the method is not good for.
    SceneError
        Deep night, or wavelengths that are no positive numbers.

    Notes
    -----
    `result.standard_error` estimates the error in every direction: of "mc" the scatter of the paths; else 1e-5 of the
    radiance, the error of the resolution, and of later orders 0.4 % for suns above 10 degrees, up to 3 % at the
    horizon. Beside other programs, and costs: docs/models/atmosphere.md.

    Examples
    --------
    >>> solved = sky.solve_atmosphere(
    ...     "inputs/atmosphere/molecules_only.atmo",
    ...     wavelength_nm=[400.0, 700.0],
    ...     sun_zenith_deg=30.0,
    ...     sky_zenith_deg=[0.0],
    ...     azimuth_from_sun_deg=[0.0],
    ...     method="order1",
    ... )
    >>> blue, red = solved.radiance[:, 0, 0]
    >>> bool(blue > 4 * red)
    True
    """
    given = (None if one is None else number("the sun's zenith angle", one) for one in (sun_zenith_deg, sun_zenith_rad))
    sun = given_angle("sun_zenith_deg", *given)
    zenith_deg = given_angle("sky_zenith_deg", sky_zenith_deg, sky_zenith_rad)
    azimuth_deg = given_angle("azimuth_from_sun_deg", azimuth_from_sun_deg, azimuth_from_sun_rad)
    if not np.isfinite(sun):
        raise SceneError(f"the sun's zenith angle must be finite, got {sun!r}")
    requested = _numbers(wavelength_nm, "wavelengths")
    medium, report = read_medium(read_atmo(Path(path), allow_paths=[os.fspath(one) for one in allow_paths]), requested)
    with status_line("solving the atmosphere", enabled=is_free()):
        result = solve(
            medium,
            sun_zenith_rad=float(np.deg2rad(sun)),
            sky_zenith_rad=np.deg2rad(_numbers(zenith_deg, "zenith angles of directions")),
            azimuth_from_sun_rad=np.deg2rad(_numbers(azimuth_deg, "azimuths of directions")),
            method=method,
            n_orders=orders,
            n_paths=paths,
            seed=seed,
            dropped=report.dropped,
            moon=moon_of_direction(direction_of_moon(moon), medium, report, float(np.rad2deg(np.deg2rad(sun))), 0.0),
            ground_radiance=glow_of_luminance(ground_luminance_cd_m2, report, os.fspath(path)),
        )
    rows = nearest_wavelength_index(requested, medium.wavelength_nm)
    return dataclasses.replace(result, **{name: getattr(result, name)[rows] for name in _PER_WAVELENGTH})


def direction_of_moon(moon: Mapping[str, float] | None) -> MoonDirection | None:
    """The argument `moon` of `solve_atmosphere`, checked; a UsageError without a direction."""
    if moon is None:
        return None
    if not isinstance(moon, Mapping):
        raise UsageError(f'the Moon must be a mapping such as {{"zenith_offset_deg": 0}}, got {moon!r}')
    lights = checked_lights({f"{PREFIX}{name}": value for name, value in moon.items()})
    if not lights:
        raise UsageError(
            "the Moon has no direction", 'write moon={"zenith_offset_deg": 0} for a Moon in front of the sun'
        )
    return moon_direction(lights)


def _numbers(given: ArrayLike, what: str) -> np.ndarray:
    """One row of float64."""
    found = np.atleast_1d(floats(what, given))
    if found.ndim != 1:
        raise UsageError(f"{what} must be numbers in one row")
    return found
