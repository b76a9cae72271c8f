"""Counts for ever: a change of any of them is a change of the photons and a new version of the streams."""

import json
from pathlib import Path

import pytest

from aomc_sky.plan.allocation import allocate

MASS = [0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0]

GOLDEN = json.loads(Path(__file__).with_name("counts.json").read_text())


@pytest.mark.parametrize(("method", "seed", "n", "counts"), GOLDEN, ids=lambda value: str(value)[:20])
def test_counts(method, seed, n, counts):
    assert allocate(MASS, n, method=method, seed=seed).tolist() == counts
