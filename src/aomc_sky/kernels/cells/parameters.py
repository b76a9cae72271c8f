"""Cell parameters on their way to the photons: a ring's and a column's, four floats each, moved as 64-bit words.

A cell has a head, which belongs to its ring: the first three parameters and the ring's *turn*, an integer in the
place of a fourth float; and a tail, which belongs to its column: sine and cosine of the centre, half the width, and a
float that is not used. Heads and tails stand in one table of words, two for four float32, four for four
float64. The scratch memory has what vector loops read fastest: a float32 photon's head and, in a second row, its tail,
each in one piece; float64 in rows of pairs, h0 and h1, h2 and the turn, t0 and t1, and a row of h3. Words that lie
side by side are read before they are written: the compiler then moves two at a time.
"""

from __future__ import annotations

import numba
import numpy as np

from aomc_sky.kernels.arithmetic.constants import FOUR, LOW32, ONE, S32, THREE, TWO
from aomc_sky.kernels.jit import inner, overloads

SCRATCH_PHOTONS = 2048 + 24  # 24 more than a block: rows a multiple of 4 KiB apart collide in the cache
MAX_PHOTONS = np.uint64(SCRATCH_PHOTONS)
"""Most photons of a block. A loop that names it vectorises: 16 bytes times its index are known not to wrap."""

_TAILS = np.uint64(4 * SCRATCH_PHOTONS)
_PAIRS = np.uint64(2 * SCRATCH_PHOTONS)
_S16 = np.uint32(16)
_LOW16 = np.uint32(0xFFFF)
_HIGH32 = np.uint64(0xFFFFFFFF00000000)


def _scratch_f32(like):
    return np.empty(4 * SCRATCH_PHOTONS, np.uint64)


def _scratch_f64(like):
    return np.empty(7 * SCRATCH_PHOTONS, np.uint64)


def scratch_words(like):
    """Return scratch memory for a block in the precision of the array `like`."""
    return _scratch_f32(like) if like.dtype == np.float32 else _scratch_f64(like)


@overloads(scratch_words)
def _scratch_overload(like):
    return _scratch_f32 if like.dtype == numba.types.float32 else _scratch_f64


def _copy_f32(scratch, j, words, head, tail, like):
    i = TWO * j
    a, b, c, d = words[head], words[head + ONE], words[tail], words[tail + ONE]
    scratch[i] = a
    scratch[i + ONE] = b
    scratch[i + _PAIRS] = c
    scratch[i + _PAIRS + ONE] = d


def _copy_f64(scratch, j, words, head, tail, like):
    i = TWO * j
    a, b, c, d = words[head], words[head + ONE], words[head + TWO], words[head + THREE]
    e, f, g = words[tail], words[tail + ONE], words[tail + TWO]
    scratch[i] = a
    scratch[i + ONE] = b
    scratch[i + _PAIRS] = c
    scratch[i + _PAIRS + ONE] = d
    scratch[i + TWO * _PAIRS] = e
    scratch[i + TWO * _PAIRS + ONE] = f
    scratch[j + THREE * _PAIRS] = g


def copy_parameters(scratch, j, words, head, tail, like):
    """Copy the parameters of one cell to photon j of the block; `like` is any number of the precision."""
    if isinstance(like, np.float32):
        _copy_f32(scratch, j, words, head, tail, like)
    else:
        _copy_f64(scratch, j, words, head, tail, like)


@overloads(copy_parameters)
def _copy_overload(scratch, j, words, head, tail, like):
    return _copy_f32 if like == numba.types.float32 else _copy_f64


def _fill_f32(scratch, lo, hi, words, head, tail, slot, s, like):
    a, b, c, d = words[head], words[head + ONE], words[tail], words[tail + ONE]
    for j in range(lo, min(hi, MAX_PHOTONS)):
        i = TWO * j
        scratch[i] = a
        scratch[i + ONE] = b
        scratch[i + _PAIRS] = c
        scratch[i + _PAIRS + ONE] = d
        slot[j] = s


def _fill_f64(scratch, lo, hi, words, head, tail, slot, s, like):
    a, b, c, d = words[head], words[head + ONE], words[head + TWO], words[head + THREE]
    e, f, g = words[tail], words[tail + ONE], words[tail + TWO]
    for j in range(lo, min(hi, MAX_PHOTONS)):
        scratch[TWO * j] = a
        scratch[TWO * j + ONE] = b
    for j in range(lo, min(hi, MAX_PHOTONS)):
        scratch[TWO * j + _PAIRS] = c
        scratch[TWO * j + _PAIRS + ONE] = d
    for j in range(lo, min(hi, MAX_PHOTONS)):
        scratch[TWO * j + TWO * _PAIRS] = e
        scratch[TWO * j + TWO * _PAIRS + ONE] = f
    for j in range(lo, min(hi, MAX_PHOTONS)):
        scratch[j + THREE * _PAIRS] = g
        slot[j] = s


def fill_parameters(scratch, lo, hi, words, head, tail, slot, s, like):
    """`copy_parameters` of the cell of slot s to the photons lo to hi - 1, and s to `slot`."""
    if isinstance(like, np.float32):
        _fill_f32(scratch, lo, hi, words, head, tail, slot, s, like)
    else:
        _fill_f64(scratch, lo, hi, words, head, tail, slot, s, like)


@overloads(fill_parameters)
def _fill_overload(scratch, lo, hi, words, head, tail, slot, s, like):
    return _fill_f32 if like == numba.types.float32 else _fill_f64


def _cell_f32(p, j):
    i = FOUR * j
    t = i + _TAILS
    return p[i], p[i + ONE], p[i + TWO], p[t + TWO], p[t], p[t + ONE]


def _cell_f64(p, j):
    i = TWO * j
    t = i + TWO * _PAIRS
    return p[i], p[i + ONE], p[i + _PAIRS], p[j + THREE * _PAIRS], p[t], p[t + ONE]


def cell_of_photon(p, j):
    """The six parameters h0, h1, h2, h3, t0, t1 of photon j from the scratch memory, seen as floats."""
    return _cell_f32(p, j) if p.dtype == np.float32 else _cell_f64(p, j)


@overloads(cell_of_photon)
def _cell_overload(p, j):
    return _cell_f32 if p.dtype == numba.types.float32 else _cell_f64


@inner
def cell_of_table(values, head, tail):
    """The same six from the table of words, seen as floats."""
    per_word = np.uint64(8) // np.uint64(values.itemsize)
    h, t = head * per_word, tail * per_word
    return values[h], values[h + ONE], values[h + TWO], values[t + TWO], values[t], values[t + ONE]


def _bits_f32(scratch, like):
    return scratch.view(np.uint32)


def _bits_f64(scratch, like):
    return scratch


def turn_bits(scratch, like):
    """The scratch memory seen as integers as wide as the floats of the array `like`, for `turn_of_photon`."""
    return _bits_f32(scratch, like) if like.dtype == np.float32 else _bits_f64(scratch, like)


@overloads(turn_bits)
def _bits_overload(scratch, like):
    return _bits_f32 if like.dtype == numba.types.float32 else _bits_f64


def _turn_u32(bits, j):
    return np.uint64(bits[FOUR * j + THREE]) << S32


def _turn_u64(bits, j):
    return bits[TWO * j + _PAIRS + ONE]


def turn_of_photon(bits, j):
    """The turn of photon j's ring, a 64-bit fraction; `bits` comes from `turn_bits`."""
    return _turn_u32(bits, j) if bits.dtype == np.uint32 else _turn_u64(bits, j)


@overloads(turn_of_photon)
def _turn_overload(bits, j):
    return _turn_u32 if bits.dtype == numba.types.uint32 else _turn_u64


def _table_turn_f32(words, head, like):
    return words[head + ONE] & _HIGH32


def _table_turn_f64(words, head, like):
    return words[head + THREE]


def turn_of_table(words, head, like):
    """The same of a head of the table of words; `like` is any number of the precision."""
    return _table_turn_f32(words, head, like) if isinstance(like, np.float32) else _table_turn_f64(words, head, like)


@overloads(turn_of_table)
def _table_turn_overload(words, head, like):
    return _table_turn_f32 if like == numba.types.float32 else _table_turn_f64


def _split_u32(word):
    return np.uint64(word >> _S16), np.uint64(word & _LOW16)


def _split_u64(word):
    return word >> S32, word & LOW32


def split_place(word):
    """Positions of a cell's head and tail in the table of words: the two halves of a 32- or 64-bit word.

    The width is known when the kernel is compiled, which makes the shifts constants.
    """
    return _split_u32(word) if isinstance(word, np.uint32) else _split_u64(word)


@overloads(split_place)
def _split_overload(word):
    return _split_u32 if word == numba.types.uint32 else _split_u64
