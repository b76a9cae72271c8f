"""One scattering step: the formulas, + - x / sqrt and rounding alone, for arrays and for `jitted` to compile."""

from __future__ import annotations

import numpy as np


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
