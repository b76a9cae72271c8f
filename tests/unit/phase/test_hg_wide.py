"""Henyey-Greenstein density and tails at many points, against the same algebra with 11 bits more."""

from __future__ import annotations

import numpy as np
import pytest

import aomc_sky as sky

WIDE = np.longdouble
PI = WIDE("3.141592653589793238462643")


@pytest.mark.skipif(np.finfo(WIDE).nmant < 63, reason="long double is no wider than float64 here")
def test_density_and_tails_are_within_5_ulp():
    rng = np.random.default_rng(11)
    n = 200_000
    g = np.where(rng.random(n) < 0.6, rng.random(n), 1 - 10 ** (-15.5 * rng.random(n)))
    v = 2 * np.where(rng.random(n) < 0.6, rng.random(n), 10 ** (-25 * rng.random(n)))
    h, a = g.astype(WIDE), v.astype(WIDE)
    d = 1 - h
    R = np.sqrt(d * d + 2 * h * a)
    H = sky.henyey_greenstein
    for found, true in (
        (H.pdf_sr(v, g), d * (1 + h) / (4 * PI * R**3)),
        (H.survival(v, g), (1 + h) * a / (R * (R + d))),
        (H.cdf(v, g), d * (2 - a) / (R * (R + (1 + h)))),
    ):
        assert (np.abs(found - true) / np.spacing(true.astype(np.float64))).max() <= 5
