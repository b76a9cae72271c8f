"""Significands of fewer bits: the nearest such number, ties to even, and what must not change."""

from __future__ import annotations

import sys
from fractions import Fraction

import numpy as np
import pytest

from aomc_sky.errors import MissingExtraError, ModelLimitWarning, UsageError
from aomc_sky.outputs.tables.atmosphere import check_wavelengths, rounded_significand, xyzw


def nearest(value: float, n_bits: int) -> float:
    """The nearest number of so many bits by exact arithmetic, ties to even."""
    exact, exponent = Fraction(abs(value)), 0
    while exact >= 2**n_bits:
        exact, exponent = exact / 2, exponent + 1
    while exact < 2 ** (n_bits - 1):
        exact, exponent = exact * 2, exponent - 1
    return float(np.sign(value) * float(round(exact) * Fraction(2) ** exponent))


@pytest.mark.parametrize("n_bits", [1, 2, 7, 12, 23, 24])
def test_against_exact_arithmetic(n_bits: int) -> None:
    rng = np.random.default_rng(5)
    values = np.concatenate([rng.normal(size=200) * 10.0 ** rng.uniform(-30, 30, 200), [1.5, 2.5, 3.5, 1 - 2**-30]])
    found = rounded_significand(values, n_bits)
    assert found.dtype == np.float32
    assert found.astype(np.float64).tolist() == [nearest(value, n_bits) for value in values]


def test_all_bits_are_what_float32_has() -> None:
    values = np.random.default_rng(6).uniform(1e-6, 1e3, 1000)
    np.testing.assert_array_equal(rounded_significand(values, 24), values.astype(np.float32))


def test_zeros_and_what_is_no_number_stay() -> None:
    found = rounded_significand(np.array([0.0, -0.0, np.inf, -np.inf, np.nan]), 3)
    np.testing.assert_array_equal(found, np.array([0.0, -0.0, np.inf, -np.inf, np.nan], dtype=np.float32))
    assert np.signbit(found[1])


FINE_NM = np.arange(360.0, 831.0)


@pytest.fixture
def colour() -> object:
    return pytest.importorskip("colour")


def planck(wavelength_nm: np.ndarray, kelvin: float) -> np.ndarray:
    """Blackbody spectrum, in some unit."""
    return wavelength_nm**-5.0 / np.expm1(1.438776877e7 / (wavelength_nm * kelvin))


def test_coarse_spectra_against_the_functions_of_colour(colour: object) -> None:
    from colour import MSDS_CMFS, SpectralDistribution
    from colour.colorimetry import SDS_LEFS, luminous_flux, sd_to_XYZ_integration

    matching = MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    night = SDS_LEFS["CIE 1951 Scotopic Standard Observer"]
    wavelength = np.linspace(400.0, 700.0, 16)
    for spectrum in (np.ones(16), planck(wavelength, 12000.0) * 1e12, np.random.default_rng(1).uniform(0, 2, 16)):
        found = xyzw(spectrum, wavelength)
        light = np.interp(FINE_NM, wavelength, spectrum, 0.0, 0.0)
        # nothing outside the wavelengths: colour-science would go on with the last value
        day = SpectralDistribution(dict(zip(FINE_NM, light, strict=True)))
        np.testing.assert_allclose(found[:3], sd_to_XYZ_integration(day, matching, k=683.0), rtol=1e-9)
        inside = (FINE_NM >= 380.0) & (FINE_NM <= 780.0)
        dark = SpectralDistribution(dict(zip(FINE_NM[inside], light[inside], strict=True)))
        np.testing.assert_allclose(found[3], luminous_flux(dark, night, 1700.0), rtol=1e-9)


@pytest.mark.parametrize(
    ("kelvin", "chromaticity"), [(2856.0, (0.4476, 0.4074)), (5000.0, (0.3451, 0.3516)), (10000.0, (0.2807, 0.2884))]
)
def test_published_chromaticities_of_blackbodies(
    colour: object, kelvin: float, chromaticity: tuple[float, float]
) -> None:
    for wavelength in (FINE_NM, np.arange(360.0, 831.0, 10.0)):
        x, y, z, _ = xyzw(planck(wavelength, kelvin), wavelength)
        np.testing.assert_allclose((x / (x + y + z), y / (x + y + z)), chromaticity, atol=3e-4)


def test_wavelengths_that_no_colour_follows_from(colour: object) -> None:
    check_wavelengths(np.arange(380.0, 781.0, 20.0))
    with pytest.raises(UsageError, match="two wavelengths"):
        check_wavelengths(np.array([550.0]))
    with pytest.warns(ModelLimitWarning, match="100 nm apart"):
        check_wavelengths(np.array([380.0, 480.0, 580.0, 680.0, 780.0]))
    with pytest.warns(ModelLimitWarning, match="outside the wavelengths"):
        check_wavelengths(np.arange(450.0, 701.0, 10.0))


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "colour", None)
    with pytest.raises(MissingExtraError, match=r'pip install "aomc-sky\[colour\]"'):
        xyzw(np.ones(2), np.array([500.0, 510.0]))
