"""The files of a scene, all read before the first problem is reported."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from aomc_sky.errors import InputFileError, Problem, UsageError
from aomc_sky.formats.aomc.amc import (
    AmcConfig,
    DifcolTable,
    LambbotTable,
    LightSource,
    read_amc,
    read_difcol,
    read_lambbot,
)
from aomc_sky.formats.aomc.skydist import SkyTable, read_skydist
from aomc_sky.source.read.kind import not_a_scene

if TYPE_CHECKING:
    from aomc_sky.formats.sky_toml.file import SkyToml
    from aomc_sky.skies.lobes.sky import LobeSky
    from aomc_sky.source.read.atmosphere import SceneAtmosphere
    from aomc_sky.source.read.field import SkyField
    from aomc_sky.source.read.plugin import PluginSky

P = ParamSpec("P")
T = TypeVar("T")

ATMOSPHERE = "atmosphere"
"""The sky of a scene whose sky.toml has [atmosphere]."""
FIELD = "field"
"""The sky of a scene whose sky.toml has [sky] table."""
OUR_SKIES = (None, "perez", "uniform", "none", ATMOSPHERE, FIELD)
"""Skies that no other package has; None is the sky file, or Perez."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneFiles:
    """What the files of a scene say; of a file that is not there or not asked for, None."""

    config: AmcConfig
    lambbot: LambbotTable
    table: SkyTable | None
    difcol: DifcolTable | None
    toml: SkyToml | None
    paths: dict[str, str]  #: role -> path
    sky: str | None = None  #: model of the diffuse sky that the caller or sky.toml names; "atmosphere" with one
    backgrounds: tuple[LobeSky, ...] = ()  #: the background skies at their times
    atmosphere: SceneAtmosphere | None = None
    plugin: PluginSky | None = None  #: the model of another package, where `sky` is its name
    sky_field: SkyField | None = None  #: the radiance field of [sky] table, where it is the sky

    @property
    def toml_or_empty(self) -> SkyToml:
        """sky.toml; an empty one where there is none."""
        from aomc_sky.formats.sky_toml.file import SkyToml

        return self.toml or SkyToml()

    @property
    def folder(self) -> str:
        """The folder of amc.inp."""
        return os.path.dirname(self.paths["amc"])

    @property
    def is_internal(self) -> bool:
        """Whether the light-source flag is 0."""
        return self.config.light_source is LightSource.MODEL


def read_scene_files(
    amc_path: Path,
    sky: str | None,
    lenient: bool,
    compat: str | None,
    allow_paths: Sequence[str] = (),
    max_memory_bytes: int | None = None,
    sky_options: Mapping[str, Any] | None = None,
) -> SceneFiles:
    """Read amc.inp and the files beside it: all that can be read before the first error, so that all are reported."""
    reading = _Reading(folder=amc_path.parent, lenient=lenient, compat=compat, max_memory_bytes=max_memory_bytes)
    config = reading.attempt(read_amc, amc_path, lenient=lenient)
    n = config.n_wavebands if config else None
    has_target = bool(config and config.bottom_target)
    reading.paths["amc"] = str(amc_path)
    path = reading.beside("lambbot")
    lambbot = reading.attempt(read_lambbot, path, n_wavebands=n, has_target=has_target, lenient=lenient)
    n_problems = len(reading.problems)
    toml = reading.toml(n, allow_paths)
    is_sure = len(reading.problems) == n_problems
    if sky is None and toml is not None:
        of_section = toml.sky.model if toml.sky.table is None else FIELD
        sky = of_section if toml.atmosphere is None else ATMOSPHERE
    table = reading.table(config, sky, is_sure=is_sure)
    difcol = reading.difcol(config, sky)
    backgrounds = reading.backgrounds(toml)
    atmosphere = reading.atmosphere(toml, sky, lambbot, allow_paths)
    plugin = reading.plugin(toml, sky, sky_options or {})
    sky_field = reading.sky_field(toml, sky)
    if config is None and (mistaken := not_a_scene(amc_path)):
        raise mistaken
    if reading.problems or config is None or lambbot is None:
        raise InputFileError(reading.problems)
    return SceneFiles(
        config=config,
        lambbot=lambbot,
        table=table,
        difcol=difcol,
        toml=toml,
        paths=reading.paths,
        sky=sky,
        backgrounds=backgrounds,
        atmosphere=atmosphere,
        plugin=plugin,
        sky_field=sky_field,
    )


@dataclass(kw_only=True, slots=True)
class _Reading:
    """The files of a folder that were read so far, and what was wrong with them."""

    folder: Path
    lenient: bool
    compat: str | None
    max_memory_bytes: int | None = None
    paths: dict[str, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def attempt(self, read: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
        """What `read` gives; None where it finds problems, which are kept."""
        try:
            return read(*args, **kwargs)
        except InputFileError as error:
            self.problems.extend(error.problems)
            return None

    def beside(self, role: str, name: str = "") -> str:
        """Path of a file beside amc.inp, noted under its role."""
        self.paths[role] = str(self.folder / (name or f"{role}.inp"))
        return self.paths[role]

    def has(self, name: str) -> bool:
        """Whether such a file lies beside amc.inp."""
        return os.path.lexists(self.folder / name)

    def toml(self, n_wavebands: int | None, allow_paths: Sequence[str]) -> SkyToml | None:
        """sky.toml; None where there is none, or a broken one."""
        if self.compat is not None or not self.has("sky.toml"):  # the program knows no such file
            return None
        from aomc_sky.formats.sky_toml.file import read_sky_toml

        path = self.beside("sky_toml", "sky.toml")
        return self.attempt(read_sky_toml, path, n_wavebands=n_wavebands, allow_paths=allow_paths)

    def table(self, config: AmcConfig | None, sky: str | None, *, is_sure: bool) -> SkyTable | None:
        """skydist.inp, where the light comes from it; a sky.toml that cannot be read leaves this unsure."""
        if config is None or config.light_source is not LightSource.FILE or sky is not None:
            return None
        if not is_sure and not self.has("skydist.inp"):
            return None
        path = self.beside("skydist")
        downgrade = frozenset({"E308"}) if self.compat else frozenset()
        return self.attempt(
            read_skydist, path, downgrade=downgrade, lenient=self.lenient, max_memory_bytes=self.max_memory_bytes
        )

    def difcol(self, config: AmcConfig | None, sky: str | None) -> DifcolTable | None:
        """difcol.inp, where there is one and the scene has a sun."""
        is_there = self.compat is not None or (sky != "none" and self.has("difcol.inp"))
        if config is None or config.light_source is not LightSource.MODEL or not is_there:
            return None
        path = self.beside("difcol")
        return self.attempt(read_difcol, path, n_wavebands=config.n_wavebands)

    def backgrounds(self, toml: SkyToml | None) -> tuple[LobeSky, ...]:
        """The background skies that sky.toml names, at their times."""
        if toml is None or not toml.background:
            return ()
        from aomc_sky.skies.lobes.light import read_backgrounds

        sections = toml.background
        self.paths |= {f"background_{k}": one.file for k, one in enumerate(sections, start=1)}
        return self.attempt(read_backgrounds, sections, self.paths["sky_toml"]) or ()

    def atmosphere(
        self, toml: SkyToml | None, sky: str | None, lambbot: LambbotTable | None, allow_paths: Sequence[str]
    ) -> SceneAtmosphere | None:
        """The atmosphere that sky.toml names, where it is the sky."""
        section = None if toml is None or sky != ATMOSPHERE else toml.atmosphere
        if section is None:
            return None
        from aomc_sky.source.read.atmosphere import read_atmosphere

        self.paths["atmosphere"] = section.file
        return self.attempt(read_atmosphere, section, lambbot, allow_paths)

    def plugin(self, toml: SkyToml | None, sky: str | None, given: Mapping[str, Any]) -> PluginSky | None:
        """The sky model of another package with its options; None where the sky is one of ours."""
        if sky in OUR_SKIES or sky is None:
            if given:
                what = "no --sky NAME and no [sky] model names one" if sky is None else f"this sky is {sky!r}"
                raise UsageError(f"sky options ({', '.join(given)}) are for a sky model of another package; {what}")
            return None
        from aomc_sky.formats.sky_toml.keys import SkySection
        from aomc_sky.source.read.plugin import choose_plugin

        section = SkySection() if toml is None else toml.sky
        return self.attempt(choose_plugin, sky, section, given, self.paths.get("sky_toml", ""))

    def sky_field(self, toml: SkyToml | None, sky: str | None) -> SkyField | None:
        """The radiance field that sky.toml names, where it is the sky."""
        section = None if toml is None or sky != FIELD else toml.sky.table
        if section is None:
            return None
        from aomc_sky.source.read.field import read_sky_field

        self.paths["table"] = section.file
        return self.attempt(read_sky_field, section, self.paths["sky_toml"])
