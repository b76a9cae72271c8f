"""The denominator of eq. (3) of the Perez sky: the integral of f cos xi over the hemisphere.

f = F1 F2 with F1 = 1 + a exp(b/mu) and F2 = 1 + e cos^2 gamma + c exp(d gamma). The first two terms of
F2 give exponential integrals. The last one has a cusp at the sun and a boundary layer at the horizon,
as thin as |b|; in coordinates centred on the sun, split at gamma = pi/2 - Z, both are edges of the
rectangle, and double-exponential quadrature resolves edges at every scale.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError

_RULE_GAMMA = (32, 3.0)
_RULE_PSI = (36, 3.1)
_SKIES_AT_ONCE = 32


@cache
def _rule(steps: int, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Double-exponential rule on (0, 1): distance from 0, distance from 1, weights [takahasi1974]."""
    t = np.linspace(-reach, reach, 2 * steps + 1)
    rise = np.pi * np.sinh(t)
    from_zero, from_one = 1.0 / (1.0 + np.exp(-rise)), 1.0 / (1.0 + np.exp(rise))
    weight = np.pi * np.cosh(t) * from_zero * from_one * (t[1] - t[0])
    return from_zero, from_one, weight


def horizontal_integral(coefficients: ArrayLike, sun_zenith_rad: ArrayLike) -> np.ndarray:
    """Integral of f cos xi over the hemisphere, the denominator of eq. (3).

    Parameters
    ----------
    coefficients : array_like, shape (..., 5)
        a, b, c, d, e with b <= 0; the leading axes broadcast with the sun.
    sun_zenith_rad : array_like
        Zenith angle of the sun. [rad, 0 to pi/2]

    Returns
    -------
    ndarray, float64
        The integral of f as it is, without a clip. [sr]

    Raises
    ------
    SceneError
        b > 0 with a not 0: the integral diverges at the horizon. Or the sun is below the horizon.

    Notes
    -----
    Accuracy: 1e-10 relative, against the sum of the magnitudes of the three terms.
    """
    values = np.asarray(coefficients, dtype=np.float64)
    zenith = np.asarray(sun_zenith_rad, dtype=np.float64)
    if np.any((zenith < 0) | (zenith > np.pi / 2)):
        raise SceneError("the sun's zenith angle must lie in 0 to pi/2 rad")
    shape = np.broadcast_shapes(values.shape[:-1], zenith.shape)
    values = np.broadcast_to(values, (*shape, 5)).reshape(-1, 5)
    suns = np.broadcast_to(zenith, shape).ravel()
    if np.any((values[:, 1] > 0) & (values[:, 0] != 0)):
        raise SceneError("the integral over the sky diverges for b > 0; take np.minimum(b, 0), as PerezSky does")
    total = np.empty(len(values))
    for start in range(0, len(values), _SKIES_AT_ONCE):
        part = slice(start, start + _SKIES_AT_ONCE)
        total[part] = _smooth_part(values[part], suns[part]) + _aureole_part(values[part], suns[part])
    return total.reshape(shape)


def _smooth_part(values: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """The integral with F2 = 1 + e cos^2 gamma: E3 and E5 are those of mu exp(b/mu) and mu^3 exp(b/mu)."""
    from scipy.special import expn

    a, b, _, _, e = values.T
    depth = np.where(a == 0, 0.0, -b)
    cube, fifth = 0.5 + a * expn(3, depth), 0.25 + a * expn(5, depth)
    half_sine2 = np.sin(sun) ** 2 / 2
    return 2 * np.pi * (cube * (1 + e * half_sine2) + fifth * e * (np.cos(sun) ** 2 - half_sine2))


def _aureole_part(values: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """The integral with F2 = c exp(d gamma), over whole circles about the sun and then over cut ones."""
    near, far, weight = _rule(*_RULE_GAMMA)
    near, far = near[:, None], far[:, None]
    along, left, weight_psi = _rule(*_RULE_PSI)
    half = np.sin(sun)[:, None, None]
    whole = (np.pi / 2 - sun)[:, None, None]
    gamma = whole * near
    lowest = np.sin(whole * far)  # mu of the circle's lowest point
    mu = lowest + 2 * np.sin(gamma) * half * np.sin(np.pi / 2 * left) ** 2
    total = _circles(values, gamma, mu) @ weight_psi @ weight * np.pi * whole[:, 0, 0]
    cut = 2 * sun[:, None, None]
    below, above = cut * near, cut * far
    gamma = whole + below
    # a cut circle meets the horizon at psi = +-end; half angles keep the differences from cancelling
    end = 2 * np.arctan2(np.sqrt(np.sin(above)), np.sqrt(np.sin(below)))
    mu = 2 * np.sin(gamma) * half * np.sin(end * (1 + along) / 2) * np.sin(end * left / 2)
    total += (_circles(values, gamma, mu) * end) @ weight_psi @ weight * cut[:, 0, 0]
    return 2 * values[:, 2] * total


def _circles(values: np.ndarray, gamma: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """exp(d gamma) sin gamma mu F1, shape (sky, gamma, psi)."""
    a, b, _, d, _ = (v[:, None, None] for v in values.T)
    # beyond e^-60 nothing is left beside 1, and tiny exponentials are slow
    depth = np.maximum(b / np.maximum(mu, 1e-300), -60.0)
    return (np.exp(d * gamma) * np.sin(gamma)) * (mu * (1 + a * np.exp(depth)))
