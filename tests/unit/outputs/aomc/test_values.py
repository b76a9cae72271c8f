"""Radiances for the AOMC program: its 32-bit rule gives back the very counts, whatever they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aomc_sky.errors import AllocationError
from aomc_sky.outputs.aomc import skydist
from aomc_sky.outputs.aomc.skydist import MOST_PHOTONS, exact_radiances
from aomc_sky.sampling.allocation import allocate
from aomc_sky.skies.tabulated import aomc_weight


def launches(radiance: np.ndarray, n: int) -> np.ndarray:
    return allocate(aomc_weight(radiance), n, method="aomc")


def assert_exact(counts: np.ndarray) -> None:
    radiance = exact_radiances(counts)
    assert radiance.dtype == np.float32
    assert np.array_equal(radiance > 0, counts > 0)
    assert np.array_equal(launches(radiance, int(counts.sum())), counts)


@st.composite
def skies(draw):
    """Counts of a random sky: smooth, spiky, sparse or with a few patches that hold most of the photons."""
    n_azimuth = draw(st.sampled_from([1, 3, 24, 360]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    mass = rng.random((89, n_azimuth)) ** draw(st.sampled_from([0.0, 1.0, 20.0]))
    mass[rng.random(mass.shape) < draw(st.sampled_from([0.0, 0.5, 0.97]))] = 0.0
    for share in draw(st.lists(st.sampled_from([0.1, 0.3, 0.5, 1.0, 3.0]), max_size=3)):
        mass[rng.integers(89), rng.integers(n_azimuth)] = share * max(mass.sum(), 1.0)
    mass[rng.integers(89), rng.integers(n_azimuth)] += 1.0
    n = draw(st.one_of(st.sampled_from([1, 1000, 10**5, 10**7, MOST_PHOTONS]), st.integers(1, MOST_PHOTONS)))
    return rng.multinomial(n, (mass / mass.sum()).ravel()).reshape(mass.shape)


@settings(deadline=None, max_examples=60)
@given(skies())
def test_the_program_launches_exactly_these_counts(counts):
    assert_exact(counts)


@pytest.mark.slow
@settings(deadline=None, max_examples=4000)
@given(skies())
def test_the_program_launches_exactly_these_counts_of_many_skies(counts):
    assert_exact(counts)


@pytest.mark.parametrize("n", [1, 5, 7_499_999, 8_388_607, 8_388_609, MOST_PHOTONS - 1, MOST_PHOTONS])
def test_few_patches_hold_all_photons(n):
    for places in ([(0, 0)], [(88, 2), (44, 1)], [(0, 0), (6, 1), (12, 2)]):
        counts = np.zeros((89, 3), dtype=np.int64)
        for place, part in zip(places, np.diff(np.linspace(0, n, len(places) + 1).astype(int)), strict=True):
            counts[place] = part
        assert_exact(counts)


def test_one_patch_of_most_photons_in_a_bright_sky_needs_more_than_the_first_guess():
    rng = np.random.default_rng(5)
    mass = 0.85 + 0.3 * rng.random((66, 178))
    mass[46, 77] = 3 * mass.sum()
    assert_exact(rng.multinomial(10**7, (mass / mass.sum()).ravel()).reshape(mass.shape))


def test_plain_float32_values_would_not_do():
    """The planted defect: counts divided by the weight of radiance 1, without a look at what comes out."""
    rng = np.random.default_rng(8)
    wrong = 0
    for _ in range(200):
        counts = np.zeros((89, 1), dtype=np.int64)
        counts[rng.integers(1, 88, 3), 0] = rng.integers(4_200_000, 5_300_000, 3)
        plain = (counts / aomc_weight(np.ones(counts.shape)).astype(np.float64)).astype(np.float32)
        wrong += not np.array_equal(launches(plain, int(counts.sum())), counts)
        assert_exact(counts)
    assert wrong > 20


def test_a_dark_sky_has_no_radiance():
    assert not exact_radiances(np.zeros((89, 4), dtype=np.int64)).any()


def test_too_many_photons_are_refused():
    counts = np.zeros((89, 1), dtype=np.int64)
    counts[3] = MOST_PHOTONS + 1
    with pytest.raises(AllocationError, match="16000001 photons in a band"):
        exact_radiances(counts)


def test_counts_that_cannot_be_had_are_an_error_and_never_silent(monkeypatch):
    monkeypatch.setattr(skydist, "allocate", lambda weight, n, method: np.zeros(weight.shape, np.int64))
    with pytest.raises(AllocationError, match="no 32-bit radiances"):
        exact_radiances(np.full((89, 1), 7))
