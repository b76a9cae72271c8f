"""The Perez luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches.

Angles do not appear: a point of the sky is given by its cosine mu and by h = sin^2(gamma/2), half its
squared chord to the sun over two, which keeps all digits beside the sun. One text serves arrays and kernels.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level, sincos_quarter, turned_by_quarters
from aomc_sky.kernels.formula import formula, inlined_formula, larger, nested, select

HALF_PI = 1.5707963267948966

A, B, C, D, E, SUN_X, SUN_Y, SUN_SINE, SUN_VECTOR = range(9)
"""Where a sky's numbers stand: coefficients, sun in quarter turns, sine of its zenith angle, three of its vector."""

_ARC_P = (
    3.47933107596021167570e-05,
    7.91534994289814532176e-04,
    -4.00555345006794114027e-02,
    2.01212532134862925881e-01,
    -3.25565818622400915405e-01,
    1.66666666666666657415e-01,
)
_ARC_Q = (
    7.70381505559019352791e-02,
    -6.88283971605453293030e-01,
    2.02094576023350569471e00,
    -2.40339491173441421878e00,
    1.0,
)


@inlined_formula
def arc(h):
    """Angle whose half has sine^2 h, branch-free; within 2 ulp up to 120 degrees, 2 ulp of pi beyond. [rad]

    The arc cosine of 1 - 2h in three zones with one rational function (the one of fdlibm), where
    h itself serves in the first, so that nothing cancels near 0.
    """
    q = 1.0 - (h + h)
    near, far = q > 0.5, q < -0.5
    z = larger(select(near, h, select(far, 1.0 - h, q * q)), 0.0)
    s = select(near | far, np.sqrt(z), q)
    r = s + s * (z * nested(_ARC_P, z) / nested(_ARC_Q, z))
    return select(near, r + r, select(far, 2.0 * HALF_PI - (r + r), HALF_PI - r))


@inlined_formula
def slant(mu, b):
    """Exponent of the first factor, b / mu for b <= 0; at mu = 0 as good as its limit. [mu 0 to 1]"""
    return b / larger(mu, 1e-300)


@inlined_formula
def first_factor(mu, a, b):
    """1 + a exp(b/mu) for b <= 0; at mu = 0 its limit. [mu 0 to 1]"""
    return 1.0 + a * exp_level(slant(mu, b))


@inlined_formula
def with_aureole(h, c, aureole, e):
    """The second factor from its exponential."""
    q = 1.0 - (h + h)
    return 1.0 + c * aureole + e * (q * q)


@inlined_formula
def second_factor(h, c, d, e):
    """1 + c exp(d gamma) + e cos^2 gamma at h = sin^2(gamma/2). [h 0 to 1]"""
    return with_aureole(h, c, exp_level(d * arc(h)), e)


@formula
def sin_cos(x):
    """Sine and cosine of x quarter turns, exact at whole ones; within 2 ulp of 1 for |x| below 1000."""
    turns = np.rint(x)
    s, c = sincos_quarter(x - turns)
    return turned_by_quarters(np.int64(turns), s, c)


@formula
def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * x)
    return s * s
