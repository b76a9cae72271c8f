"""verify_counts: correct counts pass, every planted defect is caught."""

import numpy as np
import pytest

import aomc_sky as sky

METHODS = ("systematic", "largest-remainder", "multinomial")


def masses(n=400, seed=1):
    mass = np.random.default_rng(seed).lognormal(0, 1.5, n)
    mass[[3, 50, n - 1]] = 0
    return mass


def failed(report):
    return {check.name.split(",")[0] for check in report.checks if not check.passed}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [0, 1, 399, 10**6, 10**12, 4 * 10**18])
def test_our_own_counts_pass(method, n):
    if method == "multinomial":
        n = min(n, 2**53)
    for seed in range(5):
        mass = masses(seed=seed)
        report = sky.verify_counts(sky.allocate(mass, n, method=method, seed=seed), mass, method=method, n_photons=n)
        assert report.passed, report
        assert bool(report)


@pytest.mark.parametrize("method", ["systematic", "largest-remainder"])
@pytest.mark.parametrize("n", [1000, 10**7])
def test_one_photon_moved(method, n):
    mass = masses()
    counts = sky.allocate(mass, n, method=method, seed=3)
    pull = counts - n * mass / mass.sum()
    counts[pull.argmax()] += 1  # the cell that has most already
    least = np.where(counts > 0, pull, np.inf).argmin()
    counts[least] -= 1
    report = sky.verify_counts(counts, mass, method=method)
    assert "each cell within one photon" in failed(report)
    assert {c.cell for c in report.checks if c.name.startswith("each cell")} <= {pull.argmax(), least}


def test_a_photon_moved_that_every_cell_allows():
    """Floor and ceiling exchanged far apart: each cell stays within a photon, runs do not."""
    mass = np.ones(400)
    counts = sky.allocate(mass, 200, seed=1)
    low, high = np.flatnonzero(counts[:100] == 0), 300 + np.flatnonzero(counts[300:] == 1)
    counts[low[0]], counts[high[0]] = 1, 0
    report = sky.verify_counts(counts, mass)
    assert failed(report) == {"each contiguous run within one photon"}
    assert sky.verify_counts(counts, mass, method="largest-remainder").passed


@pytest.mark.parametrize("method", METHODS)
def test_a_photon_where_no_mass_is(method):
    mass = masses()
    counts = sky.allocate(mass, 10**5, method=method)
    counts[50] = 1
    report = sky.verify_counts(counts, mass, method=method)
    assert "zero mass" in failed(report)
    assert next(c.cell for c in report.checks if c.name.startswith("zero mass")) == 50


def test_dark_bands_and_a_lost_photon_which_needs_the_request():
    mass = masses()
    counts = sky.allocate(mass, 10**5)
    counts[counts.argmax()] -= 1
    assert "sum of the counts" in failed(sky.verify_counts(counts, mass, n_photons=10**5))
    assert sky.verify_counts(np.zeros(3, int), np.zeros(3)).passed
    assert not sky.verify_counts([0, 1, 0], np.zeros(3)).passed


def test_counts_of_another_method_fail():
    mass = masses()
    counts = sky.allocate(mass, 10**6, method="multinomial", seed=2)
    assert not sky.verify_counts(counts, mass).passed
    assert not sky.verify_counts(counts, mass, method="largest-remainder").passed
    report = sky.verify_counts(sky.allocate(mass, 10**6), mass, method="multinomial")
    assert failed(report) == {"chi-square"}  # too even


@pytest.mark.parametrize("method", METHODS)
def test_a_mass_one_percent_off(method):
    mass = masses()
    biased = mass.copy()
    biased[:200] *= 1.01
    counts = sky.allocate(biased, 10**7, method=method, seed=4)
    assert not sky.verify_counts(counts, mass, method=method).passed


def test_the_level_holds():
    mass, method = np.ones(50), {"method": "multinomial"}
    reports = [sky.verify_counts(sky.allocate(mass, 5000, seed=k, **method), mass, **method) for k in range(400)]
    found = np.sort([report.checks[-1].found for report in reports])
    distance = np.abs(found - (np.arange(400) + 0.5) / 400).max()
    assert distance < 2.8 / np.sqrt(400)  # Kolmogorov: chance below 4e-7


def test_bands_are_checked_apart():
    mass = np.stack([masses(seed=1), masses(seed=2)])
    counts = np.stack([sky.allocate(m, 10**5) for m in mass])
    assert sky.verify_counts(counts, mass, n_photons=[10**5, 10**5]).passed
    report = sky.verify_counts(counts[::-1], mass)
    assert {check.band for check in report.checks if not check.passed} == {0, 1}
    shared = np.stack([sky.allocate(mass[0], n) for n in (10, 10**4)])
    assert sky.verify_counts(shared, mass[0], n_photons=[10, 10**4]).passed


def test_rational_arithmetic_decides_where_float64_cannot():
    """At 2^60 photons per cell float64 knows multiples of 256; the bound is 1 + 2^60 2^-52 + 2^61 2^-62 = 257.5."""
    half = 2**60
    assert sky.verify_counts([half + 257, half - 257], [1.0, 1.0], method="largest-remainder").passed
    assert not sky.verify_counts([half + 258, half - 258], [1.0, 1.0], method="largest-remainder").passed


@pytest.mark.parametrize("n", [10**15, 10**18])
@pytest.mark.parametrize("method", ["systematic", "largest-remainder"])
def test_masses_that_were_divided_by_their_sum(n, method):
    """A plan keeps them so: what they lose in float64 is no fault of the counts, and a photon moved is still one."""
    mass = np.random.default_rng(5).lognormal(0, 2, 2000)
    counts = sky.allocate(mass, n, seed=5, method=method)
    divided = mass / mass.sum()
    assert sky.verify_counts(counts, mass, method=method)
    assert sky.verify_counts(counts, divided, method=method)
    counts[[3, 1500]] += [n // 10**14, -(n // 10**14)]
    assert not sky.verify_counts(counts, mass, method=method)
    assert not sky.verify_counts(counts, divided, method=method)


@pytest.mark.parametrize(
    ("counts", "mass", "words"),
    [
        ([1, 2], [1.0, 1.0, 1.0], "do not fit"),
        (np.ones((2, 2, 2), int), np.ones((2, 2, 2)), "do not fit"),
        ([], [], "do not fit"),
        ([-1, 2], [1.0, 1.0], "negative"),
        *(([wrong, 2], [1.0, 1.0], "whole numbers") for wrong in (1.5, np.nan, np.inf, "a")),
        ([1e19, 2], [1.0, 1.0], "2\\^62"),
        ([1, 2], [1.0, -1.0], "masses"),
        ([1, 2], [1.0, np.nan], "masses"),
    ],
)
def test_invalid_input(counts, mass, words):
    with pytest.raises(sky.UsageError, match=words):
        sky.verify_counts(counts, mass)
    with pytest.raises(sky.UsageError, match="systematic"):
        sky.verify_counts([1], [1.0], method="fair")
