"""Rayleigh cross sections against 50 digits and the number of the description format's document."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from aomc_sky import UsageError, rayleigh_cross_section


def exact(n: float, temperature: float, pressure: float, wavelength_nm: float, king: float) -> mpmath.mpf:
    with mpmath.workdps(50):
        n, t, p, w, f = (mpmath.mpf(x) for x in (n, temperature, pressure, wavelength_nm, king))
        h = (n * n - 1) ** 2 / (w * mpmath.mpf(10) ** -9) ** 4 * (mpmath.mpf("1.380649e-23") * t / p) ** 2
        return 8 * mpmath.pi**3 / 3 * h * f


def test_air_as_the_document_has_it() -> None:
    assert f"{rayleigh_cross_section(1.000274, 288.15, 101325.0):.3e}" == "3.829e-32"


CASES = [
    (1.000274, 288.15, 101325.0, 1000.0, 1.0),
    (1.000447, 273.15, 101325.0, 532.0, 1.149),
    (1.0 + 2.0**-52, 215.0, 610.0, 1000.0, 1.0),
    (1.0000000001, 3.0, 1e-3, 121.6, 1.05),
    (2.0, 300.0, 1e9, 1e5, 2.0),
]


@pytest.mark.parametrize("case", CASES)
def test_it_is_the_formula_to_the_last_digits(case: tuple[float, ...]) -> None:
    n, temperature, pressure, wavelength, king = case
    found = rayleigh_cross_section(n, temperature, pressure, wavelength_nm=wavelength, king_factor=king)
    wanted = exact(*case)
    assert abs(found - wanted) <= 2e-15 * wanted


def test_arguments_broadcast_and_the_king_factor_multiplies() -> None:
    wavelength = np.array([400.0, 500.0, 1000.0])
    found = rayleigh_cross_section(1.000274, 288.15, 101325.0, wavelength_nm=wavelength, king_factor=[[1.0], [1.05]])
    assert found.shape == (2, 3)
    np.testing.assert_allclose(found[1] / found[0], 1.05, rtol=1e-15)
    np.testing.assert_allclose(found[0] / found[0, 2], (1000.0 / wavelength) ** 4, rtol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "king"),
    [((0.9, 288, 1e5), 1), ((1.0003, 0, 1e5), 1), ((1.0003, 288, -1), 1), ((np.nan, 288, 1e5), 1), ((1.1, 1, 1), 0.5)],
)
def test_numbers_outside_their_ranges_are_refused(arguments: tuple[float, ...], king: float) -> None:
    with pytest.raises(UsageError, match="must lie between"):
        rayleigh_cross_section(*arguments, king_factor=king)
