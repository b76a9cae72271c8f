"""``aomc-sky atmosphere``: the clear sky of an atmosphere description as tables, under one sun or several."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky import __version__
from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.engine.atmosphere import TableRequest
    from aomc_sky.outputs.tables.atmosphere import Saves


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


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Solve the atmosphere that a CalcMySky description (.atmo) describes: radiance of the clear sky "
        "at sea level, the direct beam, and how good both are."
    )
    parser.epilog = _EPILOG
    parser.add_argument("path", metavar="MODEL", help="the description, a .atmo file")
    parser.add_argument(
        "-v", "--version", action="version", version=f"aomc-sky {__version__}, descriptions of version {FORMAT_VERSION}"
    )
    _add_sun_options(parser)
    _add_output_options(parser)
    cli_options.add_light_options(parser)
    _add_calcmysky_options(parser)
    parser.show_first("out-dir sun-zenith sun-azimuth wavelength method bins no-save-tex no-netcdf force json quiet")
    parser.set_defaults(handler=atmosphere)


def _add_sun_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is solved")
    group.add_argument(
        "--sun-zenith",
        type=_suns,
        metavar="DEG",
        default=(40.0,),
        help="zenith angle of the sun: a number, several with commas, START:END:STEP, or all: as many from 0 to 90 as "
        "the description's scattering texture has (default 40)",
    )
    group.add_argument(
        "--sun-azimuth",
        type=cli_options.finite_number,
        metavar="DEG",
        default=0.0,
        help="azimuth of the sun from +x towards +y (default 0)",
    )
    group.add_argument(
        "--wavelength",
        type=_wavelengths,
        metavar="NM",
        help="wavelengths with commas, each the nearest of the description (default all)",
    )
    group.add_argument(
        "--method",
        choices=("sos", "order1", "mc", "auto"),
        default="sos",
        help="sos: successive orders of scattering, with a warning for a sun lower than 10 degrees (default); order1: "
        "light scattered once; mc: backward paths through shells, for any sun; auto: mc where sos is not accurate",
    )
    _add_size_options(group)


def _add_size_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--orders", type=_order_count, metavar="N", help="most interactions that count (default: the description's)"
    )
    group.add_argument(
        "--paths", type=_path_count, metavar="N",
        help="backward paths of mc and of a glowing ground in each direction and at each wavelength; four times as "
        "many halve the error (default: 4096, or 16384 where these are not enough, and 32768 of the ground)",
    )  # fmt: skip
    cli_options.add_bins(
        group,
        "equal bins of zenith and azimuth (default: those of the description's scattering texture, or 45 180)",
    )


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    group.add_argument("--out", metavar="FILE", help="the sky as one netCDF file, which [sky] table of sky.toml reads")
    group.add_argument("--out-dir", metavar="DIR", help="folder of the tables; made if it does not exist")
    group.add_argument("--force", action="store_true", help="replace files there that aomc-sky did not write")
    group.add_argument(
        "--allow-path", action="append", default=[], metavar="DIR",
        help="a folder, besides that of the description, below which its tables may lie; repeatable",
    )  # fmt: skip
    group.add_argument("--no-netcdf", action="store_true", help="leave atmosphere.nc out")
    cli_options.add_shared(group, "strict json quiet")


def _suns(text: str) -> tuple[float, ...] | None:
    if text == "all":
        return None
    suns = _range(text) if ":" in text else _listed(text)
    if any(not 0 <= sun <= 180 for sun in suns):
        raise argparse.ArgumentTypeError(f"wanted zenith angles from 0 to 180 degrees, got {text!r}")
    if len(set(suns)) < len(suns):
        raise argparse.ArgumentTypeError(f"a sun is given twice in {text!r}")
    return suns


def _listed(text: str) -> tuple[float, ...]:
    return tuple(sorted(cli_options.finite_number(part) for part in text.split(",")))


def _range(text: str) -> tuple[float, ...]:
    """START:END:STEP with both ends, where the step meets the end."""
    parts = [cli_options.finite_number(part) for part in text.split(":")]
    if len(parts) != 3 or not parts[2] > 0 or parts[1] < parts[0]:
        raise argparse.ArgumentTypeError(f"wanted START:END:STEP with a step above 0, for example 0:80:5, got {text!r}")
    start, end, step = parts
    count = int((end - start) / step * (1 + 1e-12)) + 1
    if count > _MOST_SUNS:
        raise argparse.ArgumentTypeError(f"{count} suns in {text!r}; at most {_MOST_SUNS}")
    return tuple(round(start + k * step, 10) for k in range(count))


def _wavelengths(text: str) -> tuple[float, ...]:
    values = tuple(cli_options.finite_number(part) for part in text.split(","))
    if any(value <= 0 for value in values):
        raise argparse.ArgumentTypeError(f"wanted positive wavelengths in nm, got {text!r}")
    return values


def _order_count(text: str) -> int:
    value = cli_options.whole_number(text)
    if not 1 <= value <= 2**31:
        raise argparse.ArgumentTypeError(f"wanted 1 to 2^31 orders, got {text}")
    return value


def _path_count(text: str) -> int:
    value = cli_options.whole_number(text)
    if not 8 <= value <= 10**9:
        raise argparse.ArgumentTypeError(f"wanted 8 to 10^9 paths, got {text}")
    return value


def atmosphere(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    with diagnostics(arguments):
        return _solve_and_write(arguments)


def _solve_and_write(arguments: argparse.Namespace) -> int:
    from aomc_sky.cli.progress import patience, progress_bar
    from aomc_sky.engine.atmosphere import prepare_table, solve_table, table_report, write_netcdf, write_table
    from aomc_sky.outputs.folder.run_folder import create_folder

    if not arguments.no_save_tex:
        _check_outputs(arguments)
    shown = cli_options.speaks(arguments)
    with patience("reading the description", enabled=shown):
        table = prepare_table(_request(arguments))
    files: dict[str, str] = {}
    if not arguments.no_save_tex:
        if arguments.out_dir is not None:
            create_folder(Path(arguments.out_dir))  # a place that cannot be written to is told before minutes of work
        with progress_bar(enabled=shown, unit="skies", before="solving") as progress:
            table = solve_table(table, progress=progress)
        with patience("writing the tables", enabled=shown):
            if arguments.out_dir is not None:
                files = write_table(table, Path(arguments.out_dir), netcdf=not arguments.no_netcdf)
            if arguments.out is not None:
                write_netcdf(table, Path(arguments.out))
                files["sky"] = arguments.out
    report = table_report(table)
    cli_options.answer(arguments, lambda: {**report, "files": files}, lambda: table_text(report, files))
    for note in notes_of(arguments) if not arguments.quiet else ():
        print(f"aomc-sky: note: {note}", file=sys.stderr)
    return 0


def _request(arguments: argparse.Namespace) -> TableRequest:
    from aomc_sky.engine.atmosphere import TableRequest
    from aomc_sky.formats.sky_toml.keys import GLOW_KEY, moon_direction
    from aomc_sky.source.light.inputs import given_lights

    lights = given_lights(cli_options.light_arguments(arguments))
    return TableRequest(
        path=arguments.path,
        sun_zenith_deg=arguments.sun_zenith,
        sun_azimuth_deg=arguments.sun_azimuth,
        wavelength_nm=arguments.wavelength,
        method=arguments.method,
        n_orders=arguments.orders,
        n_paths=arguments.paths,
        bins=None if arguments.bins is None else (arguments.bins[0], arguments.bins[1]),
        allow_paths=tuple(arguments.allow_path),
        saves=saves_of(arguments),
        significand_bits=arguments.texture_save_precision,
        moon=moon_direction(lights),
        ground_luminance_cd_m2=lights.get(GLOW_KEY, 0.0),
    )


def _check_targets(arguments: argparse.Namespace) -> None:
    """Nothing of others is replaced; beside a report of ours every file of a table is ours."""
    from aomc_sky.engine.atmosphere import DESCRIPTION_NAME, NETCDF_NAME, REPORT_HEAD, REPORT_NAME, SKYDIST_NAME
    from aomc_sky.outputs.folder.target_file import check_folder, check_target, is_ours

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
            check_target(
                path,
                "--out-dir",
                force=arguments.force or is_table,
                inputs=[arguments.path],
                is_copy=path.name == DESCRIPTION_NAME,
            )


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Fail before the work, not after it."""
    from aomc_sky.outputs.tables.atmosphere import require_netcdf

    if arguments.out_dir is None and arguments.out is None:
        raise UsageError(
            "the output is missing; write --out FILE.nc or --out-dir DIR (or --no-save-tex to check the description)"
        )
    _check_targets(arguments)
    needing = only_in_netcdf(arguments)
    if arguments.no_netcdf and needing and arguments.out is None:
        raise UsageError(f"{', '.join(needing)}: this is written to atmosphere.nc, which --no-netcdf leaves out")
    if not arguments.no_netcdf or arguments.out is not None:
        require_netcdf()


def table_text(report: Mapping[str, Any], files: Mapping[str, str]) -> str:
    """A description, its species, and where they are solved the skies, for a person; `files` by their role."""
    wavelength = report["wavelength_nm"]
    zenith, azimuth = report["bins"]
    lines = [
        f"{report['description']}: {len(wavelength)} wavelengths, {wavelength[0]:g} to {wavelength[-1]:g} nm, "
        f"{_counted(len(report['suns']), 'sun', 'suns')}, {zenith} x {azimuth} patches",
        "",
        _species(report),
    ]
    if report["dropped"]:
        lines += ["", f"too thin to count, left out: {', '.join(report['dropped'])}"]
    if report["sizes"]:
        lines += ["", _sizes(report["sizes"])]
    if "direct_irradiance" not in report["suns"][0]:
        planned = ", ".join(f"{sun['sun_zenith_deg']:g} ({sun['method']})" for sun in report["suns"])
        return "\n".join([*lines, "", f"suns, not solved: {planned}"])
    lines += [
        "",
        _suns_line(report["suns"]),
        *(
            f"{sun['sun_zenith_deg']:g}: {sun['method']} because {sun['reason']}"
            for sun in report["suns"]
            if sun["reason"]
        ),
        "",
        f"{_counted(len(report['suns']), 'sky', 'skies')} in {report['seconds']:.2f} s",
    ]
    lines += [f"{role}: {path}" for role, path in files.items() if not role.startswith("skydist ")]
    n_skydist = sum(role.startswith("skydist ") for role in files)
    if n_skydist:
        lines.append(f"skydist.inp: {n_skydist} files, one in the folder of each sun")
    return "\n".join(lines)


def _counted(n: int, one: str, several: str) -> str:
    return f"{n} {one if n == 1 else several}"


def _ends(values: Sequence[float], form: str) -> str:
    """A value, or the values of the first and the last wavelength."""
    first, last = format(values[0], form), format(values[-1], form)
    return first if first == last else f"{first} ... {last}"


def _species(report: Mapping[str, Any]) -> str:
    rows = [
        (name, _ends(depth, ".4g"), _ends(report["phase_norm"][name], ".6f") if name in report["phase_norm"] else "-")
        for name, depth in report["optical_depth"].items()
    ]
    return table(rows, ("species", "optical depth", "integral of phase function"))


def _sizes(sizes: Mapping[str, int]) -> str:
    return table([(key, str(size)) for key, size in sizes.items()], ("size in the description", "value"))


def _suns_line(suns: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        (
            f"{sun['sun_zenith_deg']:g}",
            f"{sun['method']}, {sun['orders']}",
            _ends(sun["direct_irradiance"], ".4g"),
            _ends(sun["diffuse_irradiance"], ".4g"),
            "-" if sun["truncation"] is None else f"{max(sun['truncation']):.1e}",
            f"{max(sun['largest_relative_error']):.1e}",
            f"{sum(sun['seconds'].values()):.2f}",
        )
        for sun in suns
    ]
    head = ("sun", "method, orders", "direct W m-2 nm-1", "diffuse W m-2 nm-1", "left out", "error", "s")
    return table(rows, head)


_SAVES = {
    "--save-irradiance": "irradiances order by order",
    "--save-scat-density2-from-ground": "source function of order 2 from light of the ground, with --method sos",
    "--save-scat-density": "source functions of orders 2 and up, with --method sos",
    "--save-delta-scattering": "radiance order by order; it is written in any case",
    "--save-accum-scattering": "radiance of all orders up to each",
    "--save-light-pollution": "light of a ground of 1 cd/m2, order by order, by backward paths",
}

_UNUSED = {
    "no_eds_tex": "--no-eds-tex has no effect: there is no texture of eclipsed double scattering to leave out",
    "save_delta_scattering": "--save-delta-scattering has no effect: radiance_by_order is written in any case",
}


def _add_calcmysky_options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group("options of calcmysky")
    group.add_argument(
        "--radiance", action="store_true", help="write spectral radiances; this is what is written in any case"
    )
    group.add_argument(
        "--xyzw", action="store_true",
        help="write X, Y, Z and scotopic luminance too, in cd/m2, as calcmysky does without --radiance; needs the "
        "extra 'colour'",
    )  # fmt: skip
    group.add_argument(
        "--no-save-tex", action="store_true", help="read and check the description, print the plan, solve nothing"
    )
    group.add_argument("--no-eds-tex", action="store_true", help="accepted; there is no such texture here")
    group.add_argument(
        "--texture-save-precision", type=_significand_bits, metavar="BITS",
        help="atmosphere.nc in float32 with significands of 1 to 24 bits (default: float64)",
    )  # fmt: skip
    for option, text in _SAVES.items():
        group.add_argument(option, action="store_true", help=text)
    for option, text in (
        ("--opengl-info", "print processor, versions and environment"),
        ("--opengl-debug", "the same, and say which method is chosen and why"),
        ("--opengl-debug-full", "the same with all details"),
    ):
        group.add_argument(option, action="store_true", help=f"{text}; OpenGL is not used")


def _significand_bits(text: str) -> int:
    value = cli_options.whole_number(text)
    if not 1 <= value <= 24:
        raise argparse.ArgumentTypeError(f"wanted 1 to 24 bits, got {text}")
    return value


def saves_of(arguments: argparse.Namespace) -> Saves:
    """What the options want in the table besides radiances."""
    from aomc_sky.outputs.tables.atmosphere import Saves

    return Saves(
        irradiance=arguments.save_irradiance,
        source_from_ground=arguments.save_scat_density2_from_ground,
        source=arguments.save_scat_density,
        cumulative=arguments.save_accum_scattering,
        glow=arguments.save_light_pollution,
        xyzw=arguments.xyzw,
    )


def only_in_netcdf(arguments: argparse.Namespace) -> list[str]:
    """The options given that say something about atmosphere.nc alone."""
    named = [option for option in (*_SAVES, "--xyzw") if getattr(arguments, option[2:].replace("-", "_"))]
    return named + ["--texture-save-precision"] * (arguments.texture_save_precision is not None)


def notes_of(arguments: argparse.Namespace) -> list[str]:
    """What is to be said of options that were given and change nothing."""
    return [text for name, text in _UNUSED.items() if getattr(arguments, name)]


@contextlib.contextmanager
def diagnostics(arguments: argparse.Namespace) -> Iterator[None]:
    """Print the environment and let the package speak on standard error, where the options want it."""
    is_wordy = arguments.opengl_debug or arguments.opengl_debug_full
    if is_wordy or arguments.opengl_info:
        print(_environment(), file=sys.stderr)
    if not is_wordy:
        yield
        return
    handler, logger = logging.StreamHandler(sys.stderr), logging.getLogger("aomc_sky")
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG if arguments.opengl_debug_full else logging.INFO)
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(handler)


def _environment() -> str:
    import platform
    from importlib.metadata import version

    libraries = " ".join(f"{name} {version(name)}" for name in ("aomc-sky", "numpy", "numba", "scipy"))
    machine = f"{platform.machine()}, {os.cpu_count()} cores, {platform.platform()}, python {platform.python_version()}"
    switches = [f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith("NUMBA_")]
    return "\n".join(
        [f"machine: {machine} {libraries}", f"numba: {' '.join(switches) or 'no switches set'}", "OpenGL: not used"]
    )
