"""Numbers that the jitted kernels and their plain numpy form share; importing this costs nothing."""

from __future__ import annotations

import numpy as np

from aomc_sky.directions import COS_QUARTER, SIN_QUARTER

U32, U64 = np.uint32, np.uint64
ZERO, ONE, TWO, THREE, FOUR = (np.uint64(n) for n in range(5))
S11, S32 = np.uint64(11), np.uint64(32)
LOW32 = np.uint64(0xFFFFFFFF)
"""Types, and numbers of type uint64: beside a Python integer numba would make a float of one."""

# Philox4x32-10: multipliers and key steps (Salmon et al. 2011)
PHILOX_M0 = np.uint64(0xD2511F53)
PHILOX_M1 = np.uint64(0xCD9E8D57)
PHILOX_W0 = np.uint64(0x9E3779B9)
PHILOX_W1 = np.uint64(0xBB67AE85)

# R2 (Roberts 2018): 2^64 / g and 2^64 / g^2, g^3 = g + 1, rounded to the odd neighbour, so that the
# steps visit all 2^64 fractions
R2_STEP_U = np.uint64(13925035116211876495)
R2_STEP_V = np.uint64(10511698010929265437)
# from the first photon of a ring to that of the next: 2^64 over the golden ratio (odd), furthest from any fraction
RING_STEP = np.uint64(0x9E3779B97F4A7C15)

# hash of the keyed order, the multipliers of Wellons' lowbias32
STIR_A = np.uint32(0x7FEB352D)
STIR_B = np.uint32(0x846CA68B)
SHORT_LIMIT = np.uint64(65535 << 16)
"""Up to so many photons the keyed order works in 32 bits, and neither half has more than 65 535 values."""

# sin(pi r / 2) / r and cos(pi r / 2) as polynomials in r^2 for |r| <= 1/2, highest power first;
# minimax, fitted at 50 digits with rounded coefficients
SIN_F32 = tuple(
    np.float32(c) for c in (-0.004602149128913879, 0.07968021929264069, -0.6459634900093079, 1.5707963705062866)
)
COS_F32 = tuple(
    np.float32(c) for c in (0.0009067399078048766, -0.02086152881383896, 0.253669410943985, -1.2337005138397217, 1.0)
)
SIN_F64 = SIN_QUARTER
COS_F64 = COS_QUARTER

NARROW_HALF_WIDTH = 1.0 / 60.0
"""Up to so many quarter turns (1.5 degrees) a cell's azimuth takes the Taylor series below."""

# the same functions as series for |r| <= 1/60; the first term left out is below a third of an ulp of 1
# (float32) and a tenth (float64)
NARROW_SIN_F64 = (-0.004681754135318688, 0.07969262624616705, -0.6459640975062463, 1.5707963267948966)
NARROW_COS_F64 = (-0.02086348076335296, 0.25366950790104803, -1.2337005501361697, 1.0)
NARROW_SIN_F32 = tuple(np.float32(c) for c in NARROW_SIN_F64[2:])
NARROW_COS_F32 = tuple(np.float32(c) for c in NARROW_COS_F64[2:])

# ln 2 in two parts, and the polynomial of the exponential on |r| <= ln(2)/2, highest power first (fdlibm)
LN2_HI = 6.93147180369123816490e-01
LN2_LO = 1.90821492927058770002e-10
EXP = (
    4.13813679705723846039e-08,
    -1.65339022054652515390e-06,
    6.61375632143793436117e-05,
    -2.77777777770155933842e-03,
    1.66666666666666019037e-01,
)

# rejection inside a cell: step of the sequence that decides trial 0, 2^64 over the golden ratio (odd), and
# the draw of Philox that does it for photons without a sequence
ACCEPT_STEP = np.uint64(0x9E3779B97F4A7C15)
ACCEPT = np.uint64(1 << 31)
# where photons of lobes are concerned, the sequence is moved by half a hash of the rank, two odd multipliers (those of
# the generators of Steele and Vigna 2021)
ACCEPT_STIR_A = np.uint64(0xD1342543DE82EF95)
ACCEPT_STIR_B = np.uint64(0xAF251AF3B0F025B5)
# later trials divide two words: 42 bits of each for the place, 22 of each for the decision
PLACE_BITS = np.uint64(2**64 - 2**22)
REST_BITS = np.uint64(2**22 - 1)
REST_SHIFT = np.uint64(22)
ACCEPT_SHIFT = np.uint64(20)
LAST_TRIAL = np.uint64(100_000)
"""The last try is taken whatever it is: a cell without light in float32 must not hang a run."""

# the slope along which photons are sent inside a cell before the rejection: 10 bits for each direction
TILT_STEP = 2.0**-11

NARROW, QUARTER, ANY_WIDTH, IN_MU = (np.uint64(way) for way in range(4))
"""The way of most slots: uniform in mu^2 in cells of at most 3 degrees of azimuth, at most 90, of any width; in mu."""
