"""The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample.

A number i splits into low = i mod 2^s and high = i >> s, with 2^s >= sqrt(N) and b = ceil(N / 2^s)
values of high. Three rounds of a Feistel network over Z_b x Z_(2^s) stir them: high, low, high.
Results at or beyond N walk on (probability below 2^s / N). A power of two as one radix spares every
photon a division, and starting with the high half makes three rounds behave as four (docs/decisions).
Up to 65535 x 2^16 photons all words have 32 bits, which vectorise twice as wide.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import SHORT_LIMIT
from aomc_sky.kernels.arithmetic.constants import STIR_A as _A
from aomc_sky.kernels.arithmetic.constants import STIR_B as _B
from aomc_sky.kernels.jit import inner_reader

_U32 = np.uint32
_U64 = np.uint64
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_CHUNK = np.uint64(256)
_S15 = np.uint32(15)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_BITS = np.uint32(31)
_S32 = np.uint64(32)


@inner_reader
def split_order(n):
    """Return (bits s of the low half, size b of the high half) for n >= 1 photons, both uint64."""
    s = _ONE
    while (_ONE << (s + s)) < n:
        s = s + _ONE
    return s, ((n - _ONE) >> s) + _ONE


@inner_reader
def _stir(half, key):
    """Hash a 32-bit word: two multiplications around one xor-shift, as in Wellons' lowbias32."""
    x = _U32(_U32(half * _A) + key)
    x = _U32(x ^ (x >> _S15))
    return _U32(x * _B)


@inner_reader
def _high_short(high, low, key, b):
    high = _U32(high + ((_U32(_stir(low, key) >> _S16) * _U32(b & _LOW16)) >> _S16))
    return min(high, _U32(high - b))  # wraps to a large number when high < b


@inner_reader
def _permute_short(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b), all in 32 bits: halves and b have at most 16.

    The masks change nothing; they tell the compiler that shifts and products stay within 32 bits,
    which it would otherwise compute in 64.
    """
    s = _U32(s & _BITS)
    rest = _U32((_U32(32) - s) & _BITS)
    mask = _U32((_U32(1) << s) - _U32(1))
    low = _U32(i & mask)
    high = _high_short(_U32(i >> s), low, k0, b)
    low = _U32(_U32(low + _U32(_stir(high, k1) >> rest)) & mask)
    high = _high_short(high, low, k2, b)
    return _U32(_U32(high << s) | low)


@inner_reader
def _high_step(low, key, b):
    return (_U64(_stir(_U32(low), key)) * b) >> _S32


@inner_reader
def _permute_long(i, s, b, k0, k1, k2):
    """One pass over [0, 2^s b) for more photons: halves have at most 31 bits."""
    mask = (_ONE << s) - _ONE
    low = i & mask
    high = (i >> s) + _high_step(low, k0, b)
    high = high - b if high >= b else high
    low = (low + (_U64(_stir(_U32(high), k1)) >> (_S32 - s))) & mask
    high = high + _high_step(low, k2, b)
    high = high - b if high >= b else high
    return (high << s) | low


@inner_reader
def _ranks_short(start, m, n, keys, rank):
    """Ranks beyond the end walk on; one in a chunk is rare, so that most chunks are left alone."""
    s64, b64 = split_order(n)
    s, b, last = _U32(s64), _U32(b64), _U32(n - _ONE)
    k0, k1, k2 = _U32(keys[0]), _U32(keys[1]), _U32(keys[2])
    for lo in range(_ZERO, m, _CHUNK):
        part = rank[lo : min(lo + _CHUNK, m)]
        first = _U32(start + lo)
        beyond = _U32(0)
        for j in range(part.size):
            r = _permute_short(_U32(first + _U32(j)), s, b, k0, k1, k2)
            part[j] = r
            beyond = _U32(beyond | _U32(r > last))
        if beyond != _U32(0):
            for j in range(part.size):
                r = _U32(part[j])
                while r > last:
                    r = _permute_short(r, s, b, k0, k1, k2)
                part[j] = r


@inner_reader
def _ranks_long(start, m, n, keys, rank):
    s, b = split_order(n)
    k0, k1, k2 = _U32(keys[0]), _U32(keys[1]), _U32(keys[2])
    for j in range(m):
        r = _permute_long(start + _U64(j), s, b, k0, k1, k2)
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
        last = _U32(n - _ONE)
        r = _permute_short(_U32(i), _U32(s), _U32(b), _U32(k0), _U32(k1), _U32(k2))
        while r > last:
            r = _permute_short(r, _U32(s), _U32(b), _U32(k0), _U32(k1), _U32(k2))
        return _U64(r)
    r = _permute_long(i, s, b, _U32(k0), _U32(k1), _U32(k2))
    while r >= n:
        r = _permute_long(r, s, b, _U32(k0), _U32(k1), _U32(k2))
    return r
