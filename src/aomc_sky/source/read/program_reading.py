"""How the AOMC program would read a sky file, in the numbers of the run's table: mean cosine and Ed/Eo."""

from __future__ import annotations

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import sin_cos_deg
from aomc_sky.formats.skydist.table import SkyTable
from aomc_sky.skies.aomc_weight import aomc_weight
from aomc_sky.skies.tabulated import TabulatedSky, Weighting
from aomc_sky.source.moments import Moments, cell_moments, mean_moments
from aomc_sky.wavebands import Wavebands, midpoint_wavelength_index

_HORIZON = 90
_EXACT_IN_FLOAT32 = 1 << 24


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
    read = (
        f"skydist.inp read with {sky.weighting.value} values {'at whole degrees' if is_on_degrees else 'in equal bins'}"
    )
    program = "the AOMC program reads radiances at whole degrees"
    lit = np.argwhere(table.radiance[:, _HORIZON:] > 0)
    if lit.size:
        index = int(lit[:, 1].max()) + _HORIZON + 1
        return f"{read}; {program} and can make nothing of this file, whose zenith indices go to {index}"
    taken = midpoint_wavelength_index(bands.wavelength_nm, table.wavelength_nm)
    pairs, band_of_pair = np.unique(np.stack([rows, taken]), axis=1, return_index=True)
    ours = _moments_of_rows(component, pairs[0])
    theirs = {int(row): _launch(table.radiance[row], iterations) for row in np.unique(taken)}
    cases = [
        (int(band), ours[int(row)], *theirs[int(other)]) for band, row, other in zip(band_of_pair, *pairs, strict=True)
    ]
    return f"{read}; {program} {_difference(cases, bands.n_bands, iterations)}: {_advice(table, sky, is_on_degrees)}"


def _moments_of_rows(component: Component, rows: np.ndarray) -> dict[int, Moments]:
    """Moments of each row of the component; the cells of a ring share theirs."""
    grid = component.grid
    assert grid is not None
    mean_mu, inverse_mu = (values[:: grid.n_azimuth] for values in cell_moments((component,)))
    found = {}
    for row in np.unique(rows):
        mass = component.mass[row]
        ring = (mass / (mass.max() or 1.0)).reshape(grid.n_zenith, -1).sum(axis=1)  # sums of huge values stay finite
        found[int(row)] = mean_moments(ring, mean_mu, inverse_mu)
    return found


def _launch(radiance: np.ndarray, iterations: int) -> tuple[Moments, int]:
    """Moments of what the program launches from a set of the table, and its photons.

    Every patch is rounded in 32 bits, as there; the running total, which drifts beyond 2^24, is left out.
    """
    weight = aomc_weight(radiance[:_HORIZON])
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.cumsum(weight.ravel("F"))[-1]  # one after the other, as the program adds
    mu = sin_cos_deg(np.arange(1.0, len(weight) + 1))[1]
    photons = np.zeros(len(weight))
    if np.isfinite(total) and total > 0:
        photons = np.floor((weight / total * np.float32(iterations)).astype(np.float64) + 0.5).sum(axis=1)
    lit = photons > 0
    return mean_moments(photons[lit], mu[lit], 1.0 / mu[lit]), int(photons.sum())


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


def _advice(table: SkyTable, sky: TabulatedSky, is_on_degrees: bool) -> str:
    launches = "--compat aomc launches as it does"
    if sky.weighting is Weighting.AOMC and is_on_degrees:
        return launches
    if np.any(table.line[:, _HORIZON - 1 :]) or np.any(table.line[:, :, 361:]):
        return launches  # --bins degrees refuses such indices
    return f"--bins degrees --weighting aomc reads so too, {launches}"
