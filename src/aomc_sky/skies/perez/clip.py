"""How much of a Perez sky has a negative luminance."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.skies.perez.functions import relative_radiance

_N_MU, _N_AZIMUTH, _N_GAMMA = 200, 181, 2001


def share_below_zero(coefficients: np.ndarray, sun_zenith_rad: float) -> float:
    """Share of the hemisphere's solid angle where f of eq. (1) is negative.

    Parameters
    ----------
    coefficients : ndarray, float64, shape (5,)
        a, b, c, d, e with b <= 0.
    sun_zenith_rad : float
        Zenith angle of the sun. [rad, 0 to pi/2]

    Returns
    -------
    float
        [0 to 1] Exactly 0 where neither factor can be negative; else counted on 36 000 directions.
    """
    a, b, c, d, e = coefficients.tolist()
    is_lit = 1 + a * math.exp(b) >= 0
    if is_lit and c >= 0 and e > -1:
        return 0.0
    gamma = np.linspace(0, np.pi, _N_GAMMA)
    second = 1 + c * np.exp(np.clip(d * gamma, -700, 700)) + e * np.cos(gamma) ** 2
    if is_lit and second.min() >= 0:
        return 0.0
    mu = (np.arange(_N_MU) + 0.5) / _N_MU
    azimuth = (np.arange(_N_AZIMUTH) + 0.5) * (np.pi / _N_AZIMUTH)
    value = relative_radiance(np.arccos(mu)[:, None], azimuth, sun_zenith_rad, coefficients)
    return max(float(np.mean(value < 0)), 1e-5)
