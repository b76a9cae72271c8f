"""The keyed order is a bijection for every N, and every prefix of it is a fair sample."""

import numba
import numpy as np
import pytest

from aomc_sky.kernels.cells import order
from aomc_sky.kernels.cells.blocks import ranks_of_block, split_place
from aomc_sky.kernels.cells.order import SHORT_LIMIT, high_step, mix, split_order
from aomc_sky.kernels.jit import inner, shared

_U32, _U64 = np.uint32, np.uint64
_ONE, _S32 = np.uint64(1), np.uint64(32)


@shared
def ranks_of_range(start, n, keys, rank):
    """Rank of each photon of [start, start + rank.size) of n: start and n uint64, rank uint64."""
    s, b = split_order(n)
    order = np.array([n, s, b, keys[0], keys[1], keys[2]])
    ranks_of_block(start, _U64(rank.size), order, rank)


@shared
def indices_of_ranks(rank, n, keys, index):
    """Photon index that has each rank: the inverse of `ranks_of_range`, for any ranks below n."""
    s, b = split_order(n)
    is_short = n <= SHORT_LIMIT
    k0, k1, k2 = _U32(keys[0]), _U32(keys[1]), _U32(keys[2])
    for j in range(rank.size):
        i = _unpermute(rank[j], s, b, k0, k1, k2, is_short)
        while i >= n:
            i = _unpermute(i, s, b, k0, k1, k2, is_short)
        index[j] = i


@inner
def _unpermute(i, s, b, k0, k1, k2, is_short):
    """Inverse of both passes of the order."""
    mask = (_ONE << s) - _ONE
    low = i & mask
    high = (i >> s) + b
    short_step = ((_U64(mix(_U32(low), k2)) >> _U64(16)) * b) >> _U64(16)
    high = high - (short_step if is_short else high_step(low, k2, b))
    high = high - b if high >= b else high
    low = (low - (_U64(mix(_U32(high), k1)) >> (_S32 - s))) & mask
    high = high + b
    short_step = ((_U64(mix(_U32(low), k0)) >> _U64(16)) * b) >> _U64(16)
    high = high - (short_step if is_short else high_step(low, k0, b))
    high = high - b if high >= b else high
    return (high << s) | low


JIT = not numba.config.DISABLE_JIT
KEYS = [np.array(k, dtype=np.uint64) for k in ([0, 0, 0], [0xFFFFFFFF, 0x12345678, 0x9ABCDEF0], [1, 2, 3])]


def ranks(start, stop, n, keys):
    out = np.empty(stop - start, np.uint64)
    ranks_of_range(np.uint64(start), np.uint64(n), keys, out)
    return out


def test_every_n_up_to_5000_is_a_bijection():
    for n in range(1, 5001 if JIT else 60):
        seen = np.zeros(n, bool)
        seen[ranks(0, n, n, KEYS[n % 3]).astype(np.int64)] = True
        assert seen.all(), n


@pytest.mark.parametrize(
    "n", [65_535 << 16, (65_535 << 16) + 1, 2**32 - 1, 2**32, 2**32 + 1, 3 * 2**40 + 17, 2**53 + 1, 2**62 - 1, 2**62]
)
@pytest.mark.parametrize("keys", KEYS)
def test_large_n_is_undone_by_its_inverse(n, keys):
    rng = np.random.default_rng(5)
    m = 2000 if JIT else 20
    for start in (0, n - m, int(rng.integers(0, n - m))):
        forward = ranks(start, start + m, n, keys)
        assert int(forward.max()) < n
        back = np.empty(m, np.uint64)
        indices_of_ranks(forward, np.uint64(n), keys, back)
        np.testing.assert_array_equal(back, np.arange(start, start + m, dtype=np.uint64))


@pytest.mark.parametrize("n", [1, 2, 3, 1000, 65_537, 2**32, 2**32 + 5, 2**61 + 3])
def test_plain_form_is_equal(n):
    m = min(n, 3000 if JIT else 50)
    for start in {0, n - m}:
        plain = order.ranks_of_photons(start, start + m, n, KEYS[1])
        np.testing.assert_array_equal(ranks(start, start + m, n, KEYS[1]), plain)


def prefix_excess(rank_of, n, bins, n_keys):
    """Mean chi-square per degree of freedom of a tenth of the photons over strata of ranks, as a pull."""
    m, total = n // 10, 0.0
    rng = np.random.default_rng(11)
    for _ in range(n_keys):
        keys = rng.integers(0, 2**32, 3, dtype=np.uint64)
        counts = np.bincount((rank_of(m, n, keys) * np.uint64(bins) // np.uint64(n)).astype(np.int64), minlength=bins)
        expected = m / bins
        total += ((counts - expected) ** 2 / (expected * 0.9)).sum() / (bins - 1)
    return (total / n_keys - 1) / np.sqrt(2 / ((bins - 1) * n_keys))


@pytest.mark.skipif(not JIT, reason="long without the JIT")
@pytest.mark.parametrize("n", [10_007, 1_000_003])
@pytest.mark.parametrize("bins", [2, 8, 64])
def test_prefixes_are_fair_samples(n, bins):
    assert abs(prefix_excess(lambda m, n, keys: ranks(0, m, n, keys), n, bins, 60)) < 6


def test_two_rounds_would_be_caught():
    def two_rounds(m, n, keys):
        s, b = order.split_order(np.uint64(n))
        i = np.arange(m, dtype=np.uint64)
        low, high = i & (np.uint64(1) << s) - np.uint64(1), i >> s
        mixed = order.mix(low.astype(np.uint32), np.uint32(keys[0])).astype(np.uint64)
        high = (high + ((mixed >> np.uint64(16)) * np.uint64(b) >> np.uint64(16))) % np.uint64(b)
        return np.minimum((high << s) | low, np.uint64(n - 1))

    assert abs(prefix_excess(two_rounds, 1_000_003, 8, 20)) > 6


@pytest.mark.parametrize(("kind", "bits"), [(_U32, 16), (_U64, 32)])
def test_a_place_holds_head_and_tail_in_its_halves(kind, bits):
    most = 2**bits - 1
    for head, tail in ((0, most), (most, 0), (5, 7)):
        assert split_place(kind(head << bits | tail)) == (head, tail)
