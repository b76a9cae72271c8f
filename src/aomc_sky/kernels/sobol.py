"""Points of the first two Sobol dimensions by index, with full nested (Owen) scrambling.

Point j of the plain sequence has the reversed bits of j as its first coordinate and Pascal's triangle
modulo 2 times them as its second. Scrambling walks down the binary tree of a coordinate: at each node it
swaps the two halves or not. The swaps of four levels are 15 bits of one keyed hash of the node above
them, so that each node of the tree has a bit of its own, as Owen's scrambling wants. The first three
groups of levels, 4096 nodes, come from a table per band. Levels that hold one point at most are filled by
Philox of the photon's index, which is the same law there.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.constants import STIR_A as _A
from aomc_sky.kernels.constants import STIR_B as _B
from aomc_sky.kernels.jit import inlined, inner

_U32 = np.uint32
_ZERO = np.uint64(0)
_ONE = np.uint64(1)
_TWO = np.uint64(2)
_TOPS = np.uint64(4096)
_KEYS = np.uint64(16)
_R1 = np.uint32(1)
_R2 = np.uint32(2)
_R3 = np.uint32(3)
_R4 = np.uint32(4)
_R7 = np.uint32(7)
_R8 = np.uint32(8)
_R15 = np.uint32(15)
_R16 = np.uint32(16)
_R31 = np.uint32(31)
_M1 = np.uint32(0x55555555)
_M2 = np.uint32(0x33333333)
_M4 = np.uint32(0x0F0F0F0F)
_M8 = np.uint32(0x00FF00FF)
_TABLE_SHIFT = np.uint32(20)
_TABLE_GROUPS = np.uint64(3)


@inlined
def first_coordinate(j):
    """Van der Corput: the 32 bits of j in reverse, a fraction of 2^32."""
    x = _U32(_U32(_U32(j >> _R1) & _M1) | _U32(_U32(j & _M1) << _R1))
    x = _U32(_U32(_U32(x >> _R2) & _M2) | _U32(_U32(x & _M2) << _R2))
    x = _U32(_U32(_U32(x >> _R4) & _M4) | _U32(_U32(x & _M4) << _R4))
    x = _U32(_U32(_U32(x >> _R8) & _M8) | _U32(_U32(x & _M8) << _R8))
    return _U32(_U32(x >> _R16) | _U32(x << _R16))


@inlined
def second_coordinate(x):
    """Second Sobol coordinate of the point whose first one is x: Pascal's triangle by five halvings."""
    x = _U32(x ^ _U32(x << _R16))
    x = _U32(x ^ _U32(_U32(x & _M8) << _R8))
    x = _U32(x ^ _U32(_U32(x & _M4) << _R4))
    x = _U32(x ^ _U32(_U32(x & _M2) << _R2))
    return _U32(x ^ _U32(_U32(x & _M1) << _R1))


@inlined
def _swaps(node, key_a, key_b):
    """15 keyed bits of a node: lowbias32 with a second key in its middle, so that keys share no values."""
    x = _U32(node + key_a)
    x = _U32(_U32(x ^ _U32(x >> _R16)) * _A)
    x = _U32(_U32(x ^ _U32(x >> _R15)) + key_b)
    x = _U32(x * _B)
    return _U32(x ^ _U32(x >> _R16))


@inlined
def _scrambled_digit(x, shift, key_a, key_b):
    """Four bits of x at `shift`, each flipped by the bit of the node that the bits above it name.

    The mask changes nothing; it tells the compiler that 32 bits suffice for the shifts.
    """
    shift = _U32(shift & _R31)
    part = _U32(x >> shift)
    digit = _U32(part & _R15)
    h = _swaps(_U32(part >> _R4), key_a, key_b)
    flips = _U32(_U32(h & _R1) << _R3)
    flips = _U32(flips | _U32(_U32(_U32(h >> _U32(_R1 + _U32(digit >> _R3))) & _R1) << _R2))
    flips = _U32(flips | _U32(_U32(_U32(h >> _U32(_R3 + _U32(digit >> _R2))) & _R1) << _R1))
    flips = _U32(flips | _U32(_U32(h >> _U32(_R7 + _U32(digit >> _R1))) & _R1))
    return _U32(_U32(digit ^ flips) << shift)


@inner
def _scramble(m, plain, tops, keys, n_groups, point):
    """Scrambled coordinates of m points; `tops` and `keys` those of one coordinate."""
    j = _ZERO
    while j < m:
        top = _U32(tops[np.uint64(_U32(plain[j] >> _TABLE_SHIFT))])
        point[j] = _U32(top << _TABLE_SHIFT)
        j += _ONE
    for group in range(_TABLE_GROUPS, n_groups):
        shift = _U32(_U32(28) - _U32(4) * _U32(group))
        key_a, key_b = keys[_TWO * group], keys[_TWO * group + _ONE]
        for i in range(m):
            point[i] = _U32(point[i] | _scrambled_digit(plain[i], shift, key_a, key_b))


@inner
def sobol_range(first, m, tops, keys, n_groups, plain, x, y):
    """Scrambled points [first, first + m), 4 n_groups bits of each coordinate at the top of 32.

    Parameters
    ----------
    first, m : uint64
        First point and number of points; first + m is at most 2^32.
    tops : ndarray, uint16, shape (2 x 4096,)
        The first twelve levels of both coordinates, scrambled.
    keys : ndarray, uint32, shape (2 x 8 x 2,)
        Two keys for each coordinate and group of levels.
    n_groups : uint64
        Groups of four levels wanted. [3 to 8]
    plain, x, y : ndarray, uint32
        Scratch memory and results.
    """
    base = _U32(first)
    for j in range(m):
        plain[j] = first_coordinate(_U32(base + _U32(j)))
    _scramble(m, plain, tops[:_TOPS], keys[:_KEYS], n_groups, x)
    for j in range(m):
        plain[j] = second_coordinate(plain[j])
    _scramble(m, plain, tops[_TOPS:], keys[_KEYS:], n_groups, y)
