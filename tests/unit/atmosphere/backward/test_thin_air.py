"""Backward paths through air so thin that all of them weigh little from the start."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from tests.support.atmospheres import EARTH_RADIUS_M, TOP_M, molecules_only

WAVELENGTH = 2500.0
N_PATHS = 20_000


def thin_glow() -> float:
    """Order 1 overhead of a ground of radiance 1, nothing lost on the way: the ground fills a cone below the air."""
    node, weight = np.polynomial.legendre.leggauss(200)
    h = 0.5 * TOP_M * (1.0 + node)
    c = np.sqrt(1.0 - (EARTH_RADIUS_M / (EARTH_RADIUS_M + h)) ** 2)
    scattering = 3.08458e25 * np.exp(-h / 8000.0) * 0.04022e-30 / (WAVELENGTH / 1000.0) ** 4
    return float(0.5 * TOP_M * weight @ (scattering * 0.375 * ((1.0 - c) + (1.0 - c**3) / 3.0)))


def test_roulette_leaves_paths_of_thin_air_alone() -> None:
    found = solve_paths(
        molecules_only(WAVELENGTH, 1.0), sun_zenith_rad=1.0, sky_zenith_rad=[0.0, 1.5], azimuth_from_sun_rad=[0.0, 0.0],
        n_paths=N_PATHS, n_orders=10, seed=3, ground_radiance=[1.0],
    )  # fmt: skip
    share = found.standard_error[0] / found.radiance[0]
    assert share.max() < 1.5 / np.sqrt(N_PATHS)


def test_order_one_of_a_glowing_ground_has_a_closed_form() -> None:
    found = solve_paths(
        molecules_only(WAVELENGTH), sun_zenith_rad=3.0, sky_zenith_rad=[0.0], azimuth_from_sun_rad=[0.0],
        n_paths=N_PATHS, n_orders=1, seed=4, ground_radiance=[1.0],
    )  # fmt: skip
    bar = found.standard_error[0, 0] + 1e-3 * thin_glow()
    assert found.radiance[0, 0] == pytest.approx(thin_glow(), abs=4.0 * bar)
    assert bar < 0.01 * thin_glow()
