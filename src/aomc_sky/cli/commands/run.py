"""``aomc-sky run``: from amc.inp to a run folder."""

from __future__ import annotations

import argparse
import json
import math
import platform
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import MAX_ROWS, shown, table
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.emission.photon_source import PhotonSource
    from aomc_sky.engine.run import JobResult
    from aomc_sky.outputs.statistics import BandResult
    from aomc_sky.source.scene import Scene

_EPILOG = """\
examples:
  aomc-sky run inputs/clear_day/amc.inp --seed 1 --out out
  aomc-sky run amc.inp --iterations 1e9 --format none   counts and plan only
  aomc-sky run amc.inp --format raw --out - | transport  float32 to a program
  aomc-sky run amc.inp --iterations 1e11 --shard 3/100  one part of the photons
  aomc-sky run sky.csv --azimuth-convention 'clockwise from north'
  aomc-sky run --sun-zenith 40 --dni 850 --dhi 95 --wavelengths 443 --out day
"""

GROUPS = {
    "": "out seed wavelengths",
    **cli_options.READING,
    **cli_options.WHEN,
    **cli_options.DRAWN,
    "what is written and printed": "waveband format shard threads engine scheduler dry_run force json quiet verbose",
}
FIRST = (
    "time latitude longitude wavelengths sky spectrum aerosol iterations out seed sun-zenith dni dhi format dry-run "
    "force json quiet"
)


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Read amc.inp and the files next to it, distribute the photons over the sky, emit and write them."
    )
    parser.epilog = _EPILOG
    parser.add_argument(
        "amc_inp",
        metavar="AMC_INP",
        nargs="?",
        help="amc.inp or its folder, or a measured sky (.csv, .tsv, .txt, .dat), or a radiance field (.nc); none: sun "
        "and sky by the options of weather, or a --sky alone, at --wavelengths",
    )
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=run, resumes=True)


def run(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.engine.run import run_job, stream_job
    from aomc_sky.progress import progress_bar, status_line

    _check(arguments)
    shard = None
    if arguments.shard is not None:
        from aomc_sky.outputs.shard import parse_shard

        shard = parse_shard(arguments.shard)
    if arguments.amc_inp is None:
        scene = cli_options.scene_of_options(arguments)
    else:
        scene = cli_options.scene_of(arguments, arguments.amc_inp, wavebands=arguments.waveband)
    if arguments.dry_run:
        source = cli_options.source_of(scene, arguments)  # refuses what a run would
        text = partial(dry_run_text, scene, verbose=arguments.verbose)
        print(json.dumps(scene_summary(scene)) if arguments.json else "\n".join([text(), *_bias_lines(source)]))
        return 0
    is_shown = cli_options.is_verbose(arguments)
    with status_line("sharing out the photons", enabled=is_shown):
        source = cli_options.source_of(scene, arguments)
    options = cli_options.job_options(arguments)
    folder = None if arguments.out == "-" else _folder(arguments, scene)
    with progress_bar(enabled=is_shown) as progress:
        if folder is None:
            result = stream_job(source, sys.stdout.buffer, options.threads, progress)
        elif shard is not None:
            from aomc_sky.engine.shards import run_shard

            result = run_shard(source, scene, folder, options, shard, progress)
        elif arguments.engine == "dask":
            from aomc_sky.engine.cluster import run_on_dask

            result = run_on_dask(source, scene, folder, options, scheduler=arguments.scheduler, progress=progress)
        else:
            result = run_job(source, scene, folder, options, progress)
    text = partial(run_text, scene, source, result, folder, verbose=arguments.verbose)
    if folder is not None:
        cli_options.answer(arguments, lambda: run_values(source, result, folder), text)
    elif is_shown:
        print(text(), file=sys.stderr)  # standard output belongs to the photons
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that contradict each other."""
    formats = cli_options.formats_of(arguments)
    for name, is_given in (("--shard", arguments.shard is not None), ("--engine dask", arguments.engine == "dask")):
        if is_given and (arguments.out == "-" or formats != ("npy",)):
            raise UsageError(f"{name} writes npy alone", "export the finished run to other formats")
    if arguments.engine == "dask" and arguments.shard is not None:
        raise UsageError("--engine dask divides the run by itself", "leave --shard out")
    if arguments.engine != "dask" and arguments.scheduler is not None:
        raise UsageError("--scheduler needs --engine dask")
    if arguments.out == "-" and formats != ("raw",):
        raise UsageError("--out - needs --format raw, and no other format")
    if arguments.out == "-" and arguments.json:
        raise UsageError("--json and --out - both need standard output")


def _folder(arguments: argparse.Namespace, scene: Scene) -> Path:
    named = scene.input_files.get("amc") or scene.input_files.get("radiance")
    scene_folder = None if named is None else Path(named).parent
    if arguments.out is None:
        return (scene_folder or Path()) / "aomc-sky-out"
    from aomc_sky.outputs.run_folder import check_folder

    check_folder(arguments.out, "--out", scene=scene_folder)
    return Path(arguments.out)


def run_values(source: PhotonSource, result: JobResult, folder: Path) -> dict[str, Any]:
    """A run or a shard as JSON values: the manifest, if there is one, and what was done."""
    values = {
        **(result.manifest or {"plan_sha256": source.plan.sha256, "seed": source.plan.seed}),
        "folder": str(folder),
        "was_finished": result.was_finished,
        "run": run_record(result),
    }
    if result.shard is not None:
        n_photons = sum(end - first for _, first, end in result.ranges)
        values["finished"] = result.manifest is not None
        values["shard"] = {"index": result.shard.index, "count": result.shard.count, "photons": n_photons}
        values["missing"] = [str(shard) for shard in result.missing]
    return values


def run_record(result: JobResult) -> dict[str, Any]:
    """Time, speed and machine of a command: they are printed, and are not in the files."""
    from importlib.metadata import version

    import numpy as np

    return {
        "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "seconds": round(result.seconds, 6),
        "photons_per_second": round(result.emitted / result.seconds) if result.seconds > 0 else None,
        "threads": result.threads,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": version("numba"),
        "machine": platform.machine(),
    }


_ENDLESS = (
    "note: Ed/Eo is 0 because light at the horizon is launched by solid angle, so that Eo, the mean of\n"
    "1/mu, has no finite value; the photons' own says only how near the horizon they come. Flux is launched\n"
    "by --weighting projected"
)
_ROUGH = (
    "note: Ed/Eo of the photons is more than 1 % off, because a few photons\n"
    "near the horizon make its scatter: take the exact value beside it, or more photons"
)
_WEIGHTED = (
    "note: mean cosine and Ed/Eo count each photon once, whatever its weight; for those of the weighted\n"
    "light see the table of --weighting projected"
)
MAX_COMPONENTS = 6
"""Columns for the brightest components, in the order of the scene."""

_Column = tuple[str, Callable[["BandResult"], str]]


def _column(head: str, member: str, form: str) -> _Column:
    """A column with a member of `BandResult`; missing numbers are "-"."""

    def text(band: BandResult) -> str:
        value = getattr(band, member)
        if value is None or math.isnan(value):
            return "-"
        return "0" if form == ".1e" and value == 0 else f"{value:{form}}"

    return head, text


_BAND = (_column("band", "waveband", "d"), _column("nm", "wavelength_nm", "g"))
_COLUMNS = (
    *_BAND,
    _column("sky nm", "sky_wavelength_nm", "g"),
    *(_column(name, name, "d") for name in ("requested", "launched", "residual")),
    _column("mean cosine", "mean_cosine_exact", ".6f"),
    _column("(photons)", "mean_cosine_photons", ".6f"),
    _column("Ed/Eo", "ed_over_eo_exact", ".6f"),
    _column("(photons)", "ed_over_eo_photons", ".6f"),
)
_ERRORS = list(_BAND)
for _head, _name in (("Ed", "ed"), ("Eo", "eo"), ("mean cosine", "mean_cosine"), ("Ed/Eo", "ed_over_eo")):
    _ERRORS += [_column(_head, f"{_name}_photons", ".8f"), _column("(s.e.)", f"{_name}_standard_error", ".1e")]


def _table(bands: Sequence[BandResult], columns: Sequence[_Column]) -> str:
    """A line for each of the first bands."""
    rows = [[cell(band) for _, cell in columns] for band in bands[:MAX_ROWS]]
    text = table(rows, [head for head, _ in columns], n_keys=len(_BAND))
    hidden = len(bands) - MAX_ROWS
    return text + (f"\n... and {hidden} more wavebands (manifest.json has all)" if hidden > 0 else "")


def tables_text(bands: Sequence[BandResult], options: Mapping[str, Any]) -> str:
    """The table of all bands, and absolute irradiances and standard errors if they are known."""
    text = f"\n{_table(bands, _COLUMNS)}\n"
    if options.get("weights"):
        text += f"{_WEIGHTED}\n"
    elif any(band.ed_over_eo_exact == 0 for band in bands):
        text += f"{_ENDLESS}\n"
    if options.get("placement") != "centre" and any(map(_is_rough, bands)):
        text += f"{_ROUGH}\n"
    known = [band for band in bands if band.component_irradiance_W_m2_nm is not None]
    if known:
        text += f"\n{_irradiance_text(known)}\n"
    if int(options.get("replicates", 1)) > 1:
        text += f"\n{_error_text(bands, options)}\n"
    return text


def _is_rough(band: BandResult) -> bool:
    exact, photons = band.ed_over_eo_exact, band.ed_over_eo_photons
    return exact is not None and photons is not None and abs(photons - exact) > 0.01 * exact > 0


def _irradiance_text(bands: Sequence[BandResult]) -> str:
    """Absolute irradiances of the components, and the share of light from below the horizon."""

    def irradiance(name: str, band: BandResult) -> float:
        return (band.component_irradiance_W_m2_nm or {})[name]

    def column(name: str) -> _Column:
        return name, lambda band: f"{irradiance(name, band):.4g}"

    names = list(bands[0].component_irradiance_W_m2_nm or {})
    brightest = sorted(names, key=lambda name: -max(irradiance(name, band) for band in bands))[:MAX_COMPONENTS]
    columns = [*_BAND, ("Ed", lambda band: f"{band.irradiance_W_m2_nm or 0.0:.4g}")]
    columns += [column(name) for name in names if name in brightest]
    head = "irradiance of the horizontal plane, W m-2 nm-1"
    if any(band.horizon_loss for band in bands):
        head += "; below: share of lobes' light from below it"
        columns.append(_column("below", "horizon_loss", ".4f"))
    rest = f"\n... {len(names)} components (manifest.json has all)" if len(names) > MAX_COMPONENTS else ""
    return f"{head}\n{_table(bands, columns)}{rest}"


def _error_text(bands: Sequence[BandResult], options: Mapping[str, Any]) -> str:
    """Standard errors of a run with replicates, and their limits."""
    emitted = [band for band in bands if band.ed_photons is not None]
    if not emitted:
        return "no standard errors: a run that makes no photons has none (--format none)"
    known_to = 100 / math.sqrt(2 * (int(options["replicates"]) - 1))
    lines = [
        f"standard errors from {options['replicates']} replicates, known to about {known_to:.0f} %; "
        "Ed and Eo per photon of weight 1",
        _table(emitted, _ERRORS),
    ]
    if not all(band.eo_variance_is_finite for band in emitted):
        lines.append("note: the light reaches the horizon: 1/mu has no finite variance, so the errors of Eo are rough")
    if options["allocation"] == "largest-remainder":
        lines.append("note: largest-remainder counts are equal in all replicates: their bias is not in these errors")
    return "\n".join(lines)


def run_text(scene: Scene, source: PhotonSource, result: JobResult, folder: Path | None, *, verbose: bool) -> str:
    """The text that a run or a shard prints when it is done."""
    from aomc_sky.formats.quote import shown_notes
    from aomc_sky.outputs.manifest import RAW_NUMBERS
    from aomc_sky.outputs.photon_formats import columns_of

    notes, n_hidden = (scene.notes, 0) if verbose else shown_notes(scene.notes)
    lines = [f"note: {note}" for note in notes]
    remarks, more = _remarks(scene, n_hidden, verbose=verbose)
    lines += _sun_lines(scene) + more
    if verbose:
        lines += [f"{name}: {shown(value)}" for name, value in {**scene.input_files, **scene.options}.items()]
        drawn = ("method", "allocation", "placement", "order", "precision", "replicates")
        lines += [f"{name}: {source.plan.options[name]}" for name in drawn]
    if result.shard is not None:
        lines += _shard_lines(source, result)
    else:
        launched = sum(band.launched for band in result.bands)
        lines.append(tables_text(result.bands, source.plan.options))
        lines += _bias_lines(source)
        lines += [*remarks, *[""][: len(remarks)]]  # after the table, for newcomers do not know the AOMC program
        lines.append(f"{launched} photons in {len(result.bands)} wavebands, seed {source.plan.seed}")
    if result.was_finished:
        lines.append(
            "this run was finished before, by the sizes of its files and its manifest; nothing was done again (verify "
            "compares every photon, --force makes it again)"
        )
    elif result.emitted:
        rate = result.emitted / max(result.seconds, 1e-9) / 1e6
        plural = "" if result.threads == 1 else "s"
        lines.append(
            f"{result.emitted} photons emitted and written in {result.seconds:.2f} s ({rate:.1f} million per second, "
            f"{result.threads} thread{plural}, {platform.machine()})"
        )
    else:
        lines.append("no photons were made; any photon can be made from the plan")
    if folder is None or any(name.endswith(".raw") for name in (result.manifest or {}).get("files", ())):
        lines.append(f"a raw record: {', '.join(columns_of(source))} ({RAW_NUMBERS})")
    return "\n".join([*lines, f"plan {source.plan.sha256[:16]}" + ("" if folder is None else f", folder {folder}")])


def _sun_lines(scene: Scene) -> list[str]:
    """Where the sun stands at a time and place, or at an hour of a weather file."""
    sun = scene.options.get("sun")
    if not sun or not scene.options.get("weather"):
        return []
    zenith, azimuth = sun["zenith_deg"], sun["azimuth_deg"]
    compass = (90.0 - azimuth) % 360.0
    return [f"sun: {zenith:.2f} degrees from the zenith, azimuth {azimuth:.2f} (compass {compass:.2f}); {sun['from']}"]


def _remarks(scene: Scene, n_hidden: int, *, verbose: bool) -> tuple[list[str], list[str]]:
    """Notes on how a sky file was read, and a line on notes that are not shown."""
    from aomc_sky.source.read.table import has_remark, remarks_of

    if verbose:
        return [f"note: {remark}" for remark in remarks_of(scene)], []
    n_hidden += has_remark(scene)
    return [], [f"{n_hidden} more note{'s' * (n_hidden > 1)} with -v"] if n_hidden else []


def _bias_lines(source: PhotonSource) -> list[str]:
    """What the weights of a bias cost, and components that hardly have a photon."""
    if not source.has_bias:
        return []
    import numpy as np

    bands = [band for band in range(source.n_bands) if source.n_photons(band)]
    share = min((source.effective_photons(band) / source.n_photons(band) for band in bands), default=1.0)
    largest = max((float(source.weights(band)[source.launch(band) > 0].max()) for band in bands), default=1.0)
    lines = [
        f"photons are shared out otherwise than light: for all light they count as {share:.0%} of their number; the "
        f"largest weight is {largest:.4g}"
    ]
    for band in bands:
        expected = np.add.reduceat(source.expected(band), source.plan.component_start[:-1])
        few = [name for name, n in zip(source.plan.component_names, expected.tolist(), strict=True) if 0 < n < 1]
        if few:
            lines.append(f"note: waveband {band + 1} expects less than one photon of {' and '.join(few)}")
    return lines


def _shard_lines(source: PhotonSource, result: JobResult) -> list[str]:
    n_photons = sum(end - first for _, first, end in result.ranges)
    spans = [f"waveband {band + 1}: photons {first} to {end - 1}" for band, first, end in result.ranges]
    missing = ", ".join(map(str, result.missing[:20])) + (" ..." if len(result.missing) > 20 else "")
    return [
        f"shard {result.shard}: {n_photons} photons, seed {source.plan.seed}",
        *spans[:MAX_ROWS],
        *([f"... and {len(spans) - MAX_ROWS} more wavebands"] if len(spans) > MAX_ROWS else []),
        f"shards that are not made yet: {missing}" if missing else "all shards are made: the run is finished",
    ]


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


def dry_run_text(scene: Scene, *, verbose: bool) -> str:
    """The text of --dry-run: what a run would model, and what it would not."""
    import numpy as np

    n_bands = int(np.count_nonzero(scene.n_photons))
    total = sum(int(n) for n in scene.n_photons)
    rows = np.unique(scene.row_of_band[scene.n_photons > 0]).size
    remarks, more = _remarks(scene, 0, verbose=verbose)
    lines = [*(f"note: {note}" for note in scene.notes), *remarks, *more]
    lines.append(f"{total} photons in {n_bands} of {scene.wavebands.n_bands} wavebands")
    for component in scene.components:
        masses = min(rows, component.mass.shape[0])
        lit = int(np.count_nonzero(component.mass.max(axis=0) > 0))
        lines.append(
            f"modelled: {component.name}, law {component.law.name}, {lit} of {component.n_cells} cells with light, "
            f"{masses} set{'s' if masses != 1 else ''} of masses for {n_bands} wavebands"
        )
    if polarised := [component.name for component in scene.components if component.stokes is not None]:
        lines.append(f"modelled: linear polarisation of {' and '.join(polarised)}")
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
    if scene.bias:
        lines.append(f"modelled: photons shared out otherwise than light: {shown(dict(scene.bias))}")
    elif all(c.weight is None for c in scene.components):
        lines.append("not modelled: weights (all are 1)")
    for name, value in scene.options.items():
        if value is not None:
            lines.append(f"option: {name} = {shown(value)}")
    return "\n".join(lines)
