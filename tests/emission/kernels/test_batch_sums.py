"""Sums over the photons of a block: in float64 and in their order, whatever their precision."""

import numpy as np
import pytest

from aomc_sky.emission.kernels import batches, plain


@pytest.mark.parametrize("form", [batches, plain])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_sums_are_those_of_one_after_the_other(precision, form):
    rng = np.random.default_rng(1)
    uz, weight = (-rng.uniform(1e-3, 1.0, 999)).astype(precision), rng.lognormal(size=999).astype(precision)
    mu, w = -uz.astype(np.float64), weight.astype(np.float64)
    assert form.block_sums(uz) == (np.cumsum(mu)[-1], np.cumsum(1.0 / mu)[-1])
    assert form.weighted_block_sums(uz, weight) == (np.cumsum(w)[-1], np.cumsum(w / mu)[-1])
