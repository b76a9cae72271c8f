"""Our own elementary functions: + - x / sqrt and integers only, so that every machine gives the same bits.

Results of libm and numpy differ in the last bit in 3 to 7 % of cases, from each other and between processors. Photons
that depend on them are not reproducible. Each function states its error, which the tests measure against 50-digit
arithmetic. One text serves arrays and kernels.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.directions import COS_QUARTER, SIN_QUARTER
from aomc_sky.kernels.formula import (
    by_width,
    float_of,
    formulas,
    kind_of,
    larger,
    nested,
    select,
    smaller,
    word_of,
)

HALF_PI = 1.5707963267948966
NARROW_HALF_WIDTH = 1.0 / 60.0
"""Up to so many quarter turns (1.5 degrees) a cell's azimuth takes the short series."""

LN2_HI = 6.93147180369123816490e-01
LN2_LO = 1.90821492927058770002e-10
"""ln 2 in two parts (fdlibm)."""

# sin(pi r / 2) / r and cos(pi r / 2) as polynomials in r^2 for |r| <= 1/2, highest power first;
# minimax, fitted at 50 digits with rounded coefficients
_SIN_F32 = tuple(
    np.float32(c) for c in (-0.004602149128913879, 0.07968021929264069, -0.6459634900093079, 1.5707963705062866)
)
_COS_F32 = tuple(
    np.float32(c) for c in (0.0009067399078048766, -0.02086152881383896, 0.253669410943985, -1.2337005138397217, 1.0)
)

# the same functions as Taylor series for |r| <= 1/60; the first term left out is below a third of an ulp of 1
# (float32) and a tenth (float64)
_NARROW_SIN_F64 = (-0.004681754135318688, 0.07969262624616705, -0.6459640975062463, 1.5707963267948966)
_NARROW_COS_F64 = (-0.02086348076335296, 0.25366950790104803, -1.2337005501361697, 1.0)
_NARROW_SIN_F32 = tuple(np.float32(c) for c in _NARROW_SIN_F64[2:])
_NARROW_COS_F32 = tuple(np.float32(c) for c in _NARROW_COS_F64[2:])

# the polynomial of the exponential on |r| <= ln(2)/2, highest power first (fdlibm)
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
    1.0,
)
_LOG = tuple(2.0 / k for k in range(21, 2, -2))

_S24 = np.uint64(40)
_UPPER53 = np.uint64(0xFFFFFFFFFFFFF800)
_INV24 = np.float32(2.0**-24)
_INV64 = 2.0**-64
_ROUND = 6755399441055744.0  # 1.5 x 2^52: adding it rounds to a whole number, kept in the low bits
_BIAS = np.int64(1023)
_POWER_BITS = np.int64(52)
_FRACTION = np.int64(2**52 - 1)
_HALF = np.int64(1022 << 52)
_AT_2_52 = np.int64((1023 + 52) << 52)  # 2^52 as a float64: in its last bits a whole number stands for itself
_FROM_POWER = 2.0**52 + 1022
_LARGEST = 700.0


def _unit_f32(bits, like):
    # 24 bits and no offset: half an ulp more would round to exactly 1
    return np.float32(np.int32(bits >> _S24)) * _INV24


def _unit_f64(bits, like):
    return np.float64(bits & _UPPER53) * _INV64


#: Turn a 64-bit word into a uniform number in [0, 1): 24 bits for float32, 53 for float64. The 53 bits stay where they
#: are: if the top bit may be set, AVX2, which has no such conversion, converts by halves; else one number at a time.
unit = by_width(_unit_f32, _unit_f64)


def uniform_f64(bits):
    """Uniform float64 in [0, 1) of 53 bits, whatever the precision of the photons."""
    return np.float64(bits & _UPPER53) * _INV64


def _series(sine, cosine):
    def text(r):
        t = r * r
        return nested(sine, t) * r, nested(cosine, t)

    return text


#: Sine and cosine of r quarter turns, |r| <= 1/2; within 2 ulp.
sincos_quarter = by_width(_series(_SIN_F32, _COS_F32), _series(SIN_QUARTER, COS_QUARTER))

#: Sine and cosine of r quarter turns, |r| <= 1/60; within 2 ulp of the result (sine) or of 1 (cosine).
sincos_narrow = by_width(_series(_NARROW_SIN_F32, _NARROW_COS_F32), _series(_NARROW_SIN_F64, _NARROW_COS_F64))


def sincos_turned(sin_centre, cos_centre, half_width, v):
    """Sine and cosine of the azimuth a share v of the way through a cell at most 90 degrees wide.

    The cell reaches `half_width` quarter turns (0 to 1/2) to both sides of its centre, whose sine and
    cosine come from a table. Absolute error below 2 ulp of 1.
    """
    s, c = sincos_quarter(half_width * (v + v - kind_of(v)(1)))
    return sin_centre * c + cos_centre * s, cos_centre * c - sin_centre * s


def sincos_turned_narrow(sin_centre, cos_centre, half_width, v):
    """`sincos_turned` for a cell whose half width is at most NARROW_HALF_WIDTH, by the short series."""
    s, c = sincos_narrow(half_width * (v + v - kind_of(v)(1)))
    return sin_centre * c + cos_centre * s, cos_centre * c - sin_centre * s


def sincos_turned_any(sin_centre, cos_centre, half_width, v):
    """Both for any width up to a full turn (half_width 2), the same bits: it looks which series is due.

    Absolute error below 3.5 ulp of 1.
    """
    x = half_width * (v + v - kind_of(v)(1))
    turns = np.rint(x)
    s0, c0 = sincos_quarter(x - turns)
    s1, c1 = sincos_narrow(x - turns)
    is_narrow = half_width <= kind_of(v)(NARROW_HALF_WIDTH)
    s, c = turned_by_quarters(np.int32(turns), select(is_narrow, s1, s0), select(is_narrow, c1, c0))
    return sin_centre * c + cos_centre * s, cos_centre * c - sin_centre * s


def turned_by_quarters(quarter, sine, cosine):
    """Sine and cosine of an angle after so many quarter turns."""
    swap = (quarter & 1) != 0
    s, c = select(swap, cosine, sine), select(swap, sine, cosine)
    return select((quarter & 2) != 0, -s, s), select(((quarter + 1) & 2) != 0, -c, c)


def split_power(x):
    """Split a normal positive float64 into m in [1/2, 1) and whole k with x = m 2^k, both float64."""
    word = word_of(x)
    return float_of((word & _FRACTION) | _HALF), float_of((word >> _POWER_BITS) | _AT_2_52) - _FROM_POWER


def log_of_parts(f, k):
    """log(2^k (1 + f)) for 1 + f in [sqrt(1/2), sqrt(2)], within 1 ulp.

    With s = f / (2 + f), log(1 + f) = 2 atanh(s) is summed as an odd series up to s^21.
    """
    s = f / (2.0 + f)
    z = s * s
    half = 0.5 * f * f
    r = nested(_LOG, z) * z
    return k * LN2_HI - ((half - (s * (half + r) + k * LN2_LO)) - f)


def log_level(x):
    """Natural logarithm of a normal positive float64, branch-free; within 1 ulp."""
    m, k = split_power(x)
    is_low = m < 0.7071067811865476
    return log_of_parts(select(is_low, m + m, m) - 1.0, select(is_low, k - 1.0, k))


def exp_reduced(hi, lo):
    """Exponential of r = hi - lo, |r| <= ln(2)/2: what is left once the power of two is taken out."""
    r = hi - lo
    z = r * r
    c = r - z * nested(_EXP, z)
    return 1.0 - ((lo - (r * c) / (2.0 - c)) - hi)


def exp_level(x):
    """Exponential of a float64, branch-free; within 1 ulp for |x| <= 700, beyond that the value at +-700."""
    x = larger(smaller(x, _LARGEST), -_LARGEST)
    t = x * 1.4426950408889634 + _ROUND
    k = t - _ROUND
    y = exp_reduced(x - k * LN2_HI, k * LN2_LO)
    return y * float_of((word_of(t) + _BIAS) << _POWER_BITS)


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


def sin_cos(x):
    """Sine and cosine of x quarter turns, exact at whole ones; within 2 ulp of 1 for |x| below 1000."""
    turns = np.rint(x)
    s, c = sincos_quarter(x - turns)
    return turned_by_quarters(np.int64(turns), s, c)


def half_sine2(x):
    """sin^2 of half of x quarter turns."""
    s, _ = sin_cos(0.5 * x)
    return s * s


formulas(sincos_turned, sincos_turned_narrow, sincos_turned_any, sin_cos, half_sine2)
formulas(
    uniform_f64, turned_by_quarters, split_power, log_of_parts, log_level, exp_reduced, exp_level, arc, is_inlined=True
)
