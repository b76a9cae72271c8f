"""``aomc-sky export``: other formats from a run folder."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.engine.export_formats import exports
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser

_EPILOG = """\
examples:
  aomc-sky export out --to mcpl                       out.mcpl beside out
  aomc-sky export out --to netcdf --out sky.nc        counts and masses of every patch and waveband
  aomc-sky export out --to aomc --scene amc.inp --out for_aomc   a folder that the AOMC program runs
  aomc-sky export out --to envmap                     radiance as a latitude-longitude map for renderers
  aomc-sky export out --to envmap --waveband 2 --out sky.hdr     the same as a picture of Radiance; or .exr, .npy
  aomc-sky export out --to source --out day.sky       the source for a code in C or Fortran, with aomc_sky.h
"""

GROUPS = {"": "to export.out export.waveband export.scene threads export.force json quiet"}


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Write a run in another format. Everything comes from the run's plan.npz: a run with --format none will do."
    )
    parser.epilog = _EPILOG
    parser.add_argument("run", metavar="RUN", help="run folder")
    cli_options.add_groups(parser, GROUPS)
    parser.set_defaults(handler=export, resumes=True)


def export(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.engine.export import ExportOptions, export_run
    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.progress import progress_bar, status_line

    options = ExportOptions(
        to=arguments.to,
        out=arguments.out,
        wavebands=arguments.waveband,
        scene=arguments.scene,
        threads=arguments.threads or 0,
        force=arguments.force,
    )
    _check(arguments)
    with status_line("reading the run", enabled=cli_options.is_verbose(arguments)):
        run = open_run(arguments.run)
    with progress_bar(enabled=cli_options.is_verbose(arguments)) as progress:
        result = export_run(run, options, progress)
    cli_options.answer(arguments, lambda: result, lambda: _text(result))
    return 0


def _check(arguments: argparse.Namespace) -> None:
    from aomc_sky.outputs.run_folder import check_folder

    if arguments.scene is not None and arguments.to != "aomc":
        raise UsageError("--scene is for --to aomc")
    if arguments.waveband and exports()[arguments.to].holds_all:
        raise UsageError(f"--to {arguments.to} holds all wavebands", "select one when you read it")
    if arguments.out == "-":
        raise UsageError("--out - is for run; an export has a file or a folder: name it, for example --out sky")
    if arguments.out is not None:
        check_folder(arguments.out, "--out")


def _text(result: dict[str, Any]) -> str:
    lines = [f"note: {note}" for note in result["notes"]]
    if result["was_finished"]:
        lines.append("all files exist already; nothing was done again (--force makes them again)")
    n_bands, files = len(result["wavebands"]), result["files"]
    n_bytes = sum(file["bytes"] for file in files.values())
    lines.append(
        f"{result['photons']} photons in {n_bands} waveband{'s' if n_bands > 1 else ''}, seed {result['seed']}, as "
        f"{result['to']}: {len(files)} file{'s' if len(files) > 1 else ''}, {n_bytes} bytes, {result['seconds']:.2f} s"
    )
    lines.append(f"plan {result['plan_sha256'][:16]}, {result['out']}")
    return "\n".join(lines)
