"""Two bands, two seeds, two photons: never the same random numbers."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import TWO_BANDS, even, scene, sky_angles, square_counts

N = 200_000


def source(seed):
    components = sky.UniformSky().lower([450, 550])
    return scene(components, N, bands=TWO_BANDS).source(seed=seed, placement="philox", order="patch")


def sin2(seed, band):
    return sky_angles(source(seed).photons(band))[1]


def pair_p(a, b):
    return chi2.chi2_p(square_counts(a, b).ravel(), even(a.size, 256))


@pytest.mark.parametrize("what", ["bands", "seeds", "successive photons"])
def test_streams_are_apart(plan, what):
    here = sin2(1, 0)
    if what == "successive photons":
        plan.check(pair_p(here[0::2], here[1::2]))
    else:
        plan.check(pair_p(here, sin2(1, 1) if what == "bands" else sin2(2, 0)))


@pytest.mark.parametrize("lag", [0, 1])
def test_planted_swapped_stream(plan_only, lag):
    """A stream that is read twice: at the same place, or (SplitMix by index) shifted by one."""
    here = sin2(1, 0)
    there = np.roll(sin2(1, 0), lag)
    if lag == 0:
        plan_only.catches(pair_p(here, there))
    else:
        aligned = np.roll(there, -1)
        plan_only.catches(pair_p(here, aligned))
        assert pair_p(here, there) >= plan_only.level  # only the right lag shows it


def test_r2_shifts_differ_between_bands_and_seeds():
    first = [scene(sky.UniformSky().lower([450, 550]), 100, bands=TWO_BANDS).source(seed=s).photons(b).uz[0]
             for s in range(20) for b in (0, 1)]  # fmt: skip
    assert np.unique(first).size == 40
