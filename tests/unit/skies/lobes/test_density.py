"""Densities of GGX and Beckmann lobes at many points, against the same algebra with 11 bits more."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.skies.lobes import functions as lobes

WIDE = np.longdouble
PI = WIDE("3.141592653589793238462643")


@pytest.mark.skipif(np.finfo(WIDE).nmant < 63, reason="long double is no wider than float64 here")
@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_density_of_all_widths(kind):
    rng = np.random.default_rng(12)
    n = 200_000
    alpha = 10 ** rng.uniform(-4, 3, (2, n))
    m = rng.normal(size=(n, 3))
    m[:, :2] *= np.where(rng.random((n, 1)) < 0.6, alpha.T, 1.0)
    m[:, 2] = np.abs(m[:, 2])
    x, y, z = m.T.astype(WIDE)
    length = np.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    a, b = alpha.astype(WIDE)
    square = (x / a) ** 2 + (y / b) ** 2
    if kind == "ggx":
        true, allowed = z / (PI * a * b * (square + z * z) ** 2), WIDE(8)
    else:
        ulp = 8 if np.lib.NumpyVersion(np.__version__) >= "2.0.0" else 9  # the exponential of numpy 1.26 is less exact
        true, allowed = np.exp(-square / z**2) / (PI * a * b * z**3), ulp * (1 + square / z**2)
    error = np.abs(lobes.pdf(kind, *alpha, m) - true) / np.spacing(true.astype(np.float64))
    assert np.all((error <= allowed) | (true < 1e-300))


def test_no_density_is_left_where_squares_would_overflow():
    assert lobes.pdf("ggx", 1e-200, 1.0, (1.0, 0.0, 1.0)) == 0.0
    assert lobes.pdf("ggx", 1e-30, 1e-30, (0.0, 0.0, 1.0)) == pytest.approx(1e60 / np.pi)
