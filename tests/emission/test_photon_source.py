"""The promises of the source: any split, any order, any process gives the same bits."""

import dataclasses
import inspect
import itertools
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.emission.source_file import head_of
from tests.emission.test_polarised_photons import table as polarised_table
from tests.support.sampled import table_of

BANDS = [450.0, 550.0]
FIELDS = [
    field.name for field in dataclasses.fields(sky.PhotonBatch) if field.name not in ("band", "start", "wavelength_nm")
]


def scene(n=30_011, components=None, **more):
    if components is None:
        components = table_of(np.random.default_rng(3).lognormal(0, 2, (2, 6, 9)), BANDS).lower(BANDS)
    return sky.Scene(wavebands=BANDS, n_photons=n, components=components, **more)


def several():
    disc = sky.DirectBeam(sun_zenith_deg=89.9, sun_azimuth_deg=40, radius_deg=0.2665).lower(BANDS)
    (beam,) = sky.DirectBeam(sun_zenith_deg=30).lower(BANDS)
    named = dataclasses.replace(beam, name="beam")
    return (*disc, *scene().components, *sky.UniformSky(per_solid_angle=True).lower(BANDS), named)


def assert_equal(a, b, part=slice(None)):
    for name in FIELDS:
        left, right = getattr(a, name), getattr(b, name)
        assert (left is None) == (right is None)
        if left is not None:
            np.testing.assert_array_equal(left, right[part])


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("order", ["shuffled", "patch"])
@pytest.mark.parametrize(
    ("components", "options"),
    [
        (None, {"weights": True}),
        (None, {"weights": True, "method": "iid", "replicates": 5}),
        (several(), {}),
        (polarised_table(), {}),
        (polarised_table(), {"replicates": 4}),
    ],
    ids=["weights", "weights of replicates", "several", "polarised", "polarised replicates"],
)
def test_1000_random_splits(precision, order, components, options):
    """Of the twenty ways together; with the numbers of the photons, in slices, and in arrays that are given."""
    light = scene(components=components, footprint=sky.Footprint.circle(3.0))
    source = light.source(seed=7, precision=precision, order=order, **options)
    n, whole = source.n_photons(1), source.photons(1, numbers=2)
    at = n // source.replicates
    for k in range(at - 5, min(at + 5, n)):  # one by one across the end of a replicate
        assert_equal(source.photons(1, k, k + 1, numbers=2), whole, slice(k, k + 1))
    rng = np.random.default_rng(5)
    for _ in range(1000 // 20 // 20):
        cuts = np.unique(np.concatenate([[0, n], rng.integers(0, n, 20)]))
        for start, stop in itertools.pairwise(cuts.tolist()):
            assert_equal(source.photons(1, start, stop, numbers=2), whole, slice(start, stop))
            assert_equal(whole[start:stop], whole, slice(start, stop))
    out = source.photons(1, 0, 3_333, numbers=2)
    for memory in (None, out):
        for batch in source.batches(1, 3_333, memory, numbers=2):
            assert_equal(batch, whole, slice(batch.start, batch.start + len(batch)))
    assert_equal(source.photons(1, 100, 200, out=out, numbers=2), whole, slice(100, 200))


@settings(max_examples=25)
@given(size=st.integers(1, 40_000))
def test_batches_are_the_photons(size):
    source = scene().source(seed=1)
    whole = source.photons(0)
    at = 0
    for batch in source.batches(0, max(size, 500)):
        assert batch.start == at
        assert_equal(batch, whole, slice(at, at + len(batch)))
        at += len(batch)
    assert at == len(whole) == 30_011


def test_many_photons_come_in_blocks(monkeypatch):
    """Between two of them Python answers Ctrl-C; the bits are those of batches, weights and replicates included."""
    source, sizes = scene(5_000).source(seed=2, replicates=3), []
    fill = source._emitter.fill
    monkeypatch.setattr("aomc_sky.emission.photon_source._BLOCK", 1_000)
    monkeypatch.setattr(source._emitter, "fill", lambda *a: (sizes.append(a[2]["ux"].size), fill(*a)))
    whole = source.photons(1, numbers=1)
    assert max(sizes) <= 1_000
    assert sum(sizes) == 5_000
    for batch in source.batches(1, 700, numbers=1):
        assert_equal(batch, whole, slice(batch.start, batch.start + len(batch)))


def test_what_there_is_not():
    with pytest.raises(ValueError, match="at least 1"):
        next(scene().source().batches(0, 0))
    with pytest.raises(sky.SceneError, match="a circle has one diameter"):
        sky.Footprint(shape="circle", size_x_m=1.0, size_y_m=2.0)
    with pytest.raises(sky.UsageError, match="placement must be one of 'r2', 'philox', 'centre', got 'sobol'"):
        scene().source(placement="sobol")


def test_threads_processes_and_plans(tmp_path):
    source = scene().source(seed=2)
    whole = source.photons(1)
    starts = list(range(0, 30_011, 1777))
    with ThreadPoolExecutor(8) as pool:
        parts = list(pool.map(lambda s: source.photons(1, s, min(s + 1777, 30_011)), starts))
    for start, part in zip(starts, parts, strict=True):
        assert_equal(part, whole, slice(start, start + len(part)))
    again = pickle.loads(pickle.dumps(source))
    assert_equal(again.photons(1, 5, 50), whole, slice(5, 50))
    assert len(pickle.dumps(scene(n=10**15).source())) < 100_000
    source = scene(components=several()).source(seed=6, precision="float64")
    source.plan.save(tmp_path / "plan.npz")
    plan = sky.Plan.load(tmp_path / "plan.npz")
    assert plan.sha256 == source.plan.sha256
    again = sky.PhotonSource.from_plan(plan)
    assert_equal(again.photons(0), source.photons(0))
    np.testing.assert_array_equal(again.counts, source.counts)
    assert [c.name for c in again.components] == [c.name for c in source.components]
    assert again.grid.n_patches == source.grid.n_patches


def test_bands_seeds_and_footprints():
    base = scene().source(seed=1)
    assert not np.array_equal(base.photons(0).ux, base.photons(1).ux)
    assert not np.array_equal(base.photons(0).ux, scene().source(seed=2).photons(0).ux)
    only = scene(n=[0, 30_011]).source(seed=1)
    assert_equal(only.photons(1), base.photons(1))
    assert len(only.photons(0)) == 0
    point = scene().source(seed=4)
    shape = sky.Footprint(shape="rectangle", size_x_m=2.0, size_y_m=8.0)
    wide = scene(footprint=shape).source(seed=4)
    a, b = point.photons(0), wide.photons(0)
    np.testing.assert_array_equal(a.ux, b.ux)
    assert a.x is None
    assert np.abs(b.x).max() <= 1
    assert np.abs(b.y).max() <= 4
    assert b.positions.shape == (30_011, 2)


def test_out_is_filled_and_checked():
    source = scene().source(seed=5)
    fresh = source.photons(0, 10, 1010)
    out = source.photons(0, 0, 2000)
    filled = source.photons(0, 10, 1010, out=out)
    assert filled.ux.base is not None
    assert np.shares_memory(filled.ux, out.ux)
    assert_equal(filled, fresh)
    small = source.photons(0, 0, 10)
    with pytest.raises(ValueError, match="at least 1000"):
        source.photons(0, 10, 1010, out=small)
    with pytest.raises(sky.UsageError, match="expected a PhotonBatch, got ndarray"):
        source.photons(0, 10, 1010, out=np.empty((3, 1000), np.float32))
    memory = np.empty(3000, np.float32)
    overlapping = dataclasses.replace(fresh, ux=memory[:1000], uy=memory[999:1999], uz=memory[2000:])
    with pytest.raises(ValueError, match="overlap"):
        source.photons(0, 0, 1000, out=overlapping)


@pytest.mark.parametrize(("band", "start", "stop"), [(2, 0, 1), (-1, 0, 1), (0, -1, 5), (0, 5, 4), (0, 0, 30_012)])
def test_ranges_that_do_not_exist(band, start, stop):
    with pytest.raises(IndexError, match=r"band|photons"):
        scene().source().photons(band, start, stop)


OPTIONS = {
    "seed": 2, "allocation": "largest-remainder", "method": "iid", "placement": "philox", "order": "patch",
    "precision": "float64", "weights": True, "replicates": 3, "bias": {"beam": 0.4},
    "importance": {"sky": lambda zenith, azimuth: 1.0 + zenith},
}  # fmt: skip
"""Each argument of `Scene.source` that changes photons, with a value that is not its default."""


def test_everything_that_changes_photons_changes_the_name():
    assert set(OPTIONS) == {*inspect.signature(sky.Scene.source).parameters} - {"self", "max_memory_bytes"}
    plain = scene(components=several())
    scenes = [plain, scene(n=30_012, components=several()), scene(components=several()[1:])]
    scenes.append(scene(components=several(), footprint=sky.Footprint.circle(1.0)))
    scenes.append(scene(components=several(), bias={"beam": 0.5}))
    plans = [one.source(seed=1).plan.sha256 for one in scenes]
    plans += [plain.source(**{"seed": 1, name: value}).plan.sha256 for name, value in OPTIONS.items()]
    assert len(set(plans)) == len(plans)


def test_counts_of_one_column_are_those_of_allocate():
    values = np.random.default_rng(9).lognormal(0, 3, (54, 1))
    for n in (10, 10**6, 10**12):  # far beyond, the rounding of masses that were divided by their sum shows
        source = sky.Scene(wavebands=[500.0], n_photons=n, components=table_of(values)).source(seed=3)
        np.testing.assert_array_equal(source.counts[0], sky.allocate(values[:, 0], n, seed=3))


def test_listed_weights_turn_photons_into_flux():
    """Weighted photons estimate the mean cosine of the radiance, whatever the launch law."""
    values = np.random.default_rng(8).lognormal(0, 1, (6, 9))

    def mean_mu(weighting, weights):
        table = table_of(values, weighting=weighting)
        source = sky.Scene(wavebands=[500.0], n_photons=10**6, components=table).source(weights=weights)
        batch = source.photons()
        if not weights:
            return float(-batch.uz.astype(float).mean())
        assert abs(batch.weight.astype(float).mean() - 1) < 1e-4
        return float((-batch.uz.astype(float) * batch.weight).mean())

    flux = mean_mu("projected", weights=False)
    assert abs(mean_mu("listed", weights=True) - flux) < 3e-4
    assert abs(mean_mu("solid-angle", weights=True) - flux) < 3e-4
    assert abs(mean_mu("listed", weights=False) - flux) > 0.01


@pytest.mark.parametrize(
    "call",
    [lambda s, path: sky.write_run(s.source(), path), sky.write_mcpl, sky.write_source, lambda s, _: sky.to_xarray(s)],
)
def test_a_scene_in_the_place_of_a_source(call, tmp_path):
    with pytest.raises(sky.UsageError, match=r"expected a (Scene|PhotonSource), got (PhotonSource|Scene); write "):
        call(scene(), tmp_path / "out")
    assert not list(tmp_path.iterdir())


@given(st.data())
def test_a_source_file_with_one_other_bit_has_no_head(data):
    source = scene(n=50).source()
    whole = source.to_bytes()
    found = head_of(whole)
    assert (found["bytes"], found["plan_sha256"], len(found["bands"])) == (len(whole), source.plan.sha256, 2)
    at = data.draw(st.one_of(st.integers(0, 200), st.integers(0, len(whole) - 1)))
    damaged = bytearray(whole)
    damaged[at] ^= 1 << data.draw(st.integers(0, 7))
    assert head_of(bytes(damaged)) is None
    assert head_of(whole[: 8 * (at // 8)]) is None
