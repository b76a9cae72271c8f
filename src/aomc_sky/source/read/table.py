"""A sky file as the components of a scene: bins, weighting, wavelengths, and notes."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import sin_cos_deg
from aomc_sky.emission.irradiance import Moments, cell_moments, mean_moments
from aomc_sky.errors import InputFileError, InputWarning, Span, UsageError
from aomc_sky.formats.aomc.amc import AmcConfig
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values
from aomc_sky.formats.text_file import lines_at
from aomc_sky.grid import PatchGrid
from aomc_sky.plan.options import Order, Placement, SamplingOptions
from aomc_sky.plan.sampling.allocation import AllocationMethod
from aomc_sky.skies.tabulated import TabulatedSky, Weighting, aomc_weight
from aomc_sky.source.scene import SceneDraft
from aomc_sky.wavebands import Wavebands, midpoint_wavelength_index

AOMC_TABLE_PRESET = SamplingOptions(allocation=AllocationMethod.AOMC, placement=Placement.CENTRE, order=Order.PATCH)
_HORIZON = 90  # degrees: the last zenith index that the AOMC program can use
_EXACT_IN_FLOAT32 = 1 << 24
_MOST_ENTRIES = 20
_BEYOND = "as whole degrees the zenith index must not go beyond {}"
_DEGREES_ADVICE = "without --bins degrees indices are numbers of equal bins"


@dataclass(frozen=True, kw_only=True, slots=True)
class TableOptions:
    """How to read skydist.inp; by default as the file declares."""

    bins: str | None = None
    weighting: str | None = None
    compat: str | None = None
    azimuth_bins: str = "n+1"


def table_draft(config: AmcConfig, bands: Wavebands, table: SkyTable, options: TableOptions) -> SceneDraft:
    """A scene lit by a sky file."""
    sky, chosen = tabulated_sky(table, options)
    row_of_band = sky.table_index(bands.wavelength_nm)
    used, rows = np.unique(row_of_band, return_inverse=True)
    components = sky.lower_rows(used)
    notes = []
    if not options.compat:
        reading = reading_note(
            table,
            sky,
            components[0],
            bands=bands,
            rows=rows,
            iterations=config.iterations,
            is_on_degrees=chosen["bins"] == Bins.DEGREES.value,
        )
        notes = [reading, *_notes(table, sky)]
    sky.warn_of_distance(bands.wavelength_nm, row_of_band, table.path)
    return SceneDraft(
        components=components,
        n_photons=np.full(bands.n_bands, config.iterations, dtype=np.int64),
        row_of_band=rows,
        sky_wavelength_nm=table.wavelength_nm[row_of_band],
        notes=tuple(notes),
        options={"sky": "table", **chosen},
        preset=AOMC_TABLE_PRESET if options.compat else SamplingOptions(),
    )


def tabulated_sky(table: SkyTable, options: TableOptions) -> tuple[TabulatedSky, dict[str, str]]:
    """A sky file as a model, and how it was read: bins, weighting, azimuth_bins."""
    if options.compat:
        return _compat_sky(table), {"bins": "degrees", "weighting": "aomc", "azimuth_bins": "n+1"}
    bins = Bins(options.bins) if options.bins else table.declared_bins or Bins.EQUAL
    declared = {Values.RADIANCE: "projected", Values.MASS: "listed", None: "listed"}[table.declared_values]
    weighting = Weighting(options.weighting or declared)
    grid, values = _grid_and_values(table, bins, options.azimuth_bins)
    if weighting is Weighting.AOMC and bins is not Bins.DEGREES:
        raise UsageError("weighting 'aomc' is the program's weight of whole degrees; write --bins degrees with it")
    if weighting is Weighting.AOMC:
        _refuse_infinite_float32(table)
    sky = TabulatedSky(wavelength_nm=table.wavelength_nm, values=values, grid=grid, weighting=weighting)
    return sky, {"bins": bins.value, "weighting": weighting.value, "azimuth_bins": options.azimuth_bins}


def _compat_sky(table: SkyTable) -> TabulatedSky:
    """The program's reading: lattice points, its weights, midpoints in file order."""
    n_table, n_zenith, n_columns = table.radiance.shape
    beyond = np.add(np.argwhere(table.radiance[:, 90:, :] > 0), (0, 90, 0))
    if beyond.size:
        _raise_once(table, beyond, _BEYOND.format(90), "the program's zenith indices are degrees; correct the index")
    _refuse_infinite_float32(table)
    return TabulatedSky(
        wavelength_nm=table.wavelength_nm,
        values=table.radiance.reshape(n_table, -1),
        grid=PatchGrid.lattice(n_zenith, n_columns),
        weighting=Weighting.AOMC,
        midpoint_rule=True,
    )


def _refuse_infinite_float32(table: SkyTable) -> None:
    too_large = np.argwhere(table.radiance > np.finfo(np.float32).max)
    if too_large.size:
        message = "the value is infinite in the program's 32-bit floats, so it launches no photon"
        _raise_at(table, too_large, "E302", message, "divide all values of the file by one number")


def _grid_and_values(table: SkyTable, bins: Bins, azimuth_bins: str) -> tuple[PatchGrid, np.ndarray]:
    n_table, n_zenith, n_columns = table.radiance.shape
    if bins is Bins.DEGREES:
        if azimuth_bins != "n+1":
            raise UsageError("azimuth_bins 'n' counts equal bins; it contradicts bins 'degrees'")
        return PatchGrid.whole_degrees(), _degree_values(table)
    if azimuth_bins == "n":
        if n_columns < 2:
            raise UsageError("azimuth_bins 'n' needs sky_azimuth of at least 1 in the header")
        stray = np.argwhere(table.radiance[:, :, :1] > 0)
        if stray.size:
            message = "azimuth index 0 has no bin when indices run from 1 (--azimuth-bins n)"
            _raise_at(table, stray, "E301", message, "write --azimuth-bins n+1, or number from 1")
        grid = PatchGrid.regular(n_zenith, n_columns - 1, azimuth_first_index=1)
        return grid, np.ascontiguousarray(table.radiance[:, :, 1:]).reshape(n_table, -1)
    return PatchGrid.regular(n_zenith, n_columns), table.radiance.reshape(n_table, -1)


def _degree_values(table: SkyTable) -> np.ndarray:
    """Values on the cells around whole degrees; azimuth 360 is 0."""
    n_table, n_zenith, n_columns = table.radiance.shape
    given = table.line > 0
    outside = np.add(np.argwhere(given[:, 89:, :]), (0, 89, 0))
    if outside.size:
        _raise_once(table, outside, _BEYOND.format(89), _DEGREES_ADVICE)
    far = np.add(np.argwhere(given[:, :, 361:]), (0, 0, 361))
    if far.size:
        _raise_once(table, far, "whole degrees of azimuth run from 0 to 360", _DEGREES_ADVICE)
    values = np.zeros((n_table, 89, 360))
    rings, columns = min(n_zenith, 89), min(n_columns, 360)
    values[:, :rings, :columns] = table.radiance[:, :rings, :columns]
    if n_columns > 360:
        seam, first = table.radiance[:, :rings, 360], table.radiance[:, :rings, 0]
        both = given[:, :rings, 360] & given[:, :rings, 0]
        differing = np.argwhere((both & (seam != first))[:, :, None])
        if differing.size:
            message = "azimuth 0 and 360 are one direction, but their values differ"
            advice = "give the direction once, or the same value twice"
            _raise_at(table, np.add(differing, (0, 0, 360)), "E309", message, advice)
        values[:, :rings, 0] = np.where(given[:, :rings, 360], seam, first)
    return values.reshape(n_table, -1)


def _raise_once(table: SkyTable, entries: np.ndarray, message: str, advice: str) -> None:
    """Raise E307 for entries (n, 3) that one reading makes wrong: the first line, and how many more."""
    first = np.argmin(table.line[tuple(entries.T)])
    n_more = len(entries) - 1
    more = f" (and {n_more} more line{'s' if n_more > 1 else ''} like this)" if n_more else ""
    _raise_at(table, entries[first : first + 1], "E307", message + more, advice)


def _raise_at(table: SkyTable, entries: np.ndarray, code: str, message: str, advice: str) -> None:
    """Raise for the first 20 entries (n, 3) in the order of the indices, sorted by their lines."""
    indices = sorted(map(tuple, entries[:_MOST_ENTRIES].tolist()), key=lambda index: table.line[index])
    line_of = {index: int(table.line[index]) for index in indices}
    texts = lines_at(table.path, line_of.values())
    problems = []
    for (_, zenith, azimuth), line in line_of.items():
        text, field = texts.get(line, ""), f"zenith index {zenith + 1}, azimuth index {azimuth}"
        span = Span(line, 1, text, len(text.rstrip()))
        problems.append(span.problem(table.path, code, message, field=field, advice=advice))
    raise InputFileError(problems)


def _notes(table: SkyTable, sky: TabulatedSky) -> list[str]:
    notes = []
    if table.wavelength_nm.size > 1 and np.any(np.diff(table.wavelength_nm) < 0):
        notes.append(
            "the wavelengths of skydist.inp are not in ascending order: bands take the nearest one; the AOMC "
            "program compares with midpoints in file order and may take another"
        )
    offers = sky.grid.azimuth_first_index == 0 and sky.weighting is not Weighting.AOMC
    if offers and table.radiance.shape[2] > 1 and not np.any(table.line[:, :, 0]) and np.any(table.line):
        warnings.warn(
            f"{table.path}: warning[E311]: azimuth index 0 is empty at every wavelength; if indices run from 1 to "
            f"{table.radiance.shape[2] - 1}, write --azimuth-bins n",
            InputWarning,
            stacklevel=5,
        )
    return notes


READING = "skydist.inp read with"
"""How the note of `reading_note` begins, which `run` prints after its table."""

# how the AOMC program would read the file, in the numbers of the run's table: mean cosine and Ed/Eo


def reading_note(
    table: SkyTable,
    sky: TabulatedSky,
    component: Component,
    *,
    bands: Wavebands,
    rows: np.ndarray,
    iterations: int,
    is_on_degrees: bool,
) -> str:
    """How the file was read, and what the program launches instead in the waveband that differs most.

    `component` holds the sky as it was read, `rows` its row for each waveband.
    """
    read = f"{READING} {sky.weighting.value} values {'at whole degrees' if is_on_degrees else 'in equal bins'}"
    program = "the AOMC program reads radiances at whole degrees"
    lit = np.argwhere(table.radiance[:, _HORIZON:] > 0)
    if lit.size:
        index = int(lit[:, 1].max()) + _HORIZON + 1
        return f"{read}; {program} and cannot use this file, whose zenith indices go to {index}"
    taken = midpoint_wavelength_index(bands.wavelength_nm, table.wavelength_nm)
    pairs, band_of_pair = np.unique(np.stack([rows, taken]), axis=1, return_index=True)
    ours = _moments_of_rows(component, pairs[0])
    theirs = _launches(table, set(taken.tolist()), iterations)
    cases = [
        (int(band), ours[int(row)], *theirs[int(other)]) for band, row, other in zip(band_of_pair, *pairs, strict=True)
    ]
    return (
        f"{read}; {program} {_difference(cases, bands.n_bands, iterations)}: {_same_reading(table, sky, is_on_degrees)}"
    )


def _moments_of_rows(component: Component, rows: np.ndarray) -> dict[int, Moments]:
    """Moments of each row of the component; the cells of a ring share theirs."""
    grid = component.grid
    assert grid is not None
    n_azimuth, of_cells = grid.n_azimuth, cell_moments((component,))
    mean_mu, inverse_mu = (values[::n_azimuth] for values in of_cells)
    found = {}
    for row in sorted(set(rows.tolist())):
        mass = component.mass[row]
        ring = (mass / (mass.max() or 1.0)).reshape(-1, n_azimuth).sum(axis=1)  # sums of huge values stay finite
        found[row] = mean_moments(ring, mean_mu, inverse_mu)
    return found


def _launches(table: SkyTable, rows: set[int], iterations: int) -> dict[int, tuple[Moments, int]]:
    """Moments of what the program launches from sets of the table, and its photons.

    Every patch is rounded in 32 bits, as there; the running total, which drifts beyond 2^24, is left out.
    """
    mu = sin_cos_deg(np.arange(1.0, min(table.radiance.shape[1], _HORIZON) + 1))[1]
    found = {}
    for row in rows:
        weight = aomc_weight(table.radiance[row, :_HORIZON])
        with np.errstate(over="ignore", invalid="ignore"):
            total = np.cumsum(weight.ravel("F"))[-1]  # one after the other, as the program adds
        photons = np.zeros(mu.size)
        if np.isfinite(total) and total > 0:
            photons = np.floor((weight / total * np.float32(iterations)).astype(np.float64) + 0.5).sum(axis=1)
        lit = photons > 0
        found[row] = mean_moments(photons[lit], mu[lit], 1.0 / mu[lit]), int(photons.sum())
    return found


def _difference(cases: list[tuple[int, Moments, Moments, int]], n_bands: int, iterations: int) -> str:
    """The waveband whose mean cosine changes most; one that launches nothing changes more than any."""

    def change(case: tuple[int, Moments, Moments, int]) -> float:
        _, ours, theirs, photons = case
        return np.inf if photons == 0 else float(np.nan_to_num(abs(theirs.mean_mu - ours.mean_mu)))

    band, ours, theirs, photons = max(cases, key=change)
    of_band = f" of waveband {band + 1}" if n_bands > 1 else ""
    if photons == 0:
        return f"and launches no photon{of_band}"
    counted = f" {photons} of {iterations}" if photons != iterations and iterations < _EXACT_IN_FLOAT32 else ""
    now = f"{ours.mean_mu:.4f}", f"{ours.planar_over_scalar:.4f}"
    then = f"{theirs.mean_mu:.4f}", f"{theirs.planar_over_scalar:.4f}"
    launches = f"and launches{counted or ' the'} photons{of_band}"
    if now == then:
        return f"{launches} at the same mean cosine, {now[0]}, and Ed/Eo, {now[1]}"
    return f"{launches} at mean cosine {then[0]} instead of {now[0]}, Ed/Eo {then[1]} instead of {now[1]}"


def _same_reading(table: SkyTable, sky: TabulatedSky, is_on_degrees: bool) -> str:
    launches = "--compat aomc launches as the program does"
    if sky.weighting is Weighting.AOMC and is_on_degrees:
        return launches
    if np.any(table.line[:, _HORIZON - 1 :]) or np.any(table.line[:, :, 361:]):
        return launches  # --bins degrees refuses such indices
    return f"--bins degrees --weighting aomc reads it in the same way, {launches}"
