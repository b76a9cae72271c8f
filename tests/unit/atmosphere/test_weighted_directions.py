"""Weighted directions: numbers that depend on nothing else, exact sums, an eclipse, a glowing ground."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import aomc_sky
from aomc_sky.atmosphere.backward import solve_paths
from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.order_one import solve_order_one
from aomc_sky.atmosphere.sky.method import chosen_lights
from aomc_sky.atmosphere.sky.path_orders import glow_orders
from aomc_sky.atmosphere.sky.weighted_directions import (
    FLOOR,
    WeightedDirections,
    one_wavelength,
    order_one_density,
    weighted_directions,
)
from aomc_sky.errors import SceneError, UsageError
from tests.support.atmospheres import empty, full, molecules_only
from tests.support.shared import INPUTS

SUN = float(np.radians(40.0))
PER_DIRECTION = ("zenith_rad", "azimuth_from_sun_rad", "weight", "order_one_weight")


def of(medium: aomc_sky.Medium, n: int, first: int = 0, sun: float = SUN, **more: int) -> WeightedDirections:
    return weighted_directions(medium, sun_zenith_rad=sun, n=n, first=first, **more)


def test_any_part_has_the_same_bits() -> None:
    medium = full(450.0, 0.2)
    whole = of(medium, 101)
    parts = [of(medium, n, first) for first, n in ((0, 1), (1, 63), (64, 37))]
    for name in PER_DIRECTION:
        together = np.concatenate([getattr(part, name) for part in parts], axis=1)
        np.testing.assert_array_equal(getattr(whole, name), together)


def test_wavelengths_and_seeds_have_numbers_of_their_own() -> None:
    medium = molecules_only([450.0, 600.0], 0.2)
    both = of(medium, 101)
    assert np.unique(both.zenith_rad).size == 202
    np.testing.assert_array_equal(both.weight[1], of(one_wavelength(medium, 1), 101).weight[0])
    assert not np.any(of(one_wavelength(medium, 1), 101, seed=1).zenith_rad == both.zenith_rad[1])


def test_weights_are_radiances_over_the_density() -> None:
    medium = full(450.0, 0.2)
    lights = chosen_lights(medium, SUN, method="mc", n_orders=None, moon=None, ground_radiance=None)
    found, density = of(medium, 2000), order_one_density(medium, SUN, lights)
    cell = density.grid.patch_of(np.rad2deg(found.zenith_rad[0]), np.rad2deg(found.azimuth_from_sun_rad[0]))
    chance = density.chance[0, cell] / density.grid.projected_solid_angle_sr[cell]
    once = solve_order_one(medium, SUN, found.zenith_rad[0], found.azimuth_from_sun_rad[0])[0]
    np.testing.assert_allclose(found.order_one_weight[0] * chance, once, rtol=1e-12)
    assert np.all(found.weight >= found.order_one_weight)
    assert np.all(chance >= FLOOR / np.pi * (1 - 1e-12))


def test_one_order_is_its_quadrature() -> None:
    medium = molecules_only(550.0)
    found = of(medium, 4000, n_orders=1)
    np.testing.assert_array_equal(found.weight, found.order_one_weight)
    sky = aomc_sky.AtmosphereSky(medium=medium, sun_zenith_deg=40.0, method="order1")
    assert found.irradiance == pytest.approx(sky.diffuse_irradiance, rel=0.03)
    assert abs(found.irradiance - sky.diffuse_irradiance) < 5.0 * found.standard_error


def test_twilight_agrees_with_many_paths_for_each_direction() -> None:
    medium, sun = molecules_only(450.0, 0.3), float(np.radians(92.0))
    found = of(medium, 4000, sun=sun)
    mu, weight = np.polynomial.legendre.leggauss(8)
    zenith, azimuth = np.meshgrid(np.arccos(np.sqrt((mu + 1) / 2)), (np.arange(8) + 0.5) * np.pi / 8, indexing="ij")
    paths = solve_paths(
        medium, sun_zenith_rad=sun, sky_zenith_rad=zenith.ravel(), azimuth_from_sun_rad=azimuth.ravel(),
        n_paths=1000, n_orders=medium.n_orders, seed=3,
    )  # fmt: skip
    whole = float(weight @ paths.radiance[0].reshape(8, 8).mean(axis=1)) * np.pi / 2
    assert abs(found.irradiance[0] - whole) < 5.0 * found.standard_error[0] + 0.02 * whole
    assert found.standard_error[0] < 0.05 * whole
    assert found.direct_irradiance[0] == 0.0


def test_no_air_has_no_light() -> None:
    found = of(empty(albedo=0.5), 64)
    assert not found.weight.any()
    assert found.direct_irradiance[0] > 0.0


def test_few_paths_are_told() -> None:
    assert of(molecules_only(550.0), 4).under_sampled.all()
    assert np.isnan(of(molecules_only(550.0), 1).standard_error).all()


def test_of_a_description() -> None:
    found = aomc_sky.weighted_directions(
        INPUTS / "atmosphere" / "clear_marine.atmo", wavelength_nm=[680, 440, 681], sun_zenith_deg=40, n=500
    )
    assert found.wavelength_nm.tolist() == [680, 440, 680]
    np.testing.assert_array_equal(found.weight[0], found.weight[2])
    assert found.irradiance[1] == pytest.approx(0.25, rel=0.1)


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"n": 0}, UsageError, "1 or more"),
        ({"n": 2.5}, UsageError, "whole number"),
        ({"first": 2**32 - 1}, UsageError, "within 0 and"),
        ({"seed": -1}, UsageError, "seed"),
        ({"orders": 0}, UsageError, "orders"),
        ({"sun_zenith_deg": 120.0}, SceneError, "zenith"),
    ],
)
def test_what_cannot_be_asked_for(given: dict[str, float], error: type[Exception], told: str) -> None:
    asked: dict[str, object] = {"wavelength_nm": 550.0, "sun_zenith_deg": 40.0, "n": 8}
    with pytest.raises(error, match=told):
        aomc_sky.weighted_directions(INPUTS / "atmosphere" / "molecules_only.atmo", **(asked | given))  # type: ignore[arg-type]


HALF_HIGH = float(np.radians(50.0))
AIR = molecules_only(450.0, 0.3)
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(6)
ZENITH = np.arccos(np.sqrt((_NODE + 1) / 2))  # of an integral over mu^2


@pytest.mark.slow
def test_an_eclipse_is_that_of_many_paths() -> None:
    """The Moon beside the sun's vertical plane: no azimuth is like another."""
    disc = dataclasses.replace(AIR, sun_angular_radius_rad=0.00465)
    moon = Moon(zenith_rad=HALF_HIGH, azimuth_from_sun_rad=float(np.radians(0.25)), distance_m=3.7e8)
    found = weighted_directions(disc, sun_zenith_rad=HALF_HIGH, n=20_000, moon=moon)
    theta, phi = (angle.ravel() for angle in np.meshgrid(ZENITH, np.arange(9) * 2 * np.pi / 9, indexing="ij"))
    paths = solve_paths(
        disc, sun_zenith_rad=HALF_HIGH, sky_zenith_rad=theta, azimuth_from_sun_rad=phi, n_paths=4000,
        n_orders=AIR.n_orders, seed=3, visible=moon,
    )  # fmt: skip
    whole = float(_WEIGHT @ paths.radiance[0].reshape(6, 9).mean(axis=1)) * np.pi / 2
    assert abs(found.irradiance[0] - whole) < 5.0 * found.standard_error[0] + 0.01 * whole
    assert found.standard_error[0] < 0.02 * whole
    assert not found.under_sampled.any()
    without = weighted_directions(AIR, sun_zenith_rad=HALF_HIGH, n=2)
    assert 0.3 < found.direct_irradiance[0] / without.direct_irradiance[0] < 0.9
    assert found.irradiance[0] < 0.9 * weighted_directions(AIR, sun_zenith_rad=HALF_HIGH, n=20_000).irradiance[0]


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
        weighted_directions(AIR, sun_zenith_rad=HALF_HIGH, n=2000, n_orders=2, ground_radiance=glow)
        for glow in (np.array([1e-9]), np.array([1.0]))
    )
    np.testing.assert_array_equal(one.zenith_rad, both.zenith_rad)
    np.testing.assert_array_equal(one.order_one_weight, both.order_one_weight)
    assert np.all(both.weight >= one.weight)
    assert both.irradiance[0] > one.irradiance[0]


@pytest.mark.slow
def test_moon_and_glow_of_a_description() -> None:
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
