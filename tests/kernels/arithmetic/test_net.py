"""The scrambled net: its points against long division, evenness of every aligned run, and nested moves."""

from itertools import product

import numpy as np
import pytest

from aomc_sky.kernels.arithmetic import net
from tests.reference.net import of_net

KEYS = np.array([0x0123456789ABCDEF, 0xFEDCBA9876543210, 0xDEADBEEF12345678, 0x5555AAAA3333CCCC], np.uint64)
RANKS = np.array([0, 1, 2, 3, 141, 65_535, 2**31 + 7, 2**32 - 1, 2**32, 2**40 + 12_345, 2**62 - 1], np.uint64)


def words(rank, keys=KEYS):
    index = net.index_of_rank(rank, keys[3])
    digits = index, net.digits_of_x_plus_1(index), net.digits_of_x2_plus_x_plus_1(index)
    return [net.net_word(own, key) for own, key in zip(digits, keys, strict=False)]


def test_points_are_those_of_long_division():
    found = np.column_stack(words(RANKS)).tolist()
    assert found == [list(of_net(rank, KEYS.tolist())) for rank in RANKS.tolist()]


def unevenness(numbers, n_bits):
    """The most points of 2^n_bits that one of so many equal boxes has, of all shapes: 1 is the least there is."""
    most = 0
    for shape in product(range(n_bits + 1), repeat=len(numbers)):
        if sum(shape) == n_bits:
            box = np.zeros(1 << n_bits, np.int64)
            for number, bits in zip(numbers, shape, strict=True):
                box = (box << bits) | (number >> np.uint64(32)).astype(np.int64) >> (32 - bits)
            most = max(most, np.bincount(box).max())
    return most


@pytest.mark.parametrize("first", [0, 3 << 10, 5 << 32, (1 << 40) + (7 << 10)])
def test_every_aligned_run_of_ranks_is_even(first):
    """One point a box for one number and for the first two, at most two for all; planted: a run that is not aligned,
    and a rank that is hashed, each with the net's own bits.
    """
    for n_bits in range(1, 11):
        three = words(np.arange(first, first + (1 << n_bits), dtype=np.uint64))
        for one in three:
            assert unevenness([one], n_bits) == 1
        assert unevenness(three[:2], n_bits) == 1
        assert unevenness(three, n_bits) <= 2
    shifted = words(np.arange(first + 500, first + 500 + 1024, dtype=np.uint64))
    assert unevenness(shifted[:2], 10) > 1
    hashed = words(np.arange(first, first + 1024, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15))
    assert unevenness(hashed, 10) > 2


def test_a_bit_moves_with_those_above_it_alone():
    """Of a reversed word: so runs of ranks stay together. Half of the bits move, whatever is above."""
    rng = np.random.default_rng(1)
    x, keys = rng.integers(0, 2**32, 4000, np.uint32), rng.integers(0, 2**64, 4000, np.uint64)
    moved = np.unpackbits((x ^ net.nested(x, keys)).view(np.uint8)).mean()
    assert moved == pytest.approx(0.5, abs=0.01)
    for bit in (0, 1, 7, 31):
        other = x ^ np.uint32(1 << bit)
        change = net.nested(x, keys) ^ net.nested(other, keys)
        assert not np.any(change & np.uint32((1 << bit) - 1))
        assert np.all(change >> np.uint32(bit) & np.uint32(1))
