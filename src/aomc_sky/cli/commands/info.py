"""``aomc-sky info``: the contents of a scene, a run folder, or a file of one of the formats."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.background_report import report_background
from aomc_sky.cli.terminal import report_text, shown, table
from aomc_sky.errors import UsageError
from aomc_sky.options import LOBES
from aomc_sky.source.read.kind import Kind, kind_of

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.formats.mcpl.file import McplFile
    from aomc_sky.plan.plan import Plan

GROUPS = {
    "": "csv include_dir skies json",
    **cli_options.READING,
    **cli_options.WHEN,
    "lobes of a background sky at one --time": f"info.wavelengths {' '.join(LOBES)}",
}
FIRST = "csv time skies include-dir iterations json"


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Show what a scene (amc.inp or its folder), a run folder, an MCPL file, a background-sky file "
        "(HDF5), the description of an atmosphere (.atmo) or a source file (.sky) contains, or where the C headers "
        "are, or which sky models other packages bring."
    )
    parser.epilog = (
        "examples:\n  aomc-sky info inputs/clear_day\n  aomc-sky info out\n  aomc-sky info out/photons.mcpl\n"
        "  aomc-sky info out --csv > ed.csv                          irradiance of beam and sky in each waveband\n"
        "  aomc-sky info inputs/atmosphere/hazy.atmo\n"
        "  aomc-sky info night.h5                                    animations, keys, spectra\n"
        "  aomc-sky info night.h5 --time 2026-02-14T21:30:00Z        lobes and irradiances at one time\n"
        "  aomc-sky info --include-dir\n  aomc-sky info --skies"
    )
    parser.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        help="amc.inp, a folder, a measured sky (.csv), an MCPL, HDF5 (.h5, .hdf5), .atmo or .sky file",
    )
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=info)


def info(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    if arguments.include_dir or arguments.skies:
        if arguments.path is not None:
            raise UsageError("--include-dir and --skies take no PATH")
        if arguments.include_dir and arguments.skies:
            raise UsageError("--include-dir and --skies are two commands", "leave one out")
        if arguments.skies:
            return _skies(arguments)
        print(include_dir())
        return 0
    if arguments.path is None:
        raise UsageError("aomc-sky info needs a PATH, --include-dir or --skies")
    path = Path(arguments.path)
    reports = {
        Kind.RUN: _run,
        Kind.MCPL: _mcpl,
        Kind.SOURCE: _source,
        Kind.ATMOSPHERE: _atmosphere,
        Kind.BACKGROUND: report_background,
    }
    kind = kind_of(path) or Kind.SCENE
    if arguments.csv and kind is not Kind.RUN:
        raise UsageError(f"--csv is for {Kind.RUN.value}; {arguments.path} is {kind.value}")
    if arguments.csv and arguments.json:
        raise UsageError("--csv and --json both need standard output", "leave one out")
    _refuse_idle_options(arguments, kind, is_scene=kind not in reports)
    return reports.get(kind, _scene)(arguments, path)


def _refuse_idle_options(arguments: argparse.Namespace, kind: Kind, *, is_scene: bool) -> None:
    """Refuse options that do not apply to this kind of path."""
    of_lobes = cli_options.given_options(arguments, *LOBES)
    of_lobes += ["--wavelengths"] * (arguments.wavelengths is not None and not is_scene)
    of_scenes = cli_options.given_options(arguments, *cli_options.names_of(cli_options.READING | cli_options.WHEN))
    for option in of_lobes if kind is not Kind.BACKGROUND else ():
        raise UsageError(f"{option} is for {Kind.BACKGROUND.value}; {arguments.path} is {kind.value}")
    for option in of_scenes if not is_scene else ():
        is_used = option == "--time" and kind is Kind.BACKGROUND
        if not is_used and option not in ("--strict", "--max-memory", "--allow-path"):
            raise UsageError(f"{option} is for {Kind.SCENE.value}; {arguments.path} is {kind.value}")


def _skies(arguments: argparse.Namespace) -> int:
    """Print the sky models of other packages, and why some of them cannot be used."""
    from aomc_sky.errors import PluginError
    from aomc_sky.formats.sky_models import installed_skies

    installed = installed_skies()
    refused = list(installed.refused.values())
    skies: list[dict[str, Any]] = []
    for plugin in installed.plugins.values():
        about = {"name": plugin.name, "distribution": plugin.distribution, "version": plugin.version}
        try:
            make = plugin.load()
        except PluginError as error:
            refused.append(str(error))
            continue
        skies.append(
            {**about, "options": [make.shown(name, "needed" * needed) for name, needed in make.options.items()]}
        )

    def text() -> str:
        rows = [(s["name"], f"{s['distribution']} {s['version']}", ", ".join(s["options"]) or "-") for s in skies]
        listed = table(rows, ("--sky", "package", "--sky-option"), n_left=3)
        notes = [f"note: {why}" for why in refused]
        return "\n".join([listed if rows else "no other package brings a sky model", *notes])

    cli_options.answer(arguments, lambda: {"skies": skies, "refused": refused}, text)
    return 0


def _run(arguments: argparse.Namespace, path: Path) -> int:
    from aomc_sky.outputs.manifest import read_manifest
    from aomc_sky.plan.plan import Plan

    if not (path / "manifest.json").exists():
        if arguments.csv:
            raise UsageError(f"{path} is an unfinished run, which has no table", "finish it by its own command")
        return _unfinished(arguments, path)
    manifest = read_manifest(path / "manifest.json")
    has_plan = arguments.csv or os.path.lexists(path / "plan.npz")
    plan = Plan.load(path / "plan.npz") if has_plan else None
    if plan is not None and plan.sha256 != manifest["plan_sha256"]:
        from aomc_sky.formats.text_file import refuse

        raise refuse(path, "manifest.json belongs to another plan than plan.npz", advice="make the run again")

    if plan is not None and arguments.csv:
        print(_irradiance_csv(manifest, plan), end="")
        return 0

    def text() -> str:
        from aomc_sky.cli.commands.run import tables_text
        from aomc_sky.outputs.statistics import BandResult

        head = f"run folder {path}, aomc-sky {manifest['version']}, seed {manifest['seed']}"
        return "\n".join(
            [
                f"{head}, plan {manifest['plan_sha256']}",
                f"components: {', '.join(manifest['components'])}",
                *(f"note: {note}" for note in manifest["notes"]),
                tables_text([BandResult(**band) for band in manifest["bands"]], manifest["options"]["sampling"]),
                *(f"{name}: {entry['bytes']} bytes{_columns(entry)}" for name, entry in manifest["files"].items()),
            ]
        )

    cli_options.answer(arguments, lambda: manifest, text)
    return 0


def _irradiance_csv(manifest: Mapping[str, Any], plan: Plan) -> str:
    """A line for each waveband: share of the light and irradiance of each component; empty where no unit is known."""
    import csv
    import io

    import numpy as np

    names, text = plan.component_names, io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    of_parts = [f"{name}_{of}" for of in ("share", "W_m2_nm") for name in names]
    means = ("mean_cosine_exact", "ed_over_eo_exact")
    lines.writerow(["waveband", "wavelength_nm", *of_parts, "irradiance_W_m2_nm", "mean_cosine", "ed_over_eo"])
    for band in manifest["bands"]:
        shares = np.add.reduceat(plan.mass(band["waveband"] - 1), plan.component_start[:-1]).tolist()
        known = band["component_irradiance_W_m2_nm"] or {}
        head, tail = (band["waveband"], band["wavelength_nm"]), (band[name] for name in means)
        lines.writerow([*head, *shares, *map(known.get, names), band["irradiance_W_m2_nm"], *tail])
    return text.getvalue()


def _columns(entry: Mapping[str, Any]) -> str:
    """The record of a raw file."""
    return f", records of {', '.join(entry['columns'])} ({entry['numbers']})" if entry.get("columns") else ""


def _unfinished(arguments: argparse.Namespace, path: Path) -> int:
    from aomc_sky.outputs.shard import Shard, marks_among
    from aomc_sky.plan.plan import Plan

    plan = Plan.load(path / "plan.npz")
    shards = dict.fromkeys(marks_among(os.listdir(path)))
    values: dict[str, Any] = {
        "finished": False,
        "plan_sha256": plan.sha256,
        "seed": plan.seed,
        "requested": [band.requested for band in plan.bands],
        "components": list(plan.component_names),
        "shards": [str(shard) for shard in shards],
    }
    if shards:
        parts = (Shard(index=k, count=n) for n in sorted({s.count for s in shards}) for k in range(1, n + 1))
        values["missing"] = [str(shard) for shard in parts if shard not in shards]
    head = f"run folder {path}, unfinished; the command that started the run finishes it"
    cli_options.answer(arguments, lambda: values, lambda: report_text(head, values))
    return 0


def _scene(arguments: argparse.Namespace, path: Path) -> int:
    from aomc_sky.cli.commands.run import dry_run_text, scene_summary

    scene = cli_options.scene_of(arguments, str(path))

    def text() -> str:
        bands = zip(scene.wavebands.wavelength_nm, scene.sky_wavelength_nm, scene.n_photons, strict=True)
        rows = [(str(k), f"{w:g}", "-" if s != s else f"{s:g}", str(n)) for k, (w, s, n) in enumerate(bands, start=1)]
        named = [f"{role}: {name}" for role, name in scene.input_files.items()]
        return "\n".join(
            [*named, dry_run_text(scene, verbose=True), "", table(rows, ("band", "nm", "sky nm", "photons"))]
        )

    cli_options.answer(arguments, lambda: scene_summary(scene), text)
    return 0


def include_dir() -> Path:
    """Folder of aomc_sky.h, aomc_sky.c and aomc_sky.f90."""
    return Path(str(files("aomc_sky") / "include"))


_UNITS = {"energy": "MeV", "time": "ms", **dict.fromkeys("xyz", "cm")}


def _mcpl(arguments: argparse.Namespace, path: Path) -> int:
    """Print the head of a file and the bounds of its columns; every record is read and checked."""
    from aomc_sky.formats.mcpl.file import read_mcpl
    from aomc_sky.progress import status_line

    with status_line("reading the file", enabled=cli_options.is_verbose(arguments)):
        file = read_mcpl(path)
        bounds = _bounds(file)
    header = file.header
    what, comments = f"MCPL-{header.version}", list(header.comments)
    values = {
        "particles": header.n_particles,
        "bytes": file.data_start + header.n_particles * header.record.itemsize,
        "gzip": file.is_packed,
        "header_bytes": file.data_start,
        "particle_bytes": header.record.itemsize,
        "source": header.source,
        "blobs": {key: len(data) for key, data in header.blobs},
        "precision": "float64" if header.is_double else "float32",
        "byte_order": "little" if header.is_little_endian else "big",
        "user_flags": header.has_user_flags,
        "polarisation": header.has_polarisation,
        "pdg_code": header.pdg_code or None,
        "weight": header.weight or None,
    }

    def text() -> str:
        head = f"{what} file {path}, {header.n_particles} particles, {values['bytes']} bytes"
        lines = [report_text(head, values)]
        lines += [f"comment: {shown(comment)}" for comment in comments]
        rows = [(name, f"{low:.9g}", f"{high:.9g}", _UNITS.get(name, "")) for name, (low, high) in bounds.items()]
        return "\n".join([*lines, "", table(rows, ("", "least", "greatest", "unit"))])

    cli_options.answer(arguments, lambda: {"format": what} | values | {"comments": comments, "bounds": bounds}, text)
    return 0


def _source(arguments: argparse.Namespace, path: Path) -> int:
    """Print the head of a source file and its bands."""
    from aomc_sky.outputs.source_file import read_source_head

    values = read_source_head(path)

    def text() -> str:
        head = f"source file {path}, {values['bytes']} bytes, for aomc_sky.h"
        rows = [(str(b["waveband"]), f"{b['wavelength_nm']:g}", str(b["photons"])) for b in values["bands"]]
        lines = report_text(head, {name: value for name, value in values.items() if name not in ("bands", "bytes")})
        return "\n".join([lines, "", table(rows, ("band", "nm", "photons"))])

    cli_options.answer(arguments, lambda: values, text)
    return 0


def _bounds(file: McplFile) -> dict[str, tuple[float, float]]:
    """Least and greatest value of each column; empty for an empty file."""
    bounds: dict[str, tuple[float, float]] = {}
    for part in file.blocks():
        columns = {"energy": part.energy}
        columns |= {axis: part.position[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"u{axis}": part.direction[:, k] for k, axis in enumerate("xyz")}
        columns |= {name: getattr(part, name) for name in ("time", "weight", "pdg_code", "user_flags")}
        for name, values in columns.items():
            least, greatest = values.min().item(), values.max().item()
            before, after = bounds.get(name, (least, greatest))
            bounds[name] = min(before, least), max(after, greatest)
    return bounds


_DESCRIPTION = (
    "atmosphere_height_m", "earth_radius_m", "earth_sun_distance_m", "earth_moon_distance_m", "scattering_orders",
    "wavelength_nm", "solar_irradiance", "ground_albedo", "ground_glow", "glow_luminance_cd_m2",
)  # fmt: skip
_SCATTERER = (
    "name", "line", "cross_section_1um_m2", "angstrom_exponent", "single_scattering_albedo", "phase_function_type",
    "needs_interpolation_guides", "number_density", "phase_function",
)  # fmt: skip
_ABSORBER = ("name", "line", "cross_section_m2", "number_density")
_BY_SPECIES = ("optical_depth", "phase_norm", "phase_norm_error")


def _members(of: object, names: Iterable[str]) -> dict[str, Any]:
    """Some attributes as JSON values: numbers, arrays, enumerations and texts of a file."""
    values = {name: getattr(of, name) for name in names}
    return {
        name: value.tolist() if hasattr(value, "tolist") else getattr(value, "text", getattr(value, "value", value))
        for name, value in values.items()
    }


def _atmosphere(arguments: argparse.Namespace, path: Path) -> int:
    """Print the contents of a description, and what its code blocks compute."""
    from aomc_sky.skies.atmosphere.description.medium import read_medium
    from aomc_sky.skies.atmosphere.description.reader import read_atmo

    d = read_atmo(path, allow_paths=arguments.allow_path or ())
    _, medium = read_medium(d)
    what = "atmosphere description"
    values = {
        **_members(d, _DESCRIPTION),
        "scatterers": [_members(part, _SCATTERER) for part in d.scatterers],
        "absorbers": [_members(gas, _ABSORBER) for gas in d.absorbers],
        **{name: {key: array.tolist() for key, array in getattr(medium, name).items()} for name in _BY_SPECIES},
        "negligible_species": list(medium.dropped),
        "notes": list(d.texts),
        "sizes": dict(d.sizes),
        "textures_are_radiances": d.textures_are_radiances,
        "has_eclipsed_double_scattering_textures": d.has_eclipsed_double_scattering_textures,
    }
    with_path = {"format": what, "path": d.path} | values
    cli_options.answer(arguments, lambda: with_path, lambda: report_text(f"{what} {path}", values))
    return 0
