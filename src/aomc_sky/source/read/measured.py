"""A measured sky: a table of radiances as a sky model, and as a scene of its own."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import AzimuthConvention, given_angle
from aomc_sky.errors import FieldError, InputWarning, SceneError, UsageError
from aomc_sky.formats.netcdf import lights_beside, read_field
from aomc_sky.formats.radiance_csv import read_radiance_points
from aomc_sky.formats.sky_toml.sections import SunSection
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.measured import RadianceField
from aomc_sky.skies.tabulated import TabulatedSky, polarised_parts
from aomc_sky.source.light.diffuse import FIELD, DiffuseSky, model_diffuse
from aomc_sky.source.light.inputs import LightInputs, Unsaid
from aomc_sky.source.scene import Scene
from aomc_sky.source.weather_scene import scene_of_sky
from aomc_sky.wavebands import Wavebands, listed_bands, only_bands


def read_radiance_csv(
    path: str | os.PathLike[str],
    *,
    azimuth_convention: AzimuthConvention | str | None = None,
    angle_unit: str | None = None,
    radiance_unit: str | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
    sun_zenith_rad: float | None = None,
    sun_azimuth_rad: float | None = None,
    grid: PatchGrid | None = None,
    strength: ArrayLike | None = None,
) -> RadianceField:
    """Read measured radiances of the sky, in any directions and any order, from a table of text.

    The first row names the columns, separated by commas, semicolons or tabs. They are zenith or elevation, azimuth,
    wavelength and radiance, or ``L_412`` and so on for each wavelength. Units are in brackets or after an underscore.
    A line ``# key: value`` has the effect of an argument. A gap is empty, ``nan``, -999 or -9999. Negative zenith
    angles, and elevations above 90 degrees, lie beyond the zenith, as in scans of the principal plane.

    Parameters
    ----------
    path : str or path
        The file, at most 128 MiB.
    azimuth_convention : AzimuthConvention or str, optional
        From where azimuths count and which way, if not the file says it (``# azimuth: clockwise from north``): a
        member, or words such as "clockwise from north", "west of south", "from the sun". If nothing says it, from +x
        towards +y, as in skydist.inp, with a note.
    angle_unit : {"deg", "rad"}, optional
        Of both angles, if not the names of the columns (``zenith_rad``) or ``# angle unit: deg`` say it.
    radiance_unit : str, optional
        Such as "mW m-2 nm-1 sr-1" or "uW/cm2/sr/nm", or "relative"; else that of the column or ``# radiance unit:``.
    sun_zenith_deg, sun_azimuth_deg, or sun_zenith_rad, sun_azimuth_rad : float, optional
        Where the sun is, the azimuth from +x (east) towards +y (north), or ``# sun zenith: 40`` and ``# sun azimuth:
        225 clockwise from north``. Azimuths from the sun need its azimuth; with both angles the sky is interpolated
        better around the sun.
    grid, strength : optional
        As in `RadianceField`.

    Returns
    -------
    RadianceField
        In absolute units where the file has them.

    Raises
    ------
    InputFileError
        Every problem of the file: E651 for names, units and conventions, E652 for a row that cannot be read, E653 for a
        number outside its range, E654 for too few radiances.

    Examples
    --------
    >>> from pathlib import Path
    >>> rows = [
    ...     "zenith_deg,azimuth_deg,radiance",
    ...     "0,0,0.3",
    ...     "45,0,0.25",
    ...     "45,120,0.25",
    ...     "45,240,0.25",
    ...     "80,60,0.2",
    ... ]
    >>> _ = Path("measured.csv").write_text(chr(10).join(rows))
    >>> field = sky.read_radiance_csv(
    ...     "measured.csv", azimuth_convention="north_clockwise", radiance_unit="relative"
    ... )
    >>> print(field.radiance(0.0, 0.0, 550.0).round(3))
    0.3
    """
    points = read_radiance_points(
        os.fspath(path),
        azimuth_convention=azimuth_convention,
        angle_unit=angle_unit,
        radiance_unit=radiance_unit,
        sun_zenith_deg=_degrees("sun_zenith_deg", sun_zenith_deg, sun_zenith_rad),
        sun_azimuth_deg=_degrees("sun_azimuth_deg", sun_azimuth_deg, sun_azimuth_rad),
    )
    try:
        return RadianceField.from_points(**points, grid=grid, strength=strength)
    except SceneError as error:
        raise refuse(
            os.fspath(path), str(error), advice="give each wavelength radiances of the sky", code="E654"
        ) from None


def _degrees(name: str, value: float | None, twin: float | None) -> float | None:
    return None if value is None and twin is None else float(given_angle(name, value, twin))


def measured_scene(
    path: str | os.PathLike[str],
    given: LightInputs,
    *,
    iterations: int | None = None,
    wavelength_nm: Sequence[float] | None = None,
    wavebands: Sequence[int] | None = None,
    **how: Any,
) -> Scene:
    """A scene of a measured sky, at its own wavelengths by default, and of the beam that `given` asks for.

    `how` is as `read_radiance_csv` takes it.
    """
    sky = read_radiance_csv(path, **_with_sun(how, given))
    sun = None
    if sky.sun_deg is not None:
        on_file = SunSection(zenith_deg=sky.sun_deg[0], azimuth_deg=sky.sun_deg[1], origin="measured sky")
        given = dataclasses.replace(given, sun=given.sun.over(on_file))
        sun = {"zenith_deg": sky.sun_deg[0], "azimuth_deg": sky.sun_deg[1], "disc": False, "from": given.sun.origin}
    diffuse = model_diffuse(sky, is_file=True, words="the measured sky")
    asked_nm = sky.wavelength_nm if wavelength_nm is None else wavelength_nm
    return _scene_of_table(
        path, diffuse, given, {} if sun is None else {"sun": sun}, asked_nm, iterations, wavebands, how
    )


def read_stokes_field(
    path: str,
    variable: str | None,
    variable_q: str | None,
    variable_u: str | None,
    stokes_signs: tuple[float, float] | None,
    *,
    isel: Mapping[str, int],
) -> tuple[Any, list[str]]:
    """A field of a netCDF file and the names of I, or of I, Q and U, as `TabulatedSky.from_xarray` finds them."""
    stokes = partial(polarised_parts, variable=variable, variable_q=variable_q, variable_u=variable_u)
    field = read_field(path, variable=variable, isel=isel, stokes=stokes)
    names = list(map(str, field.data_vars))
    if stokes_signs is not None and len(names) == 1:
        message = "--stokes-signs (stokes_signs) are for a field of Q and U, and this one is read without"
        raise FieldError(message, argument="stokes_signs")
    return field, names


def field_scene(
    path: str,
    given: LightInputs,
    *,
    variable: str | None = None,
    variable_q: str | None = None,
    variable_u: str | None = None,
    stokes_signs: tuple[float, float] | None = None,
    isel: Mapping[str, int] | None = None,
    iterations: int | None = None,
    wavelength_nm: Sequence[float] | None = None,
    wavebands: Sequence[int] | None = None,
    **how: Any,
) -> Scene:
    """A scene of the radiance field of a netCDF file, and of the beam that `given` asks for.

    `how` is as `TabulatedSky.from_xarray` takes it.
    """
    try:
        field, names = read_stokes_field(path, variable, variable_q, variable_u, stokes_signs, isel=isel or {})
        stokes: dict[str, Any] = dict(zip(("variable", "variable_q", "variable_u"), names, strict=False))
        read = partial(TabulatedSky.from_xarray, field, stokes_signs=stokes_signs or (1, 1), **stokes)
        try:
            sky = read(**_with_sun(how, given))
        except UsageError:
            if not (given.has_amounts or given.is_cloudless or given.polarisation):
                raise
            sky = read(**how)  # the sun is that of the beam or the pattern, and a grid of radiances needs none
    except FieldError as error:
        raise refuse(path, error.message, advice=error.advice, code="E710") from None
    except SceneError as error:
        raise refuse(path, str(error), code="E710") from None
    if wavelength_nm is None and not sky.has_wavelength:
        raise UsageError(f"{path} has no wavelengths: write --wavelengths 412 443 555")
    if not (given.has_amounts or given.is_cloudless or given.diffuse_only) and (beside := lights_beside(path)):
        text = (
            f"the radiances of {os.path.basename(path)} are not all of its light, and the rest is missing "
            f"({', '.join(beside)}); for a beam of the sun write two of {{dni}}, {{dhi}} and {{ghi}} and where the sun "
            "is, for the sky alone {diffuse_only:True}"
        )
        warnings.warn(given.say(text), InputWarning, stacklevel=3)
    diffuse = dataclasses.replace(model_diffuse(sky, is_file=True, words="the radiance field"), name=FIELD)
    asked_nm = sky.wavelength_nm if wavelength_nm is None else wavelength_nm
    return _scene_of_table(path, diffuse, given, {}, asked_nm, iterations, wavebands, how)


def _with_sun(how: Mapping[str, Any], given: LightInputs) -> dict[str, Any]:
    return {**how, "sun_zenith_deg": given.sun.zenith_deg, "sun_azimuth_deg": given.sun.azimuth_deg}


def _scene_of_table(
    path: str | os.PathLike[str],
    sky: DiffuseSky,
    given: LightInputs,
    options: dict[str, Any],
    wavelength_nm: Sequence[float] | np.ndarray,
    iterations: int | None,
    wavebands: Sequence[int] | None,
    how: Mapping[str, Any],
) -> Scene:
    bands = Wavebands(wavelength_nm=np.asarray(wavelength_nm, float))
    photons = np.full(bands.n_bands, 10**6 if iterations is None else iterations)
    how = {name: value for name, value in how.items() if isinstance(value, str)}
    return scene_of_sky(
        sky,
        given,
        bands,
        only_bands(photons, wavebands, bands.wavelength_nm),
        unsaid=Unsaid.WHOLE,
        input_files={"radiance": os.fspath(path)},
        options={**options, "wavebands": listed_bands(wavebands), **how},
    )
