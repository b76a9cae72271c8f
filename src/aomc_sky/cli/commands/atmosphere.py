"""``aomc-sky atmosphere``: the clear sky of an atmosphere description as tables, for one sun or several."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky import __version__
from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import report_text
from aomc_sky.errors import UsageError
from aomc_sky.options import LIGHTS

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.engine.atmosphere import TableRequest


FORMAT_VERSION = 6

_EPILOG = """\
examples:
  aomc-sky atmosphere clear.atmo --out-dir clear --sun-zenith 40
  aomc-sky atmosphere clear.atmo --out-dir clear --sun-zenith 0:90:5 --bins 30 60
  aomc-sky atmosphere clear.atmo --no-save-tex              check it, print optical depths and norms

In the folder: skydist.inp (the sky without the direct beam; in a folder for each sun where there are several),
atmosphere.nc (all suns, wavelengths and orders; needs the extra 'netcdf') and report.json.
"""

GROUPS = {
    "what is solved": "atmosphere.zenith_deg atmosphere.azimuth_deg atmosphere.wavelengths atmosphere.method orders "
    "paths atmosphere.seed atmosphere.bins",
    "what is written and printed": "atmosphere.out out_dir atmosphere.force allow_path no_netcdf "
    "fail_on_warnings json quiet",
    **cli_options.MOON,
    "options of calcmysky": "no_save_tex texture_save_precision save_irradiance save_scat_density2_from_ground "
    "save_scat_density save_accum_scattering save_light_pollution",
}
FIRST = "out-dir sun-zenith sun-azimuth wavelengths method bins no-save-tex no-netcdf force json quiet"


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
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=atmosphere)


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
        wavelength_nm=None if arguments.wavelengths is None else tuple(arguments.wavelengths),
        method=arguments.method,
        n_orders=arguments.orders,
        n_paths=arguments.paths,
        seed=arguments.seed,
        bins=None if arguments.bins is None else (arguments.bins[0], arguments.bins[1]),
        allow_paths=tuple(arguments.allow_path or ()),
        saves=Saves(**{member: getattr(arguments, name) for member, name in _SAVES.items()}),
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
            "the output is missing", "write --out FILE.nc or --out-dir DIR (or --no-save-tex to check the description)"
        )
    _check_targets(arguments)
    needing = cli_options.given_options(arguments, *_SAVES.values(), "texture_save_precision")
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
    "irradiance": "save_irradiance",
    "source_from_ground": "save_scat_density2_from_ground",
    "source": "save_scat_density",
    "cumulative": "save_accum_scattering",
    "glow": "save_light_pollution",
}
"""Member of `Saves` -> its row in the table of options."""
