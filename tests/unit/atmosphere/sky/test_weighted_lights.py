"""Weighted directions under an eclipse and over a glowing ground, beside many paths in chosen directions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import aomc_sky
from aomc_sky.atmosphere.backward.monte_carlo import solve_paths
from aomc_sky.atmosphere.backward.orders import glow_orders
from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.sky.weighted_directions import weighted_directions
from tests.support.atmospheres import molecules_only
from tests.support.shared import INPUTS

SUN = float(np.radians(50.0))
AIR = molecules_only(450.0, 0.3)
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(6)
ZENITH = np.arccos(np.sqrt((_NODE + 1) / 2))  # of an integral over mu^2


@pytest.mark.slow
def test_an_eclipse_is_that_of_many_paths() -> None:
    """The Moon beside the sun's vertical plane: no azimuth is like another."""
    disc = dataclasses.replace(AIR, sun_angular_radius_rad=0.00465)
    moon = Moon(zenith_rad=SUN, azimuth_from_sun_rad=float(np.radians(0.25)), distance_m=3.7e8)
    found = weighted_directions(disc, sun_zenith_rad=SUN, n=20_000, moon=moon)
    theta, phi = (angle.ravel() for angle in np.meshgrid(ZENITH, np.arange(9) * 2 * np.pi / 9, indexing="ij"))
    paths = solve_paths(
        disc, sun_zenith_rad=SUN, sky_zenith_rad=theta, azimuth_from_sun_rad=phi, n_paths=4000,
        n_orders=AIR.n_orders, seed=3, visible=moon,
    )  # fmt: skip
    whole = float(_WEIGHT @ paths.radiance[0].reshape(6, 9).mean(axis=1)) * np.pi / 2
    assert abs(found.irradiance[0] - whole) < 5.0 * found.standard_error[0] + 0.01 * whole
    assert found.standard_error[0] < 0.02 * whole
    assert not found.under_sampled.any()
    without = weighted_directions(AIR, sun_zenith_rad=SUN, n=2)
    assert 0.3 < found.direct_irradiance[0] / without.direct_irradiance[0] < 0.9
    assert found.irradiance[0] < 0.9 * weighted_directions(AIR, sun_zenith_rad=SUN, n=20_000).irradiance[0]


@pytest.mark.parametrize("n_orders", [1, 4])
def test_glow_of_the_night(n_orders: int) -> None:
    given = np.array([2.5])
    found = weighted_directions(
        AIR, sun_zenith_rad=float(np.radians(150.0)), n=20_000, n_orders=n_orders, ground_radiance=given
    )
    glow = glow_orders(AIR, given, ZENITH, n_orders, n_listed=n_orders, n_paths=20_000)
    whole = float(_WEIGHT @ glow.radiance[0].sum(axis=0)) * np.pi / 2
    assert abs(found.irradiance[0] - whole) < 5.0 * found.standard_error[0] + 0.005 * whole
    assert found.standard_error[0] < 0.02 * whole
    assert not found.order_one_weight.any()
    assert not found.direct_irradiance.any()


def test_glow_is_added_to_the_sun() -> None:
    one, both = (
        weighted_directions(AIR, sun_zenith_rad=SUN, n=2000, n_orders=2, ground_radiance=glow)
        for glow in (np.array([1e-9]), np.array([1.0]))
    )
    np.testing.assert_array_equal(one.zenith_rad, both.zenith_rad)
    np.testing.assert_array_equal(one.order_one_weight, both.order_one_weight)
    assert np.all(both.weight >= one.weight)
    assert both.irradiance[0] > one.irradiance[0]


@pytest.mark.slow
def test_of_a_description() -> None:
    asked = {"wavelength_nm": 550.0, "sun_zenith_deg": 50.0, "n": 64}
    path = INPUTS / "eclipse" / "air.atmo"
    dark = aomc_sky.weighted_directions(path, **asked, moon={"zenith_offset_deg": 0.3})  # type: ignore[arg-type]
    assert 0.0 < dark.direct_irradiance[0] < aomc_sky.weighted_directions(path, **asked).direct_irradiance[0]  # type: ignore[arg-type]
    lit = aomc_sky.weighted_directions(
        INPUTS / "light_polluted" / "air.atmo",
        wavelength_nm=550.0,
        sun_zenith_deg=170.0,
        n=64,
        ground_luminance_cd_m2=1.0,
    )
    assert lit.weight.any()
