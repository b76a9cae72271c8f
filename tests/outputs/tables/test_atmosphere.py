"""Significands of fewer bits: the nearest such number, ties to even, and what must not change."""

from fractions import Fraction

import numpy as np
import pytest

from aomc_sky.outputs.tables.atmosphere import rounded_significand


def nearest(value, n_bits):
    """The nearest number of so many bits by exact arithmetic, ties to even."""
    exact, exponent = Fraction(abs(value)), 0
    while exact >= 2**n_bits:
        exact, exponent = exact / 2, exponent + 1
    while exact < 2 ** (n_bits - 1):
        exact, exponent = exact * 2, exponent - 1
    return float(np.sign(value) * float(round(exact) * Fraction(2) ** exponent))


@pytest.mark.parametrize("n_bits", [1, 2, 7, 12, 23, 24])
def test_against_exact_arithmetic(n_bits):
    rng = np.random.default_rng(5)
    values = np.concatenate([rng.normal(size=200) * 10.0 ** rng.uniform(-30, 30, 200), [1.5, 2.5, 3.5, 1 - 2**-30]])
    found = rounded_significand(values, n_bits)
    assert found.dtype == np.float32
    assert found.astype(np.float64).tolist() == [nearest(value, n_bits) for value in values]


def test_all_bits_are_what_float32_has_and_zeros_stay():
    values = np.random.default_rng(6).uniform(1e-6, 1e3, 1000)
    np.testing.assert_array_equal(rounded_significand(values, 24), values.astype(np.float32))
    found = rounded_significand(np.array([0.0, -0.0, np.inf, -np.inf, np.nan]), 3)
    np.testing.assert_array_equal(found, np.array([0.0, -0.0, np.inf, -np.inf, np.nan], dtype=np.float32))
    assert np.signbit(found[1])
