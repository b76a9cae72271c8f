"""``aomc-sky lobes``: background-sky files at one time, without AMC files."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.commands.run import MAX_COMPONENTS, MAX_ROWS
from aomc_sky.cli.options import add_background_options, moment
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.source.backgrounds.scene import LobeScene

MAX_LOBES = 100

_EPILOG = """\
examples:
  aomc-sky lobes night.h5 --time 2026-02-14T21:30:00Z --utc-offset 1
  aomc-sky lobes night.h5 town.h5 --time 2026-02-14T22:30:00+01:00 --wavelength 450 550 650 --json
  aomc-sky lobes night.h5 --time 1771104600 --animation city --plot city.png
  aomc-sky lobes night.h5 --time 2026-02-14T21:30:00Z --wavelength 550 --out night    photons, skydist.inp, picture
"""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Print the lobes of background-sky files at one time, their irradiance per wavelength and the share "
        "below the horizon; write them as skydist.inp, netCDF, picture or photons. The light of several files adds."
    )
    parser.epilog = _EPILOG
    parser.add_argument("paths", nargs="+", metavar="FILE", help="background-sky files (HDF5; need the extra 'hdf5')")
    _add_sky_options(parser)
    _add_output_options(parser)
    parser.show_first("time wavelength utc-offset animation out iterations write-skydist netcdf plot force json quiet")
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
    cli_options.add_bins(group, "equal bins of skydist.inp and netCDF (default 18 72)", [18, 72])
    cli_options.add_shared(group, "write-skydist")
    group.add_argument("--netcdf", metavar="FILE", help="radiances and irradiances (needs the extra 'netcdf')")
    cli_options.add_shared(group, "plot")
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
    cli_options.add_shared(group, "seed", help="with --out: seed (default 0)")
    group.add_argument(
        "--format",
        choices=("npy", "mcpl", "none"),
        metavar="npy|mcpl|none",
        action="append",
        help="with --out: photon files, repeatable (default npy); none: counts and plan only",
    )
    group.add_argument(
        "--force", action="store_true", help="replace another run in the folder, and files that another program wrote"
    )
    cli_options.add_shared(group, "strict json quiet")


def lobes(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none stands alone")
    if arguments.out is None and arguments.format:
        raise UsageError("--format needs --out")
    from aomc_sky.cli.progress import patience

    with patience("making the sky", enabled=cli_options.speaks(arguments)):
        scene = _scene(arguments)
        written = write_files(scene, arguments, formats)
    cli_options.answer(arguments, lambda: {**as_json(scene), "written": written}, lambda: as_text(scene, written))
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


def write_files(scene: LobeScene, arguments: argparse.Namespace, formats: tuple[str, ...]) -> dict[str, str]:
    """Write everything that the options ask for; return what was written, and where."""
    from aomc_sky.outputs.folder.target_file import check_folder, check_target

    written: dict[str, str] = {}
    skydist, picture = arguments.write_skydist, arguments.plot
    if arguments.netcdf is not None:
        for name in ("xarray", "h5netcdf", "h5py"):
            optional_module(name, extra="netcdf")
    if picture is not None:
        optional_module("matplotlib", extra="plot")
    if arguments.out is not None:
        check_folder(arguments.out, "--out")
        skydist = str(Path(arguments.out) / "skydist.inp") if skydist is None else skydist
        if picture is None and find_spec("matplotlib") is not None:
            picture = str(Path(arguments.out) / "sky.png")
    files = {"--write-skydist": skydist, "--netcdf": arguments.netcdf, "--plot": picture}
    for option, path in files.items():
        if path is not None:
            check_target(path, option, force=arguments.force, inputs=[section.file for section in scene.sections])
    if arguments.out is not None:
        written["photons"] = _write_photons(scene, arguments, formats)
    if skydist or arguments.netcdf:
        written |= _write_tables(scene, arguments, skydist)
    if picture:
        write_picture(scene, picture)
        written["picture"] = picture
    elif arguments.out is not None:
        written["no picture"] = 'install matplotlib: pip install "aomc-sky[plot]"'
    return written


def _write_photons(scene: LobeScene, arguments: argparse.Namespace, formats: tuple[str, ...]) -> str:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.run import JobOptions, run_job

    sampled = scene.scene(arguments.iterations)
    source = sampled.source(arguments.seed)
    options = JobOptions(formats=formats, force=arguments.force)
    with progress_bar(enabled=cli_options.speaks(arguments)) as progress:
        run_job(source, sampled, Path(arguments.out), options, progress)
    return str(arguments.out)


def _write_tables(scene: LobeScene, arguments: argparse.Namespace, skydist: str | None) -> dict[str, str]:
    from aomc_sky.grid import PatchGrid
    from aomc_sky.outputs.tables.lobes import patch_radiance, write_lobe_netcdf, write_lobe_skydist

    grid = PatchGrid.regular(*arguments.bins)
    radiance = patch_radiance(scene, grid)
    writers: list[tuple[str, str | None, Callable[[str], None]]] = [
        ("radiances", skydist, lambda path: write_lobe_skydist(scene, radiance, path)),
        ("dataset", arguments.netcdf, lambda path: write_lobe_netcdf(scene, radiance, grid, path)),
    ]
    for _, path, write in writers:
        if path:
            write(path)
    return {what: path for what, path, _ in writers if path}


def write_picture(scene: LobeScene, path: str) -> None:
    """Draw the sky dome at the wavelength nearest to 550 nm."""
    import numpy as np

    from aomc_sky.formats.sky_toml.rules import moment_text
    from aomc_sky.outputs.picture import picture_path, save_picture
    from aomc_sky.pictures.animate import lobe_picture
    from aomc_sky.pictures.panels import figure_of

    target = picture_path(path)
    wavelength = float(scene.wavelength_nm[np.argmin(np.abs(scene.wavelength_nm - 550.0))])
    files = ", ".join(Path(section.file).name for section in scene.sections)
    title = f"{files} at {wavelength:g} nm\n{moment_text(scene.sections[0].time)}"
    figure = figure_of(lobe_picture([("", scene.skies)], wavelength, title=title))
    save_picture(figure, target, dpi=figure.dpi)


def as_json(scene: LobeScene) -> dict[str, Any]:
    """Lobes and irradiances as JSON values. [W m-2 nm-1, nm, deg]"""
    from aomc_sky.formats.sky_toml.rules import moment_text
    from aomc_sky.source.backgrounds.scene import axis_of

    first = scene.sections[0]
    sphere, plane = scene.irradiance(), scene.irradiance(above="projected")
    return {
        "files": [section.file for section in scene.sections],
        "time": moment_text(first.time),
        "unix_time_s": first.time,
        "utc_offset_h": first.utc_offset,
        "interpolation": first.interpolation,
        "wavelength_nm": scene.wavelength_nm.tolist(),
        "sphere_W_m2_nm": sphere.sum(axis=0).tolist(),
        "irradiance_W_m2_nm": plane.sum(axis=0).tolist(),
        "horizon_loss": scene.horizon_loss.tolist(),
        "lobes": [
            {
                "name": name,
                "kind": lobe.kind,
                "param0": lobe.param0,
                "param1": lobe.param1,
                "quaternion": lobe.quaternion.tolist(),
                "zenith_deg": axis_of(lobe)[0],
                "azimuth_deg": axis_of(lobe)[1],
                "share_above_horizon": scene.share(lobe, "plain"),
                "share_on_horizontal": scene.share(lobe, "projected"),
                "sphere_W_m2_nm": sphere[k].tolist(),
                "irradiance_W_m2_nm": plane[k].tolist(),
            }
            for k, (name, lobe) in enumerate(scene.lobes)
        ],
    }


def as_text(scene: LobeScene, written: dict[str, str]) -> str:
    """Background skies for a person."""
    values = as_json(scene)
    lines = [
        f"{', '.join(values['files'])} at {values['time']}, local midnight {values['utc_offset_h']:+g} h from UTC, "
        f"{values['interpolation']} between keys",
        "",
    ]
    if not values["lobes"]:
        lines.append("no lobe has light at this time")
    else:
        lines += [*_lobe_lines(values), "", *_irradiance_lines(values)]
    lines += ["", *(f"{what}: {where}" for what, where in written.items())]
    return "\n".join(lines).rstrip()


def _lobe_lines(values: dict[str, Any]) -> list[str]:
    rows = [
        (
            lobe["name"],
            lobe["kind"],
            f"{lobe['param0']:g}",
            "-" if lobe["kind"] == "hg" else f"{lobe['param1']:g}",
            f"{lobe['zenith_deg']:.3f}",
            f"{lobe['azimuth_deg']:.3f}",
            f"{lobe['share_above_horizon']:.6f}",
            f"{lobe['share_on_horizontal']:.6f}",
        )
        for lobe in values["lobes"][:MAX_LOBES]
    ]
    head = ("lobe", "kind", "g, alpha x", "alpha y", "zenith", "azimuth", "above", "on plane")
    lines = [
        "shares of each lobe above the horizon and on a horizontal plane; azimuth from +x (east) towards +y (north)",
        table(rows, head),
    ]
    hidden = len(values["lobes"]) - len(rows)
    return lines if hidden <= 0 else [*lines, f"... and {hidden} more lobes (--json has all)"]


def _irradiance_lines(values: dict[str, Any]) -> list[str]:
    by_light = sorted(values["lobes"], key=lambda lobe: -max(lobe["irradiance_W_m2_nm"]))
    shown = by_light[:MAX_COMPONENTS]
    rows = [
        (
            f"{wavelength:g}",
            f"{values['sphere_W_m2_nm'][k]:.5g}",
            f"{values['irradiance_W_m2_nm'][k]:.5g}",
            f"{values['horizon_loss'][k]:.6f}",
            *(f"{lobe['irradiance_W_m2_nm'][k]:.4g}" for lobe in shown),
        )
        for k, wavelength in enumerate(values["wavelength_nm"][:MAX_ROWS])
    ]
    lines = [
        "irradiance over the sphere, and Ed on a horizontal plane, of all lobes and of each [W m-2 nm-1]; "
        "below: share from below the horizon",
        table(rows, ("nm", "sphere", "Ed", "below", *(lobe["name"] for lobe in shown))),
    ]
    if len(values["wavelength_nm"]) > MAX_ROWS or len(by_light) > len(shown):
        lines.append(f"... {len(values['wavelength_nm'])} wavelengths, {len(by_light)} lobes (--json has all)")
    return lines
