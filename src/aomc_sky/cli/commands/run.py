"""``aomc-sky run``: from amc.inp to a run folder."""

from __future__ import annotations

import argparse
import json
import math
import platform
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.engine.run import JobOptions, JobResult
    from aomc_sky.engine.shards import ShardResult
    from aomc_sky.outputs.shard import Shard
    from aomc_sky.outputs.statistics import BandResult
    from aomc_sky.source.photon_source import PhotonSource
    from aomc_sky.source.scene import Scene

_EPILOG = """\
examples:
  aomc-sky run inputs/clear_day/amc.inp --seed 1 --out out
  aomc-sky run amc.inp --iterations 1e9 --format none        counts and plan only
  aomc-sky run amc.inp --format raw --out - | transport      records of float32 on standard output
  aomc-sky run amc.inp --iterations 1e11 --shard 3/100       one part, on any machine; the last one ends the run
  aomc-sky run amc.inp --iterations 1e11 --engine dask       by the processes of a Dask cluster
  aomc-sky run amc.inp --dry-run                             what would be modelled, and what not
  aomc-sky run amc.inp --dni 850 --dhi 95 --sun-zenith 32.4  light source 0 under a given weather
"""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Read amc.inp and the files next to it, distribute the photons over the sky, emit and write them."
    )
    parser.epilog = _EPILOG
    parser.add_argument("amc_inp", metavar="AMC_INP", help="amc.inp, or the folder that holds it")
    parser.add_argument(
        "--out", metavar="DIR", help="run folder (default: aomc-sky-out beside amc.inp); - with --format raw"
    )
    cli_options.add_shared(parser, "seed")
    cli_options.add_reading_options(parser)
    cli_options.add_moment_options(parser)
    group = cli_options.add_sampling_options(parser)
    cli_options.add_shared(group, "waveband")
    _add_output_options(parser)
    parser.show_first("out seed iterations format waveband compat dni dhi sun-zenith dry-run threads force json quiet")
    parser.set_defaults(handler=run, resumes=True)


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    cli_options.add_shared(group, "format")
    group.add_argument(
        "--shard", metavar="k/K", help="only part k of K, from 1, written in place; the last one ends the run"
    )
    cli_options.add_shared(group, "threads")
    group.add_argument(
        "--engine", choices=("local", "dask"), default="local", help="who makes the photons (default: this process)"
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a Dask scheduler, tcp://host:8786 (default: a cluster of processes here)",
    )
    group.add_argument("--dry-run", action="store_true", help="print what would be modelled; write nothing")
    group.add_argument("--force", action="store_true", help="replace another run in the folder")
    cli_options.add_shared(group, "json quiet")
    group.add_argument("-v", "--verbose", action="store_true", help="print how the files were read")


def run(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    formats = _formats(arguments)
    _check_engine(arguments, formats)
    shard = _shard(arguments, formats)
    scene = cli_options.scene_of(arguments, arguments.amc_inp, wavebands=arguments.waveband)
    if arguments.dry_run:
        print(json.dumps(scene_summary(scene)) if arguments.json else dry_run_text(scene))
        return 0
    from aomc_sky.cli.progress import patience

    with patience("sharing out the photons", enabled=cli_options.speaks(arguments)):
        source = cli_options.source_of(scene, arguments)
    from aomc_sky.engine.run import JobOptions

    options = JobOptions(
        formats=formats,
        threads=arguments.threads or 0,
        force=arguments.force,
        max_memory_bytes=arguments.max_memory,
    )
    if shard is not None:
        _make_shard(arguments, scene, source, options, shard)
        return 0
    result, folder = _carry_out(arguments, scene, source, options)
    _report(arguments, scene, source, result, folder)
    return 0


def _formats(arguments: argparse.Namespace) -> tuple[str, ...]:
    formats = cli_options.formats_of(arguments)
    if arguments.out == "-":
        if formats != ("raw",):
            raise UsageError("--out - needs --format raw, and no other format")
        if arguments.json:
            raise UsageError("--json and --out - both need standard output")
    return formats


def _shard(arguments: argparse.Namespace, formats: tuple[str, ...]) -> Shard | None:
    if arguments.shard is None:
        return None
    from aomc_sky.outputs.shard import parse_shard

    if arguments.out == "-" or formats != ("npy",):
        raise UsageError("--shard writes npy alone; export the finished run to other formats")
    return parse_shard(arguments.shard)


def _check_engine(arguments: argparse.Namespace, formats: tuple[str, ...]) -> None:
    if arguments.engine == "dask":
        if arguments.shard is not None:
            raise UsageError("--engine dask divides the run by itself; leave --shard out")
        if arguments.out == "-" or formats != ("npy",):
            raise UsageError("--engine dask writes npy alone; export the run to other formats")
    elif arguments.scheduler is not None:
        raise UsageError("--scheduler needs --engine dask")


def _carry_out(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, options: JobOptions
) -> tuple[JobResult, Path | None]:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.run import run_job, stream_job

    with progress_bar(enabled=cli_options.speaks(arguments)) as progress:
        if arguments.out == "-":
            return stream_job(source, scene, sys.stdout.buffer, options, progress), None
        folder = _folder(arguments, scene)
        if arguments.engine == "dask":
            from aomc_sky.engine.cluster import run_on_dask

            scheduler = arguments.scheduler
            return run_on_dask(source, scene, folder, options, scheduler=scheduler, progress=progress), folder
        return run_job(source, scene, folder, options, progress), folder


def _folder(arguments: argparse.Namespace, scene: Scene) -> Path:
    of_scene = Path(scene.input_files["amc"]).parent
    if arguments.out is None:
        return of_scene / "aomc-sky-out"
    from aomc_sky.outputs.folder.target_file import check_folder

    check_folder(arguments.out, "--out", scene=of_scene)
    return Path(arguments.out)


def _make_shard(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, options: JobOptions, shard: Shard
) -> None:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.shards import run_shard

    folder = _folder(arguments, scene)
    with progress_bar(enabled=cli_options.speaks(arguments)) as progress:
        result = run_shard(source, scene, folder, options, shard, progress)
    text = partial(shard_text, scene, source, result, folder, verbose=arguments.verbose)
    cli_options.answer(arguments, lambda: shard_json(source, result, folder), text)


def _report(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, result: JobResult, folder: Path | None
) -> None:
    text = partial(run_text, scene, source, result, folder, verbose=arguments.verbose)
    if folder is None:  # standard output belongs to the photons
        if cli_options.speaks(arguments):
            print(text(), file=sys.stderr)
        return
    from aomc_sky.engine.run import run_record

    def values() -> dict[str, Any]:
        record = run_record(result.seconds, result.emitted, result.threads)
        more = {"folder": str(folder), "was_finished": result.was_finished, "run": record}
        return {**(result.manifest or {}), **more}

    cli_options.answer(arguments, values, text)


_HEAD = ("band", "nm", "sky nm", "requested", "launched", "residual", "mean cosine", "(photons)", "Ed/Eo", "(photons)")
_ERROR_HEAD = ("band", "nm", "Ed", "(s.e.)", "Eo", "(s.e.)", "mean cosine", "(s.e.)", "Ed/Eo", "(s.e.)")
_ENDLESS = (
    "note: Ed/Eo is 0 because light at the horizon is launched by solid angle, so that Eo, the mean of 1/mu, has no\n"
    "finite value; the photons' own says only how near the horizon they come. Flux is launched by --weighting projected"
)
MAX_ROWS = 40
MAX_COMPONENTS = 6
"""Columns of components beside the table's own; the brightest are shown."""


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def band_row(band: BandResult) -> tuple[str, ...]:
    """One line of the table."""
    return (
        str(band.waveband),
        f"{band.wavelength_nm:g}",
        "-" if band.sky_wavelength_nm is None else f"{band.sky_wavelength_nm:g}",
        str(band.requested),
        str(band.launched),
        str(band.residual),
        _number(band.mean_cosine_exact, 6),
        _number(band.mean_cosine_photons, 6),
        _number(band.ed_over_eo_exact, 6),
        _number(band.ed_over_eo_photons, 6),
    )


def band_table(bands: Sequence[BandResult]) -> str:
    """The table of all bands; of many, the first ones and what was left out."""
    text = table([band_row(band) for band in bands[:MAX_ROWS]], _HEAD)
    hidden = len(bands) - MAX_ROWS
    text += f"\n... and {hidden} more wavebands (manifest.json has all)" if hidden > 0 else ""
    return f"{text}\n{_ENDLESS}" if any(band.ed_over_eo_exact == 0 for band in bands) else text


def _error_row(band: BandResult) -> tuple[str, ...]:
    pairs = (
        (band.ed_photons, band.ed_standard_error),
        (band.eo_photons, band.eo_standard_error),
        (band.mean_cosine_photons, band.mean_cosine_standard_error),
        (band.ed_over_eo_photons, band.ed_over_eo_standard_error),
    )
    texts = [(_number(value, 8), "-" if error is None else f"{error:.1e}" if error else "0") for value, error in pairs]
    return (str(band.waveband), f"{band.wavelength_nm:g}", *(text for pair in texts for text in pair))


def irradiance_text(bands: Sequence[BandResult]) -> str:
    """Absolute irradiances of the components and what the horizon takes; empty where they are not known."""
    known = [band for band in bands if band.component_irradiance_W_m2_nm is not None]
    if not known:
        return ""
    names = list(known[0].component_irradiance_W_m2_nm or {})
    names = sorted(names, key=lambda name: -max((b.component_irradiance_W_m2_nm or {})[name] for b in known))
    shown = names[:MAX_COMPONENTS]
    is_lost = any(band.horizon_loss for band in known)
    rows = []
    for band in known[:MAX_ROWS]:
        values = band.component_irradiance_W_m2_nm or {}
        numbers = [band.irradiance_W_m2_nm or 0.0, *(values[name] for name in shown)]
        loss = (f"{band.horizon_loss:.4f}",) if is_lost else ()
        rows.append((str(band.waveband), f"{band.wavelength_nm:g}", *(f"{x:.4g}" for x in numbers), *loss))
    below = "; below: share of the lobes' light from below the horizon"
    lines = [
        "irradiance of the horizontal plane, W m-2 nm-1" + (below if is_lost else ""),
        table(rows, ("band", "nm", "Ed", *shown, *(("below",) if is_lost else ()))),
    ]
    if len(known) > MAX_ROWS or len(names) > len(shown):
        lines.append(f"... {len(known)} wavebands, {len(names)} components (manifest.json has all)")
    return "\n".join(lines)


def error_text(bands: Sequence[BandResult], options: Mapping[str, Any]) -> str:
    """Standard errors of a run with replicates, and what they do not tell; empty for any other run."""
    replicates = int(options.get("replicates", 1))
    emitted = [band for band in bands if band.ed_photons is not None]
    if replicates < 2:
        return ""
    if not emitted:
        return "no standard errors: a run that makes no photons has none (--format none)"
    known_to = 100 / math.sqrt(2 * (replicates - 1))
    lines = [
        f"standard errors from {replicates} replicates, with an uncertainty of about {known_to:.0f} %; "
        "Ed and Eo per photon of weight 1",
        table([_error_row(band) for band in emitted[:MAX_ROWS]], _ERROR_HEAD),
    ]
    if len(emitted) > MAX_ROWS:
        lines.append(f"... and {len(emitted) - MAX_ROWS} more wavebands (manifest.json has all)")
    if not all(band.eo_variance_is_finite for band in emitted):
        lines.append("note: the light reaches the horizon: 1/mu has no finite variance, so the errors of Eo are rough")
    if options["allocation"] == "largest-remainder":
        lines.append("note: largest-remainder counts are equal in all replicates: their bias is not in these errors")
    return "\n".join(lines)


def run_text(scene: Scene, source: PhotonSource, result: JobResult, folder: Path | None, *, verbose: bool) -> str:
    """What a run prints when it is done."""
    lines = [*notes_text(scene, source, verbose=verbose), "", band_table(result.bands), ""]
    absolute = irradiance_text(result.bands)
    lines += [absolute, ""] if absolute else []
    errors = error_text(result.bands, source.plan.options)
    lines += [errors, ""] if errors else []
    launched = sum(b.launched for b in result.bands)
    lines.append(f"{launched} photons in {len(result.bands)} wavebands, seed {source.plan.seed}")
    if not result.emitted and not result.was_finished:
        lines.append("counts and plan only; any photon can be made from the plan")
    else:
        lines.append(effort_text(result))
    lines.append(f"plan {source.plan.sha256[:16]}" + ("" if folder is None else f", folder {folder}"))
    return "\n".join(lines)


def notes_text(scene: Scene, source: PhotonSource, *, verbose: bool) -> list[str]:
    """What a scene tells its user and, if asked for, how it was read and how photons are drawn."""
    lines = [f"note: {note}" for note in scene.notes]
    if verbose:
        lines += [f"{role}: {path}" for role, path in scene.input_files.items()]
        lines += [f"{name}: {shown_option(value)}" for name, value in scene.options.items()]
        shown = ("method", "allocation", "placement", "order", "precision", "replicates")
        lines += [f"{name}: {source.plan.options[name]}" for name in shown]
    return lines


def effort_text(result: JobResult | ShardResult) -> str:
    """What had to be done."""
    if result.was_finished:
        return "this run was finished before; nothing was done again (verify compares it, --force makes it again)"
    rate = result.emitted / max(result.seconds, 1e-9) / 1e6
    plural = "" if result.threads == 1 else "s"
    return (
        f"{result.emitted} photons emitted and written in {result.seconds:.2f} s ({rate:.1f} million per second, "
        f"{result.threads} thread{plural}, {platform.machine()})"
    )


def scene_summary(scene: Scene) -> dict[str, Any]:
    """A scene as JSON values."""
    return {
        "wavebands": scene.wavebands.wavelength_nm.tolist(),
        "photons": scene.n_photons.tolist(),
        "components": [{"name": c.name, "law": c.law.name, "cells": c.n_cells} for c in scene.components],
        "footprint": scene.footprint.shape.value,
        "options": dict(scene.options),
        "notes": list(scene.notes),
    }


def shown_option(value: Any) -> str:
    """An option for a person; of a group of values each with its name, what is not set left out."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {shown_option(v)}" for name, v in value.items() if v is not None and v != [])
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    return " ".join(map(shown_option, value)) if isinstance(value, (list, tuple)) else str(value)


def dry_run_text(scene: Scene) -> str:
    """What a run would model, and what it would not."""
    import numpy as np

    n_bands = int(np.count_nonzero(scene.n_photons))
    total = sum(int(n) for n in scene.n_photons)
    rows = np.unique(scene.row_of_band[scene.n_photons > 0]).size
    lines = [f"note: {note}" for note in scene.notes]
    lines.append(f"{total} photons in {n_bands} of {scene.wavebands.n_bands} wavebands")
    for component in scene.components:
        masses = min(rows, component.mass.shape[0])
        lit = int(np.count_nonzero(component.mass.max(axis=0) > 0))
        lines.append(
            f"modelled: {component.name}, law {component.law.name}, {lit} of {component.n_cells} cells with light, "
            f"{masses} set{'s' if masses != 1 else ''} of masses for {n_bands} wavebands"
        )
    if scene.irradiance is not None:
        low, high = (float(extreme(scene.irradiance.of_component.sum(axis=1))) for extreme in (np.min, np.max))
        lines.append(f"absolute: {low:.4g} to {high:.4g} W m-2 nm-1 on the horizontal plane")
    if scene.options.get("sky") == "none":
        lines.append("not modelled: sun and sky (the backgrounds are the only source)")
    if scene.options.get("sky") is None:
        lines.append("not modelled: a diffuse sky (all light is direct)")
    if scene.footprint.shape.value == "point":
        lines.append("not modelled: positions (the footprint is a point)")
    else:
        lines.append(f"modelled: positions over a {scene.footprint.shape.value}")
    if all(c.weight is None for c in scene.components):
        lines.append("not modelled: weights (all are 1)")
    for name, value in scene.options.items():
        if value is not None:
            lines.append(f"option: {name} = {shown_option(value)}")
    return "\n".join(lines)


def shard_text(scene: Scene, source: PhotonSource, result: ShardResult, folder: Path, *, verbose: bool) -> str:
    """What a shard prints when it is done."""
    if result.was_finished:
        return effort_text(result)
    spans = [f"waveband {band + 1}: photons {first} to {end - 1}" for band, first, end in result.ranges]
    lines = [
        *notes_text(scene, source, verbose=verbose),
        f"shard {result.shard}: {result.n_photons} photons, seed {source.plan.seed}",
        *spans[:MAX_ROWS],
        *([f"... and {len(spans) - MAX_ROWS} more wavebands"] if len(spans) > MAX_ROWS else []),
        effort_text(result) if result.emitted else "its photons were made before",
    ]
    if result.missing:
        missing = ", ".join(map(str, result.missing[:20])) + (" ..." if len(result.missing) > 20 else "")
        lines.append(f"shards that are not made yet: {missing}")
    else:
        lines.append("all shards are made: the run is finished")
    return "\n".join([*lines, f"plan {source.plan.sha256[:16]}, folder {folder}"])


def shard_json(source: PhotonSource, result: ShardResult, folder: Path) -> dict[str, Any]:
    """What a shard says to a program: with the manifest where the run is finished."""
    from aomc_sky.engine.run import run_record

    return {
        **(result.manifest or {"plan_sha256": source.plan.sha256, "seed": source.plan.seed}),
        "folder": str(folder),
        "was_finished": result.was_finished,
        "finished": result.manifest is not None,
        "shard": {"index": result.shard.index, "count": result.shard.count, "photons": result.n_photons},
        "missing": [str(shard) for shard in result.missing],
        "run": run_record(result.seconds, result.emitted, result.threads),
    }
