"""The law PEREZ: the flux of the Perez luminance inside each patch, as `CellLaw` asks for it."""

from __future__ import annotations

import numpy as np

from aomc_sky.component import CellLaw, Component
from aomc_sky.skies.perez.patches import patch_integrals, patch_moments

_N_SHARED = 11


def _numbers(component: Component) -> np.ndarray:
    assert component.shared is not None  # the rules of a plan say so
    return component.shared


def _moments(component: Component) -> tuple[np.ndarray, np.ndarray]:
    grid = component.grid
    assert grid is not None
    mean, inverse = patch_moments(grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0, _numbers(component))
    return mean.ravel(), inverse.ravel()


PEREZ = CellLaw(
    moments=_moments,
    coordinate=lambda zenith_deg: zenith_deg,
    flux=lambda component, zenith, azimuth: patch_integrals(zenith / 90.0, azimuth / 90.0, _numbers(component)),
    sun_deg=lambda component: 90.0 * _numbers(component)[5:7],
    needs_patches=True,
    instead="within='uniform'",
    tables=lambda n_cell, _: ((_N_SHARED,), (n_cell, 4)),
)
