"""The Sobol method through the public source: counts, ranges, prefixes, hard scenes, choices that contradict it."""

import pickle

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.source.plan import Plan
from tests.support.sobol_scenes import grid_component, scenes, source_of, sparse


def words(batch):
    return np.concatenate([np.asarray(values).view(np.uint8) for values in (batch.ux, batch.uy, batch.uz, batch.patch)])


def assert_same(one, other):
    np.testing.assert_array_equal(words(one), words(other))


@pytest.mark.parametrize("name", ["table", "sparse", "tiny masses", "spike", "beam and perez", "four components"])
@pytest.mark.parametrize("n", [1, 2, 1000, 30_011])
def test_counts_are_the_histogram_of_the_photons(name, n):
    source = source_of(name, n)
    patch = source.photons().patch
    np.testing.assert_array_equal(np.bincount(patch, minlength=source.plan.n_cells), source.counts[0])
    assert source.n_photons(0) == n == source.counts.sum()
    assert not np.any(source.counts[0][source.mass(0) == 0])


def test_each_component_has_its_systematic_share():
    source = source_of("four components", 5003)
    start = source.plan.arrays["component_start"][:-1]
    counts, expected = np.add.reduceat(source.counts[0], start), np.add.reduceat(source.expected(0), start)
    assert counts.sum() == 5003
    assert np.all(np.abs(counts - expected) < 1)


def source_band():
    return sky.Wavebands(wavelength_nm=np.array([500.0]))


def test_rings_and_cells_are_even_beyond_chance():
    """The first coordinate alone settles the ring: each ring is within two photons, where chance makes 80."""
    n = 2**16
    source = source_of("perez, constant in patches", n)
    rings = source.counts[0].reshape(30, 40).sum(axis=1)
    expected = source.expected(0).reshape(30, 40).sum(axis=1)
    assert np.abs(rings - expected).max() < 2.0
    assert np.sum((source.counts[0] - source.expected(0)) ** 2 / source.expected(0)) / 1199 < 0.1


def test_any_range_gives_the_same_photons():
    n = 10_007
    source = source_of("beam and perez", n)
    whole = source.photons()
    for size in (1000, 4096, 9999):
        parts = list(source.batches(0, size))
        for name in ("ux", "uy", "uz", "patch"):
            joined = np.concatenate([getattr(part, name) for part in parts])
            np.testing.assert_array_equal(joined, getattr(whole, name))
    backwards = [source.photons(0, i, i + 1) for i in (n - 1, 5000, 1, 0)]
    for batch, i in zip(backwards, (n - 1, 5000, 1, 0), strict=True):
        assert (batch.ux[0], batch.uy[0], batch.patch[0]) == (whole.ux[i], whole.uy[i], whole.patch[i])


def test_saved_and_pickled_sources_give_the_same_photons(tmp_path):
    source = source_of("beam and table", 3001, precision="float64")
    source.plan.save(tmp_path / "plan.npz")
    loaded = Plan.load(tmp_path / "plan.npz")
    assert loaded.sha256 == source.plan.sha256
    for other in (sky.PhotonSource.from_plan(loaded), pickle.loads(pickle.dumps(source))):
        assert_same(other.photons(), source.photons())
        np.testing.assert_array_equal(other.counts, source.counts)


def test_the_beam_is_within_a_photon_in_every_prefix():
    n = 4001
    source = source_of("beam and table", n)
    is_beam = np.cumsum(source.photons().patch == 0)
    share = int(source.counts[0, 0])
    assert np.abs(is_beam - np.arange(1, n + 1) * share / n).max() <= 0.5


def test_every_prefix_of_a_power_of_two_is_even():
    """A prefix of 2^k photons is itself a net: each of 16 equal patches holds 2^k / 16 photons, exactly."""
    component = grid_component(sky.Law.CELL_MU2, 4, 4, mass=np.ones(16))
    scene = sky.Scene(wavebands=source_band(), n_photons=5000, components=(component,))
    patch = scene.source(seed=3, method="sobol").photons().patch
    for k in range(4, 13):
        assert set(np.bincount(patch[: 2**k], minlength=16)) == {2**k // 16}


def test_bands_seeds_and_components_have_sequences_of_their_own():
    bands = sky.Wavebands(wavelength_nm=np.array([450.0, 550.0]))
    table = grid_component(sky.Law.CELL_MU2)
    twins = (table, grid_component(sky.Law.CELL_MU2, name="twin"))
    source = sky.Scene(wavebands=bands, n_photons=2000, components=twins).source(seed=1, method="sobol")
    other = sky.Scene(wavebands=bands, n_photons=2000, components=twins).source(seed=2, method="sobol")
    first, second = source.photons(0), source.photons(1)
    assert np.mean(first.ux == second.ux) < 0.01
    assert np.mean(first.ux == other.photons(0).ux) < 0.01
    half = table.n_cells
    mine, twin = first.ux[first.patch < half], first.ux[first.patch >= half]
    assert np.mean(mine[:900] == twin[:900]) < 0.01


def test_replicates_are_lanes_with_sequences_of_their_own():
    source = source_of("beam and table", 4000, replicates=4)
    photons = source.photons()
    np.testing.assert_array_equal(np.bincount(photons.patch, minlength=source.plan.n_cells), source.counts[0])
    rows = photons.ux.reshape(4, 1000)
    sky_photons = photons.patch.reshape(4, 1000) > 0
    for a in range(3):
        both = sky_photons[a] & sky_photons[a + 1]
        assert np.mean(rows[a][both] == rows[a + 1][both]) < 0.01


def test_the_largest_sequence():
    source = source_of("beam", 2**32)
    assert source.counts.tolist() == [[2**32]]
    last = source.photons(0, 2**32 - 3, 2**32)
    assert last.patch.tolist() == [0, 0, 0]
    np.testing.assert_array_equal(last.uz, source.photons(0, 0, 3).uz)
    with pytest.raises(SceneError, match="--method stratified, fewer --iterations or more --replicates"):
        source_of("beam", 2**32 + 1)
    assert source_of("beam", 2**33, replicates=2).counts.tolist() == [[2**33]]


def test_places_in_a_cell_of_the_largest_sequence():
    """One lit patch and 2^32 photons: its last photons lie where a smaller one has none, all apart."""
    source = source_of("spike", 2**32, precision="float64")
    photons = source.photons(0, 2**32 - 4096, 2**32)
    mu2 = np.sort(photons.uz**2)
    cell = 14 // 6
    edges = np.cos(np.deg2rad([18.0 * cell, 18.0 * (cell + 1)])) ** 2
    assert edges[1] <= mu2[0] < mu2[-1] <= edges[0]
    assert np.histogram(mu2, 64, (edges[1], edges[0]))[0].tolist() == [64] * 64
    assert np.unique(mu2).size == 4096


def test_tiny_cells_are_no_lattice():
    """What is left of a coordinate in a cell of 1e-6 of the light has random bits below the scrambled ones."""
    component = grid_component(sky.Law.CELL_MU2, 1, 2, mass=[1.0, 1e-4])
    scene = sky.Scene(wavebands=source_band(), n_photons=2**20, components=(component,))
    source = scene.source(seed=4, method="sobol", precision="float64")
    photons = source.photons()
    chosen = photons.patch == 1
    assert abs(chosen.sum() - 104.8) < 3
    azimuth = np.mod(np.arctan2(-photons.uy[chosen], -photons.ux[chosen]) / np.pi, 2.0) - 1
    assert np.unique(azimuth).size == chosen.sum()
    remainder = np.mod(np.sort(azimuth) * 2**16, 1.0)  # far below the spacing of the points
    assert 0.3 < remainder.mean() < 0.7
    assert np.unique(np.floor(remainder * 64)).size > 35


def test_dark_rings_get_nothing():
    source = source_of("sparse", 20_000)
    assert set(np.flatnonzero(source.counts[0])) == {95, 1800, 1807}
    assert np.abs(source.counts[0][[95, 1800, 1807]] - [4000, 10_000, 6000]).max() <= 3


def test_a_dark_component_and_a_dark_band():
    table = sparse()
    off = sky.Component(
        name="off", law=table.law, strength=np.zeros(1), mass=table.mass, cell=table.cell, grid=table.grid
    )
    source = sky.Scene(wavebands=source_band(), n_photons=100, components=(off, table)).source(method="sobol")
    assert source.photons().patch.min() >= 3600
    nothing = sky.Scene(wavebands=source_band(), n_photons=0, components=(off,)).source(method="sobol")
    assert nothing.photons().ux.size == 0
    with pytest.raises(SceneError, match="no light"):
        sky.Scene(wavebands=source_band(), n_photons=5, components=(off,)).source(method="sobol")


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"placement": "r2"}, "method 'sobol' means placement 'sobol', which contradicts 'r2'"),
        ({"placement": "philox"}, "contradicts 'philox'"),
        ({"order": "patch"}, "method 'sobol' means order 'shuffled', which contradicts 'patch'"),
        ({"allocation": "multinomial"}, "method 'sobol' means allocation 'systematic'"),
        ({"allocation": "aomc"}, "contradicts 'aomc'"),
    ],
)
def test_choices_that_contradict(options, text):
    with pytest.raises(UsageError, match=text):
        source_of("table", 10, **options)


def test_the_placement_comes_with_the_method_alone():
    scene = sky.Scene(wavebands=source_band(), n_photons=10, components=scenes()["table"])
    with pytest.raises(UsageError, match="part of method 'sobol'"):
        scene.source(placement="sobol")
    with pytest.raises(UsageError, match="'stratified', 'iid', 'sobol'"):
        scene.source(method="halton")
    assert scene.source().plan.options["method"] == "stratified"
    assert scene.source(method="iid").plan.options["method"] == "iid"
    assert source_of("table", 10).plan.options["method"] == "sobol"
    assert source_of("table", 10, allocation="systematic", order="shuffled").counts.sum() == 10


def test_a_preset_with_a_name_wins():
    from aomc_sky.source.from_table import AOMC_TABLE_PRESET

    scene = sky.Scene(
        wavebands=source_band(),
        n_photons=10,
        components=scenes()["table"],
        preset=AOMC_TABLE_PRESET,
        preset_name="--compat aomc",
    )
    with pytest.raises(UsageError, match="--compat aomc means"):
        scene.source(method="sobol")
