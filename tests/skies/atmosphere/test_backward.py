"""Backward paths on our own data: flat layers, order 1, error bars, seeds and splits, eclipses, glowing ground."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import expn

from aomc_sky.errors import UsageError
from aomc_sky.skies.atmosphere.backward import path_tables, paths_result, solve_paths
from aomc_sky.skies.atmosphere.lights import Moon
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import solve_orders
from aomc_sky.skies.atmosphere.sky.path_orders import path_orders
from aomc_sky.skies.atmosphere.sky.solve import solve_sky
from tests.support import atmospheres
from tests.support.atmospheres import Layer, full, henyey_greenstein_phase, molecules_only
from tests.support.plane_layers import Layers, by_order, solve_layers

ZENITH = np.radians([0.0, 35.0, 60.0, 80.0, 60.0])
AZIMUTH = np.radians([0.0, 0.0, 180.0, 90.0, 20.0])
SUN = np.radians(50.0)
SUN_RADIUS = 696350.0 / 149597870.7


def solved(medium, n_paths, **more):
    given = {"sun_zenith_rad": SUN, "sky_zenith_rad": ZENITH, "azimuth_from_sun_rad": AZIMUTH, "n_orders": 60}
    return solve_paths(medium, **{**given, "n_paths": n_paths, "seed": 5, **more})


def flat_orders(albedo):
    """Orders (n_order, n) of two flat layers by successive orders, the last row with all later ones."""
    phases = (lambda mu: atmospheres.rayleigh_phase(mu, 0), lambda mu: henyey_greenstein_phase(0.7)(mu, 0))
    scattering = np.array([[1.0, 0.1 / 0.45], [0.0, 0.27 / 0.45]])
    layers = Layers(optical_depth=np.array([0.2, 0.45]), scattering=scattering, phases=phases)
    rings, ring = np.unique(ZENITH, return_inverse=True)
    found = by_order(solve_layers(layers, albedo, SUN, rings, n_listed=3), AZIMUTH)[0]
    return found[:, ring, np.arange(ring.size)]


def pulls(albedo):
    """(n_paths - successive orders) in standard errors: order 2, order 3 and all orders."""
    layers = [Layer(tau_rayleigh=0.2), Layer(tau_rayleigh=0.1, tau_hg=0.3, g=0.7, omega_hg=0.9, tau_absorber=0.05)]
    found, exact = solved(atmospheres.plane_parallel(layers, albedo=0.3), 40_000), flat_orders(albedo)
    orders = (found.radiance_by_order[0, 1:3] - exact[1:3]) / found.standard_error_by_order[0, 1:3]
    return np.array([*orders, (found.radiance[0] - exact.sum(axis=0)) / found.standard_error[0]])


def test_flat_layers():
    off = pulls(0.3)
    assert np.abs(off).max() < 4.5
    assert np.mean(off**2) < 2.0
    assert np.abs(pulls(0.4)).max() > 8.0


def drawn_angles(phase, xi):
    """Places of angles that the paths draw with these uniform numbers, and their weights."""
    from aomc_sky.kernels.jit import shared
    from aomc_sky.skies.atmosphere.kernels.shells import draw_angle, find_cell

    @shared
    def draw(phases, guide, x):
        return draw_angle(phases, 0, find_cell(phases, guide, 0, x), x)

    tables = path_tables(atmospheres.uniform(0.1, phase=phase))
    return np.array([draw(tables.phases[0], tables.guides[0], x) for x in xi])


@pytest.mark.parametrize("g", [-0.5, 0.9, 0.999])
def test_drawn_angles_follow_the_phase_function(g):
    """Weights have mean 1, and the first two moments are those of Henyey and Greenstein."""
    drawn = drawn_angles(henyey_greenstein_phase(g), (np.arange(4000) + 0.5) / 4000)
    mu = 1.0 - 2.0 * drawn[:, 0] ** 4
    assert drawn[:, 1].mean() == pytest.approx(1.0, abs=2e-5)
    assert np.mean(mu * drawn[:, 1]) == pytest.approx(g, abs=2e-4)
    assert np.mean(mu**2 * drawn[:, 1]) == pytest.approx((1 + 2 * g * g) / 3, abs=4e-4)


def test_error_bars_are_the_spread():
    """Over 40 seeds; chi-square of 200 values within 4.5 of its own standard deviations."""
    medium = molecules_only(450.0, 0.2)
    tables = path_tables(medium)
    runs = [solved(medium, 2000, seed=seed, tables=tables) for seed in range(40)]
    values = np.array([run.radiance[0] for run in runs])
    bars = np.array([run.standard_error[0] for run in runs])
    ratio = values.var(axis=0, ddof=1).mean() / (bars**2).mean()
    assert 1 - 4.5 * np.sqrt(2 / 195) * 1.5 < ratio < 1 + 4.5 * np.sqrt(2 / 195) * 1.5


def test_threads_splits_and_neighbours_change_nothing():
    two, one = full([450.0, 550.0], 0.2), full(550.0, 0.2)
    whole, again = solved(two, 3000), solved(two, 3000, threads=3)
    np.testing.assert_array_equal(whole.radiance_by_order, again.radiance_by_order)
    np.testing.assert_array_equal(whole.standard_error, again.standard_error)
    some = {"sky_zenith_rad": ZENITH[3:], "azimuth_from_sun_rad": AZIMUTH[3:]}
    part = solved(two, 3000, **some)
    np.testing.assert_array_equal(part.radiance_by_order[:, 1:], whole.radiance_by_order[:, 1:, 3:])
    alone = solved(one, 3000, **some)  # its tables have other nodes: they follow the extinction of all wavelengths
    np.testing.assert_allclose(alone.radiance[0], whole.radiance[1, 3:], rtol=1e-4)
    assert np.all(np.abs(solved(one, 3000, seed=6, **some).radiance / alone.radiance - 1.0) > 1e-4)


def test_under_sampled_where_few_paths_make_the_variance():
    """Weights of a normal law are trusted, a single path with a quarter of the variance is not."""
    light = np.abs(np.random.default_rng(1).normal(size=4000))
    for extra, is_flagged in ((0.0, False), (np.sqrt(0.3 * np.sum(light**2)), True)):
        x = np.append(light, extra)
        totals = np.array([[[np.sum(x), np.sum(x**2), np.sum(x**4)]]])
        result = paths_result(np.ones((1, 1)), np.zeros((1, 1, 2, 2)), totals, x.size)
        assert result.under_sampled.tolist() == [[is_flagged]]
    assert paths_result(np.ones((1, 1)), np.zeros((1, 1, 2, 2)), np.zeros((1, 1, 3)), 4000).under_sampled.all()


def against_many_paths(medium, tables, rng, sun_deg, n_directions, n_seeds):
    """Deviations of 4096 paths from 32 times as many, in standard errors, and the flags: (n_seeds, 1, n_directions)."""
    asked = {
        "sun_zenith_rad": np.radians(sun_deg), "sky_zenith_rad": np.radians(rng.uniform(0, 89, n_directions)),
        "azimuth_from_sun_rad": rng.uniform(0, 2 * np.pi, n_directions), "tables": tables, "threads": 2,
    }  # fmt: skip
    many = solved(medium, 2**17, seed=1000, **asked)
    results = [solved(medium, 4096, seed=seed, **asked) for seed in range(n_seeds)]
    off = [(one.radiance - many.radiance) / np.hypot(one.standard_error, many.standard_error) for one in results]
    return np.array(off), np.array([one.under_sampled for one in results])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("medium", "suns", "n_directions", "n_seeds", "seed", "most"),
    [
        (full(550.0), (85.0, 94.0, 96.0), 12, 24, 3, 0.01),
        (full(320.0, ozone_m2=3e-24), (83.0, 86.0, 88.0), 60, 8, 6, 0.02),
    ],
    ids=["twilight", "ozone and a low sun"],
)
def test_what_is_not_flagged_can_be_trusted(medium, suns, n_directions, n_seeds, seed, most):
    """At 320 nm the sun lights the air through ever more ozone: from 83 to 88 degrees 0 to 56 % are flagged."""
    tables, rng, trusted, flagged, shares = path_tables(medium), np.random.default_rng(seed), [], [], []
    for sun in suns:
        off, is_flagged = against_many_paths(medium, tables, rng, sun, n_directions, n_seeds)
        trusted.append(off[~is_flagged])
        flagged.append(off[is_flagged])
        shares.append(is_flagged.mean())
    off = np.concatenate(trusted)
    assert abs(np.mean(off**2) - 1) < 0.2
    assert np.mean(np.abs(off) > 3) < most
    if seed == 3:
        assert shares[0] < 0.02
        assert np.mean(np.concatenate(flagged) ** 2) > 1.5
    else:
        assert shares[0] < 0.02 < shares[1] < shares[2] < 0.8


def test_orders_add_up_and_a_moon_of_the_suns_size_darkens_all():
    medium = molecules_only(400.0, 0.5)
    tables = path_tables(medium)
    many, four = solved(medium, 3000, tables=tables), solved(medium, 3000, n_orders=4, tables=tables)
    assert many.radiance_by_order.shape == (1, 24, ZENITH.size)
    np.testing.assert_array_equal(many.radiance_by_order[:, :4], four.radiance_by_order)
    np.testing.assert_allclose(many.radiance_by_order.sum(axis=1), many.radiance)
    medium = dataclasses.replace(molecules_only(550.0, 0.1), sun_angular_radius_rad=SUN_RADIUS)
    assert not solved(medium, 2000, visible=Moon(zenith_rad=SUN, distance_m=3.65e8, radius_m=1e8)).radiance.any()


def test_glow_of_the_ground_once_scattered():
    """Isotropic flat layer: L = int exp(-t/mu)/mu E2(t)/2 dt over the optical height t."""
    tau = 0.5
    slab = atmospheres.uniform(tau, phase=atmospheres.isotropic_phase, earth_radius_m=1e12, top_m=100.0)
    dark = dataclasses.replace(slab, toa_irradiance=np.zeros(1))
    result = solved(dark, 40_000, ground_radiance=[2.0], n_orders=3)
    for k, mu in enumerate(np.cos(ZENITH)):
        exact = quad(lambda t, mu=mu: np.exp(-t / mu) / mu * expn(2, t), 0, tau)[0]
        assert abs(result.radiance_by_order[0, 0, k] - exact) < 4.5 * result.standard_error_by_order[0, 0, k]
        assert result.standard_error_by_order[0, 0, k] < 0.01 * exact


@pytest.mark.parametrize(
    "bad",
    [
        {"ground_radiance": [-1.0]}, {"ground_radiance": [1.0, 1.0]}, {"sun_zenith_rad": 4.0},
        {"sky_zenith_rad": np.full(5, 2.0)}, {"azimuth_from_sun_rad": np.zeros(4)},
    ],
)  # fmt: skip
def test_bad_numbers(bad):
    with pytest.raises(UsageError):
        solved(molecules_only(550.0), **{"n_paths": 100, **bad})


RINGS = np.radians([10.0, 40.0, 65.0])


def test_modes_are_those_of_successive_orders():
    medium, sun = molecules_only(450.0, 0.2), np.radians(40.0)
    paths = path_orders(medium, sun, RINGS, 6, n_listed=6)
    exact = solve_orders(medium, sun, RINGS, 6, n_listed=6)
    assert paths.modes.shape[:2] == exact.modes.shape[:2] == (1, 5)
    np.testing.assert_allclose(paths.modes[:, :3, 0], exact.modes[:, :3, 0], rtol=0.05)
    assert 0.0 < paths.resolution_error < 0.03
    assert paths.truncation == pytest.approx(exact.truncation, rel=0.5)


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
def test_as_many_paths_as_asked_for():
    """No more of them where the error is large, and half the error for four times as many."""
    medium, sun = molecules_only(450.0, 0.2), np.radians(40.0)
    few, more = (path_orders(medium, sun, RINGS[:1], 4, n_listed=4, n_paths=n) for n in (64, 4096))
    assert few.n_paths == 64
    assert few.resolution_error > 0.05
    assert few.resolution_error / more.resolution_error == pytest.approx(8.0, rel=0.25)
    assert solve_sky(medium, sun_zenith_rad=sun, method="mc", n_orders=3, n_paths=8).n_paths == 8
    with pytest.raises(UsageError, match="whole number from 8 to"):
        solve_sky(medium, sun_zenith_rad=sun, method="mc", n_paths=7)


def test_roulette_leaves_paths_of_thin_air_alone():
    found = solved(molecules_only(2500.0, 1.0), 20_000, n_orders=10, ground_radiance=[1.0])
    share = found.standard_error[0] / found.radiance[0]
    assert share.max() < 1.5 / np.sqrt(20_000)


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
def test_errors_and_shares_of_all_light():
    """It was 0 % where more than half of the directions had no light, below the warning of 95 % at a higher sun."""
    medium = molecules_only(450.0)
    errors = [path_orders(medium, np.radians(z), RINGS, 4, n_listed=4, n_paths=16).resolution_error for z in (92, 97)]
    assert 0.5 < errors[0] <= errors[1] == 1.0
    dark = dataclasses.replace(medium, toa_irradiance=np.zeros(1))
    assert path_orders(dark, np.radians(92), RINGS, 4, n_listed=4, n_paths=16).resolution_error == 0.0
    # Under the Moon's shadow order 2 is far above order 1: the share that was stated was 61.
    sun = np.radians(40.0)
    medium = dataclasses.replace(molecules_only(450.0), sun_angular_radius_rad=4.65e-3)
    moon = Moon(zenith_rad=sun, distance_m=3.6e8)
    paths = path_orders(medium, sun, RINGS, 2, n_listed=2, n_paths=512, moon=moon)
    assert paths.modes[0, 0, 0].max() > 0.0
    assert 0.4 < paths.truncation[0] < 1.0


def test_a_far_moon_changes_nothing():
    medium = dataclasses.replace(molecules_only(550.0, 0.1), sun_angular_radius_rad=SUN_RADIUS)
    away = Moon(zenith_rad=0.0, azimuth_from_sun_rad=0.0, distance_m=3.65e8)
    free, same = solved(medium, 2000), solved(medium, 2000, visible=away)
    np.testing.assert_array_equal(free.radiance_by_order[:, 1:], same.radiance_by_order[:, 1:])
    np.testing.assert_allclose(free.radiance_by_order[:, 0], same.radiance_by_order[:, 0], rtol=2e-6)
