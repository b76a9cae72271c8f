"""A scrambled digital net over the ranks of a band: uniform numbers that never beat with the directions.

Niederreiter's sequence in base 2: the bits of an index are a polynomial over GF(2), whose digits to the bases x, x + 1
and x^2 + x + 1 are the first, second and third number. Any 2^k ranks from a multiple of 2^k on fill the unit cube
evenly; one factor of 2 is missing where three numbers go together. Nested scrambling (Owen 1995) moves each number, and
first the rank, so that no period of the ranks meets one of the numbers. It is a hash in which a bit depends on those
above it alone (Laine and Karras 2011, with the multipliers of Vegdahl 2021); here it works on reversed words.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import S32, U32, U64
from aomc_sky.kernels.formula import formulas

_A, _B, _C = np.uint32(0x3D20ADEA), np.uint32(0x05526C56), np.uint32(0x53A22864)
_REST = np.uint32(0x9E3779B9)
_ODD = np.uint32(1)

_S1, _S2, _S3, _S4, _S6, _S8, _S12, _S16, _S24 = (np.uint32(bits) for bits in (1, 2, 3, 4, 6, 8, 12, 16, 24))
_HALVES = tuple(np.uint32(mask) for mask in (0xAAAAAAAA, 0xCCCCCCCC, 0xF0F0F0F0, 0xFF00FF00))
_UPPER = np.uint32(0xFFFF0000)
_THIRD = tuple(np.uint32(mask) for mask in (0x44444444, 0x30303030, 0x0F000F00, 0x00FF0000))
_FOURTH = tuple(np.uint32(mask) for mask in (0x88888888, 0xC0C0C0C0, 0xF000F000, 0xFF000000))


def reversed_bits(x):
    """The 32 bits of a word in the other order."""
    h1, h2, h4, h8 = _HALVES
    x = U32(U32(U32(x & h1) >> _S1) | U32(U32(x << _S1) & h1))
    x = U32(U32(U32(x & h2) >> _S2) | U32(U32(x << _S2) & h2))
    x = U32(U32(U32(x & h4) >> _S4) | U32(U32(x << _S4) & h4))
    x = U32(U32(U32(x & h8) >> _S8) | U32(U32(x << _S8) & h8))
    return U32(U32(x >> _S16) | U32(x << _S16))


def nested(x, key):
    """Scramble a reversed word: a bit is moved by the key and by the lower bits, those of more weight."""
    x = U32(x ^ U32(x * _A))
    x = U32(x + U32(key >> S32))
    x = U32(x * U32(U32(key) | _ODD))
    x = U32(x ^ U32(x * _B))
    return U32(x ^ U32(x * _C))


def index_of_rank(rank, key):
    """The point of the net that a rank has; the upper 32 bits of a rank give it another net."""
    low, high = U32(rank), U32(rank >> S32)
    return reversed_bits(nested(U32(reversed_bits(low) + U32(high * _REST)), key))


def digits_of_x_plus_1(v):
    """The polynomial v to the base x + 1, the lowest digit first: divided by x^16 + 1, halves by x^8 + 1, and so on."""
    h1, h2, h4, h8 = _HALVES
    v = U32(v ^ U32(U32(v & _UPPER) >> _S16))
    v = U32(v ^ U32(U32(v & h8) >> _S8))
    v = U32(v ^ U32(U32(v & h4) >> _S4))
    v = U32(v ^ U32(U32(v & h2) >> _S2))
    return U32(v ^ U32(U32(v & h1) >> _S1))


def _divided(v, third, fourth, one, two, three):
    """Quotients and remainders by x^2m + x^m + 1 of all parts of 4 m bits; the masks are their upper quarters."""
    c, d = U32(v & third), U32(v & fourth)
    return U32(U32(v ^ U32(U32(c | d) >> one)) ^ U32(U32(c >> two) ^ U32(d >> three)))


def digits_of_x2_plus_x_plus_1(v):
    """The polynomial v to the base x^2 + x + 1, digits of two bits, the lowest one first."""
    v = _divided(v, _THIRD[3], _FOURTH[3], _S8, _S16, _S24)
    v = _divided(v, _THIRD[2], _FOURTH[2], _S4, _S8, _S12)
    v = _divided(v, _THIRD[1], _FOURTH[1], _S2, _S4, _S6)
    return _divided(v, _THIRD[0], _FOURTH[0], _S1, _S2, _S3)


def net_word(digits, key):
    """The 64-bit word of a number from the digits of its point: 32 bits are of the net, the others a hash of them."""
    x = nested(digits, key)
    return (U64(reversed_bits(x)) << S32) | U64(U32(U32(x * _REST) ^ U32(key)))


formulas(
    reversed_bits,
    nested,
    index_of_rank,
    digits_of_x_plus_1,
    _divided,
    digits_of_x2_plus_x_plus_1,
    net_word,
    is_inlined=True,
)
