"""Multinomial counts: error of the acceptance of the binomial, its law, the joint law, and cells next to 1."""

import itertools
import math

import mpmath
import numba
import numpy as np
import pytest
from scipy.special import bdtr

from aomc_sky.kernels import allocate as kernels
from aomc_sky.kernels.jit import shared
from aomc_sky.plan.allocation import AllocationMethod, allocate_bands
from tests.support.chi2 import chi2_p


@shared
def log_ratio(n, k, mode, p):
    return kernels._log_ratio(n, k, mode, *kernels._mode_constants(n, p, mode))


@shared
def stirling_rest(k):
    return kernels._stirling_rest(k)


JIT = not numba.config.DISABLE_JIT
LEVEL = 1e-8


def rows(mass, n, n_bands, seed=0):
    bands = range(n_bands)
    return allocate_bands(mass, [n] * n_bands, bands, method=AllocationMethod.MULTINOMIAL, seed=seed)


def exact_log_ratio(n, p, k, mode):
    n, p, k, mode = (mpmath.mpf(x) for x in (n, p, k, mode))
    g = mpmath.loggamma
    return g(mode + 1) + g(n - mode + 1) - g(k + 1) - g(n - k + 1) + (k - mode) * (mpmath.log(p) - mpmath.log1p(-p))


@pytest.mark.parametrize(("n", "bound"), [(2**53, 1e-6), (10**12, 1e-8), (10**9, 1e-10), (1000, 1e-11), (25, 1e-11)])
def test_acceptance_is_as_exact_as_stated(n, bound):
    with mpmath.workdps(60):
        for p in {0.5, 0.4, max(0.4, 10.0 / n), max(1e-3, 10.5 / n), 10.5 / n}:
            mode = math.floor((n + 1.0) * p)
            spread = math.sqrt(n * p * (1 - p))
            for step in np.linspace(-6, 6, 49).tolist():
                k = min(max(round(mode + step * spread), 0), n)
                found = log_ratio(*map(np.float64, (n, k, mode, p)))
                assert abs(found - exact_log_ratio(n, p, k, mode)) < bound


def test_what_stirling_leaves():
    with mpmath.workdps(40):
        for k in (*range(40), 100, 12_345, 10**9, 2**53):
            x = mpmath.mpf(k) + 1
            exact = mpmath.loggamma(x) - ((x - 0.5) * mpmath.log(x) - x + mpmath.log(2 * mpmath.pi) / 2)
            assert abs(stirling_rest(np.float64(k)) - exact) < 1e-11


def joint_probability(counts, p):
    ways = math.factorial(sum(counts)) // math.prod(math.factorial(c) for c in counts)
    return ways * math.prod(q**c for q, c in zip(p, counts, strict=True))


def joint_level(sample, p):
    """Two-sided chi-square of whole rows against the multinomial law, rare rows together (`pool`)."""
    n = int(sample[0].sum())
    cases = [c for c in itertools.product(range(n + 1), repeat=len(p)) if sum(c) == n]
    expected = np.array([joint_probability(c, p) for c in cases]) * len(sample)
    found = {tuple(row): int(times) for row, times in zip(*np.unique(sample, axis=0, return_counts=True), strict=True)}
    observed = np.array([found.get(c, 0) for c in cases], dtype=float)
    order = np.argsort(-expected)
    return chi2_p(observed[order], expected[order])


@pytest.mark.skipif(not JIT, reason="long without the JIT")
def test_joint_law_of_three_cells_and_planted_defects():
    p, n, n_rows = [0.5, 0.2, 0.3], 6, 40_000
    assert joint_level(rows(p, n, n_rows), p) > LEVEL
    assert joint_level(rows([0.51, 0.19, 0.3], n, n_rows), p) < LEVEL
    assert joint_level(allocate_bands(p, [n] * 4000, range(4000)), p) < LEVEL  # far too even


@pytest.mark.parametrize("units", [2791, 10_445])
def test_what_misses_a_cell_next_to_one(units):
    """2^53 photons, all but a few on one cell: a Poisson law whose mean 1 - p in float64 would not hold."""
    n, n_rows = 2**53, 20_000 if JIT else 200
    cumulative = np.array([0, 2**62 - units, 2**62], dtype=np.uint64)
    missed = np.empty(n_rows)
    counts = np.empty(2, dtype=np.int64)
    for band in range(n_rows):
        kernels.multinomial_counts(cumulative, n, np.uint64(77), np.uint64(band), counts)
        assert int(counts[0]) + int(counts[1]) == n
        missed[band] = counts[1]
    mean = units / 2**9
    error = math.sqrt(mean / n_rows)
    assert abs(missed.mean() - mean) < 6 * error
    assert abs(missed.var() - mean) < 6 * mean * math.sqrt((2 + 1 / mean) / n_rows)
    if JIT:
        naive = n * (1.0 - float(2**62 - units) / 2.0**62)
        assert abs(naive - mean) > 12 * error


def test_cells_draw_from_addresses_of_their_own():
    """The first cell of the same mass and band draws the same, whatever follows it."""
    for n in (12, 5000):
        first = rows([1.0, 1.0, 2.0], n, 50)[:, 0]
        np.testing.assert_array_equal(first, rows([1.0, 3.0], n, 50)[:, 0])
        np.testing.assert_array_equal(first, rows([1.0, 0.0, 0.5, 0.5, 2.0], n, 50)[:, 0])


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
    assert chi2_p(counts, expected) > LEVEL


@pytest.mark.skipif(not JIT, reason="long without the JIT")
@pytest.mark.parametrize("n", [10**12, 2**53])
def test_huge_binomials_have_the_right_mean_and_variance(n):
    p = 0.25
    pull = (draws(n, p, 20_000) - n * p) / np.sqrt(n * p * (1 - p))
    assert abs(pull.mean()) < 5 / np.sqrt(pull.size)
    assert abs(pull.var() - 1) < 5 * np.sqrt(2 / pull.size)
    assert abs((pull**4).mean() - 3) < 5 * np.sqrt(96 / pull.size)
