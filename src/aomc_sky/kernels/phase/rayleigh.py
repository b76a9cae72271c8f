"""The Rayleigh phase function's formulas: + - x / and a minimum, one text for arrays and for kernels.

The derivation is in docs/models/rayleigh.md.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.formula import formulas, smaller

# the cubic's root over t, divided by its two ends, less 1: fitted by least squares, relative error 0.4 %
_START = (0.98818173, -3.01206685, 1.60357082)


def cubic_share(gamma):
    """Weight k of the cube in the equation of the inversion, x + k x^3 = (1 + k) t. [1/3 at gamma 0, 0 at 1]"""
    return (1.0 - gamma) / (3.0 + 9.0 * gamma)


def invert(xi, k):
    """Root mu of mu + k mu^3 = (1 + k)(2 xi - 1): a start that is exact at both ends, a Halley and a Newton step.

    The last step adds the residual to its start, so nothing cancels beside xi = 1/2, and mu(0) = -1 and
    mu(1) = 1 exactly.
    """
    t = (xi + xi) - 1.0
    u = t * t
    y = (1.0 + k) * t
    x = t + t * (k * (1.0 - u) * (_START[0] + k * u * (_START[1] + _START[2] * u)))
    kx = k * x
    f = (x + kx * x * x) - y
    slope = 1.0 + 3.0 * (kx * x)
    x = x - f * slope / (slope * slope - 3.0 * (kx * f))
    kxx = k * x * x
    return x + (y - (x + kxx * x)) / (1.0 + 3.0 * kxx)


def ends(xi, mu, k):
    """1 - mu and 1 + mu of the inverse mu at xi, each right to its own last digits."""
    scale = (1.0 + k) + (1.0 + k)
    even = 1.0 + k * (1.0 + mu * mu)
    return scale * (1.0 - xi) / (even + k * mu), scale * xi / (even - k * mu)


def density(mu, gamma):
    """Density over mu, 3/8 ((1 + 3 gamma) + (1 - gamma) mu^2) / (1 + 2 gamma)."""
    return 0.375 * ((1.0 + 3.0 * gamma) + (1.0 - gamma) * (mu * mu)) / (1.0 + (gamma + gamma))


def cumulated(mu, gamma):
    """Probability of a smaller mu, with the factor 1 + mu taken out so that its small values keep their digits."""
    s = 1.0 - gamma
    inside = 3.0 * (1.0 + 3.0 * gamma) + s * (1.0 - mu * (1.0 - mu))
    return smaller((1.0 + mu) * inside / (8.0 + 16.0 * gamma), 1.0)


def cosine(xi, gamma):
    """Cosine of the scattering angle; xi is the probability of a smaller one."""
    return invert(xi, cubic_share(gamma))


def cosine_and_ends(xi, gamma):
    """`cosine`, 1 - mu and the sine of the scattering angle."""
    k = cubic_share(gamma)
    mu = invert(xi, k)
    v, w = ends(xi, mu, k)
    return mu, v, np.sqrt(v * w)


formulas(cubic_share, invert, ends, density, cumulated, cosine, cosine_and_ends, is_inlined=True)
