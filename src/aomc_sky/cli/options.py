"""Options of commands, made from the table of options, and what several commands do with them."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import values
from aomc_sky.engine.export_formats import exports
from aomc_sky.errors import UsageError
from aomc_sky.options import CLEAR_SKY, FIELD, LIGHTS, MOMENT, OPTIONS, PEREZ, SUN, Kind, Option
from aomc_sky.options import READING as TABLES
from aomc_sky.outputs.photon_formats import run_formats

if TYPE_CHECKING:
    from aomc_sky.emission.photon_source import PhotonSource
    from aomc_sky.engine.run import JobOptions
    from aomc_sky.source.light.said import Speakers
    from aomc_sky.source.read.files import Reading
    from aomc_sky.source.scene import Scene

_SLOW_SKY_S = 5.0
"""If an atmosphere takes longer to solve, a note advises to save it."""


def is_verbose(arguments: argparse.Namespace) -> bool:
    """Whether to print for a person: neither --json nor --quiet is given."""
    return not (getattr(arguments, "json", False) or getattr(arguments, "quiet", False))


def answer(arguments: argparse.Namespace, content: Callable[[], Any], text: Callable[[], str]) -> None:
    """Print the result of a command: one JSON object, a text, or with --quiet nothing."""
    if arguments.json:
        import json

        print(json.dumps(content(), allow_nan=False))
    elif is_verbose(arguments):
        print(text())


READING = {
    "how the files are read": "iterations sky sky_options bins weighting azimuth_bins compat lenient "
    "fail_on_warnings allow_path max_memory",
    "a measured sky (.csv, .tsv, .txt, .dat) or a radiance field (.nc; default: what the file states)": " ".join(FIELD),
    "the sun and the Perez sky (default: sky.toml, difcol.inp, amc.inp)": "dni dhi ghi epsilon delta spectrum "
    "zenith_deg azimuth_deg disc diffuse_only polarisation",
    "a cloudless sky (--spectrum spectrl2 without irradiances; needs 'weather')": " ".join(CLEAR_SKY),
}
"""How a scene of files is read: titles of groups, and rows of the table of options."""
WHEN = {
    "when and where, or an hour of a weather file (the sun at its middle; needs the extra 'weather')": " ".join(MOMENT)
}
DRAWN = {
    "how photons are drawn (default: the scene's preset)": "allocation method placement order precision weights "
    "replicates bias",
}
MOON = {"eclipse and glowing ground under an atmosphere": " ".join(LIGHTS)}


def names_of(groups: Mapping[str, str]) -> tuple[str, ...]:
    """The rows of some groups."""
    return tuple(name for names in groups.values() for name in names.split())


def add_groups(parser: argparse.ArgumentParser, groups: Mapping[str, str]) -> None:
    """Add the options of groups: those of the title "" are the first ones."""
    for title, names in groups.items():
        group = parser.add_argument_group(title) if title else parser
        for name in names.split():
            add_option(group, OPTIONS[name])


def add_option(group: argparse._ActionsContainer, row: Option) -> None:
    """Add an option of the table."""
    flags = [flag for flag in (row.short, row.flag) if flag]
    how: dict[str, Any] = {"dest": row.attribute, "default": row.default, "help": row.meaning or argparse.SUPPRESS}
    if row.kind is Kind.FLAG:
        group.add_argument(*flags, action="store_true", **how)
        return
    if row.kind is Kind.SWITCH:
        group.add_argument(*flags, action=argparse.BooleanOptionalAction, **how)
        return
    if row.kind is Kind.WAVELENGTHS:
        for flag in flags:  # --wavelength is not shown
            how["help"] = row.meaning if flag == row.flag else argparse.SUPPRESS
            group.add_argument(flag, nargs="+", action=_WavelengthList, metavar="NM", **how)
        return
    words, places = words_of(row), row.value.split()
    how |= {"choices": words} if words else {"metavar": row.value if len(places) == 1 else tuple(places)}
    how |= {"nargs": len(places)} if len(places) > 1 else {}
    how |= {"action": "append"} if row.repeats else {}
    limited = values.LIMITED.get(row.kind)
    how |= {"type": limited(row.low, row.high) if limited else values.TYPES[row.kind], "required": row.is_needed}
    group.add_argument(*flags, **how)


_FORMATS: dict[str, Callable[[], tuple[str, ...]]] = {
    "format": lambda: (*run_formats(), "none"),
    "to": lambda: tuple(exports()),
}
"""Words of the options that name a format."""


def words_of(row: Option) -> tuple[str, ...]:
    """The words of a choice; empty for another option."""
    return _FORMATS[row.name]() if row.kind is Kind.FORMAT else row.words


class _WavelengthList(argparse.Action):
    """Wavelengths in one word or several; given again, they add up."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, words: Any, option: str | None = None
    ) -> None:
        try:
            found = values.wavelengths(" ".join(words))
        except argparse.ArgumentTypeError as error:
            advice = f"; a file stands before {option}" if os.path.exists(words[-1]) else ""
            raise argparse.ArgumentError(self, f"{error}{advice}") from None
        setattr(namespace, self.dest, [*(getattr(namespace, self.dest) or ()), *found])


def formats_of(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The chosen formats, each once."""
    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none cannot be combined with another format")
    return formats


def source_of(scene: Scene, arguments: argparse.Namespace) -> PhotonSource:
    """The source of a scene, by the options of `DRAWN`."""
    names = ("allocation", "method", "placement", "order", "precision", "weights", "replicates")
    chosen = {name: getattr(arguments, name) for name in names}
    bias = given_once("--bias", arguments.bias) or None
    return scene.source(arguments.seed, max_memory_bytes=arguments.max_memory, bias=bias, **chosen)


def given_once(option: str, pairs: Sequence[tuple[str, Any]] | None) -> dict[str, Any]:
    """Names and values of an option that may be repeated, each name once."""
    names = [name for name, _ in pairs or ()]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{option} {name} is given twice")
    return dict(pairs or ())


def job_options(arguments: argparse.Namespace) -> JobOptions:
    """The options of a job."""
    from aomc_sky.engine.run import JobOptions

    formats, threads = formats_of(arguments), arguments.threads or 0
    return JobOptions(formats=formats, threads=threads, force=arguments.force, max_memory_bytes=arguments.max_memory)


def sky_option_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """The argument `sky_options` of `read_scene`."""
    return given_once("--sky-option", arguments.sky_option)


def given_options(arguments: argparse.Namespace, *names: str) -> list[str]:
    """The options that the user gave, out of these rows of the table; those that the command has."""
    rows = [OPTIONS[name] for name in names]
    return [row.flag for row in rows if getattr(arguments, row.attribute, row.default) != row.default]


def inputs_of(arguments: argparse.Namespace, rows: Mapping[str, Option]) -> dict[str, Any]:
    """The inputs that the sub-command has and the user gave."""
    given = {name: getattr(arguments, row.attribute, None) for name, row in rows.items()}
    return {name: value for name, value in given.items() if value is not None}


def light_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """What the options say about the light: arguments of `said_by_caller`."""
    perez = inputs_of(arguments, PEREZ)
    perez |= dict(zip("abcde", perez.pop("coefficients", ()), strict=False))
    return {
        "perez": perez,
        "sun": inputs_of(arguments, SUN),
        "weather": inputs_of(arguments, MOMENT) if "row" in arguments else {},
        "atmosphere": inputs_of(arguments, LIGHTS),
        "clear_sky": inputs_of(arguments, CLEAR_SKY),
        "diffuse_only": getattr(arguments, "diffuse_only", False),
        "polarisation": getattr(arguments, "polarisation", None),
    }


def said_of(arguments: argparse.Namespace) -> Speakers:
    """What the options say about the light, checked."""
    from aomc_sky.source.light.said import rayleigh_pattern, said_by_caller

    how = light_arguments(arguments)
    if how["polarisation"] is not None:
        how["polarisation"] = rayleigh_pattern(how["polarisation"])
    return said_by_caller(**how)


def reading_of(arguments: argparse.Namespace, wavebands: list[int] | None = None) -> Reading:
    """How the files are read, by the options of `READING`."""
    from aomc_sky.source.read.files import Reading

    names = ("iterations", "sky", "bins", "weighting", "compat", "lenient", "azimuth_bins")
    return Reading(
        wavebands=wavebands,
        allow_paths=arguments.allow_path or (),
        max_memory_bytes=arguments.max_memory,
        sky_options=sky_option_arguments(arguments),
        **{name: getattr(arguments, name) for name in names},
    )


def scene_of(arguments: argparse.Namespace, path: str, *, wavebands: list[int] | None = None) -> Scene:
    """Read the scene that the options of `READING` describe."""
    from aomc_sky.progress import status_line
    from aomc_sky.source.read.kind import Kind, kind_of, not_a_scene
    from aomc_sky.source.read.scene import scene_of_files

    kind = kind_of(Path(path))
    if kind in (Kind.MEASURED, Kind.NETCDF):
        return _measured_scene(arguments, path, wavebands, is_field=kind is Kind.NETCDF)
    if kind is not Kind.SCENE and Path(path).is_file() and (mistaken := not_a_scene(Path(path))):
        raise mistaken  # before what is said of options
    for name in given_options(arguments, *FIELD):
        key = (
            "zenith, azimuth, wavelength or isel" if name in ("--coordinate", "--isel") else name[2:].replace("-", "_")
        )
        message = f"{name} is for a measured sky (.csv) or a radiance field (.nc); {path} is none"
        raise UsageError(f"{message}: write {key} below [sky] of sky.toml for its table")
    if getattr(arguments, "wavelengths", None) and Path(path).exists():
        raise UsageError(
            f"--wavelengths is for a run without files or a measured sky; {path} has its own in lambbot.inp: leave it "
            "out, or choose among them with --waveband 1"
        )
    began = time.monotonic()
    with status_line("preparing the scene", enabled=is_verbose(arguments)):
        scene = scene_of_files(path, said_of(arguments), reading_of(arguments, wavebands))
    seconds = time.monotonic() - began
    if is_verbose(arguments) and scene.options.get("sky") == "atmosphere" and seconds > _SLOW_SKY_S:
        sun = scene.options["sun"]
        print(
            f"aomc-sky: hint: the sky took {seconds:.0f} s; to solve it once, write aomc-sky atmosphere MODEL.atmo "
            f"--sun-zenith {sun['zenith_deg']:g} --sun-azimuth {sun['azimuth_deg']:g} --out sky.nc, and table = "
            '"sky.nc" below [sky] of sky.toml',
            file=sys.stderr,
        )
    return scene


_OF_FILES = (*TABLES, "compat", "lenient", "allow_path", "waveband")


def scene_of_options(arguments: argparse.Namespace) -> Scene:
    """Sun and sky from options alone, without files of AMC."""
    from aomc_sky.source.weather_scene import scene_of_weather

    if not any(light_arguments(arguments).values()) and arguments.sky is None:
        raise UsageError(
            "which scene? name amc.inp or its folder, or sun, sky and wavebands: --sun-zenith 40 --ghi 780 --dhi 140 "
            "--wavelengths 440 550, or --sky overcast --wavelengths 550"
        )
    for name in given_options(arguments, *FIELD):
        raise UsageError(f"{name} is for a measured sky (.csv) or a radiance field (.nc): name it")
    for name in given_options(arguments, *_OF_FILES):
        raise UsageError(f"{name} is for a scene of files: name its amc.inp")
    if not arguments.wavelengths:
        raise UsageError("a scene without amc.inp needs its wavebands: --wavelengths 412 443 555")
    return scene_of_weather(
        said_of(arguments),
        arguments.wavelengths,
        10**6 if arguments.iterations is None else arguments.iterations,
        sky=arguments.sky,
        sky_options=sky_option_arguments(arguments),
    )


_NOT_MEASURED = ("sky", "sky_options", *TABLES, "compat", "lenient", "allow_path")


def _measured_scene(arguments: argparse.Namespace, path: str, wavebands: list[int] | None, *, is_field: bool) -> Scene:
    """Read a measured sky or a radiance field in netCDF, with the beam that the options ask for."""
    from aomc_sky.progress import status_line

    if others := given_options(arguments, *_NOT_MEASURED):
        raise UsageError(f"{' and '.join(others)}: not used with {path}, a measured sky", "leave it out")
    callers = said_of(arguments)
    how = {
        "iterations": arguments.iterations,
        "wavelength_nm": getattr(arguments, "wavelengths", None),
        "wavebands": wavebands,
    }
    for name in () if is_field else given_options(arguments, "variable_q", "variable_u", "stokes_signs", "isel"):
        raise UsageError(f"{name} is for a radiance field (.nc); {path} is none")
    stated: dict[str, Any] = {name: getattr(arguments, name) for name in FIELD}
    named = given_once("--coordinate", stated.pop("coordinate"))
    stated["isel"] = tuple(stated["isel"] or ())
    with status_line("interpolating the sky", enabled=is_verbose(arguments)):
        from aomc_sky.formats.sky_toml.sections import FieldSection
        from aomc_sky.source.read.radiance_scene import field_scene, measured_scene

        section = FieldSection(file=path, **stated, **named)
        section.check()
        return (field_scene if is_field else measured_scene)(section, callers, **how)
