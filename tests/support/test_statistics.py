"""The tools of the statistical tests: laws under the null, and agreement with numbers worked out otherwise."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import kolmogorov

from tests.support import chi2
from tests.support.plan import MOST_CASES, MOST_P_VALUES, StatisticalPlan


def uniform_distance(p_values):
    p = np.sort(p_values)
    n = p.size
    return kolmogorov(np.sqrt(n) * max((np.arange(1, n + 1) / n - p).max(), (p - np.arange(n) / n).max()))


def test_pooling_keeps_everything_and_reaches_the_least():
    rng = np.random.default_rng(1)
    expected = rng.lognormal(0, 2, 1000)
    observed = rng.poisson(expected)
    o, e = chi2.pool(observed, expected)
    assert o.sum() == observed.sum()
    assert e.sum() == pytest.approx(expected.sum())
    assert e.min() >= 20
    assert e[:-1].max() < 20 + expected.max()
    with pytest.raises(AssertionError, match="expects none"):
        chi2.pool(np.array([30, 1]), np.array([31.0, 0.0]))


def test_chi2_is_exact_for_two_degrees_of_freedom():
    observed, expected = np.array([120.0, 90, 90]), np.full(3, 100.0)
    upper = math.exp(-chi2.chi2_statistic(observed, expected) / 2)
    assert chi2.chi2_p(observed, expected) == pytest.approx(2 * min(upper, 1 - upper), rel=1e-12)
    with pytest.raises(AssertionError, match="nothing would be tested"):
        chi2.chi2_p(np.array([10, 12]), np.array([11.0, 11.0]))


def test_chi2_p_is_uniform_and_both_tails_reject():
    rng = np.random.default_rng(2)
    expected = np.full(40, 250.0)
    p = [chi2.chi2_p(rng.multinomial(10_000, expected / 10_000), expected) for _ in range(1000)]
    assert uniform_distance(np.array(p)) > 1e-6
    assert chi2.chi2_p(expected, expected) < 1e-12  # too even
    assert chi2.chi2_p(expected * np.where(np.arange(40) % 2, 1.2, 0.8), expected) < 1e-12


def test_homogeneity_is_uniform():
    rng = np.random.default_rng(3)
    p = rng.dirichlet(np.full(20, 5.0))
    found = [chi2.homogeneity_p(rng.multinomial(8000, p), rng.multinomial(20_000, p)) for _ in range(1000)]
    assert uniform_distance(np.array(found)) > 1e-6
    assert chi2.homogeneity_p(rng.multinomial(8000, p), rng.multinomial(8000, p[::-1])) < 1e-12


def test_ks_is_uniform_and_two_sided():
    rng = np.random.default_rng(4)
    p = np.array([chi2.ks_p(rng.random(2000)) for _ in range(1000)])
    assert uniform_distance(p) > 1e-6
    assert chi2.ks_p(rng.random(10**5) ** 1.05) < 1e-9
    assert chi2.ks_p((np.arange(10**5) + 0.5) / 10**5) < 1e-9  # too even
    assert chi2.ks_p(rng.random(2000) * 2) == 0


def test_per_degree():
    assert chi2.per_degree(np.array([1000, 1000]), np.array([1000.0, 1000.0])) == 0
    assert chi2.per_degree(np.array([1100, 900]), np.array([1000.0, 1000.0])) == pytest.approx(20)
    with pytest.raises(AssertionError, match="1000"):
        chi2.per_degree(np.array([999, 999]), np.array([999.0, 999.0]))


def test_mean_p():
    sample = np.array([-1.0, 1.0] * 50)
    assert chi2.mean_p(sample, 0.0) == 1
    assert chi2.mean_p(sample + 0.196, 0.0, variance=1.0) == pytest.approx(0.05, abs=1e-4)
    assert chi2.mean_p(np.ones(5), 1.0) == 1
    assert chi2.mean_p(np.ones(5), 1.1) == 0


def test_the_plan_shares_the_level():
    assert 1 - (1 - StatisticalPlan.level) ** (MOST_CASES * MOST_P_VALUES) == pytest.approx(1e-6)
    plan = StatisticalPlan()
    for p_value in (1e-10, math.nan):
        with pytest.raises(AssertionError, match="below the level"):
            plan.check(p_value)
    plan.compared = MOST_P_VALUES
    with pytest.raises(AssertionError, match="more than 12 p-values"):
        plan.check(0.5)
    plan.catches(1e-10)
    with pytest.raises(AssertionError, match="not caught"):
        plan.catches(0.1)


def test_the_number_of_cases_is_bounded():
    from tests.statistical import conftest

    items = [SimpleNamespace(fixturenames=["plan"])] * MOST_CASES
    conftest.pytest_collection_modifyitems(items)
    with pytest.raises(pytest.UsageError, match="241 cases"):
        conftest.pytest_collection_modifyitems([*items, items[0]])
