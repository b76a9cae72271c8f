"""Equal patches whose rings are nearly a period of the places' lattice: never worse than jitter or independent photons.

Errors are root mean squares over seeds, so with k seeds their squares scatter like chi-square of k degrees of freedom
over k: against independent photons, whose error is known, the level is 1e-7 for each quantity. Against jitter the
bound is the promise of docs/methods.md, a factor of 2; the worst found is 1.2.
"""

import numpy as np
import pytest
from scipy.special import chdtri

from tests.support.resonances import EqualPatches, grids

SEEDS = 24
WORSE = float(np.sqrt(chdtri(SEEDS, 1e-7) / SEEDS))
JITTER = 2.0

RINGS = 33
"""Few enough for photons in step to show, enough for neighbours to cancel where they are not."""


def too_large(patches, places):
    """Quantities whose error is beyond one of the two bounds, and by how much."""
    found = patches.errors(places, SEEDS)
    jitter = patches.errors(patches.jittered(), SEEDS)
    independent = patches.errors_of_independent()
    over = {f"{name} / jitter": found[name] / jitter[name] / JITTER for name in found}
    over |= {f"{name} / independent": found[name] / independent[name] / WORSE for name in independent}
    return {name: ratio for name, ratio in over.items() if ratio > 1}


@pytest.mark.parametrize(
    "some",
    [
        list(grids((RINGS,), largest=24)),
        *(pytest.param(list(grids((rings,))), marks=pytest.mark.slow) for rings in (33, 90)),
        # the golden ratio alone would move the resonances to 20, 27, 34, 41 ... columns
        pytest.param([(RINGS, columns, 1) for columns in range(5, 181)], marks=pytest.mark.slow),
    ],
)
def test_rings_that_are_nearly_a_period(some):
    for grid in some:
        patches = EqualPatches(*grid)
        assert not too_large(patches, patches.emitted()), grid


@pytest.mark.parametrize("grid", [(60, 86, 1), (40, 86, 1), (90, 7, 1), (33, 172, 1), (90, 7, 2)])
def test_places_by_the_rank_in_the_band_are_found_out(grid):
    """The planted defect: the law of aomc-sky/1."""
    patches = EqualPatches(*grid)
    assert too_large(patches, patches.by_rank())


@pytest.mark.parametrize("grid", [(60, 27, 1), (33, 20, 1), (90, 120, 1)])
def test_the_golden_ratio_without_a_new_start_is_found_out(grid):
    """The other planted defect: rings a golden ratio on, the steps counted through the whole band."""
    patches = EqualPatches(*grid)
    assert too_large(patches, patches.by_rank(golden=True))


@pytest.mark.parametrize("grid", [(60, 86, 1), (33, 27, 2)])
def test_the_places_along_the_flux_are_those_of_the_rank(grid):
    """u knows nothing of rings, so planar irradiance gains as much as by the rank in the band alone."""
    patches = EqualPatches(*grid)
    _, u, _ = patches.emitted()(5)
    steps = np.mod(np.diff(u), 1.0)
    # u comes back from sin^2 of a direction: 1e-16 over a growth of 5e-4 and more
    np.testing.assert_allclose(steps, 0.7548776662466927, atol=1e-11)


def test_photons_above_each_other_are_a_golden_ratio_apart():
    patches = EqualPatches(12, 30, 3)
    _, _, v = patches.emitted()(8)
    first = v.reshape(12, 30, 3)
    np.testing.assert_allclose(np.mod(np.diff(first, axis=0), 1.0), 0.6180339887498949, atol=2**-31)
    np.testing.assert_allclose(np.mod(np.diff(first.reshape(12, 90), axis=1), 1.0), 0.5698402909980532, atol=1e-11)
