"""Numbers for hosts: uniform one by one, in pairs, threes, and with the direction; even inside one run."""

from itertools import combinations

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from aomc_sky.emission import band
from aomc_sky.kernels.arithmetic.constants import ACCEPT_STEP, R2_STEP_V
from bench import number_modes
from tests.support import chi2
from tests.support.backend import photons_by
from tests.support.sampled import cell_component, even, scene

N = 400_000
SEEDS = 1000
PAIRS = list(combinations(range(5), 2))
"""Of s and t, the two coordinates of the direction, and n1, n2, n3."""


@pytest.fixture(autouse=True)
def _in_plain_numpy():
    """Kernels of these laws and this precision would be compiled for this file alone, which takes longer."""
    with photons_by(kernels=False):
        yield


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
    own = band.NUMBER_STEPS
    for at, value, pair in ((1, own[0], (2, 3)), (0, R2_STEP_V, (1, 2))):
        planted = own.copy()
        planted[at] = value
        monkeypatch.setattr(band, "NUMBER_STEPS", planted)
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
    planted = band.NUMBER_STEPS.copy()
    planted[0] = ACCEPT_STEP
    monkeypatch.setattr(band, "NUMBER_STEPS", planted)
    monkeypatch.setattr(band, "_is_one_lattice", lambda plan, number: True)
    assert chi_square_with_the_place(scene(model, N).source(seed=3, precision="float64"))[0] > 5


SMALL = [(name, 300) for name in ("perez", "equal patches", "lobes", "uniform")]
LARGE = [
    *((name, 1000) for name, _ in SMALL),
    ("perez", 13_000),
    ("equal patches", 5760),
    ("table", 10_000),
    ("uniform", 10_000),
]


@pytest.mark.parametrize(("name", "n"), [*SMALL, *(pytest.param(*row, marks=pytest.mark.slow) for row in LARGE)])
def test_no_mode_of_direction_and_numbers_is_far_above_chance(name, n, monkeypatch):
    """All of them up to the fifth order, beside independent numbers; planted: the lattice on a grid of many cells."""
    make = number_modes.GRIDS[name]
    value, mode, chance = number_modes.worst_mode(make, n, 30 if n < 5000 else 6)
    assert value < number_modes.BOUND * chance, mode
    if name in ("perez", "equal patches"):
        monkeypatch.setattr(band, "_is_one_lattice", lambda plan, number: True)
        assert number_modes.worst_mode(make, n, 3)[0] > 2 * number_modes.BOUND * chance


def variance_of_the_beat(monkeypatch, lattice):
    """Of exp i(2 pi (2 n1 + n2) - azimuth), over that of independent numbers, where rings have 141 photons."""
    monkeypatch.setattr(band, "_is_one_lattice", lambda plan, number: lattice)
    total = []
    for seed in range(18):
        direction, numbers = number_modes.photons(number_modes.GRIDS["perez"](), 13_000, seed)
        total.append(np.exp(2j * np.pi * (2 * numbers[:, 0] + numbers[:, 1] - direction[:, 2])).sum())
    return np.mean(np.abs(total) ** 2) / 13_000


def test_rings_do_not_beat_with_two_numbers(monkeypatch):
    """47 times the variance of independent numbers by the lattice: 2 n1 + n2 makes a turn in each ring."""
    assert variance_of_the_beat(monkeypatch, lattice=False) < 2
    assert variance_of_the_beat(monkeypatch, lattice=True) > 20


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
