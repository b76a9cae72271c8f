"""``aomc-sky info``: what a scene, a run folder, or a file of one of the formats contains."""

from __future__ import annotations

import argparse
import json
import os
import shlex
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import AomcSkyError, UsageError
from aomc_sky.source.read.kind import Kind, kind_of

if TYPE_CHECKING:
    import numpy as np

    from aomc_sky.cli.usage import Parser
    from aomc_sky.errors import SourceText
    from aomc_sky.formats.atmo.data import AbsorberDescription, AtmosphereDescription, ScattererDescription
    from aomc_sky.formats.mcpl.file import McplFile, McplParticles
    from aomc_sky.source.atmospheres.medium import MediumReport


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Show what a scene (amc.inp or its folder), a run folder, an MCPL file, a background-sky file "
        "(HDF5) or the description of an atmosphere (.atmo) contains, or where the C headers are, or which sky models "
        "other packages bring."
    )
    parser.epilog = (
        "examples:\n  aomc-sky info inputs/clear_day\n  aomc-sky info out\n  aomc-sky info out/photons.mcpl\n"
        "  aomc-sky info inputs/atmosphere/hazy.atmo\n"
        "  aomc-sky info night.h5                                    animations, keys, spectra\n"
        "  aomc-sky info night.h5 --time 2026-02-14T21:30:00Z        lobes and irradiances at one time\n"
        "  aomc-sky info --include-dir\n  aomc-sky info --skies"
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
    building.add_argument("--skies", action="store_true", help="list the sky models of other packages (--sky NAME)")
    cli_options.add_reading_options(parser)
    cli_options.add_moment_options(parser)
    group = parser.add_argument_group("lobes of a background sky at one --time")
    cli_options.add_background_options(group)
    group.add_argument(
        "--wavelength", type=cli_options.finite_number, nargs="+", metavar="NM", help="default: those of the spectra"
    )
    cli_options.add_shared(parser, "json")
    parser.show_first("time skies include-dir embed-flags iterations json")
    parser.set_defaults(handler=info)


def info(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    if arguments.include_dir or arguments.embed_flags or arguments.skies:
        if arguments.path is not None:
            raise UsageError("--include-dir, --embed-flags and --skies take no PATH")
        return _skies(as_json=arguments.json) if arguments.skies else _for_compilers(arguments)
    if arguments.path is None:
        raise UsageError("aomc-sky info needs a PATH, --include-dir, --embed-flags or --skies")
    path = Path(arguments.path)
    kind = kind_of(path)
    if kind is Kind.ATMOSPHERE:
        return report_atmo(path, as_json=arguments.json, allow_paths=arguments.allow_path)
    if kind is Kind.BACKGROUND:
        from aomc_sky.cli.background_report import report_background

        return report_background(arguments)
    reports = {Kind.RUN: _run_folder, Kind.MCPL: report_mcpl}
    return reports[kind](path, as_json=arguments.json) if kind in reports else _scene(arguments)


def _for_compilers(arguments: argparse.Namespace) -> int:
    print(include_dir() if arguments.include_dir else " ".join(embed_flags()))
    return 0


def _skies(*, as_json: bool) -> int:
    """The sky models of other packages, and why some of them cannot be used."""
    from aomc_sky.errors import PluginError
    from aomc_sky.sky_plugins import installed_skies

    installed = installed_skies()
    refused, skies = list(installed.refused.values()), []
    for plugin in installed.plugins.values():
        try:
            make = plugin.load()
        except PluginError as error:
            refused.append(str(error))
            continue
        about = {"name": plugin.name, "distribution": plugin.distribution, "version": plugin.version}
        skies.append((about, [f"{name} (needed)" if needed else name for name, needed in make.options.items()]))
    if as_json:
        print(json.dumps({"skies": [about | {"options": options} for about, options in skies], "refused": refused}))
        return 0
    rows = [(a["name"], f"{a['distribution']} {a['version']}", ", ".join(options) or "-") for a, options in skies]
    head = ("--sky", "package", "--sky-option")
    print(table(rows, head, n_left=3) if rows else "no other package brings a sky model")
    for text in refused:
        print(f"note: {text}")
    return 0


def _run_folder(path: Path, *, as_json: bool) -> int:
    if not (path / "manifest.json").exists():
        return _unfinished(path, as_json=as_json)
    from aomc_sky.cli.commands.run import band_table, error_text, irradiance_text
    from aomc_sky.outputs.manifest import read_manifest
    from aomc_sky.outputs.statistics import BandResult

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
    for name, entry in manifest["files"].items():
        print(f"{name}: {entry['bytes']} bytes")
    return 0


def _check_plan(path: Path, manifest: dict[str, Any]) -> None:
    """Raise unless the plan of a finished run, where it is there, is whole and that of its manifest."""
    from aomc_sky.formats.text_file import refuse
    from aomc_sky.source.plan.plan import Plan

    if not os.path.lexists(path / "plan.npz"):
        return
    plan = Plan.load(path / "plan.npz")
    if plan.sha256 != manifest["plan_sha256"]:
        raise refuse(path, "manifest.json belongs to another plan than plan.npz", advice="make the run again")


def _unfinished(path: Path, *, as_json: bool) -> int:
    from aomc_sky.outputs.shard import marks_among
    from aomc_sky.source.plan.plan import Plan

    plan = Plan.load(path / "plan.npz")
    requested = [int(n) for n in plan.arrays["requested"]]
    shards = [str(shard) for shard in marks_among(os.listdir(path))]
    if as_json:
        known = {"plan_sha256": plan.sha256, "seed": plan.seed, "requested": requested, "shards": shards}
        print(json.dumps({"finished": False} | known))
        return 0
    print(f"run folder {path}, unfinished, seed {plan.seed}, plan {plan.sha256}")
    print(f"components: {', '.join(plan.component_names)}")
    print(
        f"{sum(requested)} photons requested in {len(requested)} wavebands; "
        "the command that started the run finishes it"
    )
    if shards:
        print(f"finished shards: {', '.join(shards[:20])}{' ...' if len(shards) > 20 else ''} ({len(shards)})")
    return 0


def _scene(arguments: argparse.Namespace) -> int:
    from aomc_sky.cli.commands.run import dry_run_text, scene_summary

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
    for folder in folders:
        if (folder / f"libpython{version}.so").exists():
            return [f"-L{folder}", f"-lpython{version}", f"-Wl,-rpath,{folder}"]
    for folder in folders:
        static = folder / f"libpython{version}.a"
        if static.exists():
            return ["-no-pie", str(static), "-Wl,--export-dynamic", *_words("MODLIBS")]
    looked = ", ".join(str(folder) for folder in dict.fromkeys(folders))
    raise AomcSkyError(
        f"libpython{version} is in none of {looked}; install it (python3-dev on Debian), "
        "or build Python with --enable-shared"
    )


_MAX_COMMENT = 400


def report_mcpl(path: Path, *, as_json: bool) -> int:
    """Print what a file holds; every record is read and checked."""
    from aomc_sky.cli.progress import patience
    from aomc_sky.formats.mcpl.file import read_mcpl

    with patience("reading the file", enabled=not as_json):
        file = read_mcpl(path)
        bounds = _bounds(file)
    print(json.dumps(_mcpl_summary(file, bounds)) if as_json else "\n".join(_mcpl_lines(file, bounds)))
    return 0


def _mcpl_columns(part: McplParticles) -> Iterator[tuple[str, str, np.ndarray]]:
    yield "energy", "MeV", part.energy
    for k, axis in enumerate("xyz"):
        yield axis, "cm", part.position[:, k]
    for k, axis in enumerate("xyz"):
        yield f"u{axis}", "", part.direction[:, k]
    yield "time", "ms", part.time
    yield "weight", "", part.weight
    yield "pdg_code", "", part.pdg_code
    yield "user_flags", "", part.user_flags


def _bounds(file: McplFile) -> dict[str, tuple[str, float, float]]:
    """Unit, least and greatest value of every column, by name; nothing of an empty file."""
    bounds: dict[str, tuple[str, float, float]] = {}
    for part in file.blocks():
        for name, unit, values in _mcpl_columns(part):
            least, greatest = values.min().item(), values.max().item()
            _, before, after = bounds.get(name, (unit, least, greatest))
            bounds[name] = unit, min(before, least), max(after, greatest)
    return bounds


def _mcpl_summary(file: McplFile, bounds: dict[str, tuple[str, float, float]]) -> dict[str, Any]:
    header = file.header
    return {
        "format": f"MCPL-{header.version}",
        "particles": header.n_particles,
        "bytes": file.data_start + header.n_particles * header.record.itemsize,
        "gzip": file.is_packed,
        "header_bytes": file.data_start,
        "particle_bytes": header.record.itemsize,
        "source": header.source,
        "comments": list(header.comments),
        "blobs": {key: len(data) for key, data in header.blobs},
        "precision": "float64" if header.is_double else "float32",
        "byte_order": "little" if header.is_little_endian else "big",
        "user_flags": header.has_user_flags,
        "polarisation": header.has_polarisation,
        "pdg_code": header.pdg_code or None,
        "weight": header.weight or None,
        "bounds": {name: [least, greatest] for name, (_, least, greatest) in bounds.items()},
    }


def _mcpl_lines(file: McplFile, bounds: dict[str, tuple[str, float, float]]) -> Iterator[str]:
    facts = _mcpl_summary(file, bounds)
    packed = ", compressed by gzip" if file.is_packed else ""
    yield f"{facts['format']} file {file.path}, {facts['particles']} particles, {facts['bytes']} bytes{packed}"
    yield (
        f"head {facts['header_bytes']} bytes, {facts['particle_bytes']} bytes per particle, "
        f"{facts['precision']}, {facts['byte_order']}-endian"
    )
    yield f"source: {_printable(facts['source'])}"
    yield from (f"comment: {_printable(comment)}" for comment in facts["comments"])
    yield from (f"blob: {_printable(key)}, {n} bytes" for key, n in facts["blobs"].items())
    for name, value in (("kind of particle (PDG code)", facts["pdg_code"]), ("weight", facts["weight"])):
        yield f"{name}: {'of each record' if value is None else f'{value:g}, of all'}"
    yield "; ".join(
        f"{name.replace('_', ' ')}: {'yes' if facts[name] else 'no'}" for name in ("user_flags", "polarisation")
    )
    if bounds:
        rows = [(name, f"{low:.9g}", f"{high:.9g}", unit) for name, (unit, low, high) in bounds.items()]
        yield f"\n{table(rows, ('', 'least', 'greatest', 'unit'))}"


def _printable(text: str) -> str:
    """Text without control characters, which would disturb a terminal, and of a length that can be read."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text[:_MAX_COMMENT])
    return shown if len(text) <= _MAX_COMMENT else f"{shown} ... ({len(text)} characters)"


MAX_ROWS = 100


def report_atmo(path: Path, *, as_json: bool, allow_paths: Sequence[str]) -> int:
    """Print what a description holds and what its code blocks give."""
    from aomc_sky.formats.atmo.reader import read_atmo
    from aomc_sky.source.atmospheres.medium import read_medium

    description = read_atmo(path, allow_paths=allow_paths)
    _, medium = read_medium(description)
    if as_json:
        print(json.dumps(_atmo_summary(description, medium), allow_nan=False))
    else:
        print("\n".join(_atmo_lines(description, medium)))
    return 0


def _atmo_summary(d: AtmosphereDescription, medium: MediumReport) -> dict[str, Any]:
    return {
        "format": "atmosphere description",
        "path": d.path,
        "atmosphere_height_m": d.atmosphere_height_m,
        "earth_radius_m": d.earth_radius_m,
        "earth_sun_distance_m": d.earth_sun_distance_m,
        "earth_moon_distance_m": d.earth_moon_distance_m,
        "scattering_orders": d.scattering_orders,
        "wavelength_nm": d.wavelength_nm.tolist(),
        "solar_irradiance": d.solar_irradiance.tolist(),
        "ground_albedo": d.ground_albedo.tolist(),
        "ground_glow": None if d.ground_glow is None else d.ground_glow.tolist(),
        "glow_luminance_cd_m2": d.glow_luminance_cd_m2,
        "scatterers": [_scatterer(part) for part in d.scatterers],
        "absorbers": [_absorber(part) for part in d.absorbers],
        "optical_depth": {name: depth.tolist() for name, depth in medium.optical_depth.items()},
        "phase_norm": {name: norm.tolist() for name, norm in medium.phase_norm.items()},
        "negligible_species": list(medium.dropped),
        "sizes": dict(d.sizes),
        "textures_are_radiances": d.textures_are_radiances,
        "has_eclipsed_double_scattering_textures": d.has_eclipsed_double_scattering_textures,
    }


def _scatterer(part: ScattererDescription) -> dict[str, Any]:
    return {
        "name": part.name,
        "line": part.line,
        "cross_section_1um_m2": part.cross_section_1um_m2,
        "angstrom_exponent": part.angstrom_exponent,
        "single_scattering_albedo": part.single_scattering_albedo.tolist(),
        "phase_function_type": part.phase_function_type.value,
        "needs_interpolation_guides": part.needs_interpolation_guides,
        "number_density": part.number_density.text,
        "phase_function": part.phase_function.text,
    }


def _absorber(part: AbsorberDescription) -> dict[str, Any]:
    return {
        "name": part.name,
        "line": part.line,
        "cross_section_m2": part.cross_section_m2.tolist(),
        "number_density": part.number_density.text,
    }


def _atmo_lines(d: AtmosphereDescription, medium: MediumReport) -> Iterator[str]:
    from aomc_sky.formats.units import AU_M

    yield f"atmosphere description {d.path}, {_counts(d)}"
    yield f"ground at {d.earth_radius_m / 1e3:g} km, top {d.atmosphere_height_m / 1e3:g} km above it"
    moon = "" if d.earth_moon_distance_m is None else f", moon at {d.earth_moon_distance_m / 1e3:g} km"
    yield f"sun at {d.earth_sun_distance_m / AU_M:g} AU{moon}"
    yield f"orders of scattering: {d.scattering_orders}"
    if d.glow_luminance_cd_m2 is not None:
        yield f"glow of the ground: scaled to 1 cd/m2 from {d.glow_luminance_cd_m2:.6g} cd/m2"
    for part in d.scatterers:
        yield (
            f"scatterer {part.name}: {part.cross_section_1um_m2:g} m2 at 1 um, Angstrom exponent "
            f"{part.angstrom_exponent:g}, density {_line_span(part.number_density)}, "
            f"{part.phase_function_type.value} phase function {_line_span(part.phase_function)}, "
            f"{_phase_norm(part.name, medium)}"
        )
    for gas in d.absorbers:
        yield f"absorber {gas.name}: density {_line_span(gas.number_density)}"
    if medium.dropped:
        yield f"negligible, not used in any solution: {', '.join(medium.dropped)}"
    columns = _atmo_columns(d, medium)
    rows = [tuple(f"{values[k]:.6g}" for values in columns.values()) for k in range(len(d.wavelength_nm))]
    yield f"\n{table(rows[:MAX_ROWS], tuple(columns))}"
    if len(rows) > MAX_ROWS:
        yield f"... and {len(rows) - MAX_ROWS} more wavelengths"
    if d.sizes:
        yield "\nnumbers of points and texels:"
        yield from (f"  {key}: {value}" for key, value in d.sizes.items())


def _counts(d: AtmosphereDescription) -> str:
    n_scatterers, n_absorbers, n = len(d.scatterers), len(d.absorbers), len(d.wavelength_nm)
    return (
        f"{n_scatterers} scatterer{'s' * (n_scatterers != 1)}, {n_absorbers} absorber{'s' * (n_absorbers != 1)}, "
        f"{n} wavelength{'s' * (n != 1)}"
    )


def _phase_norm(name: str, medium: MediumReport) -> str:
    norm = medium.phase_norm[name]
    least, greatest = f"{norm.min():.6f}", f"{norm.max():.6f}"
    return f"integral {least}" if least == greatest else f"integral {least} to {greatest}"


def _line_span(code: SourceText) -> str:
    last = code.line + code.text.count("\n")
    return f"in line {code.line}" if last == code.line else f"in lines {code.line} to {last}"


def _atmo_columns(d: AtmosphereDescription, medium: MediumReport) -> dict[str, np.ndarray]:
    """Spectra under their heads; albedos of 1 throughout are left out."""
    columns = {"nm": d.wavelength_nm, "sun W m-2 nm-1": d.solar_irradiance, "albedo": d.ground_albedo}
    if d.ground_glow is not None:
        columns["glow W m-2 sr-1 nm-1"] = d.ground_glow
    for part in d.scatterers:
        if (part.single_scattering_albedo != 1.0).any():
            columns[f"albedo of {part.name}"] = part.single_scattering_albedo
    for gas in d.absorbers:
        columns[f"{gas.name} m2"] = gas.cross_section_m2
    for name, depth in medium.optical_depth.items():
        columns[f"tau of {name}"] = depth
    return columns
