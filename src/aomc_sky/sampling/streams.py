"""Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers."""

from __future__ import annotations

import hashlib

from aomc_sky.whole_number import as_index_within

STREAM_VERSION = "aomc-sky/2"
"""Changes whenever equal input gives other photons; part of every key and of the plan's hash."""

ALLOCATION = "allocation"
ORDER = "order"
SHIFT = "shift"
PLACEMENT = "placement"
POSITION = "position"

MAX_SEED = 2**64 - 1


def checked_seed(seed: int) -> int:
    """Return a seed as a Python integer; a UsageError for what is none, or lies outside [0, 2^64 - 1]."""
    return as_index_within(seed, "seed", 0, MAX_SEED)


def stream_key(seed: int, stream: str, method: str | None = None) -> int:
    """Return the 64-bit Philox key of a stream, one of this module's constants.

    It is the first 8 bytes, little-endian, of SHA-256 over version, seed, method (if any) and name, joined by NUL. The
    method is that of the photons: photons of one seed by two methods share no number. None for streams that no method
    has a part in.
    """
    named = (stream,) if method is None else (method, stream)
    text = "\0".join((STREAM_VERSION, str(checked_seed(seed)), *named)).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "little")


_LOW = 0xFFFFFFFF


def philox_pair(key: int, rank: int, band: int, draw: int) -> tuple[int, int]:
    """Two 64-bit words of Philox4x32-10, as `aomc_sky.kernels.arithmetic.rng.philox_pair` gives them.

    The counter is (rank low, rank high, band, draw). Plain integers, for the few words that a run needs before any
    photon: compiling the kernel for them would cost more than everything else at the start.
    """
    c0, c1, c2, c3 = rank & _LOW, rank >> 32, band, draw
    k0, k1 = key & _LOW, key >> 32
    for _ in range(10):
        p0, p1 = 0xD2511F53 * c0, 0xCD9E8D57 * c2
        c0, c1, c2, c3 = (p1 >> 32) ^ c1 ^ k0, p1 & _LOW, (p0 >> 32) ^ c3 ^ k1, p0 & _LOW
        k0, k1 = (k0 + 0x9E3779B9) & _LOW, (k1 + 0xBB67AE85) & _LOW
    return (c0 << 32) | c1, (c2 << 32) | c3
