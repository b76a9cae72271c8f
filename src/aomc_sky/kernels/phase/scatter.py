"""One scattering step: the formulas, + - x / sqrt and rounding alone, for arrays and for `jitted` to compile."""

from __future__ import annotations

import numpy as np

from aomc_sky.directions import COS_QUARTER as COS_F64
from aomc_sky.directions import SIN_QUARTER as SIN_F64


def cos_sin(share):
    """Cosine and sine of a share of the full turn; within 1.5 ulp of 1, and exact at quarter turns."""
    x = 4.0 * share
    turns = np.rint(x)
    r = x - turns
    t = r * r
    s = (((SIN_F64[0] * t + SIN_F64[1]) * t + SIN_F64[2]) * t + SIN_F64[3]) * t + SIN_F64[4]
    s = ((s * t + SIN_F64[5]) * t + SIN_F64[6]) * r
    c = (((COS_F64[0] * t + COS_F64[1]) * t + COS_F64[2]) * t + COS_F64[3]) * t + COS_F64[4]
    c = ((c * t + COS_F64[5]) * t + COS_F64[6]) * t + COS_F64[7]
    half = np.floor(0.5 * turns)
    swap = turns - (half + half)  # 1 in the quarters where sine and cosine change places
    flip = 1.0 - 2.0 * (half - 2.0 * np.floor(0.5 * half))
    stay = 1.0 - swap
    return flip * (stay * c - swap * s), flip * (stay * s + swap * c)


def turned(ux, uy, uz, one_minus_mu, sin_theta, cos_azimuth, sin_azimuth):
    """Direction after a turn by theta, with its length brought back to 1.

    The two tangents are those of Duff and others, which have no seam but the sign of uz and no pole. The
    part along the old direction loses (1 - mu) times itself, so that a small angle keeps its digits.
    """
    sign = np.copysign(1.0, uz)
    a = -1.0 / (sign + uz)
    b = ux * uy * a
    p = sin_theta * cos_azimuth
    q = sin_theta * sin_azimuth
    x = (ux - one_minus_mu * ux) + (p * (1.0 + sign * (ux * ux * a)) + q * b)
    y = (uy - one_minus_mu * uy) + (p * (sign * b) + q * (sign + uy * uy * a))
    z = (uz - one_minus_mu * uz) - (p * (sign * ux) + q * uy)
    scale = 1.5 - 0.5 * ((x * x + y * y) + z * z)  # 1 / length, its first two terms
    return x * scale, y * scale, z * scale
