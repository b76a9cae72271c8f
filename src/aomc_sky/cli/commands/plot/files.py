"""What ``aomc-sky plot`` draws of each kind of path, and where it writes it."""

from __future__ import annotations

import argparse
import enum
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from aomc_sky.cli import options as cli_options
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.outputs.folder.target_file import check_target
from aomc_sky.outputs.picture import MOVING_SUFFIX, picture_path, save_picture

if TYPE_CHECKING:
    from aomc_sky.pictures.content import Picture
    from aomc_sky.verify.report import Pulls

_SIZE_PX, _FRAMES = 960, 48


class Kind(enum.Enum):
    """What a path is."""

    SCENE = "a scene"
    RUN = "a run"
    BACKGROUND = "a background sky"
    ATMOSPHERE = "an atmosphere"
    TABLE = "a sky file"
    NETCDF = "a netCDF file"


_READING = ("iterations", "sky", "dni", "dhi", "ghi", "epsilon", "delta", "coefficients", "spectrum", "disc", "within",
            "limits", "air_mass", "extraterrestrial")  # fmt: skip
_ATMOSPHERE = ("sun_zenith", "sun_azimuth", "moon_zenith", "moon_zenith_offset", "moon_azimuth", "moon_azimuth_offset",
               "moon_distance", "ground_luminance", "allow_path")  # fmt: skip
_TIMES = ("time", "start", "stop", "frames", "animation", "utc_offset", "interpolation")

_BELONGS: dict[str, tuple[Kind, ...]] = {
    "show": (Kind.SCENE, Kind.RUN),
    "pull": (Kind.RUN,),
    "row": (Kind.RUN,),
    "seed": (Kind.SCENE,),
    "waveband": (Kind.SCENE, Kind.RUN, Kind.TABLE, Kind.NETCDF),
    "wavelength": (Kind.BACKGROUND, Kind.ATMOSPHERE),
    **dict.fromkeys(_TIMES, (Kind.BACKGROUND,)),
    **dict.fromkeys(_READING, (Kind.SCENE,)),
    **dict.fromkeys(_ATMOSPHERE, (Kind.SCENE, Kind.ATMOSPHERE)),
    **dict.fromkeys(("bins", "weighting", "azimuth_bins", "compat", "lenient"), (Kind.SCENE, Kind.TABLE)),
}
"""The kinds of paths that an option says something about."""

_DEFAULTS = {
    "azimuth_bins": "n+1", "interpolation": "crossfade", "utc_offset": 0.0, "seed": 0, "pull": False, "lenient": False,
    "allow_path": [],
}  # fmt: skip
"""Of options that are not None when nobody gives them."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Drawn:
    """What was drawn."""

    path: Path
    kind: Kind
    picture: Picture  #: its domes; of an animation all frames
    n_panels: int  #: how many there would be if all were shown
    maps: tuple[Pulls, ...] = ()  #: of a picture of pulls: all of them, shown or not


def kind_of(arguments: argparse.Namespace) -> Kind:
    """What the path is, by what a folder holds and by the name of a file."""
    path = Path(arguments.path)
    if path.is_dir() and ((path / "manifest.json").exists() or (path / "plan.npz").exists()):
        return Kind.RUN
    name = path.name.lower()
    endings = {(".h5", ".hdf5"): Kind.BACKGROUND, (".atmo",): Kind.ATMOSPHERE, (".nc",): Kind.NETCDF}
    found = next((kind for ending, kind in endings.items() if name.endswith(ending)), None)
    return found or (Kind.TABLE if name.startswith("skydist") and not path.is_dir() else Kind.SCENE)


def refuse_idle_options(arguments: argparse.Namespace, kind: Kind) -> None:
    """Raise for options that say nothing about this kind of path."""
    given = [name for name in _BELONGS if getattr(arguments, name) != _DEFAULTS.get(name)]
    for name in given:
        if kind not in _BELONGS[name]:
            others = " or ".join(k.value for k in _BELONGS[name])
            raise UsageError(f"--{name.replace('_', '-')} is for {others}; {arguments.path} is {kind.value}")
    if arguments.pull and arguments.show:
        raise UsageError("--pull and --show are two pictures; make them one after the other")
    if arguments.pull and arguments.row is not None:
        raise UsageError("the hours of a year store no photons, so they have no pulls; leave --pull out")


def draw(arguments: argparse.Namespace, kind: Kind) -> Drawn:
    """Draw and write the picture."""
    from aomc_sky.pictures.drawing.dome import View
    from aomc_sky.pictures.drawing.panels import figure_of

    optional_module("matplotlib", extra="plot")
    target = _target(arguments, kind)
    check_target(target, "--out", force=arguments.force, inputs=[arguments.path])
    if target.suffix.lower() == MOVING_SUFFIX:
        return _animation(arguments, target)
    maps = _pulls(arguments) if arguments.pull else ()
    picture, n_panels = _pull_picture(arguments, maps) if maps else _PICTURES[kind](arguments)
    size, view = arguments.size or _SIZE_PX, View.named(arguments.seen_from)
    figure = figure_of(picture, size_px=size, view=view, limits=arguments.range)
    save_picture(figure, target, dpi=figure.dpi)
    return Drawn(path=target, kind=kind, picture=picture, n_panels=n_panels, maps=maps)


def _target(arguments: argparse.Namespace, kind: Kind) -> Path:
    """Where the picture goes; a wrong name is told before the work."""
    is_moving = kind is Kind.BACKGROUND and arguments.time is None
    if arguments.out == "":
        raise UsageError("--out is empty; name a file, for example sky.png")
    if arguments.out is not None:
        return picture_path(arguments.out, may_move=is_moving)
    path = Path(os.path.abspath(arguments.path))
    name = path.name if path.is_dir() else path.stem
    return path.with_name(f"{name}{'-pull' if arguments.pull else ''}{MOVING_SUFFIX if is_moving else '.png'}")


def _title(arguments: argparse.Namespace, text: str) -> str:
    return text if arguments.title is None else str(arguments.title)


def _name(arguments: argparse.Namespace) -> str:
    """What a person calls the path: a scene by its folder."""
    path = Path(os.path.abspath(arguments.path))
    return path.parent.name if path.name == "amc.inp" else path.name


def _bands(arguments: argparse.Namespace, n_bands: int) -> list[int] | None:
    """The wavebands that were named, from 0."""
    if not arguments.waveband:
        return None
    for waveband in arguments.waveband:
        if not 1 <= waveband <= n_bands:
            raise UsageError(f"there is no waveband {waveband}; there are {n_bands}, from 1")
    return [waveband - 1 for waveband in dict.fromkeys(arguments.waveband)]


def _scene(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.pictures.domes.source import source_picture
    from aomc_sky.pictures.plot import scene_sun_deg

    scene = cli_options.scene_of(arguments, arguments.path, wavebands=arguments.waveband)
    bands = _bands(arguments, scene.wavebands.n_bands)
    title = _title(arguments, f"{_name(arguments)}: the source")
    source, sun = scene.source(arguments.seed, max_memory_bytes=arguments.max_memory), scene_sun_deg(scene.options)
    picture = source_picture(source, show=arguments.show or "radiance", bands=bands, sun_deg=sun, title=title)
    return picture, len(bands or range(source.n_bands))


def _run(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.pictures.domes.source import source_picture, spaced, spread
    from aomc_sky.pictures.plot import scene_sun_deg

    run = open_run(arguments.path, row=arguments.row)
    bands = list(dict.fromkeys(run.chosen(arguments.waveband)))
    sun = scene_sun_deg(run.manifest["options"].get("scene", {})) if run.manifest is not None else None
    title = _title(arguments, f"{_name(arguments)}: {spaced(run.source.total)} photons, seed {run.source.plan.seed}")
    shown = bands if arguments.waveband else spread(bands)
    show = arguments.show or "counts"
    return source_picture(run.source, show=show, bands=shown, sun_deg=sun, title=title), len(bands)


def _pulls(arguments: argparse.Namespace) -> tuple[Pulls, ...]:
    """Maps of the pulls of a finished run."""
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.outputs.folder.run_folder import RunFolder
    from aomc_sky.verify.stored.parts import open_parts
    from aomc_sky.verify.stored.run import VerifyOptions, verify_run

    run = open_run(arguments.path)
    parts = open_parts(RunFolder(Path(os.path.abspath(arguments.path))), run.source)
    if not parts:
        raise UsageError(f"{arguments.path} is not finished; the same run command finishes it")
    report = verify_run(parts, run.chosen(arguments.waveband), VerifyOptions(resample=0.0))
    if not report.pulls:
        raise UsageError(f"{arguments.path} holds no photons to compare; run it with --format npy")
    return report.pulls


def _pull_picture(arguments: argparse.Namespace, maps: tuple[Pulls, ...]) -> tuple[Picture, int]:
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.pictures.domes.source import spaced
    from aomc_sky.pictures.pull import DRAWN, PLANNED, pull_picture
    from aomc_sky.verify.report import Against

    source = open_run(arguments.path).source
    wavelength = source.plan.arrays["wavelength_nm"]
    named = [(f"waveband {p.waveband}, {wavelength[p.waveband - 1]:g} nm", p.zones, p.pull) for p in maps]
    title = _title(arguments, f"{_name(arguments)}: pulls of {spaced(source.total)} photons")
    note = PLANNED if any(p.against is Against.PLAN for p in maps) else DRAWN
    return pull_picture(named, title=title, note=note), len(maps)


def _table(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.formats.skydist.table import read_skydist
    from aomc_sky.pictures.tables import table_picture
    from aomc_sky.source.read.table import TableOptions, tabulated_sky

    options = TableOptions(
        bins=arguments.bins,
        weighting=arguments.weighting,
        compat=arguments.compat,
        azimuth_bins=arguments.azimuth_bins,
    )
    sky, how = tabulated_sky(read_skydist(arguments.path, lenient=arguments.lenient), options)
    bands = _bands(arguments, sky.wavelength_nm.size)
    title = _title(arguments, f"{_name(arguments)}: {how['weighting']} values, {how['bins']} bins")
    return table_picture(sky, bands=bands, title=title), len(bands or sky.wavelength_nm)


def _netcdf(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.pictures.tables import netcdf_picture

    panels = [band - 1 for band in dict.fromkeys(arguments.waveband)] if arguments.waveband else None
    return netcdf_picture(arguments.path, panels=panels, title=_title(arguments, _name(arguments)))


def _atmosphere(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.engine.atmosphere.table import TableRequest, prepare_table, solve_table
    from aomc_sky.formats.sky_toml.keys import GLOW_KEY
    from aomc_sky.formats.sky_toml.moon import moon_direction
    from aomc_sky.pictures.tables import atmosphere_picture
    from aomc_sky.source.light.inputs import given_lights

    lights = given_lights(cli_options.light_arguments(arguments))
    zenith = 40.0 if arguments.sun_zenith is None else arguments.sun_zenith
    request = TableRequest(
        path=arguments.path,
        sun_zenith_deg=(zenith,),
        sun_azimuth_deg=arguments.sun_azimuth or 0.0,
        wavelength_nm=tuple(arguments.wavelength or (450.0, 550.0, 650.0)),
        bins=(45, 180),
        allow_paths=tuple(arguments.allow_path),
        moon=moon_direction(lights),
        ground_luminance_cd_m2=lights.get(GLOW_KEY, 0.0),
    )
    sky = solve_table(prepare_table(request)).skies[0]
    picture = atmosphere_picture(sky, title=_title(arguments, f"{_name(arguments)}, sun at {zenith:g}°"))
    return picture, len(picture.domes)


def _background(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.cli.commands.plot.background import side_by_side, still

    picture = still(arguments) if arguments.time is not None else side_by_side(arguments)
    return picture, len(picture.domes)


def _animation(arguments: argparse.Namespace, target: Path) -> Drawn:
    from aomc_sky.cli.commands.plot.background import moving

    picture = moving(arguments, target, n_frames=arguments.frames or _FRAMES)
    return Drawn(path=target, kind=Kind.BACKGROUND, picture=picture, n_panels=len(picture.domes))


_PICTURES: dict[Kind, Callable[[argparse.Namespace], tuple[Picture, int]]] = {
    Kind.SCENE: _scene,
    Kind.RUN: _run,
    Kind.BACKGROUND: _background,
    Kind.ATMOSPHERE: _atmosphere,
    Kind.TABLE: _table,
    Kind.NETCDF: _netcdf,
}
