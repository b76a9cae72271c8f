"""Scrambled Sobol points: the sequence, the net property, the table of the first levels, shares of components."""

import numpy as np
import pytest
from scipy.stats import qmc

from aomc_sky.kernels import plain_sobol
from aomc_sky.kernels.sobol import first_coordinate, second_coordinate, sobol_range
from aomc_sky.kernels.sobol_cells import _fraction_word, _times_over_2_62

WORD = 2**32 - 1


def keys_of(seed):
    return np.random.default_rng(seed).integers(0, 2**32, (2, 8, 2), dtype=np.uint32)


def scrambled(index, keys, n_groups=8):
    points = plain_sobol.plain_points(np.asarray(index, dtype=np.uint32))
    return [plain_sobol.scramble(x, k, n_groups) for x, k in zip(points, keys, strict=True)]


def shares_every_interval(x, y, bits):
    """Whether every elementary interval of area 2^-bits holds one of the 2^bits points."""
    for a in range(bits + 1):
        interval = ((x.astype(np.uint64) >> np.uint64(32 - a)) << np.uint64(bits - a)) | (
            y.astype(np.uint64) >> np.uint64(32 - bits + a)
        )
        if np.unique(interval).size != 2**bits:
            return False
    return True


def test_plain_points_are_the_sobol_sequence():
    """Scipy walks in Gray code's order: its point i is point i ^ (i >> 1) of the sequence."""
    index = np.arange(2**13, dtype=np.uint32)
    ours = np.stack(plain_sobol.plain_points(index ^ (index >> np.uint32(1)))) / 2.0**32
    theirs = qmc.Sobol(2, scramble=False, bits=32).random(index.size)
    np.testing.assert_array_equal(ours.T, theirs)


def test_plain_points_of_large_indices():
    """Each digit of an index adds its direction number: bits of the whole word are in use."""
    for bit in range(32):
        x, y = (int(c[0]) for c in plain_sobol.plain_points(np.array([1 << bit], np.uint32)))
        assert x == 1 << (31 - bit)
        assert y >> (31 - bit) & 1 == 1
        assert y & ((1 << (31 - bit)) - 1) == 0  # upper triangular: no digit below its own
    many = np.random.default_rng(3).integers(0, 2**32, (2, 500), dtype=np.uint32)
    for both, a, b in zip(
        plain_sobol.plain_points(many[0] ^ many[1]), *map(plain_sobol.plain_points, many), strict=True
    ):
        np.testing.assert_array_equal(both, a ^ b)  # linear


@pytest.mark.parametrize("bits", [1, 4, 5, 8, 11, 13])
@pytest.mark.parametrize("block", [0, 1, 1000])
def test_every_elementary_interval_holds_one_point(bits, block):
    index = np.arange(block << bits, (block + 1) << bits, dtype=np.uint64)
    for seed in range(3):
        assert shares_every_interval(*scrambled(index, keys_of(seed)), bits)


def test_the_last_points_are_a_net_too():
    x, y = scrambled(np.arange(2**32 - 2**10, 2**32, dtype=np.uint64), keys_of(5))
    assert shares_every_interval(x, y, 10)


@pytest.mark.parametrize("defect", ["one digit flipped", "stretched", "other order"])
def test_the_net_property_can_fail(defect):
    index = np.arange(2**10, dtype=np.uint64)
    x, y = scrambled(index, keys_of(1))
    if defect == "one digit flipped":
        y[17] ^= np.uint32(1 << 31)
    elif defect == "stretched":
        y = y * np.uint32(3)
    else:
        y = np.random.default_rng(1).permutation(y)
    assert not shares_every_interval(x, y, 10)


def test_scrambling_is_nested():
    """The scrambled digits of a number depend on the digits down to their own level and on nothing below."""
    rng = np.random.default_rng(2)
    x = rng.integers(0, 2**32, 300, dtype=np.uint32)
    for level in range(1, 32):
        below = rng.integers(0, 2**32, x.size, dtype=np.uint32) >> np.uint32(level)
        for keys in keys_of(level):
            first, second = plain_sobol.scramble(x, keys), plain_sobol.scramble(x ^ below, keys)
            np.testing.assert_array_equal((first ^ second) >> np.uint32(32 - level), 0)
            # a permutation at each level: where the first difference lies does not change
            np.testing.assert_array_equal(np.frexp((first ^ second).astype(float))[1], np.frexp(below.astype(float))[1])


@pytest.mark.parametrize("n_groups", [3, 4, 5, 8])
@pytest.mark.parametrize("first", [0, 12345, 2**32 - 700])
def test_compiled_points_equal_plain_ones(first, n_groups):
    keys = keys_of(8)
    x, y, plain = (np.zeros(700, np.uint32) for _ in range(3))
    with np.errstate(over="ignore"):
        sobol_range(
            np.uint64(first),
            np.uint64(700),
            plain_sobol.top_table(keys).ravel(),
            keys.ravel(),
            np.uint64(n_groups),
            plain,
            x,
            y,
        )
    expected = scrambled(np.arange(first, first + 700, dtype=np.uint64), keys, n_groups)
    np.testing.assert_array_equal(np.stack([x, y]), np.stack(expected))


def test_compiled_coordinates_of_one_point():
    index = np.array([0, 1, 2, 3, 0x12345678, WORD], np.uint32)
    x, y = plain_sobol.plain_points(index)
    for i, a, b in zip(index, x, y, strict=True):
        assert first_coordinate(i) == a
        assert second_coordinate(a) == b


def test_products_of_62_bits_are_exact():
    rng = np.random.default_rng(4)
    a = np.append(rng.integers(0, 2**62, 200, dtype=np.uint64), [0, 1, 2**62 - 1, 2**62, 2**62]).astype(np.uint64)
    b = np.append(rng.integers(0, 2**62, 200, dtype=np.uint64), [5, 2**62, 2**62, 2**62 - 1, 2**62]).astype(np.uint64)
    quotient, remainder = plain_sobol.times_over_2_62(a, b)
    for i, (p, q) in enumerate(zip(a, b, strict=True)):
        assert divmod(int(p) * int(q), 2**62) == (int(quotient[i]), int(remainder[i]))
        with np.errstate(over="ignore"):
            assert tuple(map(int, _times_over_2_62(p, q))) == (int(quotient[i]), int(remainder[i]))


def test_a_fraction_is_below_one():
    value = np.array([0.0, 0.5, np.nextafter(1.0, 0.0), 1.0])
    words = plain_sobol.fraction_word(value)
    assert [int(w) >> 11 for w in words] == [0, 2**52, 2**53 - 1, 2**53 - 1]
    assert [int(_fraction_word(v)) for v in value] == [int(w) for w in words]


def tree_of(photons):
    from aomc_sky.source.sobol_table import _tree

    return _tree(np.array(photons))


@pytest.mark.parametrize(
    "photons",
    [[7], [1, 0], [0, 5], [3, 5], [999, 1], [10, 20, 30], [1, 1, 998], [0, 0, 4], [400, 300, 200, 100], [1, 1, 1, 997]],
)
def test_up_to_four_components_are_within_a_photon_in_every_prefix(photons):
    n = sum(photons)
    component, point = plain_sobol.component_points(np.arange(n, dtype=np.uint64), tree_of(photons))
    seen = np.cumsum(component[:, None] == np.arange(len(photons)), axis=0)
    ideal = np.outer(np.arange(1, n + 1), photons) / n
    assert np.abs(seen - ideal).max() < 1.0
    assert seen[-1].tolist() == photons
    for k, count in enumerate(photons):
        assert point[component == k].tolist() == list(range(count))  # each takes its points in order


def test_eight_components_are_within_three_halves():
    photons = [1, 997, 3, 500, 2, 250, 7, 333]
    n = sum(photons)
    component, _ = plain_sobol.component_points(np.arange(n, dtype=np.uint64), tree_of(photons))
    seen = np.cumsum(component[:, None] == np.arange(8), axis=0)
    assert np.abs(seen - np.outer(np.arange(1, n + 1), photons) / n).max() < 1.5
    assert seen[-1].tolist() == photons


def test_components_at_the_largest_number_of_photons():
    photons = [2**32 - 3, 2, 1]
    index = np.array([0, 1, 2**31, 2**32 - 2, 2**32 - 1], np.uint64)
    component, point = plain_sobol.component_points(index, tree_of(photons))
    for i, k, j in zip(index.tolist(), component.tolist(), point.tolist(), strict=True):
        assert abs(j - i * photons[k] / 2**32) <= 1.5
        assert 0 <= j < photons[k]
    alone, points = plain_sobol.component_points(index, tree_of([2**32, 0]))
    assert alone.tolist() == [0] * 5
    np.testing.assert_array_equal(points, index)
