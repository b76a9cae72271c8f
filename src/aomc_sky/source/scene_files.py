"""The files of a scene, all read before the first problem is told."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from aomc_sky.errors import InputFileError, Problem
from aomc_sky.formats.amc import AmcConfig, LightSource, read_amc
from aomc_sky.formats.difcol import DifcolTable, read_difcol
from aomc_sky.formats.lambbot import LambbotTable, read_lambbot
from aomc_sky.formats.sky_toml import SkyToml, read_sky_toml
from aomc_sky.formats.skydist import SkyTable, read_skydist

if TYPE_CHECKING:
    from aomc_sky.skies.lobe_sky import LobeSky
    from aomc_sky.source.from_atmosphere import SceneAtmosphere

T = TypeVar("T")

ATMOSPHERE = "atmosphere"
"""The sky of a scene whose sky.toml has [atmosphere]."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneFiles:
    """What the files of a scene say; `table` and `difcol` are None where there is none.

    `sky` is the model of the diffuse sky that the caller or sky.toml names, "atmosphere" with `atmosphere`;
    `backgrounds` are the background skies at their times.
    """

    config: AmcConfig
    lambbot: LambbotTable
    table: SkyTable | None
    difcol: DifcolTable | None
    toml: SkyToml
    paths: dict[str, str]
    sky: str | None = None
    backgrounds: tuple[LobeSky, ...] = ()
    atmosphere: SceneAtmosphere | None = None

    @property
    def folder(self) -> str:
        """The folder of amc.inp."""
        return os.path.dirname(self.paths["amc"])

    @property
    def is_internal(self) -> bool:
        """Whether the light-source flag is 0."""
        return self.config.light_source is LightSource.MODEL


def read_scene_files(
    amc_path: Path, sky: str | None, lenient: bool, compat: str | None, allow_paths: Sequence[str] = ()
) -> SceneFiles:
    """Read every file that can be read before the first error is raised, so that all are reported.

    Parameters
    ----------
    amc_path : Path
        amc.inp; the others lie beside it.
    sky, lenient, compat, allow_paths
        As `aomc_sky.read_scene` has them.

    Returns
    -------
    SceneFiles

    Raises
    ------
    InputFileError
        Every problem of every file.
    """
    problems: list[Problem] = []

    def attempt(read: Callable[[], T]) -> T | None:
        try:
            return read()
        except InputFileError as error:
            problems.extend(error.problems)
            return None

    folder = amc_path.parent
    config = attempt(lambda: read_amc(amc_path, lenient=lenient))
    n = config.n_wavebands if config else None
    has_target = bool(config and config.bottom_target)
    paths = {"amc": str(amc_path), "lambbot": str(folder / "lambbot.inp")}
    lambbot = attempt(lambda: read_lambbot(paths["lambbot"], n_wavebands=n, has_target=has_target, lenient=lenient))
    toml: SkyToml | None = SkyToml()
    if compat is None and os.path.lexists(folder / "sky.toml"):  # the program knows no such file
        paths["sky_toml"] = str(folder / "sky.toml")
        toml = attempt(
            lambda: read_sky_toml(paths["sky_toml"], lenient=lenient, n_wavebands=n, allow_paths=allow_paths)
        )
    if sky is None and toml is not None:
        sky = toml.sky.model if toml.atmosphere is None else ATMOSPHERE
    table, difcol = None, None
    if config is not None and config.light_source is LightSource.FILE and sky is None:
        paths["skydist"] = str(folder / "skydist.inp")
        downgrade = frozenset({"E308"}) if compat else frozenset()
        table = attempt(lambda: read_skydist(paths["skydist"], lenient=lenient, downgrade=downgrade))
    has_difcol = compat is not None or (sky != "none" and os.path.lexists(folder / "difcol.inp"))
    if config is not None and config.light_source is LightSource.MODEL and has_difcol:
        paths["difcol"] = str(folder / "difcol.inp")
        difcol = attempt(lambda: read_difcol(paths["difcol"], n_wavebands=n, lenient=lenient))
    backgrounds: tuple[LobeSky, ...] | None = ()
    if toml is not None and toml.background:
        from aomc_sky.source.background_light import read_backgrounds

        sections = toml.background
        paths |= {f"background_{k}": one.file for k, one in enumerate(sections, start=1)}
        backgrounds = attempt(lambda: read_backgrounds(sections, paths["sky_toml"]))
    atmosphere: SceneAtmosphere | None = None
    section = None if toml is None or sky != ATMOSPHERE else toml.atmosphere
    if section is not None:
        from aomc_sky.source.from_atmosphere import read_atmosphere

        paths["atmosphere"] = section.file
        atmosphere = attempt(lambda: read_atmosphere(section, lambbot))
    if backgrounds is None or problems or config is None or lambbot is None or toml is None:
        raise InputFileError(problems)
    return SceneFiles(
        config=config,
        lambbot=lambbot,
        table=table,
        difcol=difcol,
        toml=toml,
        paths=paths,
        sky=sky,
        backgrounds=backgrounds,
        atmosphere=atmosphere,
    )
