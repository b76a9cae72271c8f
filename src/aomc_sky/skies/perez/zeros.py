"""Where the two factors of the Perez luminance are 0, in numbers that are the same on every machine."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.perez.plain_law import exp_level, first_factor, half_sine2, second_factor, sin_cos

_STEPS = 720
_HALVINGS = 80


def first_factor_zero(a: float, b: float) -> float:
    """Zenith angle where 1 + a exp(b/mu) = 0, or -1 where it has one sign.

    Parameters
    ----------
    a, b : float
        Coefficients, b <= 0.

    Returns
    -------
    float
        The factor is negative nearer to the zenith. [quarter turns, 0 to 1, or -1]
    """
    if b == 0 or a > -1.0 or 1.0 + a * float(exp_level(b)) >= 0:
        return -1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if first_factor(sin_cos(middle)[1], a, b) < 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def second_factor_zeros(c: float, d: float, e: float) -> np.ndarray:
    """Places where 1 + c exp(d gamma) + e cos^2 gamma changes its sign, seen in steps of a quarter degree.

    Parameters
    ----------
    c, d, e : float
        Coefficients.

    Returns
    -------
    ndarray, float64, shape (n_zero,)
        sin^2(gamma/2), ascending. [0 to 1]
    """
    if c >= 0 and e > -1:
        return np.empty(0)
    h = half_sine2(np.arange(_STEPS + 1) * (2.0 / _STEPS))
    h[-1] = 1.0
    negative = second_factor(h, c, d, e) < 0
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    low, high = h[changes], h[changes + 1]
    for _ in range(_HALVINGS if changes.size else 0):
        middle = 0.5 * (low + high)
        is_low = (second_factor(middle, c, d, e) < 0) == negative[changes]
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return 0.5 * (low + high)
