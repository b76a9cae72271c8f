"""Successive orders of scattering against quadrature, reciprocity and themselves; the reference tables stand apart."""

import dataclasses
import itertools

import mpmath
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid

from aomc_sky.errors import SceneError
from aomc_sky.skies.atmosphere.optical_depth import optical_depth_to_top, vertical_optical_depth
from aomc_sky.skies.atmosphere.scattering_orders import diffuse
from aomc_sky.skies.atmosphere.scattering_orders.diffuse import ALL_ORDERS, source_functions, times_cosine
from aomc_sky.skies.atmosphere.scattering_orders.orders import legendre_table, phase_moments, split_table
from aomc_sky.skies.atmosphere.scattering_orders.paths import ShellPaths, node_paths
from aomc_sky.skies.atmosphere.scattering_orders.slab import altitude_grid, slabs_of_medium
from aomc_sky.skies.atmosphere.sky.solve import solve
from tests.support import atmospheres
from tests.support.plane_layers import Layers, by_order, later_orders, solve_flat, solve_layers

AZIMUTH = np.deg2rad([0.0, 40.0, 110.0, 180.0])


def rayleigh(cosine):
    return atmospheres.rayleigh_phase(cosine, 0)


def peaked(cosine):
    return atmospheres.henyey_greenstein_phase(0.6)(cosine, 0)


def one_layer(depth, albedo=1.0, phase=rayleigh):
    return Layers(optical_depth=np.array([depth]), scattering=np.array([[albedo]]), phases=(phase,))


def whole_radiance(sky):
    return by_order(sky, AZIMUTH).sum(axis=1)


def first_order(layers_depth, phase, mu0, depth, mu, cosine):
    """Radiance of order 1 inside a conservative homogeneous layer over a black ground; mu < 0 goes up."""
    with np.errstate(over="ignore"):
        down = mu0 / (mu0 - mu) * (np.exp(-depth / mu0) - np.exp(-depth / np.abs(mu)))
        lost = np.exp(-layers_depth / mu0 - (layers_depth - depth) / np.abs(mu))
        up = mu0 / (mu0 - mu) * (np.exp(-depth / mu0) - lost)
    return phase(cosine) * np.where(mu > 0.0, down, up)


def second_order(depth, phase, mu0, mu, azimuth):
    """Radiance of order 2 at the ground: three nested quadratures, none of which the solver uses."""
    x, w = np.polynomial.legendre.leggauss(40)
    t = 0.5 * (x + 1.0)
    inner_mu = np.concatenate([-(t**3), t**3])  # crowded at the horizon
    inner_weight = np.tile(0.5 * w * 3.0 * t**2, 2)
    turn = 2.0 * np.pi * np.arange(64) / 64
    sine = np.sqrt(1.0 - inner_mu**2)[:, None]
    from_sun = inner_mu[:, None] * mu0 + sine * np.sqrt(1.0 - mu0**2) * np.cos(turn)
    to_eye = inner_mu[:, None] * mu + sine * np.sqrt(1.0 - mu**2) * np.cos(turn - azimuth)
    z, zw = np.polynomial.legendre.leggauss(24)
    s = 0.5 * (z + 1.0)
    levels, level_weight = depth * s * s * (3.0 - 2.0 * s), depth * 6.0 * s * (1.0 - s) * 0.5 * zw
    total = 0.0
    for level, weight in zip(levels, level_weight, strict=True):
        light = first_order(depth, phase, mu0, level, np.broadcast_to(inner_mu[:, None], from_sun.shape), from_sun)
        source = np.sum(inner_weight[:, None] * light * phase(to_eye)) * (2.0 * np.pi / 64)
        total += weight * source * np.exp(-(depth - level) / mu) / mu
    return total


@pytest.mark.parametrize("phase", [rayleigh, peaked])
@pytest.mark.parametrize(("depth", "mu0"), [(0.1, 0.3), (0.8, 0.9)])
def test_order_two_by_nested_quadrature(phase, depth, mu0):
    mu = np.array([0.1, 0.5, 0.97])
    sky = solve_layers(one_layer(depth, phase=phase), 0.0, np.arccos(mu0), np.arccos(mu), n_orders=2, n_listed=2)
    found = by_order(sky, AZIMUTH)[0, 1]
    expected = [[second_order(depth, phase, mu0, m, a) for a in AZIMUTH] for m in mu]
    np.testing.assert_allclose(found, expected, rtol=2e-4)


@pytest.mark.parametrize("phase", [rayleigh, peaked])
def test_transmission_is_reciprocal(phase):
    """The mu-weighted radiance is symmetric in sun and eye; turned upside down where the layers differ."""
    layers = Layers(optical_depth=np.array([0.3, 0.1, 0.5]), scattering=np.array([[0.9, 0.4, 1.0]]), phases=(phase,))
    turned = Layers(optical_depth=layers.optical_depth[::-1], scattering=layers.scattering[:, ::-1], phases=(phase,))
    for one, two in itertools.combinations([0.15, 0.5, 0.9], 2):
        there = whole_radiance(solve_layers(layers, 0.0, np.arccos(one), np.arccos([two])))
        back = whole_radiance(solve_layers(turned, 0.0, np.arccos(two), np.arccos([one])))
        np.testing.assert_allclose(two * there, one * back, rtol=3e-5)


def ground_irradiance(sky):
    return sky.direct_irradiance + sky.irradiance_by_order.sum(axis=1)


@pytest.mark.parametrize(("depth", "albedo"), [(0.1, 0.0), (1.0, 0.8), (5.0, 1.0)])
def test_geometric_rest_is_what_more_orders_bring(depth, albedo):
    zenith = np.deg2rad([10.0, 80.0])
    summed = solve_layers(one_layer(depth), albedo, 0.8, zenith)
    counted = solve_layers(one_layer(depth), albedo, 0.8, zenith, n_orders=900)
    np.testing.assert_allclose(whole_radiance(summed), whole_radiance(counted), rtol=2e-6)
    assert summed.irradiance_by_order.sum() == pytest.approx(counted.irradiance_by_order.sum(), rel=1e-6)


def test_orders_stop_exactly_and_scale_with_the_sun():
    zenith = np.deg2rad([10.0, 80.0])
    every = solve_layers(one_layer(0.5), 0.3, 0.8, zenith, n_listed=6)
    first = solve_layers(one_layer(0.5), 0.3, 0.8, zenith, n_orders=4, n_listed=2)
    each = by_order(every, AZIMUTH)[0]
    np.testing.assert_allclose(whole_radiance(first)[0], each[:4].sum(axis=0), rtol=1e-10)
    np.testing.assert_allclose(first.irradiance_by_order[0].sum(), every.irradiance_by_order[0, :4].sum(), rtol=1e-10)
    assert np.all(each > 0.0)
    alone = solve_layers(one_layer(0.5), 0.3, 0.8, zenith, n_orders=1)
    np.testing.assert_array_equal(later_orders(alone.modes, AZIMUTH), 0.0)
    factor, zenith = np.array([2.0, 0.5]), np.deg2rad([30.0, 85.0])
    one = dataclasses.replace(atmospheres.molecules_only([400.0, 600.0], albedo=0.2), n_orders=ALL_ORDERS)
    two = dataclasses.replace(one, toa_irradiance=factor)
    first, second = (solve_flat(medium, 1.0, zenith, n_listed=2) for medium in (one, two))
    np.testing.assert_allclose(by_order(second, AZIMUTH), factor[:, None, None, None] * by_order(first, AZIMUTH))
    np.testing.assert_allclose(ground_irradiance(second), factor * ground_irradiance(first))


def test_resolution_error_covers_a_finer_solution(monkeypatch):
    medium = atmospheres.molecules_only(450.0, 0.2)
    zenith = np.array([0.2, 1.4])

    def found(n_directions):
        finer = dataclasses.replace(medium, least_angles=n_directions)
        return diffuse.summed_orders(finer, 0.7, zenith, medium.n_orders, n_listed=1)[0]

    np.testing.assert_array_equal(found(1600), found(0))  # 20 nodes are there in any case
    assert np.any(found(1601) != found(0))
    np.testing.assert_allclose(found(1601).sum(axis=1)[:, 0], found(0).sum(axis=1)[:, 0], rtol=1e-4)
    assert [diffuse.least_nodes(n) for n in (0, 2**31 - 1)] == [0, 64]
    zenith = np.deg2rad([20.0, 70.0, 88.8])
    sky = solve_layers(one_layer(0.4), 0.0, 1.2, zenith)
    fine = diffuse.Resolution(n_mu=48, n_element=24, n_moments=3)
    monkeypatch.setattr(diffuse, "choose_resolution", lambda *given: fine)
    truth = later_orders(solve_layers(one_layer(0.4), 0.0, 1.2, zenith).modes, AZIMUTH)
    assert 0.0 < np.max(np.abs(later_orders(sky.modes, AZIMUTH) / truth - 1.0)) < sky.resolution_error < 1e-3


@pytest.mark.parametrize("medium", [atmospheres.full([450.0]), atmospheres.uniform(0.5, top_m=1e6)])
def test_a_uniform_glow_shows_the_optical_depth_of_every_line(medium):
    """A source of 1 everywhere gives 1 - exp(-depth to the top), also past the lowest point of a line."""
    grid = altitude_grid(medium, 6)
    slab = slabs_of_medium(medium, grid, 0.5)[0]
    mu = np.array([0.003, 0.03, 0.3, 1.0])
    paths, view = ShellPaths(grid, mu, mu).weights(slab, grid.profile.extinction_m2[0])
    altitude = grid.node_m.ravel()
    rising = optical_depth_to_top(medium, altitude[:, None], np.arccos(mu))[0]
    np.testing.assert_allclose(paths.down.sum(axis=2).T, -np.expm1(-rising), rtol=1e-9)
    sinking = optical_depth_to_top(medium, altitude[:, None], np.pi - np.arccos(mu))[0]
    assert paths.over is not None
    seen = (paths.up + paths.over).sum(axis=2) + paths.from_ground
    misses = np.isfinite(sinking)
    assert 20 < misses.sum() < misses.size
    np.testing.assert_allclose(seen.T[misses], -np.expm1(-sinking[misses]), rtol=1e-8)
    np.testing.assert_allclose(seen.T[~misses], 1.0, rtol=1e-12)
    from_ground = optical_depth_to_top(medium, 0.0, np.arccos(mu))[0]
    np.testing.assert_allclose(view.sum(axis=1), -np.expm1(-from_ground), rtol=1e-9)


SUN = np.deg2rad(40.0)
ZENITH = np.deg2rad([0.0, 60.0, 90.0, 120.0, 180.0])
SOURCE_AZIMUTH = np.deg2rad([0.0, 90.0, 180.0])


@pytest.mark.parametrize("phase", [atmospheres.isotropic_phase, atmospheres.rayleigh_phase])
def test_thin_flat_air_above_a_bright_ground(phase):
    """Half of what the ground sends up, A F0 mu0 / pi, is scattered into every direction: its law is even in mu."""
    flat = {"scale_height_m": 40.0, "earth_radius_m": 1e14, "top_m": 100.0}
    medium = atmospheres.exponential(1e-5, albedo=0.6, phase=phase, **flat)
    found = source_functions(medium, SUN, ZENITH, SOURCE_AZIMUTH, n_orders=2)
    density = medium.constituents[0].number_density(found.altitude_m)
    extinction = medium.constituents[0].scattering_m2[0] * density
    expected = 0.5 * 0.6 / np.pi * np.cos(SUN) * extinction
    np.testing.assert_allclose(found.from_ground[0], np.repeat(expected[:, None], ZENITH.size, axis=1), rtol=2e-4)
    # order 2 has besides what the air itself sends, which is thinner still
    assert np.all(found.by_order[0, 0] >= found.from_ground[0][:, :, None] * (1 - 1e-9))


def test_light_of_the_ground_is_what_its_albedo_adds():
    with_ground, without = (
        source_functions(atmospheres.full([450.0, 700.0], albedo), SUN, ZENITH, SOURCE_AZIMUTH, n_orders=2)
        for albedo in (0.4, 0.0)
    )
    assert np.all(without.from_ground == 0.0)
    added = with_ground.by_order[:, 0] - without.by_order[:, 0]
    expected = np.broadcast_to(with_ground.from_ground[..., None], added.shape)
    np.testing.assert_allclose(added, expected, atol=1e-12 * with_ground.by_order[:, 0].max())


def test_radiance_overhead_is_the_integral_of_the_source():
    """L(zenith) = int S exp(-tau) dh, order by order, with another quadrature than the solver's."""
    medium = atmospheres.molecules_only(450.0, 0.3)
    found = source_functions(medium, SUN, ZENITH[:1], SOURCE_AZIMUTH[:1], n_orders=4)
    altitude = np.linspace(0.0, 90e3, 20001)
    gas = medium.constituents[0]
    extinction = gas.scattering_m2[0] * gas.number_density(altitude)
    depth = cumulative_trapezoid(extinction, altitude, initial=0.0)
    overhead = {"sun_zenith_rad": SUN, "sky_zenith_rad": [0.0], "azimuth_from_sun_rad": [0.0]}
    radiance = solve(medium, **overhead, method="sos", n_orders=4).radiance_by_order[0, :, 0, 0]
    for k in range(3):
        logarithm = np.interp(altitude, found.altitude_m[::-1], np.log(found.by_order[0, k, ::-1, 0, 0]))
        assert trapezoid(np.exp(logarithm - depth), altitude) == pytest.approx(radiance[k + 1], rel=2e-3)


def test_addition_theorem_at_high_degree():
    one, two, azimuth, n = 0.3, -0.8, 2.2, 150
    first, second = (legendre_table(np.array([x]), n, n)[:, :, 0] for x in (one, two))
    cosine = one * two + np.sqrt((1 - one**2) * (1 - two**2)) * np.cos(azimuth)
    terms = np.where(np.arange(n) == 0, 1.0, 2.0) * np.cos(np.arange(n) * azimuth)
    for degree in (0, 1, 60, 149):
        m = np.arange(degree + 1)
        found = np.sum(terms[m] * first[m, degree - m] * second[m, degree - m])
        assert found == pytest.approx(float(mpmath.legendre(degree, cosine)), abs=1e-12)


@pytest.mark.parametrize("n_moments", [1, 6, 7])
def test_both_parities_have_as_many_rows(n_moments):
    """An odd number of degrees is filled with zeros."""
    mu = np.array([0.2, 0.7])
    table = legendre_table(mu, n_moments, n_moments)
    even, odd = split_table(mu, n_moments, n_moments)
    assert even.shape == odd.shape == (n_moments, (n_moments + 1) // 2, 2)
    assert np.array_equal(even, table[:, 0::2])
    n_odd = n_moments // 2
    assert np.array_equal(odd[:, :n_odd], table[:, 1::2])
    assert not odd[:, n_odd:].any()


@pytest.mark.parametrize("n_modes", [1, 2, 5])
def test_a_cosine_series_times_the_cosine(n_modes):
    modes, azimuth = np.random.default_rng(2).random((n_modes, 3)), np.linspace(0.0, np.pi, 7)
    before, after = (np.cos(np.outer(azimuth, np.arange(n))) for n in (n_modes, n_modes + 1))
    wanted = np.cos(azimuth)[:, None] * (before @ modes)
    np.testing.assert_allclose(after @ times_cosine(modes), wanted, rtol=0.0, atol=1e-14)


def test_moments_of_phase_functions():
    sharp = phase_moments(lambda cosine: atmospheres.peaked_phase(cosine, 0), 4)
    assert sharp[0] == 1.0
    x = (np.arange(200_000) + 0.5) / 200_000
    cosine = 1.0 - 2.0 * x**4
    mean = np.mean(16.0 * np.pi * x**3 * cosine * atmospheres.peaked_phase(cosine, 0))
    assert sharp[1] == pytest.approx(mean, rel=1e-7)
    with pytest.raises(SceneError, match=r"integral 1\.1 over the sphere"):
        phase_moments(lambda cosine: np.full_like(cosine, 1.1 / (4.0 * np.pi)), 4)
    # A stair: its moments are differences of Legendre functions, x_l = 2 pi h (P_l-1 - P_l+1)(c) / (2 l + 1).
    at, low, high = np.array([-0.97, 0.3]), 0.01, 0.1
    last = (1.0 / (2.0 * np.pi) - low * (at[1] - at[0]) - high * (1.0 - at[1])) / (at[0] + 1.0)
    found = phase_moments(lambda c: np.where(c > at[1], high, np.where(c > at[0], low, last)), 40)
    for degree in range(1, 40):
        values = [np.polynomial.legendre.legval(at, np.eye(42)[degree + k]) for k in (-1, 1)]
        steps = np.array([low - last, high - low])
        expected = 2.0 * np.pi * steps @ (values[0] - values[1]) / (2 * degree + 1)
        np.testing.assert_allclose(found[degree], expected, rtol=0.0, atol=1e-9)


def test_a_line_that_turns_inside_an_element():
    """What arrives of sources 1 and s, from this side of the lowest point and from beyond it, in closed form."""
    share = np.array([[0.2, 0.4, 0.6, 0.8]])
    crossed, below = np.full((4, 1, 1), 0.7), np.array([[0.6], [0.4], [0.1], [0.0]])
    paths = node_paths(share, crossed, below, np.full((4, 1, 1), 0.65), np.full((4, 1), 10.0), np.array([[0.7]]))
    assert paths.over is not None
    np.testing.assert_allclose(paths.up.sum(axis=2)[0, :3], -np.expm1(-below[:3, 0]), rtol=1e-12)
    both = (paths.up + paths.over).sum(axis=2)[0, :3]
    np.testing.assert_allclose(both, -np.expm1(-(below[:3, 0] + 0.7)), rtol=1e-12)
    start, near = share[0, :3], below[:3, 0]
    from_here = start * -np.expm1(-near) + (0.65 - start) / near * (1 - (1 + near) * np.exp(-near))
    beyond = 0.65 * np.exp(-near) * (-np.expm1(-0.7) - (1 - 1.7 * np.exp(-0.7)) / 0.7)
    np.testing.assert_allclose((paths.up @ share[0])[0, :3], from_here, rtol=1e-11)
    np.testing.assert_allclose((paths.over @ share[0])[0, :3], beyond, rtol=1e-11)


@pytest.mark.parametrize("medium", [atmospheres.full([450.0, 600.0]), atmospheres.mol_ozone([550.0])])
def test_columns_of_a_medium(medium):
    sun = np.deg2rad(80.0)
    grid = altitude_grid(medium, 8)
    assert set(atmospheres.OZONE_KINKS_M) <= set(grid.edge_m)
    assert np.all(np.diff(grid.edge_m) < 0.0)
    for row, slab in enumerate(slabs_of_medium(medium, grid, sun)):
        assert slab.edge_depth[-1] == pytest.approx(vertical_optical_depth(medium)[row].sum(), rel=1e-9)
        assert np.all((slab.share > 0.0) & (slab.share < 1.0))
        share = slab.scattering.sum(axis=0)
        assert np.all((share > 0.0) & (share <= 1.0 + 1e-12))
        depth = optical_depth_to_top(medium, grid.node_m.ravel(), float(sun))[row]
        np.testing.assert_allclose(slab.beam.ravel(), np.exp(-depth), rtol=1e-12)


def test_a_wavelength_that_sees_nothing():
    both = atmospheres.medium_of([atmospheres.molecules(np.array([400.0, 500.0]))], [400.0, 500.0])
    both.constituents[0].scattering_m2[1] = 0.0
    seen, empty = slabs_of_medium(both, altitude_grid(both, 6), 0.3)
    assert np.all(np.diff(empty.edge_depth) > 0.0)
    assert empty.edge_depth[-1] < 1e-12 < seen.edge_depth[-1]
    assert np.all((empty.share > 0.0) & (empty.share < 1.0))


def test_elements_of_one_gas_are_those_of_any_of_its_wavelengths():
    def edges(*wavelength_nm):
        gas = atmospheres.molecules(np.array(wavelength_nm))
        return altitude_grid(atmospheres.medium_of([gas], wavelength_nm), 6).edge_m

    np.testing.assert_allclose(edges(400.0, 500.0, 700.0), edges(500.0), rtol=1e-9)


def test_a_direction_does_not_depend_on_its_company():
    many = np.deg2rad(np.linspace(0.0, 90.0, 19))
    together = later_orders(solve_layers(one_layer(0.3), 0.1, 0.4, many).modes, AZIMUTH)
    alone = later_orders(solve_layers(one_layer(0.3), 0.1, 0.4, many[[7]]).modes, AZIMUTH)
    np.testing.assert_allclose(alone[:, 0], together[:, 7], rtol=1e-12)


def test_paths_of_a_source_that_is_known():
    """J = t: the radiances have closed forms, upward and downward, at every node."""
    edges, mu = np.array([0.0, 0.1, 0.5, 0.6]), np.array([0.05, 0.7])
    share = np.tile([[0.08, 0.3, 0.7, 0.95]], (3, 1))
    nodes = edges[:-1, None] + np.diff(edges)[:, None] * share
    ground = np.diff(edges) / mu[:, None]
    crossed = np.tile(ground, (nodes.size, 1, 1))
    below = (edges[1:, None] - nodes).ravel()[:, None] / mu
    paths = node_paths(share, crossed, below, np.ones_like(crossed), np.full_like(below, -1.0), ground)
    depth, cosine = nodes.ravel(), mu[:, None]
    down = depth - cosine * -np.expm1(-depth / cosine)
    up = depth + cosine - (0.6 + cosine) * np.exp(-(0.6 - depth) / cosine)
    np.testing.assert_allclose(paths.down @ depth, down, rtol=1e-11)
    np.testing.assert_allclose(paths.up @ depth, up, rtol=1e-11)
    np.testing.assert_allclose(paths.from_ground, np.exp(-(0.6 - depth) / cosine), rtol=1e-12)
    np.testing.assert_allclose(paths.at_ground @ depth, 0.6 + mu * np.expm1(-0.6 / mu), rtol=1e-11)
    assert paths.over is None
