"""The texts that ``run`` prints: the table of a run, and what a dry run would model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.cli.table import table

if TYPE_CHECKING:
    from aomc_sky.engine.run import JobResult
    from aomc_sky.outputs.blocks.statistics import BandResult
    from aomc_sky.source.photon_source import PhotonSource
    from aomc_sky.source.scene import Scene

_HEAD = ("band", "nm", "sky nm", "requested", "launched", "residual", "mean cosine", "(photons)", "Ed/Eo", "(photons)")
_ERROR_HEAD = ("band", "nm", "Ed", "(s.e.)", "Eo", "(s.e.)", "mean cosine", "(s.e.)", "Ed/Eo", "(s.e.)")
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
    text = table([band_row(band) for band in bands[:MAX_ROWS]], _HEAD, n_keys=2)
    hidden = len(bands) - MAX_ROWS
    return text if hidden <= 0 else f"{text}\n... and {hidden} more wavebands (manifest.json has all)"


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
    """Absolute irradiances of the components and what the horizon takes; empty where they are not known.

    Parameters
    ----------
    bands : sequence of BandResult
        The bands of the run.
    """
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
        table(rows, ("band", "nm", "Ed", *shown, *(("below",) if is_lost else ())), n_keys=2),
    ]
    if len(known) > MAX_ROWS or len(names) > len(shown):
        lines.append(f"... {len(known)} wavebands, {len(names)} components (manifest.json has all)")
    return "\n".join(lines)


def error_text(bands: Sequence[BandResult], options: Mapping[str, Any]) -> str:
    """Standard errors of a run with replicates, and what they do not tell; empty for any other run.

    Parameters
    ----------
    bands : sequence of BandResult
        The bands of the run.
    options : mapping
        Its sampling options, `replicates` and `allocation` among them.
    """
    replicates = int(options.get("replicates", 1))
    emitted = [band for band in bands if band.ed_photons is not None]
    if replicates < 2:
        return ""
    if not emitted:
        return "no standard errors: a run that makes no photons has none (--format none)"
    known_to = 100 / math.sqrt(2 * (replicates - 1))
    lines = [
        f"standard errors from {replicates} replicates, themselves known to about {known_to:.0f} %; "
        "Ed and Eo per photon of weight 1",
        table([_error_row(band) for band in emitted[:MAX_ROWS]], _ERROR_HEAD, n_keys=2),
    ]
    if len(emitted) > MAX_ROWS:
        lines.append(f"... and {len(emitted) - MAX_ROWS} more wavebands (manifest.json has all)")
    if not all(band.eo_variance_is_finite for band in emitted):
        lines.append("note: light down to the horizon: 1/mu has no finite variance, the errors of Eo are rough")
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
    content = result.manifest and result.manifest["content"]
    if folder is not None and content is None and not result.was_finished:
        lines.append("counts and plan only; any photon can be made from the plan")
    else:
        lines.append(effort_text(result.emitted, result.seconds, what="run" if result.was_finished else ""))
    root = f", content {content['root'][:16]}" if content else ""
    lines.append(f"plan {source.plan.sha256[:16]}{root}" + ("" if folder is None else f", folder {folder}"))
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


def effort_text(emitted: int, seconds: float, *, what: str) -> str:
    """What had to be done; `what` names a run or shard that was finished before."""
    if what:
        return f"this {what} was finished before and is whole; nothing was done again (--force makes it anew)"
    if not emitted:
        return f"all photons were there and agree with their hashes; read in {seconds:.2f} s"
    rate = emitted / max(seconds, 1e-9) / 1e6
    return f"{emitted} photons emitted and written in {seconds:.2f} s ({rate:.1f} million per second)"


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
    wanted = int(np.count_nonzero(scene.n_photons))
    total = sum(int(n) for n in scene.n_photons)
    rows = np.unique(scene.row_of_band[scene.n_photons > 0]).size
    lines = [f"note: {note}" for note in scene.notes]
    lines.append(f"{total} photons in {wanted} of {scene.wavebands.n_bands} wavebands")
    for component in scene.components:
        masses = min(rows, component.mass.shape[0])
        lit = int(np.count_nonzero(component.mass.max(axis=0) > 0))
        lines.append(
            f"modelled: {component.name}, law {component.law.name}, {lit} of {component.n_cells} cells with light, "
            f"{masses} set{'s' if masses != 1 else ''} of masses for {wanted} wavebands"
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
