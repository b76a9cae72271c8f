"""The radiance field of a file, named alone or in sky.toml, as the diffuse sky of a scene."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import FieldError, InputFileError, UsageError
from aomc_sky.formats import netcdf
from aomc_sky.formats.hdf5_storage import require_size
from aomc_sky.formats.radiance_words import SunAngles
from aomc_sky.formats.sky_toml.file import problem_of_key
from aomc_sky.formats.sky_toml.sections import FieldSection, SunSection
from aomc_sky.skies.field import read_field
from aomc_sky.skies.field_choice import choose
from aomc_sky.skies.measured import RadianceField
from aomc_sky.skies.tabulated import TabulatedSky, Weighting
from aomc_sky.source.light.brightness import InBands
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.skies import FIELD, Lowered, Model, patterned
from aomc_sky.source.read.kind import TABLES
from aomc_sky.source.read.measured import measured_sky
from aomc_sky.source.scene import require_projected
from aomc_sky.wavebands import nearest_wavelength_index


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyField:
    """A radiance field on its patches, and how it was read."""

    section: FieldSection
    variable: str
    sky: TabulatedSky
    sun: SunSection  #: where the file says that it is

    @property
    def reading(self) -> str:
        """What was read, for a person."""
        grid, n_wl = self.sky.grid, self.sky.wavelength_nm.size
        wavelengths = f", {n_wl} wavelength{'s' * (n_wl != 1)}" if self.sky.has_wavelength else ""
        origin = f"{self.section.file}, {self.variable!r}"
        return f"sky field: {origin}, {grid.n_zenith} x {grid.n_azimuth} patches{wavelengths}"

    def as_options(self, folder: str) -> dict[str, Any]:
        """JSON values for a manifest; the same wherever the scene lies."""
        section = dataclasses.asdict(self.section)
        return {
            **{name: value for name, value in section.items() if name not in _STOKES_KEYS or value is not None},
            "file": os.path.relpath(self.section.file, folder or os.curdir),
            "variable": self.variable,
            "isel": dict(self.section.isel),
            "n_zenith": self.sky.grid.n_zenith,
            "n_azimuth": self.sky.grid.n_azimuth,
            "wavelength_nm": self.sky.wavelength_nm.tolist() if self.sky.has_wavelength else None,
            "remarks": list(self.sky.remarks),
        }

    def as_sky(self, folder: str, *, per_solid_angle: bool) -> FieldSky:
        """The field as the sky of a scene."""
        sky = self.sky
        if per_solid_angle and sky.radiance_unit:
            raise UsageError(
                "weighting 'solid-angle' is for a sky in relative units, and this field is in W m-2 nm-1 on the "
                "horizontal surface",
                "leave it out",
            )
        if per_solid_angle:
            sky = dataclasses.replace(sky, weighting=Weighting.SOLID_ANGLE, slope=None)
        return FieldSky(
            sky=sky, file=self.section.file, reading=self.reading, options={"field": self.as_options(folder)}
        )


READ_BY = (
    "zenith_deg", "azimuth_deg", "time", "latitude_deg", "longitude_deg", "weighting"
)  # fmt: skip
"""Inputs that say how a field is read."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FieldSky:
    """A radiance field as the sky of a scene."""

    sky: TabulatedSky
    file: str
    reading: str  #: what was read, for people
    options: Mapping[str, Any]  #: for a manifest
    made_of: str = "the field of sky.toml"
    is_whole: bool = False
    name, names = FIELD, READ_BY
    needs_sun, has_sun = False, True

    def _rows(self, wavelength_nm: np.ndarray) -> np.ndarray:
        return nearest_wavelength_index(wavelength_nm, self.sky.wavelength_nm)

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> np.ndarray | None:
        """Of the wavelength of the field that serves each waveband."""
        return self.sky.irradiance_of_rows(self._rows(wavelength_nm))

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """A row for each wavelength of the field that a waveband takes."""
        rows = self._rows(wavelength_nm)
        self.sky.warn_of_distance(wavelength_nm, rows, self.file)
        sets, of_band = np.unique(rows, return_inverse=True)
        components = self.sky.lower_rows_in_unit(sets)
        components = patterned(self.sky, components, sun, self.sky.wavelength_nm[sets], self.file)
        notes = (self.reading, *(f"sky field: {remark}" for remark in self.sky.notes(wavelength_nm)))
        return Lowered(
            components=components,
            row_of_band=of_band.ravel(),
            notes=notes,
            options=self.options,
            table_wavelength_nm=self.sky.table_wavelength_nm(wavelength_nm),
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class MeasuredField:
    """A measured sky that sky.toml names, a table of text."""

    section: FieldSection
    sky: RadianceField
    sun: SunSection  #: where the file says that it is

    def as_sky(self, folder: str, *, per_solid_angle: bool) -> Model:
        """The measured sky as the sky of a scene."""
        if per_solid_angle:
            require_projected("solid-angle", "a measured sky")
        options = {"field": {"file": os.path.relpath(self.section.file, folder or os.curdir)}}
        made_of = "the measured sky of sky.toml"
        return Model(model=self.sky, name=FIELD, made_of=made_of, options=options, names=READ_BY)


_STOKES_KEYS = ("variable_q", "variable_u", "stokes_signs")
_NETCDF_KEYS = (*_STOKES_KEYS, "isel")


def read_sky_field(
    section: FieldSection, toml_path: str, sun: SunSection, amc_sun: SunSection
) -> SkyField | MeasuredField:
    """Read the file that `table` names; missing information is an error at a key of sky.toml (E710).

    An angle of the sun is that of `sun`, else of the file, else of amc.inp.
    """
    if os.path.splitext(section.file)[1].lower() in TABLES:
        for key in (key for key in _NETCDF_KEYS if getattr(section, key)):
            message, advice = f"{key} is for a netCDF file, and table names a table of text", "remove it"
            raise InputFileError([problem_of_key(toml_path, ("sky", key), "E710", message, advice)])
        table, of_file = measured_sky(section.file, section, sun.angles_deg, amc_sun.angles_deg)
        return MeasuredField(section=section, sky=table, sun=_sun_of_file(section, of_file))
    try:
        return read_field_file(section, sun.angles_deg, amc_sun.angles_deg)
    except FieldError as error:
        problems = []
        for one in error.problems:
            place = ("sky", one.field if getattr(section, one.field, None) else "table")
            problems.append(problem_of_key(toml_path, place, "E710", one.message, in_keys(one.advice)))
        raise InputFileError(problems) from None


def read_field_file(section: FieldSection, sun: SunAngles, other_sun: SunAngles = (None, None)) -> SkyField:
    """Read a netCDF file; FieldError for missing information."""
    with netcdf.open_netcdf(section.file, decode_times=False) as (dataset, allowed):
        chosen = choose(dataset, section)
        require_size(chosen.n_bytes, allowed, allowed, "a field")
        chosen = chosen.loaded()
    if section.stokes_signs is not None and chosen.stokes is None:
        message = "--stokes-signs (stokes_signs) are for a field of Q and U, and this one is read without"
        raise FieldError(message, argument="stokes_signs")
    made, of_file = read_field(chosen, section, grid=None, sun=sun, other_sun=other_sun)
    return SkyField(
        section=section,
        variable=str(chosen.radiance.name),
        sky=TabulatedSky(weighting=Weighting.PROJECTED, **made),
        sun=_sun_of_file(section, of_file),
    )


def in_keys(advice: str) -> str:
    """Advice in options, in the words of sky.toml: '--angle-unit deg (angle_unit=)' is the key angle_unit of [sky]."""
    for option, key in (("--sun-azimuth", "azimuth_deg of [sun]"), ("--sun-zenith", "zenith_deg of [sun]")):
        advice = advice.replace(option, key)
    advice = re.sub(r"--isel (\S+)=0", r"isel = { \1 = 0 }", advice)
    advice = re.sub(r"--coordinate (\w+)=(\S+)", r'\1 = "\2"', advice)
    return re.sub(r"--([a-z][a-z-]+)", lambda option: option[1].replace("-", "_"), advice)


def _sun_of_file(section: FieldSection, angles: SunAngles) -> SunSection:
    return SunSection(zenith_deg=angles[0], azimuth_deg=angles[1], origin=os.path.basename(section.file))
