"""``aomc-sky perez``: one Perez sky without AMC files, or a year of them from a weather file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.engine.year import YearResult

WEATHER = ("epw", "tmy2", "tmy3")
_number = cli_options.finite_number
_bin_count = cli_options.bin_count

_EPILOG = """\
examples:
  aomc-sky perez --sun-zenith 40 --dni 850 --dhi 95
  aomc-sky perez --time 2026-06-21T09:30:00Z --latitude 54.2 --longitude 7.9 --dni 850 --dhi 95
  aomc-sky perez --epw site.epw --row 4000 --plot sky.png --write-skydist skydist.inp
  aomc-sky perez --epw site.epw --every hour --out year     counts of every hour; resumable
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Print clearness, brightness, coefficients and normalisation of a Perez sky; write it as "
        "skydist.inp, as photon counts or as a picture. With --every hour: all hours of a weather file."
    )
    parser.epilog = _EPILOG
    _add_weather_options(parser)
    _add_sun_options(parser)
    _add_sky_options(parser)
    _add_output_options(parser)
    parser.set_defaults(handler=perez, resumes=True)


def _add_weather_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("a weather file (the sun at the middle of each hour; needs the extra 'weather')")
    file = group.add_mutually_exclusive_group()
    for kind in WEATHER:
        file.add_argument(f"--{kind}", metavar="FILE", help=f"an {kind.upper()} file of hours".replace("an T", "a T"))
    group.add_argument("--row", type=cli_options.whole_number, metavar="N", help="the hour to take, from 1")
    group.add_argument("--every", choices=("hour",), help="all hours, into the folder --out")


def _add_sun_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sun, where no weather file says it")
    group.add_argument("--sun-zenith", type=_number, metavar="DEG", help="zenith angle, 0 to below 90")
    group.add_argument(
        "--sun-azimuth",
        type=_number,
        metavar="DEG",
        help="azimuth from +x (east) towards +y (north), default 0",
    )
    group.add_argument(
        "--time", metavar="ISO8601", help="date and time with Z or an offset (needs the extra 'weather')"
    )
    group.add_argument("--latitude", type=_number, metavar="DEG", help="north positive, with --time")
    group.add_argument("--longitude", type=_number, metavar="DEG", help="east positive, with --time")


def _add_sky_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sky: dni and dhi, ghi and dni, epsilon and delta, or coefficients")
    cli_options.add_perez_inputs(group, of_scene=False)
    cli_options.add_perez_choices(group, of_scene=False)


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    group.add_argument(
        "--bins",
        type=_bin_count,
        nargs=2,
        metavar=("NZ", "NA"),
        default=[45, 180],
        help="equal bins (default 45 180)",
    )
    group.add_argument("--write-skydist", metavar="FILE", help="radiances as a skydist.inp")
    group.add_argument(
        "--wavelength",
        type=_number,
        metavar="NM",
        default=550.0,
        help="of the one table in it (default 550)",
    )
    group.add_argument("--counts", metavar="FILE", help="photons of every patch as CSV")
    group.add_argument("--plot", metavar="FILE", help="the sky dome as .png, .svg or .pdf (needs the extra 'plot')")
    group.add_argument(
        "--iterations", type=cli_options.photon_total, metavar="N", default=10**6, help="photons (default 1e6)"
    )
    group.add_argument("--seed", type=cli_options.seed, default=0, metavar="INT", help="seed, 0 to 2^64-1 (default 0)")
    group.add_argument("--out", metavar="DIR", help="folder of a year, with --every")
    group.add_argument(
        "--format", choices=("none",), default="none", help="with --every: counts and plan only; photons on demand"
    )
    group.add_argument("--with-beam", action="store_true", help="with --every: photons of the direct beam too")
    group.add_argument(
        "--force", action="store_true", help="replace files of others, with --every another year in the folder"
    )
    group.add_argument("--strict", action="store_true", help="warnings are errors")
    cli_options.add_print_options(group)


def perez(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    kind = next((kind for kind in WEATHER if getattr(arguments, kind) is not None), None)
    if arguments.every:
        if kind is None:
            raise UsageError("--every hour needs a weather file: --epw, --tmy2 or --tmy3")
        return year(arguments, kind)
    for name in ("out", "with_beam"):
        if getattr(arguments, name) not in (None, False):
            raise UsageError(f"--{name.replace('_', '-')} belongs to --every hour")
    return _one_sky(arguments, kind)


def _one_sky(arguments: argparse.Namespace, kind: str | None) -> int:
    from aomc_sky.cli.commands.perez.report import as_json, as_text, write_counts, write_picture, write_table
    from aomc_sky.cli.commands.perez.sky import resolve
    from aomc_sky.outputs.folder.target_file import check_target

    weather = None if kind is None else getattr(arguments, kind)
    for option, path in (
        ("--write-skydist", arguments.write_skydist),
        ("--counts", arguments.counts),
        ("--plot", arguments.plot),
    ):
        if path is not None:
            check_target(path, option, force=arguments.force, inputs=() if weather is None else (weather,))
    found = resolve(arguments, kind)
    for path, write in (
        (arguments.write_skydist, write_table),
        (arguments.counts, write_counts),
        (arguments.plot, write_picture),
    ):
        if path is not None:
            write(found, arguments, path)
    if arguments.json:
        print(json.dumps(as_json(found), allow_nan=False))
    elif not arguments.quiet:
        print(as_text(found))
    return 0


_OF_ONE_SKY = (
    "row",
    "sun_zenith",
    "sun_azimuth",
    "time",
    "latitude",
    "longitude",
    "dni",
    "dhi",
    "ghi",
    "epsilon",
    "delta",
    "coefficients",
    "extraterrestrial",
    "write_skydist",
    "counts",
    "plot",
)


def year(arguments: argparse.Namespace, kind: str) -> int:
    """Carry the year out."""
    from aomc_sky.cli.commands.perez.sky import refuse_given

    refuse_given(arguments, _OF_ONE_SKY, f"--{kind} with --every hour")
    if arguments.strict:
        raise UsageError("--strict belongs to one sky; of a year, index.csv says what was limited in which hour")
    if arguments.out is None:
        raise UsageError("--every hour needs --out DIR")
    from aomc_sky.outputs.folder.target_file import check_folder

    check_folder(arguments.out, "--out")
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.year import run_year
    from aomc_sky.formats.weather import read_weather
    from aomc_sky.source.year import plan_year

    path = getattr(arguments, kind)
    plan = plan_year(
        read_weather(path, kind),
        iterations=arguments.iterations,
        seed=arguments.seed,
        bins=(arguments.bins[0], arguments.bins[1]),
        limits=arguments.limits,
        air_mass=arguments.air_mass,
        with_beam=arguments.with_beam,
    )
    folder = Path(arguments.out)
    with progress_bar(enabled=not (arguments.quiet or arguments.json), unit="skies", per_unit=1.0) as progress:
        result = run_year(plan, folder, weather_file=path, force=arguments.force, progress=progress)
    if arguments.json:
        print(json.dumps({**result.manifest, "folder": str(folder), "was_finished": result.was_finished}))
    elif not arguments.quiet:
        print(_text(result, folder))
    return 0


def _text(result: YearResult, folder: Path) -> str:
    """What a year prints when it is done."""
    manifest: dict[str, Any] = result.manifest
    hours = manifest["hours"]
    lines = [f"{count:6d} hours  {_MEANING.get(state, state)}" for state, count in hours.items()]
    if manifest["hours_limited"]:
        lines.append(f"{manifest['hours_limited']:6d} of the skies had to be limited; index.csv says how")
    lines.append("")
    sky = hours.get("sky", 0)
    lines.append(f"{manifest['total']} photons in {sky} skies, seed {manifest['seed']}")
    if result.was_finished:
        lines.append("this year was finished before; nothing was done again (--force makes it anew)")
    else:
        rate = result.hours_done / max(result.seconds, 1e-9)
        lines.append(f"{result.hours_done} skies made in {result.seconds:.1f} s ({rate:.0f} per second)")
    lines.append(f"plan {manifest['plan_sha256'][:16]}, folder {folder}")
    return "\n".join(lines)


_MEANING = {
    "sky": "with a sky",
    "night": "with the sun below the horizon at their middle",
    "no-diffuse": "with DHI = 0: no sky to sample",
    "missing": "without DNI or DHI in the file",
    "no-light": "whose sky the model leaves without light; index.csv says why",
}
