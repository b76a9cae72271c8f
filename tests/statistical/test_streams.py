"""Two bands, seeds, photons and methods never have the same random numbers; a stretch of the order is a fair sample."""

import numpy as np
import pytest
from scipy.special import erfc

import aomc_sky as sky
from aomc_sky.plan import streams
from tests.support import chi2
from tests.support.sampled import TWO_BANDS, even, scene, sky_angles, square_counts, table_of, uneven_sky

N = 200_000


def source(seed):
    return scene("uniform", N, bands=TWO_BANDS).source(seed=seed, placement="philox", order="patch")


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
    there = np.roll(here, lag)
    plan_only.catches(pair_p(here, np.roll(there, -lag)))
    if lag:
        assert pair_p(here, there) >= plan_only.level  # only the right lag shows it


def test_r2_shifts_differ_between_bands_and_seeds():
    sources = [scene("uniform", 100, bands=TWO_BANDS).source(seed=seed) for seed in range(20)]
    assert np.unique([source.photons(band).uz[0] for source in sources for band in (0, 1)]).size == 40


METHODS_SEEDS = 250
TABLE = table_of(np.linspace(1, 3, 64).reshape(8, 8))
FOOTPRINT = sky.Footprint.circle(2.0)


def correlation_p(a, b):
    """Two-sided p-value of a correlation; under independence its variance is 1 / (n - 1), for permutations too."""
    r = float(np.corrcoef(a, b)[0, 1])
    return float(erfc(abs(r) * np.sqrt((len(a) - 1) / 2)))


def first_counts(method):
    """Photons of the first patch over seeds, where two or three are expected."""
    few = scene(TABLE, 300)
    return np.array([few.source(seed=seed, method=method).counts[0, :2].sum() for seed in range(METHODS_SEEDS)])


def method_words(what):
    """The same quantity of stratified and of independent photons of one seed."""
    if what == "counts":
        return first_counts("stratified"), first_counts("iid")
    if what == "places":  # both from Philox, photon by photon in the order of ranks
        dome = scene("uniform", N)
        tied = dome.source(seed=1, placement="philox", order="patch")
        free = dome.source(seed=1, method="iid", order="patch")
        return sky_angles(tied.photons())[1], sky_angles(free.photons())[1]
    wide = scene(TABLE, N, footprint=FOOTPRINT)
    tied, free = (wide.source(seed=1, method=method).photons() for method in ("stratified", "iid"))
    return (tied.uz, free.uz) if what == "order" else (tied.x, free.x)


@pytest.mark.parametrize("what", ["counts", "order", "places", "positions"])
def test_methods_of_one_seed_are_apart(plan, what, monkeypatch):
    """Planted: the keys of `aomc-sky/1`, which methods shared."""
    plan.check(correlation_p(*method_words(what)))

    def shared_key(seed, stream, method=None, stream_key=streams.stream_key):
        return stream_key(seed, stream, None if method is None else "stratified")

    for module in ("streams", "allocation"):
        monkeypatch.setattr(f"aomc_sky.plan.{module}.stream_key", shared_key)
    plan.catches(correlation_p(*method_words(what)))


PREFIX = 20_000


def without_replacement_p(patches, counts):
    """Two-sided p-value of a sample without replacement: the chi-square shrinks by (N - n) / (N - 1)."""
    n, total = patches.size, counts.sum()
    observed, expected = chi2.pool(np.bincount(patches, minlength=counts.size), counts * (n / total))
    statistic = chi2.chi2_statistic(observed, expected) * (total - 1) / (total - n)
    return chi2.statistic_p(statistic, observed.size - 1)


@pytest.fixture(scope="module")
def uneven():
    return scene(uneven_sky().lower([500]), N).source(seed=9)


def test_prefixes(plan, uneven):
    for start in (0, N // 2, N - PREFIX):
        plan.check(without_replacement_p(uneven.photons(0, start, start + PREFIX).patch, uneven.counts[0]))


@pytest.mark.parametrize("defect", ["patch order", "golden ratio", "linear congruence", "rotation by a key"])
def test_planted_defects(plan_only, uneven, defect):
    in_order = np.repeat(np.arange(uneven.counts.shape[1]), uneven.counts[0])
    i = np.arange(PREFIX)
    rank = {
        "patch order": i,
        "golden ratio": (i * int(N * 0.6180339887498949)) % N,
        "linear congruence": (i * 48_271 + 7) % N,
        "rotation by a key": (i + 123_456) % N,
    }[defect]
    plan_only.catches(without_replacement_p(in_order[rank], uneven.counts[0]))


def neighbours_p(patch):
    pairs = patch[: patch.size // 2 * 2].reshape(-1, 2)
    return chi2.chi2_p(np.bincount(pairs[:, 0] * 16 + pairs[:, 1], minlength=256), even(pairs.shape[0], 256))


def test_neighbours(plan):
    """Patch of photon i against patch of photon i + 1, among 16 equal patches; few enough of many for chance."""
    patch = scene(table_of(np.ones((4, 4))), 50_000_000).source(seed=10).photons(0, 0, 200_000).patch.astype(int)
    plan.check(neighbours_p(patch))
    plan.catches(neighbours_p(np.sort(patch)))
    plan.catches(neighbours_p(np.arange(200_000) * 7 % 16))
