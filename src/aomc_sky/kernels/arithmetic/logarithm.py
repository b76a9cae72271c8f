"""The logarithm's series: + - x / alone, for arrays, and for `elementary` to compile."""

from __future__ import annotations

from aomc_sky.kernels.arithmetic.constants import LN2_HI, LN2_LO


def log_of_parts(f, k):
    """log(2^k (1 + f)) for 1 + f in [sqrt(1/2), sqrt(2)], within 1 ulp.

    With s = f / (2 + f), log(1 + f) = 2 atanh(s) is summed as an odd series up to s^21.
    """
    s = f / (2.0 + f)
    z = s * s
    p = 2.0 / 21.0
    p = p * z + 2.0 / 19.0
    p = p * z + 2.0 / 17.0
    p = p * z + 2.0 / 15.0
    p = p * z + 2.0 / 13.0
    p = p * z + 2.0 / 11.0
    p = p * z + 2.0 / 9.0
    p = p * z + 2.0 / 7.0
    p = p * z + 2.0 / 5.0
    p = p * z + 2.0 / 3.0
    half = 0.5 * f * f
    r = p * z
    return k * LN2_HI - ((half - (s * (half + r) + k * LN2_LO)) - f)
