"""Phase functions, each as the scattering cosine that a uniform number stands for, and the turn by that cosine."""

from __future__ import annotations

import math

import numba

ISOTROPIC_BELOW = 1e-6
"""Asymmetry below which the Henyey-Greenstein formula loses its digits; light scatters isotropically there."""


@numba.njit(nogil=True)
def sample_henyey_greenstein(g: float, u: float) -> float:
    """Return a scattering cosine of Henyey and Greenstein's phase function.

    Parameters
    ----------
    g : float
        Mean cosine. (-1 to 1)
    u : float
        Uniform number. [0, 1]
    """
    if abs(g) < ISOTROPIC_BELOW:
        return 2.0 * u - 1.0
    ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u)
    return min(max((1.0 + g * g - ratio * ratio) / (2.0 * g), -1.0), 1.0)


@numba.njit(nogil=True)
def sample_rayleigh(u: float) -> float:
    """Return a scattering cosine of 3/8 (1 + mu^2): the real root of mu^3 + 3 mu = 8 u - 4, after Cardano."""
    q = 4.0 * u - 2.0
    root = (q + math.sqrt(q * q + 1.0)) ** (1.0 / 3.0)
    return min(max(root - 1.0 / root, -1.0), 1.0)


@numba.njit(nogil=True)
def turned(ux: float, uy: float, uz: float, mu: float, u: float) -> tuple[float, float, float]:
    """Turn a unit vector by a scattering angle, in a plane that a uniform number chooses.

    The two directions across the path are those of Duff et al. (2017, J. Comput. Graph. Tech. 6(1)), which
    lose no digits anywhere. A step of Newton's square root keeps the length at 1 over any number of turns.

    Parameters
    ----------
    ux, uy, uz : float
        Travel direction, unit length.
    mu : float
        Cosine of the scattering angle. [-1 to 1]
    u : float
        Uniform number. [0, 1]
    """
    sign = math.copysign(1.0, uz)
    a = -1.0 / (sign + uz)
    b = ux * uy * a
    sine = math.sqrt(1.0 - mu * mu)
    p, q = sine * math.cos(2.0 * math.pi * u), sine * math.sin(2.0 * math.pi * u)
    x = p * (1.0 + sign * ux * ux * a) + q * b + mu * ux
    y = p * sign * b + q * (sign + uy * uy * a) + mu * uy
    z = -p * sign * ux - q * uy + mu * uz
    scale = 1.5 - 0.5 * (x * x + y * y + z * z)
    return x * scale, y * scale, z * scale
