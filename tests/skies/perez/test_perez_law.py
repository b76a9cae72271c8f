"""The quadrature of the continuous Perez sky against closed forms, itself in other coordinates, and other programs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expn

from tests.reference import perez_law
from tests.reference.perez_law import PerezLaw
from tests.support.perez_cases import CASES
from tests.support.shared import REFERENCE

pytestmark = pytest.mark.slow  # the oracle itself, whose users are tested in every run

PEREZ = REFERENCE / "perez"


def law_of(coefficients, sun_zenith_deg):
    return PerezLaw(coefficients=coefficients, sun_zenith_rad=float(np.deg2rad(sun_zenith_deg)))


def one(x, y, mu):
    return np.ones_like(mu)


@pytest.mark.parametrize("sun_zenith_deg", [0, 8, 40, 82, 89.9])
def test_closed_forms(sun_zenith_deg):
    """Constant sky; e alone; a alone through E3; the aureole alone below the zenith."""
    z = np.deg2rad(sun_zenith_deg)
    flat = law_of((0.0, 0.0, 0.0, 0.0, 0.0), sun_zenith_deg)
    np.testing.assert_allclose(perez_law.flux_over_sky(flat, one), np.pi, rtol=1e-12)
    np.testing.assert_allclose(perez_law.mean(flat, lambda x, y, mu: mu), 2 / 3, rtol=1e-12)
    np.testing.assert_allclose(perez_law.mean(flat, lambda x, y, mu: mu * mu), 1 / 2, rtol=1e-12)
    scattered = law_of((0.0, -1.0, 0.0, 0.0, 0.7), sun_zenith_deg)
    exact = np.pi + 0.7 * np.pi / 4 * (1 + np.cos(z) ** 2)
    np.testing.assert_allclose(perez_law.flux_over_sky(scattered, one), exact, rtol=1e-12)
    horizon = law_of((-0.9, -0.3, 0.0, 0.0, 0.0), sun_zenith_deg)
    exact = np.pi - 0.9 * 2 * np.pi * expn(3, 0.3)
    np.testing.assert_allclose(perez_law.flux_over_sky(horizon, one), exact, rtol=1e-10)
    if sun_zenith_deg == 0:
        d = -6.7
        exact = np.pi * (1 + 20 * 2 * (1 + np.exp(d * np.pi / 2)) / (d * d + 4))
        aureole = law_of((0.0, -1.0, 20.0, d, 0.0), 0)
        np.testing.assert_allclose(perez_law.flux_over_sky(aureole, one), exact, rtol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_two_coordinate_systems_agree(name):
    """Cells of zenith angle and azimuth, the sun inside one of them, against rings around the sun."""
    law = replace(CASES[name].law, sun_zenith_rad=CASES[name].law.sun_zenith_rad + 0.03)
    flux = perez_law.patch_flux(law, np.linspace(0, 90, 10), np.linspace(-175, 185, 37))
    np.testing.assert_allclose(flux.sum(), perez_law.flux_over_sky(law, one), rtol=1e-11)


def test_reference_integrals_and_patches():
    """The oracle against the integrals and patch masses made by other programs."""
    rows = np.genfromtxt(PEREZ / "normalisation.csv", delimiter=",", names=True, dtype=None, encoding="ascii")
    for row in rows:
        law = replace(law_of(tuple(float(row[x]) for x in "abcde"), row["Z_deg"]), clipped=False)
        np.testing.assert_allclose(perez_law.flux_over_sky(law, one), row["integral_f_cos"], rtol=1e-11)
    masses = np.genfromtxt(PEREZ / "patch_mass.csv", delimiter=",", names=True)
    cases = {row["case"]: row for row in rows}
    for case in set(masses.dtype.names) & set(cases):
        row = cases[case]
        law = law_of(tuple(float(row[x]) for x in "abcde"), row["Z_deg"])
        shares = perez_law.patch_shares(law, np.linspace(0, 90, 10), np.linspace(0, 360, 37))
        np.testing.assert_allclose(shares[:, :18].ravel(), masses[case], rtol=1e-9, atol=1e-10)
