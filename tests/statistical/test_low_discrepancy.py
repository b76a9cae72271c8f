"""R2 placement: even beyond chance inside one run, uniform over seeds; independent patches with Philox."""

import numpy as np
import pytest

from aomc_sky.component import Law
from tests.support import chi2
from tests.support.backend import photons_by
from tests.support.sampled import (
    azimuth_place,
    cell_component,
    even,
    scene,
    sky_angles,
    square_counts,
    table_of,
    uneven_sky,
    zenith_place_mu,
    zenith_place_mu2,
)

N = 1_000_000
SEEDS = 1000
"""The least for a Kolmogorov test; 28 of them in each of 6 x 6 cells."""
DOME = ((0.0, 90.0), (0.0, 360.0))
PLACE = {Law.CELL_MU2: zenith_place_mu2, Law.CELL_MU: zenith_place_mu}


@pytest.fixture(autouse=True)
def _in_plain_numpy():
    """Kernels of these laws and this precision would be compiled for this file alone, which takes longer."""
    with photons_by(kernels=False):
        yield


def dome_places(law, batch):
    mu, sin2, azimuth = sky_angles(batch)
    return PLACE[law](mu, sin2, DOME[0]), azimuth_place(azimuth, DOME[1])


def unevenness(s, t, n=16):
    return chi2.per_degree(square_counts(s, t, n).ravel(), even(s.size, n * n))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("law", PLACE)
def test_one_cell_is_filled_evenly(law, precision):
    batch = scene(cell_component(law, *DOME), N).source(seed=6, precision=precision).photons()
    assert unevenness(*dome_places(law, batch)) < 0.1


@pytest.mark.parametrize("seed", range(5))
def test_the_patches_of_a_sky_are_filled_evenly(seed):
    """All photons of 8 x 8 patches, four cells in each of them, seen through the directions."""
    table = table_of(np.linspace(1, 3, 64).reshape(8, 8))
    source = scene(table, N).source(seed=seed, precision="float64")
    batch = source.photons()
    mu, _, azimuth = sky_angles(batch)
    ring, column = np.divmod(batch.patch, 8)
    near, far = np.cos(np.deg2rad(table.grid.zenith_bounds_deg[ring])).T ** 2
    s = (near - mu**2) / (near - far)
    t = azimuth / 45 - column
    quarter = batch.patch.astype(int) * 4 + (s > 0.5) * 2 + (t > 0.5)
    expected = np.repeat(source.counts[0] / 4, 4)
    assert chi2.per_degree(np.bincount(quarter, minlength=256), expected) < 0.1


DEFECTS = {
    # a density that is up to 1 % off
    "one percent": lambda s, t: (s + 0.01 / (2 * np.pi * 4) * np.sin(2 * np.pi * 4 * s), t),
    "cosine for cosine squared": lambda s, t: (1 - (1 - s) ** 2, t),
    "no sine": lambda s, t: (np.sin(np.pi / 2 * s) ** 2, t),
    "independent photons": lambda s, t: np.random.default_rng(1).random((2, N)),
}


def test_planted_defects():
    batch = scene(cell_component(Law.CELL_MU2, *DOME), N).source(seed=6, precision="float64").photons()
    places = dome_places(Law.CELL_MU2, batch)
    for name, defect in DEFECTS.items():
        assert unevenness(*defect(*places)) > 0.1, name


@pytest.fixture(scope="module")
def sources_of_seeds():
    components = uneven_sky(2, 3).lower([500])
    return [scene(components, 60).source(seed=seed, precision="float64") for seed in range(SEEDS)]


@pytest.mark.parametrize("index", [0, 37])
def test_over_seeds_each_photon_is_uniform(plan, sources_of_seeds, index):
    """Photon `index` of many seeds: uniform in its patch, and its patch follows the masses."""
    found = [source.photons(0, index, index + 1) for source in sources_of_seeds]
    patch = np.array([int(batch.patch[0]) for batch in found])
    _, sin2, azimuth = (np.concatenate(parts) for parts in zip(*map(sky_angles, found), strict=True))
    ring, column = np.divmod(patch, 3)
    s = np.where(ring == 0, sin2 / 0.5, (sin2 - 0.5) / 0.5)
    t = azimuth / 120 - column
    plan.check(chi2.ks_p(s))
    plan.check(chi2.ks_p(t))
    plan.check(chi2.chi2_p(square_counts(s, t, 6).ravel(), even(SEEDS, 36)))
    mass = uneven_sky(2, 3).mass(0)
    plan.check(chi2.chi2_p(np.bincount(patch, minlength=6), mass / mass.sum() * SEEDS))
    plan.catches(chi2.ks_p(np.mod(index * 0.7548776662466927, 1.0) + np.zeros(SEEDS)))  # R2 without its shift


def test_pairs_of_patches(plan):
    """Philox: the first photons of two patches know nothing of each other, over seeds."""
    place, two = {0: [], 1: []}, scene(table_of(np.ones((1, 2))), 2)
    for seed in range(SEEDS):
        batch = two.source(seed=seed, placement="philox", order="patch", precision="float64").photons()
        _, sin2, azimuth = sky_angles(batch)
        for k in (0, 1):
            place[k].append((sin2[k], azimuth[k] / 180 - k))
    first, second = (np.array(place[k]).T for k in (0, 1))
    for a, b in zip(first, second, strict=True):
        plan.check(chi2.chi2_p(square_counts(a, b, 6).ravel(), even(SEEDS, 36)))
    plan.catches(chi2.chi2_p(square_counts(first[0], first[0], 6).ravel(), even(SEEDS, 36)))
