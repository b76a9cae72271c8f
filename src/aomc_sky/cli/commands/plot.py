"""``aomc-sky plot``: the sky dome of a scene before its run, of a run, and of the files of the package."""

from __future__ import annotations

import argparse
import dataclasses
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.background_report import lobes_at, moment_of
from aomc_sky.cli.terminal import shown
from aomc_sky.errors import InputFileError, UsageError
from aomc_sky.options import FIELD, LOBES
from aomc_sky.progress import status_line
from aomc_sky.source.read.kind import Kind, kind_of

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.cli.usage import Parser
    from aomc_sky.pictures.picture import Picture
    from aomc_sky.verify.report import Pulls

_EPILOG = """\
examples:
  aomc-sky plot inputs/clear_day                       inputs/clear_day.png: radiance of every waveband
  aomc-sky plot amc.inp --show counts --out sky.svg    photons per steradian, before any run
  aomc-sky plot out                                    photons per steradian of a run
  aomc-sky plot out --pull                             where its photons lie off what is expected
  aomc-sky plot night.h5 --utc-offset 1                night.png: a background sky over a day
  aomc-sky plot night.h5 --time 2026-02-14T21:30:00Z   at one time
  aomc-sky plot sky.nc                                 what aomc-sky atmosphere --out sky.nc solved
  aomc-sky plot --sky overcast --wavelengths 550       sky.png: a scene without files, as aomc-sky run takes it
"""

_CONTENT = "show quantity pull plot.waveband plot.seed plot.wavelengths"
_TIME = f"frames {' '.join(LOBES)}"
GROUPS = {
    "the picture": "plot.out plot.force size seen_from range scale cmap norm title no_caption json quiet",
    "what is drawn": _CONTENT,
    "a background sky over time, or at one --time": _TIME,
    **cli_options.READING,
    **cli_options.WHEN,
}
FIRST = "out show pull waveband wavelengths time size seen-from range title force json quiet"


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Draw the sky dome: the source of a scene before any run, photons per steradian or pulls of a run, "
        "a background sky over time, a table. North is up, the zenith in the centre, the horizon at the "
        "rim; the picture says which way azimuth grows. Needs the extra 'plot'."
    )
    parser.epilog = _EPILOG
    parser.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        help="amc.inp or its folder, a run folder, a measured sky (.csv), a background sky (.h5, .hdf5), skydist.inp, "
        "or a netCDF file of this package (.nc); none: sun and sky by options, as for aomc-sky run",
    )
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=plot)


def plot(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.extras import optional_module
    from aomc_sky.outputs.picture import save_picture
    from aomc_sky.outputs.run_folder import check_target
    from aomc_sky.pictures.dome import ColourChoice, View
    from aomc_sky.pictures.panels import figure_of

    kind = Kind.SCENE if arguments.path is None else kind_of(Path(arguments.path)) or Kind.SCENE
    if kind is Kind.ATMOSPHERE:
        raise UsageError(
            f"{arguments.path} is an atmosphere",
            f"write aomc-sky atmosphere {arguments.path} --out sky.nc, which solves it, and plot sky.nc",
        )
    kind = kind if kind in _PICTURES else Kind.SCENE
    _refuse_idle_options(arguments, kind)
    optional_module("matplotlib", extra="plot")
    target = _target(arguments)
    check_target(target, "--out", force=arguments.force, inputs=[] if arguments.path is None else [arguments.path])
    maps: tuple[Pulls, ...] = ()
    with status_line("drawing", enabled=cli_options.is_verbose(arguments)):
        if arguments.pull:
            picture, maps = _pull_picture(arguments)
            n_panels = len(maps)
        else:
            picture, n_panels = _PICTURES[kind](arguments)
        figure = figure_of(
            picture,
            size_px=arguments.size,
            view=View(arguments.seen_from),
            choice=ColourChoice(limits=arguments.range, cmap=arguments.cmap, norm=arguments.norm),
            scale=arguments.scale,
            has_caption=not arguments.no_caption,
        )
        save_picture(figure, target, dpi=figure.dpi)
    values = _values(target, kind, picture, n_panels, maps)
    cli_options.answer(arguments, lambda: values, lambda: _text(values))
    return 0


def _values(target: Path, kind: Kind, picture: Picture, n_panels: int, maps: Sequence[Pulls]) -> dict[str, Any]:
    """The result as JSON values."""
    from aomc_sky.pictures.dome import plain_label
    from aomc_sky.verify.report import cell_json, largest_pull

    values: dict[str, Any] = {
        "out": str(target),
        "bytes": target.stat().st_size,
        "of": kind.name.lower(),
        "quantity": plain_label(picture.quantity.label),
        "domes": [dome.title.split("\n")[0] for dome in picture.domes],
        "left_out": n_panels - len(picture.domes),
    }
    if maps:
        worst = largest_pull(maps)
        named = worst and {"waveband": worst[0].waveband, "against": worst[0].against.name.lower(), **cell_json(*worst)}
        values["largest_pull"] = named
    return values


def _text(values: dict[str, Any]) -> str:
    """A line for the file, and notes."""
    n = len(values["domes"])
    domes = f"{n} dome{'s' if n > 1 else ''} of a {'measured sky' if values['of'] == 'measured' else values['of']}"
    lines = [f"{values['out']}: {domes}, {values['quantity']}, {values['bytes']} bytes"]
    if values["left_out"]:
        n_all = n + values["left_out"]
        lines.append(f"note: {n_all} wavebands, {n} spread over them are drawn; choose with --waveband I")
    if "largest_pull" in values:
        none = "none, because every zone expects too few photons"
        lines.append(f"largest pull: {shown(values['largest_pull']) if values['largest_pull'] else none}")
    return "\n".join(lines)


_USUAL_NM = 550.0
"""A background sky is drawn at its wavelength nearest to this one."""

_BELONGS: dict[str, tuple[Kind, ...]] = {
    "--show": (Kind.SCENE, Kind.RUN, Kind.MEASURED),
    "--quantity": (Kind.RUN,),
    "--pull": (Kind.RUN,),
    "--waveband": (Kind.SCENE, Kind.RUN, Kind.TABLE, Kind.NETCDF, Kind.MEASURED),
    **dict.fromkeys(
        ("--azimuth-convention", "--angle-unit", "--radiance-unit", "--variable", "--isel"),
        (Kind.MEASURED, Kind.NETCDF),
    ),
    **dict.fromkeys(("--variable-q", "--variable-u", "--stokes-signs"), (Kind.NETCDF,)),
    **dict.fromkeys(("--seed", "--iterations"), (Kind.SCENE, Kind.MEASURED)),
    **dict.fromkeys(("--sun-zenith", "--sun-azimuth"), (Kind.SCENE, Kind.MEASURED, Kind.NETCDF)),
    "--wavelengths": (Kind.BACKGROUND,),
    "--time": (Kind.SCENE, Kind.BACKGROUND),
    **dict.fromkeys(("--bins", "--weighting", "--azimuth-bins", "--compat", "--lenient"), (Kind.SCENE, Kind.TABLE)),
    **dict.fromkeys(("--strict", "--max-memory"), tuple(Kind)),
}
"""Option -> the kinds of paths that it applies to; options that are missing here apply to scenes alone."""


def _refuse_idle_options(arguments: argparse.Namespace, kind: Kind) -> None:
    """Refuse options that do not apply to this kind of path."""
    if arguments.path is None or not Path(arguments.path).exists():
        return  # what reads it says so
    time_options = cli_options.given_options(arguments, *_TIME.split())
    others = cli_options.given_options(
        arguments, *_CONTENT.split(), *cli_options.names_of(cli_options.READING | cli_options.WHEN)
    )
    for option in [*time_options, *others]:
        kinds = (Kind.BACKGROUND,) if option in time_options else _BELONGS.get(option, (Kind.SCENE,))
        if kind not in kinds:
            named = " or ".join(k.value for k in kinds)
            raise UsageError(f"{option} is for {named}; {arguments.path} is {kind.value}")
    chosen = [f"--{name}" for name in ("pull", "show", "quantity") if getattr(arguments, name)]
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(chosen)} are {len(chosen)} pictures", "make each with a command of its own")


def _target(arguments: argparse.Namespace) -> Path:
    """The path of the picture; a wrong name is an error before the work."""
    from aomc_sky.outputs.picture import picture_path

    if arguments.out == "":
        raise UsageError("--out is empty", "name a file, for example sky.png")
    if arguments.out is not None:
        return picture_path(arguments.out)
    path = Path(os.path.abspath(arguments.path or "sky"))
    name = path.name if path.is_dir() else path.stem
    return path.with_name(f"{name}{'-pull' if arguments.pull else ''}.png")


def _title(arguments: argparse.Namespace, text: str) -> str:
    return text if arguments.title is None else str(arguments.title)


def _name(arguments: argparse.Namespace) -> str:
    """The name of the path in a title; a scene has the name of its folder, one of options that of its sky."""
    if arguments.path is None:
        when = f"{Path(arguments.weather).name}, row {arguments.row}" if arguments.weather else arguments.time
        return ", ".join(filter(None, (arguments.sky or "sun and sky", when)))
    path = Path(os.path.abspath(arguments.path))
    return path.parent.name if path.name == "amc.inp" else path.name


def _bands(arguments: argparse.Namespace, wavelength_nm: np.ndarray) -> list[int] | None:
    """The wavebands that were named, from 0."""
    from aomc_sky.wavebands import absent_waveband

    if not arguments.waveband:
        return None
    for waveband in arguments.waveband:
        if not 1 <= waveband <= wavelength_nm.size:
            raise absent_waveband(waveband, wavelength_nm)
    return [waveband - 1 for waveband in dict.fromkeys(arguments.waveband)]


def _scene(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.pictures.plot import picture_of_scene
    from aomc_sky.plan.laws import law_of

    if arguments.path is None:
        scene = cli_options.scene_of_options(arguments)
    else:
        scene = cli_options.scene_of(arguments, arguments.path, wavebands=arguments.waveband)
    bands = _bands(arguments, scene.wavebands.wavelength_nm)
    show: Any = arguments.show or "radiance"
    source = scene.source(arguments.seed, max_memory_bytes=arguments.max_memory)
    is_beam_alone = all(law_of(c.law).is_beam for c in source.components)
    radiance = "the direct beam, without a sky" if is_beam_alone else "radiance of the sky"
    shown_words = radiance if show == "radiance" else "photons that a run will launch"
    title = _title(arguments, f"{_name(arguments)}: {shown_words}")
    picture = picture_of_scene(scene, source, show=show, bands=bands, title=title)
    return picture, len(bands or range(source.n_bands))


def _run(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.pictures.picture import spread
    from aomc_sky.pictures.plot import sun_of_options
    from aomc_sky.pictures.source import source_picture, spaced

    run = open_run(arguments.path)
    bands = list(dict.fromkeys(run.chosen(arguments.waveband)))
    sun = sun_of_options(run.manifest["options"].get("scene", {})) if run.manifest is not None else None
    title = _title(arguments, f"{_name(arguments)}: {spaced(run.source.total)} photons, seed {run.source.plan.seed}")
    drawn = bands if arguments.waveband else spread(bands)
    show: Any = arguments.quantity or arguments.show or "counts"
    return source_picture(run.source, show=show, bands=drawn, sun=sun, title=title), len(bands)


def _pull_picture(arguments: argparse.Namespace) -> tuple[Picture, tuple[Pulls, ...]]:
    """The picture and the maps of the pulls of a finished run."""
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.pictures.picture import DRAWN, PLANNED, pull_picture
    from aomc_sky.pictures.source import spaced
    from aomc_sky.verify.report import Against
    from aomc_sky.verify.reproduce import statistics_of_run

    run = open_run(arguments.path)
    if run.manifest is None:
        raise UsageError(f"{arguments.path} is not finished; the same run command finishes it")
    maps = statistics_of_run(run.path, run.source, run.chosen(arguments.waveband)).pulls
    if not maps:
        raise UsageError(f"{arguments.path} holds no photons to compare", "run it with --format npy")
    wavelength = run.source.plan.wavelength_nm
    named = [(f"waveband {p.waveband}, {wavelength[p.waveband - 1]:g} nm", p.zones, p.pull) for p in maps]
    title = _title(arguments, f"{_name(arguments)}: pulls of {spaced(run.source.total)} photons")
    note = PLANNED if any(p.against is Against.PLAN for p in maps) else DRAWN
    return pull_picture(named, title=title, note=note), maps


def _table(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.formats.aomc.skydist import read_skydist
    from aomc_sky.pictures.plot import table_picture
    from aomc_sky.source.read.table import tabulated_sky

    names = ("bins", "weighting", "compat", "azimuth_bins")
    options = {name: getattr(arguments, name) for name in names}
    sky, how = tabulated_sky(read_skydist(arguments.path, lenient=arguments.lenient), **options)
    bands = _bands(arguments, sky.wavelength_nm)
    title = _title(arguments, f"{_name(arguments)}: {how['weighting']} values, {how['bins']} bins")
    return table_picture(sky, bands=bands, title=title), len(bands or sky.wavelength_nm)


def _netcdf(arguments: argparse.Namespace) -> tuple[Picture, int]:
    from aomc_sky.pictures.plot import netcdf_picture

    has_sun = (arguments.sun_zenith, arguments.sun_azimuth) != (None, None)
    if has_sun or cli_options.given_options(arguments, *FIELD):
        return _scene(arguments)
    panels = [band - 1 for band in dict.fromkeys(arguments.waveband)] if arguments.waveband else None
    try:
        return netcdf_picture(arguments.path, panels=panels, title=_title(arguments, _name(arguments)))
    except InputFileError:
        return _scene(arguments)  # radiances in directions, without patches


def _background(arguments: argparse.Namespace) -> tuple[Picture, int]:
    """The sky at one time with a dome for each wavelength, or at up to 12 times."""
    from aomc_sky.formats.sky_toml.keys import moment_text
    from aomc_sky.pictures.backgrounds import lobe_picture

    if arguments.time is None:
        picture = _over_time(arguments)
        return picture, len(picture.domes)
    if arguments.frames is not None:
        raise UsageError("--time is one time; --frames is for several")
    moment = moment_of(arguments)
    _, sky, known_nm = lobes_at(arguments, moment)
    wavelengths = known_nm.tolist() if arguments.wavelengths else [_nearest_nm(known_nm)]
    pictures = [lobe_picture([(f"{w:g} nm", sky)], w) for w in wavelengths]
    title = _title(arguments, f"{Path(arguments.path).name}, {moment_text(moment)}")
    domes = tuple(picture.domes[0] for picture in pictures)
    return dataclasses.replace(pictures[0], domes=domes, title=title), len(domes)


def _over_time(arguments: argparse.Namespace) -> Picture:
    """The named animations at one wavelength and several times."""
    from aomc_sky.pictures.backgrounds import frame_times_s, moving_picture, time_span_s
    from aomc_sky.pictures.picture import MOST_PANELS
    from aomc_sky.skies.lobes.light import read_background

    if arguments.wavelengths and len(arguments.wavelengths) > 1:
        raise UsageError("several times are shown at one --wavelength; several wavelengths are for one --time")
    *_, known_nm = lobes_at(arguments, 0.0)  # refuses names and wavelengths that are not in the file
    wavelength = float(known_nm[0]) if arguments.wavelengths else _nearest_nm(known_nm)
    sky = read_background(arguments.path, utc_offset_h=arguments.utc_offset)
    if arguments.animation is not None:
        sky = dataclasses.replace(sky, animations={name: sky.animations[name] for name in arguments.animation})
    title = _title(arguments, f"{Path(arguments.path).name} at {wavelength:g} nm")
    times = frame_times_s(*time_span_s(sky), arguments.frames or MOST_PANELS).tolist()
    return moving_picture(sky, wavelength, times, title=title, interpolation=arguments.interpolation)


def _nearest_nm(known_nm: np.ndarray) -> float:
    return float(known_nm[abs(known_nm - _USUAL_NM).argmin()])


_PICTURES: dict[Kind, Callable[[argparse.Namespace], tuple[Picture, int]]] = {
    Kind.SCENE: _scene,
    Kind.MEASURED: _scene,
    Kind.RUN: _run,
    Kind.BACKGROUND: _background,
    Kind.TABLE: _table,
    Kind.NETCDF: _netcdf,
}
