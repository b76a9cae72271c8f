"""Sums over photons: exact in a bounded number of terms, the same with and without kernels, infinite at the horizon."""

from __future__ import annotations

import math
import random
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aomc_sky.outputs import statistics
from aomc_sky.outputs.statistics import BlockSums, ExactSum, PhotonSums

FINITE = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e290, max_value=1e290)


def of(terms) -> ExactSum:
    total = ExactSum()
    for term in terms:
        total.add(term)
    return total


@settings(deadline=None)
@given(st.lists(FINITE, max_size=60), st.integers(0, 60), st.integers(1, 8))
def test_any_grouping_is_the_sum_correctly_rounded(terms, cut, most):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statistics, "_MOST_TERMS", most)
        grouped = of(terms[:cut])
        grouped.add(*of(reversed(terms[cut:])).terms)
    assert grouped.value == of(terms).value == float(sum(map(Fraction, terms), Fraction(0)))


def test_expansion_is_exact_at_the_ends_of_the_range():
    terms = [2.0**1000, 1.0, 5e-324, -(2.0**-1000), 3e-17, -1e-300]
    parts = statistics._expansion(terms)
    assert len(parts) <= 40
    assert sum(map(Fraction, parts)) == sum(map(Fraction, terms))
    assert statistics._expansion([1.0, -1.0]) == []


def test_memory_is_bounded():
    total, draw = ExactSum(), random.Random(3)
    terms = [draw.expovariate(1.0) for _ in range(3 * statistics._MOST_TERMS)]
    for term in terms:
        total.add(term)
        assert len(total._terms) <= statistics._MOST_TERMS
    assert total.value == math.fsum(terms)


@pytest.mark.parametrize("terms", [[1.0, math.inf], [math.nan], [1e308, 1e308], [math.inf, -math.inf]])
def test_what_is_not_finite_or_too_large_is_infinite(terms, monkeypatch):
    assert of(terms).value == math.inf
    monkeypatch.setattr(statistics, "_MOST_TERMS", 1)
    assert of([*terms, 1.0, 1.0]).value == math.inf


def test_sums_of_horizontal_photons_and_of_none():
    def block(mu, inverse):
        return BlockSums(replicate=0, n_photons=1, mu=mu, inverse=inverse, weight=1.0, weighted_inverse=inverse)

    sums = PhotonSums()
    assert sums.mean("mu") is None
    assert sums.planar_over_scalar() is None
    sums.add([block(0.5, 2.0), block(0.0, np.inf)])
    assert (sums.mean("mu"), sums.planar_over_scalar(), sums.mean("weight")) == (0.25, 0.0, 1.0)
    assert sums.mean("weighted_inverse") == np.inf
