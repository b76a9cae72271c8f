"""Numbers for hosts: uniform one by one, in pairs, threes, and with the direction; even inside one run."""

from itertools import combinations

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from aomc_sky.emission import emitter
from aomc_sky.kernels.arithmetic.constants import ACCEPT_STEP, R2_STEP_V
from tests.support import chi2
from tests.support.sampled import cell_component, even, scene

N = 400_000
SEEDS = 1000
PAIRS = list(combinations(range(5), 2))
"""Of s and t, the two coordinates of the direction, and n1, n2, n3."""


def coordinates(batch):
    """Both places of a photon in the cell of the whole dome, and its numbers: (n, 5), uniform."""
    sin2 = np.square(batch.ux) + np.square(batch.uy)
    turn = np.mod(np.arctan2(-batch.uy, -batch.ux) / (2 * np.pi), 1.0)
    return np.column_stack([sin2, turn, batch.numbers])


def dome(n, seed, **options):
    components = cell_component(Law.CELL_MU2, (0.0, 90.0), (0.0, 360.0))
    return scene(components, n).source(seed=seed, precision="float64", **options).photons(numbers=3)


def cells(points, n):
    """Points in cells of the unit box, n along each side."""
    found = np.minimum((points * n).astype(np.int64), n - 1)
    return np.bincount(np.ravel_multi_index(tuple(found.T), (n,) * points.shape[1]), minlength=n ** points.shape[1])


def unevenness(points):
    """Chi-square per degree of freedom on 343 to 400 cells of at least 1000 photons."""
    counts = cells(points, {1: 400, 2: 19, 3: 7}[points.shape[1]])
    return chi2.per_degree(counts, even(len(points), counts.size))


SETS = [part for size in (1, 2, 3) for part in combinations(range(5), size) if max(part) > 1]


@pytest.mark.parametrize("seed", [1, 2])
def test_one_run_fills_every_box_evenly(seed):
    """Far better than chance, which gives 1 +- 0.045: for each, each pair and three, and those with the direction."""
    points = coordinates(dome(N, seed))
    for part in SETS:
        assert unevenness(points[:, part]) < {1: 0.01, 2: 0.1, 3: 0.1}[len(part)], part


def test_equal_steps_are_caught(monkeypatch):
    """Planted: two numbers of one step, and one with the step of the azimuth; each is uniform and the pair is not."""
    own = emitter.NUMBER_STEPS
    for at, value, pair in ((1, own[0], (2, 3)), (0, R2_STEP_V, (1, 2))):
        planted = own.copy()
        planted[at] = value
        monkeypatch.setattr(emitter, "NUMBER_STEPS", planted)
        points = coordinates(dome(N, 1))
        assert unevenness(points[:, [2 + at]]) < 0.01
        assert unevenness(points[:, pair]) > 1


def chi_square_with_the_place(source):
    """Per degree of freedom, of 20 x 20 cells of sin^2 of the zenith angle and each number; 1 +- 0.07 by chance."""
    batch = source.photons(numbers=3)
    sin2, found = np.square(batch.ux) + np.square(batch.uy), []
    for number in batch.numbers.T:
        counts = np.histogram2d(sin2, number, bins=20, range=[[0, 1], [0, 1]])[0]
        expected = np.broadcast_to(counts.sum(axis=1, keepdims=True) / 20, counts.shape)
        found.append(chi2.chi2_statistic(counts, expected) / 380)
    return found


def test_a_rejection_does_not_choose_numbers(monkeypatch):
    """A clear sky in coarse patches rejects many; planted: the step of the word that decides."""
    sun = {"sun_zenith_rad": 0.7, "sun_azimuth_rad": 0.2}
    model = sky.PerezSky(**sun, epsilon=8.0, delta=0.1, grid=sky.PatchGrid.regular(2, 4))
    source = scene(model, N).source(seed=3, precision="float64")
    assert max(chi_square_with_the_place(source)) < 1.4
    planted = emitter.NUMBER_STEPS.copy()
    planted[0] = ACCEPT_STEP
    monkeypatch.setattr(emitter, "NUMBER_STEPS", planted)
    assert chi_square_with_the_place(source)[0] > 5


@pytest.mark.parametrize("n", [pytest.param(7, marks=pytest.mark.slow), 60])
def test_over_seeds_they_are_uniform(plan, n):
    """One photon of each of many seeds: each number, each pair, and each with both places of the direction."""
    points = np.concatenate([coordinates(dome(n, seed)[5:6]) for seed in range(SEEDS)])
    for k in (2, 3, 4):
        plan.check(chi2.ks_p(points[:, k]))
    for pair in PAIRS[1:]:
        plan.check(chi2.chi2_p(cells(points[:, pair], 6), even(SEEDS, 36)))
    plan.catches(chi2.ks_p(np.full(SEEDS, points[0, 2])))  # without a shift


def test_philox_placement_makes_them_independent(plan):
    """In one run, by two-sided tests; planted: numbers that are the direction's own."""
    points = coordinates(dome(200_000, 5, placement="philox"))
    for k in (2, 3, 4):
        plan.check(chi2.ks_p(points[:, k]))
    for pair in PAIRS[1:]:
        plan.check(chi2.chi2_p(cells(points[:, pair], 16), even(200_000, 256)))
    plan.catches(chi2.chi2_p(cells(points[:, [0, 0]], 16), even(200_000, 256)))
