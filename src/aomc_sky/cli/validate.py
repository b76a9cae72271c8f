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
    from aomc_sky.source.perez_inputs import GivenInputs


def add_parser(commands: Any) -> None:
    """Add the sub-command."""
    parser = commands.add_parser(
        "validate",
        help="read files and report every problem",
        description="Read every file named (of a folder: amc.inp, lambbot.inp, skydist.inp, difcol.inp, sky.toml, "
        "photons.mcpl, background.h5) and "
        "report every problem of every file; never sample. The kind of a file is told by its name.",
        epilog="examples:\n  aomc-sky validate inputs/clear_day\n  aomc-sky validate amc.inp skydist.inp",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("paths", nargs="+", metavar="FILE", help="a file, or a folder")
    parser.add_argument("--lenient", action="store_true", help="take Fortran's value where a person reads another one")
    parser.add_argument("--strict", action="store_true", help="warnings are errors")
    cli_options.add_path_option(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output and nothing else")
    cli_options.add_sky_options(parser)
    parser.set_defaults(handler=validate)


def _readers(lenient: bool, allow_paths: list[str]) -> dict[str, Callable[[Path], Any]]:
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
        "skydist": lambda path: read_skydist(path, lenient=lenient),
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


def _absent_difcol(path: Path, given: GivenInputs, allow_paths: list[str]) -> None:
    """Raise what `run` would, for a scene that has no difcol.inp and nothing in its place."""
    from aomc_sky.formats.amc import LightSource, read_amc
    from aomc_sky.formats.sky_toml import SkyToml, read_sky_toml
    from aomc_sky.source.perez_inputs import sky_inputs
    from aomc_sky.source.perez_light import difcol_of_inputs

    folder = path.parent
    if path.exists() or not (folder / "amc.inp").is_file():
        return
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            config = read_amc(folder / "amc.inp", lenient=True)
        exists = (folder / "sky.toml").exists()
        toml = read_sky_toml(folder / "sky.toml", allow_paths=allow_paths) if exists else SkyToml()
    except AomcSkyError:
        return  # reported under its own name
    has_light = toml.sky.model == "none" or toml.atmosphere is not None
    if config.light_source is LightSource.MODEL and not has_light:
        inputs = sky_inputs(config, toml, given)
        difcol_of_inputs(inputs.perez, inputs.sun, str(path), config.n_wavebands)


def _kind(path: Path, readers: dict[str, Any]) -> str:
    """Kind of a file by the begin of its name or its ending .toml, .mcpl, .h5 or .atmo; anything else is an amc.inp."""
    stem = path.name.lower()
    if stem.endswith((".mcpl", ".mcpl.gz")):
        return "photons.mcpl"
    if stem.endswith((".h5", ".hdf5")):
        return "background.h5"
    if stem.endswith(".atmo"):
        return ".atmo"
    if stem.endswith(".toml"):
        return "sky.toml"
    return next((kind for kind in readers if stem.startswith(kind)), "amc")


def validate(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.source.perez_inputs import given_inputs

    readers = _readers(arguments.lenient, arguments.allow_path)
    inputs = given_inputs(**cli_options.sky_arguments(arguments))
    results: list[dict[str, Any]] = []
    worst = 0
    for given in arguments.paths:
        for path in _files_of(Path(given), readers):
            result, code = _check(path, readers[_kind(path, readers)], arguments.strict)
            results.append(result)
            worst = max(worst, code)
        absent = functools.partial(_absent_difcol, given=inputs, allow_paths=arguments.allow_path)
        result, code = _check(Path(given) / "difcol.inp", absent, arguments.strict)
        if code:
            results.append(result)
            worst = max(worst, code)
    if arguments.json:
        print(json.dumps({"files": results, "ok": worst == 0}))
    else:
        for result in results:
            for text in result["problems"]:
                print(text, file=sys.stderr)
            print(f"{result['path']}: {'ok' if result['ok'] else 'has errors' if result['was_read'] else 'not read'}")
    return worst


def _files_of(path: Path, readers: dict[str, Any]) -> list[Path]:
    if not path.is_dir():
        return [path]
    known = [path / (kind if "." in kind else f"{kind}.inp") for kind in readers]
    found = [p for p in known if p.exists()]
    return found or [path / "amc.inp"]


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
