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
from aomc_sky.errors import NOWHERE, InputFileError, Problem, SceneError, UsageError
from aomc_sky.formats.report import nearest
from aomc_sky.formats.sky_toml.keys import BackgroundSection
from aomc_sky.formats.sky_toml.rules import shown_value
from aomc_sky.skies.lobes.animation import LobeAnimation
from aomc_sky.skies.lobes.background import BackgroundSky, background_at
from aomc_sky.skies.lobes.file.data import KINDS, Animation, BackgroundFile, LobeType
from aomc_sky.skies.lobes.file.file import read_background_file
from aomc_sky.skies.lobes.horizon import mass_above_horizon
from aomc_sky.skies.lobes.lobe import rotation_matrix
from aomc_sky.skies.lobes.sky import LobeSky, WeightedLobe, plain_name

_TOLERANCE = 1e-6  # 0.400 um is 0.4000000059 in float32
_KIND = {lobe_type: kind for kind, lobe_type in KINDS.items()}


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
    >>> town = sky.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.write_background("town.h5", sky.background_of_lobes({"town": town}, [550.0]))
    >>> sky.read_background("town.h5").wavelength_nm.round(3).tolist()
    [550.0]
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
        reference=one.reference,
        reference_unix_s=float(one.time_point_s),
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
            absent = dict.fromkeys(n for n in section.animation or () if n not in file.animations)
            problems += [_absent(n, file, section.file, toml_path) for n in absent]
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


def _sky_of(file: BackgroundFile, section: BackgroundSection) -> BackgroundSky:
    if section.animation is not None:
        chosen = {name: file.animations[name] for name in section.animation if name in file.animations}
        file = dataclasses.replace(file, animations=chosen)
    return background_sky(file, utc_offset_h=section.utc_offset)


def _absent(name: str, file: BackgroundFile, path: str, said_by: str) -> Problem:
    """The problem of an animation that a file does not have."""
    known = ", ".join(plain_name(one) for one in file.animations)
    best = plain_name(nearest(name, file.animations))
    message = f"{path} has no animation {shown_value(name)}; the nearest is {best}"
    advice = f"it has {known if len(known) <= 200 else f'{known[:200]}...'}"
    return NOWHERE.problem(said_by, "E709", message, field="animation", advice=advice)


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


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeScene:
    """A background sky at one time and at some wavelengths, ready to be shown without AMC files."""

    section: BackgroundSection  #: file, time, animations
    sky: LobeSky
    wavelength_nm: np.ndarray  #: (n_wl,)

    @property
    def lobes(self) -> tuple[tuple[str, WeightedLobe], ...]:
        """Names and lobes, in their order."""
        return tuple((plain_name(lobe.name), lobe) for lobe in self.sky.lobes)

    def irradiance(self, *, above: str = "sphere") -> np.ndarray:
        """Irradiance of each lobe, (n_lobe, n_wl): `above` says which part of it counts. [W m-2 nm-1]

        "sphere": the whole lobe; "plain": its part above the horizon; "projected": that part on a horizontal plane.
        """
        rows = [lobe.irradiance(self.wavelength_nm) * self.share(lobe, above) for lobe in self.sky.lobes]
        return np.array(rows).reshape(-1, self.wavelength_nm.size)

    @property
    def horizon_loss(self) -> np.ndarray:
        """Share of the light of all lobes from below the horizon, shape (n_wl,); 0 without light. [0 to 1]"""
        sphere, above = (self.irradiance(above=part).sum(axis=0) for part in ("sphere", "plain"))
        share = np.divide(sphere - above, sphere, out=np.zeros_like(sphere), where=sphere > 0)
        return np.clip(share, 0.0, 1.0)

    def share(self, lobe: WeightedLobe, above: str) -> float:
        """Share of a lobe that counts, see `irradiance`."""
        if above == "sphere":
            return 1.0
        return float(mass_above_horizon(lobe.kind, lobe.param0, lobe.param1, lobe.quaternion, weighting=above))


def axis_of(lobe: WeightedLobe) -> tuple[float, float]:
    """Zenith angle and azimuth of the axis of a lobe. [deg; azimuth from +x towards +y, 0 to below 360]"""
    x, y, z = rotation_matrix(lobe.quaternion)[:, 2]
    return float(np.degrees(np.arctan2(np.hypot(x, y), z))), float(np.degrees(np.arctan2(y, x)) % 360.0)


def read_lobe_scene(section: BackgroundSection, wavelength_nm: Sequence[float] | None) -> LobeScene:
    """Read a background-sky file, by default at the wavelengths of its spectra. [nm]

    UsageError: an animation that it does not have, a wavelength outside its spectra.
    """
    file = read_background_file(Path(section.file))
    for name in section.animation or ():
        if name not in file.animations:
            best, listed = plain_name(nearest(name, file.animations)), ", ".join(map(plain_name, file.animations))
            raise UsageError(f"the file has no animation {name!r}; the nearest is {best}, there are: {listed}")
    low, high = file.wavelength_nm[0], file.wavelength_nm[-1]
    for value in wavelength_nm or ():
        if not low * (1 - _TOLERANCE) <= value <= high * (1 + _TOLERANCE):
            raise UsageError(f"--wavelength {value:g} is outside the spectra of the file, {low:g} to {high:g} nm")
    sky = background_at(_sky_of(file, section), section.time, interpolation=section.interpolation)
    chosen = file.wavelength_nm if wavelength_nm is None else np.array(wavelength_nm, dtype=np.float64)
    return LobeScene(section=section, sky=sky, wavelength_nm=chosen)
