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
from aomc_sky.errors import AomcSkyError, InputFileError, InputWarning, MissingExtraError

if TYPE_CHECKING:
    from aomc_sky.formats.amc import AmcConfig
    from aomc_sky.formats.sky_toml import SkyToml
    from aomc_sky.source.perez_inputs import GivenInputs


_TABLES = ("amc", "lambbot", "difcol", "skydist")
_ENDINGS = {
    (".mcpl", ".mcpl.gz"): "photons.mcpl",
    (".h5", ".hdf5"): "background.h5",
    (".atmo",): ".atmo",
    (".toml",): "sky.toml",
}


def add_parser(commands: Any) -> None:
    """Add the sub-command."""
    parser = commands.add_parser(
        "validate",
        help="read files and report every problem",
        description="Read every file named (of a folder: all of a known name, and those that its amc.inp asks for) and "
        "report every problem of every file; never sample. The kind of a file is told by its name: amc, lambbot, "
        "skydist or difcol at its begin or between dots, or its ending .toml, .mcpl, .h5 or .atmo.",
        epilog="examples:\n  aomc-sky validate inputs/clear_day\n  aomc-sky validate amc.inp skydist.inp",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("paths", nargs="+", metavar="FILE", help="a file, or a folder")
    parser.add_argument("--lenient", action="store_true", help="take Fortran's value where a person reads another one")
    parser.add_argument("--strict", action="store_true", help="warnings are errors")
    cli_options.add_path_option(parser)
    cli_options.add_memory_option(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output and nothing else")
    cli_options.add_sky_options(parser)
    parser.set_defaults(handler=validate)


def _readers(lenient: bool, allow_paths: list[str], max_memory: int | None) -> dict[str, Callable[[Path], Any]]:
    from aomc_sky.formats.amc import read_amc
    from aomc_sky.formats.background_hdf5 import read_background_file
    from aomc_sky.formats.difcol import read_difcol
    from aomc_sky.formats.lambbot import read_lambbot
    from aomc_sky.formats.mcpl import check_mcpl
    from aomc_sky.formats.skydist import read_skydist

    return {
        "amc": lambda path: read_amc(path, lenient=lenient),
        "lambbot": lambda path: _read_beside(path, read_lambbot, lenient, with_target=True),
        "difcol": lambda path: _read_beside(path, read_difcol, lenient, with_target=False),
        "skydist": lambda path: read_skydist(path, lenient=lenient, max_memory_bytes=max_memory),
        "sky.toml": lambda path: _read_toml(path, lenient, allow_paths),
        "photons.mcpl": check_mcpl,
        "background.h5": read_background_file,
        ".atmo": lambda path: _read_atmosphere(path, allow_paths),
    }


def _read_atmosphere(path: Path, allow_paths: list[str]) -> None:
    """Read a description of an atmosphere, its tables, and its code."""
    from aomc_sky.formats.atmo import read_atmo
    from aomc_sky.source.atmosphere_medium import read_medium

    read_medium(read_atmo(path, allow_paths=allow_paths))


def _read_beside(path: Path, read: Callable[..., Any], lenient: bool, *, with_target: bool) -> Any:
    """Read a file with one row per waveband; an amc.inp beside it tells how many."""
    extra: dict[str, Any] = {}
    amc = path.parent / "amc.inp"
    if amc.is_file():
        from aomc_sky.formats.amc import read_amc

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", InputWarning)
                config = read_amc(amc, lenient=lenient)
            extra["n_wavebands"] = config.n_wavebands
            if with_target:
                extra["has_target"] = config.bottom_target
        except AomcSkyError:
            pass  # reported under its own name
    return read(path, lenient=lenient, **extra)


def _read_toml(path: Path, lenient: bool, allow_paths: list[str]) -> None:
    """Read sky.toml, and the background-sky files and the atmosphere that it names."""
    from aomc_sky.formats.sky_toml import read_sky_toml

    read = functools.partial(read_sky_toml, allow_paths=allow_paths)
    toml = _read_beside(path, read, lenient, with_target=False)
    if toml.background:
        from aomc_sky.source.background_light import read_backgrounds

        read_backgrounds(toml.background, str(path))
    if toml.atmosphere is not None:
        _read_atmosphere(Path(toml.atmosphere.file), allow_paths)


def _scene_heads(folder: Path, allow_paths: list[str]) -> tuple[AmcConfig, SkyToml] | None:
    """Return what amc.inp and sky.toml of a folder say, None where one is broken, which its own reading tells."""
    from aomc_sky.formats.amc import read_amc
    from aomc_sky.formats.sky_toml import SkyToml, read_sky_toml

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            config = read_amc(folder / "amc.inp", lenient=True)
        exists = (folder / "sky.toml").exists()
        return config, read_sky_toml(folder / "sky.toml", allow_paths=allow_paths) if exists else SkyToml()
    except AomcSkyError:
        return None


def _absent_table(path: Path, allow_paths: list[str]) -> None:
    """Raise what `run` would, for a scene that has no lambbot.inp, or no skydist.inp and nothing in its place."""
    from aomc_sky.formats.amc import LightSource
    from aomc_sky.formats.text_file import read_bytes

    if path.exists() or not (path.parent / "amc.inp").is_file():
        return
    if path.stem == "skydist":
        heads = _scene_heads(path.parent, allow_paths)
        if heads is None or heads[0].light_source is not LightSource.FILE:
            return
        if heads[1].sky.model is not None or heads[1].atmosphere is not None:
            return
    read_bytes(path)


def _absent_difcol(path: Path, given: GivenInputs, allow_paths: list[str]) -> None:
    """Raise what `run` would, for a scene that has no difcol.inp and nothing in its place."""
    from aomc_sky.formats.amc import LightSource
    from aomc_sky.source.perez_inputs import sky_inputs
    from aomc_sky.source.perez_light import difcol_of_inputs

    if path.exists() or not (path.parent / "amc.inp").is_file():
        return
    heads = _scene_heads(path.parent, allow_paths)
    if heads is None:
        return
    config, toml = heads
    has_light = toml.sky.model == "none" or toml.atmosphere is not None
    if config.light_source is LightSource.MODEL and not has_light:
        inputs = sky_inputs(config, toml, given)
        difcol_of_inputs(inputs.perez, inputs.sun, str(path), config.n_wavebands)


def _kind(path: Path) -> str | None:
    """Kind of a file by its ending, or by the begin or a part of its name; None for any other name."""
    name = path.name.lower()
    for endings, kind in _ENDINGS.items():
        if name.endswith(endings):
            return kind
    return next((kind for kind in _TABLES if name.startswith(kind) or f".{kind}." in name), None)


def validate(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.source.perez_inputs import given_inputs

    readers = _readers(arguments.lenient, arguments.allow_path, arguments.max_memory)
    inputs = given_inputs(**cli_options.sky_arguments(arguments))
    results: list[dict[str, Any]] = []
    worst = 0
    absent = functools.partial(_absent_table, allow_paths=arguments.allow_path)
    no_difcol = functools.partial(_absent_difcol, given=inputs, allow_paths=arguments.allow_path)
    needed = {"lambbot.inp": absent, "skydist.inp": absent, "difcol.inp": no_difcol}
    for given in arguments.paths:
        for path in _files_of(Path(given)):
            result, code = _check(path, readers[_kind(path) or "amc"], arguments.strict)
            results.append(result)
            worst = max(worst, code)
        for name, check in needed.items():
            result, code = _check(Path(given) / name, check, arguments.strict)
            if code:
                results.append(result)
                worst = max(worst, code)
    if arguments.json:
        print(json.dumps({"files": results, "ok": worst == 0}))
    else:
        told: list[list[str]] = []  # a broken file that sky.toml names is read for both of them
        for result in results:
            if result["problems"] and result["problems"] not in told:
                told.append(result["problems"])
                print(*result["problems"], sep="\n", file=sys.stderr)
            print(f"{result['path']}: {'ok' if result['ok'] else 'has errors' if result['was_read'] else 'not read'}")
    return worst


def _files_of(path: Path) -> list[Path]:
    """The path itself, or the files of a folder that have known names, those of a scene first."""
    if not path.is_dir():
        return [path]
    first = [f"{kind}.inp" for kind in _TABLES] + ["sky.toml"]
    found = [path / name for name in first if (path / name).exists()]
    others = sorted(p for p in path.iterdir() if _is_known(p) and p not in found)
    return found + others or [path / "amc.inp"]


def _is_known(path: Path) -> bool:
    """Whether the name of a file of a folder tells its kind; `skydist.png` and `report.toml` do not."""
    kind = _kind(path)
    name = path.name.lower()
    if kind in _TABLES:
        return name.endswith(".inp")
    return kind is not None and (kind != "sky.toml" or name.endswith("sky.toml"))


def _check(path: Path, read: Callable[[Path], Any], strict: bool) -> tuple[dict[str, Any], int]:
    problems: list[str] = []
    code, was_read = 0, True
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        try:
            read(path)
        except InputFileError as error:
            problems, code = str(error).split("\n"), error.exit_code
        except MissingExtraError as error:
            problems, code, was_read = [f"aomc-sky: error: {error}"], error.exit_code, False
        except AomcSkyError as error:
            problems, code = [str(error)], error.exit_code
    noticed = [str(w.message) for w in caught if issubclass(w.category, InputWarning)]
    if strict and noticed:
        code = code or 3
    found = {"path": str(path), "ok": code == 0, "was_read": was_read, "problems": [*problems, *noticed]}
    return found, code
