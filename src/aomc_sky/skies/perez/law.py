"""The law PEREZ: the flux of the Perez luminance inside each patch, as `aomc_sky.skies.cell_law` asks for it."""

from __future__ import annotations

import numpy as np

from aomc_sky.component import Component
from aomc_sky.skies.cell_law import CellLaw, Moments
from aomc_sky.skies.perez.patches import patch_integrals, patch_moments

_N_SHARED = 11


def _numbers(component: Component) -> np.ndarray:
    assert component.shared is not None  # the rules of a plan say so
    return component.shared


def _moments(component: Component) -> Moments:
    grid = component.grid
    assert grid is not None
    zenith, azimuth = grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0
    mean, inverse = patch_moments(zenith, azimuth, _numbers(component))
    return mean.ravel(), inverse.ravel()


def _flux(component: Component, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> np.ndarray:
    return patch_integrals(zenith_deg / 90.0, azimuth_deg / 90.0, _numbers(component))


def _sun_deg(component: Component) -> tuple[float, float]:
    zenith, azimuth = _numbers(component)[5:7].tolist()
    return 90.0 * zenith, 90.0 * azimuth


PEREZ = CellLaw(
    moments=_moments,
    coordinate=lambda zenith_deg: zenith_deg,
    flux=_flux,
    sun_deg=_sun_deg,
    needs_patches=True,
    instead="within='uniform'",
    tables=lambda n_cell, _: ((_N_SHARED,), (n_cell, 4)),
)
