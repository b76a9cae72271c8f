"""Texts of floats: those of `repr`, character by character; and floats of digits: those of `float`."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.kernels.arithmetic.decimals import WIDTH, nearest_floats, shortest_texts

RNG = np.random.default_rng(20)
N = 20_000
POWERS_OF_TWO = 2.0 ** np.arange(-1074, 1024)
POWERS_OF_TEN = np.array([float(f"1e{k}") for k in range(-324, 309)])


def neighbours(values):
    with np.errstate(over="ignore"):  # next to the largest float stands infinity
        return np.concatenate([np.nextafter(values, 0), values, np.nextafter(values, np.inf)])


VALUES = {
    "every-bit-pattern": RNG.integers(0, 2**64, N, dtype=np.uint64).view(np.float64),
    "positive-bit-patterns": RNG.integers(0, 2**63, N).view(np.float64),
    "shares": RNG.random(N) * 10.0 ** RNG.integers(-12, 0, N),
    "powers-of-two": neighbours(POWERS_OF_TWO),
    "powers-of-ten": neighbours(POWERS_OF_TEN),
    "few-digits": RNG.integers(1, 10**6, N) / 10.0 ** RNG.integers(0, 12, N),
    "fifteen-digits": np.array([float(f"{value:.14e}") for value in RNG.lognormal(size=N, sigma=9)]),
    "sixteen-digits": np.array([float(f"{value:.15e}") for value in RNG.lognormal(size=N, sigma=9)]),
    "whole-numbers": RNG.integers(2**50, 2**63, N) / 1.0,
    "halves": RNG.integers(2**52, 2**54, N) / 2,
    "odd": np.array([0.0, -0.0, np.inf, -np.inf, np.nan, -1.5, 5e-324, 9007199254740993.0, 1e22, 1e23, 9.5e-5, 1e16]),
    "none": np.zeros(0),
}


def texts_of(values):
    return [row.tobytes().replace(b"\0", b"").decode() for row in shortest_texts(values)]


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
def test_texts_are_those_of_repr(values):
    assert texts_of(values) == [repr(value) for value in values.tolist()]


def test_a_piece_of_a_strided_array_reads_like_a_whole_one():
    values = RNG.random(40_000)
    np.testing.assert_array_equal(shortest_texts(values[::2]), shortest_texts(values)[::2])
    assert shortest_texts(values[:3]).shape == (3, WIDTH)


def halfway(n):
    """Digits and powers of ten of numbers next to the middle of two floats."""
    low = RNG.integers(2**52, 2**53, n)
    return np.concatenate([10 * low + 5, 10 * low + 4, 10 * low + 6]), np.tile(RNG.integers(-40, 40, n), 3)


DIGITS = {
    "any": (RNG.integers(0, 9 * 10**18, N), RNG.integers(-60, 60, N)),
    "few-digits": (RNG.integers(0, 10**6, N), RNG.integers(-30, 30, N)),
    "seventeen-digits": (RNG.integers(10**16, 10**17, N), RNG.integers(-40, 5, N)),
    "far-powers": (RNG.integers(0, 10**18, 2000), RNG.integers(-400, 400, 2000)),
    "halves-of-gaps": (2 * RNG.integers(2**52, 2**53, N) + 1, np.zeros(N, np.int64)),
    "near-halves": halfway(N // 4),
    "powers-of-two": (2 ** np.arange(63), np.zeros(63, np.int64)),
}


@pytest.mark.parametrize(("digits", "exponent"), DIGITS.values(), ids=DIGITS)
def test_digits_are_read_as_float_reads_them(digits, exponent):
    expected = [float(f"{digit}e{power}") for digit, power in zip(digits.tolist(), exponent.tolist(), strict=True)]
    np.testing.assert_array_equal(nearest_floats(digits, exponent), expected)
