"""``aomc-sky lobes``: background-sky files at one time, without AMC files."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.background_options import add_background_options, moment
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.source.backgrounds.scene import LobeScene

_EPILOG = """\
examples:
  aomc-sky lobes night.h5 --time 2026-02-14T21:30:00Z --utc-offset 1
  aomc-sky lobes night.h5 town.h5 --time 2026-02-14T22:30:00+01:00 --wavelength 450 550 650 --json
  aomc-sky lobes night.h5 --time 1771104600 --animation city --plot city.png
  aomc-sky lobes night.h5 --time 2026-02-14T21:30:00Z --wavelength 550 --out night    photons, skydist.inp, picture
"""


def add_parser(commands: Any) -> None:
    """Add the sub-command."""
    parser = commands.add_parser(
        "lobes",
        help="look at background-sky files at one time, or make photons of them",
        description="Print the lobes of background-sky files at one time, their irradiance per wavelength and what the "
        "horizon takes; write them as skydist.inp, netCDF, picture or photons. The light of several files adds.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("paths", nargs="+", metavar="FILE", help="background-sky files (HDF5; need the extra 'hdf5')")
    _add_sky_options(parser)
    _add_output_options(parser)
    parser.set_defaults(handler=lobes, resumes=True)


def _add_sky_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sky")
    group.add_argument(
        "--time",
        type=moment,
        required=True,
        metavar="TIME",
        help="ISO 8601 with Z or an offset, or seconds since 1970-01-01 UTC",
    )
    add_background_options(group)
    group.add_argument(
        "--wavelength",
        type=cli_options.finite_number,
        nargs="+",
        metavar="NM",
        help="wavelengths (default: those of the spectra that all files have)",
    )


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    group.add_argument(
        "--bins",
        type=cli_options.bin_count,
        nargs=2,
        metavar=("NZ", "NA"),
        default=[18, 72],
        help="equal bins of skydist.inp and netCDF (default 18 72)",
    )
    group.add_argument("--write-skydist", metavar="FILE", help="radiances as a skydist.inp")
    group.add_argument("--netcdf", metavar="FILE", help="radiances and irradiances (needs the extra 'netcdf')")
    group.add_argument("--plot", metavar="FILE", help="the sky dome as .png, .svg or .pdf (needs the extra 'plot')")
    group.add_argument(
        "--out", metavar="DIR", help="a run folder of photons; skydist.inp and, with the extra 'plot', sky.png beside"
    )
    group.add_argument(
        "--iterations",
        type=cli_options.photon_total,
        default=10**5,
        metavar="N",
        help="with --out: photons per wavelength (default 1e5)",
    )
    group.add_argument("--seed", type=cli_options.seed, default=0, metavar="INT", help="with --out: seed (default 0)")
    group.add_argument(
        "--format",
        choices=("npy", "mcpl", "none"),
        metavar="npy|mcpl|none",
        action="append",
        help="with --out: photon files, repeatable (default npy); none: counts and plan only",
    )
    group.add_argument("--force", action="store_true", help="replace another run in the folder, and files of others")
    group.add_argument("--strict", action="store_true", help="warnings are errors")
    cli_options.add_print_options(group)


def lobes(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.cli.commands.lobes.files import write_files
    from aomc_sky.cli.commands.lobes.report import as_json, as_text

    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none stands alone")
    if arguments.out is None and arguments.format:
        raise UsageError("--format and its files belong to --out")
    scene = _scene(arguments)
    written = write_files(scene, arguments, formats)
    if arguments.json:
        print(json.dumps({**as_json(scene), "written": written}, allow_nan=False))
    elif not arguments.quiet:
        print(as_text(scene, written))
    return 0


def _scene(arguments: argparse.Namespace) -> LobeScene:
    from aomc_sky.formats.sky_toml.keys import BackgroundSection
    from aomc_sky.source.backgrounds.scene import read_lobe_scene

    sections = [
        BackgroundSection(
            file=path,
            time=arguments.time,
            animation=None if arguments.animation is None else tuple(arguments.animation),
            utc_offset=arguments.utc_offset,
            interpolation=arguments.interpolation,
        )
        for path in arguments.paths
    ]
    return read_lobe_scene(sections, arguments.wavelength)
