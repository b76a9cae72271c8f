"""Random words and elementary functions over arrays, in plain numpy: equal to `rng` and `elementary` to the bit.

Only + - x / sqrt, integers and rounding are used, so numpy gives the same bits as the kernels everywhere.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import constants as k
from aomc_sky.kernels.arithmetic.constants import LOW32, S32, U64

_ROUND = 6755399441055744.0


def philox(key: np.uint64, rank: np.ndarray, band: int, draw: int) -> tuple[np.ndarray, np.ndarray]:
    """Two 64-bit words for each rank: counter (rank low, rank high, band, draw)."""
    c0, c1 = rank & LOW32, rank >> S32
    c2, c3 = np.full_like(rank, band), np.full_like(rank, draw)
    k0, k1 = key & LOW32, key >> S32
    for _ in range(10):
        p0, p1 = k.PHILOX_M0 * c0, k.PHILOX_M1 * c2
        c0, c1, c2, c3 = (p1 >> S32) ^ c1 ^ k0, p1 & LOW32, (p0 >> S32) ^ c3 ^ k1, p0 & LOW32
        k0, k1 = (k0 + k.PHILOX_W0) & LOW32, (k1 + k.PHILOX_W1) & LOW32
    return (c0 << S32) | c1, (c2 << S32) | c3


def unit(bits: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Uniform numbers in [0, 1): 24 bits for float32, 53 for float64."""
    if dtype == np.float32:
        return (bits >> U64(40)).astype(np.float32) * np.float32(2.0**-24)
    return (bits >> U64(11)).astype(np.float64) * 2.0**-53


def sincos_quarter(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of r quarter turns, |r| <= 1/2."""
    short = r.dtype == np.float32
    t = r * r
    return nested(k.SIN_F32 if short else k.SIN_F64, t) * r, nested(k.COS_F32 if short else k.COS_F64, t)


def sincos_narrow(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of r quarter turns, |r| <= 1/60, by the shorter series."""
    short = r.dtype == np.float32
    t = r * r
    sine = nested(k.NARROW_SIN_F32 if short else k.NARROW_SIN_F64, t)
    return sine * r, nested(k.NARROW_COS_F32 if short else k.NARROW_COS_F64, t)


def nested(coefficients, t):
    """A polynomial, the highest power first."""
    value = np.full_like(t, coefficients[0])
    for coefficient in coefficients[1:]:
        value *= t
        value += coefficient
    return value


def sincos_turned(t0, t1, half_width, v):
    """Sine and cosine of the azimuth a share v of the way through a cell of any width."""
    x = half_width * (v + v - v.dtype.type(1))
    turns = np.rint(x)
    is_narrow = half_width <= v.dtype.type(k.NARROW_HALF_WIDTH)
    if np.all(is_narrow):
        s0, c0 = sincos_narrow(x)
        return t0 * c0 + t1 * s0, t1 * c0 - t0 * s0
    s0, c0 = sincos_quarter(x - turns)
    if np.any(is_narrow):
        s1, c1 = sincos_narrow(x - turns)
        s0, c0 = np.where(is_narrow, s1, s0), np.where(is_narrow, c1, c0)
    quarter = turns.astype(np.int32)
    swap = (quarter & 1) != 0
    s, c = np.where(swap, c0, s0), np.where(swap, s0, c0)
    s = np.where((quarter & 2) != 0, -s, s)
    c = np.where(((quarter + 1) & 2) != 0, -c, c)
    return t0 * c + t1 * s, t1 * c - t0 * s


def exp_reduced(hi, lo):
    """Exponential of r = hi - lo, |r| <= ln(2)/2: what is left once the power of two is taken out."""
    r = hi - lo
    z = r * r
    c = r - z * nested(k.EXP, z)
    return 1.0 - ((lo - (r * c) / (2.0 - c)) - hi)


def exp_level(x):
    """Exponential for |x| <= 700, beyond that the value at +-700."""
    x = np.maximum(np.minimum(np.asarray(x, dtype=np.float64), 700.0), -700.0)
    t = x * 1.4426950408889634 + _ROUND
    turns = t - _ROUND
    y = exp_reduced(x - turns * k.LN2_HI, turns * k.LN2_LO)
    return y * ((t.view(np.int64) + 1023) << 52).view(np.float64)
