"""The exact rejection of `perez_cells` in plain numpy, equal to the bit; the luminance of `perez_law` likewise."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels import constants as k
from aomc_sky.kernels.plain import _from_mu2, philox, sincos_turned, unit

_U64 = np.uint64
_LN2_HI = 6.93147180369123816490e-01
_LN2_LO = 1.90821492927058770002e-10
_ROUND = 6755399441055744.0
_HALF_PI = 1.5707963267948966
_EXP = (
    4.13813679705723846039e-08,
    -1.65339022054652515390e-06,
    6.61375632143793436117e-05,
    -2.77777777770155933842e-03,
    1.66666666666666019037e-01,
)
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
)


def _nested(coefficients, z):
    value = coefficients[0]
    for coefficient in coefficients[1:]:
        value = coefficient + z * value
    return value


def exp_level(x):
    """Exponential for |x| <= 700."""
    x = np.maximum(np.minimum(x, 700.0), -700.0)
    t = x * 1.4426950408889634 + _ROUND
    whole = t - _ROUND
    hi, lo = x - whole * _LN2_HI, whole * _LN2_LO
    r = hi - lo
    c = r - (r * r) * _nested(_EXP, r * r)
    y = 1.0 - ((lo - (r * c) / (2.0 - c)) - hi)
    return y * ((t.view(np.int64) + 1023) << 52).view(np.float64)


def arc(h):
    """Angle whose half has sine^2 h. [rad]"""
    q = 1.0 - (h + h)
    near, far = q > 0.5, q < -0.5
    z = np.maximum(np.where(near, h, np.where(far, 1.0 - h, q * q)), 0.0)
    s = np.where(near | far, np.sqrt(z), q)
    r = s + s * (z * _nested(_ARC_P, z) / (1.0 + z * _nested(_ARC_Q, z)))
    return np.where(near, r + r, np.where(far, 2.0 * _HALF_PI - (r + r), _HALF_PI - r))


def luminance(mu, h, sky):
    """Relative luminance of the model for b <= 0; `sky` starts with a, b, c, d, e."""
    a, b, c, d, e = sky[:5]
    q = 1.0 - (h + h)
    first = 1.0 + a * exp_level(b / np.maximum(mu, 1e-300))
    return first * (1.0 + c * exp_level(d * arc(h)) + e * (q * q))


def _is_rejected(directions, word, bound, sky):
    x, y, z = (values.astype(np.float64) for values in directions)
    dx, dy, dz = x + sky[8], y + sky[9], z + sky[10]
    chord = np.minimum(0.25 * ((dx * dx + dy * dy) + dz * dz), 1.0)
    limit = ((word >> _U64(11)).astype(np.float64) * 2.0**-53) * bound
    return limit >= luminance(-z, chord, sky)


def reject(directions, p, perez, jitter, key, rank, band):
    """Replace the directions that the luminance rejects; p, `perez` and the rest hold one entry per photon.

    `perez` is (threshold, bound, sky, steps) as in the kernel, its first two already looked up.
    """
    threshold, bound, sky, steps = perez
    word = philox(key, rank, band, int(k.ACCEPT))[0] if jitter else steps[0] + rank * steps[1]
    left = np.flatnonzero((word >> _U64(32)) >= threshold)
    left = left[_is_rejected([d[left] for d in directions], word[left], bound[left], sky)]
    trial = 1
    while left.size and trial < int(k.LAST_TRIAL):
        first, second = philox(key, rank[left], band, trial)
        word = (((first & k.REST_BITS) << k.REST_SHIFT) | (second & k.REST_BITS)) << k.ACCEPT_SHIFT
        kind = directions[0].dtype
        u, v = unit(first & k.PLACE_BITS, kind), unit(second & k.PLACE_BITS, kind)
        q = tuple(values[left] for values in p)
        new = _from_mu2(q, u, *sincos_turned(q[4], q[5], q[3], v))
        for values, replaced in zip(directions, new, strict=True):
            values[left] = replaced
        left = left[_is_rejected(new, word, bound[left], sky)]
        trial += 1
    return directions
