"""Masses of patches by adaptive quadrature, against closed forms, and what linear light in patches costs."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import KDTree

import aomc_sky as sky
from aomc_sky.component import MAX_SLOPE
from aomc_sky.skies import patch_integrals
from aomc_sky.skies.jumps import jumps
from aomc_sky.skies.patch_integrals import SURE_SPOT, integrate_patches
from aomc_sky.skies.quadrature import POINTS

GRIDS = [(1, 1), (9, 4), (90, 360)]


def ring_masses(grid, antiderivative):
    """Masses of a radiance of the zenith angle alone; the antiderivative is that of L cos sin."""
    edges = np.deg2rad(grid.zenith_bounds_deg)
    width = np.deg2rad(np.diff(grid.azimuth_bounds_deg, axis=1))[:, 0]
    return np.outer(antiderivative(edges[:, 1]) - antiderivative(edges[:, 0]), width).ravel()


@pytest.mark.parametrize("shape", GRIDS)
@pytest.mark.parametrize(
    ("radiance", "antiderivative"),
    [
        (lambda z: 1 + 2 * np.cos(z) ** 2, lambda z: -(np.cos(z) ** 2) / 2 - np.cos(z) ** 4 / 2),
        (np.cos, lambda z: -(np.cos(z) ** 3) / 3),
        (lambda z: z, lambda z: np.sin(2 * z) / 8 - z * np.cos(2 * z) / 4),
        (lambda z: 1 / (np.cos(z) + 0.01), lambda z: -np.cos(z) + 0.01 * np.log(np.cos(z) + 0.01)),
    ],
    ids=["1 + 2 cos^2", "cos", "angle", "bright horizon"],
)
def test_smooth_radiances(shape, radiance, antiderivative):
    """Every mass to 1e-10 of the total, all together too, and the stated error covers it."""
    grid = sky.PatchGrid.regular(*shape)
    result = integrate_patches(lambda z, a: radiance(z), grid)
    exact = ring_masses(grid, antiderivative)
    off = np.abs(result.mass - exact).sum() / exact.sum()
    assert off < 1e-12
    assert off <= result.error + 1e-13
    assert result.error < 1e-10


@pytest.mark.parametrize("shape", GRIDS)
def test_constants_and_jumps(shape):
    grid = sky.PatchGrid.regular(*shape)
    result = integrate_patches(lambda z, a: np.full(z.shape, 0.3), grid)
    np.testing.assert_array_equal(result.mass, 0.3 * grid.projected_solid_angle_sr)
    assert not result.slope.any()
    assert (result.error, *result[3:]) == (0.0, 0.0, 0.0, 0.0)
    # A step in azimuth and one in zenith angle, neither at an edge of a patch.
    grid = sky.PatchGrid.regular(*shape)
    in_azimuth = integrate_patches(lambda z, a: (a < 1.0) + 0.0, grid)
    assert abs(in_azimuth.mass.sum() / 0.5 - 1) < 1e-10
    in_zenith = integrate_patches(lambda z, a: (z < 1.0) + 0.0, grid)
    assert abs(in_zenith.mass.sum() / (np.pi * np.sin(1.0) ** 2) - 1) < 1e-10
    assert max(in_azimuth.error, in_zenith.error) < 1e-9


def wedges(seed, n=16):
    """A sky of n wedges between meridians and parallels on light that varies slowly, and its integral."""
    rng = np.random.default_rng(seed)
    many = [
        (*rng.uniform((0, 0.05), (6.28, 1)), *np.sort(rng.uniform(0, np.pi / 2, 2)), rng.uniform(0.1, 3))
        for _ in range(n)
    ]

    def light(z, a):
        total = 0.1 + np.cos(z) ** 2 + 0 * a
        for start, width, top, bottom, height in many:
            total = total + height * ((np.mod(a - start, 2 * np.pi) < width) & (z >= top) & (z < bottom))
        return total

    flux = (h * width * (np.sin(bottom) ** 2 - np.sin(top) ** 2) / 2 for _, width, top, bottom, h in many)
    return light, 0.6 * np.pi + sum(flux)


@pytest.mark.parametrize("shape", [(9, 36), pytest.param((30, 120), marks=pytest.mark.slow)])
def test_meridians_and_parallels_of_jumps_are_found(shape, monkeypatch):
    """Corners and margins that no point of the rule sees: 0.3.0 was off by 1.3e-4, and claimed 1e-13."""
    grid = sky.PatchGrid.regular(*shape)
    for seed in range(3 if shape == (9, 36) else 1):
        light, exact = wedges(seed)
        result = integrate_patches(light, grid)
        assert abs(result.mass.sum() / exact - 1) < 1e-13
        assert result.error < 1e-9
    monkeypatch.setattr(patch_integrals, "jumps", lambda *_: (np.zeros(0), np.zeros(0)))
    light, exact = wedges(0)
    assert abs(integrate_patches(light, grid).mass.sum() / exact - 1) > 1e-7


def test_what_patches_cost():
    """The whole dome as one patch, lit over a share p of its azimuths: 1 - p - t p (1 - p) at the steepest slope -t."""
    result = integrate_patches(lambda z, a: (a < 1.0) + 0.0, sky.PatchGrid.regular(1, 1))
    p = 1 / (2 * np.pi)
    assert result.slope.tolist() == [[0.0, -MAX_SLOPE]]
    assert abs(result.variation - (1 - p - MAX_SLOPE * p * (1 - p))) < 1e-8
    assert result.ring_variation < result.column_variation
    edges = np.array([[0.0, 1.0]]), np.array([[0.0, 4.0]])
    found = [jumps(lambda x, y: (y < 0.7) + 0.0 * x, *edges, most)[1].tolist() for most in (10**6, 0)]
    assert found == [[pytest.approx(0.7)], []]
    # L = mu: what is left of a smooth radiance falls with the square of the rings.
    values = [integrate_patches(lambda z, a: np.cos(z), sky.PatchGrid.regular(n, 1)) for n in (30, 60)]
    assert abs(values[0].variation / values[1].variation - 4) < 0.15
    assert values[1].column_variation < 1e-15
    # by hand, one patch: the density 1.5 sqrt(w) of w = mu^2 has the mean 0.6, so the law is 0.4 + 1.2 w
    one = integrate_patches(lambda z, a: np.cos(z), sky.PatchGrid.regular(1, 1))
    np.testing.assert_allclose(one.slope, [[-0.6, 0.0]], atol=1e-8)
    left = quad(lambda w: abs(1.5 * np.sqrt(w) - 0.4 - 1.2 * w), 0, 1, limit=200)[0] / 2
    assert abs(one.variation - left) < 0.05 * left


def test_what_never_settles_ends_with_its_error(monkeypatch):
    """A disc's edge runs through no grid: quadrature ends at its limit of parts, and says how far it came."""
    monkeypatch.setattr(patch_integrals, "_MAX_PARTS", 2000)

    def disc(z, a):
        cosine = np.sin(z) * np.sin(0.7) * np.cos(a - 2.0) + np.cos(z) * np.cos(0.7)
        return (cosine > np.cos(0.2)) + 0.0

    result = integrate_patches(disc, sky.PatchGrid.regular(9, 36))
    exact = np.pi * np.sin(0.2) ** 2 * np.cos(0.7)  # of a disc above the horizon: pi sin^2 r cos z
    assert 1e-10 < abs(result.mass.sum() / exact - 1) <= result.error < 0.05


def spot(zenith, azimuth, width_deg, share):
    """Radiance 1 and a disc with a share of the light."""
    middle = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])
    radius = np.deg2rad(width_deg) / 2
    bright = share / (1 - share) / (np.sin(radius) ** 2 * np.cos(zenith))

    def radiance(z, a):
        x, y = np.sin(z) * np.cos(a) - middle[0], np.sin(z) * np.sin(a) - middle[1]
        return 1 + bright * (x * x + y * y + (np.cos(z) - middle[2]) ** 2 <= (2 * np.sin(radius / 2)) ** 2)

    return radiance


def emptiest(*orders):
    """The place in a patch that is farthest from the points of these orders, and how far it is."""
    nodes = (POINTS[order].nodes for order in orders)
    points = np.concatenate([np.array(np.meshgrid(x, x)).reshape(2, -1).T for x in nodes])
    around = np.concatenate([points + np.array([i, j]) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    asked = np.array(np.meshgrid(*2 * [np.linspace(0, 1, 500)])).reshape(2, -1).T
    distance = KDTree(around).query(asked)[0]
    return asked[distance.argmax()], distance.max()


def test_spots_between_the_points_are_found(monkeypatch):
    """0.19 degrees and wider in patches of one degree, with 7 % of the light; the first look alone misses one."""
    monkeypatch.setattr(patch_integrals, "_MAX_PARTS", 2**10)
    rings, columns = ([[k, k + 1] for k in one] for one in (range(80, 86), range(70, 80)))
    grid = sky.PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)
    even = grid.projected_solid_angle_sr.sum()
    hidden = (*(np.array([83, 75]) + emptiest(4, 7)[0]), 0.2)
    places = [hidden, *np.random.default_rng(5).uniform([81, 71, 0.19], [85, 79, 0.5], (40, 3))]

    def found(zenith, azimuth, width):
        light = integrate_patches(spot(np.deg2rad(zenith), np.deg2rad(azimuth), width, 0.07), grid).mass.sum() / even
        return (light - 1) / (0.07 / 0.93 * np.pi / even)

    assert all(0.9 < found(*place) < 1.1 for place in places)
    monkeypatch.setattr(patch_integrals, "_SEEN", np.inf)
    assert found(*hidden) == 0
    assert SURE_SPOT - 0.006 < 2 * emptiest(4, 7, 8)[1] < SURE_SPOT


@pytest.mark.parametrize(
    ("zenith_deg", "azimuth_deg", "width_deg"), [(39.876, 147.546, 0.289), (25.841, 207.287, 0.351)]
)
def test_a_spot_that_reaches_into_a_neighbour_is_whole(zenith_deg, azimuth_deg, width_deg, monkeypatch):
    """The points of the neighbour lie beside the part of the spot: 3 and 2 % of its light were missing."""
    monkeypatch.setattr(patch_integrals, "_MAX_PARTS", 2**13)
    radiance = spot(*np.deg2rad([zenith_deg, azimuth_deg]), width_deg, 1 - 1e-9)
    edges = np.floor(zenith_deg) + np.arange(-2.0, 4.0), np.floor(azimuth_deg) + np.arange(-3.0, 5.0)
    rings, columns = (np.column_stack([ends[:-1], ends[1:]]) for ends in edges)
    grid = sky.PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=columns)
    exact = np.pi * (1e9 - 1)  # of a spot with all but 1e-9 of the light of a dome of radiance 1
    assert integrate_patches(radiance, grid).mass.sum() == pytest.approx(exact, rel=2e-3)
