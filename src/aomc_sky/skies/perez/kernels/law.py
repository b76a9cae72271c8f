"""The Perez luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches.

A point of the sky has no angles here, but its cosine mu and h = sin^2(gamma/2). This h is a quarter of the squared
chord to the sun, and keeps all digits beside the sun. One text serves arrays and kernels.
"""

from __future__ import annotations

from aomc_sky.kernels.arithmetic.elementary import arc, exp_level
from aomc_sky.kernels.formula import formulas, larger

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE, SUN_VECTOR = range(9)
"""Where a sky's numbers stand: coefficients, sun in quarter turns, sine of its zenith angle, three of its vector."""


def slant(mu, b):
    """Exponent of the first factor, b / mu for b <= 0; at mu = 0 it acts as its limit. [mu 0 to 1]"""
    return b / larger(mu, 1e-300)


def first_factor(mu, a, b):
    """1 + a exp(b/mu) for b <= 0; at mu = 0 its limit. [mu 0 to 1]"""
    return 1.0 + a * exp_level(slant(mu, b))


def with_aureole(h, c, aureole, e):
    """The second factor from its exponential."""
    q = 1.0 - (h + h)
    return 1.0 + c * aureole + e * (q * q)


def second_factor(h, c, d, e):
    """1 + c exp(d gamma) + e cos^2 gamma at h = sin^2(gamma/2). [h 0 to 1]"""
    return with_aureole(h, c, exp_level(d * arc(h)), e)


formulas(slant, first_factor, with_aureole, second_factor, is_inlined=True)
