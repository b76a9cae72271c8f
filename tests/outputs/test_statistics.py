"""Sums over photons: exact, the same with and without kernels, infinite at the horizon."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aomc_sky.outputs.statistics import BlockSums, PhotonSums

FINITE = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e290, max_value=1e290)


def of(terms):
    total = PhotonSums()
    total.add(BlockSums(replicate=0, n_photons=1, mu=x, inverse=x, weight=x, weighted_inverse=x) for x in terms)
    return total


@settings(deadline=None)
@given(st.lists(FINITE, max_size=60), st.integers(0, 60))
def test_any_grouping_is_the_sum_correctly_rounded(terms, cut):
    grouped = of(terms[:cut])
    grouped.add_sums(PhotonSums.from_json(json.loads(json.dumps(of(reversed(terms[cut:])).as_json())), 1))
    assert grouped.total("mu") == of(terms).total("mu") == float(sum(map(Fraction, terms), Fraction(0)))


def test_sums_are_exact_at_the_ends_of_the_range():
    terms = [2.0**1000, 1.0, 5e-324, -(2.0**-1000), 3e-17, -1e-300, -(2.0**1000)]
    assert of(terms).total("mu") == float(sum(map(Fraction, terms)))
    assert of([2.0**1000, 5e-324, -(2.0**1000)]).total("mu") == 5e-324


@pytest.mark.parametrize("terms", [[1.0, math.inf], [math.nan], [1e308, 1e308], [math.inf, math.inf]])
def test_what_is_not_finite_or_too_large_is_infinite(terms):
    assert of(terms).total("mu") == math.inf
    assert PhotonSums.from_json(of(terms).as_json(), 1).total("mu") == math.inf


@pytest.mark.parametrize("damage", [{"mu": [0.5]}, {"mu": None}, {"weight": [1, 2]}, {"n_photons": ["1"]}])
def test_what_is_no_sum_is_refused(damage):
    with pytest.raises(ValueError, match="sums"):
        PhotonSums.from_json(of([1.0]).as_json() | damage, 1)


def test_sums_of_horizontal_photons_and_of_none():
    def block(mu, inverse):
        return BlockSums(replicate=0, n_photons=1, mu=mu, inverse=inverse, weight=1.0, weighted_inverse=inverse)

    sums = PhotonSums()
    assert sums.mean("mu") is None
    assert sums.planar_over_scalar() is None
    sums.add([block(0.5, 2.0), block(0.0, np.inf)])
    assert (sums.mean("mu"), sums.planar_over_scalar(), sums.mean("weight")) == (0.25, 0.0, 1.0)
    assert sums.mean("weighted_inverse") == np.inf
