"""The transport's own random numbers: a function of (key, photon, event), without state.

Philox4x32-10 (Salmon et al. 2011) turns a counter and a key into four words of 32 bits. The counter holds
the photon's index and the number of the event in its life, so a photon's fate depends neither on the thread
that follows it nor on other photons, and no number is ever used twice. The photon source uses the same
function under other keys (a hash of its own name and the seed), and so the two never meet: what befalls a
photon is independent of the direction that it came from.
"""

from __future__ import annotations

import hashlib

import numba
import numpy as np

Words = tuple[np.uint64, np.uint64, np.uint64, np.uint64]

_LOW = np.uint64(0xFFFFFFFF)
_S32 = np.uint64(32)
_MULTIPLIER_0, _MULTIPLIER_1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_STEP_0, _STEP_1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)


def transport_key(seed: int) -> np.uint64:
    """Return the key of a run's transport: the first 8 bytes of a hash of the example's name and the seed."""
    digest = hashlib.sha256(f"aomc-sky example slab\0{seed}".encode()).digest()
    return np.uint64(int.from_bytes(digest[:8], "little"))


@numba.njit(nogil=True)
def philox4x32(c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, key: np.uint64) -> Words:
    """Return four random words of 32 bits, held in uint64, for a counter of four words and a key of 64 bits."""
    k0, k1 = key & _LOW, key >> _S32
    for _ in range(10):
        p0, p1 = _MULTIPLIER_0 * c0, _MULTIPLIER_1 * c2
        c0, c1, c2, c3 = (p1 >> _S32) ^ c1 ^ k0, p1 & _LOW, (p0 >> _S32) ^ c3 ^ k1, p0 & _LOW
        k0, k1 = (k0 + _STEP_0) & _LOW, (k1 + _STEP_1) & _LOW
    return c0, c1, c2, c3


@numba.njit(nogil=True)
def event_numbers(key: np.uint64, photon: int, event: int) -> tuple[float, float, float, float]:
    """Return the four random numbers of one event in a photon's life.

    Parameters
    ----------
    key : numpy.uint64
        From `transport_key`.
    photon : int
        Index of the photon. [0 to 2^63 - 1]
    event : int
        Number of the event. [0 to 2^32 - 1]

    Returns
    -------
    tuple of four float
        Middles of 2^32 equal intervals, never 0 and never 1, so that their logarithm is finite. (0, 1)
    """
    index = np.uint64(photon)
    w0, w1, w2, w3 = philox4x32(index & _LOW, index >> _S32, np.uint64(event), np.uint64(0), key)
    return unit(w0), unit(w1), unit(w2), unit(w3)


@numba.njit(nogil=True)
def unit(word: np.uint64) -> float:
    """Return the middle of a word's interval. (0, 1)"""
    return (np.float64(np.int64(word)) + 0.5) * 2.0**-32
