"""Options of several sub-commands."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import values
from aomc_sky.errors import UsageError
from aomc_sky.inputs import CLEAR_SKY, INPUTS, LIGHTS, MODEL, MOMENT, PEREZ, SUN, WEATHER_FILES, Input
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


Kinds = Mapping[str, Callable[[str], Any] | None]


def add_table(
    group: argparse.ArgumentParser | argparse._ArgumentGroup | argparse._MutuallyExclusiveGroup,
    table: str,
    kinds: Kinds | None = None,
    **defaults: Any,
) -> None:
    """Add the options of a table that looks like help.

    A row is --quiet, --size PX, --range LOW HIGH, --norm log|linear, --wavelengths NM... or --waveband I*, two blanks,
    and the help; lines that begin with a blank continue it. A star means that the option may be repeated. The type
    comes from `kinds`, or else from the word for the value. A row without help names options of `_SHARED`. A row that
    ends with a colon begins a group.
    """
    parser = group
    for row in _rows(table):
        spec, _, text = row.partition("  ")
        if row.endswith(":"):
            group = parser.add_argument_group(row[:-1])
        elif not text:
            shared = "\n".join(_SHARED_ROWS[name] for name in spec.split())
            add_table(group, shared, _SHARED_KINDS, **_SHARED_DEFAULTS)
        else:
            _add(group, spec.split(), text.strip(), kinds or {}, defaults)


def _rows(table: str) -> list[str]:
    return re.sub(r"\n +", " ", table.strip()).split("\n")


def attribute(option: str) -> str:
    """The attribute in which argparse keeps the value of an option."""
    return option[2:].replace("-", "_")


def _add(
    group: argparse._ActionsContainer, words: list[str], text: str, kinds: Kinds, defaults: Mapping[str, Any]
) -> None:
    flags = [word for word in words if word.startswith("-")]
    rest = words[len(flags) :]
    name = attribute(next(flag for flag in flags if flag.startswith("--")))
    if not rest:
        group.add_argument(*flags, action="store_true", help=text)
        return
    value = rest[0].removesuffix("*").removesuffix("...")
    how: dict[str, Any] = {
        "type": kinds.get(name) or _KINDS.get(value),
        "default": defaults.get(name),
        "help": text or argparse.SUPPRESS,
    }
    if "|" in value and "NAME" not in value:
        how["choices"] = value.rstrip("|").split("|")
    else:
        how["metavar"] = value if len(rest) == 1 else tuple(rest)
    if len(rest) > 1:
        how["nargs"] = len(rest)
    if rest[0].endswith("..."):
        how |= {"type": values.wavelengths, "action": "extend", "metavar": "NM [NM ...]"}
    if rest[0].endswith("*"):
        how |= {"action": "append", "help": f"{text}; repeatable"}
    group.add_argument(*flags, **how)


SAMPLING = """\
how photons are drawn (default: the scene's preset):
--allocation --method --placement --order --precision --weights --replicates
"""


def formats_of(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The chosen formats, each once."""
    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none cannot be combined with another format")
    return formats


def source_of(scene: Scene, arguments: argparse.Namespace) -> PhotonSource:
    """The source of a scene, by the options of `SAMPLING`."""
    names = ("allocation", "method", "placement", "order", "precision", "weights", "replicates")
    chosen = {name: getattr(arguments, name) for name in names}
    return scene.source(arguments.seed, max_memory_bytes=arguments.max_memory, **chosen)


def job_options(arguments: argparse.Namespace) -> JobOptions:
    """The options of a job."""
    from aomc_sky.engine.run import JobOptions

    formats, threads = formats_of(arguments), arguments.threads or 0
    return JobOptions(formats=formats, threads=threads, force=arguments.force, max_memory_bytes=arguments.max_memory)


def add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Options for reading the input files."""
    add_table(
        parser,
        "how the files are read:\n--iterations --sky --sky-option --bins --weighting --azimuth-bins --compat --lenient "
        "--strict --allow-path --max-memory",
    )
    add_measured_options(parser)
    group = parser.add_argument_group("the sun and the Perez sky (default: sky.toml, difcol.inp, amc.inp)")
    add_inputs(group, *PEREZ.values(), *SUN.values(), *MODEL.values())
    add_table(group, "--diffuse-only  the sky without the sun's beam")
    add_inputs(group, INPUTS["polarisation"])
    group = parser.add_argument_group("a cloudless sky (--spectrum spectrl2 without irradiances; needs 'weather')")
    add_inputs(group, *CLEAR_SKY.values())
    add_light_options(parser)


def add_measured_options(parser: argparse.ArgumentParser) -> None:
    """Options for a table of measured radiances that does not state its conventions."""
    kinds = {"coordinate": _coordinate, "isel": _dimension_index, "stokes_signs": values.whole_number}
    add_table(parser, _MEASURED_OPTIONS, kinds)


_MEASURED_OPTIONS = """\
a measured sky (.csv, .tsv) or a radiance field (.nc; default: what the file states):
--azimuth-convention WORDS  from where its azimuths count and which way: clockwise or counterclockwise, from north,
                        east, south, west, the sun or the antisun, as 'clockwise from north'
--angle-unit deg|rad    of its angles
--wavelength-unit nm|um|m|angstrom  of its wavelengths
--radiance-unit UNIT    of its radiances, such as 'mW m-2 nm-1 sr-1', or relative
--decimal point|comma   sign of the decimals of a table
--coordinate ROLE=NAME*  a column or coordinate of another name: zenith, elevation, azimuth or wavelength, as zenith=vza
--variable NAME         the radiance, where it has another name; alone, without Q and U beside it
--variable-q NAME       the Stokes parameter Q, where its name is not radiance_q; with --variable-u
--variable-u NAME       the same of U
--stokes-signs Q U      1 or -1 for each: factors that bring them to our signs (docs/conventions.md)
--isel DIM=INDEX*       the index to take of a further dimension, from 0
"""


def _coordinate(text: str) -> tuple[str, str]:
    """What a coordinate is, and its name, of ROLE=NAME."""
    role, _, name = text.partition("=")
    if role not in ("zenith", "elevation", "azimuth", "wavelength") or not name:
        message = f"expected ROLE=NAME with zenith, elevation, azimuth or wavelength, as zenith=vza, got {text!r}"
        raise argparse.ArgumentTypeError(message)
    return role, name


def _dimension_index(text: str) -> tuple[str, int]:
    """Name and index of DIM=INDEX."""
    name, _, index = text.partition("=")
    if not name or not index.isdecimal():
        raise argparse.ArgumentTypeError(f"expected DIM=INDEX, for example stokes=0, got {text!r}")
    return name, int(index)


def _sky_name(text: str) -> str:
    """The name of a sky of ours or of an installed package."""
    from aomc_sky.formats.sky_toml.keys import value_problem

    _, message, advice = value_problem("sky", "model", text)
    if message:
        raise argparse.ArgumentTypeError(f"{message}; {advice}")
    return text


def _sky_option(text: str) -> tuple[str, Any]:
    """Name and value of KEY=VALUE; the value is read as TOML, or is the text itself if it is not TOML."""
    import tomllib

    name, is_pair, value = text.partition("=")
    if not is_pair or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE, for example type=12, got {text!r}")
    try:
        found = tomllib.loads(f"value = {value}")
    except ValueError:
        return name, value
    return name, found["value"] if len(found) == 1 else value


_SHARED = f"""\
--allocation systematic|largest-remainder|multinomial|aomc  how photons are distributed over the patches (default
                        systematic)
--allow-path DIR*       folder below which files named in sky.toml or in an .atmo file may lie, besides its own
--azimuth-bins n+1|n    n: azimuth indices run from 1 to n (default n+1, from 0)
--bins equal|degrees    meaning of the indices of skydist.inp (default: what the file declares, else equal bins)
--compat aomc|          everything as the AOMC 1.2.2 program does it
--format {"|".join(run_formats())}|none*  photon files (default npy); source: source.sky, for codes in C or Fortran;
                        none: counts and plan only
--iterations N          photons per waveband instead of line 1 of amc.inp, also as 1e6
--json                  one JSON object on standard output and nothing else
--lenient               use Fortran's value if a person would read another one
--max-memory SIZE       refuse a sky file, plan or run that takes more, e.g. 4G (default 2G, threads not counted)
--method stratified|iid  how the photons of a band depend on each other (default stratified)
--order shuffled|patch  order of the photons of a band (default shuffled)
--placement r2|philox|centre  where a photon lies in its cell (default r2)
--precision float32|float64  of directions (default float32)
-q --quiet              print warnings and errors only
--replicates R          divide the photons of a band into R independent runs, and print standard errors (default 1)
--seed INT              seed, 0 to 2^64-1 (default 0)
--sky perez|uniform|none|NAME  diffuse sky with light-source flag 0 (default perez); with flag 1, instead of
                        skydist.inp; none: the backgrounds of sky.toml alone; NAME: overcast, cardioidal,
                        cie (--sky-option type=1 to 15), harrison-coombes, or a model of another package
                        (`aomc-sky info --skies`)
--sky-option KEY=VALUE*  an option of a named sky, as in [sky] of sky.toml
--strict                warnings are errors
--threads N             threads, 1 to 1024 (default: all CPUs)
--waveband I*           only this band, from 1
--weighting listed|projected|solid-angle|aomc  meaning of the values of skydist.inp: masses (listed,
                        the default) or radiances times solid angle
--weights               carry weights where the launch law is not the flux law
"""
"""Options of several sub-commands."""

_SHARED_ROWS = {re.findall(r"--[a-z-]+", row)[0]: row for row in _rows(_SHARED)}
_SHARED_KINDS: Kinds = {
    "iterations": values.photon_total,
    "sky": _sky_name,
    "sky_option": _sky_option,
    "threads": values.thread_count,
}
_SHARED_DEFAULTS = {
    "azimuth_bins": "n+1", "precision": "float32", "replicates": 1, "seed": 0, "allow_path": [], "sky_option": [],
}  # fmt: skip


def sky_option_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """The argument `sky_options` of `read_scene`."""
    names = [name for name, _ in arguments.sky_option]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"--sky-option {name} is given twice")
    return dict(arguments.sky_option)


def _left_out(*options: str | Callable[[argparse.ArgumentParser], object]) -> dict[str, Any]:
    """Values of the options that tables and functions describe, where nobody gives them."""
    parser = argparse.ArgumentParser(add_help=False)
    for one in options:
        if isinstance(one, str):
            add_table(parser, one, seed=0)
        else:
            one(parser)
    return vars(parser.parse_args([]))


def given_options(
    arguments: argparse.Namespace, *options: str | Callable[[argparse.ArgumentParser], object]
) -> list[str]:
    """The options that the user gave, out of those that tables and functions describe."""
    left_out = _left_out(*options)
    return ["--" + name.replace("_", "-") for name, value in left_out.items() if getattr(arguments, name) != value]


def add_inputs(group: argparse._ArgumentGroup, *rows: Input) -> None:
    """Add options for inputs of sky and sun; the default is None."""
    for row in rows:
        if row.is_switch:
            group.add_argument(row.option, action=argparse.BooleanOptionalAction, default=None, help=row.text)
            continue
        value = "|".join(row.words) or row.value or (row.unit or row.name[0]).split()[0].upper()
        value = "a b c d e" if row.name == "coefficients" else value
        kinds = {attribute(row.option): values.INPUT_TYPES.get(row.name)}
        _add(group, [row.option, *value.split()], f"{row.text}{f' [{row.unit}]' if row.unit else ''}", kinds, {})


def add_light_options(parser: argparse.ArgumentParser) -> None:
    """The Moon and the glow of the ground under an atmosphere, in place of those of sky.toml."""
    group = parser.add_argument_group("eclipse and glowing ground under an atmosphere")
    add_inputs(group, *LIGHTS.values())


def inputs_of(arguments: argparse.Namespace, rows: Mapping[str, Input]) -> dict[str, Any]:
    """The inputs that the sub-command has and the user gave."""
    values = {name: getattr(arguments, attribute(row.option), None) for name, row in rows.items()}
    return {name: value for name, value in values.items() if value is not None}


def add_moment_options(parser: argparse.ArgumentParser) -> None:
    """Time and place, or an hour of a weather file, in place of the angles of the sun."""
    group = parser.add_argument_group(
        "when and where, or an hour of a weather file (the sun at its middle; needs the extra 'weather')"
    )
    add_inputs(group, *(row for name, row in MOMENT.items() if name not in WEATHER_FILES))
    add_inputs(group.add_mutually_exclusive_group(), *(MOMENT[name] for name in WEATHER_FILES))


def light_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """What the options say about the light: arguments of `said_by_caller`."""
    perez = inputs_of(arguments, PEREZ | MODEL)
    perez |= dict(zip("abcde", perez.pop("coefficients", ()), strict=False))
    return {
        "within": perez.pop("within", None),
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
    """How the files are read, by the options of `add_reading_options`."""
    from aomc_sky.source.read.files import Reading

    names = ("iterations", "sky", "bins", "weighting", "compat", "lenient", "azimuth_bins")
    return Reading(
        wavebands=wavebands,
        allow_paths=arguments.allow_path,
        max_memory_bytes=arguments.max_memory,
        sky_options=sky_option_arguments(arguments),
        **{name: getattr(arguments, name) for name in names},
    )


def scene_of(arguments: argparse.Namespace, path: str, *, wavebands: list[int] | None = None) -> Scene:
    """Read the scene that the options of `add_reading_options` describe."""
    from aomc_sky.progress import status_line
    from aomc_sky.source.read.kind import Kind, kind_of, not_a_scene
    from aomc_sky.source.read.scene import scene_of_files

    kind = kind_of(Path(path))
    if kind in (Kind.MEASURED, Kind.NETCDF):
        return _measured_scene(arguments, path, wavebands, is_field=kind is Kind.NETCDF)
    if kind is not Kind.SCENE and Path(path).is_file() and (mistaken := not_a_scene(Path(path))):
        raise mistaken  # before what is said of options
    for name in given_options(arguments, add_measured_options):
        key = attribute(name) if name not in ("--coordinate", "--isel") else "zenith, azimuth, wavelength or isel"
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
            f"aomc-sky: note: the sky took {seconds:.0f} s; to solve it once, write aomc-sky atmosphere MODEL.atmo "
            f"--sun-zenith {sun['zenith_deg']:g} --sun-azimuth {sun['azimuth_deg']:g} --out sky.nc, and table = "
            '"sky.nc" below [sky] of sky.toml',
            file=sys.stderr,
        )
    return scene


_NOT_MEASURED = "--sky --sky-option --bins --weighting --azimuth-bins --compat --lenient --allow-path"


def _measured_scene(arguments: argparse.Namespace, path: str, wavebands: list[int] | None, *, is_field: bool) -> Scene:
    """Read a measured sky or a radiance field in netCDF, with the beam that the options ask for."""
    from aomc_sky.progress import status_line

    if others := given_options(arguments, _NOT_MEASURED):
        raise UsageError(f"{' and '.join(others)}: not used with {path}, a measured sky; leave it out")
    callers = said_of(arguments)
    how = {
        "iterations": arguments.iterations,
        "wavelength_nm": getattr(arguments, "wavelengths", None),
        "wavebands": wavebands,
    }
    of_fields = ("variable_q", "variable_u", "stokes_signs", "isel")
    for name in given_options(arguments, add_measured_options) if not is_field else ():
        if attribute(name) in of_fields:
            raise UsageError(f"{name} is for a radiance field (.nc); {path} is none")
    stated: dict[str, Any] = {name: getattr(arguments, name) for name in _left_out(add_measured_options)}
    named = stated.pop("coordinate") or []
    for role, _ in named:
        if [one for one, _ in named].count(role) > 1:
            raise UsageError(f"--coordinate {role} is given twice")
    stated["isel"] = tuple(stated["isel"] or ())
    with status_line("interpolating the sky", enabled=is_verbose(arguments)):
        from aomc_sky.formats.sky_toml.sections import FieldSection
        from aomc_sky.source.read.radiance_scene import field_scene, measured_scene

        section = FieldSection(file=path, **stated, **dict(named))
        section.check()
        return (field_scene if is_field else measured_scene)(section, callers, **how)


_BACKGROUND_OPTIONS = """\
--animation NAME*     only this animation (default: all)
--utc-offset HOURS    local time less UTC, for the midnight of repeating animations (default 0)
--interpolation crossfade|slerp  between two keys both lobes fade (default), or one turns
"""


def add_background_options(parser: argparse.ArgumentParser | argparse._ArgumentGroup, more: str) -> None:
    """Add the options of a background sky after the rows of `more`."""
    kinds, defaults = {"utc_offset": values.number_in(-24, 24)}, {"utc_offset": 0.0, "interpolation": "crossfade"}
    add_table(parser, more + _BACKGROUND_OPTIONS, kinds, **defaults)


_KINDS: Kinds = {
    **dict.fromkeys(("PX", "N", "I", "R"), values.whole_number),
    **dict.fromkeys(("DEG", "M", "LOW"), values.finite_number),
    "NM": values.wavelength,
    "INT": values.seed,
    "NZ": values.whole_number_in(1, 3600),
    "SIZE": values.memory,
    "TIME": values.moment,
}
"""Word for a value in a table of options -> its type."""
