"""The one rule of integrals over patches: its points, hard places against another quadrature, and planted defects."""

import dataclasses

import mpmath as mp
import numpy as np
import pytest

from aomc_sky.skies import quadrature
from aomc_sky.skies.quadrature import POINTS, Rule, points_of, weighted_sum

SKY = np.array([[0.0, 1.0]]), np.array([[0.0, 4.0]])


def test_points_are_gauss_points():
    with mp.workdps(40):
        for order, (nodes, weights, _) in POINTS.items():
            for node, weight in zip(nodes, weights, strict=True):
                root = mp.findroot(lambda t, n=order: mp.legendre(n, t), 2 * mp.mpf(float(node)) - 1)
                slope = mp.diff(lambda t, n=order: mp.legendre(n, t), root)
                assert abs((root + 1) / 2 - mp.mpf(float(node))) < 2e-16
                assert abs(1 / ((1 - root**2) * slope**2) - mp.mpf(float(weight))) < 1e-16
    for order, (nodes, _, highest) in POINTS.items():
        for degree in range(order - 1):
            assert abs(weighted_sum(nodes**degree, highest)) < 1e-15
        assert abs(weighted_sum(nodes ** (order - 1), highest)) > 1e-5


def double_exponential(light, x, y):
    """Integral over a rectangle by nodes that crowd at its sides: sharp corners and roots there do no harm."""
    t = np.arange(-3.4, 3.41, 0.04)
    e = np.exp(np.pi * np.sinh(t))
    share, weight = e / (1 + e), 0.04 * np.pi * np.cosh(t) * e / (1 + e) ** 2
    xs, ys = (low + (high - low) * share for low, high in (x, y))
    values = light(xs[:, None], ys[None, :])
    return float(np.sum(weight[:, None] * weight * values)) * (x[1] - x[0]) * (y[1] - y[0])


def cone(x, y, centre):
    """Distance to a point of the sky. [rad]"""
    xs, ys = x * np.pi / 2, (y - centre[1]) * np.pi / 2
    sun = centre[0] * np.pi / 2
    h = np.sin((xs - sun) / 2) ** 2 + np.sin(xs) * np.sin(sun) * np.sin(ys / 2) ** 2
    return 2 * np.arcsin(np.sqrt(h))


def rule_of(light, centre, **options):
    return Rule(integrand=lambda x, y, _: light(x[0] + centre[0], y[0] + centre[1]), centre=centre, **options)


@pytest.mark.parametrize("centre", [(0.4, 1.1), (0.9999, 3.7), (0.004, 0.3)])
@pytest.mark.parametrize("decay", [3.0, 300.0])
def test_a_cone_at_any_place(centre, decay):
    """Patches that hold the sun, touch it or are far away; the other quadrature ends at the sun in both angles."""

    def light(x, y):
        return np.sin(np.pi * x) * (1.0 + 20.0 * np.exp(-decay * cone(x, y, centre)))

    rule = rule_of(light, centre, width=2.5 / decay, cusp=20.0 * decay)
    x = np.unique([0.0, 0.3, 0.8, 1.0, *(np.clip(centre[0] + s, 0, 1) for s in (-0.02, 0.0, 0.02))])
    y = np.unique([0.0, 1.0, 4.0, *(np.mod(centre[1] + s, 4) for s in (-2.0, -0.02, 0.0, 0.02))])
    rings, columns = (np.stack([edges[:-1], edges[1:]], axis=1) for edges in (x, y))
    found = rule.integrate(rings, columns).masses(len(rings) * len(columns)).reshape(len(rings), -1)
    for i, ring in enumerate(rings):
        for j, column in enumerate(columns):
            assert found[i, j] == pytest.approx(double_exponential(light, ring, column), rel=1e-10)
    assert rule.integrate(*SKY).masses(1)[0] == pytest.approx(found.sum(), rel=1e-10)


def test_a_narrow_cone_is_not_seen_without_its_width():
    """Planted: a rule that trusts two orders which agree misses what stands between their points."""
    centre = (0.37, 1.3)
    rule = rule_of(lambda x, y: np.exp(-3000.0 * cone(x, y, centre)) + 1.0, centre, width=1e-3, cusp=3000.0)
    blind = dataclasses.replace(rule, width=np.inf, cusp=0.0)
    sines = np.sin(centre[0] * np.pi / 2)
    true = 4.0 + 2 * np.pi / 3000.0**2 / sines / (np.pi / 2) ** 2
    assert rule.integrate(*SKY).masses(1)[0] == pytest.approx(true, rel=1e-10)
    assert abs(blind.integrate(*SKY).masses(1)[0] / true - 1) > 1e-8


@pytest.mark.parametrize("centre", [(0.4, 1.1), (0.0, 0.0), (0.95, 3.9), (1.2, 0.5)])
@pytest.mark.parametrize("radius", [0.3, 1.0, 1.4])
def test_light_that_ends_at_a_circle(centre, radius):
    """Sum over fine patches, and the solid angle of the cap of a sphere where all of it is above the horizon."""
    circle = np.sin(radius / 2) ** 2

    def light(x, y):
        h = np.sin(cone(x, y, centre) / 2) ** 2
        return np.sin(x * np.pi / 2) * np.maximum(circle - h, 0.0)

    rule = rule_of(light, centre, circles=(float(circle),))
    coarse = rule.integrate(*SKY).masses(1)[0]
    edges = [np.linspace(0.0, end, n + 1) for end, n in ((1.0, 13), (4.0, 29))]
    rings, columns = (np.stack([e[:-1], e[1:]], axis=1) for e in edges)
    parts = rule.integrate(rings, columns).masses(13 * 29)
    assert parts.min() >= 0.0
    assert coarse == pytest.approx(parts.sum(), rel=1e-11)
    if radius + centre[0] * np.pi / 2 < np.pi / 2:
        true = 2 * np.pi * (np.cos(radius) ** 2 / 4 - np.cos(radius) / 2 + 0.25)
        assert coarse * (np.pi / 2) ** 2 == pytest.approx(true, rel=1e-11)


def test_sums_do_not_depend_on_how_many_tiles_there_are(monkeypatch):
    def values(x, y, _):
        return np.exp(-x) * np.cos(y)

    tiles = np.random.default_rng(2).random((4, 300))
    index = np.arange(300)
    both = values(*points_of(8, tiles), index)
    np.testing.assert_array_equal(both[..., 17:18], values(*points_of(8, tiles[:, 17:18]), index[17:18]))
    rule = rule_of(lambda x, y: np.exp(-3 * cone(x, y, (0.4, 1.1))), (0.4, 1.1), width=1.0, cusp=3.0)
    edges = np.linspace(0, 1, 8)
    rings = np.stack([edges[:-1], edges[1:]], axis=1)
    first = rule.integrate(rings, 4 * rings).masses(49)
    monkeypatch.setattr(quadrature, "_POINTS_AT_ONCE", 100)
    np.testing.assert_array_equal(rule.integrate(rings, 4 * rings).masses(49), first)
