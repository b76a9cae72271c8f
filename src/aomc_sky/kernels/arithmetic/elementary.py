"""Our own elementary functions: + - x / sqrt and integers only, so that every machine gives the same bits.

libm and numpy differ from each other, and from themselves on another processor, in the last bit of
3 to 7 % of their results; a photon that depends on them is not reproducible. Each function states
its error, which the tests measure against 50-digit arithmetic.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba.extending import intrinsic

from aomc_sky.kernels.arithmetic import logarithm
from aomc_sky.kernels.arithmetic.constants import COS_F32 as _C32
from aomc_sky.kernels.arithmetic.constants import COS_F64 as _C64
from aomc_sky.kernels.arithmetic.constants import EXP as _EXP
from aomc_sky.kernels.arithmetic.constants import LN2_HI, LN2_LO, NARROW_HALF_WIDTH
from aomc_sky.kernels.arithmetic.constants import NARROW_COS_F32 as _NC32
from aomc_sky.kernels.arithmetic.constants import NARROW_COS_F64 as _NC64
from aomc_sky.kernels.arithmetic.constants import NARROW_SIN_F32 as _NS32
from aomc_sky.kernels.arithmetic.constants import NARROW_SIN_F64 as _NS64
from aomc_sky.kernels.arithmetic.constants import SIN_F32 as _S32
from aomc_sky.kernels.arithmetic.constants import SIN_F64 as _S64
from aomc_sky.kernels.jit import inlined, inner, overloads

_S24 = np.uint64(40)
_S53 = np.uint64(11)
_S52 = np.uint64(52)
_FRACTION = np.uint64(2**52 - 1)
_HALF = np.uint64(1022 << 52)
_INV24 = np.float32(2.0**-24)
_INV53 = 2.0**-53
_ROUND = 6755399441055744.0  # 1.5 x 2^52: adding it rounds to a whole number, kept in the low bits
_BIAS = np.int64(1023)
_POWER_BITS = np.int64(52)
_LARGEST = 700.0


def _unit_f32(bits, like):
    # 24 bits and no offset: half an ulp more would round to exactly 1
    return np.float32(np.int32(bits >> _S24)) * _INV24


def _unit_f64(bits, like):
    return np.float64(np.int64(bits >> _S53)) * _INV53


def unit(bits, like):
    """Turn a 64-bit word into a uniform number in [0, 1): 24 bits for float32, 53 for float64.

    `like` is any number of the wanted precision.
    """
    return _unit_f32(bits, like) if isinstance(like, np.float32) else _unit_f64(bits, like)


@overloads(unit)
def _unit_overload(bits, like):
    return _unit_f32 if like == numba.types.float32 else _unit_f64


def _sincos_quarter_f32(r):
    t = r * r
    s = ((_S32[0] * t + _S32[1]) * t + _S32[2]) * t + _S32[3]
    c = (((_C32[0] * t + _C32[1]) * t + _C32[2]) * t + _C32[3]) * t + _C32[4]
    return s * r, c


def _sincos_quarter_f64(r):
    t = r * r
    s = (((_S64[0] * t + _S64[1]) * t + _S64[2]) * t + _S64[3]) * t + _S64[4]
    s = (s * t + _S64[5]) * t + _S64[6]
    c = (((_C64[0] * t + _C64[1]) * t + _C64[2]) * t + _C64[3]) * t + _C64[4]
    c = ((c * t + _C64[5]) * t + _C64[6]) * t + _C64[7]
    return s * r, c


def sincos_quarter(r):
    """Sine and cosine of r quarter turns, |r| <= 1/2; within 2 ulp (float32) and 1.5 ulp (float64)."""
    return _sincos_quarter_f32(r) if isinstance(r, np.float32) else _sincos_quarter_f64(r)


@overloads(sincos_quarter)
def _sincos_quarter_overload(r):
    return _sincos_quarter_f32 if r == numba.types.float32 else _sincos_quarter_f64


def _sincos_narrow_f32(r):
    t = r * r
    return (_NS32[0] * t + _NS32[1]) * r, _NC32[0] * t + _NC32[1]


def _sincos_narrow_f64(r):
    t = r * r
    s = ((_NS64[0] * t + _NS64[1]) * t + _NS64[2]) * t + _NS64[3]
    c = ((_NC64[0] * t + _NC64[1]) * t + _NC64[2]) * t + _NC64[3]
    return s * r, c


def sincos_narrow(r):
    """Sine and cosine of r quarter turns, |r| <= 1/60; within 2 ulp of the result (sine) or of 1 (cosine)."""
    return _sincos_narrow_f32(r) if isinstance(r, np.float32) else _sincos_narrow_f64(r)


@overloads(sincos_narrow)
def _sincos_narrow_overload(r):
    return _sincos_narrow_f32 if r == numba.types.float32 else _sincos_narrow_f64


@inner
def sincos_turned(sin_centre, cos_centre, half_width, v, is_narrow):
    """Sine and cosine of the azimuth a share v of the way through a cell at most 90 degrees wide.

    The cell reaches `half_width` quarter turns (0 to 1/2) to both sides of its centre, whose sine and
    cosine come from a table. `is_narrow` (True or None) promises at most 1/60, where a shorter series
    does. Absolute error below 2 ulp of 1.
    """
    r = half_width * (v + v - type(v)(1))
    if is_narrow is None:
        s, c = sincos_quarter(r)
    else:
        s, c = sincos_narrow(r)
    return sin_centre * c + cos_centre * s, cos_centre * c - sin_centre * s


@inner
def sincos_turned_any(sin_centre, cos_centre, half_width, v):
    """`sincos_turned` for any width up to a full turn (half_width 2), the same bits: it looks which series is due."""
    x = half_width * (v + v - type(v)(1))
    turns = np.rint(x)
    r = x - turns
    s0, c0 = sincos_quarter(r)
    s1, c1 = sincos_narrow(r)
    is_narrow = half_width <= type(v)(NARROW_HALF_WIDTH)
    s0 = s1 if is_narrow else s0
    c0 = c1 if is_narrow else c0
    quarter = np.int32(turns)
    swap = (quarter & 1) != 0
    s = c0 if swap else s0
    c = s0 if swap else c0
    s = -s if (quarter & 2) != 0 else s
    c = -c if ((quarter + 1) & 2) != 0 else c
    return sin_centre * c + cos_centre * s, cos_centre * c - sin_centre * s


log_of_parts = inlined(logarithm.log_of_parts)


def split_power(x):
    """Split a normal positive float64 into m in [1/2, 1) and whole k with x = m 2^k, both float64; vectorises."""
    m, k = math.frexp(x)
    return m, float(k)


@intrinsic
def _word_of(context, x):
    def bits(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], context.get_value_type(numba.types.uint64))

    return numba.types.uint64(numba.types.float64), bits


@intrinsic
def _float_of(context, word):
    def value(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], context.get_value_type(numba.types.float64))

    return numba.types.float64(numba.types.uint64), value


@overloads(split_power)
def _split_power_overload(x):
    def split(x):
        word = _word_of(x)
        k = np.float64(np.int64(word >> _S52) - 1022)
        return _float_of((word & _FRACTION) | _HALF), k

    return split


@inner
def log(x):
    """Natural logarithm of a positive float64; within 1 ulp for normal numbers.

    The argument is split exactly into 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)); see `logarithm`.
    """
    m, k = math.frexp(x)
    if m < 0.7071067811865476:
        m = m + m
        k = k - 1
    return log_of_parts(m - 1.0, k)


@inlined
def exp_reduced(hi, lo):
    """Exponential of r = hi - lo, |r| <= ln(2)/2: what is left once the power of two is taken out."""
    r = hi - lo
    z = r * r
    c = r - z * ((((_EXP[0] * z + _EXP[1]) * z + _EXP[2]) * z + _EXP[3]) * z + _EXP[4])
    return 1.0 - ((lo - (r * c) / (2.0 - c)) - hi)


@inner
def exp(x):
    """Exponential of a float64 in [-745, 709]; within 1 ulp where the result is a normal number."""
    if x < -745.2:
        return 0.0
    k = np.rint(x * 1.4426950408889634)
    return math.ldexp(exp_reduced(x - k * LN2_HI, k * LN2_LO), int(k))


@inlined
def exp_level(x):
    """Exponential of a float64, branch-free; within 1 ulp for |x| <= 700, beyond that the value at +-700."""
    x = max(min(x, _LARGEST), -_LARGEST)
    t = x * 1.4426950408889634 + _ROUND
    k = t - _ROUND
    y = exp_reduced(x - k * LN2_HI, k * LN2_LO)
    power = (np.float64(t).view(np.int64) + _BIAS) << _POWER_BITS
    return y * np.int64(power).view(np.float64)
