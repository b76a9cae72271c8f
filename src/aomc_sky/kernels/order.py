"""The keyed order of photons: a bijection on [0, N), so that every prefix of a run is a fair sample.

A number i splits into (left, right) with left = i mod 2^s, right = i >> s, 2^s >= sqrt(N). Four
rounds of a Feistel network over Z_(2^s) x Z_b, b = ceil(N / 2^s), stir the halves; results at or
beyond N walk on (probability below 2^s / N). The radix is a power of two, so that no photon pays
for a division.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel

_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)
_ONE = np.uint64(1)
_ZERO = np.uint64(0)
_A = np.uint64(0x7FEB352D)
_B = np.uint64(0x846CA68B)
_S15 = np.uint64(15)
_S16 = np.uint64(16)


@inner
def _stir(half, key, size):
    """Hash a 32-bit half into [0, size): Wellons' lowbias32 without its last step, then multiply-shift."""
    x = (half ^ key) & _LOW
    x = ((x ^ (x >> _S16)) * _A) & _LOW
    x = ((x ^ (x >> _S15)) * _B) & _LOW
    return (x * size) >> _S32


@inner
def split_order(n):
    """Return (bits s of the left half, size b of the right half) for n >= 1 photons."""
    s = _ZERO
    while (_ONE << (s + s)) < n:
        s += _ONE
    return s, ((n - _ONE) >> s) + _ONE


@inner
def permute_step(i, s, b, k0, k1, k2, k3):
    """One pass of the network over [0, 2^s b)."""
    mask = (_ONE << s) - _ONE
    size = mask + _ONE
    left = i & mask
    right = i >> s
    left = (left + _stir(right, k0, size)) & mask
    right = right + _stir(left, k1, b)
    right = right - b if right >= b else right
    left = (left + _stir(right, k2, size)) & mask
    right = right + _stir(left, k3, b)
    right = right - b if right >= b else right
    return (right << s) | left


@inner
def unpermute_step(i, s, b, k0, k1, k2, k3):
    """Inverse of `permute_step`."""
    mask = (_ONE << s) - _ONE
    size = mask + _ONE
    left = i & mask
    right = i >> s
    right = right + b - _stir(left, k3, b)
    right = right - b if right >= b else right
    left = (left - _stir(right, k2, size)) & mask
    right = right + b - _stir(left, k1, b)
    right = right - b if right >= b else right
    left = (left - _stir(right, k0, size)) & mask
    return (right << s) | left


@kernel
def ranks_of_indices(index, n, keys, out):
    """Rank of each photon index; both uint64 arrays, keys four 32-bit words in uint64."""
    s, b = split_order(n)
    k0, k1, k2, k3 = keys[0], keys[1], keys[2], keys[3]
    for j in range(index.size):
        i = permute_step(index[j], s, b, k0, k1, k2, k3)
        while i >= n:
            i = permute_step(i, s, b, k0, k1, k2, k3)
        out[j] = i


@kernel
def indices_of_ranks(rank, n, keys, out):
    """Photon index that has each rank: the inverse of `ranks_of_indices`."""
    s, b = split_order(n)
    k0, k1, k2, k3 = keys[0], keys[1], keys[2], keys[3]
    for j in range(rank.size):
        i = unpermute_step(rank[j], s, b, k0, k1, k2, k3)
        while i >= n:
            i = unpermute_step(i, s, b, k0, k1, k2, k3)
        out[j] = i
