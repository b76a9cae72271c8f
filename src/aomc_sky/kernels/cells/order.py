"""The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample.

A number i splits into low = i mod 2^s and high = i >> s, with 2^s >= sqrt(N) and b = ceil(N / 2^s)
values of high. Three rounds of a Feistel network over Z_b x Z_(2^s) mix them: high, low, high.
Results at or beyond N walk on (probability below 2^s / N). A power of two as one radix spares every
photon a division, and starting with the high half makes three rounds behave as four (docs/decisions).
Up to 65535 x 2^16 photons all words have 32 bits, which vectorise twice as wide.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ONE, S32, U32, U64
from aomc_sky.kernels.formula import formulas, select, smaller

SHORT_LIMIT = np.uint64(65535 << 16)
"""Up to so many photons the order works in 32 bits, and neither half has more than 65 535 values."""

# hash of the keyed order, the multipliers of Wellons' lowbias32
_A = np.uint32(0x7FEB352D)
_B = np.uint32(0x846CA68B)
_S15 = np.uint32(15)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_BITS = np.uint32(31)
_TABLE_LIMIT = 1 << 24


def split_order(n):
    """Return (bits s of the low half, size b of the high half) for n >= 1 photons, all uint64."""
    s = ONE
    while (ONE << (s + s)) < n:
        s = s + ONE
    return s, ((n - ONE) >> s) + ONE


def mix(half, key):
    """Hash a 32-bit word: two multiplications around one xor-shift, as in Wellons' lowbias32."""
    x = U32(U32(half * _A) + key)
    x = U32(x ^ (x >> _S15))
    return U32(x * _B)


def _high_short(high, low, key, b):
    high = U32(high + ((U32(mix(low, key) >> _S16) * U32(b & _LOW16)) >> _S16))
    return smaller(high, U32(high - b))  # wraps to a large number when high < b


def permute_short(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b), all in 32 bits: halves and b have at most 16.

    The masks change nothing; they tell the compiler that shifts and products stay within 32 bits,
    which it would otherwise compute in 64.
    """
    s = U32(s & _BITS)
    rest = U32((U32(32) - s) & _BITS)
    mask = U32((U32(1) << s) - U32(1))
    low = U32(i & mask)
    high = _high_short(U32(i >> s), low, k0, b)
    low = U32(U32(low + U32(mix(high, k1) >> rest)) & mask)
    high = _high_short(high, low, k2, b)
    return U32(U32(high << s) | low)


def high_step(low, key, b):
    """Step of the high half in a round, from the low half."""
    return (U64(mix(U32(low), key)) * b) >> S32


def permute_long(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b) for more photons: halves have at most 31 bits."""
    mask = (ONE << s) - ONE
    low = i & mask
    high = (i >> s) + high_step(low, k0, b)
    high = select(high >= b, high - b, high)
    low = (low + (U64(mix(U32(high), k1)) >> (S32 - s))) & mask
    high = high + high_step(low, k2, b)
    high = select(high >= b, high - b, high)
    return (high << s) | low


def ranks_of_photons(start: int, stop: int, n: int, keys: np.ndarray) -> np.ndarray:
    """Rank of each photon of [start, stop) of n, uint64, in plain numpy."""
    permute, word = (permute_short, U32) if n <= SHORT_LIMIT else (permute_long, U64)
    parameters = *map(word, split_order(U64(n))), *(U32(key) for key in keys)
    rank = permute(np.arange(start, stop, dtype=U64).astype(word), *parameters)
    while True:
        beyond = np.flatnonzero(rank > word(n - 1))
        if beyond.size == 0:
            return rank.astype(U64)
        rank[beyond] = permute(rank[beyond], *parameters)


def slot_finder(cumulative: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function from ranks to slots; `cumulative` (n_slot + 1,) starts with 0 and ends with N."""
    n = int(cumulative[-1])
    if n <= _TABLE_LIMIT:
        slots = np.repeat(np.arange(cumulative.size - 1, dtype=np.int32), np.diff(cumulative).astype(np.int64))
        return lambda rank: slots[rank.astype(np.int64)]
    ends = cumulative[1:].astype(U64)
    return lambda rank: np.searchsorted(ends, rank, side="right").astype(np.int32)


formulas(split_order, mix, _high_short, permute_short, high_step, permute_long)
