"""Keys of the random streams: one per seed and purpose, so that no two uses ever share numbers."""

from __future__ import annotations

import hashlib

from aomc_sky.errors import UsageError

STREAM_VERSION = "aomc-sky/1"
"""Changes whenever equal input gives other photons; part of every key and of the plan's hash."""

ALLOCATION = "allocation"
ORDER = "order"
SHIFT = "shift"
PLACEMENT = "placement"
POSITION = "position"

MAX_SEED = 2**64 - 1


def stream_key(seed: int, stream: str) -> int:
    """Return the 64-bit Philox key of a stream.

    Parameters
    ----------
    seed : int
        The seed of the run. [0 to 2^64 - 1]
    stream : str
        Name of the stream, one of this module's constants.

    Returns
    -------
    int
        The first 8 bytes, little-endian, of SHA-256 over version, seed and name joined by NUL.
    """
    if isinstance(seed, bool) or not 0 <= int(seed) <= MAX_SEED or int(seed) != seed:
        raise UsageError(f"seed must be a whole number from 0 to 2^64 - 1, got {seed!r}")
    text = "\0".join((STREAM_VERSION, str(int(seed)), stream)).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "little")
