"""Philox4x32-10, addressed by counter (Salmon et al. 2011, known answers in tests/golden), for arrays and kernels.

The ten rounds are written out: a loop over rounds inside a large loop is not vectorised.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import LOW32, S32
from aomc_sky.kernels.formula import formulas

# multipliers and key steps (Salmon et al. 2011)
_M0 = np.uint64(0xD2511F53)
_M1 = np.uint64(0xCD9E8D57)
_W0 = np.uint64(0x9E3779B9)
_W1 = np.uint64(0xBB67AE85)

# later trials of a rejection divide two words: 42 bits of each for the place, 22 of each for the decision
_PLACE_BITS = np.uint64(2**64 - 2**22)
_REST_BITS = np.uint64(2**22 - 1)
_REST_SHIFT = np.uint64(22)
_ACCEPT_SHIFT = np.uint64(20)


def philox_round(c0, c1, c2, c3, k0, k1):
    """One round on 32-bit words held in uint64."""
    p0 = _M0 * c0
    p1 = _M1 * c2
    return (p1 >> S32) ^ c1 ^ k0, p1 & LOW32, (p0 >> S32) ^ c3 ^ k1, p0 & LOW32


def philox4x32(c0, c1, c2, c3, k0, k1):
    """Return the four 32-bit words of Philox4x32-10 for a counter and a key, held in uint64."""
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    c0, c1, c2, c3 = philox_round(c0, c1, c2, c3, k0, k1)
    k0 = (k0 + _W0) & LOW32
    k1 = (k1 + _W1) & LOW32
    return philox_round(c0, c1, c2, c3, k0, k1)


def philox_pair(key, rank, band, draw):
    """Two 64-bit uniform words for one photon: counter (rank low, rank high, band, draw), all uint64."""
    w0, w1, w2, w3 = philox4x32(rank & LOW32, rank >> S32, band, draw, key & LOW32, key >> S32)
    return (w0 << S32) | w1, (w2 << S32) | w3


def later_words(key, rank, band, trial):
    """The words of a trial after the first: two for the place, 42 bits each, and the one that decides."""
    first, second = philox_pair(key, rank, band, trial)
    decision = (((first & _REST_BITS) << _REST_SHIFT) | (second & _REST_BITS)) << _ACCEPT_SHIFT
    return first & _PLACE_BITS, second & _PLACE_BITS, decision


formulas(philox_round, philox4x32, philox_pair, later_words, is_inlined=True)
