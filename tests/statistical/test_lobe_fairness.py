"""Photons of lobes by the default method: each bin its exact expectation, and evener than independent photons."""

import numba
import numpy as np
import pytest

from aomc_sky.emission.band import lobe_offset_words
from aomc_sky.plan import streams
from aomc_sky.skies.lobes.kernels import law as plain
from aomc_sky.skies.lobes.law import LobeTables
from tests.statistical.test_lobe_emission import LOBES as EMITTED
from tests.support import chi2
from tests.support.fairness import LOBES, component, fairness, scene_of
from tests.support.sampled import scene

JIT = not numba.config.DISABLE_JIT
SEEDS = 100_000


@pytest.fixture(scope="module")
def lobe_tables():
    """The lobe "streak" alone, of 1024 bins, and the random words of its offset over seeds."""
    source = scene((component(LOBES["streak"]),), 10).source()
    keys = (streams.stream_key(seed, streams.SHIFT, "stratified") for seed in range(SEEDS))
    words = np.array([streams.philox_pair(key, 0, 0, 2)[0] for key in keys], np.uint64)
    assert lobe_offset_words(source.plan, 0, np.array([0]))[0] == words[0]
    return LobeTables.of(source.components), words


def visits(tables, words, n):
    """How often each bin gets one of the n photons of a lobe, over seeds; no bin gets two of so few."""
    ranges = np.tile(tables.tables[0], words.size)
    seeds = LobeTables(lobe=tables.lobe, cell=np.zeros(words.size, np.int64), tables=(ranges, *tables.tables[1:]))
    proposals, lines = seeds.bin_proposals(np.array([0, n]), words)
    columns = (*proposals.reshape(-1, plain.PROPOSAL_COLUMNS).T, *lines.reshape(-1, plain.LINE_COLUMNS).T)
    found = np.zeros(1 << int(tables.tables[0][1]), np.int64)
    for rank in range(n):
        found += np.bincount(
            plain.bin_of_rank(np.full(words.size, rank, np.uint64), *columns).astype(np.int64), minlength=found.size
        )
    return found


def expectation_p(found, n, seeds):
    """Bins are Bernoulli(n / bins) over seeds; the least p-value, times how many there are (Bonferroni)."""
    least = min(chi2.binomial_p(int(k), seeds, n / found.size) for k in (found.min(), found.max()))
    return min(1.0, found.size * least)


@pytest.mark.parametrize("n", [1, 2, 3, 100])
def test_bins_get_their_expectation(plan, lobe_tables, n):
    """Planted: the same law without an offset, whose photons always fall into the same bins."""
    tables, words = lobe_tables
    assert int(tables.tables[0][1]) == 10
    plan.check(expectation_p(visits(tables, words, n), n, SEEDS))
    plan.catches(expectation_p(visits(tables, np.zeros(200, np.uint64), n), n, 200))


FEW_SEEDS = 400
"""Half of them show the planted defect."""


def first_photons(case, n, seeds=FEW_SEEDS):
    """Where the first of n photons goes over seeds: a direction of the lobe's law."""
    lobe = scene((component(case),), n)
    found = [lobe.source(seed=seed, precision="float64").photons(0, 0, 1) for seed in range(seeds)]
    return -np.concatenate([batch.directions for batch in found])


@pytest.mark.parametrize("n", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_one_photon_over_seeds_follows_the_law(plan, n, monkeypatch):
    """Planted: no offset. With a few photons the lobe then shines from the same few cells of its envelope."""
    from tests.statistical.test_lobe_emission import patch_p

    case = EMITTED["city"]
    plan.check(patch_p(case, first_photons(case, n)))
    monkeypatch.setattr(
        "aomc_sky.emission.emitter.lobe_offset_words", lambda plan, band, cells: np.zeros(cells.size, np.uint64)
    )
    plan.catches(patch_p(case, first_photons(case, n, FEW_SEEDS // 2)))


needs_jit = pytest.mark.skipif(not JIT, reason="long without the JIT")


@needs_jit
@pytest.mark.parametrize("name", ["streak", pytest.param("cloud edge", marks=pytest.mark.slow)])
def test_evener_than_independent_photons(name):
    """3e5 photons alone, at which the law of `aomc-sky/1` was at its worst; see below."""
    found = fairness(LOBES[name], scene_of(LOBES[name], 300_000))
    assert found.n_bins > 500
    assert found.holds, found


def bins_from_words(rank, lobe, proposals, shifts, steps, accept, key, band, jitter):
    """The law of `aomc-sky/1`: the first bits of the sequence name the bin, the rest is stretched over it."""
    assert not jitter
    return None, shifts[0] + rank * steps[0], shifts[1] + rank * steps[1], accept[0] + rank * accept[1]


def plain_photons(source):
    directions = {name: np.empty(source.n_photons(0), source.dtype) for name in ("ux", "uy", "uz")}
    source._emitter.fill_plain(0, 0, {**directions, "patch": np.empty(source.n_photons(0), np.int32)})
    return tuple(directions.values())


def test_planted_strips_of_the_sequence(monkeypatch):
    """Bins as strips of u that are narrower than the points stand apart; the mended law passes the same few seeds."""
    lobe = scene_of(LOBES["streak"], 300_000)
    assert fairness(LOBES["streak"], lobe, seeds=4, emit=plain_photons).holds
    monkeypatch.setattr("aomc_sky.skies.lobes.kernels.law.lobe_words", bins_from_words)
    planted = fairness(LOBES["streak"], lobe, seeds=4, emit=plain_photons)
    assert planted.mean > 1.0
    assert planted.worst > 10.0


def fresh_places(rank, lobe, proposals, shifts, steps, accept, key, band, jitter):
    """The strips of `aomc-sky/1` with everything else as it was, but fresh numbers for the place in the strip."""
    _, first, second, third = bins_from_words(rank, lobe, proposals, shifts, steps, accept, key, band, jitter)
    bits = proposals[0].reshape(-1, plain.PROPOSAL_COLUMNS)[lobe].T[4]
    fresh = np.random.default_rng(int(shifts[0])).integers(0, 2**64, rank.size, dtype=np.uint64)
    down = np.uint64(64) - bits
    return None, ((first >> down) << down) | (fresh >> bits), second, third


@pytest.mark.slow
def test_the_cause_is_the_place_in_the_strip(monkeypatch):
    """With the same strips, azimuths, decisions and later trials, a fresh place in the strip alone mends it."""
    lobe = scene_of(LOBES["streak"], 300_000)
    monkeypatch.setattr("aomc_sky.skies.lobes.kernels.law.lobe_words", bins_from_words)
    stretched = fairness(LOBES["streak"], lobe, seeds=12, emit=plain_photons)
    monkeypatch.setattr("aomc_sky.skies.lobes.kernels.law.lobe_words", fresh_places)
    fresh = fairness(LOBES["streak"], lobe, seeds=12, emit=plain_photons)
    assert stretched.mean > 2 * fresh.mean
    assert stretched.worst > 3 * fresh.worst
    assert fresh.mean < 1.0


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize("name", LOBES)
def test_every_lobe(name):
    """Few photons and many, alone and in a crowd, in both precisions by turns."""
    together, alone = ("float32", "float64")[:: 1 if list(LOBES).index(name) % 2 else -1]
    for n, crowded, precision in (
        (30_000, False, together), (1_000_000, False, alone), (30_000, True, alone), (1_000_000, True, together)
    ):  # fmt: skip
        found = fairness(LOBES[name], scene_of(LOBES[name], n, crowded=crowded), precision=precision)
        assert found.holds, (n, crowded, found)
