"""Photons counted by direction: damaged ones, the keyed choice that thins them, and pulls of cells."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.outputs.photons.files import PhotonRows
from aomc_sky.verify.directions import Dependence, DirectionTests, is_kept, thinning_key
from aomc_sky.verify.report import Pulls
from tests.support.shared import INPUTS


def test_damaged_directions_are_counted_as_such():
    source = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=1000).source(0)
    good = source.photons(0).directions[:6]
    bad = np.array([[np.nan, 0, -1], [np.inf, 0, -1], [0, 0, 0], [0, 0, np.nan], [0, 0, 1], [3e38, 3e38, -3e38]])
    tests = DirectionTests(source, dependence=Dependence.PLAN)
    counts = tests.count(0, [PhotonRows(start=0, direction=np.concatenate([good, bad.astype(good.dtype)]))])
    assert (counts.n, counts.n_bad_length) == (12, 5)
    n_above = counts.zone_sums[0].sum()
    assert n_above + counts.n_upward == 12
    assert 6 <= n_above <= 10


def test_counts_are_the_same_on_any_number_of_threads():
    source = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=3000).source(0)
    directions = source.photons(0).directions
    blocks = [PhotonRows(start=k, direction=directions[k : k + 100]) for k in range(0, 3000, 100)]
    tests = DirectionTests(source, dependence=Dependence.STRATIFIED)
    one, three = (tests.count(0, blocks, threads) for threads in (1, 3))
    assert np.array_equal(one.zone_sums, three.zone_sums)
    assert np.array_equal(one.inside, three.inside)
    assert one.repeats.pairs() == three.repeats.pairs()


@given(start=st.integers(0, 2**40), n=st.integers(0, 2000), cut=st.integers(0, 2000))
def test_thinning_does_not_know_how_a_file_is_split(start, n, cut):
    cut = min(cut, n)
    whole = is_kept(7, start, n)
    assert np.array_equal(whole, np.concatenate([is_kept(7, start, cut), is_kept(7, start + cut, n - cut)]))


def test_thinning_of_a_seed_is_for_ever_and_of_another_one_another():
    first, second = (is_kept(thinning_key(seed), 0, 10_000) for seed in (0, 1))
    assert 0.45 < np.mean(first == second) < 0.55
    assert np.packbits(is_kept(thinning_key(0), 0, 64)).tobytes().hex() == "03d78386918d7d62"


def pulls_of(observed, expected, variance):
    found, mean, spread = (np.array([x], dtype=np.float64) for x in (observed, expected, variance))
    zones = sky.PatchGrid.regular(1, len(observed))
    return Pulls(waveband=1, zones=zones, observed=found, expected=mean, variance=spread).pull[0]


def test_pulls_are_in_standard_deviations():
    assert pulls_of([110, 400, 110], [100, 400, 100], [100, 400, 25]).tolist() == [1.0, 0.0, 2.0]
    pulls = pulls_of([3, 0, 2, 1], [2, 0, 0, 30], [2, 0, 0, 30])
    assert np.isnan(pulls[0])  # expects too few
    assert np.isnan(pulls[1])  # dark, and is dark
    assert pulls[2] == np.inf  # photons from the dark
    assert pulls[3] < -5
