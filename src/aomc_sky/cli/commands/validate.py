"""``aomc-sky validate``: every problem of every file, and nothing else."""

from __future__ import annotations

import argparse
import functools
import json
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import error_text
from aomc_sky.errors import AomcSkyError, InputFileError, InputWarning, MissingExtraError, ModelLimitWarning
from aomc_sky.source.read.kind import SCENE_FILES, Kind, kind_of_name, not_a_scene

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser

_OURS = (InputWarning, ModelLimitWarning)
_ENDING = {
    **dict.fromkeys((Kind.SCENE, Kind.LAMBBOT, Kind.DIFCOL, Kind.TABLE), ".inp"),
    Kind.SKY_TOML: "sky.toml",
    **dict.fromkeys((Kind.MCPL, Kind.BACKGROUND, Kind.ATMOSPHERE), ""),
}
"""Ends of the names of files that are read in a folder."""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Read every file named (of a folder: all of a known name, and those that its amc.inp asks for) and "
        "report every problem of every file, and of a folder with amc.inp whatever `run` would refuse; never "
        "make photons. The name of a file says its kind: amc, lambbot, "
        "skydist or difcol at its start or between dots, or its ending .toml, .mcpl, .h5, .atmo or .csv (a measured "
        "sky)."
    )
    parser.epilog = "examples:\n  aomc-sky validate inputs/clear_day\n  aomc-sky validate amc.inp skydist.inp"
    parser.add_argument("paths", nargs="+", metavar="FILE", help="a file, or a folder")
    cli_options.add_table(parser, "--json")
    cli_options.add_reading_options(parser)
    cli_options.add_moment_options(parser)
    parser.show_first("lenient strict compat allow-path json")
    parser.set_defaults(handler=validate)


def _readers(arguments: argparse.Namespace) -> dict[Kind, Callable[[Path], Any]]:
    lenient, allow_paths, max_memory = arguments.lenient, arguments.allow_path, arguments.max_memory
    from aomc_sky.formats.aomc.amc import read_difcol, read_lambbot
    from aomc_sky.formats.aomc.skydist import read_skydist
    from aomc_sky.formats.mcpl.file import check_mcpl

    return {
        Kind.SCENE: lambda path: _read_amc(path, lenient),
        Kind.LAMBBOT: lambda path: _read_beside(
            path, functools.partial(read_lambbot, lenient=lenient), lenient, with_target=True
        ),
        Kind.DIFCOL: lambda path: _read_beside(path, read_difcol, lenient, with_target=False),
        Kind.TABLE: lambda path: read_skydist(path, lenient=lenient, max_memory_bytes=max_memory),
        Kind.SKY_TOML: lambda path: _read_toml(path, lenient, allow_paths, arguments),
        Kind.MCPL: check_mcpl,
        Kind.BACKGROUND: _read_background,
        Kind.ATMOSPHERE: lambda path: _read_atmosphere(path, allow_paths),
        Kind.MEASURED: lambda path: cli_options.scene_of(arguments, str(path)),
    }


def _read_amc(path: Path, lenient: bool) -> None:
    """Read amc.inp; what holds something else is named."""
    from aomc_sky.formats.aomc.amc import read_amc

    try:
        read_amc(path, lenient=lenient)
    except InputFileError as error:
        raise not_a_scene(path) or error from None


def _read_background(path: Path) -> None:
    """Read a background-sky file."""
    from aomc_sky.skies.lobes.file.file import read_background_file

    read_background_file(path)


def _read_atmosphere(path: Path, allow_paths: list[str]) -> None:
    """Read a description of an atmosphere, its tables, and its code."""
    from aomc_sky.skies.atmosphere.description.medium import read_medium
    from aomc_sky.skies.atmosphere.description.reader import read_atmo

    read_medium(read_atmo(path, allow_paths=allow_paths))


def _read_beside(path: Path, read: Callable[..., Any], lenient: bool, *, with_target: bool) -> Any:
    """Read a file with one row per waveband; an amc.inp beside it tells how many."""
    extra: dict[str, Any] = {}
    amc = path.parent / "amc.inp"
    if amc.is_file():
        from aomc_sky.formats.aomc.amc import read_amc

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", InputWarning)
                config = read_amc(amc, lenient=lenient)
            extra["n_wavebands"] = config.n_wavebands
            if with_target:
                extra["has_target"] = config.bottom_target
        except AomcSkyError:
            pass  # reported under its own name
    return read(path, **extra)


def _read_toml(path: Path, lenient: bool, allow_paths: list[str], arguments: argparse.Namespace) -> None:
    """Read sky.toml, and the background-sky files, the atmosphere, the field and the sky model that it names."""
    from aomc_sky.formats.sky_toml.file import read_sky_toml

    read = functools.partial(read_sky_toml, allow_paths=allow_paths)
    toml = _read_beside(path, read, lenient, with_target=False)
    if toml.background:
        from aomc_sky.skies.lobes.light import read_backgrounds

        read_backgrounds(toml.background, str(path))
    if toml.atmosphere is not None:
        _read_atmosphere(Path(toml.atmosphere.file), allow_paths)
    if toml.sky.table is not None and arguments.sky is None:
        from aomc_sky.source.read.field import read_sky_field

        read_sky_field(toml.sky.table, str(path))
    if toml.sky.model_span is not None and arguments.sky in (None, toml.sky.model):
        from aomc_sky.source.read.plugin import choose_plugin

        choose_plugin(toml.sky.model, toml.sky, cli_options.sky_option_arguments(arguments), str(path))


def _refusal(folder: Path, arguments: argparse.Namespace) -> None:
    """Raise what `run` would for the scene of a folder: files that are missing, a sky without light, too large a plan.

    The light of an atmosphere takes `run` its minutes and is not solved here.
    """
    from aomc_sky.source.read.files import read_scene_files

    how = (arguments.sky, arguments.lenient, arguments.compat, arguments.allow_path, arguments.max_memory)
    options = cli_options.sky_option_arguments(arguments)
    if read_scene_files(folder / "amc.inp", *how, options).atmosphere is None:
        scene = cli_options.scene_of(arguments, str(folder))
        source = scene.source(max_memory_bytes=arguments.max_memory)
        if arguments.max_memory is not None:
            from aomc_sky.engine.run import JobOptions, check_memory

            check_memory(source, JobOptions(max_memory_bytes=arguments.max_memory))


def _check_scene(folder: Path, arguments: argparse.Namespace, results: list[dict[str, Any]]) -> int:
    """Add to the results what no file alone shows; return the exit code of `run`."""
    of_path = {result["path"]: result for result in results}
    known = {line for result in results for line in result["problems"]}
    of_scene, code, by_path = _checked(folder, lambda path: _refusal(path, arguments), arguments.strict)
    for path, problems in by_path.items():
        result = of_path.get(path)
        if result is None:
            results.append(_result(path, code, problems))
        elif result["ok"]:
            result.update(ok=False, problems=[*result["problems"], *problems])
    rest = [text for text in of_scene["problems"] if text not in known] if not by_path else []
    if rest:
        results.append({**of_scene, "problems": rest})
    return code


def validate(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.progress import patience
    from aomc_sky.source.light.inputs import given_inputs

    given_inputs(**cli_options.sky_arguments(arguments))
    readers = _readers(arguments)
    results: list[dict[str, Any]] = []
    worst = 0
    for named in arguments.paths:
        own: list[dict[str, Any]] = []
        for path in _files_of(Path(named)):
            with patience("reading the files", enabled=not arguments.json):
                result, code, _ = _checked(
                    path, readers.get(kind_of_name(path.name) or Kind.SCENE, readers[Kind.SCENE]), arguments.strict
                )
            own.append(result)
            worst = max(worst, code)
        if (Path(named) / "amc.inp").is_file():
            worst = max(worst, _check_scene(Path(named), arguments, own))
        results += own
    if arguments.json:
        print(json.dumps({"files": results, "ok": worst == 0}))
    else:
        printed: list[list[str]] = []  # a broken file that sky.toml names is read for both of them
        for result in results:
            if result["problems"] and result["problems"] not in printed:
                printed.append(result["problems"])
                print(*result["problems"], sep="\n", file=sys.stderr)
            print(f"{result['path']}: {'ok' if result['ok'] else 'has errors' if result['was_read'] else 'not read'}")
    return worst


def _files_of(path: Path) -> list[Path]:
    """The path itself, or the files of a folder that have known names, those of a scene first."""
    if not path.is_dir():
        return [path]
    known = [path / name for name in SCENE_FILES if (path / name).exists()]
    others = sorted(p for p in path.iterdir() if _is_known(p) and p not in known)
    return known + others or [path / "amc.inp"]


def _is_known(path: Path) -> bool:
    """Whether the name of a file of a folder tells its kind; `skydist.png` and `report.toml` do not."""
    ending = _ENDING.get(kind) if (kind := kind_of_name(path.name)) else None
    return ending is not None and path.name.lower().endswith(ending)


def _checked(path: Path, read: Callable[[Path], Any], strict: bool) -> tuple[dict[str, Any], int, dict[str, list[str]]]:
    """What to report of a file or folder, the exit code, and the lines of problems under the files that they are of."""
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
                of_file = InputFileError([problem for problem in error.problems if problem.path == name])
                by_path[name] = str(of_file).split("\n")
        except MissingExtraError as error:
            problems, code, was_read = [error_text(error)], error.exit_code, False
        except AomcSkyError as error:
            problems, code = [error_text(error)], error.exit_code
    noticed = list(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, _OURS)))
    if strict and noticed:
        code = code or 3
    result = {"path": str(path), "ok": code == 0, "was_read": was_read, "problems": [*problems, *noticed]}
    return result, code, by_path


def _result(path: str, code: int, problems: list[str]) -> dict[str, Any]:
    return {"path": path, "ok": code == 0, "was_read": True, "problems": problems}
