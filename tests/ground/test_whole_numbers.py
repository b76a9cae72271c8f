"""Numbers that a caller gives: every integer type means the same photons, everything else is our error."""

import functools
import math

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AllocationError, AomcSkyError, SceneError, UsageError
from aomc_sky.plan.streams import checked_seed
from aomc_sky.whole_number import as_index, as_number_of
from tests.support.backend import photons_by
from tests.support.sampled import table_of
from tests.support.shared import INPUTS

INTEGERS = (
    *(np.int8, np.int16, np.int32, np.int64, np.intp),
    *(np.uint8, np.uint16, np.uint32, np.uint64, np.uintp),
    *(lambda n, t=t: np.array(n, t) for t in (np.int8, np.uint32, np.int64)),  # 0-dimensional arrays
)
SOME_INTEGERS = (np.int32, np.uint64, INTEGERS[-1])
"""For calls that all ask the same function."""
NO_INTEGERS = (True, np.True_, 1.0, math.nan, "1", b"1", None, [1], np.array([1]), 1j)
NO_NUMBERS = (True, 1.5, math.nan, math.inf, "1e6", [5], np.array([5]), -1, 2**62 + 1)
CLEAR_DAY = INPUTS / "clear_day" / "amc.inp"


def scene():
    table = table_of(np.arange(72.0).reshape(6, 12))
    return sky.Scene(wavebands=[440.0, 550.0, 670.0], n_photons=100, components=table)


def directions(batch):
    return np.stack([batch.ux, batch.uy, batch.uz]).tobytes() + batch.patch.tobytes()


@pytest.fixture
def by(request):
    with photons_by(kernels=request.param == "compiled"):
        yield


@pytest.mark.parametrize("by", ["plain", "compiled"], indirect=True)
def test_all_integers_are_one_band(by):
    """Photons and what is kept for a band are those of the Python integer, whoever asks first."""
    settled = scene().source(seed=5, replicates=2)
    expected = directions(settled.photons(1, 3, 90))
    assert expected != directions(settled.photons(2, 3, 90))
    for integer in INTEGERS:
        source = PhotonSource(settled.plan)  # nothing kept yet
        one, start, stop = integer(1), integer(3), integer(90)
        assert directions(source.photons(one, start, stop)) == expected
        assert directions(source.photons(1, 3, 90)) == expected
        batches = [directions(b) for b in source.batches(one, integer(64))]
        assert batches == [directions(b) for b in settled.batches(1, 64)]
        batch = source.photons(one, start, stop)
        assert type(batch.band) is int
        assert type(batch.start) is int


@pytest.mark.parametrize("value", NO_INTEGERS, ids=repr)
def test_integers_and_nothing_else_are_whole_numbers(value):
    assert {as_index(integer(7), "n") for integer in INTEGERS} == {7}
    assert {as_number_of(integer(7), "n", 1, 9) for integer in INTEGERS} == {7}
    with pytest.raises(UsageError, match="n must be a whole number"):
        as_index(value, "n")


@pytest.mark.parametrize("integer", SOME_INTEGERS)
def test_all_integers_are_one_question_and_one_seed(integer):
    wanted = scene()
    settled = wanted.source(seed=integer(1), replicates=integer(4))
    assert settled.plan.sha256 == wanted.source(seed=1, replicates=4).plan.sha256
    one = integer(1)
    assert settled.replicate_range(one, one) == settled.replicate_range(1, 1)
    assert np.array_equal(settled.replicate_counts(one), settled.replicate_counts(1))
    assert settled.replicate_parts(one, integer(2), integer(80)) == settled.replicate_parts(1, 2, 80)
    for quantity in ("n_photons", "mass", "expected", "exact_moments", "irradiance", "horizon_loss"):
        np.testing.assert_equal(getattr(settled, quantity)(one), getattr(settled, quantity)(1))
    mass = np.arange(10.0)
    assert np.array_equal(sky.allocate(mass, integer(100), seed=integer(3)), sky.allocate(mass, 100, seed=3))
    read = sky.read_scene(CLEAR_DAY, iterations=integer(100), wavebands=[integer(1)])
    assert read.n_photons.tolist() == [100, 0, 0]
    assert read.options == sky.read_scene(CLEAR_DAY, iterations=100, wavebands=[1]).options
    assert sky.PatchGrid.regular(integer(5), integer(120)).n_azimuth == 120


@pytest.mark.parametrize("value", [True, 1.0, "1", None], ids=repr)
def test_what_is_no_index_is_our_error(value):
    source = scene().source(seed=1)
    of_a_band = (source.n_photons, source.replicate_counts, source.mass, source.expected, source.exact_moments)
    calls = [
        *(functools.partial(call, value) for call in of_a_band),
        lambda: source.photons(value, 0, 5),
        lambda: source.photons(0, value, 5),
        lambda: next(iter(source.batches(value))),
        lambda: next(iter(source.batches(0, value))),
        lambda: source.replicate_range(0, value),
        lambda: source.replicate_range(value, 0),
        lambda: source.replicate_parts(0, value, 5),
        lambda: source.numba_sampler(value),
        lambda: scene().source(seed=value),
        lambda: sky.allocate([1.0, 2.0], 5, seed=value),
        lambda: sky.PatchGrid.regular(value, 4),
        lambda: sky.PatchGrid.regular(4, value),
        lambda: sky.PatchGrid.lattice(value, 4),
        lambda: sky.read_scene(CLEAR_DAY, wavebands=[value]),
    ]
    if value is not None:  # None is the end
        calls.append(lambda: source.photons(0, 0, value))
    for call in calls:
        with pytest.raises(UsageError, match="must be a whole number"):
            call()


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_what_is_no_number_of_photons_is_our_error(value):
    with pytest.raises(SceneError, match=r"iterations must be a whole number from 1 to"):
        sky.read_scene(CLEAR_DAY, iterations=value)
    with pytest.raises(AllocationError, match="must be a whole number from 0 to"):
        sky.allocate([1.0, 2.0], value)
    with pytest.raises(UsageError, match="replicates must be a whole number from 1 to 4096"):
        scene().source(replicates=value)
    if np.ndim(value) == 0:  # a list is one number per band
        with pytest.raises(SceneError, match="n_photons"):
            sky.Scene(wavebands=[440.0], n_photons=value, components=(sky.UniformSky(),))


def test_numbers_of_photons_and_seeds():
    """1e6 is how people write a million."""
    assert sky.read_scene(CLEAR_DAY, iterations=1e3).n_photons[0] == 1000
    assert sky.allocate([1.0, 2.0], np.float64(3e2)).sum() == 300
    assert as_number_of(np.array(1e6), "n", 0, 10**6) == 10**6
    for value in (-1, 2**64, np.int8(-1)):
        with pytest.raises(UsageError, match=r"from 0 to 2\^64 - 1"):
            checked_seed(value)
    assert checked_seed(np.uint64(2**64 - 1)) == 2**64 - 1
    for high, words in ((4096, "4096"), (2**31 - 1, r"2\^31 - 1"), (2**62, r"2\^62"), (2**62 + 1, str(2**62 + 1))):
        with pytest.raises(AomcSkyError, match=f"n must be a whole number from 1 to {words}, got 0"):
            as_number_of(0, "n", 1, high)
    with pytest.raises(UsageError, match=r"n must be a whole number, got 1\.5"):
        as_index(1.5, "n")
