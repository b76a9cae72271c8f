"""Counts over seeds: systematic rounding is fair, multinomial counts have their variance."""

import numpy as np

import aomc_sky as sky
from tests.support import chi2

SEEDS = 2000
MASS = np.random.default_rng(7).lognormal(0, 1, 12)
N = 1000


def rounded_up(method):
    """How often each cell got the ceiling, and the fraction that it should be."""
    share = N * MASS / MASS.sum()
    whole = np.floor(share)
    counts = np.array([sky.allocate(MASS, N, method=method, seed=seed) for seed in range(SEEDS)])
    return (counts - whole).sum(axis=0).astype(int), share - whole


def test_rounding_is_bernoulli(plan):
    ups, fraction = rounded_up("systematic")
    for k, p in zip(ups.tolist(), fraction.tolist(), strict=True):
        plan.check(chi2.binomial_p(k, SEEDS, p))
    fixed, _ = rounded_up("largest-remainder")  # the same every time
    plan.catches(min(chi2.binomial_p(int(k), SEEDS, float(p)) for k, p in zip(fixed, fraction, strict=True)))


def test_multinomial_is_multinomial(plan):
    """Sum of chi-squares over seeds: right mean and right variance; systematic counts are too even."""
    expected = N * MASS / MASS.sum()

    def p_value(method):
        counts = np.array([sky.allocate(MASS, N, method=method, seed=seed) for seed in range(500)])
        statistic = chi2.chi2_statistic(counts, np.broadcast_to(expected, counts.shape))
        return chi2.statistic_p(statistic, 500 * (MASS.size - 1))

    plan.check(p_value("multinomial"))
    plan.catches(p_value("systematic"))
