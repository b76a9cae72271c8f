"""The photon counts of a plan, made from its masses; `verify` makes them again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from aomc_sky.plan.sampling.allocation import AllocationMethod, allocate_bands
from aomc_sky.plan.sampling.walk import WalkedGrid

Arrays = Mapping[str, np.ndarray]


def replicate_band_photons(requested: np.ndarray, replicates: int) -> np.ndarray:
    """Photons of each replicate band, int64 (n_replicate x n_band,), one replicate after the other.

    The replicates of a band share its photons evenly; the first ones take one more where some are left.
    """
    each, left = np.divmod(requested, replicates)
    return np.concatenate([each + (left > r) for r in range(replicates)])


def cumulative_counts(arrays: Arrays, options: Mapping[str, Any]) -> np.ndarray:
    """Member `cumulative` of a plan, int64 (n_replicate_band, n_cell + 1), from its other members and its options.

    Any allocation but `aomc`, which rounds the table itself. A band without light has no photons.
    """
    mass, replicates = arrays["mass"], options["replicates"]
    photons = replicate_band_photons(arrays["requested"], replicates)
    row_of = np.tile(arrays["row_of_band"], replicates)
    cumulative = np.zeros((photons.size, mass.shape[1] + 1), dtype=np.int64)
    rings = rings_of(arrays)
    for k in np.flatnonzero(mass.any(axis=1)):
        bands = np.flatnonzero(row_of == k)
        counts = allocate_bands(
            mass[k],
            photons[bands].tolist(),
            bands.tolist(),
            method=AllocationMethod(options["allocation"]),
            seed=options["seed"],
            family=options["method"],
            rings=rings,
        )
        cumulative[bands, 1:] = np.cumsum(counts, axis=1)
    return cumulative


def rings_of(arrays: Arrays) -> tuple[WalkedGrid, ...]:
    """The rings of all components that have a grid."""
    start = arrays["component_start"][:-1].tolist()
    grids = {k: (f"zenith_bounds_deg_{k}", f"azimuth_bounds_deg_{k}") for k in range(len(start))}
    return tuple(
        WalkedGrid(first_cell=start[k], n_rings=len(arrays[zenith]), n_columns=len(arrays[azimuth]))
        for k, (zenith, azimuth) in grids.items()
        if zenith in arrays
    )
