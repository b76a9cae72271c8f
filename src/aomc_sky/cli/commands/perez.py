"""``aomc-sky perez``: one Perez sky without AMC files."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import report_text
from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.options import PEREZ, WEATHER_FILES

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.skies.perez.sky import PerezSky
    from aomc_sky.source.light.place import Sun
    from aomc_sky.source.light.said import Speakers
    from aomc_sky.source.scene import Scene

_EPILOG = """\
examples:
  aomc-sky perez --sun-zenith 40 --dni 850 --dhi 95
  aomc-sky perez --time 2026-06-21T09:30:00Z --latitude 54.2 --longitude 7.9 --dni 850 --dhi 95
  aomc-sky perez --weather site.epw --row 4000 --plot sky.png --write-skydist skydist.inp
  aomc-sky perez --weather site.epw --row 4000 --iterations 1e6 --out sky     its photons, as `run` writes them
"""

_PHOTONS = "format threads max_memory perez.wavelengths perez.diffuse_only with_beam perez.verbose"
GROUPS = {
    **cli_options.WHEN,
    "the sun, without a weather file": "zenith_deg azimuth_deg",
    "the sky: two of dni, dhi and ghi, epsilon and delta, or coefficients": f"{' '.join(PEREZ)} polarisation",
    "what is written and printed": "perez.bins write_skydist perez.wavelength plot perez.out perez.iterations seed "
    "perez.force fail_on_warnings json quiet",
    **cli_options.DRAWN,
    "photons, with --out": _PHOTONS,
}
_OF_PHOTONS = (*cli_options.names_of(cli_options.DRAWN), *_PHOTONS.split())
FIRST = "dni dhi sun-zenith time latitude longitude weather row out iterations seed write-skydist plot json"


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Print clearness, brightness, coefficients and normalisation of a Perez sky; write it as "
        "skydist.inp, as photons or as a picture."
    )
    parser.epilog = _EPILOG
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=perez, resumes=True)


def perez(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.grid import PatchGrid
    from aomc_sky.progress import status_line
    from aomc_sky.source.light.brightness import brightness_of, direct_fraction, refuse_kilowatts
    from aomc_sky.source.light.place import place_of
    from aomc_sky.source.light.said import moment_said
    from aomc_sky.source.light.skies import perez_of, perez_sky
    from aomc_sky.source.light.unused import refuse_unused

    _check(arguments)
    is_shown = cli_options.is_verbose(arguments)
    with status_line("modelling the sky", enabled=is_shown):
        speakers = cli_options.said_of(arguments)
        asked = perez_of(speakers, PatchGrid.regular(*arguments.bins))
        sun, shape = place_of(speakers, "a perez sky"), asked.shape
        if shape is None:
            raise UsageError(
                "which sky? write two of --dni, --dhi and --ghi, --epsilon and --delta, or --coefficients a b c d e; a "
                "cloudless sky is made by aomc-sky run --spectrum spectrl2"
            )
        refuse_kilowatts(shape, sun)
        refuse_unused(speakers, brightness_of(speakers, asked.made_of, is_whole=False, warns=False), asked)
        if shape.coefficients is None and direct_fraction(shape, sun) == 1.0:
            hour = moment_said(speakers)
            what = "the diffuse irradiance" if hour is None or hour.path is None else f"{hour.where}: DHI"
            raise SceneError(f"{what} is 0, so there is no light in the sky")
        sky, limited = perez_sky(asked.choices, shape, sun, asked.grid)
        values = _values(sky, sun, speakers, limited)
        scene = None if arguments.out is None else _scene(speakers, arguments)
    for path, write in ((arguments.write_skydist, _write_table), (arguments.plot, _write_picture)):
        if path is not None:
            with status_line(f"writing {Path(path).name}", enabled=is_shown):
                write(sky, values, arguments, path)
    texts: list[Callable[[], str]] = [partial(report_text, _HEAD, dict(values))]
    if scene is not None:
        values["run"], text = _emit(scene, arguments)
        texts += [lambda: "", text]
    cli_options.answer(arguments, lambda: values, lambda: "\n".join(text() for text in texts))
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that contradict each other, and outputs that would replace files of others."""
    from aomc_sky.outputs.run_folder import check_folder, check_target

    if arguments.out is None:
        for name in cli_options.given_options(arguments, *_OF_PHOTONS):
            raise UsageError(f"{name} is for photons: name their folder with --out DIR")
        if arguments.spectrum is not None:
            raise UsageError("--spectrum shares beam and sky out over the photons: name their folder with --out DIR")
        if arguments.polarisation is not None:
            raise UsageError("--polarisation is for photons: name their folder with --out DIR")
    elif arguments.out == "-":
        raise UsageError("--out - is for run; perez writes a folder: name it, for example --out sky")
    else:
        cli_options.formats_of(arguments)
        check_folder(arguments.out, "--out")
    if arguments.diffuse_only and arguments.with_beam:
        raise UsageError("--diffuse-only contradicts --with-beam")
    for option, values_nm in (("--wavelength", [arguments.wavelength]), ("--wavelengths", arguments.wavelengths or [])):
        for value in values_nm:
            if not value > 0:
                raise UsageError(f"{option} must be positive, got {value:g}")
    weather = [file for file in (getattr(arguments, name) for name in WEATHER_FILES) if file is not None]
    for option, path in (("--write-skydist", arguments.write_skydist), ("--plot", arguments.plot)):
        if path is not None:
            check_target(path, option, force=arguments.force, inputs=weather)


_HEAD = (
    "Perez sky; irradiances in W m-2, azimuth from +x (east) towards +y (north), horizontal integral of f by eq. (3)"
)


def _scene(speakers: Speakers, arguments: argparse.Namespace) -> Scene:
    """A scene of sun and sky, or of the sky alone."""
    from aomc_sky.formats.sky_toml.keys import SPECTRL2
    from aomc_sky.grid import PatchGrid
    from aomc_sky.source.weather_scene import scene_of_weather

    if arguments.with_beam and arguments.coefficients is not None and arguments.spectrum != SPECTRL2:
        raise UsageError("coefficients do not say how bright the beam is", "write two of --dni, --dhi, --ghi")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "(?!spectrum )", ModelLimitWarning)  # warnings of the sky were shown before
        return scene_of_weather(
            speakers,
            arguments.wavelengths or [arguments.wavelength],
            arguments.iterations,
            grid=PatchGrid.regular(*arguments.bins),
        )


def _values(sky: PerezSky, sun: Sun, speakers: Speakers, limited: list[str]) -> dict[str, Any]:
    """A sky as JSON values; a value that does not follow from the inputs is None."""
    from aomc_sky.skies.perez.functions import epsilon_bin
    from aomc_sky.skies.perez.functions import limited as limits_of
    from aomc_sky.source.light.said import moment_said

    moment = moment_said(speakers)
    clearness, brightness, used = sky.clearness, sky.brightness, None
    if clearness is not None and brightness is not None:
        used = [float(value) for value in limits_of(clearness, brightness, limits=sky.limits)]
    integral = float(sky.relative_integral)
    beam = None if sky.dni is None else sky.dni * math.cos(sky.sun_zenith_rad)
    return {
        "source": {} if moment is None else moment.source,
        "sun_zenith_deg": sun.zenith_deg,
        "sun_azimuth_deg": sun.azimuth_deg % 360.0,
        "epsilon": None if clearness is None else float(clearness),
        "delta": None if brightness is None else float(brightness),
        "epsilon_used": None if used is None else used[0],
        "delta_used": None if used is None else used[1],
        "bin": None if used is None else int(epsilon_bin(used[0])) + 1,
        "limits": sky.limits,
        "coefficients": dict(zip("abcde", sky.model_coefficients.tolist(), strict=True)),
        "horizontal_integral": integral,
        "radiance_per_unit": None if sky.dhi is None else sky.dhi / integral,
        "dni": sky.dni,
        "dhi": sky.dhi,
        "direct_horizontal": beam,
        "ghi": None if beam is None or sky.dhi is None else beam + sky.dhi,
        "extraterrestrial_normal": sky.extraterrestrial_normal,
        "air_mass": sky.air_mass,
        "warnings": limited,
    }


def _write_table(sky: PerezSky, values: dict[str, Any], arguments: argparse.Namespace, path: str) -> None:
    """Write skydist.inp: the mean radiance of each patch, weighted with the cosine.

    Mass = radiance x projected solid angle, so a scene that reads the table has the masses of the model.
    """
    import numpy as np

    from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, write_skydist

    grid = sky.patches
    scale = values["horizontal_integral"] if sky.dhi is None else sky.dhi
    radiance = sky.patch_mass(grid) * scale / grid.projected_solid_angle_sr
    radiance = radiance.reshape(1, grid.n_zenith, grid.n_azimuth)
    table = SkyTable(wavelength_nm=np.array([arguments.wavelength]), radiance=radiance, path=path)
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


def _write_picture(sky: PerezSky, values: dict[str, Any], arguments: argparse.Namespace, path: str) -> None:
    """Draw the sky dome."""
    from aomc_sky.pictures.plot import plot

    what = "" if values["epsilon"] is None else f", ε = {values['epsilon']:.4g}, Δ = {values['delta']:.3g}"
    when = values["source"].get("sun_at") or values["source"].get("time")
    plot(sky, path, title="Perez sky" + what + (f"\n{when}" if when else ""))


def _emit(scene: Scene, arguments: argparse.Namespace) -> tuple[dict[str, Any], Callable[[], str]]:
    """Write the run folder of one sky; returns its manifest, and the text that `run` would print."""
    from aomc_sky.cli.commands.run import run_text
    from aomc_sky.engine.run import run_job
    from aomc_sky.progress import progress_bar

    source = cli_options.source_of(scene, arguments)
    folder = Path(arguments.out)
    with progress_bar(enabled=cli_options.is_verbose(arguments)) as progress:
        result = run_job(source, scene, folder, cli_options.job_options(arguments), progress)
    manifest = {**(result.manifest or {}), "folder": str(folder), "was_finished": result.was_finished}
    return manifest, partial(run_text, scene, source, result, folder, verbose=arguments.verbose)
