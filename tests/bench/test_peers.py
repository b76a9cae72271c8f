"""The peers make the photons that are asked of them; one that is absent is told, not hidden."""

import math

import numpy as np
import pytest

from aomc_sky.errors import MissingExtraError
from bench import peers as peers_module
from bench.peers import peers_of_table
from bench.quantities import Tally
from bench.skies import bench_sky

N = 50_000
NUMPY = ("numpy choice", "numpy multinomial + repeat")
NAMES = (*NUMPY, *(f"{name}, float32" for name in NUMPY), "scipy DiscreteAliasUrn", "scipy DiscreteGuideTable")


@pytest.fixture(scope="module")
def sky():
    return bench_sky("clear-uniform")


def assert_close_to_the_truth(sky, photons):
    """Six standard deviations of independent photons; a patch or a sign that is off shows in all."""
    sums = Tally()
    sums.add(*photons)
    found, truth = sums.values(), sky.truth.values
    assert np.rint(found.histogram * N).sum() == N
    assert abs(found.planar - truth.planar) < 6 * 0.3 / math.sqrt(N)
    assert found.relative_error(truth, "histogram") < 1.3 * 1 / (np.linalg.norm(truth.histogram) * math.sqrt(N))
    for name in ("cone", "ring"):
        p = getattr(truth, name)
        assert abs(getattr(found, name) - p) < 6 * math.sqrt(p / N)


@pytest.fixture(scope="module")
def peers(sky):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers_module, "optional_module", absent)
        found, left_out = peers_of_table(sky.grid, sky.mass)
    assert left_out == ['Mitsuba 3 is left out: not installed: pip install ".[bench]"']
    assert tuple(found) == NAMES
    return found


def absent(name, *, extra):
    raise MissingExtraError(f'not installed: pip install ".[{extra}]"')


@pytest.mark.parametrize("name", NAMES)
def test_photons_follow_the_table(sky, peers, name):
    photons = peers[name](N)
    assert all(part.dtype == np.float32 and part.shape == (N,) for part in photons)
    assert np.allclose(sum(part.astype(np.float64) ** 2 for part in photons), 1, atol=1e-6)
    assert_close_to_the_truth(sky, photons)


def test_a_mirrored_azimuth_would_be_seen(sky, peers):
    x, y, z = peers["numpy choice"](N)
    with pytest.raises(AssertionError):
        assert_close_to_the_truth(sky, (y, x, z))


def test_mitsuba_follows_the_table(sky):
    pytest.importorskip("mitsuba")
    try:
        peer = peers_module.MitsubaPeer(sky.grid, sky.mass / sky.mass.sum())
    except MissingExtraError as error:
        pytest.skip(str(error))
    vector = peer(N)
    photons = (np.ascontiguousarray(np.array(part)) for part in (vector.x, vector.y, vector.z))
    assert_close_to_the_truth(sky, photons)
