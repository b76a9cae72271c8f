"""The Perez luminance of `law` in plain numpy, equal to the bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import COS_F64, SIN_F64
from aomc_sky.kernels.arithmetic.plain import exp_level, nested

_HALF_PI = 1.5707963267948966
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


def arc(h):
    """Angle whose half has sine^2 h. [rad]"""
    h = np.asarray(h, dtype=np.float64)
    q = 1.0 - (h + h)
    near, far = q > 0.5, q < -0.5
    z = np.maximum(np.where(near, h, np.where(far, 1.0 - h, q * q)), 0.0)
    s = np.where(near | far, np.sqrt(z), q)
    r = s + s * (z * nested(_ARC_P, z) / nested(_ARC_Q, z))
    return np.where(near, r + r, np.where(far, 2.0 * _HALF_PI - (r + r), _HALF_PI - r))


def first_factor(mu, a, b):
    """1 + a exp(b/mu) for b <= 0; at mu = 0 its limit."""
    return 1.0 + a * exp_level(b / np.maximum(mu, 1e-300))


def second_factor(h, c, d, e):
    """1 + c exp(d gamma) + e cos^2 gamma at h = sin^2(gamma/2)."""
    q = 1.0 - (h + h)
    return 1.0 + c * exp_level(d * arc(h)) + e * (q * q)


def sin_cos(x):
    """Sine and cosine of x quarter turns, exact at whole ones."""
    x = np.asarray(x, dtype=np.float64)
    turns = np.rint(x)
    r = x - turns
    t = r * r
    s0, c0 = nested(SIN_F64, t) * r, nested(COS_F64, t)
    quarter = turns.astype(np.int64)
    swap = (quarter & 1) != 0
    s, c = np.where(swap, c0, s0), np.where(swap, s0, c0)
    return np.where((quarter & 2) != 0, -s, s), np.where(((quarter + 1) & 2) != 0, -c, c)


def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * np.asarray(x))
    return s * s
