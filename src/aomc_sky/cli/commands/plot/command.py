"""``aomc-sky plot``: the sky dome of a scene before its run, of a run, and of the files of the package."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.options import add_background_options, moment

if TYPE_CHECKING:
    from aomc_sky.cli.commands.plot.files import Drawn

_EPILOG = """\
examples:
  aomc-sky plot inputs/clear_day                       inputs/clear_day.png: radiance of every waveband
  aomc-sky plot amc.inp --show counts --out sky.svg    photons per steradian, before any run
  aomc-sky plot out                                    photons per steradian of a run
  aomc-sky plot out --pull                             where its photons lie off what is expected
  aomc-sky plot night.h5 --utc-offset 1                night.gif: a background sky over a day
  aomc-sky plot night.h5 --time 2026-02-14T21:30:00Z   at one time
  aomc-sky plot clear.atmo --sun-zenith 40 --wavelength 550
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Draw the sky dome: the source of a scene before any run, photons per steradian or pulls of a run, "
        "a background sky over time, an atmosphere, a table. North is up, the zenith in the centre, the horizon at the "
        "rim; the picture says which way azimuth grows. Needs the extra 'plot'."
    )
    parser.epilog = _EPILOG
    parser.add_argument(
        "path",
        metavar="PATH",
        help="amc.inp or its folder, a run folder, a background sky (.h5, .hdf5), an atmosphere (.atmo), skydist.inp, "
        "or a netCDF file of this package (.nc)",
    )
    _add_picture_options(parser)
    _add_content_options(parser)
    _add_time_options(parser)
    cli_options.add_reading_options(parser)
    parser.set_defaults(handler=plot)


def _add_picture_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the picture")
    group.add_argument(
        "--out",
        metavar="FILE",
        help="the picture as .png, .svg or .pdf, an animation as .gif (default: PATH.png or PATH.gif beside PATH)",
    )
    group.add_argument("--force", action="store_true", help="replace a file that aomc-sky did not write")
    group.add_argument(
        "--size",
        type=cli_options.whole_number,
        metavar="PX",
        help="width in dots, 300 to 8000; 2000 at most for .gif (default 960, 640 for .gif)",
    )
    group.add_argument(
        "--seen-from",
        choices=("above", "below"),
        default="above",
        help="above: as a map, east to the right (default); below: as one looks up, east to the left",
    )
    group.add_argument(
        "--range",
        type=cli_options.finite_number,
        nargs=2,
        metavar=("LOW", "HIGH"),
        help="ends of the colour bar (default: the values, at most four decades)",
    )
    group.add_argument("--title", metavar="TEXT", help="above the picture (default: what PATH is)")
    cli_options.add_print_options(group)


def _add_content_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is drawn")
    group.add_argument(
        "--show",
        choices=("radiance", "counts"),
        help="of a scene or a run: radiance, or photons per steradian (default: radiance of a scene, counts of a run)",
    )
    group.add_argument(
        "--pull",
        action="store_true",
        help="of a run: photons less what is expected, over the standard deviation of independent photons",
    )
    cli_options.add_waveband_option(
        group, "only this band, or this table of a file, from 1; repeatable (default: all, 12 spread over more)"
    )
    group.add_argument("--row", type=cli_options.whole_number, metavar="N", help="hour of a year of skies, from 1")
    group.add_argument(
        "--seed",
        type=cli_options.seed,
        default=0,
        metavar="INT",
        help="of the counts of a scene, 0 to 2^64-1 (default 0)",
    )
    group.add_argument(
        "--wavelength",
        type=cli_options.finite_number,
        nargs="+",
        metavar="NM",
        help="of a background sky (default near 550), of an atmosphere (default near 450, 550, 650)",
    )


def _add_time_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("a background sky over time")
    group.add_argument(
        "--time",
        type=moment,
        metavar="TIME",
        help="one time: ISO 8601 with Z or an offset, or seconds since 1970-01-01 UTC (default: an animation, and 12 "
        "times side by side where --out is no .gif)",
    )
    group.add_argument("--start", type=moment, metavar="TIME", help="first frame (default: the first key, midnight)")
    group.add_argument("--stop", type=moment, metavar="TIME", help="end (default: the last key, a day or week later)")
    group.add_argument(
        "--frames", type=cli_options.whole_number, metavar="N", help="frames of the animation, 2 to 1000 (default 48)"
    )
    add_background_options(group)


def plot(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.cli.commands.plot.files import draw, kind_of, refuse_idle_options

    kind = kind_of(arguments)
    refuse_idle_options(arguments, kind)
    drawn = draw(arguments, kind)
    if arguments.json:
        print(as_json(drawn))
    elif not arguments.quiet:
        print(as_text(drawn))
    return 0


def as_text(drawn: Drawn) -> str:
    """A line for the file, and one for what it leaves out."""
    from aomc_sky.outputs.picture import MOVING_SUFFIX
    from aomc_sky.pictures.drawing.style import plain_label

    n = len(drawn.picture.domes)
    parts = "frame" if drawn.path.suffix.lower() == MOVING_SUFFIX else "dome"
    line = (
        f"{drawn.path}: {n} {parts}{'s' if n > 1 else ''} of {drawn.kind.value}, "
        f"{plain_label(drawn.picture.quantity.label)}, {drawn.path.stat().st_size} bytes"
    )
    if n < drawn.n_panels:
        line += f"\nnote: {drawn.n_panels} wavebands, {n} spread over them are drawn; choose with --waveband I"
    if drawn.maps:
        line += f"\n{_largest(drawn)}"
    return line


def _largest(drawn: Drawn) -> str:
    """Where photons are farthest off."""
    from aomc_sky.verify.report import largest_pull

    worst = largest_pull(drawn.maps)
    if worst is None:
        return "largest pull: none, for every zone expects too few photons to say"
    pulls, ring, column = worst
    zenith, azimuth = pulls.zones.zenith_bounds_deg[ring], pulls.zones.azimuth_bounds_deg[column]
    return (
        f"largest pull: {pulls.pull[ring, column]:+.2f} of {sum(p.pull.size for p in drawn.maps)}, in waveband "
        f"{pulls.waveband}, zenith {zenith[0]:.2f} to {zenith[1]:.2f}, azimuth {azimuth[0]:.2f} to {azimuth[1]:.2f} "
        f"deg: {pulls.observed[ring, column]:.6g} photons, {pulls.expected[ring, column]:.6g} by {pulls.against.value}"
    )


def _largest_json(drawn: Drawn) -> dict[str, Any] | None:
    from aomc_sky.verify.report import cell_json, largest_pull

    worst = largest_pull(drawn.maps)
    if worst is None:
        return None
    return {"waveband": worst[0].waveband, "against": worst[0].against.name.lower(), **cell_json(*worst)}


def as_json(drawn: Drawn) -> str:
    """The same as one JSON object."""
    from aomc_sky.pictures.drawing.style import plain_label

    values = {
        "out": str(drawn.path),
        "bytes": drawn.path.stat().st_size,
        "of": drawn.kind.name.lower(),
        "quantity": plain_label(drawn.picture.quantity.label),
        "domes": [dome.title.split("\n")[0] for dome in drawn.picture.domes],
        "left_out": drawn.n_panels - len(drawn.picture.domes),
        **({"largest_pull": _largest_json(drawn)} if drawn.maps else {}),
    }
    return json.dumps(values)
