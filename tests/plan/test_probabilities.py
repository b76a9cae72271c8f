"""Probabilities and fixed point from masses of any scale."""

import numpy as np
import pytest

from aomc_sky.errors import AllocationError
from aomc_sky.kernels.arithmetic import error_free as fixed_point
from aomc_sky.plan.allocation import fixed_point_cumulative, normalise
from tests.reference import allocation as plain

MASSES = {
    "one": [3.0],
    "equal": [1.0] * 7,
    "one subnormal": [5e-324],
    "all subnormal": [5e-324, 1e-323, 0.0, 1.5e-322],
    "every scale": [1e300, 1e-300, 5e-324, 1.0, 0.0, 1e299],
    "largest": [1.7e308] * 9,
    "two largest": [1.0, 2.0, 2.0, 0.5],
    "beam": [1.0, 1e-17, 1e-18, 1e-19],
    "half a unit": [2.0**-63, 1 - 2.0**-53, 2.0**-53 - 2.0**-63],
    "beyond half a unit": [2.0**-63, 1e-40, 1 - 2.0**-53, 2.0**-53 - 2.0**-63],
    "below half a unit": [2.0**-63, 1 - 2.0**-53, 2.0**-53 - 2.0**-63, 1e-40],
    "many halves": [2.0**-63, *[0.0] * 5, *[1e-60] * 50, 1 - 2.0**-53, 2.0**-53 - 2.0**-63],
    "sky": np.random.default_rng(4).lognormal(sigma=3.0, size=1000).tolist(),
}


@pytest.mark.parametrize("mass", MASSES.values(), ids=MASSES.keys())
def test_fixed_point_equals_the_plain_one(mass):
    cumulative = fixed_point_cumulative(mass)
    assert cumulative.dtype == np.uint64
    assert cumulative[0] == 0
    assert int(cumulative[-1]) == 2**62
    assert cumulative.tolist() == plain.fixed_point(mass)


@pytest.mark.parametrize("mass", MASSES.values(), ids=MASSES.keys())
def test_normalised_to_one_ulp_or_so(mass):
    found = normalise(mass)
    for p, exact in zip(found.tolist(), plain.exact_probability(mass), strict=True):
        tiny = 2.0**-1074
        assert abs(plain.Fraction(p) - exact) <= exact / 2**52 + plain.Fraction(tiny)
    assert abs(sum(map(plain.Fraction, found.tolist())) - 1) <= plain.Fraction(1, 2**52)


def test_quotients_in_doubt_are_settled_by_integers(monkeypatch):
    """Here all of them are."""
    monkeypatch.setattr(fixed_point, "_NEAR_A_HALF", 1.0)
    assert fixed_point_cumulative(MASSES["sky"]).tolist() == plain.fixed_point(MASSES["sky"])


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        ([], "no cells"),
        ([0.0, 0.0], "all masses are zero"),
        ([1.0, -1e-300], "cell 1 has -1e-300"),
        ([1.0, 2.0, np.nan], "cell 2 has nan"),
        ([np.inf, 1.0], "cell 0 has inf"),
    ],
)
@pytest.mark.parametrize("function", [normalise, fixed_point_cumulative])
def test_masses_that_are_none(function, mass, message):
    with pytest.raises(AllocationError, match=message) as caught:
        function(mass)
    assert caught.value.exit_code == 4
