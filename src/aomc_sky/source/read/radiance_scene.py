"""The scene of radiances that are named alone: a measured sky, or a radiance field."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from aomc_sky.errors import FieldError, InputFileError, InputWarning, SceneError, UsageError
from aomc_sky.formats.netcdf import lights_beside
from aomc_sky.formats.sky_toml.sections import FieldSection, SunSection
from aomc_sky.formats.text_file import refuse
from aomc_sky.options import say
from aomc_sky.source.light.said import Said, Speakers, sun_said
from aomc_sky.source.light.skies import Model, Sky
from aomc_sky.source.read.field import READ_BY, read_field_file
from aomc_sky.source.read.measured import measured_sky
from aomc_sky.source.scene import Scene
from aomc_sky.source.weather_scene import scene_of_sky
from aomc_sky.wavebands import Wavebands, listed_bands, only_bands


def measured_scene(
    section: FieldSection,
    callers: Speakers,
    *,
    iterations: int | None = None,
    wavelength_nm: Sequence[float] | None = None,
    wavebands: Sequence[int] | None = None,
) -> Scene:
    """A scene of a measured sky, at its own wavelengths by default, and of the beam that a caller asks for."""
    path = section.file
    sky, of_file = measured_sky(path, section, sun_said(callers).angles_deg)
    on_file = SunSection(zenith_deg=of_file[0], azimuth_deg=of_file[1], origin="measured sky")
    found = Model(model=sky, name="RadianceField", made_of="the measured sky", is_whole=True, names=READ_BY)
    asked_nm = sky.wavelength_nm if wavelength_nm is None else wavelength_nm
    options = {name: value for name, value in dataclasses.asdict(section).items() if value and name != "file"}
    return _scene_of_table(path, found, _with_sun(callers, on_file), options, asked_nm, iterations, wavebands)


def field_scene(
    section: FieldSection,
    callers: Speakers,
    *,
    iterations: int | None = None,
    wavelength_nm: Sequence[float] | None = None,
    wavebands: Sequence[int] | None = None,
) -> Scene:
    """A scene of the radiance field of a netCDF file, and of the beam that a caller asks for."""
    path = section.file
    try:
        field = read_field_file(section, sun_said(callers).angles_deg)
    except FieldError as error:
        problems = [dataclasses.replace(one, path=path, code="E710", field="") for one in error.problems]
        raise InputFileError(problems) from None
    except SceneError as error:
        raise refuse(path, str(error), code="E710") from None
    speakers = _with_sun(callers, field.sun)
    if wavelength_nm is None and not field.sky.has_wavelength:
        raise UsageError(f"{path} has no wavelengths: write --wavelengths 412 443 555")
    asks = any(one.perez.has_amounts or one.perez.spectrum or one.diffuse_only for one in callers)
    if not asks and (beside := lights_beside(path)):
        text = (
            f"the radiances of {os.path.basename(path)} are not all of its light, and the rest is missing "
            f"({', '.join(beside)}); for a beam of the sun write two of {{dni}}, {{dhi}} and {{ghi}} and where the sun "
            "is, for the sky alone {diffuse_only:True}"
        )
        warnings.warn(say(text), InputWarning, stacklevel=3)
    found = field.as_sky(os.path.dirname(path), per_solid_angle=False)
    found = dataclasses.replace(found, is_whole=True, made_of="the radiance field")
    asked_nm = field.sky.wavelength_nm if wavelength_nm is None else wavelength_nm
    return _scene_of_table(path, found, speakers, {}, asked_nm, iterations, wavebands)


def _with_sun(callers: Speakers, of_file: SunSection) -> Speakers:
    """The caller, and the sun that a file states, if it is up: twilight has no beam, and its light is in the file."""
    is_up = of_file.zenith_deg is None or of_file.zenith_deg < _HORIZON_DEG
    return (*callers, Said(sun=of_file, is_file=True)) if is_up else callers


_HORIZON_DEG = 90.0


def _scene_of_table(
    path: str | os.PathLike[str],
    sky: Sky,
    speakers: Speakers,
    options: dict[str, Any],
    wavelength_nm: Sequence[float] | np.ndarray,
    iterations: int | None,
    wavebands: Sequence[int] | None,
) -> Scene:
    bands = Wavebands(wavelength_nm=np.asarray(wavelength_nm, float))
    sun = sun_said(speakers)  # the one by which the sky was read, unless a beam has it
    angles = {"zenith_deg": sun.zenith_deg, "azimuth_deg": sun.azimuth_deg}
    if None not in angles.values():
        options = {**options, "sun": {**angles, "disc": False, "from": sun.origin}}
    photons = np.full(bands.n_bands, 10**6 if iterations is None else iterations)
    return scene_of_sky(
        sky,
        speakers,
        bands,
        only_bands(photons, wavebands, bands.wavelength_nm),
        input_files={"radiance": os.fspath(path)},
        options={**options, "wavebands": listed_bands(wavebands)},
    )
