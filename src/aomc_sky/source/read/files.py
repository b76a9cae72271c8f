"""The files of a scene, all read before the first problem is reported."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

from aomc_sky.errors import InputFileError, Problem, SceneError, UsageError, require_one_of
from aomc_sky.formats.aomc.amc import (
    AmcConfig,
    DifcolTable,
    LightSource,
    read_amc,
    read_difcol,
    read_lambbot,
)
from aomc_sky.formats.aomc.skydist import BinsWord, SkyTable, read_skydist
from aomc_sky.formats.sky_toml.sections import SkySection, SkyToml, SunSection
from aomc_sky.plan.allocation import MAX_PHOTONS
from aomc_sky.source.light.said import Speakers, sun_said
from aomc_sky.source.light.skies import FIELD, require_sky_name
from aomc_sky.source.read.kind import not_a_scene
from aomc_sky.wavebands import Wavebands
from aomc_sky.whole_number import as_number_of

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky
    from aomc_sky.skies.tabulated import WeightingWord
    from aomc_sky.source.light.plugin import PluginSky
    from aomc_sky.source.read.atmosphere import SceneAtmosphere
    from aomc_sky.source.read.field import MeasuredField, SkyField

T = TypeVar("T")

ATMOSPHERE = "atmosphere"
"""The sky of a scene whose sky.toml has [atmosphere]."""
GIVEN = "given"
"""The sky of a scene whose caller gives a model or a function."""
COMPAT_NAME = "--compat aomc"
CompatWord = Literal["aomc"]
AzimuthBinsWord = Literal["n+1", "n"]
OUR_SKIES = (None, "perez", "uniform", "none", ATMOSPHERE, FIELD, GIVEN)
"""Skies that no other package has; None is the sky file, or Perez."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Reading:
    """How the files are read: the arguments of `read_scene` beside those of the light."""

    iterations: int | None = None
    sky: Any = None
    bins: BinsWord | None = None
    weighting: WeightingWord | None = None
    compat: CompatWord | None = None
    lenient: bool = False
    azimuth_bins: AzimuthBinsWord = "n+1"
    wavebands: Sequence[int] | None = None
    sky_options: Mapping[str, Any] = field(default_factory=dict)
    allow_paths: Sequence[str | os.PathLike[str]] = ()
    max_memory_bytes: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The inputs that only some skies use."""
        given = (
            ("bins", self.bins, None),
            ("weighting", self.weighting, None),
            ("azimuth_bins", self.azimuth_bins, "n+1"),
        )
        return tuple(name for name, value, default in given if value != default)

    def check(self) -> None:
        """Raise for a word that is not allowed, and for one that contradicts `compat`."""
        allowed = {
            "bins": get_args(BinsWord),
            "weighting": ("listed", "projected", "solid-angle", "aomc"),
            "compat": get_args(CompatWord),
            "azimuth_bins": get_args(AzimuthBinsWord),
        }
        for name, words in allowed.items():
            if getattr(self, name) is not None:
                require_one_of(words, getattr(self, name), name)
        if isinstance(self.sky, str):
            require_sky_name(self.sky)
        if self.compat is not None:
            kept = {"bins": ("degrees",), "weighting": ("aomc",), "sky": ("uniform",), "azimuth_bins": ("n+1",)}
            for name, words in kept.items():
                value = getattr(self, name)
                if value is not None and value not in words:
                    raise UsageError(f"{COMPAT_NAME} means {name} {words[0]!r}, which contradicts {value!r}")


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneFiles:
    """Contents of the files of a scene. A file that is absent or not needed is None."""

    config: AmcConfig
    bands: Wavebands  #: of lambbot.inp
    table: SkyTable | None
    difcol: DifcolTable | None
    toml: SkyToml  #: an empty one where there is none
    paths: dict[str, str]  #: role -> path
    sky: str | None = None  #: model of the diffuse sky that the caller or sky.toml names; "atmosphere" with one
    backgrounds: tuple[LobeSky, ...] = ()  #: the background skies at their times
    atmosphere: SceneAtmosphere | None = None
    plugin: PluginSky | None = None  #: the model of another package, where `sky` is its name
    sky_field: SkyField | MeasuredField | None = None  #: the radiance field of [sky] table, where it is the sky

    @property
    def folder(self) -> str:
        """The folder of amc.inp."""
        return os.path.dirname(self.paths["amc"])


def sun_of(config: AmcConfig) -> SunSection:
    """The sun of amc.inp."""
    zenith, azimuth = float(config.direct_zenith_deg), float(config.direct_azimuth_deg)
    return SunSection(zenith_deg=zenith, azimuth_deg=azimuth, origin="amc.inp")


def read_scene_files(path: str | os.PathLike[str], callers: Speakers, reading: Reading) -> SceneFiles:
    """Read amc.inp, or that of a folder, and the files beside it, and report the problems of all of them together."""
    reading.check()
    amc_path = Path(path) / "amc.inp" if Path(path).is_dir() else Path(path)
    sky = reading.sky if reading.sky is None or isinstance(reading.sky, str) else GIVEN
    lenient, compat, allow_paths = reading.lenient, reading.compat, [os.fspath(one) for one in reading.allow_paths]
    folder = _Folder(path=amc_path.parent)
    config = folder.attempt(read_amc, amc_path, lenient=lenient)
    n = config.n_wavebands if config else None
    light = config.light_source if config else None
    has_target = bool(config and config.bottom_target)
    folder.paths["amc"] = str(amc_path)
    lambbot_path = folder.beside("lambbot")
    lambbot = folder.attempt(read_lambbot, lambbot_path, n_wavebands=n, has_target=has_target, lenient=lenient)
    n_problems = len(folder.problems)
    toml = folder.toml(n, allow_paths) if compat is None else None  # the program knows no such file
    is_sure = len(folder.problems) == n_problems
    if sky is None and toml is not None:
        named_model = toml.sky.model if toml.sky.table is None else FIELD
        sky = named_model if toml.atmosphere is None else ATMOSPHERE
    table = difcol = None
    if light is LightSource.FILE and sky is None and (is_sure or folder.has("skydist.inp")):
        how = {"lenient": lenient, "max_memory_bytes": reading.max_memory_bytes}
        downgrade = frozenset({"E308"}) if compat else frozenset()
        table = folder.attempt(read_skydist, folder.beside("skydist"), downgrade=downgrade, **how)
    if light is LightSource.MODEL and (compat is not None or (sky != "none" and folder.has("difcol.inp"))):
        difcol = folder.attempt(read_difcol, folder.beside("difcol"), n_wavebands=n, lenient=lenient)
    toml_files = {}
    if toml is not None:
        suns = sun_said(callers).over(toml.sun), SunSection() if config is None else sun_of(config)
        toml_files = folder.named_files(toml, sky, lambbot, allow_paths, suns)
    plugin = folder.plugin(toml, sky, reading.sky_options)
    if config is None and (mistaken := not_a_scene(amc_path)):
        raise mistaken
    if folder.problems or config is None or lambbot is None:
        raise InputFileError(folder.problems)
    if reading.iterations is not None:
        iterations = as_number_of(reading.iterations, "iterations", 1, MAX_PHOTONS, error=SceneError)
        config = dataclasses.replace(config, iterations=iterations)
    return SceneFiles(
        config=config,
        bands=lambbot,
        table=table,
        difcol=difcol,
        toml=toml or SkyToml(),
        paths=folder.paths,
        sky=sky,
        plugin=plugin,
        **toml_files,
    )


@dataclass(kw_only=True, slots=True)
class _Folder:
    """The files of a folder that were read, and their problems."""

    path: Path
    paths: dict[str, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def attempt(self, read: Callable[..., T], *args: Any, **kwargs: Any) -> T | None:
        """The result of `read`, or None with its problems kept."""
        try:
            return read(*args, **kwargs)
        except InputFileError as error:
            self.problems.extend(error.problems)
            return None

    def beside(self, role: str, name: str = "") -> str:
        """Path of a file beside amc.inp, noted under its role."""
        self.paths[role] = str(self.path / (name or f"{role}.inp"))
        return self.paths[role]

    def has(self, name: str) -> bool:
        """Whether such a file lies beside amc.inp."""
        return os.path.lexists(self.path / name)

    def toml(self, n_wavebands: int | None, allow_paths: Sequence[str]) -> SkyToml | None:
        """sky.toml, or None if it is absent or broken."""
        if not self.has("sky.toml"):
            return None
        from aomc_sky.formats.sky_toml.file import read_sky_toml

        path = self.beside("sky_toml", "sky.toml")
        return self.attempt(read_sky_toml, path, n_wavebands=n_wavebands, allow_paths=allow_paths)

    def named_files(
        self,
        toml: SkyToml,
        sky: str | None,
        lambbot: Wavebands | None,
        allow_paths: Sequence[str],
        suns: tuple[SunSection, SunSection],
    ) -> dict[str, Any]:
        """Background skies, and the atmosphere or radiance field if it is the sky."""
        found: dict[str, Any] = {}
        if toml.background:
            from aomc_sky.skies.lobes.light import read_backgrounds

            self.paths |= {f"background_{k}": one.file for k, one in enumerate(toml.background, start=1)}
            found["backgrounds"] = self.attempt(read_backgrounds, toml.background, self.paths["sky_toml"]) or ()
        if sky == ATMOSPHERE and toml.atmosphere is not None:
            from aomc_sky.source.read.atmosphere import read_atmosphere

            self.paths["atmosphere"] = toml.atmosphere.file
            found["atmosphere"] = self.attempt(read_atmosphere, toml.atmosphere, lambbot, allow_paths)
        if sky == FIELD and toml.sky.table is not None:
            from aomc_sky.formats.sky_toml.file import problem_of_key
            from aomc_sky.source.read.field import read_sky_field

            self.paths["table"] = toml.sky.table.file
            made = self.attempt(read_sky_field, toml.sky.table, self.paths["sky_toml"], *suns)
            found["sky_field"] = made
            if toml.sky.polarisation is not None and getattr(made and made.sky, "values_q", None) is not None:
                key, message = ("sky", "polarisation"), "polarisation with a table that has Q and U of its own"
                advice = "remove it, or name the radiance alone below [sky]: variable"
                self.problems.append(problem_of_key(self.paths["sky_toml"], key, "E705", message, advice))
        return found

    def plugin(self, toml: SkyToml | None, sky: str | None, given: Mapping[str, Any]) -> PluginSky | None:
        """The sky model of another package with its options, or None for a sky of ours."""
        if sky in OUR_SKIES or sky is None:
            if given:
                what = "no --sky NAME and no [sky] model names one" if sky is None else f"this sky is {sky!r}"
                what = "give a model of Python its own" if sky == GIVEN else what
                raise UsageError(f"sky options ({', '.join(given)}) are for a sky model of another package; {what}")
            return None
        from aomc_sky.source.light.plugin import choose_plugin, plain_option

        options = {name: plain_option(name, value) for name, value in given.items()}
        section = SkySection() if toml is None else toml.sky
        return self.attempt(choose_plugin, sky, section, options, self.paths.get("sky_toml", ""))
