"""Errors, trends and times to reach an error on numbers whose answers are known."""

import dataclasses
import math

import numpy as np
import pytest

from bench.accuracy import Found, Row, error_of, measure_errors, slope_of, trends
from bench.quantities import QUANTITIES, Values
from bench.samplers import METHODS
from bench.skies import bench_sky

TRUTH = Values(planar=0.5, scalar=2.0, cone=0.1, ring=0.01, histogram=np.full(4, 0.25))


def off_by(share):
    return Values(**{name: (1.0 + share) * value for name, value in dataclasses.asdict(TRUTH).items()})


def test_error_is_the_root_mean_square_and_scalar_the_median():
    error, bias = error_of([off_by(share) for share in (0.3, -0.1, 0.1)], TRUTH)
    for quantity in ("planar", "cone", "ring", "histogram"):
        assert error[quantity] == pytest.approx(math.sqrt(0.11 / 3))
    assert error["scalar"] == pytest.approx(0.1)
    assert set(bias) == set(QUANTITIES) - {"histogram"}
    assert all(value == pytest.approx(0.1) for value in bias.values())


def rows(errors, photons, seconds=None):
    times = seconds or [n * 1e-8 for n in photons]
    run = {"sky": "uniform", "method": "iid", "replicates": 9, "plan_s": 0.0}
    return [
        Row(n_photons=n, emit_s=t, error=dict.fromkeys(QUANTITIES, e), **run)
        for n, e, t in zip(photons, errors, times, strict=True)
    ]


def reach_of(given, k):
    (trend,) = (trend for trend in trends(given) if trend.quantity == "planar")
    return trend.reach[k]


def test_time_to_reach_an_error_on_a_straight_line():
    """Error = 10 / sqrt(N): 1 % at 1e6 photons, 0.01 % at 1e10, which is beyond what was measured."""
    photons = [10**4, 10**5, 10**7]
    given = rows([10 / math.sqrt(n) for n in photons], photons)
    assert slope_of(np.array(photons), np.array([10 / math.sqrt(n) for n in photons])) == pytest.approx(-0.5)
    near, far = reach_of(given, 0), reach_of(given, 1)
    assert (near.found, far.found) == (Found.BETWEEN, Found.BEYOND)
    assert (near.photons, near.seconds) == pytest.approx((1e6, 1e-2))
    assert (far.photons, far.seconds) == pytest.approx((1e10, 100))


def test_floors_are_never_passed_and_a_good_start_is_told():
    floor = rows([0.1, 0.051, 0.05, 0.05], [10**3, 10**4, 10**5, 10**6])
    assert reach_of(floor, 0).found is Found.NEVER
    assert math.isinf(reach_of(floor, 0).seconds)
    good = rows([1e-3, 1e-5], [10**3, 10**4])
    assert reach_of(good, 0).found is Found.AT_MOST
    assert reach_of(good, 0).photons == 1000
    assert reach_of(good, 1).found is Found.BETWEEN
    exact = rows([0.5, 0.0], [10**3, 10**4])
    assert reach_of(exact, 1).found is Found.BETWEEN
    photons, errors = [10**4, 10**5, 10**6], [0.1, 0.011, 0.0105]
    assert reach_of(rows(errors, photons), 1).found is Found.BEYOND
    biased = [dataclasses.replace(row, bias={"planar": -row.error["planar"]}) for row in rows(errors, photons)]
    assert reach_of(biased, 1).found is Found.NEVER


def test_independent_photons_have_the_error_that_theory_gives():
    """Variance of a share p is p (1 - p) / N; of the mean of mu on a uniform sky 1/18 / N. 40 runs: within 40 %."""
    n, truth = 20_000, bench_sky("uniform").truth.values
    (row,) = measure_errors(bench_sky("uniform"), [METHODS["iid"]], n, replicates=40, seed=5)
    assert row.error["planar"] == pytest.approx(math.sqrt(1 / 18 / n) / truth.planar, rel=0.4)
    for quantity in ("cone", "ring"):
        p = getattr(truth, quantity)
        assert row.error[quantity] == pytest.approx(math.sqrt((1 - p) / p / n), rel=0.4)
    expected = math.sqrt((1 - (truth.histogram**2).sum()) / n) / np.linalg.norm(truth.histogram)
    assert row.error["histogram"] == pytest.approx(expected, rel=0.2)


def test_a_method_without_chance_runs_once():
    found = measure_errors(bench_sky("sparse"), list(METHODS.values()), 2000, replicates=3)
    by_name = {row.method: row for row in found}
    assert by_name["aomc"].replicates == 1
    assert by_name["default"].replicates == 3
    assert by_name["patch-order"].error == by_name["default"].error
