"""The phase functions at their hard points against 50-digit arithmetic from the definitions alone."""

import numpy as np
import pytest
from mpmath import mp, mpf

import aomc_sky as sky
from tests.reference import phase_exact as exact

R, H = sky.rayleigh, sky.henyey_greenstein
GAMMAS = [0.0, 1e-12, 0.0144, 0.5, 1 - 2.0**-24, 1 - 1e-10, 1 - 2.0**-53, 1.0]
GS = [0.0, 1e-300, 1e-8, 0.3, 0.9, 0.99999, 1 - 2.0**-24, 1 - 1e-14, 1 - 2.0**-53]
HALF = [0.5 - 2.0**-25, 0.5 - 2.0**-54, 0.5, 0.5 + 2.0**-53, 0.5 + 2.0**-24]  # and its neighbours in both precisions
XIS = [0.0, 1e-30, 2.0**-53, 0.01, 0.3, *HALF, 0.77, 0.999, 1 - 2.0**-24, 1 - 2.0**-53, 1.0]


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(exact.DIGITS):
        yield


def pairs(parameters, kind):
    """Every parameter with every xi, in one precision; parameters that round to 1 stay away from HG."""
    with np.errstate(under="ignore"):
        found = [(kind(p), kind(x)) for p in parameters for x in XIS]
    return [np.array(column, dtype=kind) for column in zip(*found, strict=True)]


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_rayleigh_inverse(kind):
    gamma, xi = pairs(GAMMAS, kind)
    mu, one_minus_mu, sine = R.sample_mu_sin(xi, gamma)
    for g, x, m, v, s in zip(gamma, xi, mu, one_minus_mu, sine, strict=True):
        true = exact.inverse(exact.rayleigh_cdf, float(x), float(g))
        assert exact.ulps(m, true) <= 3
        assert exact.ulps(v, 1 - true) <= 5
        assert exact.ulps(s, mp.sqrt((1 - true) * (1 + true))) <= 4
    assert np.all(mu[xi == 0] == -1)
    assert np.all(mu[xi == 1] == 1)
    assert np.all(mu[xi == 0.5] == 0)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_hg_inverse(kind, sign):
    g, xi = pairs([g for g in GS if kind(g) < 1], kind)
    mu, one_minus_mu, sine = H.sample_mu_sin(xi, sign * g)
    for h, x, m, v, s in zip(g, xi, mu, one_minus_mu, sine, strict=True):
        with mp.workdps(3 * exact.DIGITS):
            q = mpf(float(x)) if sign > 0 else 1 - mpf(float(x))
            h = mpf(float(h))
            D = 1 - h + 2 * h * q
            # the textbook's inverse, with digits to spare for its cancellation
            true = 2 * q - 1 if h < 1e-100 else (1 + h**2 - ((1 - h**2) / D) ** 2) / (2 * h)
            small = sign * true
            v_true, w_true = 1 - small, 1 + small
        unit = float(np.finfo(kind).eps) / 2**-52
        assert float(abs(mpf(float(m)) - small)) <= 2e-16 * unit or exact.ulps(m, small) <= 5
        assert exact.ulps(v, v_true) <= 5
        assert exact.ulps(s, mp.sqrt(v_true * w_true)) <= 5


@pytest.mark.parametrize("parameter", [0.0, 0.5, 1 - 2.0**-53])
def test_smallest_number_of_all(parameter):
    for law in (R, H):
        assert law.sample_mu(1.0, parameter) == 1
        mu, one_minus_mu, sine = law.sample_mu_sin(5e-324, parameter)
        assert mu == -1
        assert one_minus_mu == 2
        assert 0 <= sine < 1e-145


@pytest.mark.parametrize("sign", [1, -1])
def test_hg_density_and_tails(sign):
    places = [0.0, 1e-30, 2.0**-53, 1e-8, 0.3, 1.0, 1.5, 2 - 2.0**-52, 2.0]
    for g in GS:
        for v in places:
            with mp.workdps(3 * exact.DIGITS):
                below = exact.hg_cdf(1 - mpf(v), sign * g) if g > 1e-100 else 1 - mpf(v) / 2
                density = exact.hg_pdf_sr(1 - mpf(v), sign * g)
                above = 1 - below
            assert exact.ulps(H.pdf_sr(v, sign * g), density) <= 5
            for found, true in ((H.cdf(v, sign * g), below), (H.survival(v, sign * g), above)):
                assert found == 0 if abs(true) < 1e-60 else exact.ulps(found, true) <= 5
    assert H.survival(2.0, sign * np.linspace(0.0, 0.99, 9999)).max() == 1  # a probability


def test_rayleigh_density_cdf_and_moments():
    for gamma in GAMMAS:
        for mu in (-1.0, -1 + 2.0**-53, -0.7, -1e-20, 0.0, 0.3, 1.0):
            assert exact.ulps(R.pdf_mu(mu, gamma), exact.rayleigh_pdf(mu, gamma)) <= 3
            assert exact.ulps(R.pdf_sr(mu, gamma), exact.rayleigh_pdf(mu, gamma) / (2 * mp.pi)) <= 4
            assert exact.ulps(R.cdf_mu(mu, gamma), exact.rayleigh_cdf(mu, gamma)) <= 4
    assert R.cdf_mu(1.0, np.linspace(0.0, 1.0, 9999)).max() == 1
    node, weight = np.polynomial.legendre.leggauss(8)
    for gamma in (0.0, 0.0144, 0.6, 1.0):
        p = R.pdf_mu(node, gamma) * weight
        assert np.isclose(p.sum(), 1, rtol=1e-14)
        assert np.isclose((p * node**2).sum(), R.mean_mu2(gamma), rtol=1e-14)
    gamma = np.linspace(0, 0.74, 100)
    assert np.allclose(R.gamma_from_rho(R.rho_from_gamma(gamma)), gamma, rtol=1e-15, atol=1e-16)
    rho = R.rho_from_gamma(gamma)
    assert np.allclose(R.king_factor(gamma), (6 + 3 * rho) / (6 - 7 * rho), rtol=1e-13)
    assert np.allclose(R.gamma_from_king_factor(R.king_factor(gamma)), gamma, rtol=1e-13, atol=1e-15)


def test_air_table():
    """Counts and sums added up by hand from the printed table."""
    assert len(R.WAVELENGTH_NM) == len(R.RHO_MILLI_PERCENT) == 36
    assert sum(R.WAVELENGTH_NM) == 15645
    assert sum(R.RHO_MILLI_PERCENT) == 116446
    assert R.air_depolarisation(550.0) == 0.02842
    assert R.air_depolarisation(475.0) == pytest.approx((0.02899 + 0.02842) / 2, rel=1e-15)
    assert R.air_gamma(550.0) == pytest.approx(0.02842 / (2 - 0.02842), rel=1e-15)
    nm, rho = np.array(R.WAVELENGTH_NM), np.array(R.RHO_MILLI_PERCENT)
    left_out = [np.interp(nm[k], np.delete(nm, k), np.delete(rho, k)) / rho[k] - 1 for k in range(1, 35)]
    assert np.abs(left_out).max() < 0.011
