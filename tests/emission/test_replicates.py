"""Replicates: lanes of a plan, how a band's photons are shared, and what the sums over them give."""

import math
from typing import get_args

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.outputs.statistics import PhotonSums, photon_sums, scalars_have_variance, standard_error
from aomc_sky.plan.allocation import AllocationWord
from aomc_sky.plan.options import MethodWord, OrderWord, PlacementWord, PrecisionWord

GRID = sky.PatchGrid.regular(4, 6)
VALUES = np.random.default_rng(3).lognormal(0.0, 1.0, (1, GRID.n_patches))
VALUES[0, 5] = 0.0


def scene(n_photons, n_bands=1, weighting="listed", footprint=True):
    table = sky.TabulatedSky(wavelength_nm=[500.0], values=VALUES, grid=GRID, weighting=weighting)
    beam = sky.DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=10)
    perez = sky.PerezSky(sun_zenith_rad=0.7, epsilon=3.0, delta=0.2, grid=sky.PatchGrid.regular(6, 8))
    components = [component for model in (table, beam, perez) for component in model.lower([500.0])]
    place = sky.Footprint.circle(2.0) if footprint else sky.Footprint()
    return sky.Scene(wavebands=[500.0] * n_bands, n_photons=n_photons, components=components, footprint=place)


def joined(batches):
    batches = list(batches)
    return {name: np.concatenate([batch.to_dict()[name] for batch in batches]) for name in batches[0].to_dict()}


def assert_same(first, second):
    assert set(first) == set(second)
    for name, array in first.items():
        assert np.array_equal(array, second[name]), name


def test_one_replicate_is_the_run_without_any():
    plain, one = scene(1000).source(seed=4), scene(1000).source(seed=4, replicates=1)
    assert plain.plan.sha256 == one.plan.sha256 != scene(1000).source(seed=4, replicates=2).plan.sha256
    assert one.plan.cumulative.shape[0] == one.n_bands == 1
    assert_same(joined([plain.photons()]), joined([one.photons()]))
    assert scene(12).source(replicates=12).n_photons(0) == 12
    with pytest.raises(SceneError, match="waveband 2 has 12 photons, too few for 13 replicates"):
        scene([13, 12, 0], n_bands=3).source(replicates=13)
    with pytest.raises(UsageError, match="no randomness"):
        scene(1000).source(replicates=2, allocation="aomc")
    with pytest.raises(UsageError, match="cells in 4000 replicates takes about"):
        scene(5000, n_bands=100).source(replicates=4000, max_memory_bytes=2**25)


WORDS = {"method": MethodWord, "order": OrderWord, "placement": PlacementWord, "precision": PrecisionWord}
WORDS["allocation"] = AllocationWord
OPTIONS = [{name: word} for name, words in WORDS.items() for word in get_args(words)[1:] if word != "aomc"]
"""All that is no default; replicates have no allocation of AOMC."""


@pytest.mark.parametrize("options", [{}, *OPTIONS], ids=str)
def test_a_replicate_is_the_band_of_its_lane(options):
    """Replicate r of band b is band r * n_bands + b of a run with as many bands, so lanes share no counter."""
    source = scene(3 * 700, n_bands=2).source(seed=9, replicates=3, **options)
    bands = scene(700, n_bands=6).source(seed=9, **options)
    for band in range(2):
        pieces = [bands.photons(replicate * 2 + band) for replicate in range(3)]
        assert_same(joined([source.photons(band)]), joined(pieces))


def test_photons_are_shared_evenly_and_counts_keep_their_bounds():
    source = scene([1000, 0, 17], n_bands=3).source(seed=5, replicates=7)
    assert [source.n_photons(band) for band in range(3)] == [1000, 0, 17]
    assert source.counts.sum(axis=1).tolist() == [1000, 0, 17]
    assert source.total == 1017
    for band, n in ((0, 1000), (2, 17)):
        counts = source.replicate_counts(band)
        assert counts.sum(axis=1).tolist() == [n // 7 + (r < n % 7) for r in range(7)]
        assert np.array_equal(counts.sum(axis=0), source.counts[band])
        assert np.all(np.abs(counts - counts.sum(axis=1, keepdims=True) * source.mass(band)) < 1)
        assert np.all(counts[:, source.mass(band) == 0] == 0)
        ranges = [source.replicate_range(band, r) for r in range(7)]
        assert [start for start, _ in ranges[1:]] == [stop for _, stop in ranges[:-1]]
        for (start, stop), row in zip(ranges, counts, strict=True):
            batch = source.photons(band, start, stop)
            assert np.array_equal(np.bincount(batch.patch, minlength=row.size), row)
    assert source.replicate_counts(1).sum() == 0
    with pytest.raises(IndexError, match="replicate 7"):
        source.replicate_range(0, 7)


def sums_of(source, band=0, size=64):
    sums = PhotonSums(source.replicates)
    for start in range(0, source.n_photons(band), size):
        batch = source.photons(band, start, min(start + size, source.n_photons(band)))
        sums.add(photon_sums(source, band, batch.start, batch.uz, batch.weight))
    return sums


def test_standard_errors_are_those_of_the_replicate_means():
    source = scene(1600).source(seed=8, replicates=16, precision="float64")
    mu = -source.photons().uz.reshape(16, 100)
    sums = sums_of(source)
    assert math.isclose(sums.mean("mu"), mu.mean(), rel_tol=1e-14)
    for name, values in (("mu", mu), ("inverse", 1 / mu), ("weighted_inverse", 1 / mu)):
        assert math.isclose(sums.standard_error(name), values.mean(axis=1).std(ddof=1) / 4, rel_tol=1e-9)
    assert sums.mean("weight") == 1.0
    assert sums.standard_error("weight") == 0.0
    assert sums_of(scene(1600).source()).standard_error("mu") is None
    totals, n = np.array([3.0, 5.0, 4.5]), np.array([2.0, 3.0, 3.0])
    residual = totals - 12.5 / 8 * n
    assert math.isclose(standard_error(totals, n), math.sqrt(1.5 * np.sum(residual**2)) / 8, rel_tol=1e-15)
    assert standard_error(totals[:1], n[:1]) is None
    assert standard_error(totals * np.inf, n) is None
    assert standard_error(totals * 0, n * 0) is None


def test_photons_with_weights():
    """Photons of equal solid angle: their weight carries mu, so that Ed has an error and Eo a variance."""
    options = {"replicates": 8, "weights": True, "precision": "float64"}
    source = scene(3200, weighting="solid-angle", footprint=False).source(**options)
    batch, sums = source.photons(), sums_of(source)
    weight, mu = batch.weight.reshape(8, 400), -batch.uz.reshape(8, 400)
    assert math.isclose(sums.mean("weight"), weight.mean(), rel_tol=1e-14)
    assert math.isclose(sums.standard_error("weight"), weight.mean(axis=1).std(ddof=1) / math.sqrt(8), rel_tol=1e-9)
    assert math.isclose(sums.mean("weighted_inverse"), (weight / mu).mean(), rel_tol=1e-14)
    assert sums.standard_error("weight") > 0


def has_variance(*parts, **options):
    plan = sky.Scene(wavebands=[500.0], n_photons=10, components=parts).source(**options).plan
    (found,) = scalars_have_variance(plan, [0])
    return found


def test_which_skies_have_a_variance_of_scalar_irradiance():
    def table(weighting="listed", n_rings=4):  # three rings: zenith angles up to 67.5 degrees
        values = np.arange(24.0)[None] < 6 * n_rings
        return sky.TabulatedSky(wavelength_nm=[500.0], values=values.astype(float), grid=GRID, weighting=weighting)

    assert not has_variance(table())
    assert has_variance(table(n_rings=3))
    assert has_variance(table(), placement="centre")
    assert not has_variance(table("solid-angle"))
    assert has_variance(table("solid-angle"), weights=True)
    assert has_variance(sky.DirectBeam(sun_zenith_deg=89.0))
    assert has_variance(sky.DirectBeam(sun_zenith_deg=89.0, radius_deg=0.267))
    assert not has_variance(sky.DirectBeam(sun_zenith_deg=89.9, radius_deg=0.267))
