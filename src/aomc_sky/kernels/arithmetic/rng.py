"""Philox4x32-10, addressed by counter (Salmon et al. 2011, known answers in tests/golden).

The ten rounds are written out: a loop over rounds inside a large loop is not vectorised.
"""

from __future__ import annotations

from aomc_sky.kernels.arithmetic.constants import LOW32, S32
from aomc_sky.kernels.arithmetic.constants import PHILOX_M0 as _M0
from aomc_sky.kernels.arithmetic.constants import PHILOX_M1 as _M1
from aomc_sky.kernels.arithmetic.constants import PHILOX_W0 as _W0
from aomc_sky.kernels.arithmetic.constants import PHILOX_W1 as _W1
from aomc_sky.kernels.jit import inlined


@inlined
def philox_round(c0, c1, c2, c3, k0, k1):
    """One round on 32-bit words held in uint64."""
    p0 = _M0 * c0
    p1 = _M1 * c2
    return (p1 >> S32) ^ c1 ^ k0, p1 & LOW32, (p0 >> S32) ^ c3 ^ k1, p0 & LOW32


@inlined
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


@inlined
def philox_pair(key, rank, band, draw):
    """Two 64-bit uniform words for one photon: counter (rank low, rank high, band, draw)."""
    w0, w1, w2, w3 = philox4x32(rank & LOW32, rank >> S32, band, draw, key & LOW32, key >> S32)
    return (w0 << S32) | w1, (w2 << S32) | w3
