"""Options that several sub-commands share, and the types that turn their text into values."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import TYPE_CHECKING, Any

from aomc_sky.errors import UsageError
from aomc_sky.inputs import LIGHTS, MODEL, PEREZ, SUN, Input

if TYPE_CHECKING:
    from aomc_sky.source.photon_source import PhotonSource
    from aomc_sky.source.scene import Scene

_SLOW_SKY_S = 5.0
"""A solution of an atmosphere that takes longer is better saved."""

_SUFFIXES = {"": 1, "k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40}


def whole_number(text: str) -> int:
    """A whole number, also as 1e6."""
    try:
        value = Decimal(text)
        if value == value.to_integral_value() and abs(value) < Decimal(10) ** 30:
            return int(value)
    except InvalidOperation:
        pass
    raise argparse.ArgumentTypeError(f"expected a whole number, for example 1000000 or 1e6, got {text!r}")


def finite_number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a finite number, got {text!r}")
    return value


def whole_number_in(low: int, high: int) -> Callable[[str], int]:
    """Type of an option that is a whole number from `low` to `high`."""

    def number(text: str) -> int:
        value = whole_number(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"expected {low} to {high}, got {text}")
        return value

    return number


seed = whole_number_in(0, 2**64 - 1)
thread_count = whole_number_in(1, 1024)


def photon_total(text: str) -> int:
    """Iterations: 1 or more; more than 2^62 is a scene that cannot be sampled, not a wrong usage."""
    value = whole_number(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected 1 to 2^62 iterations, got {text}")
    return value


def memory(text: str) -> int:
    """A memory size such as 500M or 2G. [bytes]"""
    number = text.strip().lower().removesuffix("b").removesuffix("i")
    suffix = number[-1:] if number[-1:].isalpha() else ""
    try:
        value = int(float(number.removesuffix(suffix)) * _SUFFIXES[suffix])
    except (ValueError, KeyError, OverflowError):
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a size such as 500M or 2G, got {text!r}")
    return value


def speaks(arguments: argparse.Namespace) -> bool:
    """Whether a person reads along: neither a program nor somebody who wants quiet."""
    return not (getattr(arguments, "json", False) or getattr(arguments, "quiet", False))


def answer(arguments: argparse.Namespace, values: Callable[[], Any], text: Callable[[], str]) -> None:
    """Print what a command found: one JSON object, a text, or with --quiet nothing."""
    if arguments.json:
        import json

        print(json.dumps(values(), allow_nan=False))
    elif speaks(arguments):
        print(text())


def add_bins(group: argparse._ArgumentGroup, text: str, default: list[int] | None = None) -> None:
    """--bins, equal bins of a table that a sub-command makes of a sky model."""
    group.add_argument(
        "--bins", type=whole_number_in(1, 3600), nargs=2, metavar=("NZ", "NA"), default=default, help=text
    )


def _sampling_method(word: str) -> str:
    """The word itself; a method that was removed is told with what to write instead."""
    if word not in ("stratified", "iid"):
        from aomc_sky.source.plan.options import refuse_withdrawn

        refuse_withdrawn(word)
    return word


def add_sampling_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """How photons are drawn."""
    group = parser.add_argument_group("how photons are drawn (default: the scene's preset)")
    add_shared(group, "allocation method placement order precision weights replicates")
    return group


def formats_of(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The formats that were asked for, each once."""
    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none cannot be combined with another format")
    return formats


def source_of(scene: Scene, arguments: argparse.Namespace) -> PhotonSource:
    """The source of a scene that the options of `add_sampling_options` describe."""
    return scene.source(
        arguments.seed,
        allocation=arguments.allocation,
        method=arguments.method,
        placement=arguments.placement,
        order=arguments.order,
        precision=arguments.precision,
        weights=arguments.weights,
        replicates=arguments.replicates,
        max_memory_bytes=arguments.max_memory,
    )


def add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Options that say how the input files are read."""
    group = parser.add_argument_group("how the files are read")
    reading = "iterations sky sky-option bins weighting azimuth-bins compat lenient strict"
    add_shared(group, f"{reading} allow-path max-memory")
    add_sky_options(parser)
    add_light_options(parser)


def _sky_name(text: str) -> str:
    """A sky of ours, or of an installed package."""
    from aomc_sky.formats.sky_toml.keys import value_problem

    _, message, advice = value_problem("sky", "model", text)
    if message:
        raise argparse.ArgumentTypeError(f"{message}; {advice}")
    return text


def _sky_option(text: str) -> tuple[str, Any]:
    """Name and value of KEY=VALUE; the value as TOML has it, where it is no such value the text itself."""
    import tomllib

    name, is_pair, value = text.partition("=")
    if not is_pair or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE, for example type=12, got {text!r}")
    try:
        found = tomllib.loads(f"value = {value}")
    except ValueError:
        return name, value
    return name, found["value"] if len(found) == 1 else value


_SHARED: dict[str, dict[str, Any]] = {
    "allocation": {
        "choices": ("systematic", "largest-remainder", "multinomial", "aomc"),
        "help": "how photons are distributed over the patches (default systematic)",
    },
    "allow-path": {
        "metavar": "DIR",
        "action": "append",
        "default": [],
        "help": "folder below which files named in sky.toml or in an .atmo file may lie, besides its own; repeatable",
    },
    "azimuth-bins": {
        "choices": ("n+1", "n"),
        "default": "n+1",
        "help": "n: azimuth indices run from 1 to n (default n+1, from 0)",
    },
    "bins": {
        "choices": ("equal", "degrees"),
        "help": "what the indices of skydist.inp are (default: what the file declares, else equal bins)",
    },
    "compat": {"choices": ("aomc",), "help": "everything as the AOMC 1.2.2 program does it"},
    "format": {
        "choices": ("npy", "mcpl", "raw", "none"),
        "metavar": "npy|mcpl|raw|none",
        "action": "append",
        "help": "photon files, repeatable (default npy); none: counts and plan only",
    },
    "iterations": {
        "type": photon_total,
        "metavar": "N",
        "help": "photons per waveband instead of line 1 of amc.inp, also as 1e6",
    },
    "json": {"help": "one JSON object on standard output and nothing else"},
    "lenient": {"help": "take Fortran's value where a person reads another one"},
    "max-memory": {
        "type": memory,
        "metavar": "SIZE",
        "help": "refuse a sky file, plan or run that takes more, e.g. 4G (default 2G, threads not counted)",
    },
    "method": {
        "type": _sampling_method,
        "choices": ("stratified", "iid"),
        "help": "how the photons of a band depend on each other (default stratified)",
    },
    "order": {"choices": ("shuffled", "patch"), "help": "order of the photons of a band (default shuffled)"},
    "placement": {"choices": ("r2", "philox", "centre"), "help": "where a photon lies in its cell (default r2)"},
    "precision": {
        "choices": ("float32", "float64"),
        "default": "float32",
        "help": "of directions (default float32)",
    },
    "quiet": {"short": "-q", "help": "print warnings and errors only"},
    "replicates": {
        "type": whole_number,
        "default": 1,
        "metavar": "R",
        "help": "divide the photons of a band into R independent runs, and print standard errors (default 1)",
    },
    "seed": {"type": seed, "default": 0, "metavar": "INT", "help": "seed, 0 to 2^64-1 (default 0)"},
    "sky": {
        "type": _sky_name,
        "metavar": "perez|uniform|none|NAME",
        "help": "diffuse sky with light-source flag 0 (default perez); with flag 1, instead of skydist.inp; "
        "none: the backgrounds of sky.toml alone; NAME: a model of another package (`aomc-sky info --skies`)",
    },
    "sky-option": {
        "type": _sky_option,
        "action": "append",
        "default": [],
        "metavar": "KEY=VALUE",
        "help": "an option of another package's sky model, as [sky] of sky.toml has it; repeatable",
    },
    "strict": {"help": "warnings are errors"},
    "threads": {"type": thread_count, "metavar": "N", "help": "threads, 1 to 1024 (default: all CPUs)"},
    "waveband": {
        "type": whole_number,
        "action": "append",
        "metavar": "I",
        "help": "only this band, from 1; repeatable",
    },
    "weighting": {
        "choices": ("listed", "projected", "solid-angle", "aomc"),
        "help": "what its values are: masses (listed, the default) or radiances times solid angle",
    },
    "weights": {"help": "carry weights where the launch law is not the flux law"},
}
"""Options of several sub-commands, or of several groups; one of help alone is a switch."""


def add_shared(group: argparse._ArgumentGroup | argparse.ArgumentParser, names: str, **changes: Any) -> None:
    """Add options of the table, in this order; `changes` take the place of what the table says of all of them."""
    for name in names.split():
        how = _SHARED[name] | changes
        short = how.pop("short", None)
        if how.keys() == {"help"}:
            how["action"] = "store_true"
        group.add_argument(*([short] if short else []), f"--{name}", **how)


def sky_option_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """The argument `sky_options` of `read_scene`."""
    names = [name for name, _ in arguments.sky_option]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"--sky-option {name} is given twice")
    return dict(arguments.sky_option)


def given_options(arguments: argparse.Namespace, *groups: Callable[[argparse.ArgumentParser], object]) -> list[str]:
    """The options that these functions add and that are not as they are when left out."""
    parser = argparse.ArgumentParser(add_help=False)
    for add in groups:
        add(parser)
    left_out = vars(parser.parse_args([]))
    return ["--" + name.replace("_", "-") for name, value in left_out.items() if getattr(arguments, name) != value]


def add_inputs(group: argparse._ArgumentGroup, *rows: Input) -> None:
    """Options of inputs of sky and sun; None where one is not given."""
    for row in rows:
        if row.is_switch:
            group.add_argument(row.option, action=argparse.BooleanOptionalAction, default=None, help=row.text)
        elif row.words:
            group.add_argument(row.option, choices=row.words, help=row.text)
        elif row.name == "coefficients":
            number = number_in(row.low, row.high)
            group.add_argument(row.option, type=number, nargs=5, metavar=tuple("abcde"), help=row.text)
        else:
            metavar = (row.unit or row.name[0]).split()[0].upper()
            text = f"{row.text} [{row.unit}]" if row.unit else row.text
            group.add_argument(row.option, type=number_in(row.low, row.high), metavar=metavar, help=text)


def add_light_options(parser: argparse.ArgumentParser) -> None:
    """The Moon and the glow of the ground under an atmosphere, which win over sky.toml."""
    group = parser.add_argument_group("eclipse and glowing ground under an atmosphere")
    add_inputs(group, *LIGHTS.values())


def light_arguments(arguments: argparse.Namespace) -> dict[str, float]:
    """The argument `atmosphere` of `read_scene`: what is given."""
    return _given_inputs(arguments, LIGHTS)


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def _given_inputs(arguments: argparse.Namespace, rows: dict[str, Input]) -> dict[str, Any]:
    """Values of the inputs that a sub-command takes and somebody gives."""
    return _given({name: getattr(arguments, row.attribute, None) for name, row in rows.items()})


_WEATHER_FILES = ("epw", "tmy2", "tmy3")
_MOMENT = {
    **{kind: kind for kind in _WEATHER_FILES},
    "row": "row",
    "time": "time",
    "latitude": "latitude_deg",
    "longitude": "longitude_deg",
    "altitude": "altitude_m",
}


def add_moment_options(parser: argparse.ArgumentParser) -> None:
    """When and where the sun shines, or an hour of a weather file, instead of the angles of the sun."""
    group = parser.add_argument_group(
        "when and where, or an hour of a weather file (the sun at its middle; needs the extra 'weather')"
    )
    group.add_argument("--time", metavar="ISO8601", help="date and time with Z or an offset")
    for name, text in (("latitude", "north positive, with --time"), ("longitude", "east positive, with --time")):
        group.add_argument(f"--{name}", type=finite_number, metavar="DEG", help=text)
    group.add_argument(
        "--altitude", type=finite_number, metavar="M", help="height above the sea, with --time (default 0)"
    )
    file = group.add_mutually_exclusive_group()
    for kind in _WEATHER_FILES:
        article = "an" if kind == "epw" else "a"
        file.add_argument(f"--{kind}", metavar="FILE", help=f"{article} {kind.upper()} file of hours")
    group.add_argument("--row", type=whole_number, metavar="N", help="the hour of the file to take, from 1")


def moment_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """The argument `weather` of `read_scene`: what is given, by a sub-command with `add_moment_options`."""
    if not hasattr(arguments, "latitude"):
        return {}
    return _given({key: getattr(arguments, name) for name, key in _MOMENT.items()})


def add_sky_options(parser: argparse.ArgumentParser) -> None:
    """Options that win over sky.toml, difcol.inp and the sun of amc.inp."""
    group = parser.add_argument_group("the sun and the Perez sky (default: sky.toml, difcol.inp, amc.inp)")
    add_inputs(group, *PEREZ.values(), *SUN.values(), *MODEL.values())


def number_in(low: float, high: float) -> Callable[[str], float]:
    """Type of an option that is a number in a range."""

    def number(text: str) -> float:
        from aomc_sky.formats.report import BadValueError
        from aomc_sky.formats.sky_toml import rules

        try:
            return float(rules.number(low, high)(float(text)))
        except ValueError:
            raise argparse.ArgumentTypeError(f"expected a number, got {text!r}") from None
        except BadValueError as problem:
            raise argparse.ArgumentTypeError(problem.message) from None

    return number


def sky_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """The arguments `perez`, `sun`, `within` and `weather` of `read_scene`, with what is given."""
    perez = _given_inputs(arguments, PEREZ | MODEL)
    perez |= dict(zip("abcde", perez.pop("coefficients", ()), strict=False))
    sun, within = _given_inputs(arguments, SUN), perez.pop("within", None)
    return {"perez": perez, "sun": sun, "within": within, "weather": moment_arguments(arguments)}


def scene_of(arguments: argparse.Namespace, path: str, *, wavebands: list[int] | None = None) -> Scene:
    """Read the scene that the options of `add_reading_options` describe."""
    from aomc_sky.cli.progress import patience
    from aomc_sky.source.read.scene import read_scene

    began = time.monotonic()
    with patience("preparing the scene", enabled=speaks(arguments)):
        scene = read_scene(
            path,
            iterations=arguments.iterations,
            sky=arguments.sky,
            bins=arguments.bins,
            weighting=arguments.weighting,
            compat=arguments.compat,
            lenient=arguments.lenient,
            azimuth_bins=arguments.azimuth_bins,
            wavebands=wavebands,
            allow_paths=arguments.allow_path,
            max_memory_bytes=arguments.max_memory,
            sky_options=sky_option_arguments(arguments),
            atmosphere=light_arguments(arguments),
            **sky_arguments(arguments),
        )
    seconds = time.monotonic() - began
    if speaks(arguments) and scene.options.get("sky") == "atmosphere" and seconds > _SLOW_SKY_S:
        print(
            f"aomc-sky: note: the sky took {seconds:.0f} s; to solve it once, write aomc-sky atmosphere MODEL.atmo "
            '--out sky.nc, and table = "sky.nc" below [sky] of sky.toml',
            file=sys.stderr,
        )
    return scene


def moment(text: str) -> float:
    """A time with its zone, or seconds since 1970."""
    from aomc_sky.formats.report import BadValueError
    from aomc_sky.formats.sky_toml import rules

    is_number = text.lstrip("+-").replace(".", "", 1).isdecimal()
    try:
        return rules.time(float(text) if is_number else text)
    except BadValueError as problem:
        raise argparse.ArgumentTypeError(f"{problem.message}; {problem.advice}") from None


def add_background_options(group: argparse._ArgumentGroup) -> None:
    """Which animations of the files count, where midnight is, and what happens between two keys."""
    group.add_argument(
        "--animation", action="append", metavar="NAME", help="only this animation; repeatable (default: all)"
    )
    group.add_argument(
        "--utc-offset",
        type=number_in(-24, 24),
        default=0.0,
        metavar="HOURS",
        help="local time less UTC, for the midnight of repeating animations (default 0)",
    )
    group.add_argument(
        "--interpolation",
        choices=("crossfade", "slerp"),
        default="crossfade",
        help="between two keys both lobes fade (default), or one turns",
    )
