"""Counts against the plain twin, and everything that is refused."""

import numpy as np
import pytest

from aomc_sky.errors import AllocationError, UsageError
from aomc_sky.plan.allocation import AllocationMethod, allocate, allocate_bands

EXACT = [method.value for method in AllocationMethod if method is not AllocationMethod.AOMC]


def sky(n_cells, seed=0):
    rng = np.random.default_rng(seed)
    mass = rng.lognormal(sigma=2.0, size=n_cells)
    mass[rng.random(n_cells) < 0.1] = 0.0
    return mass


def test_largest_remainder_gives_ties_to_the_lower_index():
    # four equal quarters and dyadic remainders, so the ties are exact
    assert allocate([1.0] * 4, 6, method="largest-remainder").tolist() == [2, 2, 1, 1]
    assert allocate([0.0, 1.0, 1.0, 0.0, 2.0], 1, method="largest-remainder").tolist() == [0, 0, 0, 0, 1]
    assert allocate([0.0, 1.0, 1.0, 0.0, 2.0], 2, method="largest-remainder").tolist() == [0, 1, 0, 0, 1]


@pytest.mark.parametrize("method", EXACT)
def test_shape_of_the_mass_is_kept(method):
    mass = sky(60, seed=9)
    counts = allocate(mass, 1000, method=method)
    np.testing.assert_array_equal(allocate(mass.reshape(3, 4, 5), 1000, method=method), counts.reshape(3, 4, 5))
    assert allocate(mass.tolist(), 1000, method=AllocationMethod(method)).tolist() == counts.tolist()


@pytest.mark.parametrize("method", EXACT)
def test_bands_are_independent_of_each_other(method):
    mass, chosen = sky(300, seed=2), AllocationMethod(method)
    n, bands = [5, 0, 10**9, 77, 5], [0, 1, 2, 300, 2**32 - 1]
    together = allocate_bands(mass, n, bands, method=chosen, seed=11)
    assert together.shape == (5, 300)
    for k in range(5):
        alone = allocate_bands(mass, n[k : k + 1], bands[k : k + 1], method=chosen, seed=11)
        np.testing.assert_array_equal(together[k], alone[0])
    turned = allocate_bands(mass, n[::-1], bands[::-1], method=chosen, seed=11)
    np.testing.assert_array_equal(turned, together[::-1])


def test_seeds_and_bands_have_offsets_of_their_own():
    mass = sky(32_400, seed=2)
    rows = {tuple(allocate(mass, 10**6, seed=seed)) for seed in range(1, 11)}
    rows |= {tuple(row) for row in allocate_bands(mass, [10**6] * 10, range(4, 14), seed=0)}
    assert len(rows) == 20


def test_photons_methods_and_seeds_that_are_refused():
    with pytest.raises(AllocationError, match=r"from 0 to 2\^53, got 9007199254740993"):
        allocate([1.0, 2.0], 2**53 + 1, method="multinomial")
    with pytest.raises(UsageError, match="'systematic', 'largest-remainder', 'multinomial', 'aomc'"):
        allocate([1.0], 1, method="alias")
    with pytest.raises(UsageError, match="seed"):
        allocate([1.0], 1, seed=-1)
    with pytest.raises(UsageError, match="allocate with method='aomc'"):
        allocate_bands([1.0], [1], [0], method=AllocationMethod.AOMC)
