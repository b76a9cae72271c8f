"""Order, cells and laws of a block of photons in plain numpy, equal to `order`, `slots` and `laws` to the bit."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import constants as k
from aomc_sky.kernels.arithmetic.constants import U32, U64
from aomc_sky.kernels.arithmetic.plain import philox, sincos_turned, unit

CELL_MU2, CELL_MU, BEAM, DISC, DISC_AT_HORIZON, PEREZ, HG, GGX, BECKMANN = range(9)

_TABLE_LIMIT = 1 << 24


def _stir(half: np.ndarray, key: np.uint32) -> np.ndarray:
    x = half * k.STIR_A + key
    x ^= x >> U32(15)
    return x * k.STIR_B


def split_order(n: int) -> tuple[int, int]:
    """Bits of the low half and size of the high half for n photons."""
    s = 1
    while 1 << 2 * s < n:
        s += 1
    return s, (n - 1 >> s) + 1


def _permute(i: np.ndarray, n: int, keys: np.ndarray) -> np.ndarray:
    """One pass of the keyed order; see `order`."""
    s, b = split_order(n)
    bits = 16 if n <= k.SHORT_LIMIT else 32
    mask, size, down = U64((1 << s) - 1), U64(b), U64(32 - s)
    low, high = i & mask, i >> U64(s)

    def step(high: np.ndarray, low: np.ndarray, key: np.uint64) -> np.ndarray:
        stirred = _stir(low.astype(U32), U32(key)).astype(U64)
        high = high + (((stirred >> U64(32 - bits)) * size) >> U64(bits))
        return np.where(high >= size, high - size, high)

    high = step(high, low, keys[0])
    low = (low + (_stir(high.astype(U32), U32(keys[1])).astype(U64) >> down)) & mask
    high = step(high, low, keys[2])
    return (high << U64(s)) | low


def shuffled_ranks(start: int, stop: int, n: int, keys: np.ndarray) -> np.ndarray:
    """Rank of each photon of [start, stop), uint64."""
    rank = _permute(np.arange(start, stop, dtype=U64), n, keys)
    while True:
        beyond = np.flatnonzero(rank >= U64(n))
        if beyond.size == 0:
            return rank
        rank[beyond] = _permute(rank[beyond], n, keys)


def slot_finder(cumulative: np.ndarray):
    """Return a function from ranks to slots; `cumulative` (n_slot + 1,) starts with 0 and ends with N."""
    n = int(cumulative[-1])
    if n <= _TABLE_LIMIT:
        slots = np.repeat(np.arange(cumulative.size - 1, dtype=np.int32), np.diff(cumulative).astype(np.int64))
        return lambda rank: slots[rank.astype(np.int64)]
    ends = cumulative[1:].astype(U64)
    return lambda rank: np.searchsorted(ends, rank, side="right").astype(np.int32)


def from_mu2(h, u, sine, cosine):
    """Travel directions for azimuths, uniform in mu^2."""
    one = u.dtype.type(1)
    radius = np.sqrt(h[0] + h[1] * u)
    return -(radius * cosine), -(radius * sine), -np.sqrt(h[2] + h[1] * (one - u))


def _from_mu(h, u, sine, cosine):
    one = u.dtype.type(1)
    mu = h[2] + h[1] * (one - u)
    radius = np.sqrt((h[0] + h[1] * u) * (one + mu))
    return -(radius * cosine), -(radius * sine), -mu


def _disc(p, u, v):
    h0, h1, h2, h3, t0, t1 = p
    kind = u.dtype.type
    s, c = sincos_turned(kind(0), kind(1), kind(2), v)
    root = np.sqrt(u)
    along, across = h2 * root * c, h2 * root * s
    x = h3 * h0 + along * h1
    height = h3 * h1 - along * h0
    mu = np.sqrt(height * height + h2 * h2 * (kind(1) - u))
    return -(x * t1 - across * t0), -(x * t0 + across * t1), -mu


def _disc_at_horizon(p, u, v, key, rank, band):
    kind = u.dtype.type
    out = [np.empty_like(u) for _ in range(3)]
    left = np.arange(u.size)
    trial = 0
    while left.size:
        h0, h1, h2, h3, t0, t1 = (x[left] for x in p)
        sin_z = np.sqrt(kind(1) - h3 * h3)
        mu2 = h0 * (kind(1) - u)
        mu, far = np.sqrt(mu2), np.sqrt(kind(1) - mu2)
        s, c = sincos_turned(kind(0), kind(1), h1, v)
        dx, dy, dz = far * c - sin_z, far * s, mu - h3
        hit = dx * dx + dy * dy + dz * dz <= h2
        x, y = -(far * (c * t1 - s * t0)), -(far * (c * t0 + s * t1))
        for o, values in zip(out, (x, y, -mu), strict=True):
            o[left[hit]] = values[hit]
        left = left[~hit]
        trial += 1
        a, b = philox(key, rank[left], band, trial)
        u, v = unit(a, u.dtype), unit(b, v.dtype)
    return out


def place(law, p, u, v, key, rank, band):
    """Travel directions of photons of one law; p holds the six parameters of each."""
    if law == DISC:
        return _disc(p, u, v)
    if law == DISC_AT_HORIZON:
        return _disc_at_horizon(p, u, v, key, rank, band)
    sine, cosine = sincos_turned(p[4], p[5], p[3], v)
    return (_from_mu if law == CELL_MU else from_mu2)(p, u, sine, cosine)


def places(rank, jitter, key, band, shifts, steps, turn, dtype):
    """The two uniform numbers of each photon; `turn` is what its ring adds to the second one's word."""
    if jitter:
        a, b = philox(key, rank, band, 0)
    else:
        a, b = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1] + turn
    return unit(a, dtype), unit(b, dtype)
