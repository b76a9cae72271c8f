"""``aomc-sky validate``: report every problem of every file, and make no photons."""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import error_text
from aomc_sky.errors import AomcSkyError, InputFileError, InputWarning, MissingExtraError, ModelLimitWarning
from aomc_sky.source.read.kind import SCENE_FILES, Kind, kind_of, kind_of_name, not_a_scene, only_table

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser

_OURS = (InputWarning, ModelLimitWarning)
_ENDING = {
    **dict.fromkeys((Kind.SCENE, Kind.LAMBBOT, Kind.DIFCOL, Kind.TABLE), ".inp"),
    Kind.SKY_TOML: "sky.toml",
    **dict.fromkeys((Kind.MCPL, Kind.BACKGROUND, Kind.ATMOSPHERE), ""),
}
"""Kind of file -> the ending of names that are read in a folder."""


GROUPS = {"": "json", **cli_options.READING, **cli_options.WHEN}
FIRST = "lenient strict compat allow-path json"


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Read every file named (of a folder: all of a known name, and those that its amc.inp asks for) and "
        "report every problem of every file, and of a folder with amc.inp whatever `run` would refuse; never "
        "make photons. The name of a file says its kind: amc, lambbot, skydist or difcol at its start or between dots, "
        "or its ending .toml, .mcpl, .sky, .h5, .atmo, .epw, .tmy2, .tmy3 or .csv (a measured sky)."
    )
    parser.epilog = "examples:\n  aomc-sky validate inputs/clear_day\n  aomc-sky validate amc.inp skydist.inp"
    parser.add_argument("paths", nargs="+", metavar="FILE", help="a file, or a folder")
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=validate)


def _readers(arguments: argparse.Namespace) -> dict[Kind, Callable[[Path], Any]]:
    lenient, allow_paths, max_memory = arguments.lenient, arguments.allow_path or (), arguments.max_memory
    from aomc_sky.formats.aomc.amc import read_difcol, read_lambbot
    from aomc_sky.formats.aomc.skydist import read_skydist
    from aomc_sky.formats.mcpl.file import check_mcpl
    from aomc_sky.outputs.source_file import read_source_head

    return {
        Kind.SCENE: lambda path: _read_amc(path, lenient),
        Kind.LAMBBOT: lambda path: read_lambbot(path, lenient=lenient, **_beside(path, lenient, with_target=True)),
        Kind.DIFCOL: lambda path: read_difcol(path, lenient=lenient, **_beside(path, lenient)),
        Kind.TABLE: lambda path: read_skydist(path, lenient=lenient, max_memory_bytes=max_memory),
        Kind.SKY_TOML: lambda path: _read_toml(path, arguments),
        Kind.MCPL: check_mcpl,
        Kind.SOURCE: read_source_head,
        Kind.BACKGROUND: _read_background,
        Kind.ATMOSPHERE: lambda path: _read_atmosphere(path, allow_paths),
        Kind.WEATHER: _read_weather,
        **dict.fromkeys((Kind.MEASURED, Kind.NETCDF), lambda path: cli_options.scene_of(arguments, str(path))),
    }


def _read_amc(path: Path, lenient: bool) -> None:
    """Read amc.inp; a file of another kind is an error that says its kind."""
    from aomc_sky.formats.aomc.amc import read_amc

    try:
        read_amc(path, lenient=lenient)
    except InputFileError as error:
        raise not_a_scene(path) or error from None


def _read_background(path: Path) -> None:
    """Read a background-sky file."""
    from aomc_sky.skies.lobes.file.file import read_background_file

    read_background_file(path)


def _read_weather(path: Path) -> None:
    """Read a weather file."""
    from aomc_sky.formats.weather import read_weather

    read_weather(path, "tmy2" if path.suffix.lower() == ".tm2" else path.suffix.lower().removeprefix("."))


def _read_atmosphere(path: Path, allow_paths: Sequence[str]) -> None:
    """Read a description of an atmosphere, its tables, and its code."""
    from aomc_sky.skies.atmosphere.description.medium import read_medium
    from aomc_sky.skies.atmosphere.description.reader import read_atmo

    read_medium(read_atmo(path, allow_paths=allow_paths))


def _beside(path: Path, lenient: bool, *, with_target: bool = False) -> dict[str, Any]:
    """The number of wavebands, and whether there is a target, from an amc.inp in the same folder."""
    from aomc_sky.formats.aomc.amc import read_amc

    amc = path.parent / "amc.inp"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            config = read_amc(amc, lenient=lenient) if amc.is_file() else None
    except AomcSkyError:
        config = None  # reported under its own name
    if config is None:
        return {}
    return {"n_wavebands": config.n_wavebands} | ({"has_target": config.bottom_target} if with_target else {})


def _read_toml(path: Path, arguments: argparse.Namespace) -> None:
    """Read sky.toml, and the background-sky files, the atmosphere, the field and the sky model that it names."""
    from aomc_sky.formats.sky_toml.file import read_sky_toml

    toml = read_sky_toml(path, allow_paths=arguments.allow_path or (), **_beside(path, arguments.lenient))
    if toml.background:
        from aomc_sky.skies.lobes.light import read_backgrounds

        read_backgrounds(toml.background, str(path))
    if toml.atmosphere is not None:
        _read_atmosphere(Path(toml.atmosphere.file), arguments.allow_path or ())
    if toml.sky.table is not None and arguments.sky is None:
        from aomc_sky.formats.sky_toml.sections import SunSection
        from aomc_sky.source.read.field import read_sky_field

        read_sky_field(toml.sky.table, str(path), toml.sun, SunSection(azimuth_deg=0.0))  # amc.inp has one
    if toml.sky.model is not None and toml.sky.model_span is not None and arguments.sky in (None, toml.sky.model):
        from aomc_sky.source.light.plugin import choose_plugin

        choose_plugin(toml.sky.model, toml.sky, cli_options.sky_option_arguments(arguments), str(path))


def _refusal(folder: Path, arguments: argparse.Namespace) -> None:
    """Raise the errors of `run` for the scene of a folder: missing files, a dark sky, a plan that is too large.

    The light of an atmosphere takes minutes and is not solved here.
    """
    from aomc_sky.source.read.files import read_scene_files

    reading = cli_options.reading_of(arguments)
    if read_scene_files(folder / "amc.inp", cli_options.said_of(arguments), reading).atmosphere is None:
        scene = cli_options.scene_of(arguments, str(folder))
        source = scene.source(max_memory_bytes=arguments.max_memory)
        if arguments.max_memory is not None:
            from aomc_sky.engine.run import JobOptions, check_memory

            check_memory(source, JobOptions(max_memory_bytes=arguments.max_memory))


def _check_scene(folder: Path, arguments: argparse.Namespace, results: list[dict[str, Any]]) -> int:
    """Add to the results what only the whole scene shows; returns the exit code of `run`."""
    result_of_path = {result["path"]: result for result in results}
    known = {line for result in results for line in result["problems"]}
    scene_result, code, by_path = _checked(folder, lambda path: _refusal(path, arguments), arguments.strict)
    for path, problems in by_path.items():
        if path not in result_of_path:
            results.append({"path": path, "ok": code == 0, "was_read": True, "problems": problems})
        elif result_of_path[path]["ok"]:
            result_of_path[path].update(ok=False, problems=[*result_of_path[path]["problems"], *problems])
    rest = [text for text in scene_result["problems"] if text not in known] if not by_path else []
    if rest:
        results.append({**scene_result, "problems": rest})
    return code


def validate(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.progress import status_line

    cli_options.said_of(arguments)
    readers = _readers(arguments)
    results: list[dict[str, Any]] = []
    worst = 0
    for named in arguments.paths:
        own: list[dict[str, Any]] = []
        for path in _files_of(Path(named)):
            kind = kind_of(path) or Kind.SCENE
            read = readers.get(kind, readers[Kind.SCENE])
            with status_line("reading the files", enabled=not arguments.json):
                result, code, _ = _checked(path, read, arguments.strict)
            own.append(result | {"checked": "head and checksum" if kind is Kind.SOURCE else "all"})
            worst = max(worst, code)
        if (Path(named) / "amc.inp").is_file():
            worst = max(worst, _check_scene(Path(named), arguments, own))
        results += own
    if arguments.json:
        print(json.dumps({"files": results, "ok": worst == 0}))
    else:
        printed: list[list[str]] = []  # a broken file that sky.toml names has its problems in both
        for result in results:
            if result["problems"] and result["problems"] not in printed:
                printed.append(result["problems"])
                print(*result["problems"], sep="\n", file=sys.stderr)
            # tables are for aomc_sky_load of a host, which has the compiler whose bits are in question
            ok = "ok" if result.get("checked") != "head and checksum" else "head and checksum are ok"
            print(f"{result['path']}: {ok if result['ok'] else 'has errors' if result['was_read'] else 'not read'}")
    return worst


def _files_of(path: Path) -> list[Path]:
    """The path itself, or the files with known names in a folder, those of a scene first; else its only table."""
    if not path.is_dir():
        return [path]
    known = [path / name for name in SCENE_FILES if (path / name).exists()]
    others = sorted(p for p in path.iterdir() if _is_known(p) and p not in known)
    return known + others or [only_table(path) or path / "amc.inp"]


def _is_known(path: Path) -> bool:
    """Whether a file in a folder has a known name; `skydist.png` and `report.toml` have not."""
    ending = _ENDING.get(kind) if (kind := kind_of_name(path.name)) else None
    return ending is not None and path.name.lower().endswith(ending)


def _checked(path: Path, read: Callable[[Path], Any], strict: bool) -> tuple[dict[str, Any], int, dict[str, list[str]]]:
    """The result of a file or folder, its exit code, and the lines of problems by file."""
    problems: list[str] = []
    by_path: dict[str, list[str]] = {}
    code, was_read = 0, True
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        warnings.simplefilter("always", ModelLimitWarning)
        try:
            read(path)
        except InputFileError as error:
            problems, code = error_text(error).split("\n"), error.exit_code
            for name in dict.fromkeys(problem.path for problem in error.problems):
                file_error = InputFileError([problem for problem in error.problems if problem.path == name])
                by_path[name] = str(file_error).split("\n")
        except AomcSkyError as error:
            problems, code = [error_text(error)], error.exit_code
            was_read = not isinstance(error, MissingExtraError)
    texts = list(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, _OURS)))
    noticed = [text if ": warning[" in text else f"{path}: warning: {text}" for text in texts]
    if strict and noticed:
        code = code or 3
    result = {"path": str(path), "ok": code == 0, "was_read": was_read, "problems": [*problems, *noticed]}
    return result, code, by_path
