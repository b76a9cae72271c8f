"""Photons shared out otherwise than light: error bars keep their promise, and directions are those of the launch."""

import functools

import numpy as np
import pytest
from scipy.special import stdtrit

import aomc_sky as sky
from aomc_sky.outputs.statistics import PhotonSums, band_results, photon_sums
from tests.support import chi2

R, N, SEEDS = 8, 100, 250
BIAS = {"direct": 0.1}


@functools.cache
def scene():
    beam = sky.DirectBeam(sun_zenith_deg=40.0, strength=0.7)
    diffuse = sky.PerezSky(sun_zenith_deg=40.0, epsilon=4.0, delta=0.2, strength=0.3, grid=sky.PatchGrid.regular(6, 12))
    return sky.Scene(wavebands=[550.0], n_photons=R * N, components=[beam, diffuse])


def result_of(seed, method):
    source = scene().source(seed=seed, method=method, precision="float64", replicates=R, bias=BIAS)
    batch, sums = source.photons(), PhotonSums(R)
    sums.add(photon_sums(source, 0, 0, batch.uz, batch.weight))
    (result,) = band_results(source, {0: sums})
    return result, batch


@pytest.mark.parametrize("method", ["stratified", "iid"])
def test_the_exact_cosine_of_the_light_lies_within_the_error_bars(plan, method):
    hits = planted = 0
    for seed in range(SEEDS):
        result, batch = result_of(seed, method)
        reach = stdtrit(R - 1, 0.975) * result.mean_cosine_standard_error
        hits += abs(result.mean_cosine_photons - result.mean_cosine_exact) < reach
        planted += abs(float(-batch.uz.mean()) - result.mean_cosine_exact) < reach  # each photon counted once
    plan.check(chi2.binomial_p(hits, SEEDS, 0.95))
    plan.catches(chi2.binomial_p(planted, SEEDS, 0.95))


def test_directions_of_the_sky_are_those_of_its_light(plan):
    """Independent photons of the sky: their patches are those of its masses, whatever its share of the photons."""
    source = scene().source(seed=1, method="iid", bias=BIAS)
    counts = np.zeros(source.plan.n_cells, np.int64)
    for seed in range(200):
        counts += scene().source(seed=seed, method="iid", bias=BIAS).counts[0]
    launch = source.launch(0) * counts.sum()
    plan.check(chi2.chi2_p(counts, launch))
    plan.catches(chi2.chi2_p(counts, source.mass(0) * counts.sum()))
