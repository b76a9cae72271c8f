"""The Moon before the sun, and a ground that glows: laws of their own, without a table."""

import dataclasses
import math

import numpy as np
import pytest

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.atmosphere.eclipse import eclipsed_once, visible_share
from aomc_sky.skies.atmosphere.lights import Moon
from aomc_sky.skies.atmosphere.sky.method import chosen_lights
from aomc_sky.skies.atmosphere.sky.path_orders import glow_orders
from aomc_sky.skies.atmosphere.sky.solve import solve_sky
from aomc_sky.skies.atmosphere.sky.solved import SkyField, fit_field, patch_means
from tests.support.atmospheres import molecules_only

SUN = math.radians(45.0)
SUN_RADIUS = 696350.0 / 149597870.7
GRID = PatchGrid.regular(3, 4)
ZENITH = np.radians([0.0, 40.0, 75.0, 75.0])
AZIMUTH = np.radians([0.0, 30.0, -120.0, 170.0])


@pytest.fixture(scope="module")
def medium():
    return dataclasses.replace(molecules_only(550.0, 0.1), sun_angular_radius_rad=SUN_RADIUS, n_orders=3)


def moon(zenith_deg, azimuth_deg=0.0):
    where = {"zenith_rad": SUN + math.radians(zenith_deg), "azimuth_from_sun_rad": math.radians(azimuth_deg)}
    return Moon(distance_m=3.65e8, **where)


def lights(medium, sun_deg=45.0, **given):
    asked = {"method": "auto", "n_orders": None, "moon": None, "ground_radiance": None} | given
    return chosen_lights(medium, math.radians(sun_deg), **asked)


def test_reach_of_a_moon_is_never_short(medium):
    """Where it says that nothing is hidden, no place of air or ground sees a part of the sun hidden."""
    across = 2.0 * (medium.earth_radius_m + medium.top_m)
    degrees = np.arange(0.0, 6.0, 0.25)
    reached = [moon(offset).reaches(SUN, SUN_RADIUS, across_m=across) for offset in degrees]
    assert reached[0]
    assert not reached[-1]
    assert sorted(reached, reverse=True) == reached
    first = moon(float(degrees[reached.index(False)]))
    for tilt in np.linspace(-np.pi / 2, np.pi / 2, 21):  # the observer elsewhere: the Moon moves by its parallax
        place = np.array([np.sin(tilt), 0.0, np.cos(tilt)]) * (medium.earth_radius_m + medium.top_m)
        to_moon = np.array(first.centre_m(medium.earth_radius_m)) - place
        sun = np.array([np.sin(SUN), 0.0, np.cos(SUN)])
        apart = np.arccos(to_moon @ sun / np.linalg.norm(to_moon))
        assert apart > SUN_RADIUS + np.arcsin(first.radius_m / np.linalg.norm(to_moon))
    with_moon = solve_sky(medium, sun_zenith_rad=SUN, moon=moon(10.0, 10.0))
    without = solve_sky(medium, sun_zenith_rad=SUN)
    assert (with_moon.method, with_moon.moon, with_moon.visible_share) == ("sos", None, 1.0)
    np.testing.assert_array_equal(patch_means(with_moon, GRID, 0.3)[0], patch_means(without, GRID, 0.3)[0])
    np.testing.assert_array_equal(with_moon.direct_irradiance, without.direct_irradiance)


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2, 0.4, 0.6])
def test_visible_share_is_that_of_the_disc(medium, offset):
    radius = (np.arange(1000) + 0.5) / 1000
    turn = (np.arange(720) + 0.5) * np.pi / 360
    x, y = (np.sqrt(radius)[:, None] * part(turn) * SUN_RADIUS for part in (np.cos, np.sin))
    seen = np.hypot(x - math.radians(offset), y) > np.arcsin(1.7371e6 / 3.65e8)
    assert visible_share(medium, SUN, moon(offset)) == pytest.approx(seen.mean(), abs=1e-3)


def test_left_and_right_change_places_with_the_moon(medium):
    left = eclipsed_once(medium, SUN, ZENITH, AZIMUTH, moon(0.1, 0.2))
    np.testing.assert_allclose(left, eclipsed_once(medium, SUN, ZENITH, -AZIMUTH, moon(0.1, -0.2)), rtol=1e-9)
    same_side = eclipsed_once(medium, SUN, ZENITH, -AZIMUTH, moon(0.1, 0.2))
    assert np.abs(same_side / left - 1.0)[..., 1:].max() > 0.02
    assert moon(0.1, 0.2).breaks_symmetry
    assert not moon(0.1, 0.0).breaks_symmetry


def test_skies_without_symmetry(medium):
    def law(zenith, azimuth):
        u = np.sqrt(1.0 - zenith / (np.pi / 2))
        return (1.0 + u * u) * (2.0 + np.cos(azimuth) - 0.5 * np.sin(2.0 * azimuth))

    field = fit_field(law, n_zenith=5, n_azimuth=7, is_mirrored=False)
    np.testing.assert_allclose(field.at(ZENITH, AZIMUTH), law(ZENITH, AZIMUTH), rtol=0, atol=1e-13)
    assert np.abs(fit_field(law, n_zenith=5, n_azimuth=7).at(ZENITH, AZIMUTH) - law(ZENITH, AZIMUTH)).max() > 0.1
    # Means of sin(azimuth) over columns around the sun are odd; mirrored columns would be alike.
    sky = solve_sky(medium, sun_zenith_rad=SUN, n_orders=1)
    coefficient = np.zeros((1, 1, 1, 3))
    coefficient[..., 0], coefficient[..., 2] = 2.0, 1.0
    beside = moon(0.1, 0.2)
    sky = dataclasses.replace(sky, moon=beside, later_orders=SkyField(coefficient=coefficient, is_mirrored=False))
    mean = patch_means(sky, GRID, 0.0)[0][0, 1].reshape(3, 4)
    np.testing.assert_allclose(mean, np.tile(2.0 + 2.0 / np.pi * np.array([1, 1, -1, -1]), (3, 1)), rtol=1e-12)


def test_glow_is_added_to_the_sky_of_the_sun(medium):
    sky = solve_sky(medium, sun_zenith_rad=SUN)
    coefficient = np.zeros((1, 3, 1, 1))
    coefficient[0, :, 0, 0] = 1.0, 0.5, 0.25
    lit = dataclasses.replace(sky, glow=SkyField(coefficient=coefficient))
    more = patch_means(lit, GRID, 0.0)[0] - patch_means(sky, GRID, 0.0)[0]
    np.testing.assert_allclose(more, np.broadcast_to(coefficient[..., 0], more.shape), rtol=1e-12)
    np.testing.assert_allclose(lit.at(ZENITH, AZIMUTH) - sky.at(ZENITH, AZIMUTH), 1.75, rtol=1e-12)


def test_what_shines_and_how_it_is_solved(medium):
    glow = np.ones(1)
    assert lights(medium, moon=moon(0.1)).method == "mc"
    assert lights(medium, moon=moon(0.1), n_orders=1).method == "order1"
    assert lights(medium, ground_radiance=glow).method == "sos"
    night = lights(medium, 130.0, ground_radiance=glow, moon=moon(0.1))
    assert (night.has_sun, night.moon, night.method) == (False, None, "mc")
    with pytest.raises(UsageError, match="cannot solve an eclipse"):
        lights(medium, moon=moon(0.1), method="sos")
    with pytest.raises(SceneError, match="108"):
        lights(medium, 130.0, ground_radiance=np.zeros(1))
    with pytest.raises(SceneError):
        Moon(zenith_rad=0.0, distance_m=1e6)


def test_glow_is_linear_in_the_radiance_of_the_ground(medium):
    zenith = np.radians([10.0, 70.0])
    one, two = (glow_orders(medium, np.array([r]), zenith, 5, n_listed=3, n_paths=64) for r in (1.0, 2.0))
    np.testing.assert_array_equal(two[0], 2.0 * one[0])
    assert two[1] == pytest.approx(one[1], rel=1e-12)
    assert one[0].shape == (1, 3, 2)
