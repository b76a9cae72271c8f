"""The wavebands of a plan, and their photon counts, made from its masses; `verify` makes the counts again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.plan.allocation import AllocationMethod, WalkedGrid, allocate_bands


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanBand:
    """One waveband of a plan."""

    wavelength_nm: float  #: [nm]
    sky_wavelength_nm: float  #: of the sky that it takes; NaN where the sky has none [nm]
    requested: int  #: photons of all replicates together
    row: int  #: of the components' masses, weights and slopes
    #: Irradiance of each component on a horizontal plane, None where it is not known. [W m-2 nm-1]
    irradiance_W_m2_nm: tuple[float, ...] | None = None  # noqa: N815
    #: Of the light of the lobes, the share that comes from below the horizon and sends no photons. [0 to 1]
    horizon_loss: float = 0.0


def replicate_band_photons(requested: np.ndarray, replicates: int) -> np.ndarray:
    """Photons of each replicate band, int64 (n_replicate x n_band,), one replicate after the other.

    The replicates of a band share its photons evenly; the first ones take one more where some are left.
    """
    each, left = np.divmod(requested, replicates)
    return np.concatenate([each + (left > r) for r in range(replicates)])


def cumulative_counts(
    bands: Sequence[PlanBand], components: Sequence[Component], options: Mapping[str, Any]
) -> np.ndarray:
    """Member `cumulative` of a plan, int64 (n_replicate_band, n_cell + 1), from its masses and its options.

    Any allocation but `aomc`, which rounds the table itself. A band without light has no photons.
    """
    replicates, n_cells = options["replicates"], sum(component.n_cells for component in components)
    photons = replicate_band_photons(np.array([band.requested for band in bands]), replicates)
    row_of = np.tile([band.row for band in bands], replicates)
    cumulative = np.zeros((photons.size, n_cells + 1), dtype=np.int64)
    rings = _rings_of(components)
    for row in range(len(components[0].mass)):
        mass = np.concatenate([component.mass[row] for component in components])
        if not mass.any():
            continue
        own = np.flatnonzero(row_of == row)
        counts = allocate_bands(
            mass,
            photons[own].tolist(),
            own.tolist(),
            method=AllocationMethod(options["allocation"]),
            seed=options["seed"],
            family=options["method"],
            rings=rings,
        )
        cumulative[own, 1:] = np.cumsum(counts, axis=1)
    return cumulative


def _rings_of(components: Sequence[Component]) -> tuple[WalkedGrid, ...]:
    """The rings of all components that have a grid."""
    starts = accumulate((component.n_cells for component in components), initial=0)
    return tuple(
        WalkedGrid(first_cell=start, n_rings=component.grid.n_zenith, n_columns=component.grid.n_azimuth)
        for start, component in zip(starts, components, strict=False)
        if component.grid is not None
    )
