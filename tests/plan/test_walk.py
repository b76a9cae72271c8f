"""The walk of systematic allocation through the rings of a grid: its bounds, its evenness, and what it leaves alone."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

import aomc_sky as sky
from aomc_sky.plan.allocation import (
    AllocationMethod,
    WalkedGrid,
    allocate_bands,
    first_columns,
    fixed_point_cumulative,
    walk_of_cells,
)
from tests.reference.allocation import philox_words
from tests.support.sampled import table_of

WHOLE = 1 << 62
GOLDEN = (math.sqrt(5) - 1) / 2


def grids():
    """Rings, columns, cells before the grid, masses of all cells."""
    size = st.tuples(st.integers(1, 6), st.integers(1, 9), st.integers(0, 3))
    mass = st.one_of(st.just(1.0), st.just(0.0), st.floats(1e-6, 1e3))
    return size.flatmap(
        lambda s: st.tuples(st.just(s), st.lists(mass, min_size=s[0] * s[1] + s[2], max_size=s[0] * s[1] + s[2]))
    ).filter(lambda grid: any(grid[1]))


@given(grids(), st.one_of(st.integers(0, 200), st.integers(0, WHOLE)), st.integers(0, 2**32))
def test_bounds(grid, n, band):
    (n_rings, n_columns, before), mass = grid
    rings = (WalkedGrid(before, n_rings, n_columns),)
    counts = allocate_bands(mass, [n], [band], rings=rings)[0]
    cumulative = fixed_point_cumulative(mass)
    units = np.diff(cumulative).tolist()
    assert counts.sum() == n
    assert counts[np.equal(mass, 0)].sum() == 0

    off = [Fraction(int(count) * WHOLE - n * unit, WHOLE) for count, unit in zip(counts, units, strict=True)]

    def spread(steps):
        """Largest difference between photons and share over all runs of these steps, in photons."""
        running = [Fraction(0), *itertools.accumulate(steps)]
        return max(running) - min(running)

    assert max(map(abs, off)) < 1
    assert spread(off[cell] for cell in walk_of_cells(cumulative, n, rings)) < 1
    assert spread(off) < 3
    edges = [*range(before), *range(before, counts.size + 1, n_columns)]
    assert spread(sum(off[a:b]) for a, b in itertools.pairwise(edges)) < 1  # whole rings


def test_counts_are_unbiased():
    mass = np.random.default_rng(3).lognormal(0, 1, (5, 8))
    n_bands, n = 4000, 23
    counts = allocate_bands(mass, [n] * n_bands, range(n_bands), rings=(WalkedGrid(0, 5, 8),))
    expected = n * (mass / mass.sum()).ravel()
    rest = expected - np.floor(expected)
    z = (counts.mean(0) - expected) / np.sqrt(rest * (1 - rest) / n_bands)
    assert np.abs(z).max() < 6  # 40 cells: 1e-7 by chance


def ratio_of_sectors(n_rings, n_columns, n, pattern, rings, n_parts, bands=64):
    """Error of the photons in parts of the circle, whole columns each, over that of independent photons."""
    mass = np.ones((n_rings, n_columns))
    mass[1::2] *= pattern
    counts = allocate_bands(mass, [n] * bands, range(bands), rings=rings)
    parts = counts.reshape(bands, n_rings, n_parts, -1).sum(axis=(1, 3))
    return math.sqrt(((parts - n / n_parts) ** 2).mean() / (n / n_parts * (1 - 1 / n_parts)))


IN_STEP = [
    (90, 360, 9000, 1),  # 90 photons in each of 100 columns and none in the others
    (50, 180, 1000, 1),
    (20, 72, 1000, 1),
    (90, 360, 90 * 89, 1),  # a Fibonacci number: rings a golden ratio apart fall in step, too
    (90, 360, 90 * 55, 1),
    (90, 360, 90 * 271, 1),
    (90, 180, 9000, 2),
    (60, 360, 60 * 3 * 17, 2),
]


@pytest.mark.parametrize(("n_rings", "n_columns", "n", "pattern"), IN_STEP)
def test_no_ring_is_in_step_with_another(n_rings, n_columns, n, pattern):
    walk = (WalkedGrid(0, n_rings, n_columns),)
    assert ratio_of_sectors(n_rings, n_columns, n, pattern, walk, n_columns) < 1.3
    assert ratio_of_sectors(n_rings, n_columns, n, pattern, walk, 36) < 1.1


def test_planted_walks_are_seen(monkeypatch):
    """Rings that begin at one column, and rings a golden ratio apart."""
    assert ratio_of_sectors(90, 360, 9000, 1, (), 360) > 5
    assert ratio_of_sectors(90, 360, 9000, 1, (), 36) > 2

    def golden(units, n, n_columns):
        return np.floor(np.arange(units.size - 1) * GOLDEN % 1 * n_columns).astype(np.int64)

    monkeypatch.setattr("aomc_sky.plan.allocation.first_columns", golden)
    assert ratio_of_sectors(90, 360, 9000, 1, (WalkedGrid(0, 90, 360),), 36) < 0.2
    assert ratio_of_sectors(90, 360, 90 * 89, 1, (WalkedGrid(0, 90, 360),), 360) > 3


@pytest.mark.parametrize(("n_rings", "n_columns"), [(1, 36), (36, 1)])
def test_grids_of_one_ring_or_one_column_keep_their_order(n_rings, n_columns):
    mass, walk = np.random.default_rng(1).lognormal(0, 1, 36), (WalkedGrid(0, n_rings, n_columns),)
    walked = allocate_bands(mass, [1000], [0], seed=5, rings=walk)
    np.testing.assert_array_equal(walked[0], sky.allocate(mass, 1000, seed=5))


@pytest.mark.parametrize("method", ["largest-remainder", "multinomial"])
def test_other_methods_keep_their_order(method):
    mass, chosen = np.random.default_rng(1).lognormal(0, 1, 36), AllocationMethod(method)
    walked = allocate_bands(mass, [1000], [0], method=chosen, seed=5, rings=(WalkedGrid(0, 6, 6),))
    np.testing.assert_array_equal(walked[0], sky.allocate(mass, 1000, method=method, seed=5))


def scene_counts(values, n, seed=0):
    return sky.Scene(wavebands=[550.0], n_photons=n, components=table_of(values)).source(seed=seed).counts[0]


def test_verify_counts_knows_the_walk():
    values = np.random.default_rng(2).lognormal(0, 1, (30, 48))
    counts = scene_counts(values, 5000)
    assert sky.verify_counts(counts, values.ravel(), n_columns=48, n_photons=5000)
    assert not sky.verify_counts(counts, values.ravel(), n_photons=5000)  # not in the order of the cells
    flat = np.ones((90, 360))
    in_step = sky.allocate(flat, 9000)  # every ring fills the same columns
    assert sky.verify_counts(in_step.ravel(), flat.ravel())
    report = sky.verify_counts(in_step.ravel(), flat.ravel(), n_columns=360)
    assert [c.name for c in report.checks if not c.passed] == ["each run of the walk within one photon"]
    mirrored = scene_counts(flat, 9000).reshape(90, 360)[:, ::-1]
    assert not sky.verify_counts(mirrored.ravel(), flat.ravel(), n_columns=360)


@pytest.mark.parametrize("n_columns", [0, 7, -48, 48.5])
def test_columns_must_fit_the_cells(n_columns):
    with pytest.raises((ValueError, sky.AomcSkyError)):
        sky.verify_counts(np.ones(36, int), np.ones(36), n_columns=n_columns)


@given(st.lists(st.integers(0, 1000), min_size=2, max_size=30).filter(any), st.integers(1, 10**6), st.integers(2, 40))
def test_each_ring_begins_where_the_text_says(masses, n, n_columns):
    """In decimals of 40 digits, from the square roots that the steps are of."""
    units = fixed_point_cumulative(masses)
    found = first_columns(units, n, n_columns)
    with mp.workdps(40):
        for q in range(1, len(masses)):
            expected, before = (mp.mpf(n * int(u)) / WHOLE for u in (units[q + 1] - units[q], units[q]))
            excess = expected % n_columns
            is_gap = excess > n_columns / 2
            fewer, sign = (n_columns - excess, -1) if is_gap else (excess, 1)
            w = mp.mpf(philox_words(0, (q, 0, 0, 0))[0]) / 2**64
            x = near = mp.frac(q * (mp.sqrt(13) - 3) / 2) + w / 16
            if fewer >= 1:
                off = q * mp.sqrt(2) + sign * before - fewer * near
                x = near + (off - mp.nint(off)) / fewer
            if expected < 1:
                x = w
            column = mp.frac(x) * n_columns
            # a whole photon, half the columns and the edge of a column are matters of rounding
            if (
                min(abs(expected - 1), abs(fewer - 1), abs(excess - n_columns / 2), abs(column - mp.nint(column)))
                > 1e-3
            ):
                assert found[q] == mp.floor(column)
    assert found[0] == 0
