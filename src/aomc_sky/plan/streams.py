"""Keys of the random streams: one per seed, method and purpose, so that no two uses ever share numbers."""

from __future__ import annotations

import hashlib

import numpy as np

from aomc_sky.kernels.arithmetic import rng
from aomc_sky.whole_number import as_index_within

STREAM_VERSION = "aomc-sky/4"
"""Changes whenever equal input gives other photons; part of the plan's hash."""

_KEY_VERSION = "aomc-sky/2"
"""Part of every key: changes only if the random words themselves must change."""

ALLOCATION = "allocation"
ORDER = "order"
SHIFT = "shift"
PLACEMENT = "placement"
POSITION = "position"

PHOTON_STREAMS = (ORDER, SHIFT, PLACEMENT, POSITION)
"""Streams whose keys are in a plan, in this order; the key of allocation is not needed any more."""

MAX_SEED = 2**64 - 1


def checked_seed(seed: int) -> int:
    """Return a seed as a Python integer; a UsageError for what is none, or lies outside [0, 2^64 - 1]."""
    return as_index_within(seed, "seed", 0, MAX_SEED)


def stream_key(seed: int, stream: str, method: str | None = None) -> int:
    """Return the 64-bit Philox key of a stream, one of this module's constants.

    `seed` is a `checked_seed`. The key is the first 8 bytes, little-endian, of SHA-256 over the version of the keys,
    seed, method (if any) and name, joined by NUL. The method is that of the photons: photons of one seed by two methods
    share no number. For streams that no method has a part in it is None.
    """
    named = (stream,) if method is None else (method, stream)
    text = "\0".join((_KEY_VERSION, str(int(seed)), *named)).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "little")


def photon_keys(seed: int, method: str) -> np.ndarray:
    """The keys of `PHOTON_STREAMS`, uint64 (4,): the member `keys` of a plan."""
    return np.array([stream_key(seed, stream, method) for stream in PHOTON_STREAMS], dtype=np.uint64)


def philox_pair(key: int, rank: int, band: int, draw: int) -> tuple[int, int]:
    """Two 64-bit words of Philox4x32-10 as integers, for the few words that a run needs before any photon.

    The counter is (rank low, rank high, band, draw).
    """
    first, second = rng.philox_pair(*map(np.uint64, (key, rank, band, draw)))
    return int(first), int(second)
