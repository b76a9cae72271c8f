"""A year of skies: a weather file in, the photon counts of every hour out, any photon of any hour on demand."""

from __future__ import annotations

import dataclasses
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import AllocationError, AomcSkyError, ModelLimitWarning, SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.manifest import input_hash, manifest_bytes
from aomc_sky.outputs.photons.files import Progress
from aomc_sky.outputs.shard import MANIFEST, PLAN
from aomc_sky.outputs.year import (
    COUNTS,
    INDEX,
    INDEX_COLUMNS,
    NO_LIGHT,
    YearFolder,
    YearWriter,
    block_ends,
    build_year_manifest,
    counts_dtype,
    index_line,
    read_counts,
    read_year_manifest,
)
from aomc_sky.sampling.allocation import allocate, normalise
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.scene import Scene
from aomc_sky.source.year import HourState, YearPlan, state_text
from aomc_sky.wavebands import Wavebands


@dataclass(frozen=True, kw_only=True, slots=True)
class YearResult:
    """What a finished year reports."""

    manifest: dict[str, Any]  #: what manifest.json holds
    hours_done: int  #: hours with a sky that this call made; less than all where an earlier call was cut short
    seconds: float  #: time that it took [s]
    was_finished: bool  #: the year stood there already, and nothing was done


def run_year(
    plan: YearPlan,
    out: str | Path,
    *,
    weather_file: str | Path | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> YearResult:
    """Write the counts of every hour that has a sky: plan, counts, index, manifest; complete a part of the same year.

    Every row of counts sums exactly to the photons asked for, except that of an hour whose sky the
    model leaves without light: zeros, and ``no-light`` in the index. Name and hash of `weather_file` go to the
    manifest. `progress` is called with hours done and hours in all. ForeignOutputError where the folder holds something
    else and `force` is off. About 5 ms an hour on 45 x 180 patches (bench/year.py).
    """
    folder = YearFolder(Path(out))
    with folder.held(plan, force=force):
        return _run_year(plan, folder, weather_file, progress)


def _run_year(
    plan: YearPlan, folder: YearFolder, weather_file: str | Path | None, progress: Progress | None
) -> YearResult:
    finished = _finished(folder, plan)
    if finished is not None:
        return YearResult(manifest=finished, hours_done=0, seconds=0.0, was_finished=True)
    inputs = {} if weather_file is None else {"weather": input_hash(Path(weather_file))}
    started, hours = time.perf_counter(), 0
    if not folder.has_files:
        folder.require_space_for(plan)
        with folder.writer(plan, INDEX_COLUMNS) as writer:
            hours = _write_blocks(plan, writer, progress)
    seconds = time.perf_counter() - started
    manifest = build_year_manifest(folder, plan, inputs, hours, seconds)
    folder.write(MANIFEST, manifest_bytes(manifest))
    return YearResult(manifest=manifest, hours_done=hours, seconds=seconds, was_finished=False)


def _write_blocks(plan: YearPlan, writer: YearWriter, progress: Progress | None) -> int:
    """Make the blocks that are missing; return the hours with a sky in them."""
    grid, rows, ends = plan.grid, plan.sky_rows, block_ends(plan)
    epsilon, delta = _clearness(plan)
    first = 0 if writer.blocks_done == 0 else ends[writer.blocks_done - 1]
    done = start = writer.hours_done
    for end in ends[writer.blocks_done :]:
        counts = np.zeros((np.count_nonzero((rows >= first) & (rows < end)), plan.n_cells), dtype=counts_dtype(plan))
        lines, k = [], 0
        for row in range(first, end):
            if plan.arrays["state"][row] != HourState.SKY:
                lines.append(index_line(plan, row))
                continue
            note = _fill_hour(plan, row, grid, counts[k])
            photons = int(counts[k].sum(dtype=np.int64))
            clearness = (float(epsilon[row]), float(delta[row]))
            lines.append(index_line(plan, row, sky=(*clearness, done, photons), note=note))
            k, done = k + 1, done + 1
            if progress:
                progress(done, int(rows.size))
        writer.append(lines, counts)
        first = end
    return done - start


def _fill_hour(plan: YearPlan, row: int, grid: PatchGrid, counts: np.ndarray) -> str:
    """Write the counts of one hour and return what its model had to limit."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        try:
            mass = plan.sky(row).patch_mass(grid)
            if plan.with_beam:
                fraction = plan.direct_fraction(row)
                mass = np.concatenate([[fraction], (1 - fraction) * normalise(mass)])
            counts[:] = allocate(mass, plan.iterations, seed=plan.hour_seed(row))
        except (SceneError, AllocationError) as error:
            return f"{NO_LIGHT}: {error}"
    texts = (str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning))
    # the head of such a warning names the sky, which the line's other columns do
    return "; ".join(dict.fromkeys(text.partition(": ")[2] or text for text in texts))


def _clearness(plan: YearPlan) -> tuple[np.ndarray, np.ndarray]:
    """Epsilon and Delta of every row, 0 where there is no sky; before any limits."""
    from aomc_sky.skies.perez.functions import sky_brightness, sky_clearness

    arrays, rows = plan.arrays, plan.sky_rows
    epsilon, delta = np.zeros(plan.n_rows), np.zeros(plan.n_rows)
    sun, dhi = np.deg2rad(arrays["sun_zenith_deg"][rows]), arrays["dhi"][rows]
    epsilon[rows] = sky_clearness(arrays["dni"][rows], dhi, sun)
    constants = {
        "extraterrestrial_normal": arrays["extraterrestrial_normal"][rows],
        "air_mass": plan.options["air_mass"],
    }
    delta[rows] = sky_brightness(dhi, sun, **constants)
    return epsilon, delta


def _finished(folder: YearFolder, plan: YearPlan) -> dict[str, Any] | None:
    """The manifest of a finished year whose files are all there."""
    if folder.size_of(MANIFEST) is None:
        return None
    try:
        manifest = read_year_manifest(folder.path)
    except AomcSkyError:
        manifest = None
    if manifest is not None and manifest["plan_sha256"] == plan.sha256 and _files_are_complete(folder, manifest):
        return manifest
    folder.remove(MANIFEST)  # the folder is unfinished again until the new manifest is written
    return None


def _files_are_complete(folder: YearFolder, manifest: dict[str, Any]) -> bool:
    return all(folder.size_of(name) == entry["bytes"] for name, entry in manifest["files"].items())


def hour_counts(folder: str | Path, row: int) -> np.ndarray:
    """Counts of one hour as they are in a year's folder.

    Parameters
    ----------
    folder : str or Path
        The folder of a finished year.
    row : int
        Row of the weather file. [1-based]

    Returns
    -------
    ndarray, int64, shape (n_cell,)
        The beam first where the year has one, then the patches, zenith-major.

    Raises
    ------
    SceneError
        The row does not exist, or has no sky.
    AomcSkyError
        The folder holds no finished year.
    """
    plan = _stored_plan(folder)
    return _stored_counts(Path(folder), plan, _row_index(plan, row))


def _stored_plan(folder: str | Path) -> YearPlan:
    YearFolder(Path(folder)).require_regular_files()
    return YearPlan.load(Path(folder) / PLAN)


def _row_index(plan: YearPlan, row: int) -> int:
    if not 1 <= row <= plan.n_rows:
        raise SceneError(f"row {row} does not exist; the weather file has rows 1 to {plan.n_rows}")
    return row - 1


def _stored_counts(folder: Path, plan: YearPlan, index: int) -> np.ndarray:
    state = HourState(int(plan.arrays["state"][index]))
    if state is not HourState.SKY:
        raise SceneError(f"row {index + 1} has no sky to sample: {state_text(state)}")
    stored = read_counts(YearFolder(folder), plan)[int(np.searchsorted(plan.sky_rows, index))]
    counts = np.array(stored, dtype=np.int64)
    total = int(counts.sum())
    if total == 0:
        raise SceneError(f"row {index + 1} has no light; its line of {INDEX} says why")
    if total != plan.iterations or counts.min() < 0:
        raise AomcSkyError(f"{folder / COUNTS} is damaged: row {index + 1} holds {total} of {plan.iterations} photons")
    return counts


def hour_source(folder: str | Path, row: int, *, wavelength_nm: float = 550.0, **options: Any) -> PhotonSource:
    """The photon source of one hour of a year, with exactly the counts that the year's folder holds.

    Parameters
    ----------
    folder : str or Path
        The folder of a finished year.
    row : int
        Row of the weather file. [1-based]
    wavelength_nm : float
        What the photons are labelled with; the sky's shape is one for all wavelengths. [nm]
    **options
        `placement`, `order`, `precision` of `Scene.source`.

    Returns
    -------
    PhotonSource
        One band. The same photons on any machine that computes the same sky; counts always as stored.

    Raises
    ------
    SceneError
        The row does not exist, or has no sky.
    AomcSkyError
        The folder holds no finished year.
    UsageError
        Replicates: the counts are those of one run.
    """
    if options.get("replicates", 1) != 1:
        raise UsageError("the counts of an hour are stored as those of one run, without replicates")
    plan = _stored_plan(folder)
    index = _row_index(plan, row)
    counts = _stored_counts(Path(folder), plan, index)
    wavelengths = np.array([wavelength_nm], dtype=np.float64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelLimitWarning)  # they are in the index
        scene = Scene(
            wavebands=Wavebands(wavelength_nm=wavelengths),
            n_photons=np.array([plan.iterations]),
            components=plan.components(index, plan.grid, wavelengths),
        )
        settled = scene.source(plan.hour_seed(index), **options).plan
    cumulative = np.zeros((1, counts.size + 1), dtype=np.int64)
    np.cumsum(counts, out=cumulative[0, 1:])
    cumulative.flags.writeable = False
    return PhotonSource(dataclasses.replace(settled, arrays={**settled.arrays, "cumulative": cumulative}))
