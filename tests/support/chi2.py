"""Tests of goodness of fit: each returns a p-value or a statistic, and none draws a random number."""

import numpy as np
from scipy.special import gammainc, gammaincc, ndtr
from scipy.stats import binom, kstwo

MIN_EXPECTED = 20.0


def two_sided(lower, upper):
    return float(min(1.0, 2.0 * min(lower, upper)))


def pool(observed, expected, least=MIN_EXPECTED):
    """Neighbouring cells together until each group expects `least`; what is left joins the last group.

    Cells of expectation zero must be empty: photons there are a defect that no p-value should soften.
    """
    observed, expected = np.ravel(observed).astype(np.float64), np.ravel(expected).astype(np.float64)
    if np.any(observed[expected == 0] != 0):
        raise AssertionError("photons in a cell that expects none")
    groups = []
    o = e = 0.0
    for oi, ei in zip(observed.tolist(), expected.tolist(), strict=True):
        o, e = o + oi, e + ei
        if e >= least:
            groups.append([o, e])
            o = e = 0.0
    if groups:
        groups[-1][0] += o
        groups[-1][1] += e
    pooled = np.array(groups).reshape(-1, 2)
    return pooled[:, 0], pooled[:, 1]


def chi2_statistic(observed, expected):
    return float(np.sum((observed - expected) ** 2 / expected))


def statistic_p(statistic, degrees):
    """Two-sided p-value of a chi-square, or of a sum of independent ones, of so many degrees of freedom."""
    return two_sided(gammainc(degrees / 2, statistic / 2), gammaincc(degrees / 2, statistic / 2))


def chi2_p(observed, expected):
    """Two-sided p-value of counts whose total is fixed; cells are pooled first."""
    observed, expected = pool(observed, expected)
    if observed.size < 2:
        raise AssertionError("fewer than two cells are left after pooling: nothing would be tested")
    return statistic_p(chi2_statistic(observed, expected), observed.size - 1)


def upper_p(observed, expected):
    """Chance of so large a chi-square: photons that fill cells evenly have p near 1, which is no defect."""
    observed, expected = pool(observed, expected)
    return float(gammaincc((observed.size - 1) / 2, chi2_statistic(observed, expected) / 2))


def homogeneity_p(first, second):
    """Two-sided p-value that two histograms come from one law, their totals fixed."""
    n, m = first.sum(), second.sum()
    together = first + second
    expected = np.stack([together * n / (n + m), together * m / (n + m)])
    statistic = chi2_statistic(np.stack([first, second])[:, together > 0], expected[:, together > 0])
    return statistic_p(statistic, np.count_nonzero(together) - 1)


def per_degree(observed, expected, least=1000.0):
    """Chi-square per degree of freedom of low-discrepancy photons, on cells of at least `least` photons.

    Chance gives 1; points that fill cells evenly stay far below, and a defect of 1 % lifts them.
    """
    observed, expected = np.ravel(observed), np.ravel(expected)
    if expected.size < 2 or expected.min() < least:
        raise AssertionError(f"every cell must expect at least {least} photons")
    return chi2_statistic(observed, expected) / (expected.size - 1)


def ks_p(sample):
    """Two-sided p-value (both too far and too close) that a sample is uniform on [0, 1)."""
    x = np.sort(np.asarray(sample, dtype=np.float64))
    if x[0] < 0 or x[-1] > 1:
        return 0.0
    grid = np.arange(x.size + 1) / x.size
    distance = max((grid[1:] - x).max(), (x - grid[:-1]).max())
    return two_sided(kstwo.cdf(distance, x.size), kstwo.sf(distance, x.size))


def binomial_p(k, n, p):
    """Two-sided p-value of k successes in n trials."""
    return two_sided(binom.cdf(k, n, p), binom.sf(k - 1, n, p))


def mean_p(sample, mean, variance=None):
    """Two-sided p-value of a sample's mean by the normal law; variance known, or the sample's own."""
    sample = np.asarray(sample, dtype=np.float64)
    spread = sample.var(ddof=1) if variance is None else variance
    if spread == 0:
        return float(sample.mean() == mean)
    return float(2 * ndtr(-abs(sample.mean() - mean) / np.sqrt(spread / sample.size)))
