"""The emission of `emit` in plain numpy, equal to the bit: for small jobs, which numba's start-up would slow down.

Every formula stands here a second time, written for whole arrays; the tests compare both forms bit by bit.
Only + - x / sqrt, integers and rounding are used, so numpy gives the same bits as the kernels everywhere.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic import constants as k

_U32 = np.uint32
_U64 = np.uint64
_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)

CELL_MU2, CELL_MU, BEAM, DISC, DISC_AT_HORIZON, PEREZ, HG = range(7)

_TABLE_LIMIT = 1 << 24


def philox(key: np.uint64, rank: np.ndarray, band: int, draw: int) -> tuple[np.ndarray, np.ndarray]:
    """Two 64-bit words for each rank: counter (rank low, rank high, band, draw)."""
    c0, c1 = rank & _LOW, rank >> _S32
    c2, c3 = np.full_like(rank, band), np.full_like(rank, draw)
    k0, k1 = key & _LOW, key >> _S32
    for _ in range(10):
        p0, p1 = k.PHILOX_M0 * c0, k.PHILOX_M1 * c2
        c0, c1, c2, c3 = (p1 >> _S32) ^ c1 ^ k0, p1 & _LOW, (p0 >> _S32) ^ c3 ^ k1, p0 & _LOW
        k0, k1 = (k0 + k.PHILOX_W0) & _LOW, (k1 + k.PHILOX_W1) & _LOW
    return (c0 << _S32) | c1, (c2 << _S32) | c3


def unit(bits: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Uniform numbers in [0, 1): 24 bits for float32, 53 for float64."""
    if dtype == np.float32:
        return (bits >> _U64(40)).astype(np.float32) * np.float32(2.0**-24)
    return (bits >> _U64(11)).astype(np.float64) * 2.0**-53


def sincos_quarter(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of r quarter turns, |r| <= 1/2."""
    short = r.dtype == np.float32
    t = r * r
    return _horner(k.SIN_F32 if short else k.SIN_F64, t) * r, _horner(k.COS_F32 if short else k.COS_F64, t)


def sincos_narrow(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of r quarter turns, |r| <= 1/60, by the shorter series."""
    short = r.dtype == np.float32
    t = r * r
    sine = _horner(k.NARROW_SIN_F32 if short else k.NARROW_SIN_F64, t)
    return sine * r, _horner(k.NARROW_COS_F32 if short else k.NARROW_COS_F64, t)


def _horner(coefficients, t):
    value = np.full_like(t, coefficients[0])
    for coefficient in coefficients[1:]:
        value *= t
        value += coefficient
    return value


def sincos_turned(t0, t1, half_width, v):
    """Sine and cosine of the azimuth a share v of the way through a cell of any width."""
    x = half_width * (v + v - v.dtype.type(1))
    turns = np.rint(x)
    is_narrow = half_width <= v.dtype.type(k.NARROW_HALF_WIDTH)
    if np.all(is_narrow):
        s0, c0 = sincos_narrow(x)
        return t0 * c0 + t1 * s0, t1 * c0 - t0 * s0
    s0, c0 = sincos_quarter(x - turns)
    if np.any(is_narrow):
        s1, c1 = sincos_narrow(x - turns)
        s0, c0 = np.where(is_narrow, s1, s0), np.where(is_narrow, c1, c0)
    quarter = turns.astype(np.int32)
    swap = (quarter & 1) != 0
    s, c = np.where(swap, c0, s0), np.where(swap, s0, c0)
    s = np.where((quarter & 2) != 0, -s, s)
    c = np.where(((quarter + 1) & 2) != 0, -c, c)
    return t0 * c + t1 * s, t1 * c - t0 * s


def _stir(half: np.ndarray, key: np.uint32) -> np.ndarray:
    x = half * k.STIR_A + key
    x ^= x >> _U32(15)
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
    mask, size, down = _U64((1 << s) - 1), _U64(b), _U64(32 - s)
    low, high = i & mask, i >> _U64(s)

    def step(high: np.ndarray, low: np.ndarray, key: np.uint64) -> np.ndarray:
        stirred = _stir(low.astype(_U32), _U32(key)).astype(_U64)
        high = high + (((stirred >> _U64(32 - bits)) * size) >> _U64(bits))
        return np.where(high >= size, high - size, high)

    high = step(high, low, keys[0])
    low = (low + (_stir(high.astype(_U32), _U32(keys[1])).astype(_U64) >> down)) & mask
    high = step(high, low, keys[2])
    return (high << _U64(s)) | low


def shuffled_ranks(start: int, stop: int, n: int, keys: np.ndarray) -> np.ndarray:
    """Rank of each photon of [start, stop), uint64."""
    rank = _permute(np.arange(start, stop, dtype=_U64), n, keys)
    while True:
        beyond = np.flatnonzero(rank >= _U64(n))
        if beyond.size == 0:
            return rank
        rank[beyond] = _permute(rank[beyond], n, keys)


def slot_finder(cumulative: np.ndarray):
    """Return a function from ranks to slots; `cumulative` (n_slot + 1,) starts with 0 and ends with N."""
    n = int(cumulative[-1])
    if n <= _TABLE_LIMIT:
        slots = np.repeat(np.arange(cumulative.size - 1, dtype=np.int32), np.diff(cumulative).astype(np.int64))
        return lambda rank: slots[rank.astype(np.int64)]
    ends = cumulative[1:].astype(_U64)
    return lambda rank: np.searchsorted(ends, rank, side="right").astype(np.int32)


def _from_mu2(h, u, sine, cosine):
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
    return (_from_mu if law == CELL_MU else _from_mu2)(p, u, sine, cosine)


def places(rank, jitter, key, band, shifts, steps, turn, dtype):
    """The two uniform numbers of each photon; `turn` is what its ring adds to the second one's word."""
    if jitter:
        a, b = philox(key, rank, band, 0)
    else:
        a, b = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1] + turn
    return unit(a, dtype), unit(b, dtype)


def emit(
    start,
    stop,
    n,
    order_keys,
    shifts,
    steps,
    place_key,
    band,
    jitter,
    finder,
    turns,
    cells,
    laws,
    perez,
    lobes,
    ux,
    uy,
    uz,
    cell,
):
    """Write the photons [start, stop) of a band with n photons.

    `finder` comes from `slot_finder` over the counts of all cells; `turns` holds the ring of each
    cell and the turn of each ring; `cells` (n_cell, 6) in the precision
    of the outputs; `laws` int8 (n_cell,); `perez` holds words and bounds (n_cell,), the sky's numbers and
    the steps of the first trial, or None; `lobes` the lobe of each cell, the tables of `plain_lobe`, the steps of
    the first trial, and `falls` with `paces`. Other parameters are those of the kernel.
    """
    rank = np.arange(start, stop, dtype=_U64) if order_keys is None else shuffled_ranks(start, stop, n, order_keys)
    cell[:] = finder(rank)
    u, v = places(rank, jitter, place_key, band, shifts, steps, turns[1][turns[0][cell]], ux.dtype)
    law = laws[cell]
    for code in np.unique(law):
        chosen = slice(None) if np.all(law == code) else np.flatnonzero(law == code)
        p = tuple(cells[:, j][cell[chosen]] for j in range(6))
        if code == PEREZ and perez is not None:
            from aomc_sky.kernels.perez.plain_cells import accept_words, place_perez

            looked_up = (perez[0][cell[chosen]], perez[1][cell[chosen]], perez[2])
            word = accept_words(rank[chosen], perez[3], place_key, band, jitter)
            directions = place_perez(p, looked_up, u[chosen], v[chosen], word, place_key, rank[chosen], band)
        elif code >= HG:
            from aomc_sky.kernels.lobes.plain import lobe_words, place_lobes

            lobe = lobes[0][cell[chosen]]
            word = lobe_words(rank[chosen], lobe, lobes[3], shifts, steps, lobes[2], place_key, band, jitter)
            directions = place_lobes(lobe, lobes[1], word, place_key, rank[chosen], band)
        else:
            directions = place(code, p, u[chosen], v[chosen], place_key, rank[chosen], band)
        ux[chosen], uy[chosen], uz[chosen] = directions


def block_sums(uz: np.ndarray) -> tuple[float, float]:
    """Sums of mu and 1 / mu in the order of the photons; numpy's cumsum adds one after the other."""
    mu = -uz.astype(np.float64)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / mu
    return float(np.cumsum(mu)[-1]), float(np.cumsum(inverse)[-1])


def positions(shape_is_circle, start, key, band, size_x, size_y, x, y):
    """Positions over a circle of diameter size_x or a rectangle, as `positions` makes them."""
    a, b = philox(key, np.arange(start, start + x.size, dtype=_U64), band, 0)
    u, v, kind = unit(a, x.dtype), unit(b, x.dtype), x.dtype.type
    if shape_is_circle:
        sine, cosine = sincos_turned(kind(0), kind(1), kind(2), v)
        r = kind(size_x / 2) * np.sqrt(u)
        x[:], y[:] = r * cosine, r * sine
    else:
        x[:], y[:] = kind(size_x) * (u - kind(0.5)), kind(size_y) * (v - kind(0.5))
