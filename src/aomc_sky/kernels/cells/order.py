"""The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample.

A number i splits into low = i mod 2^s and high = i >> s, with 2^s >= sqrt(N) and b = ceil(N / 2^s)
values of high. Three rounds of a Feistel network over Z_b x Z_(2^s) stir them: high, low, high.
Results at or beyond N walk on (probability below 2^s / N). A power of two as one radix spares every
photon a division, and starting with the high half makes three rounds behave as four (docs/decisions).
Up to 65535 x 2^16 photons all words have 32 bits, which vectorise twice as wide.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ONE, S32, SHORT_LIMIT, U32, U64, ZERO
from aomc_sky.kernels.arithmetic.constants import STIR_A as _A
from aomc_sky.kernels.arithmetic.constants import STIR_B as _B
from aomc_sky.kernels.jit import inner_reader

_CHUNK = np.uint64(256)
_S15 = np.uint32(15)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_BITS = np.uint32(31)


@inner_reader
def split_order(n):
    """Return (bits s of the low half, size b of the high half) for n >= 1 photons, both uint64."""
    s = ONE
    while (ONE << (s + s)) < n:
        s = s + ONE
    return s, ((n - ONE) >> s) + ONE


@inner_reader
def _stir(half, key):
    """Hash a 32-bit word: two multiplications around one xor-shift, as in Wellons' lowbias32."""
    x = U32(U32(half * _A) + key)
    x = U32(x ^ (x >> _S15))
    return U32(x * _B)


@inner_reader
def _high_short(high, low, key, b):
    high = U32(high + ((U32(_stir(low, key) >> _S16) * U32(b & _LOW16)) >> _S16))
    return min(high, U32(high - b))  # wraps to a large number when high < b


@inner_reader
def _permute_short(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b), all in 32 bits: halves and b have at most 16.

    The masks change nothing; they tell the compiler that shifts and products stay within 32 bits,
    which it would otherwise compute in 64.
    """
    s = U32(s & _BITS)
    rest = U32((U32(32) - s) & _BITS)
    mask = U32((U32(1) << s) - U32(1))
    low = U32(i & mask)
    high = _high_short(U32(i >> s), low, k0, b)
    low = U32(U32(low + U32(_stir(high, k1) >> rest)) & mask)
    high = _high_short(high, low, k2, b)
    return U32(U32(high << s) | low)


@inner_reader
def _high_step(low, key, b):
    return (U64(_stir(U32(low), key)) * b) >> S32


@inner_reader
def _permute_long(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b) for more photons: halves have at most 31 bits."""
    mask = (ONE << s) - ONE
    low = i & mask
    high = (i >> s) + _high_step(low, k0, b)
    high = high - b if high >= b else high
    low = (low + (U64(_stir(U32(high), k1)) >> (S32 - s))) & mask
    high = high + _high_step(low, k2, b)
    high = high - b if high >= b else high
    return (high << s) | low


@inner_reader
def _ranks_short(start, m, n, keys, rank):
    """Ranks beyond the end walk on; one in a chunk is rare, so that most chunks are left alone."""
    s64, b64 = split_order(n)
    s, b, last = U32(s64), U32(b64), U32(n - ONE)
    k0, k1, k2 = U32(keys[0]), U32(keys[1]), U32(keys[2])
    for lo in range(ZERO, m, _CHUNK):
        part = rank[lo : min(lo + _CHUNK, m)]
        first = U32(start + lo)
        beyond = U32(0)
        for j in range(part.size):
            r = _permute_short(U32(first + U32(j)), s, b, k0, k1, k2)
            part[j] = r
            beyond = U32(beyond | U32(r > last))
        if beyond != U32(0):
            for j in range(part.size):
                r = U32(part[j])
                while r > last:
                    r = _permute_short(r, s, b, k0, k1, k2)
                part[j] = r


@inner_reader
def _ranks_long(start, m, n, keys, rank):
    s, b = split_order(n)
    k0, k1, k2 = U32(keys[0]), U32(keys[1]), U32(keys[2])
    for j in range(m):
        r = _permute_long(start + U64(j), s, b, k0, k1, k2)
        while r >= n:
            r = _permute_long(r, s, b, k0, k1, k2)
        rank[j] = r


@inner_reader
def shuffled_ranks(start, m, n, keys, rank):
    """Write the ranks of the photons [start, start + m) of n; all uint64, keys three 32-bit words."""
    if n <= SHORT_LIMIT:
        _ranks_short(start, m, n, keys, rank)
    else:
        _ranks_long(start, m, n, keys, rank)


@inner_reader
def rank_of_photon(i, order):
    """Rank of one photon, uint64; `order` holds n, what `split_order` says of it, and the three keys, all uint64."""
    n, s, b, k0, k1, k2 = order
    if n <= SHORT_LIMIT:
        last = U32(n - ONE)
        r = _permute_short(U32(i), U32(s), U32(b), U32(k0), U32(k1), U32(k2))
        while r > last:
            r = _permute_short(r, U32(s), U32(b), U32(k0), U32(k1), U32(k2))
        return U64(r)
    r = _permute_long(i, s, b, U32(k0), U32(k1), U32(k2))
    while r >= n:
        r = _permute_long(r, s, b, U32(k0), U32(k1), U32(k2))
    return r
