"""The score of photons that are uniform in zenith angle: its expectation and variance from first principles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.verify import uniform_share
from aomc_sky.verify.uniform_share import UniformScore
from aomc_sky.verify.zone_shares import ZoneShares

ZONES = sky.PatchGrid(
    zenith_bounds_deg=np.array([[0.0, 30.0], [30.0, 50.0], [50.0, 65.0], [65.0, 90.0]]),
    azimuth_bounds_deg=np.array([[0.0, 120.0], [120.0, 360.0]]),
)
WIDTHS = np.array([30.0, 20.0, 15.0, 25.0]) / 90
RINGS = np.array([0.5, 0.1, 0.3, 0.1])
EXPECTED = 1e5 * np.outer(RINGS, [0.4, 0.6]).ravel()


def mixed(share):
    """Expected counts with a share of photons uniform in zenith angle."""
    return (1 - share) * EXPECTED + share * 1e5 * np.outer(WIDTHS, [1 / 3, 2 / 3]).ravel()


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, -0.02])
def test_the_share_is_found(share):
    check = uniform_share.of_independent(ZONES, mixed(share), EXPECTED, 1)
    assert check.found == pytest.approx(share, abs=1e-14)


def test_the_variance_is_that_of_the_multinomial_law():
    score = UniformScore.of(ZONES, EXPECTED)
    covariance = 1e5 * (np.diag(RINGS) - np.outer(RINGS, RINGS))
    variance = float(score.per_ring @ covariance @ score.per_ring)
    assert score.per_ring == pytest.approx(WIDTHS / RINGS - 1, rel=1e-14)
    assert score.difference == pytest.approx(float(np.sum(WIDTHS**2 / RINGS)) - 1, rel=1e-13)
    check = uniform_share.of_independent(ZONES, mixed(0.01), EXPECTED, 1)
    pull = 0.01 * 1e5 * score.difference / math.sqrt(variance)
    assert check.p_value == pytest.approx(math.erfc(pull / math.sqrt(2)), rel=1e-10)


def test_rings_that_expect_little_are_put_together():
    expected = np.outer([900.0, 99_000.0, 600.0, 700.0], [0.5, 0.5]).ravel()
    score = UniformScore.of(ZONES, expected)
    assert score.per_ring[0] == score.per_ring[1] != score.per_ring[2] == score.per_ring[3]
    assert score.per_ring[2] == pytest.approx(40 / 90 / (1300 / expected.sum()) - 1)


def test_dark_rings_take_no_part():
    expected = np.outer([50_000.0, 0.0, 40_000.0, 10_000.0], [0.5, 0.5]).ravel()
    score = UniformScore.of(ZONES, expected)
    assert score.per_ring[1] == 0
    assert score.per_ring[0] == pytest.approx(30 / 70 / 0.5 - 1)


def test_a_sky_that_is_uniform_in_zenith_angle_is_not_tested():
    expected = 1e5 * np.outer(WIDTHS, [0.5, 0.5]).ravel()
    assert UniformScore.of(ZONES, expected) is None
    assert uniform_share.of_independent(ZONES, expected, expected, 1).p_value is None
    assert uniform_share.of_independent(ZONES, EXPECTED / 100, EXPECTED / 100, 1).p_value is None  # too few photons


def shares_of_two_cells():
    """Cell 0 lies in zones 0 and 2, cell 1 in zone 5 alone, cell 2 in all of ring 3."""
    return ZoneShares(
        cell=np.array([0, 0, 1, 2, 2]),
        zone=np.array([0, 2, 5, 6, 7]),
        share=np.array([0.25, 0.75, 1.0, 0.5, 0.5]),
        n_zones=8,
    )


def test_free_places_of_a_plan():
    """Only cells that reach over several rings add variance: n q (1 - q) times the square of the difference."""
    shares, of_cells = shares_of_two_cells(), np.array([20_000.0, 30_000.0, 50_000.0])
    values = np.arange(8.0) ** 2
    wanted = 20_000 * 0.25 * 0.75 * (values[2] - values[0]) ** 2 + 50_000 * 0.25 * (values[7] - values[6]) ** 2
    assert shares.variance(of_cells, values) == pytest.approx(wanted, rel=1e-14)
    zones = shares.expected(of_cells)
    score = UniformScore.of(ZONES, zones)
    a = score.of_zones(ZONES)
    free = 20_000 * 0.25 * 0.75 * (a[2] - a[0]) ** 2
    own = float(score.per_ring**2 @ score.expected)
    found = zones + np.array([500.0, 0, -500, 0, 0, 0, 0, 0])
    for check, variance in (
        (uniform_share.of_plan(ZONES, found, shares, of_cells, 1), 1.5 * free + 0.1 * own),
        (uniform_share.of_thinned(ZONES, found - zones / 2, shares, of_cells, 1), own / 4 + 1.5 * free / 4),
    ):
        pull = abs(500 * (a[0] - a[2])) / math.sqrt(variance)
        assert check.p_value == pytest.approx(math.erfc(pull / math.sqrt(2)), rel=1e-6)


def test_sums_of_weights():
    """Weights of 2 are as half as many photons of weight 1."""
    share = EXPECTED / EXPECTED.sum()
    heavy = uniform_share.of_weights(ZONES, mixed(0.01), 2 * mixed(0.01), share, 1)
    alone = uniform_share.of_weights(ZONES, mixed(0.01), mixed(0.01), share, 1)
    assert heavy.found == pytest.approx(0.01, rel=1e-10)
    assert float(heavy.detail.split()[-1]) == pytest.approx(math.sqrt(2) * float(alone.detail.split()[-1]), rel=0.05)
