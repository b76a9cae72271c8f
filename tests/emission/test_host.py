"""Samplers for loops of numba: ends, arguments, processes; their photons to the bit: test_numbers.py."""

import pickle

import numba
import numpy as np
import pytest

import aomc_sky as sky
from tests.support.host_scenes import N, directions, source


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
    with pytest.raises(sky.UsageError, match="replicates=1"):
        source("table", replicates=4).numba_sampler()
    source("table").numba_sampler()  # what is imported without the compiler stays without it
    monkeypatch.setattr(numba.core.config, "DISABLE_JIT", 1)
    with pytest.raises(sky.UsageError, match="NUMBA_DISABLE_JIT"):
        source("table").numba_sampler()
