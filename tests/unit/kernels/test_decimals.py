"""Texts of floats: those of `repr`, character by character."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.kernels.arithmetic.decimals import WIDTH, shortest_texts

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
