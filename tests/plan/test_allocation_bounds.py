"""What integer counts promise, for masses of any scale and up to 2^62 photons: equalities and exact bounds."""

import itertools
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.kernels.arithmetic.error_free import exact_sum, product_over_2_62
from aomc_sky.plan.allocation import AllocationMethod, allocate, allocate_bands, fixed_point_cumulative
from aomc_sky.skies.tabulated import Weighting
from tests.reference import allocation as plain

WHOLE = 1 << 62

subnormal = st.integers(1, 2**20).map(lambda k: k * 5e-324)
any_scale = st.builds(lambda m, e: m * 10.0**e, st.floats(1.0, 9.9), st.integers(-300, 299))
tame = st.floats(2.0**-100, 2.0**100)


def tables(values):
    """Non-negative masses with zeros among them, at least one positive."""
    return st.lists(st.one_of(values, st.just(0.0)), min_size=1, max_size=60).filter(any)


masses = st.one_of(tables(any_scale), tables(subnormal), tables(tame), tables(st.one_of(any_scale, subnormal)))
photons = st.one_of(
    st.integers(0, 100),
    st.integers(0, 10**9),
    st.integers(0, WHOLE),
    st.integers(0, 1000).map(lambda k: WHOLE - k),
    st.integers(0, 62).map(lambda k: 1 << k),
)
seeds = st.integers(0, 2**64 - 1)
words = st.one_of(
    st.integers(0, WHOLE), st.integers(0, 62).map(lambda k: 1 << k), st.integers(0, 62).map(lambda k: (1 << k) - 1)
)
bounded = st.sampled_from(["systematic", "largest-remainder"])


@given(st.lists(words, min_size=1, max_size=20), words, words)
def test_128_bits_equal_python_integers(a, n, offset):
    offset %= WHOLE
    quotient, rest = product_over_2_62(np.array(a, dtype=np.uint64), n, offset)
    assert list(zip(quotient.tolist(), rest.tolist(), strict=True)) == [divmod(n * x + offset, WHOLE) for x in a]


@given(
    st.lists(st.one_of(st.floats(0, 1), st.floats(0, 1e-30), st.floats(0, 1e-305)), max_size=60),
    st.integers(1, 300),
    st.integers(0, 2**32),
)
def test_sum_equals_fsum(values, n, seed):
    rng = np.random.default_rng(seed)
    values = np.concatenate([values, rng.random(n) * 2.0 ** -rng.integers(0, 200, n)])
    assert exact_sum(values) == math.fsum(values)
    # half an ulp of the sum and a little more or less: where a sum that is not exact rounds the wrong way
    for tie in ([1.0, 2.0**-53], [1.0, 2.0**-53, 2.0**-200], [1.0, 2.0**-52, 2.0**-53], [0.5] * n):
        assert exact_sum(np.array(tie)) == math.fsum(tie)


@given(masses, photons, seeds)
def test_systematic_equals_the_plain_one(mass, n, seed):
    expected = plain.systematic(plain.fixed_point(mass), n, plain.offset_of(seed, 0))
    assert allocate(mass, n, seed=seed).tolist() == expected


@given(masses, photons)
def test_largest_remainder_equals_the_plain_one(mass, n):
    expected = plain.largest_remainder(plain.fixed_point(mass), mass, n)
    assert allocate(mass, n, method="largest-remainder").tolist() == expected


@given(masses, photons, seeds, bounded)
def test_sum_is_exact_zero_stays_zero_and_no_cell_is_a_photon_off(mass, n, seed, method):
    counts = allocate(mass, n, method=method, seed=seed).tolist()
    shares = np.diff(fixed_point_cumulative(mass)).tolist()
    assert sum(counts) == n
    for count, share, m in zip(counts, shares, mass, strict=True):
        assert count >= 0
        assert m > 0 or count == 0
        tied = n if method == "largest-remainder" else 0  # equal masses have the fewest units of any of them
        assert abs(count * WHOLE - n * share) < WHOLE + tied


@given(masses)
def test_fixed_point_against_the_exact_ratios(mass):
    """Every cumulative is the nearest one, so every run of cells is within one unit of its exact ratio."""
    cumulative = fixed_point_cumulative(mass).tolist()
    exact = itertools.accumulate(plain.exact_probability(mass), initial=0)
    off = [c - WHOLE * s for c, s in zip(cumulative, exact, strict=True)]
    assert all(-Fraction(1, 2) < error <= Fraction(1, 2) for error in off)
    assert max(off) - min(off) <= 1
    assert all(m > 0 or a == b for m, (a, b) in zip(mass, itertools.pairwise(cumulative), strict=True))


@pytest.mark.parametrize("n", [2**20 - 1, 2**20, 2**20 + 1, 2_500_000])
def test_fixed_point_of_many_patches(n):
    """Each entry the nearest multiple of 2^-62, by whole numbers; widely spread masses, some 0."""
    rng = np.random.default_rng(n)
    mass = rng.integers(1, 2**20, n) << rng.integers(0, 21, n)
    mass[rng.random(n) < 0.2] = 0
    sums = np.cumsum(mass)
    places, total = rng.integers(0, n, 20_000), int(sums[-1])
    wanted = [(2**63 * s + total) // (2 * total) for s in sums[places].tolist()]
    assert fixed_point_cumulative(mass / 2.0**41)[1 + places].tolist() == wanted


@pytest.mark.parametrize("n", [32_400, 10_007, 4096])
def test_equal_patches_at_1e15_photons(n):
    """Every run of patches within one photon and N 2^-62 of its exact share; the rest in one cell was 3 photons off."""
    photons = 10**15
    for method in ("systematic", "largest-remainder"):
        counts = allocate(np.ones(n), photons, method=method, seed=3)
        reached = np.concatenate([[0], np.cumsum(counts)]).tolist()
        off = [reached[k] * n - photons * k for k in range(n + 1)]  # n times the deviation, exactly
        assert np.abs(counts * n - photons).max() < n + photons * n / WHOLE
        if method == "systematic":
            assert max(off) - min(off) < n * (1 + photons / WHOLE)


@given(tables(st.one_of(any_scale, subnormal)), photons, seeds, bounded)
def test_counts_against_the_exact_ratios(mass, n, seed, method):
    """The bound a user sees: one photon and N 2^-62, which is 1/4600 of a photon at 1e15."""
    counts = allocate(mass, n, method=method, seed=seed).tolist()
    for count, p in zip(counts, plain.exact_probability(mass), strict=True):
        assert abs(count - n * p) < 1 + Fraction(n, WHOLE)


@given(masses, photons, seeds)
def test_any_run_of_cells_is_within_one_photon(mass, n, seed):
    counts = allocate(mass, n, seed=seed)
    reached = np.concatenate([[0], np.cumsum(counts)]).tolist()
    wanted = fixed_point_cumulative(mass).tolist()
    off = [count * WHOLE - n * c for count, c in zip(reached, wanted, strict=True)]
    assert max(off) - min(off) < WHOLE
    exact = [n * s for s in itertools.accumulate(plain.exact_probability(mass), initial=Fraction(0))]
    off = [count - s for count, s in zip(reached, exact, strict=True)]
    assert max(off) - min(off) < 1 + Fraction(n, WHOLE)


@given(masses, st.integers(0, WHOLE), st.integers(1, 12))
def test_mean_over_offsets_is_the_expectation(mass, n, bits):
    """Hermite: the sum of floor(x + j/M) over j < M is floor(M x), for every cumulative x = N C / 2^62."""
    cumulative, m = fixed_point_cumulative(mass), 1 << bits
    total = [0] * cumulative.size
    for j in range(m):
        quotient, _ = product_over_2_62(cumulative, n, j * (WHOLE // m))
        total = [t + q for t, q in zip(total, quotient.tolist(), strict=True)]
    assert total == [m * n * c // WHOLE for c in cumulative.tolist()]


@given(tables(tame), st.integers(-900, 900), photons, seeds, bounded)
def test_a_power_of_two_changes_nothing(mass, exponent, n, seed, method):
    scaled, chosen = np.ldexp(mass, exponent), {"method": method, "seed": seed}
    np.testing.assert_array_equal(fixed_point_cumulative(scaled), fixed_point_cumulative(mass))
    np.testing.assert_array_equal(allocate(scaled, n, **chosen), allocate(mass, n, **chosen))


@given(masses, st.integers(0, 2**53), seeds)
def test_multinomial_keeps_sum_and_zeros(mass, n, seed):
    counts = allocate_bands(mass, [n], [3], method=AllocationMethod.MULTINOMIAL, seed=seed)[0].tolist()
    assert sum(counts) == n
    assert all(count >= 0 and (m > 0 or count == 0) for count, m in zip(counts, mass, strict=True))


@given(tables(st.floats(1e-6, 1e6)), st.integers(0, 999_999_999))
def test_aomc_rounding_equals_the_plain_one(weight, n):
    table = np.array(weight, dtype=np.float32).reshape(1, -1)
    np.testing.assert_array_equal(allocate(table, n, method="aomc"), plain.aomc(table, n))


def listed(values, grid, **more):
    return sky.TabulatedSky(wavelength_nm=[550.0], values=values, grid=grid, weighting=Weighting.LISTED, **more)


def _shares(values):
    exact = [Fraction(x) for x in values]
    return [x / sum(exact) for x in exact]


@given(st.lists(masses, min_size=1, max_size=2), photons.filter(bool), seeds, st.floats(0.01, 1.0))
def test_counts_of_a_scene_are_within_its_bound(tables_of, n, seed, strength):
    """Masses of a plan are float64: beside 1 + N 2^-62 photons, N p 2^-52 of one component and 2^-51 of several."""
    skies = []
    for values, part, name in zip(tables_of, (1.0, strength), "ab", strict=False):
        table = listed(np.array([values]), sky.PatchGrid.regular(1, len(values)), strength=part)
        skies += [replace(component, name=name) for component in table.lower([550.0])]
    scene = sky.Scene(wavebands=[550.0], n_photons=n, components=skies)
    parts = _shares([1.0, strength][: len(skies)])
    shares = [part * p for part, values in zip(parts, tables_of, strict=True) for p in _shares(values)]
    rounding = Fraction(1, 2**52 if len(skies) == 1 else 2**51)
    for count, p in zip(scene.source(seed=seed).counts.ravel().tolist(), shares, strict=True):
        assert abs(count - n * p) < 1 + Fraction(n, WHOLE) + n * p * rounding
        assert p or not count


def test_a_table_of_one_decade_moves_more_than_the_rounding_of_shares_alone():
    """The planted defect: the bound without N p 2^-52 fails at 1e18 photons."""
    values = np.random.default_rng(0).uniform(0.1, 1, 12)
    n, table = 10**18, listed(values[None], sky.PatchGrid.regular(3, 4))
    found = sky.Scene(wavebands=[550.0], n_photons=n, components=table).source(seed=1).counts.ravel().tolist()
    assert max(abs(count - n * p) for count, p in zip(found, _shares(values), strict=True)) > 1.22
