"""Background-sky files become skies, and their lobes the light that shines at one time."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import InputFileError, Problem, SceneError
from aomc_sky.formats.background.data import KINDS, Animation, BackgroundFile, LobeType
from aomc_sky.formats.background.file import read_background_file
from aomc_sky.formats.report import nearest
from aomc_sky.formats.sky_toml.keys import BackgroundSection
from aomc_sky.formats.sky_toml.rules import shown_value
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference
from aomc_sky.skies.lobes.background import BackgroundSky, background_at
from aomc_sky.skies.lobes.horizon import mass_above_horizon
from aomc_sky.skies.lobes.sky import LobeSky, WeightedLobe, plain_name

_KIND = {lobe_type: kind for kind, lobe_type in KINDS.items()}


def read_background(path: str | os.PathLike[str], *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """Read a background-sky file (DIRSIG BackgroundSkyData, HDF5) as a sky.

    Parameters
    ----------
    path : str or path
        The file.
    utc_offset_h : float
        Local time less UTC: where the midnight of diurnal and weekly animations lies. [h]

    Returns
    -------
    BackgroundSky
        Its animations, in absolute units.

    Raises
    ------
    InputFileError
        Everything that is wrong with the file, together.
    MissingExtraError
        h5py is not installed.
    SceneError
        The UTC offset is not finite.
    """
    return background_sky(read_background_file(Path(path)), utc_offset_h=utc_offset_h)


def background_sky(file: BackgroundFile, *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """The sky that a background-sky file, read or built in Python, describes."""
    return BackgroundSky(
        animations={name: _animation(one) for name, one in file.animations.items()},
        wavelength_nm=file.wavelength_nm,
        curves=file.curves,
        utc_offset_h=utc_offset_h,
    )


def _animation(one: Animation) -> LobeAnimation:
    return LobeAnimation(
        kind=tuple(_KIND[LobeType(kind)] for kind in one.lobe_type.tolist()),
        param0=one.param0,
        param1=one.param1,
        coefficient=one.coefficient,
        quaternion=one.quaternion,
        curve=one.curve_index,
        time_days=one.relative_time_days,
        reference=Reference[one.reference.name],
        reference_unix_s=float(one.time_point_s),
    )


def read_backgrounds(sections: Sequence[BackgroundSection], toml_path: str) -> tuple[LobeSky, ...]:
    """Read the files of all tables, each once, and give the sky of each table at its time; `toml_path` is for messages.

    InputFileError: every problem of every file; an animation that a file does not have.
    """
    files, problems = _read([section.file for section in sections])
    for section in sections:
        file = files.get(section.file)
        absent = [n for n in section.animation or () if file is not None and n not in file.animations]
        problems += [_absent(n, file, section.file, toml_path) for n in dict.fromkeys(absent) if file is not None]
    if problems:
        raise InputFileError(problems)
    at_their_times: dict[BackgroundSection, LobeSky] = {}
    skies: dict[tuple[Any, ...], BackgroundSky] = {}
    for section in dict.fromkeys(sections):  # many tables may take one file, at one time or another
        key = (section.file, section.animation, section.utc_offset)
        if key not in skies:
            skies[key] = _sky_of(files[section.file], section)
        at_their_times[section] = background_at(skies[key], section.time, interpolation=section.interpolation)
    return tuple(at_their_times[section] for section in sections)


def read_background_files(paths: Sequence[str]) -> dict[str, BackgroundFile]:
    """Read background-sky files, each once, by their paths; the error has every problem of every file."""
    files, problems = _read(paths)
    if problems:
        raise InputFileError(problems)
    return files


def _read(paths: Sequence[str]) -> tuple[dict[str, BackgroundFile], list[Problem]]:
    files: dict[str, BackgroundFile] = {}
    problems: list[Problem] = []
    for path in dict.fromkeys(paths):
        try:
            files[path] = read_background_file(Path(path))
        except InputFileError as error:
            problems.extend(error.problems)
    return files, problems


def sky_at(file: BackgroundFile, section: BackgroundSection) -> LobeSky:
    """The sky of a file at a time, with the animations that are named, as far as the file has them."""
    return background_at(_sky_of(file, section), section.time, interpolation=section.interpolation)


def _sky_of(file: BackgroundFile, section: BackgroundSection) -> BackgroundSky:
    if section.animation is not None:
        chosen = {name: file.animations[name] for name in section.animation if name in file.animations}
        file = dataclasses.replace(file, animations=chosen)
    return background_sky(file, utc_offset_h=section.utc_offset)


def _absent(name: str, file: BackgroundFile, path: str, said_by: str) -> Problem:
    """The problem of an animation that a file does not have."""
    known = ", ".join(plain_name(one) for one in file.animations)
    best = plain_name(nearest(name, file.animations))
    return Problem(
        path=said_by,
        line=0,
        column=0,
        code="E709",
        field="animation",
        message=f"{path} has no animation {shown_value(name)}; the nearest is {best}",
        advice=f"it has {known if len(known) <= 200 else f'{known[:200]}...'}",
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundLight:
    """Light of backgrounds at some wavelengths. [W m-2 nm-1]"""

    #: one for each lobe that reaches the horizontal plane; `strength` is its irradiance there
    components: tuple[Component, ...]
    sphere: np.ndarray  #: (n_wl,) irradiance of all lobes integrated over the sphere
    lost: np.ndarray  #: (n_wl,) the part of it that comes from below the horizon
    hidden: tuple[str, ...]  #: lobes with light of which none reaches the plane

    @property
    def horizon_loss(self) -> np.ndarray:
        """Share of the light that comes from below the horizon, shape (n_wl,). [0 to 1]"""
        return np.divide(self.lost, self.sphere, out=np.zeros_like(self.lost), where=self.sphere > 0)


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
            name = _free(plain_name(f"{number}:{lobe.name}" if len(skies) > 1 else lobe.name), names)
            names.add(name)
            lobes.append(dataclasses.replace(lobe, name=name))
    components = LobeSky(lobes=tuple(lobes)).lower(wavelength_nm)
    light = {lobe.name: lobe.irradiance(wavelength_nm) for lobe in lobes}
    lost = [light[lobe.name] * (1.0 - _above(lobe)) for lobe in lobes]
    shown = {component.name for component in components}
    zero = np.zeros(wavelength_nm.size)
    return BackgroundLight(
        components=components,
        sphere=sum(light.values(), zero),
        lost=sum(lost, zero),
        hidden=tuple(name for name in light if name not in shown and light[name].max(initial=0.0) > 0),
    )


def _above(lobe: WeightedLobe) -> float:
    """Share of a lobe above the horizon."""
    return _mass_above(lobe.kind, float(lobe.param0), float(lobe.param1), tuple(map(float, lobe.quaternion)))


@lru_cache(maxsize=4096)  # the same lobe of one file at many times
def _mass_above(kind: str, param0: float, param1: float, quaternion: tuple[float, ...]) -> float:
    return min(float(mass_above_horizon(kind, param0, param1, quaternion)), 1.0)


def _free(name: str, taken: Collection[str]) -> str:
    """The name, or the name with a number that no other has."""
    candidate, number = name, 2
    while candidate in taken:
        candidate, number = f"{name} ({number})", number + 1
    return candidate


def refuse_darkness(light: BackgroundLight) -> None:
    """Raise where the backgrounds are the only source and nothing of them reaches the horizontal plane."""
    if not light.components:
        reason = "all their lobes lie below the horizon" if light.hidden else "their lobes have no light at that time"
        raise SceneError(f"the backgrounds are the only source of light, but {reason}")
