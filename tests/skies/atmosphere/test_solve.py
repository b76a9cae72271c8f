"""Solving in given directions and for the whole sky: one answer from both, and what is refused."""

import dataclasses

import numpy as np
import pytest
from scipy.special import chdtr

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere.backward import MOST_LISTED, solve_paths
from aomc_sky.skies.atmosphere.eclipse import solve_order_one
from aomc_sky.skies.atmosphere.lights import Moon
from aomc_sky.skies.atmosphere.model import AtmosphereSky
from aomc_sky.skies.atmosphere.sky import path_orders, solved
from aomc_sky.skies.atmosphere.sky import solve as solve_module
from aomc_sky.skies.atmosphere.sky.method import chosen_method, is_curved
from aomc_sky.skies.atmosphere.sky.solve import solve, solve_sky
from aomc_sky.skies.atmosphere.sky.solved import patch_means, zenith_nodes
from tests.support import atmospheres
from tests.support.atmospheres import molecules_only

SUN = np.deg2rad(40.0)
AIR = atmospheres.molecules_only([450.0, 650.0], albedo=[0.3, 0.1])
HAZE = atmospheres.full([550.0], albedo=0.05)


def wave(zenith, azimuth):
    """A function that the series hold: polynomials of the square root of the elevation times cosines."""
    u = np.sqrt(1 - zenith / (np.pi / 2))
    return np.stack([1 + u**3 * np.cos(2 * azimuth), u * np.cos(azimuth)])


def test_a_field_is_exact_for_what_its_series_hold():
    field = solved.fit_field(wave, n_zenith=5, n_azimuth=4)
    zenith, azimuth = np.linspace(0, np.pi / 2, 7), np.linspace(-4, 9, 7)
    np.testing.assert_allclose(field.at(zenith, azimuth), wave(zenith, azimuth), rtol=0, atol=1e-14)
    grid = np.meshgrid(zenith, azimuth, indexing="ij")
    found = field.in_cells(zenith[None], azimuth[None], np.zeros(1, int), np.zeros(1, int))[:, 0]
    np.testing.assert_allclose(found, wave(*grid), rtol=0, atol=1e-14)
    again = solved.field_of_modes(
        np.stack([[np.ones(5), 0 * zenith_nodes(5), wave(zenith_nodes(5), np.zeros(5))[0] - 1]])
    )
    np.testing.assert_allclose(again.at(zenith, azimuth)[0], wave(zenith, azimuth)[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize("medium", [AIR, HAZE], ids=["air", "haze"])
def test_the_whole_sky_agrees_with_single_directions(medium):
    sky = solve_sky(medium, sun_zenith_rad=SUN, n_orders=5)
    zenith, azimuth = np.deg2rad([0.0, 17.3, 40.0, 66.6, 88.7, 90.0]), np.deg2rad([0.0, 33.0, 200.0])
    direct = solve(medium, sun_zenith_rad=SUN, sky_zenith_rad=zenith, azimuth_from_sun_rad=azimuth, n_orders=5)
    theta, phi = (x.ravel() for x in np.meshgrid(zenith, azimuth, indexing="ij"))
    np.testing.assert_allclose(sky.at(theta, phi), direct.radiance.reshape(-1, theta.size), rtol=2e-4)
    once = solve_order_one(medium, SUN, theta, phi)
    np.testing.assert_allclose(sky.with_phases(sky.order_one.at(theta, phi), theta, phi), once, rtol=1e-6)
    np.testing.assert_allclose(direct.radiance_by_order[:, 0].reshape(once.shape), once, rtol=1e-14)


def test_orders_add_up_and_azimuths_mirror():
    azimuth = np.deg2rad([350.0, 10.0, -10.0, 370.0, 95.0, 265.0])
    found = solve(AIR, sun_zenith_rad=SUN, sky_zenith_rad=[1.0, 0.2, 1.0], azimuth_from_sun_rad=azimuth, n_orders=4)
    assert found.radiance_by_order.shape == (2, 4, 3, 6)
    np.testing.assert_allclose(found.radiance_by_order.sum(axis=1), found.radiance, rtol=1e-15)
    np.testing.assert_array_equal(found.radiance[:, 0], found.radiance[:, 2])
    np.testing.assert_allclose(found.radiance[..., 0], found.radiance[..., 3], rtol=1e-13)
    np.testing.assert_allclose(found.radiance[..., 4], found.radiance[..., 5], rtol=1e-13)
    assert np.all(found.standard_error > 0)
    assert np.all(found.standard_error < 0.02 * found.radiance)
    few, most = (
        solve(AIR, sun_zenith_rad=SUN, sky_zenith_rad=[0.5], azimuth_from_sun_rad=[0.0], n_orders=n)
        for n in (3, MOST_LISTED + 16)
    )
    np.testing.assert_allclose(1 - few.diffuse_irradiance / most.diffuse_irradiance, few.truncation, rtol=0.01)
    assert np.all(most.truncation < 1e-9)
    nodes, weights = np.polynomial.legendre.leggauss(48)
    t, w = (nodes + 1) / 2, weights / 2
    mu = t**2  # crowded at the horizon
    azimuth = np.pi * (np.arange(24) + 0.5) / 24
    found = solve(AIR, sun_zenith_rad=SUN, sky_zenith_rad=np.arccos(mu), azimuth_from_sun_rad=azimuth, n_orders=6)
    wanted = 2 * np.pi * np.einsum("wza,z->w", found.radiance, w * 2 * t * mu) / 24
    np.testing.assert_allclose(found.diffuse_irradiance, wanted, rtol=1e-6)
    found = solve(atmospheres.empty(albedo=0.5), sun_zenith_rad=SUN, sky_zenith_rad=[0.3], azimuth_from_sun_rad=[0.0])
    assert found.radiance.max() == 0.0
    assert found.direct_irradiance[0] == pytest.approx(np.cos(SUN), rel=1e-15)
    assert found.diffuse_irradiance[0] == 0.0


def test_patch_means_settle_around_a_sharp_peak():
    sky = solve_sky(HAZE, sun_zenith_rad=SUN, n_orders=1)
    grid = PatchGrid.regular(30, 60)
    mean, change = patch_means(sky, grid, 0.3)
    fine, _ = patch_means(sky, grid, 0.3, tolerance=1e-9)
    assert change <= 1e-5
    np.testing.assert_allclose(mean, fine, rtol=2e-5)
    ring, column = 13, 2  # around the sun at 40 degrees, 17.2 degrees
    share, weight = np.polynomial.legendre.leggauss(200)
    sin2 = np.sin(np.deg2rad(39 + np.array([0.0, 3.0]))) ** 2
    zenith = np.arcsin(np.sqrt(sin2[0] + (sin2[1] - sin2[0]) * (share + 1) / 2))
    azimuth = np.deg2rad(12 + 6 * (share + 1) / 2) - 0.3
    theta, phi = (one.ravel() for one in np.meshgrid(zenith, azimuth, indexing="ij"))
    once = sky.with_phases(sky.order_one.at(theta, phi), theta, phi)
    exact = np.einsum("wij,i,j->w", once.reshape(-1, 200, 200), weight, weight) / 4
    np.testing.assert_allclose(mean[:, 0, ring * 60 + column], exact, rtol=2e-5)


def test_what_a_method_is_not_good_for():
    low = np.deg2rad(83.0)
    assert chosen_method(AIR, low, "auto", 1) == ("order1", 1)
    assert chosen_method(AIR, SUN, "order1", 9) == ("order1", 1)
    assert chosen_method(AIR, SUN, "auto", None) == ("sos", AIR.n_orders)
    assert chosen_method(AIR, low, "auto", 2) == ("mc", 2)
    assert chosen_method(AIR, np.deg2rad(95.0), "auto", 2) == ("mc", 2)
    assert chosen_method(AIR, SUN, "mc", 2) == ("mc", 2)
    with pytest.warns(ModelLimitWarning, match="wrong by some per cent"):
        assert chosen_method(AIR, low, "sos", 2) == ("sos", 2)
    flat = dataclasses.replace(AIR, earth_radius_m=1e10)
    assert not is_curved(flat, low)
    assert chosen_method(flat, low, "auto", 2) == ("sos", 2)
    for method, n_orders, word in (("fast", None, "'sos'"), ("sos", 0, "from 1"), ("auto", 2.5, "whole")):
        with pytest.raises(UsageError, match=word):
            chosen_method(AIR, SUN, method, n_orders)
    with pytest.raises(UsageError, match="above the horizon"):
        chosen_method(AIR, np.deg2rad(91.0), "sos", 2)
    for degrees in (-1.0, 109.0, np.nan):
        with pytest.raises(SceneError, match="108"):
            chosen_method(AIR, np.deg2rad(degrees), "order1", None)
    assert "one order" in solve_sky(AIR, sun_zenith_rad=SUN, method="auto", n_orders=1).reason
    assert not solve_sky(AIR, sun_zenith_rad=SUN, method="order1").reason
    for zenith, azimuth in (([1.6], [0.0]), ([-0.1], [0.0]), ([np.nan], [0.0]), ([1.0], [np.inf]), ([], [0.0])):
        with pytest.raises(UsageError):
            solve(AIR, sun_zenith_rad=SUN, sky_zenith_rad=zenith, azimuth_from_sun_rad=azimuth)


def test_twilight_is_solved_in_every_direction():
    sun = np.deg2rad(95.0)
    sky = solve_sky(AIR, sun_zenith_rad=sun, n_orders=1)
    zenith, azimuth = np.deg2rad([10.0, 70.0, 89.0]), np.deg2rad([0.0, 100.0, 180.0])
    np.testing.assert_array_equal(sky.at(zenith, azimuth), solve_order_one(AIR, sun, zenith, azimuth))
    mean, change = patch_means(sky, PatchGrid.regular(6, 8), 0.2, tolerance=1e-4)
    fine, _ = patch_means(sky, PatchGrid.regular(6, 8), 0.2, tolerance=1e-6)
    np.testing.assert_allclose(mean, fine, rtol=5e-4)
    assert change <= 1e-4
    assert sky.direct_irradiance.max() == 0.0


TWILIGHT_SUN = np.radians(91.0)
ZENITH, AZIMUTH = np.radians([0.0, 60.0, 85.0, 89.0]), np.radians([-150.0, 0.0, 150.0])
MOLECULES = molecules_only(550.0, 0.3)


def sky_of(sun_rad):
    """What `directed_paths` reads of a sky, which is not solved for it."""
    sky = solve_sky(MOLECULES, sun_zenith_rad=1.0, method="order1")
    return dataclasses.replace(sky, sun_zenith_rad=sun_rad, method="mc", n_orders=4)


@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
def test_errors_are_those_of_each_direction(monkeypatch):
    monkeypatch.setattr(solve_module, "MOST_PATHS", 10_000)
    theta, phi = (angle.ravel() for angle in np.meshgrid(ZENITH, AZIMUTH[1:], indexing="ij"))
    found = solve_module.directed_paths(sky_of(TWILIGHT_SUN), theta, phi)
    where = {"sun_zenith_rad": TWILIGHT_SUN, "sky_zenith_rad": theta, "azimuth_from_sun_rad": phi}
    other = solve_paths(MOLECULES, **where, n_paths=20_000, n_orders=4, seed=99)
    pull = (found.radiance - other.radiance) / np.hypot(found.standard_error, other.standard_error)
    assert 1e-4 < chdtr(pull.size, np.sum(pull**2)) < 1 - 1e-4
    share = found.standard_error / found.radiance
    assert share.max() > 3.0 * share.min()  # the dark side of the horizon is known far worse than the glow


def test_two_suns_have_numbers_of_their_own():
    zenith, azimuth = np.radians([60.0]), np.zeros(1)
    one, two = (solve_module.directed_paths(sky_of(sun), zenith, azimuth) for sun in (1.2, np.nextafter(1.2, 2.0)))
    later = [found.radiance_by_order[0, 1:, 0].sum() for found in (one, two)]
    assert 1e-5 < abs(later[0] / later[1] - 1.0) < 0.05


@pytest.mark.parametrize(("turn", "moon_deg"), [(2 * np.pi, None), (-2 * np.pi, 0.5)])
def test_the_error_of_a_direction_is_that_of_its_nearest_node(turn, moon_deg):
    """Left and right are one sky, unless a Moon stands beside the sun."""
    moon = None if moon_deg is None else Moon(zenith_rad=1.0, azimuth_from_sun_rad=np.radians(moon_deg), distance_m=4e8)
    azimuth = solved.azimuth_nodes(5, is_mirrored=moon is None)
    sky = solve_sky(MOLECULES, sun_zenith_rad=1.0, method="order1")
    sky = dataclasses.replace(sky, moon=moon, node_error=np.arange(30.0).reshape(1, 6, 5))
    zenith, azimuth = np.meshgrid(zenith_nodes(6) + 1e-9, azimuth, indexing="ij")
    for turned in (azimuth, azimuth + turn, *([-azimuth] if moon is None else [])):
        np.testing.assert_array_equal(sky.path_error(zenith.ravel(), turned.ravel())[0], np.arange(30.0))


@pytest.mark.filterwarnings("ignore:the paths give orders 2 and up")
@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
def test_patches_have_errors_of_their_own(monkeypatch):
    monkeypatch.setattr(path_orders, "solve_paths", lambda *given, **how: solve_paths(*given, **how | {"n_paths": 256}))
    how = {"sun_zenith_deg": 89.0, "sun_azimuth_deg": 70.0, "method": "mc", "n_orders": 3}
    sky = AtmosphereSky(medium=MOLECULES, grid=PatchGrid.regular(9, 12), **how)
    share = sky.patch_error[0] / sky.patch_mean[0, 1:].sum(axis=0)
    assert share.max() > 1.5 * share.min()
    assert np.all(share > 0)
