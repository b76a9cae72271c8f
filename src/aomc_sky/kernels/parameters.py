"""Cell parameters on their way to the photons: three pairs of floats, moved as 64-bit words.

A cell has a head (four floats, its ring) and a tail (two floats, its column), which stand in one
table of words: a pair of float32 is one word, a pair of float64 two. Scratch memory has three rows, a
pair per photon in each; moving words instead of floats halves the stores of the float32 path.
"""

from __future__ import annotations

import numba
import numpy as np
from numba.extending import overload

SCRATCH_PHOTONS = 2048 + 24  # 24 more than a block: rows a multiple of 4 KiB apart collide in the cache
PAIR_ROW = np.uint64(2 * SCRATCH_PHOTONS)
"""Distance between two rows of the scratch memory, in floats."""

_ROW32 = np.uint64(SCRATCH_PHOTONS)
_ROW64 = np.uint64(2 * SCRATCH_PHOTONS)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_THREE = np.uint64(3)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_S32 = np.uint64(32)
_LOW32 = np.uint64(0xFFFFFFFF)


def _scratch_f32(like):
    return np.empty(3 * SCRATCH_PHOTONS, np.uint64)


def _scratch_f64(like):
    return np.empty(6 * SCRATCH_PHOTONS, np.uint64)


def scratch_words(like):
    """Return scratch memory for a block in the precision of the array `like`."""
    return _scratch_f32(like) if like.dtype == np.float32 else _scratch_f64(like)


@overload(scratch_words)
def _scratch_overload(like):
    return _scratch_f32 if like.dtype == numba.types.float32 else _scratch_f64


def _copy_f32(scratch, j, words, head, tail, like):
    scratch[j] = words[head]
    scratch[j + _ROW32] = words[head + _ONE]
    scratch[j + _TWO * _ROW32] = words[tail]


def _copy_f64(scratch, j, words, head, tail, like):
    i = _TWO * j
    scratch[i] = words[head]
    scratch[i + _ONE] = words[head + _ONE]
    scratch[i + _ROW64] = words[head + _TWO]
    scratch[i + _ROW64 + _ONE] = words[head + _THREE]
    scratch[i + _TWO * _ROW64] = words[tail]
    scratch[i + _TWO * _ROW64 + _ONE] = words[tail + _ONE]


def copy_parameters(scratch, j, words, head, tail, like):
    """Copy the parameters of one cell to photon j of the block; `like` is any number of the precision."""
    if isinstance(like, np.float32):
        _copy_f32(scratch, j, words, head, tail, like)
    else:
        _copy_f64(scratch, j, words, head, tail, like)


@overload(copy_parameters)
def _copy_overload(scratch, j, words, head, tail, like):
    return _copy_f32 if like == numba.types.float32 else _copy_f64


def _split_u32(word):
    return np.uint64(word >> _S16), np.uint64(word & _LOW16)


def _split_u64(word):
    return word >> _S32, word & _LOW32


def split_place(word):
    """Positions of a cell's head and tail in the table of words: the two halves of a 32- or 64-bit word.

    The width is known when the kernel is compiled, which makes the shifts constants.
    """
    return _split_u32(word) if isinstance(word, np.uint32) else _split_u64(word)


@overload(split_place)
def _split_overload(word):
    return _split_u32 if word == numba.types.uint32 else _split_u64
