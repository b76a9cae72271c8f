"""Rayleigh and Henyey-Greenstein scattering angles: two million draws against probabilities with 50 digits."""

import numpy as np
import pytest
from mpmath import mp, mpf

import aomc_sky as sky
from tests.reference import phase_exact as exact
from tests.support import chi2

N = 2_000_000
FEWER = N // 4
"""In cells of unequal width, which take numpy ten times as long; enough for the planted defects."""
BINS = 60
GAMMAS = [0.0, 0.0144, 0.5, 1 - 2.0**-20]
GS = [0.0, 1e-6, 5e-4, 0.7, -0.85, 0.99999]
KINDS = [np.float64, np.float32]


def draws(kind, seed, n=N):
    return np.random.default_rng(seed).random(n, dtype=kind)


def probabilities(cdf, mu_edges, parameter):
    with mp.workdps(exact.DIGITS):
        return np.array([float(p) for p in np.diff([cdf(mu, parameter) for mu in mu_edges])])


def mu_p(mu, cdf, parameter):
    edges = np.linspace(-1, 1, BINS + 1)
    assert abs(mu).max() <= 1
    expected = probabilities(cdf, [mpf(e) for e in edges], parameter) * mu.size
    return chi2.chi2_p(np.histogram(mu.astype(float), BINS, (-1, 1))[0], expected)


def drop_p(v, g):
    """p-value of 1 - mu in cells that grow by equal factors from the peak, its mirror image for a negative g."""
    h = abs(g)
    a = v.astype(float) if g >= 0 else 2.0 - v.astype(float)
    edges = np.concatenate([[0.0], np.geomspace((1 - h) ** 2 / 100, 2.0, BINS)])
    with mp.workdps(exact.DIGITS):
        expected = probabilities(exact.hg_cdf, [1 - mpf(e) for e in edges[::-1]], h)[::-1] * v.size
    return chi2.chi2_p(np.histogram(a, bins=edges)[0], expected)


def sine_p(sine, g):
    """p-value of sines, which come from both sides of 90 degrees, in cells that grow by equal factors."""
    edges = np.concatenate([[0.0], np.geomspace((1 - abs(g)) / 10, 1.0, BINS)])
    with mp.workdps(exact.DIGITS):
        cosines = [mp.sqrt(1 - mpf(e) ** 2) for e in edges]
        below = [1 - exact.hg_cdf(c, g) + exact.hg_cdf(-c, g) for c in cosines]
        expected = np.array([float(p) for p in np.diff(below)]) * sine.size
    return chi2.chi2_p(np.histogram(sine.astype(float), bins=edges)[0], expected)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("gamma", GAMMAS)
def test_rayleigh(plan, gamma, kind):
    mu, one_minus_mu, _ = sky.rayleigh.sample_mu_sin(draws(kind, 21), gamma)
    assert mu.dtype == kind
    plan.check(mu_p(mu, exact.rayleigh_cdf, gamma))
    plan.check(mu_p(1 - one_minus_mu, exact.rayleigh_cdf, gamma))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("g", GS)
def test_henyey_greenstein(plan, g, kind):
    g = float(kind(g))
    mu, one_minus_mu, sine = sky.henyey_greenstein.sample_mu_sin(draws(kind, 22), kind(g))
    assert mu.dtype == kind
    plan.check(mu_p(mu, exact.hg_cdf, g))
    plan.check(drop_p(one_minus_mu[:FEWER], g))
    plan.check(sine_p(sine[:FEWER], g))


HALF = 40_000_000
SMALL_G = 9e-4


def forward_p(sampler):
    """p-value of the number of cosines above 0 among forty million: what a small g changes first."""
    n_forward = 0
    for seed in range(40):
        n_forward += int(np.count_nonzero(sampler(draws(np.float64, 100 + seed, HALF // 40)) >= 0))
    with mp.workdps(exact.DIGITS):
        forward = float(1 - exact.hg_cdf(mpf(0), SMALL_G))
    return chi2.binomial_p(n_forward, HALF, forward)


def test_small_g(plan):
    plan.check(forward_p(lambda xi: sky.henyey_greenstein.sample_mu(xi, SMALL_G)))


def test_isotropic_switch_is_caught(plan_only):
    """2 xi - 1 for |g| < 1e-3, which many codes have."""
    plan_only.catches(forward_p(lambda xi: 2 * xi - 1))


def textbook(xi, g):
    one, two = xi.dtype.type(1), xi.dtype.type(2)
    f = (one - g * g) / (one - g + two * g * xi)
    return (one + g * g - f * f) / (two * g)


def test_textbook_in_single_precision_is_caught(plan_only):
    def p_of(kind, g):
        return mu_p(np.clip(textbook(draws(kind, 22, FEWER), g), -1, 1), exact.hg_cdf, float(g))

    plan_only.catches(p_of(np.float32, np.float32(1e-6)))
    assert p_of(np.float64, 0.7) >= plan_only.level  # the textbook itself is sound


@pytest.mark.parametrize("g", [np.float32(0.99999), np.float64(1 - 1e-8)])
def test_sine_from_the_cosine_is_caught(plan_only, g):
    mu, _, sine = sky.henyey_greenstein.sample_mu_sin(draws(type(g), 22, FEWER), g)
    plan_only.catches(sine_p(np.sqrt(1 - mu * mu), float(g)))
    assert sine_p(sine, float(g)) >= plan_only.level


def test_wrong_anisotropy_is_caught(plan_only):
    """The classical 3/8 (1 + mu^2) where air's gamma is meant."""
    mu = sky.rayleigh.sample_mu(draws(np.float64, 21), 0.0)
    plan_only.catches(mu_p(mu, exact.rayleigh_cdf, 0.0144))
