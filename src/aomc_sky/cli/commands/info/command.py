"""``aomc-sky info``: what a scene, a run folder, or a file of one of the formats contains."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import sysconfig
from importlib.resources import files
from pathlib import Path
from typing import Any

from aomc_sky.cli import options as cli_options
from aomc_sky.errors import AomcSkyError, UsageError


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Show what a scene (amc.inp or its folder), a run folder, an MCPL file, a background-sky file "
        "(HDF5) or the description of an atmosphere (.atmo) contains, or where the C headers are."
    )
    parser.epilog = (
        "examples:\n  aomc-sky info inputs/clear_day\n  aomc-sky info out\n  aomc-sky info out/photons.mcpl\n"
        "  aomc-sky info inputs/atmosphere/hazy.atmo\n"
        "  aomc-sky info --include-dir"
    )
    parser.add_argument(
        "path", metavar="PATH", nargs="?", help="amc.inp, a folder, an MCPL, HDF5 (.h5, .hdf5) or .atmo file"
    )
    building = parser.add_mutually_exclusive_group()
    building.add_argument(
        "--include-dir", action="store_true", help="print the folder of aomc_sky.h, aomc_sky.f90 and aomc_sky_embed.c"
    )
    building.add_argument(
        "--embed-flags", action="store_true", help="print the compiler flags for a C program that starts Python itself"
    )
    cli_options.add_reading_options(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output and nothing else")
    parser.set_defaults(handler=info)


def info(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    if arguments.include_dir or arguments.embed_flags:
        return _for_compilers(arguments)
    if arguments.path is None:
        raise UsageError("aomc-sky info wants a PATH, --include-dir or --embed-flags")
    path = Path(arguments.path)
    if path.is_dir() and ((path / "manifest.json").exists() or (path / "plan.npz").exists()):
        return _run_folder(path, as_json=arguments.json)
    if path.name.lower().endswith((".mcpl", ".mcpl.gz")):
        from aomc_sky.cli.commands.info.mcpl import report_mcpl

        return report_mcpl(path, as_json=arguments.json)
    if path.name.lower().endswith(".atmo"):
        from aomc_sky.cli.commands.info.atmo import report_atmo

        return report_atmo(path, as_json=arguments.json, allow_paths=arguments.allow_path)
    if path.name.lower().endswith((".h5", ".hdf5")):
        from aomc_sky.cli.commands.info.background import report_background

        return report_background(path, as_json=arguments.json)
    return _scene(arguments)


def _for_compilers(arguments: argparse.Namespace) -> int:
    if arguments.path is not None:
        raise UsageError("--include-dir and --embed-flags take no PATH")
    print(include_dir() if arguments.include_dir else " ".join(embed_flags()))
    return 0


def _run_folder(path: Path, *, as_json: bool) -> int:
    from aomc_sky.outputs.folder.run_folder import RunFolder

    RunFolder(path).require_regular_files()
    if not (path / "manifest.json").exists():
        return _unfinished(path, as_json=as_json)
    from aomc_sky.cli.commands.run import band_table, error_text, irradiance_text
    from aomc_sky.outputs.blocks.statistics import BandResult
    from aomc_sky.outputs.manifest import read_manifest

    manifest = read_manifest(path / "manifest.json")
    _check_plan(path, manifest)
    if as_json:
        print(json.dumps(manifest))
        return 0
    print(f"run folder {path}, aomc-sky {manifest['version']}, seed {manifest['seed']}, plan {manifest['plan_sha256']}")
    print(f"components: {', '.join(manifest['components'])}")
    for note in manifest["notes"]:
        print(f"note: {note}")
    bands = [BandResult(**band) for band in manifest["bands"]]
    print(f"\n{band_table(bands)}\n")
    absolute = irradiance_text(bands)
    if absolute:
        print(f"{absolute}\n")
    errors = error_text(bands, manifest["options"]["sampling"])
    if errors:
        print(f"{errors}\n")
    if manifest["content"] is not None:
        print(f"content: {manifest['content']['root']}")
    for name, entry in manifest["files"].items():
        print(f"{name}: {entry['bytes']} bytes, SHA-256 {entry['sha256']}")
    return 0


def _check_plan(path: Path, manifest: dict[str, Any]) -> None:
    """Raise unless the plan of a finished run, where it is there, is whole and that of its manifest."""
    from aomc_sky.formats.text_file import refuse
    from aomc_sky.outputs.manifest import require_wavebands
    from aomc_sky.source.plan.plan import Plan

    if not (path / "plan.npz").exists():
        return
    plan = Plan.load(path / "plan.npz")
    require_wavebands(path / "manifest.json", manifest, plan.n_bands)
    if plan.sha256 != manifest["plan_sha256"]:
        raise refuse(path, "manifest.json belongs to another plan than plan.npz", advice="make the run again")


def _unfinished(path: Path, *, as_json: bool) -> int:
    from aomc_sky.outputs.folder.run_folder import RunFolder
    from aomc_sky.source.plan.plan import Plan

    plan = Plan.load(path / "plan.npz")
    requested = [int(n) for n in plan.arrays["requested"]]
    shards = [str(shard) for shard in RunFolder(path).finished_shards()]
    if as_json:
        known = {"plan_sha256": plan.sha256, "seed": plan.seed, "requested": requested, "shards": shards}
        print(json.dumps({"finished": False} | known))
        return 0
    print(f"run folder {path}, unfinished, seed {plan.seed}, plan {plan.sha256}")
    print(f"components: {', '.join(plan.component_names)}")
    print(
        f"{sum(requested)} photons wanted in {len(requested)} wavebands; the command that started the run finishes it"
    )
    if shards:
        print(f"finished shards: {', '.join(shards[:20])}{' ...' if len(shards) > 20 else ''} ({len(shards)})")
    return 0


def _scene(arguments: argparse.Namespace) -> int:
    from aomc_sky.cli.commands.run import dry_run_text, scene_summary
    from aomc_sky.cli.table import table

    scene = cli_options.scene_of(arguments, arguments.path)
    if arguments.json:
        print(json.dumps(scene_summary(scene)))
        return 0
    for role, name in scene.input_files.items():
        print(f"{role}: {name}")
    print(dry_run_text(scene))
    rows = [
        (str(k + 1), f"{w:g}", "-" if s != s else f"{s:g}", str(n))
        for k, (w, s, n) in enumerate(
            zip(scene.wavebands.wavelength_nm, scene.sky_wavelength_nm, scene.n_photons, strict=True)
        )
    ]
    print(f"\n{table(rows, ('band', 'nm', 'sky nm', 'photons'))}")
    return 0


def include_dir() -> Path:
    """Folder of aomc_sky.h, aomc_sky.f90 and aomc_sky_embed.c."""
    return Path(str(files("aomc_sky") / "include"))


def embed_flags() -> list[str]:
    """Flags that compile aomc_sky_embed.c and link a program with the Python that runs this.

    As ``python3-config --cflags --ldflags --embed`` gives them, but for this very interpreter, also from a virtual
    environment, and with the path of the latter, so that the program finds aomc-sky. They are meant for
    ``cc ... $(aomc-sky info --embed-flags)``: the shell looks at no quotes there.
    """
    headers = Path(sysconfig.get_paths()["include"])
    if not (headers / "Python.h").exists():
        raise AomcSkyError(f"{headers}/Python.h is missing; install the headers of this Python (python3-dev on Debian)")
    macro = f'-DAOMC_SKY_PYTHON="{sys.executable}"'
    return [f"-I{include_dir()}", f"-I{headers}", macro, *_library(), *_words("LIBS"), *_words("SYSLIBS")]


def _words(name: str) -> list[str]:
    return shlex.split(sysconfig.get_config_var(name) or "")


def _library() -> list[str]:
    """The shared library where it is installed, else the static one with all that extensions look for in it."""
    version = sysconfig.get_config_var("LDVERSION") or sysconfig.get_config_var("py_version_short")
    main, fixed = (Path(sysconfig.get_config_var(name) or "") for name in ("LIBDIR", "LIBPL"))
    folders = [main, main / (sysconfig.get_config_var("MULTIARCH") or ""), fixed]
    for place in folders:
        if (place / f"libpython{version}.so").exists():
            return [f"-L{place}", f"-lpython{version}", f"-Wl,-rpath,{place}"]
    for place in folders:
        static = place / f"libpython{version}.a"
        if static.exists():
            return ["-no-pie", str(static), "-Wl,--export-dynamic", *_words("MODLIBS")]
    looked = ", ".join(str(place) for place in dict.fromkeys(folders))
    raise AomcSkyError(
        f"libpython{version} is in none of {looked}; install it (python3-dev on Debian), "
        "or build Python with --enable-shared"
    )
