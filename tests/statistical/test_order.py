"""The keyed order: every stretch of it is a fair sample without replacement."""

import numpy as np
import pytest

from tests.support import chi2
from tests.support.sampled import even, scene, table_of, uneven_sky

N = 200_000
PREFIX = 20_000


def without_replacement_p(patches, counts):
    """Two-sided p-value of a sample without replacement: the chi-square shrinks by (N - n) / (N - 1)."""
    n, total = patches.size, counts.sum()
    observed, expected = chi2.pool(np.bincount(patches, minlength=counts.size), counts * (n / total))
    statistic = chi2.chi2_statistic(observed, expected) * (total - 1) / (total - n)
    return chi2.statistic_p(statistic, observed.size - 1)


@pytest.fixture(scope="module")
def source():
    return scene(uneven_sky().lower([500]), N).source(seed=9)


def test_prefixes(plan, source):
    for start in (0, N // 2, N - PREFIX):
        plan.check(without_replacement_p(source.photons(0, start, start + PREFIX).patch, source.counts[0]))


@pytest.mark.parametrize("defect", ["patch order", "golden ratio", "linear congruence", "rotation by a key"])
def test_planted_defects(plan_only, source, defect):
    in_order = np.repeat(np.arange(source.counts.shape[1]), source.counts[0])
    i = np.arange(PREFIX)
    rank = {
        "patch order": i,
        "golden ratio": (i * int(N * 0.6180339887498949)) % N,
        "linear congruence": (i * 48_271 + 7) % N,
        "rotation by a key": (i + 123_456) % N,
    }[defect]
    plan_only.catches(without_replacement_p(in_order[rank], source.counts[0]))


def neighbours_p(patch):
    pairs = patch[: patch.size // 2 * 2].reshape(-1, 2)
    return chi2.chi2_p(np.bincount(pairs[:, 0] * 16 + pairs[:, 1], minlength=256), even(pairs.shape[0], 256))


def test_neighbours(plan):
    """Patch of photon i against patch of photon i + 1, among 16 equal patches; few enough of many for chance."""
    patch = scene(table_of(np.ones((4, 4))), 50_000_000).source(seed=10).photons(0, 0, 200_000).patch.astype(int)
    plan.check(neighbours_p(patch))
    plan.catches(neighbours_p(np.sort(patch)))
    plan.catches(neighbours_p(np.arange(200_000) * 7 % 16))
