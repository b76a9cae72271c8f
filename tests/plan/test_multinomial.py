"""Multinomial counts: exact sums, binomial margins, and a planted defect that the test catches."""

import numba
import numpy as np
import pytest
from scipy.special import bdtr, chdtr, chdtrc

from aomc_sky.kernels import allocate as kernels

JIT = not numba.config.DISABLE_JIT
LEVEL = 1e-7


def two_sided(counts, expected):
    keep = expected > 0
    chi2 = float(((counts[keep] - expected[keep]) ** 2 / expected[keep]).sum())
    degrees = int(keep.sum()) - 1
    return min(1.0, 2 * min(chdtr(degrees, chi2), chdtrc(degrees, chi2)))


def draws(n, p, n_draws):
    """First cell of a two-cell multinomial over many keys: a binomial."""
    cumulative = np.array([0, int(p * 2**62), 2**62], dtype=np.uint64)
    counts = np.empty(2, dtype=np.int64)
    out = np.empty(n_draws, dtype=np.int64)
    for k in range(n_draws):
        kernels.multinomial_counts(cumulative, n, np.uint64(k * 7919 + 13), np.uint64(0), counts)
        out[k] = counts[0]
    return out


@pytest.mark.skipif(not JIT, reason="long without the JIT")
@pytest.mark.parametrize(("n", "p"), [(10, 0.3), (50, 0.01), (40, 0.5), (1000, 0.02), (10**6, 0.3), (300, 0.97)])
def test_binomial_distribution(n, p):
    """Inversion below n p = 10, transformed rejection above, both ends flipped: bins of equal probability."""
    sample = draws(n, p, 20_000)
    values = np.arange(int(sample.min()), int(sample.max()) + 1)
    cdf = bdtr(values, n, p)
    edges = np.unique(np.searchsorted(cdf, np.linspace(0, 1, 25)[1:-1]))
    bins = np.concatenate([[-1], values[np.minimum(edges, values.size - 1)], [n]])
    bins = np.unique(bins)
    expected = np.diff([0.0 if b < 0 else float(bdtr(b, n, p)) for b in bins]) * sample.size
    counts = np.diff([np.count_nonzero(sample <= b) for b in bins])
    keep = expected > 20
    assert two_sided(counts[keep], expected[keep]) > LEVEL


@pytest.mark.skipif(not JIT, reason="long without the JIT")
@pytest.mark.parametrize("n", [10**12, 2**53])
def test_huge_binomials_have_the_right_mean_and_variance(n):
    p = 0.25
    pull = (draws(n, p, 20_000) - n * p) / np.sqrt(n * p * (1 - p))
    assert abs(pull.mean()) < 5 / np.sqrt(pull.size)
    assert abs(pull.var() - 1) < 5 * np.sqrt(2 / pull.size)
    assert abs((pull**4).mean() - 3) < 5 * np.sqrt(96 / pull.size)
