"""``aomc-sky atmosphere``: the clear sky of an atmosphere description as tables, for one sun or several."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky import __version__
from aomc_sky.cli import options as cli_options
from aomc_sky.cli import values
from aomc_sky.cli.terminal import report_text
from aomc_sky.errors import UsageError
from aomc_sky.inputs import LIGHTS

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.engine.atmosphere import TableRequest


FORMAT_VERSION = 6
_MOST_SUNS = 1000

_EPILOG = """\
examples:
  aomc-sky atmosphere clear.atmo --out-dir clear --sun-zenith 40
  aomc-sky atmosphere clear.atmo --out-dir clear --sun-zenith 0:90:5 --bins 30 60
  aomc-sky atmosphere clear.atmo --no-save-tex              check it, print optical depths and norms

In the folder: skydist.inp (the sky without the direct beam; in a folder for each sun where there are several),
atmosphere.nc (all suns, wavelengths and orders; needs the extra 'netcdf') and report.json.
"""

_OPTIONS = """\
what is solved:
--sun-zenith DEG              zenith angle of the sun: a number, several with commas, START:END:STEP, or all: as many
                              from 0 to 90 as the description's scattering texture has (default 40)
--sun-azimuth DEG             azimuth of the sun from +x towards +y (default 0)
--wavelength --wavelengths NM...  wavelengths with blanks or commas, between those of the description (default all)
--method sos|order1|mc|auto   sos: successive orders of scattering, with a warning for a sun lower than 10 degrees
                              (default); order1: light scattered once; mc: backward paths through shells, for any sun;
                              auto: mc where sos is not accurate
--orders N                    most interactions that count (default: the description's)
--paths N                     backward paths of mc and of a glowing ground in each direction and at each wavelength;
                              four times as many halve the error (default: 4096, or 16384 where these are not enough,
                              and 32768 of the ground)
--bins NZ NA                  equal bins of zenith and azimuth (default: those of the description's scattering texture,
                              or 45 180)
what is written and printed:
--out FILE                    the sky as one netCDF file, which [sky] table of sky.toml reads
--out-dir DIR                 folder of the tables; made if it does not exist
--force                       replace files there that aomc-sky did not write
--allow-path
--no-netcdf                   leave atmosphere.nc out
--strict --json --quiet
"""
_CALCMYSKY_OPTIONS = """\
options of calcmysky:
--no-save-tex                 read and check the description, print the plan, solve nothing
--texture-save-precision BITS  atmosphere.nc in float32 with significands of 1 to 24 bits (default: float64)
"""


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Solve the atmosphere that a CalcMySky description (.atmo) describes: radiance of the clear sky "
        "at sea level, the direct beam, and how good both are."
    )
    parser.epilog = _EPILOG
    parser.add_argument("path", metavar="MODEL", help="the description, a .atmo file")
    parser.add_argument(
        "-v", "--version", action="version", version=f"aomc-sky {__version__}, descriptions of version {FORMAT_VERSION}"
    )
    kinds = {
        "sun_zenith": _suns,
        "orders": values.whole_number_in(1, 2**31),
        "paths": values.whole_number_in(8, 10**9),
    }
    cli_options.add_table(parser, _OPTIONS, kinds, sun_zenith=(40.0,), sun_azimuth=0.0, method="sos")
    cli_options.add_light_options(parser)
    rows = [f"{option}  {text}" for option, text in _SAVES.values()]
    rows += [f"{option}  accepted: {why}" for option, why in _IDLE.items()]
    kinds = {"texture_save_precision": values.whole_number_in(1, 24)}
    cli_options.add_table(parser, _CALCMYSKY_OPTIONS + "\n".join(rows), kinds)
    parser.show_first("out-dir sun-zenith sun-azimuth wavelength method bins no-save-tex no-netcdf force json quiet")
    parser.set_defaults(handler=atmosphere)


def _suns(text: str) -> tuple[float, ...] | None:
    if text == "all":
        return None
    suns = tuple(values.stepped(text)) if ":" in text else tuple(sorted(map(values.finite_number, text.split(","))))
    if any(not 0 <= sun <= 180 for sun in suns):
        raise argparse.ArgumentTypeError(f"expected zenith angles from 0 to 180 degrees, got {text!r}")
    if len(suns) > _MOST_SUNS:
        raise argparse.ArgumentTypeError(f"{len(suns)} suns in {text!r}; at most {_MOST_SUNS}")
    if len(set(suns)) < len(suns):
        raise argparse.ArgumentTypeError(f"a sun is given twice in {text!r}")
    return suns


def atmosphere(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.engine.atmosphere import prepare_table, solve_table, table_report, write_netcdf, write_table
    from aomc_sky.outputs.run_folder import create_folder
    from aomc_sky.progress import progress_bar, status_line

    if not arguments.no_save_tex:
        _check_outputs(arguments)
    shown = cli_options.is_verbose(arguments)
    with status_line("reading the description", enabled=shown):
        table = prepare_table(_request(arguments))
    files: dict[str, str] = {}
    if not arguments.no_save_tex:
        if arguments.out_dir is not None:
            create_folder(Path(arguments.out_dir))  # an error before minutes of work
        with progress_bar(enabled=shown, unit="skies", before="solving") as progress:
            table = solve_table(table, progress=progress)
        with status_line("writing the tables", enabled=shown):
            if arguments.out_dir is not None:
                files = write_table(table, Path(arguments.out_dir), netcdf=not arguments.no_netcdf)
            if arguments.out is not None:
                write_netcdf(table, Path(arguments.out))
                files["sky"] = arguments.out
    report = table_report(table)
    cli_options.answer(arguments, lambda: {**report, "files": files}, lambda: _text(report, files))
    for option, why in () if arguments.quiet else _IDLE.items():
        if getattr(arguments, cli_options.attribute(option)):
            print(f"aomc-sky: note: {option} has no effect: {why}", file=sys.stderr)
    return 0


def _request(arguments: argparse.Namespace) -> TableRequest:
    from aomc_sky.engine.atmosphere import TableRequest
    from aomc_sky.formats.sky_toml.keys import GLOW_KEY
    from aomc_sky.formats.sky_toml.sections import moon_direction
    from aomc_sky.outputs.tables.atmosphere import Saves
    from aomc_sky.source.light.said import checked_lights

    lights = checked_lights(cli_options.inputs_of(arguments, LIGHTS))
    return TableRequest(
        path=arguments.path,
        sun_zenith_deg=arguments.sun_zenith,
        sun_azimuth_deg=arguments.sun_azimuth,
        wavelength_nm=None if arguments.wavelength is None else tuple(arguments.wavelength),
        method=arguments.method,
        n_orders=arguments.orders,
        n_paths=arguments.paths,
        bins=None if arguments.bins is None else (arguments.bins[0], arguments.bins[1]),
        allow_paths=tuple(arguments.allow_path),
        saves=Saves(**{key: getattr(arguments, cli_options.attribute(option)) for key, (option, _) in _SAVES.items()}),
        significand_bits=arguments.texture_save_precision,
        moon=moon_direction(lights),
        ground_luminance_cd_m2=lights.get(GLOW_KEY, 0.0),
    )


def _check_targets(arguments: argparse.Namespace) -> None:
    """Refuse to replace files of others; every file of a table beside a report of ours is ours."""
    from aomc_sky.engine.atmosphere import DESCRIPTION_NAME, NETCDF_NAME, REPORT_HEAD, REPORT_NAME, SKYDIST_NAME
    from aomc_sky.outputs.run_folder import check_folder, check_target, is_ours

    if arguments.out is not None:
        check_target(arguments.out, "--out", force=arguments.force, inputs=[arguments.path])
    if arguments.out_dir is None:
        return
    check_folder(arguments.out_dir, "--out-dir")
    folder = Path(arguments.out_dir)
    is_table = is_ours(folder / REPORT_NAME, REPORT_HEAD)
    names = (SKYDIST_NAME, NETCDF_NAME, DESCRIPTION_NAME, REPORT_NAME)
    for path in [folder / name for name in names] + sorted(folder.glob(f"sun_*/{SKYDIST_NAME}")):
        if path.exists():
            is_copy, force = path.name == DESCRIPTION_NAME, arguments.force or is_table
            check_target(path, "--out-dir", force=force, inputs=[arguments.path], is_copy=is_copy)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse before the work what cannot be written after it."""
    from aomc_sky.outputs.tables.atmosphere import require_netcdf

    if arguments.out_dir is None and arguments.out is None:
        raise UsageError(
            "the output is missing; write --out FILE.nc or --out-dir DIR (or --no-save-tex to check the description)"
        )
    _check_targets(arguments)
    options = [*(option for option, _ in _SAVES.values()), "--texture-save-precision"]
    needing = [option for option in options if getattr(arguments, cli_options.attribute(option))]
    if arguments.no_netcdf and needing and arguments.out is None:
        raise UsageError(f"{', '.join(needing)}: this is written to atmosphere.nc, which --no-netcdf leaves out")
    if not arguments.no_netcdf or arguments.out is not None:
        require_netcdf()


def _text(report: Mapping[str, Any], files: Mapping[str, str]) -> str:
    """A description with its species and, once solved, its skies; `files` by their role."""
    roles = {role: path for role, path in files.items() if not role.startswith("skydist ")}
    if len(roles) < len(files):
        roles["skydist.inp"] = f"{len(files) - len(roles)} files, one in the folder of each sun"
    is_solved = "direct_irradiance" in report["suns"][0]
    head = f"{report['description']}, {'solved' if is_solved else 'not solved'}; irradiances in W m-2 nm-1"
    values = {name: value for name, value in report.items() if name not in ("description", "version")}
    if isinstance(values.get("bins"), list | tuple):
        values["bins"] = dict(zip(("zenith", "azimuth"), values["bins"], strict=True))
    return "\n".join([report_text(head, values), "", *(f"{role}: {path}" for role, path in roles.items())])


_SAVES = {
    "irradiance": ("--save-irradiance", "irradiances order by order"),
    "source_from_ground": (
        "--save-scat-density2-from-ground",
        "source function of order 2 from light of the ground, with --method sos",
    ),
    "source": ("--save-scat-density", "source functions of orders 2 and up, with --method sos"),
    "cumulative": ("--save-accum-scattering", "radiance of all orders up to each"),
    "glow": ("--save-light-pollution", "light of a ground of 1 cd/m2, order by order, by backward paths"),
}
"""Member of `Saves` -> its option, and what it adds to atmosphere.nc."""

_IDLE = {
    "--radiance": "spectral radiances are written in any case",
    "--save-delta-scattering": "radiance_by_order is written in any case",
    "--no-eds-tex": "there is no texture of eclipsed double scattering to leave out",
    **dict.fromkeys(("--opengl-info", "--opengl-debug", "--opengl-debug-full"), "OpenGL is not used"),
}
"""Options of calcmysky that change nothing -> why."""
