"""Background-sky files become skies, and their lobes the light that shines at one time."""

from __future__ import annotations

import dataclasses
import itertools
import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import NOWHERE, InputFileError, Problem, UsageError
from aomc_sky.formats.report import nearest
from aomc_sky.formats.sky_toml.keys import shown_value
from aomc_sky.formats.sky_toml.sections import BackgroundSection
from aomc_sky.skies.lobes.background import BackgroundSky, background_at
from aomc_sky.skies.lobes.file.data import BackgroundFile
from aomc_sky.skies.lobes.file.file import read_background_file
from aomc_sky.skies.lobes.sky import FLOAT32_TOLERANCE, LobeSky, WeightedLobe, plain_name


def read_background(path: str | os.PathLike[str], *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """Read a background-sky file (DIRSIG BackgroundSkyData, HDF5) as a sky in absolute units.

    InputFileError: all problems of the file together. MissingExtraError: h5py is not installed.

    Parameters
    ----------
    path : str or path
        The file.
    utc_offset_h : float
        Local time less UTC: the midnight of diurnal and weekly animations. [h]

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.lobes.write_background(
    ...     "town.h5", sky.lobes.background_of_lobes({"town": town}, [550.0])
    ... )
    >>> sky.read_background("town.h5").wavelength_nm.round(3).tolist()
    [550.0]
    """
    return background_sky(read_background_file(Path(path)), utc_offset_h=utc_offset_h)


def background_sky(file: BackgroundFile, *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """The sky that a background-sky file, read or built in Python, describes."""
    return BackgroundSky(
        animations=file.animations,
        wavelength_nm=file.wavelength_nm,
        curves=file.curves,
        utc_offset_h=utc_offset_h,
        texts=file.texts,
    )


def read_backgrounds(sections: Sequence[BackgroundSection], toml_path: str) -> tuple[LobeSky, ...]:
    """Read the files of all tables, each once, and give the sky of each table at its time; `toml_path` is for messages.

    InputFileError: every problem of every file; an animation that a file does not have.
    """
    files: dict[str, BackgroundFile] = {}
    problems: list[Problem] = []
    for path in dict.fromkeys(section.file for section in sections):
        try:
            files[path] = read_background_file(path)
        except InputFileError as error:
            problems.extend(error.problems)
    for section in sections:
        if (file := files.get(section.file)) is not None:
            for message, advice in _unknown(section, file):
                problems.append(NOWHERE.problem(toml_path, "E709", message, field="animation", advice=advice))
    if problems:
        raise InputFileError(problems)
    at_their_times: dict[BackgroundSection, LobeSky] = {}
    skies: dict[tuple[Any, ...], BackgroundSky] = {}
    for section in dict.fromkeys(sections):  # many tables may take one file, at one time or another
        key = (section.file, section.animation, section.utc_offset)
        if key not in skies:
            skies[key] = _sky_of(files[section.file], section)
        at_their_times[section] = background_at(
            skies[key],
            section.time,
            interpolation=section.interpolation,  # type: ignore[arg-type]  # read by its rule
        )
    return tuple(at_their_times[section] for section in sections)


def _unknown(section: BackgroundSection, file: BackgroundFile) -> Iterator[tuple[str, str]]:
    """A message and advice for each animation that a section names and its file does not have."""
    known = ", ".join(plain_name(one) for one in file.animations)
    for name in dict.fromkeys(n for n in section.animation or () if n not in file.animations):
        best = plain_name(nearest(name, file.animations))
        message = f"{section.file} has no animation {shown_value(name)}; the nearest is {best}"
        yield message, f"it has {known if len(known) <= 200 else f'{known[:200]}...'}"


def _sky_of(file: BackgroundFile, section: BackgroundSection) -> BackgroundSky:
    if section.animation is not None:
        chosen = {name: file.animations[name] for name in section.animation if name in file.animations}
        file = dataclasses.replace(file, animations=chosen)
    return background_sky(file, utc_offset_h=section.utc_offset)


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundLight:
    """Light of backgrounds at some wavelengths. [W m-2 nm-1]"""

    #: One for each lobe that reaches the horizontal plane; `strength` is its irradiance there.
    components: tuple[Component, ...]
    horizon_loss: np.ndarray  #: (n_wl,) share of the light of all lobes that comes from below the horizon [0 to 1]
    hidden: tuple[str, ...]  #: Lobes with light of which none reaches the plane.


def background_light(
    skies: Sequence[LobeSky], wavelength_nm: np.ndarray, *, taken: Collection[str] = ()
) -> BackgroundLight:
    """Lobes as components of a scene, a row for each wavelength; `taken` are names that other components have.

    They are called as the lobes, before that ``1:`` and so on where there are several skies; letters that a table or
    netCDF cannot hold are replaced.
    """
    lobes: list[WeightedLobe] = []
    names = set(taken)
    for number, sky in enumerate(skies, start=1):
        for lobe in sky.lobes:
            name = own = plain_name(f"{number}:{lobe.name}" if len(skies) > 1 else lobe.name)
            others = itertools.count(2)
            while name in names:
                name = f"{own} ({next(others)})"
            names.add(name)
            lobes.append(dataclasses.replace(lobe, name=name))
    components = LobeSky(lobes=tuple(lobes)).lower(wavelength_nm)
    light = {lobe.name: lobe.irradiance(wavelength_nm) for lobe in lobes}
    below = {component.name: component.below_horizon for component in components}
    zero = np.zeros(wavelength_nm.size)
    sphere, lost = sum(light.values(), zero), sum((light[name] * below.get(name, 1.0) for name in light), zero)
    return BackgroundLight(
        components=components,
        horizon_loss=np.divide(lost, sphere, out=np.zeros_like(lost), where=sphere > 0),
        hidden=tuple(name for name in light if name not in below and light[name].max(initial=0.0) > 0),
    )


def read_lobes(section: BackgroundSection, wavelength_nm: Sequence[float] | None) -> tuple[LobeSky, np.ndarray]:
    """The lobes of a file at one time, and the wavelengths to show, by default those of its spectra. [nm]

    UsageError: an animation that it does not have, a wavelength outside its spectra.
    """
    file = read_background_file(Path(section.file))
    for message, advice in _unknown(section, file):
        raise UsageError(f"{message}; {advice}")
    low, high = file.wavelength_nm[0], file.wavelength_nm[-1]
    for value in wavelength_nm or ():
        if not low * (1 - FLOAT32_TOLERANCE) <= value <= high * (1 + FLOAT32_TOLERANCE):
            raise UsageError(f"--wavelength {value:g} is outside the spectra of the file, {low:g} to {high:g} nm")
    sky = background_at(
        _sky_of(file, section),
        section.time,
        interpolation=section.interpolation,  # type: ignore[arg-type]  # as above
    )
    chosen = file.wavelength_nm if wavelength_nm is None else np.array(wavelength_nm, dtype=np.float64)
    return sky, chosen
