"""Settle a run with the Sobol method: integer masses of each component, keys, and the counts its photons make."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aomc_sky.errors import SceneError
from aomc_sky.sampling.mass import fixed_point_cumulative
from aomc_sky.source.sobol_table import SobolLane, lane_mass, lane_photons
from aomc_sky.source.start_up import use_kernels
from aomc_sky.source.stream_keys import sobol_keys

if TYPE_CHECKING:
    from aomc_sky.component import Component

MAX_SOBOL = 2**32
"""Photons of a lane: the index of a Sobol point has 32 bits."""


def settle_sobol(
    components: tuple[Component, ...], rows: np.ndarray, seed: int, arrays: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the arrays of a plan that the Sobol method adds or replaces.

    Parameters
    ----------
    components : tuple of Component
        What shines.
    rows : ndarray, int
        Rows of the components that the plan uses.
    seed : int
        Seed of the run.
    arrays : dict of ndarray
        The plan's arrays under systematic allocation, whose counts give each component its photons.

    Returns
    -------
    dict of ndarray
        `sobol_mass` uint64 (n_row, n_cell), masses in units of 2^-62, each component on its own;
        `sobol_keys` uint64 (2,), of the scrambling and of the places; `cumulative` with the counts of the
        cells that the photons really hit.

    Raises
    ------
    SceneError
        A waveband, or a replicate of one, wants more than 2^32 photons.

    Cost
    ----
    The counts come from one pass over the photons without their directions: docs/methods.md has its speed.
    """
    launched = arrays["cumulative"][:, -1]
    if launched.max(initial=0) > MAX_SOBOL:
        lane = int(launched.argmax())
        raise SceneError(
            f"waveband {lane % arrays['wavelength_nm'].size + 1} wants {launched[lane]} photons of one Sobol sequence, "
            f"which has at most 2^32 = {MAX_SOBOL}; write --method stratified, fewer --iterations or more --replicates"
        )
    masses = [np.concatenate([_units(c, int(row)) for c in components]) for row in rows]
    added = {"sobol_mass": np.stack(masses), "sobol_keys": sobol_keys(seed)}
    cumulative = np.zeros_like(arrays["cumulative"])
    for lane in np.flatnonzero(launched).tolist():
        cumulative[lane, 1:] = np.cumsum(_lane_counts({**arrays, **added}, lane))
    return {**added, "cumulative": cumulative}


def _units(component: Component, row: int) -> np.ndarray:
    """Masses of the cells of one component in units of 2^-62."""
    mass = component.mass_of(row)
    if not (component.strength[row] > 0 and mass.max(initial=0.0) > 0):
        return np.zeros(component.n_cells, np.uint64)
    return np.diff(fixed_point_cumulative(mass))


def _lane_counts(arrays: dict[str, np.ndarray], lane: int) -> np.ndarray:
    """Photons of each cell of a lane, int64 (n_cell,)."""
    n = int(arrays["cumulative"][lane, -1])
    lit = lane_mass(arrays, lane) > 0
    photons, start = lane_photons(arrays, lane), arrays["component_start"]
    if np.all((np.add.reduceat(lit, start[:-1]) == 1) | (photons == 0)):
        return np.where(lit, np.repeat(photons, np.diff(start)), 0)  # one cell each: nothing to count
    slots = np.flatnonzero(lit)
    tables = SobolLane.of(arrays, lane, photons, slots)
    counts = np.zeros(arrays["law"].size, np.int64)
    if use_kernels(n):
        from aomc_sky.kernels.sobol_cells import count_sobol

        whole = slots.size == counts.size
        cell_of_slot = None if whole else slots.astype(np.int32)
        count_sobol(np.uint64(0), np.uint64(n), *tables.kernel_address(), cell_of_slot, counts)
    else:
        from aomc_sky.kernels.plain_sobol import count_cells

        count_cells(n, counts, slots, *tables.plain_address())
    return counts
