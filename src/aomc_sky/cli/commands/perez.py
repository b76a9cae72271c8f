"""``aomc-sky perez``: one Perez sky without AMC files."""

from __future__ import annotations

import argparse
import dataclasses
import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.cli.usage import Parser
    from aomc_sky.grid import PatchGrid
    from aomc_sky.skies.perez.sky import PerezSky
    from aomc_sky.source.light.inputs import GivenInputs
    from aomc_sky.source.scene import Scene

WEATHER = ("epw", "tmy2", "tmy3")
_SKY_OPTIONS = ("dni", "dhi", "ghi", "epsilon", "delta", "coefficients")

_EPILOG = """\
examples:
  aomc-sky perez --sun-zenith 40 --dni 850 --dhi 95
  aomc-sky perez --time 2026-06-21T09:30:00Z --latitude 54.2 --longitude 7.9 --dni 850 --dhi 95
  aomc-sky perez --epw site.epw --row 4000 --plot sky.png --write-skydist skydist.inp
  aomc-sky perez --epw site.epw --row 4000 --iterations 1e6 --out sky     its photons, as `run` writes them
"""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Print clearness, brightness, coefficients and normalisation of a Perez sky; write it as "
        "skydist.inp, as photon counts, as photons or as a picture."
    )
    parser.epilog = _EPILOG
    cli_options.add_moment_options(parser)
    _add_sun_options(parser)
    _add_sky_options(parser)
    cli_options.add_sampling_options(parser)
    _add_output_options(parser)
    parser.show_first("dni dhi sun-zenith time latitude longitude epw row out iterations seed write-skydist plot json")
    parser.set_defaults(handler=perez, resumes=True)


def _add_sun_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sun, without a weather file")
    group.add_argument(
        "--sun-zenith", type=cli_options.finite_number, metavar="DEG", help="zenith angle, 0 to below 90"
    )
    group.add_argument(
        "--sun-azimuth",
        type=cli_options.finite_number,
        metavar="DEG",
        help="azimuth from +x (east) towards +y (north), default 0",
    )


def _add_sky_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the sky: two of dni, dhi and ghi, epsilon and delta, or coefficients")
    cli_options.add_perez_inputs(group, of_scene=False)
    cli_options.add_perez_choices(group, of_scene=False)


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    cli_options.add_bins(group, "equal bins (default 45 180)", [45, 180])
    cli_options.add_shared(group, "write-skydist")
    group.add_argument(
        "--wavelength",
        type=cli_options.finite_number,
        metavar="NM",
        default=550.0,
        help="wavelength of the table in skydist.inp, and of photons (default 550)",
    )
    group.add_argument("--counts", metavar="FILE", help="photons of every patch as CSV")
    cli_options.add_shared(group, "plot")
    group.add_argument(
        "--iterations", type=cli_options.photon_total, metavar="N", default=10**6, help="photons (default 1e6)"
    )
    cli_options.add_shared(group, "seed")
    group.add_argument("--out", metavar="DIR", help="run folder with the photons of the sky")
    cli_options.add_shared(group, "format threads max-memory")
    group.add_argument("--with-beam", action="store_true", help="with --out: photons of the direct beam too")
    group.add_argument(
        "--force",
        action="store_true",
        help="replace files that another program wrote, and another run in the folder",
    )
    cli_options.add_shared(group, "strict json quiet")
    group.add_argument("-v", "--verbose", action="store_true", help="with --out: print how photons are drawn")


def perez(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    kind = next((kind for kind in WEATHER if getattr(arguments, kind) is not None), None)
    if arguments.out is None:
        for name in cli_options.given_options(arguments, _add_options_of_out):
            raise UsageError(f"{name} is for photons: name their folder with --out DIR")
    return _one_sky(arguments, kind)


def _add_options_of_out(parser: argparse.ArgumentParser) -> None:
    """The options that say nothing of a sky without photons."""
    cli_options.add_sampling_options(parser)
    cli_options.add_shared(parser, "format threads max-memory")
    parser.add_argument("--with-beam", action="store_true")
    parser.add_argument("-v", "--verbose", action="store_true")


def _one_sky(arguments: argparse.Namespace, kind: str | None) -> int:
    from aomc_sky.cli.progress import patience
    from aomc_sky.outputs.folder.target_file import check_folder, check_target

    weather = None if kind is None else getattr(arguments, kind)
    files = (
        ("--write-skydist", arguments.write_skydist, _write_table),
        ("--counts", arguments.counts, _write_counts),
        ("--plot", arguments.plot, _write_picture),
    )
    for option, path, _ in files:
        if path is not None:
            check_target(path, option, force=arguments.force, inputs=() if weather is None else (weather,))
    if arguments.out is not None:
        cli_options.formats_of(arguments)
        if arguments.out == "-":
            raise UsageError("--out - is for run; perez writes a folder: name it, for example --out sky")
        check_folder(arguments.out, "--out")
    shown = cli_options.speaks(arguments)
    with patience("modelling the sky", enabled=shown):
        modelled = _resolve(arguments)
    for _, path, write in files:
        if path is not None:
            with patience(f"writing {Path(path).name}", enabled=shown):
                write(modelled, arguments, path)
    run = {} if arguments.out is None else _emit(modelled, arguments)
    of_run = {"run": run["manifest"]} if run else {}
    cli_options.answer(
        arguments,
        lambda: {**_as_json(modelled), **of_run},
        lambda: "\n\n".join([_as_text(modelled), *([run["text"]] if run else [])]),
    )
    return 0


@dataclass(frozen=True, kw_only=True, slots=True)
class ModelledSky:
    """A sky, what it came from, and the masses of its patches."""

    sky: PerezSky
    sun_zenith_deg: float  #: as it is seen, with refraction
    sun_azimuth_deg: float  #: from +x towards +y
    dni: float | None  #: where it is known [W m-2]
    dhi: float | None  #: where it is known [W m-2]
    extraterrestrial_normal: float  #: what Delta was computed with [W m-2]
    source: dict[str, Any]  #: where sun and irradiances came from: JSON values
    path: str | None  #: of the weather file
    grid: PatchGrid
    mass: np.ndarray  #: share of each patch of the grid, shape (n_patch,)
    warnings: tuple[str, ...]  #: what the model had to limit


def _resolve(arguments: argparse.Namespace) -> ModelledSky:
    """Find the sky, and say in warnings what its model had to limit."""
    from aomc_sky.grid import PatchGrid
    from aomc_sky.skies.perez.irradiances import EXTRATERRESTRIAL_NORMAL
    from aomc_sky.skies.perez.sky import PerezSky

    given = _given(arguments)
    sun, weather = given.sun, given.weather
    assert sun.zenith_deg is not None, "checked in _given"
    dated = EXTRATERRESTRIAL_NORMAL if weather is None else weather.extraterrestrial_normal
    extraterrestrial = dated if arguments.extraterrestrial is None else arguments.extraterrestrial
    if not extraterrestrial > 0:
        raise UsageError(f"--extraterrestrial must be positive, got {extraterrestrial:g}")
    grid = PatchGrid.regular(*arguments.bins)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = PerezSky(
            sun_zenith_rad=math.radians(sun.zenith_deg),
            sun_azimuth_rad=math.radians(sun.azimuth_deg or 0.0),
            limits=arguments.limits,
            air_mass=arguments.air_mass,
            extraterrestrial_normal=extraterrestrial,
            **given.perez.as_arguments(),
        )
        if sky.is_dark:
            what = "the diffuse irradiance" if weather is None or weather.path is None else f"{weather.where}: DHI"
            raise SceneError(f"{what} is 0, so there is no light in the sky")
        mass = sky.patch_mass(grid)
    texts = tuple(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)))
    for text in texts:
        warnings.warn(text, ModelLimitWarning, stacklevel=2)
    return ModelledSky(
        sky=sky,
        sun_zenith_deg=sun.zenith_deg,
        sun_azimuth_deg=sun.azimuth_deg or 0.0,
        dni=sky.dni,
        dhi=sky.dhi,
        extraterrestrial_normal=extraterrestrial,
        source={} if weather is None else weather.source,
        path=None if weather is None else weather.path,
        grid=grid,
        mass=mass,
        warnings=texts,
    )


def _given(arguments: argparse.Namespace) -> GivenInputs:
    """What the options say of sun and sky: a place of the sun, and a whole set of the model's inputs."""
    from aomc_sky.formats.sky_toml.keys import COEFFICIENT_NAMES
    from aomc_sky.source.light.inputs import given_inputs

    values = {name: getattr(arguments, name) for name in _SKY_OPTIONS if name != "coefficients"}
    if arguments.coefficients is not None:
        values.update(zip(COEFFICIENT_NAMES, arguments.coefficients, strict=True))
    zenith, azimuth = arguments.sun_zenith, arguments.sun_azimuth
    moment = cli_options.moment_arguments(arguments)
    if not moment:
        if zenith is None:
            raise UsageError("where is the sun? write --sun-zenith, or --time, --latitude and --longitude")
        if not 0 <= zenith < 90:
            raise SceneError(f"a sky needs the sun above the horizon, 0 to below 90 degrees, got {zenith:g}")
    sun = {"zenith_deg": zenith, "azimuth_deg": None if azimuth is None else azimuth % 360.0}
    given = given_inputs(values, sun, None, weather=moment)
    if given.weather is not None:
        given.weather.require_sun()
    if not given.perez.has_set:
        raise UsageError(
            "which sky? write two of --dni, --dhi and --ghi, --epsilon and --delta, or --coefficients a b c d e"
        )
    return given


def _as_json(modelled: ModelledSky) -> dict[str, Any]:
    """One sky as JSON values; None where the inputs do not tell."""
    from aomc_sky.skies.perez.functions import epsilon_bin, limited

    sky, dni, dhi = modelled.sky, modelled.dni, modelled.dhi
    clearness, brightness = sky.clearness, sky.brightness
    used: tuple[float, float] | None = None
    if clearness is not None and brightness is not None:
        used = tuple(float(value) for value in limited(clearness, brightness, limits=sky.limits))  # type: ignore[assignment]
    integral = float(sky.relative_integral)
    beam = None if dni is None else dni * math.cos(sky.sun_zenith_rad)
    return {
        "source": modelled.source,
        "sun_zenith_deg": modelled.sun_zenith_deg,
        "sun_azimuth_deg": modelled.sun_azimuth_deg,
        "epsilon": None if clearness is None else float(clearness),
        "delta": None if brightness is None else float(brightness),
        "epsilon_used": None if used is None else used[0],
        "delta_used": None if used is None else used[1],
        "bin": None if used is None else int(epsilon_bin(used[0])) + 1,
        "limits": sky.limits,
        "coefficients": dict(zip("abcde", sky.model_coefficients.tolist(), strict=True)),
        "horizontal_integral": integral,
        "radiance_per_unit": None if dhi is None else dhi / integral,
        "dni": dni,
        "dhi": dhi,
        "direct_horizontal": beam,
        "ghi": None if beam is None or dhi is None else beam + dhi,
        "extraterrestrial_normal": modelled.extraterrestrial_normal,
        "air_mass": sky.air_mass,
        "warnings": list(modelled.warnings),
    }


def _as_text(modelled: ModelledSky) -> str:
    """One sky for a person."""
    values = _as_json(modelled)
    rows = [*_source_rows(values["source"]), ("sun", _sun_text(values))]
    if values["dhi"] is not None:
        texts = [f"{name.upper()} {values[name]:g}" for name in ("dni", "dhi", "ghi")]
        texts.append(f"direct horizontal {values['direct_horizontal']:g} W m-2")
        rows.append(("irradiances", ", ".join(texts)))
    if values["epsilon"] is not None:
        rows.append(("epsilon", f"{values['epsilon']:.6g}, bin {values['bin']} of 8" + _used(values, "epsilon")))
        how = f" (extraterrestrial {values['extraterrestrial_normal']:g} W m-2, air mass {values['air_mass']})"
        rows.append(("Delta", f"{values['delta']:.6g}" + _used(values, "delta") + (how if values["dhi"] else "")))
    rows.append(("coefficients", "  ".join(f"{k} {v:.6g}" for k, v in values["coefficients"].items())))
    rows.append(("integral", f"{values['horizontal_integral']:.10g} (of f cos over the hemisphere, eq. 3)"))
    if values["radiance_per_unit"] is not None:
        rows.append(("radiance", f"{values['radiance_per_unit']:.6g} W m-2 sr-1 times f"))
    limits = {"radiance": "published practice (radiance)", "paper": "none (paper)"}[values["limits"]]
    rows.append(("limits", limits))
    rows += [("limited", text.partition(": ")[2] or text) for text in values["warnings"]]
    return "\n".join(f"{name:13s} {text}" for name, text in rows)


def _source_rows(source: dict[str, Any]) -> list[tuple[str, str]]:
    def site() -> str:
        return f"latitude {source['latitude_deg']:g}, longitude {source['longitude_deg']:g}"

    if "weather" in source:
        start, end = source["hour"]
        name = "".join(c if c.isprintable() else "?" for c in source["place"])
        return [
            ("weather", f"{source['weather']}:{source['line']}, row {source['row']}, {name}, {site()}"),
            ("hour", f"{start} to {end}, sun at {source['sun_at']}"),
        ]
    return [("time", f"{source['time']}, {site()}")] if "time" in source else []


def _sun_text(values: dict[str, Any]) -> str:
    zenith, azimuth = values["sun_zenith_deg"], values["sun_azimuth_deg"]
    true = values["source"].get("true_zenith_deg")
    seen = "" if true is None else f" (as seen; {true:.4f} without refraction)"
    return f"zenith {zenith:.4f} deg{seen}, azimuth {azimuth:.4f} deg from +x (east) towards +y (north)"


def _used(values: dict[str, Any], name: str) -> str:
    """What the coefficients were taken at, where that is another value."""
    return "" if values[name] == values[f"{name}_used"] else f", limited to {values[f'{name}_used']:g}"


def _write_table(modelled: ModelledSky, arguments: argparse.Namespace, path: str) -> None:
    """Write skydist.inp: the mean radiance of each patch, weighted as its photons are.

    Read back, the table gives the masses of the model again, for mass = radiance x projected solid angle.
    """
    import numpy as np

    from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, write_skydist

    wavelength = _wavelength(arguments)
    grid = modelled.grid
    scale = float(modelled.sky.relative_integral) if modelled.dhi is None else modelled.dhi
    radiance = (modelled.mass * scale / grid.projected_solid_angle_sr).reshape(1, grid.n_zenith, grid.n_azimuth)
    table = SkyTable(wavelength_nm=np.array([wavelength]), radiance=radiance, path=path)
    write_skydist(table, path, bins=Bins.EQUAL, values=Values.RADIANCE)


def _wavelength(arguments: argparse.Namespace) -> float:
    """What table and photons are labelled with. [nm]"""
    if not arguments.wavelength > 0:
        raise UsageError(f"--wavelength must be positive, got {arguments.wavelength:g}")
    return float(arguments.wavelength)


def _write_counts(modelled: ModelledSky, arguments: argparse.Namespace, path: str) -> None:
    """Write the photons of every patch with mass, in the columns of a run's counts.csv."""
    import numpy as np

    from aomc_sky.formats.text_file import write_atomically
    from aomc_sky.outputs.counts import COLUMNS
    from aomc_sky.sampling.allocation import allocate, normalise

    grid = modelled.grid
    counts = allocate(modelled.mass, arguments.iterations, seed=arguments.seed)
    mass = normalise(modelled.mass)
    zenith = [f"{lo!r},{hi!r}" for lo, hi in grid.zenith_bounds_deg.tolist()]
    azimuth = [f"{lo!r},{hi!r}" for lo, hi in grid.azimuth_bounds_deg.tolist()]
    cells = np.flatnonzero(mass)
    rings, columns = np.divmod(cells, grid.n_azimuth)
    rows = zip(rings.tolist(), columns.tolist(), mass[cells].tolist(), counts[cells].tolist(), strict=True)
    lines = [
        f"1,,,perez,{z + 1},{a},{zenith[z]},{azimuth[a]},{m!r},{m * arguments.iterations!r},{n}" for z, a, m, n in rows
    ]
    write_atomically(path, "\n".join([COLUMNS, *lines, ""]))


def _write_picture(modelled: ModelledSky, arguments: argparse.Namespace, path: str) -> None:
    """Draw the sky dome."""
    from aomc_sky.pictures.plot import plot

    clearness, brightness = modelled.sky.clearness, modelled.sky.brightness
    what = "" if clearness is None else f", ε = {clearness:.4g}, Δ = {brightness:.3g}"
    source = modelled.source
    when = source.get("sun_at") or source.get("time")
    plot(modelled.sky, path, title="Perez sky" + what + (f"\n{when}" if when else ""))


def _emit(modelled: ModelledSky, arguments: argparse.Namespace) -> dict[str, Any]:
    """Write the run folder of one sky; its manifest, and the text that `run` would print."""
    from aomc_sky.cli.commands.run import run_text
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.run import JobOptions, run_job

    scene = _scene(modelled, arguments)
    source = cli_options.source_of(scene, arguments)
    options = JobOptions(
        formats=cli_options.formats_of(arguments),
        threads=arguments.threads or 0,
        force=arguments.force,
        max_memory_bytes=arguments.max_memory,
    )
    folder = Path(arguments.out)
    with progress_bar(enabled=cli_options.speaks(arguments)) as progress:
        result = run_job(source, scene, folder, options, progress)
    text = run_text(scene, source, result, folder, verbose=arguments.verbose)
    return {
        "manifest": {**(result.manifest or {}), "folder": str(folder), "was_finished": result.was_finished},
        "text": text,
    }


def _scene(modelled: ModelledSky, arguments: argparse.Namespace) -> Scene:
    """One waveband under the sky, and under the beam where it was asked for."""
    import numpy as np

    from aomc_sky.skies.direct_beam import DirectBeam
    from aomc_sky.source.scene import Scene
    from aomc_sky.wavebands import Wavebands

    wavebands = Wavebands(wavelength_nm=np.array([_wavelength(arguments)]))
    nm = wavebands.wavelength_nm
    fraction = _beam_share(modelled, arguments) if arguments.with_beam else 0.0
    shown = _as_json(modelled)
    names = ("epsilon", "delta", "coefficients", "limits", "air_mass", "extraterrestrial_normal", "dni", "dhi")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelLimitWarning)  # they were told when the sky was found
        sky = dataclasses.replace(modelled.sky, grid=modelled.grid, strength=1.0 - fraction)
        beam = DirectBeam(
            sun_zenith_deg=modelled.sun_zenith_deg, sun_azimuth_deg=modelled.sun_azimuth_deg, strength=fraction
        )
        split = f"direct fraction {fraction:.6g}, the rest from a perez sky" if fraction else ""
        notes = tuple(filter(None, [split or sky.missing_beam("write --with-beam to launch it too")]))
        return Scene(
            wavebands=wavebands,
            n_photons=np.array([arguments.iterations]),
            components=(*(beam.lower(nm) if fraction else ()), *sky.lower(nm)),
            notes=notes,
            input_files={} if modelled.path is None else {"weather": modelled.path},
            options={
                "sky": "perez",
                "sun": {"zenith_deg": modelled.sun_zenith_deg, "azimuth_deg": modelled.sun_azimuth_deg},
                "perez": {name: shown[name] for name in names} | {"limited": list(modelled.warnings)},
                "weather": modelled.source or None,
            },
        )


def _beam_share(modelled: ModelledSky, arguments: argparse.Namespace) -> float:
    """Share of the beam in the photons of a horizontal plane. [0 to 1]"""
    from aomc_sky.formats.sky_toml.keys import PerezSection
    from aomc_sky.source.light.inputs import PerezInputs, Sun, direct_fraction

    sky = modelled.sky
    if sky.coefficients is not None:
        raise UsageError(
            "--with-beam: coefficients do not say how bright the beam is; write two of --dni, --dhi, --ghi"
        )
    section = PerezSection(dni=sky.dni, dhi=sky.dhi)
    if sky.dni is None:
        section = PerezSection(epsilon=sky.epsilon, delta=sky.delta)
    sun = Sun(
        zenith_deg=modelled.sun_zenith_deg,
        azimuth_deg=modelled.sun_azimuth_deg,
        extraterrestrial_normal=modelled.extraterrestrial_normal,
    )
    fraction = direct_fraction(PerezInputs(section=section, origin="options", text=""), sun)
    assert fraction is not None, "coefficients are refused"
    return fraction
