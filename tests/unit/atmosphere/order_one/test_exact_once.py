"""Order 1 of twilight on circles of one zenith angle: polynomials beside the solver itself."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.atmosphere.order_one import order_one_tables, scattered_once
from aomc_sky.atmosphere.twilight import ExactOnce
from tests.support.atmospheres import full

ZENITH = np.radians([0.0, 35.0, 70.0, 85.0, 89.0, 89.9])
AZIMUTH = np.radians(np.linspace(-200.0, 200.0, 161))


def exact(sun_deg: float) -> ExactOnce:
    medium, sun = full([400.0, 700.0]), np.radians(sun_deg)
    return ExactOnce(medium=medium, sun_zenith_rad=sun, tables=order_one_tables(medium, sun))


@pytest.mark.parametrize("sun_deg", [90.5, 92.0, 96.0])
def test_circles_are_the_solver(sun_deg: float) -> None:
    once = exact(sun_deg)
    theta, phi = np.meshgrid(ZENITH, AZIMUTH, indexing="ij")
    true = scattered_once(once.medium, once.sun_zenith_rad, theta.ravel(), phi.ravel()).reshape(2, -1, *theta.shape)
    found = once.on_product(ZENITH, AZIMUTH)
    assert np.all(found >= 0.0)
    brightest = true.max(axis=-1, keepdims=True)
    assert np.all(brightest > 0.0)
    assert np.all(np.abs(found - true) <= 5e-6 * (true + 1e-3 * brightest))


def test_cells_are_those_of_the_product() -> None:
    """Rings with many cells and with one, whose nodes are too few for a polynomial."""
    once = exact(92.0)
    zenith, azimuth = ZENITH[:4].reshape(2, 2), np.radians(np.linspace(0.0, 170.0, 36)).reshape(18, 2)
    ring, column = np.append(np.zeros(18, dtype=int), 1), np.append(np.arange(18), 7)
    found = once.in_cells(zenith, azimuth, ring, column)
    assert found.shape[2:] == (19, 2, 2)
    for cell in (0, 11, 18):
        theta, phi = np.meshgrid(zenith[ring[cell]], azimuth[column[cell]], indexing="ij")
        true = once.at(theta.ravel(), phi.ravel()).reshape(found[:, :, cell].shape)
        np.testing.assert_allclose(found[:, :, cell], true, rtol=1e-6)
