"""Photons of lobes by the default method: each bin its exact expectation, and evener than independent photons."""

import numba
import numpy as np
import pytest

from tests.statistical.test_lobe_emission import LOBES as EMITTED
from tests.support.fairness import LOBES, component, fairness, scene_of
from tests.support.sampled import scene

JIT = not numba.config.DISABLE_JIT
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
