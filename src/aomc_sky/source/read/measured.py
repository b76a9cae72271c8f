"""A measured sky: a table of radiances as a sky model."""

from __future__ import annotations

import os
from typing import Any

from numpy.typing import ArrayLike

from aomc_sky.directions import AzimuthConvention, one_angle
from aomc_sky.errors import SceneError
from aomc_sky.formats.azimuth import AzimuthWord
from aomc_sky.formats.radiance_csv import read_radiance_points
from aomc_sky.formats.radiance_words import AngleUnitWord, DecimalWord, Stated, SunAngles, WavelengthUnitWord
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.measured import RadianceField


def read_radiance_csv(
    path: str | os.PathLike[str],
    *,
    zenith: str | None = None,
    elevation: str | None = None,
    azimuth: str | None = None,
    wavelength: str | None = None,
    variable: str | None = None,
    azimuth_convention: AzimuthConvention | AzimuthWord | None = None,
    angle_unit: AngleUnitWord | None = None,
    wavelength_unit: WavelengthUnitWord | None = None,
    radiance_unit: str | None = None,
    decimal: DecimalWord | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
    sun_zenith_rad: float | None = None,
    sun_azimuth_rad: float | None = None,
    grid: PatchGrid | None = None,
    strength: ArrayLike | None = None,
) -> RadianceField:
    """Read measured radiances of the sky, in any directions and any order, from a table of text.

    The first row names the columns, separated by commas, semicolons or tabs: ``zenith_deg`` or ``elevation_deg``,
    ``azimuth_deg``, ``wavelength_nm`` and ``radiance``, or ``L_412`` and so on for each wavelength; ``_rad`` and
    ``_um`` are other units. A line ``# key: value`` has the effect of an argument. Other lines that begin with ``#``
    change nothing and are quoted in a note. A gap is empty, ``nan``, -999 or -9999. Negative zenith angles, and
    elevations above 90 degrees, lie beyond the zenith, as in scans of the principal plane.

    Parameters
    ----------
    path : str or path
        The file, at most 128 MiB.
    zenith, elevation, azimuth, wavelength, variable : str, optional
        Columns of other names; `variable` is that of the radiances.
    azimuth_convention : AzimuthConvention or str, optional
        From where azimuths count and which way, if not the file says it (``# azimuth: clockwise from north``): a
        member, or words such as "clockwise from north". If nothing says it, it is asked.
    angle_unit : {"deg", "rad"}, optional
        Of both angles, if not the names of the columns (``zenith_rad``) or ``# angle unit: deg`` say it.
    wavelength_unit : {"nm", "um", "m", "angstrom"}, optional
        Of the column of wavelengths, if not its name or ``# wavelength unit: nm`` says it.
    radiance_unit : str, optional
        Such as "mW m-2 nm-1 sr-1" or "uW/cm2/sr/nm", or "relative"; else that of ``# radiance unit:``.
    decimal : {"point", "comma"}, optional
        Sign of decimals, if not ``# decimal: comma`` says it.
    sun_zenith_deg, sun_azimuth_deg, or sun_zenith_rad, sun_azimuth_rad : float, optional
        Where the sun is, the azimuth from +x (east) towards +y (north), or ``# sun zenith: 40`` and ``# sun azimuth:
        225 clockwise from north``. Azimuths from the sun need its azimuth; with both angles the sky is interpolated
        better around the sun, and light that is not where the sun is gets a warning.
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
    stated = Stated(
        zenith=zenith,
        elevation=elevation,
        azimuth=azimuth,
        wavelength=wavelength,
        variable=variable,
        azimuth_convention=azimuth_convention,
        angle_unit=angle_unit,
        wavelength_unit=wavelength_unit,
        radiance_unit=radiance_unit,
        decimal=decimal,
    )
    sun = (
        one_angle("sun_zenith_deg", sun_zenith_deg, sun_zenith_rad),
        one_angle("sun_azimuth_deg", sun_azimuth_deg, sun_azimuth_rad),
    )
    return measured_sky(path, stated, sun, grid=grid, strength=strength)[0]


def measured_sky(
    path: str | os.PathLike[str], stated: Stated, sun: SunAngles, other_sun: SunAngles = (None, None), **how: Any
) -> tuple[RadianceField, SunAngles]:
    """As `read_radiance_csv`, with what is stated in one record; with it come the angles of the sun of the file.

    `other_sun` has the angles of the sun where neither the caller nor the file states them.
    """
    points, of_file = read_radiance_points(os.fspath(path), stated, sun, other_sun)
    try:
        return RadianceField.from_points(**points, **how), of_file
    except SceneError as error:
        raise refuse(
            os.fspath(path), str(error), advice="give each wavelength radiances of the sky", code="E654"
        ) from None
