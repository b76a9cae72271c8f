"""Samplers for loops of numba: ends, arguments, processes, weights; their photons to the bit: test_numbers.py, too."""

import pickle

import numba
import numpy as np
import pytest

import aomc_sky as sky
from tests.support.host_scenes import N, directions, source
from tests.support.sampled import table_of
from tests.support.source_files import biased


def test_ends_and_wrong_arguments():
    sampler = source("table").numba_sampler()
    sample, fill = sampler.sample, sampler.fill
    for index in (-1, N, 2**62):
        with pytest.raises(IndexError, match="outside the band"):
            sample(index)
    for wrong in (1.5, True, 1j):
        with pytest.raises(TypeError, match="the index of a photon is an integer"):
            sample(wrong)
    assert sample(N - 1) == sample(np.uint64(N - 1)) == sample(np.int32(N - 1))
    out = np.full((3, 50_000), np.float32(7))
    assert fill(N, out) == fill(2**62, out) == fill(0, out[:, :0].copy()) == 0
    assert np.all(out == 7)
    assert fill(N - 3, out) == 3
    assert np.all(out[:, 3:] == 7)
    wrong = np.empty((3, 10)), np.empty((10, 3), np.float32).T, np.empty(30, np.float32)
    for start, array, error, words in (
        (-1, out, IndexError, "index 0"),
        (0, np.empty((4, 10), np.float32), ValueError, r"\(3, n\)"),
        *((0, array, TypeError, None) for array in wrong),
    ):
        with pytest.raises(error, match=words):
            fill(start, array)
    with pytest.raises(IndexError, match="bands run from 0 to 1"):
        source("table").numba_sampler(2)
    sampler = source("table", [0, 5]).numba_sampler(0)
    with pytest.raises(IndexError):
        sampler.sample(0)
    assert sampler.fill(0, np.empty((3, 4), np.float32)) == 0


def test_two_bands_in_one_parallel_loop():
    bands = source("table", order="patch")
    first, second = (bands.numba_sampler(band).sample for band in (0, 1))

    @numba.njit(parallel=True)
    def loop(out):
        for i in numba.prange(out.shape[1]):
            a, b = first(i), second(i)
            for k in range(3):
                out[k, i] = a[k]
                out[3 + k, i] = b[k]

    out = np.empty((6, N), np.float32)
    loop(out)
    assert out.tobytes() == np.concatenate([directions(bands.photons(band)) for band in (0, 1)]).tobytes()


def test_a_function_that_uses_it_is_not_cached(tmp_path, monkeypatch):
    """Its tables stand at an address of this process: a cached copy would read foreign memory."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    sample = source("table").numba_sampler().sample

    @numba.njit(cache=True)
    def loop(i):
        return sample(i)

    with pytest.warns(numba.NumbaWarning, match="Cannot cache compiled function"):
        loop(0)
    assert not list(tmp_path.rglob("*.nbc"))


def test_tables_outlive_the_sampler():
    def make():
        sample = source("table").numba_sampler().sample

        @numba.njit
        def loop(i):
            return sample(i)

        loop(0)
        return loop

    loop = make()
    wanted = directions(source("table").photons())
    filler = [np.random.default_rng(0).random(10_000) for _ in range(100)]
    assert len(filler) == 100
    assert all(loop(i) == tuple(wanted[:, i]) for i in range(100))


def test_a_sampler_is_made_again_where_it_can_be(monkeypatch):
    one = sky.Scene(wavebands=[550.0], n_photons=50, components="uniform").source(3)
    sampler = one.numba_sampler(0, numbers=1)
    expected = sampler.sample(7)  # its function holds addresses of this process
    again = pickle.loads(pickle.dumps(sampler))
    assert (again.n, again.band, again.numbers, again.precision) == (50, 0, 1, np.float32)
    assert again.sample(7) == expected
    several = source("table", replicates=4)
    with pytest.raises(sky.UsageError, match=r"numba_sampler\(band, replicate=r\), 0 to 3"):
        several.numba_sampler()
    for wrong in (4, -1):
        with pytest.raises(IndexError, match=f"replicate {wrong} does not exist; they run from 0 to 3"):
            several.numba_sampler(replicate=wrong)
    for wrong in (True, False, 0.0, "", [], np.array([0, 1])):
        with pytest.raises(sky.UsageError, match="replicate must be a whole number"):
            several.numba_sampler(replicate=wrong)
    with pytest.raises(sky.UsageError, match="weighted"):
        several.numba_sampler(weighted="no")
    one = pickle.loads(pickle.dumps(several.numba_sampler(1, replicate=2)))
    assert (one.n, one.replicate) == (np.diff(several.replicate_range(1, 2)).item(), 2)
    source("table").numba_sampler()  # what is imported without the compiler stays without it
    monkeypatch.setattr(numba.core.config, "DISABLE_JIT", 1)
    with pytest.raises(sky.UsageError, match="NUMBA_DISABLE_JIT"):
        source("table").numba_sampler()


def loop_over(sampler):
    """Directions (3, n), patches and weights of all photons, one by one in a loop of numba."""
    sample, patch, weights = sampler.sample, sampler.patch, sampler.weights

    @numba.njit
    def loop(rows, cells, weight):
        for i in range(cells.size):
            rows[0, i], rows[1, i], rows[2, i] = sample(i)
            cells[i] = patch(i)
            weight[i] = weights[patch(i)]

    rows, cells = np.empty((3, sampler.n), sampler.precision), np.empty(sampler.n, np.int32)
    weight = np.empty(sampler.n, sampler.precision)
    loop(rows, cells, weight)
    return rows, cells, weight


@pytest.mark.parametrize(("precision", "order"), [("float32", "shuffled"), ("float64", "patch")])
def test_patches_and_weights_of_replicates_in_a_loop(precision, order):
    """Weights of a bias, and those of the patches of listed values, of every replicate; planted: another replicate."""
    how = {"precision": precision, "order": order, "replicates": 3}
    listed = table_of(np.random.default_rng(3).lognormal(0, 1, (7, 11)), weighting="listed")
    plain = sky.Scene(wavebands=[550.0], n_photons=1003, components=listed).source(seed=3, weights=True, **how)
    for made in (biased("disc and table", 1003, **how), plain):
        batch = made.photons(0)
        assert np.unique(batch.weight).size > 1
        with pytest.raises(sky.UsageError, match="weighted=True"):
            made.numba_sampler(0, replicate=1)
        found = [loop_over(made.numba_sampler(0, weighted=True, replicate=r)) for r in range(3)]
        for replicate, (rows, cells, weight) in enumerate(found):
            part = slice(*made.replicate_range(0, replicate))
            assert rows.tobytes() == np.ascontiguousarray(directions(batch)[:, part]).tobytes()
            assert cells.tobytes() == batch.patch[part].tobytes()
            assert weight.tobytes() == batch.weight[part].tobytes()
        assert found[0][0].tobytes() != found[2][0].tobytes()


def test_weights_that_no_cell_has_are_refused():
    uniform = sky.UniformSky(per_solid_angle=True)
    made = sky.Scene(wavebands=[550.0], n_photons=50, components=uniform).source(seed=3, weights=True)
    for weighted in (False, True):
        with pytest.raises(sky.UsageError, match="take photons in batches, or from a source file"):
            made.numba_sampler(0, weighted=weighted)
