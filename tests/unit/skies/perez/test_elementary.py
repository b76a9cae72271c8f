"""Exponential, logarithm and power of the Perez coefficients: to the last bits, and the same bits everywhere."""

from __future__ import annotations

import mpmath as mp
import numpy as np

from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.coefficients import exp, expm1, log, power

RNG = np.random.default_rng(12)


def ulps(found: np.ndarray, exact: list[mp.mpf]) -> float:
    pairs = zip(found, exact, strict=True)
    return max(float(abs(mp.mpf(float(f)) - e)) / float(np.spacing(abs(f))) for f, e in pairs)


def test_errors_in_ulps() -> None:
    with mp.workdps(50):
        x = np.concatenate([RNG.uniform(-700, 700, 300), RNG.uniform(-2, 2, 300)])
        assert ulps(exp(x), [mp.exp(mp.mpf(float(v))) for v in x]) < 1
        x = np.concatenate([10 ** RNG.uniform(-30, 0, 300), RNG.uniform(0, 3, 300), [0.0, 0.5]])
        assert ulps(expm1(x), [mp.expm1(mp.mpf(float(v))) for v in x]) < 2
        x = np.concatenate([10 ** RNG.uniform(-12, 3, 300), RNG.uniform(0.4, 2, 300), [0.5, 1.0, 2.0]])
        for ten_thousandths in (12375, -16364, -12530):
            exponent = mp.mpf(ten_thousandths) / 10000
            found = power(x, np.full_like(x, ten_thousandths))
            assert ulps(found, [mp.mpf(float(v)) ** exponent for v in x]) < 2
        for v, head, tail in zip(x, *log(x), strict=True):
            miss = mp.mpf(float(head)) + mp.mpf(float(tail)) - mp.log(mp.mpf(float(v)))
            assert abs(miss) < 4e-18 * max(1, abs(head))


def test_ends_of_the_range() -> None:
    np.testing.assert_array_equal(exp(np.array([-1e9, 1e9, 0.0])), [0, np.inf, 1])
    assert np.isnan(exp(np.array([np.nan]))).all()
    np.testing.assert_array_equal(power(np.zeros(2), np.array([12375.0, -16364.0])), [0, np.inf])
    assert np.isnan(power(np.array([np.nan]), np.array([12375.0]))).all()


def test_bits_of_a_coefficient_are_pinned() -> None:
    sun = 0.75
    overcast = perez.coefficients(1.0, 0.3, sun)
    assert [float(v).hex() for v in overcast[2:4]] == PINNED[:2]
    assert float(perez.sky_brightness(100.0, sun)).hex() == PINNED[2]


PINNED = ["0x1.a2d16b46a6f5cp+0", "-0x1.ed22514734237p-1", "0x1.9adbd806fd980p-4"]
