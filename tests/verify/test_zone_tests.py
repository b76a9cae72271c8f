"""The scores of photons of a sampler's mistakes: their expectations and variances from first principles."""

import math

import numpy as np
import pytest
import scipy.stats

import aomc_sky as sky
from aomc_sky.verify.zone_tests import share_checks, share_score, thinned
from aomc_sky.verify.zones import ZoneShares

ZONES = sky.PatchGrid(
    zenith_bounds_deg=np.array([[0.0, 30.0], [30.0, 50.0], [50.0, 65.0], [65.0, 90.0]]),
    azimuth_bounds_deg=np.array([[0.0, 120.0], [120.0, 360.0]]),
)
WIDTHS = np.array([30.0, 20.0, 15.0, 25.0]) / 90
RINGS = np.array([0.5, 0.1, 0.3, 0.1])
EXPECTED = 1e5 * np.outer(RINGS, [0.4, 0.6]).ravel()


FLUX = ZONES.projected_solid_angle_sr / np.pi
OTHERS = {"uniform": np.outer(WIDTHS, [1 / 3, 2 / 3]).ravel(), "lambert": FLUX}
"""Shares of the photons of each mistake in the zones, in the order of the checks."""


def own_variance(expected):
    return lambda score: float(score**2 @ expected)


def checks_of(observed, expected):
    return share_checks(ZONES, observed, expected, own_variance(expected), 1)


def uniform_score(expected):
    return share_score(np.outer([30.0, 20.0, 15.0, 25.0], [1, 2]).ravel(), expected, np.arange(8) // 2)


def mixed(share, mistake="uniform"):
    """Expected counts with a share of photons of a mistake."""
    return (1 - share) * EXPECTED + share * 1e5 * OTHERS[mistake]


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, -0.02])
@pytest.mark.parametrize("mistake", OTHERS)
def test_the_share_is_found(mistake, share):
    check = checks_of(mixed(share, mistake), EXPECTED)[list(OTHERS).index(mistake)]
    assert check.found == pytest.approx(share, abs=1e-14)


def test_too_few_photons_of_a_mistake_are_as_odd_as_too_many():
    more, fewer = (checks_of(mixed(share), EXPECTED)[0] for share in (0.01, -0.01))
    assert fewer.p_value == pytest.approx(more.p_value, rel=1e-9)
    assert fewer.p_value < 0.05


def test_the_variance_is_that_of_the_multinomial_law():
    score, difference = uniform_score(EXPECTED)
    covariance = 1e5 * (np.diag(RINGS) - np.outer(RINGS, RINGS))
    per_ring = score[::2]
    assert np.array_equal(per_ring, score[1::2])
    variance = float(per_ring @ covariance @ per_ring)
    assert per_ring == pytest.approx(WIDTHS / RINGS - 1, rel=1e-13)
    assert difference == pytest.approx(float(np.sum(WIDTHS**2 / RINGS)) - 1, rel=1e-13)
    pull = 0.01 * 1e5 * difference / math.sqrt(variance)
    assert checks_of(mixed(0.01), EXPECTED)[0].p_value == pytest.approx(math.erfc(pull / math.sqrt(2)), rel=1e-10)


def test_rings_that_expect_little_are_put_together_and_dark_ones_take_no_part():
    expected = np.outer([900.0, 99_000.0, 600.0, 700.0], [0.5, 0.5]).ravel()
    score, _ = uniform_score(expected)
    assert score[0] == score[4] == score[6] != score[2]
    assert score[4] == pytest.approx(70 / 90 / (2200 / expected.sum()) - 1)
    expected = np.outer([50_000.0, 0.0, 40_000.0, 10_000.0], [0.5, 0.5]).ravel()
    score, _ = uniform_score(expected)
    assert score[2] == score[3] == 0
    assert score[0] == pytest.approx(30 / 70 / 0.5 - 1)


def test_a_sky_of_the_law_of_the_mistake_is_not_tested_for_it():
    expected = 1e5 * np.outer(WIDTHS, [0.5, 0.5]).ravel()
    assert not uniform_score(expected)[0].any()
    assert checks_of(expected, expected)[0].p_value is None
    assert checks_of(EXPECTED / 100, EXPECTED / 100)[0].p_value is None
    uniform, lambert = checks_of(1e5 * FLUX, 1e5 * FLUX)
    assert uniform.p_value is not None
    assert lambert.p_value is None


def test_free_positions_of_a_plan():
    """Only cells that reach over several zones add variance: n q (1 - q) times the square of the difference.

    Cell 0 lies in zones 0 and 2, cell 1 in zone 5 alone, cell 2 in all of ring 3.
    """
    cells, zones = np.array([0, 0, 1, 2, 2]), np.array([0, 2, 5, 6, 7])
    shares = ZoneShares(cell=cells, zone=zones, share=np.array([0.25, 0.75, 1.0, 0.5, 0.5]), n_zones=8)
    per_cell, values = np.array([20_000.0, 30_000.0, 50_000.0]), np.arange(8.0) ** 2
    wanted = 20_000 * 0.25 * 0.75 * (values[2] - values[0]) ** 2 + 50_000 * 0.25 * (values[7] - values[6]) ** 2
    assert shares.variance(per_cell, values) == pytest.approx(wanted, rel=1e-14)


def test_sums_of_weights():
    """Weights of 2 are as half as many photons of weight 1."""
    alone = checks_of(mixed(0.01), EXPECTED)[0]
    heavy = share_checks(ZONES, 2 * mixed(0.01), 2 * EXPECTED, own_variance(4 * EXPECTED), 1, photons_per_unit=0.5)[0]
    assert heavy.found == pytest.approx(0.01, rel=1e-10)
    assert heavy.p_value == pytest.approx(alone.p_value, rel=1e-10)
    few = share_checks(ZONES, EXPECTED, EXPECTED, own_variance(EXPECTED), 1, photons_per_unit=1e-3)
    assert [check.p_value for check in few] == [None, None]


def test_cells_that_cut_patches_may_spread_by_their_loose_variance_too():
    expected = np.full(64, 2000.0)
    kept = expected / 2 + 1.8 * np.sqrt(expected / 4) * np.tile([-1.0, 1.0], 32)
    alone, with_loose = (thinned(kept, expected, loose, "x", 1).p_value for loose in (0 * expected, expected))
    # statistic 1.8^2 x 64 = 207, half of it with loose variance as large as the expectation
    assert alone == pytest.approx(2 * scipy.stats.chi2.sf(207.36, 64), rel=1e-9)
    assert with_loose == pytest.approx(2 * scipy.stats.chi2.sf(103.68, 64), rel=1e-9)
