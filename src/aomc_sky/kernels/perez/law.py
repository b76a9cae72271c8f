"""The Perez luminance in float64 with + - x / sqrt alone: the same bits on every machine, no branches.

Angles do not appear: a point of the sky is given by its cosine mu and by h = sin^2(gamma/2), half its
squared chord to the sun over two, which keeps all digits beside the sun.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.elementary import exp_level, sincos_quarter
from aomc_sky.kernels.jit import inlined, inner_reader

_HALF_PI = 1.5707963267948966


@inlined
def arc(h):
    """Angle whose half has sine^2 h, branch-free; within 2 ulp up to 120 degrees, 2 ulp of pi beyond. [rad]

    The arc cosine of 1 - 2h in three zones with one rational function (the one of fdlibm), where
    h itself serves in the first, so that nothing cancels near 0.
    """
    q = 1.0 - (h + h)
    near, far = q > 0.5, q < -0.5
    z = h if near else (1.0 - h if far else q * q)
    z = max(z, 0.0)
    root = np.sqrt(z)
    s = root if near or far else q
    p = z * (
        1.66666666666666657415e-01
        + z
        * (
            -3.25565818622400915405e-01
            + z
            * (
                2.01212532134862925881e-01
                + z * (-4.00555345006794114027e-02 + z * (7.91534994289814532176e-04 + z * 3.47933107596021167570e-05))
            )
        )
    )
    d = 1.0 + z * (
        -2.40339491173441421878e00
        + z * (2.02094576023350569471e00 + z * (-6.88283971605453293030e-01 + z * 7.70381505559019352791e-02))
    )
    r = s + s * (p / d)
    return r + r if near else (2.0 * _HALF_PI - (r + r) if far else _HALF_PI - r)


@inlined
def first_factor(mu, a, b):
    """1 + a exp(b/mu) for b <= 0; at mu = 0 its limit. [mu 0 to 1]"""
    return 1.0 + a * exp_level(b / max(mu, 1e-300))


@inlined
def second_factor(h, c, d, e):
    """1 + c exp(d gamma) + e cos^2 gamma at h = sin^2(gamma/2). [h 0 to 1]"""
    q = 1.0 - (h + h)
    return 1.0 + c * exp_level(d * arc(h)) + e * (q * q)


@inner_reader
def sin_cos(x):
    """Sine and cosine of x quarter turns, exact at whole ones; within 2 ulp of 1 for |x| below 1000."""
    turns = np.rint(x)
    s0, c0 = sincos_quarter(x - turns)
    quarter = np.int64(turns)
    swap = (quarter & 1) != 0
    s = c0 if swap else s0
    c = s0 if swap else c0
    s = -s if (quarter & 2) != 0 else s
    c = -c if ((quarter + 1) & 2) != 0 else c
    return s, c
