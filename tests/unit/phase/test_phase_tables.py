"""The reference tables: every row of the Rayleigh folder and of the two Henyey-Greenstein files."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from mpmath import mp, mpf

import aomc_sky as sky
from tests.support.shared import SHARED, needs_shared

pytestmark = needs_shared
R, H = sky.rayleigh, sky.henyey_greenstein
KINDS = [np.float64, np.float32]
MOMENTS = {
    "mean_mu2": R.mean_mu2,
    "mean_mu4": R.mean_mu4,
    "mean_abs_mu": R.mean_abs_mu,
    "legendre2": R.legendre2,
    "rho_n": R.rho_from_gamma,
    "max_degree_of_polarisation": R.max_polarisation,
}


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(50):
        yield


def columns(name):
    with (SHARED / name).open() as file:
        rows = list(csv.DictReader(file))
    return {key: [row[key] for row in rows] for key in rows[0]}


def floats(texts, kind):
    found = np.array(texts, dtype=np.float64)
    assert np.array_equal(found.astype(kind), found)
    return found.astype(kind)


def worst(found, exact):
    """Largest distance in ulp of the exact value. A column of zeros must be met exactly."""
    spacing = np.spacing(np.abs(np.array([float(e) for e in exact])).astype(found.dtype)).astype(np.float64)
    apart = [abs(mpf(float(f)) - mpf(e)) for f, e in zip(found, exact, strict=True)]
    return max(float(a / mpf(s)) for a, s in zip(apart, spacing, strict=True))


@pytest.mark.parametrize("kind", KINDS)
def test_rayleigh_inverse(kind):
    table = columns("rayleigh/inverse_cdf.csv")
    xi, gamma = floats(table["xi"], kind), floats(table["gamma"], kind)
    mu, one_minus_mu, sine = R.sample_mu_sin(xi, gamma)
    assert mu.dtype == one_minus_mu.dtype == sine.dtype == kind
    assert np.array_equal(mu, R.sample_mu(xi, gamma))
    assert worst(mu, table["mu"]) <= 2
    small = [s if x >= 0.5 else str(2 - mpf(s)) for s, x in zip(table["one_minus_abs_mu"], xi, strict=True)]
    assert worst(one_minus_mu, small) <= 3
    far = [mpf(s) for s in table["one_minus_abs_mu"]]
    assert worst(sine, [mp.sqrt(s * (2 - s)) for s in far]) <= 3


@pytest.mark.parametrize("kind", KINDS)
def test_rayleigh_density_and_cdf(kind):
    table = columns("rayleigh/pdf_cdf.csv")
    mu, gamma = floats(table["mu"], kind), floats(table["gamma"], kind)
    assert worst(R.pdf_mu(mu, gamma), table["pdf_mu"]) <= 2
    assert worst(2 * R.pdf_mu(mu, gamma), table["phase_function_4pi"]) <= 2
    assert worst(R.pdf_sr(mu, gamma), table["pdf_per_sr"]) <= 3
    assert worst(R.cdf_mu(mu, gamma), table["cdf"]) <= 2


@pytest.mark.parametrize("kind", KINDS)
def test_rayleigh_moments(kind):
    table = columns("rayleigh/moments.csv")
    gamma = floats(table["gamma"], kind)
    for name, function in MOMENTS.items():
        assert worst(function(gamma), table[name]) <= 2, name
    given = [k != "" for k in table["king_factor"]]
    assert worst(R.king_factor(gamma[given]), [k for k in table["king_factor"] if k]) <= 2


def test_rayleigh_bins():
    table = columns("rayleigh/bin_probabilities.csv")
    gamma = np.array(table["gamma"], dtype=float)
    low, high, exact = (np.array(table[key], dtype=float) for key in ("mu_lo", "mu_hi", "probability"))
    assert np.abs(R.cdf_mu(high, gamma) - R.cdf_mu(low, gamma) - exact).max() < 4e-16


def test_air():
    table = columns("rayleigh/air_depolarisation.csv")
    nm = np.round(1000 * np.array(table["wavelength_um"], dtype=float))
    assert np.array_equal(
        R.air_depolarisation(nm), np.array([float(mpf(rho) / 100) for rho in table["rho_n_percent_table"]])
    )
    gamma = R.air_gamma(nm)
    # the column has 20 digits
    assert worst(gamma, table["gamma_table"]) <= 2
    assert worst(R.king_factor(gamma), table["king_factor_table"]) <= 2
    assert worst(R.mean_mu2(gamma), table["mean_mu2_table"]) <= 2
    formula = np.array(table["rho_n_percent_formula"], dtype=float) / 100
    assert np.abs(R.air_depolarisation(nm) / formula - 1).max() < 0.03
    fine = np.interp(np.arange(200, 1001), nm, formula)
    assert np.abs(R.air_depolarisation(np.arange(200, 1001)) / fine - 1).max() < 0.03


@pytest.mark.parametrize("kind", KINDS)
def test_hg_inverse(kind):
    table = columns("lobes/hg_inverse_cdf.csv")
    xi, g = floats(table["xi"], kind), floats(table["g"], kind)
    mu, one_minus_mu, sine = H.sample_mu_sin(xi, g)
    assert worst(one_minus_mu, table["one_minus_mu"]) <= 3
    assert worst(sine, table["sin_theta"]) <= 3
    apart = np.array([float(abs(mpf(float(f)) - mpf(e))) for f, e in zip(mu, table["mu"], strict=True)])
    exact = np.array(table["mu"], dtype=float)
    unit = float(np.finfo(kind).eps) / 2**-52
    assert np.all(apart <= np.maximum(2e-16 * unit, 5 * np.spacing(np.abs(exact).astype(kind)).astype(float)))
    assert np.array_equal(mu, H.sample_mu(xi, g))


@pytest.mark.parametrize("kind", KINDS)
def test_hg_inverse_mirrored(kind):
    """A negative g is the mirror image: 1 - mu of -g at 1 - xi is 1 + mu of g at xi, where 1 - xi is exact."""
    table = columns("lobes/hg_inverse_cdf.csv")
    xi, g = floats(table["xi"], kind), floats(table["g"], kind)
    exact = np.nonzero((1 - (1 - xi) == xi) & ((1 - xi) + xi == 1))[0]
    assert exact.size > 200
    _, one_minus_mu, sine = H.sample_mu_sin(1 - xi[exact], -g[exact])
    assert worst(one_minus_mu, [table["one_plus_mu"][k] for k in exact]) <= 3
    assert worst(sine, [table["sin_theta"][k] for k in exact]) <= 3


@pytest.mark.parametrize("kind", KINDS)
def test_hg_density_and_tails(kind):
    table = columns("lobes/hg_pdf_cdf.csv")
    v, g = floats(table["one_minus_mu"], kind), floats(table["g"], kind)
    assert worst(H.pdf_sr(v, g), table["pdf_per_sr"]) <= 4
    assert worst(H.survival(v, g), table["prob_closer_to_axis"]) <= 4
    assert worst(H.cdf(v, g), table["prob_farther_from_axis"]) <= 4
