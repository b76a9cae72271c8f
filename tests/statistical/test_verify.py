"""The tests that `verify` makes: correct photons pass as often as they should, planted defects fail each test."""

from functools import lru_cache

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.verify.directions import Dependence, is_kept, thinning_key
from aomc_sky.verify.report import kolmogorov_p
from tests.support import chi2
from tests.support.sampled import scene
from tests.support.shared import INPUTS
from tests.support.verified import direction_report, directions_of, named, uniform_in_zenith_angle

SEEDS = 8
N = 30_000
MANY = 2_000_000


@lru_cache(maxsize=8)
def scene_of(name, n=N):
    return sky.read_scene(INPUTS / name / "amc.inp", iterations=n)


@lru_cache(maxsize=4)
def many(method):
    source = scene_of("clear_day", MANY).source(3, method=method)
    return source, directions_of(source)


@lru_cache(maxsize=32)
def independent_report(name, seed):
    """The tests of independent photons of a scene, which several tests below look at."""
    return direction_report(scene_of(name).source(seed, method="iid"), Dependence.INDEPENDENT)


def share_below_p(reports, *beginnings, limit=0.3):
    """p-value of how many p-values of tests lie below a limit: they are uniform."""
    p_values = [named(report, name).p_value for report in reports for name in beginnings]
    return chi2.binomial_p(sum(p < limit for p in p_values), len(p_values), limit)


def summed_p(reports, beginning):
    """Two-sided p-value of the sum of a chi-square over independent reports."""
    checks = [named(report, beginning) for report in reports]
    assert all(check.p_value is not None for check in checks)
    degrees = sum(int(check.detail.split()[2]) for check in checks)
    return chi2.statistic_p(sum(check.found for check in checks), degrees)


def check_sums(plan, reports, *more):
    assert all(reports)
    for beginning in ("mu^2:", "azimuth:", "mu^2 x azimuth:", *more):
        plan.check(summed_p(reports, beginning))


@pytest.mark.parametrize("name", ["clear_day", pytest.param("perez_sky", marks=pytest.mark.slow)])
def test_chi_squares_of_independent_photons(plan, name):
    """Statistics of many seeds add up to a chi-square: level and power are those of theory."""
    reports = [independent_report(name, seed) for seed in range(SEEDS)]
    check_sums(plan, reports, "inside patches, mu^2: chi", "inside patches, azimuth: chi")
    lattice = [direction_report(scene_of(name).source(s), Dependence.INDEPENDENT) for s in range(4)]
    plan.catches(summed_p(lattice, "mu^2:"))  # too even is a defect as well


def test_chi_squares_after_thinning(plan):
    source = scene_of("clear_day").source(5)
    reports = [direction_report(source, Dependence.STRATIFIED, seed=seed) for seed in range(SEEDS)]
    check_sums(plan, reports)
    free = [scene_of("clear_day").source(seed, method="iid") for seed in range(4)]
    independent = [direction_report(source, Dependence.STRATIFIED) for source in free]
    plan.catches(summed_p(independent, "mu^2 x azimuth:"))  # twice the variance


def importance_sampled(source, seed):
    """Photons of the source's light drawn from another law, with weights that make up for it."""
    rng = np.random.default_rng(seed)
    directions = directions_of(source)
    chance = 0.25 + 0.75 * -directions[:, 2]
    kept = rng.random(len(directions)) < chance
    return directions[kept], 1 / chance[kept]


def test_chi_squares_of_weights(plan):
    reports = []
    for seed in range(SEEDS):
        source = scene_of("clear_day").source(seed, method="iid")
        directions, weight = importance_sampled(source, seed)
        reports.append(direction_report(source, Dependence.INDEPENDENT, directions, weight=weight))
    check_sums(plan, reports)
    directions, weight = importance_sampled(source, 1)
    without = direction_report(source, Dependence.INDEPENDENT, directions)
    plan.catches(named(without, "mu^2:").p_value)
    plan.catches(named(direction_report(source, Dependence.INDEPENDENT, directions, weight=weight**2), "mu^2:").p_value)


def test_kolmogorov_distances(plan):
    """P-values of the distance inside patches are uniform."""
    reports = [independent_report("clear_day", seed) for seed in range(20)]
    plan.check(share_below_p(reports, "inside patches, mu^2: Kolm", "inside patches, azimuth: Kolm"))
    plan.catches(kolmogorov_p(3.5 / np.sqrt(N), N))  # 5e-11


def lambert(directions, share, seed=0):
    """The directions with a share of them from a sky of the same radiance everywhere."""
    rng = np.random.default_rng([seed, 1])
    spoilt = directions.copy()
    chosen = rng.random(len(directions)) < share
    sine, azimuth = np.sqrt(rng.random(chosen.sum())), rng.random(chosen.sum()) * 2 * np.pi
    spoilt[chosen] = -np.column_stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - sine**2)])
    return spoilt


@pytest.mark.parametrize(
    ("beginning", "spoil", "band"), [("share uniform", uniform_in_zenith_angle, 0), ("share of equal", lambert, 2)]
)
def test_shares(plan, beginning, spoil, band):
    """P-values of the score are uniform for independent photons, and a share of 10 % is measured."""
    day = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=N, wavebands=[band + 1])
    sources = [day.source(seed, method="iid") for seed in range(20)]
    plan.check(share_below_p([direction_report(s, Dependence.INDEPENDENT, band=band) for s in sources], beginning))
    directions = spoil(directions_of(sources[1], band), 0.1)
    spoilt = named(direction_report(sources[1], Dependence.INDEPENDENT, directions, band=band), beginning)
    plan.catches(spoilt.p_value)
    assert abs(spoilt.found - 0.1) < 4 * float(spoilt.detail.split()[-1])  # its standard deviation


def test_one_percent_of_lambert_in_a_million_photons(plan_only):
    """Its size in standard deviations is 0.01 sqrt(N D) = 9.6 in this waveband, D = 0.92 from the masses alone."""
    day = sky.read_scene(INPUTS / "clear_day" / "amc.inp", iterations=1_000_000, wavebands=[3])
    source = day.source(1, method="iid")
    report = direction_report(source, Dependence.INDEPENDENT, lambert(directions_of(source, 2), 0.01), band=2)
    check = named(report, "share of equal")
    assert float(check.detail.split()[-1]) == pytest.approx(1 / np.sqrt(1e6 * 0.9215), rel=0.05)
    assert not check.passed
    plan_only.catches(check.p_value)


def copied(directions, n, seed=0):
    """The directions with n photons replaced by copies of others."""
    rng = np.random.default_rng([seed, 2])
    spoilt = directions.copy()
    spoilt[rng.choice(len(directions), n, replace=False)] = directions[rng.choice(len(directions), n, replace=False)]
    return spoilt


@pytest.mark.parametrize(
    ("method", "dependence"), [("iid", Dependence.INDEPENDENT), ("stratified", Dependence.STRATIFIED)]
)
def test_copies_of_photons(plan_only, method, dependence):
    """Twelve copies among 200 000 photons; correct ones have no equal pair."""
    source = scene_of("clear_day", 200_000).source(3, method=method)
    directions = directions_of(source)
    correct = named(direction_report(source, dependence, directions), "photons that repeat")
    assert correct.p_value > 0.01
    spoilt = named(direction_report(source, dependence, copied(directions, 12)), "photons that repeat")
    assert not spoilt.passed
    plan_only.catches(spoilt.p_value)


def test_random_numbers_of_15_bits_repeat(plan_only):
    """A C library's rand() with RAND_MAX 32767 gives 2^30 directions; two numbers of 24 bits are enough."""
    uniform = scene(sky.UniformSky(), 10).source()
    rng = np.random.default_rng(8)
    for bits in (15, 24):
        u, v = rng.integers(1 << bits, size=(2, 200_000)) / (1 << bits)
        sine, azimuth = np.sqrt(u), 2 * np.pi * v
        rows = -np.column_stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - u)])
        check = named(direction_report(uniform, Dependence.INDEPENDENT, rows.astype(np.float32)), "photons that repeat")
        if bits == 15:
            assert not check.passed
            plan_only.catches(check.p_value)
        else:
            assert check.p_value > 0.01


def test_thinning_is_fair(plan):
    kept = is_kept(thinning_key(11), 0, 1_000_000)
    plan.check(chi2.binomial_p(int(kept.sum()), kept.size, 0.5))
    plan.check(chi2.binomial_p(int((kept[1:] ^ kept[:-1]).sum()), kept.size - 1, 0.5))
    plan.catches(chi2.binomial_p(int(kept[: kept.size // 2].sum() * 2 * 1.01), kept.size, 0.5))


@pytest.mark.parametrize(
    ("method", "dependence"),
    [
        ("stratified", Dependence.PLAN),
        ("iid", Dependence.INDEPENDENT),
        pytest.param("stratified", Dependence.STRATIFIED, marks=pytest.mark.slow),
    ],
)
def test_one_percent_uniform_in_zenith_angle(plan_only, method, dependence):
    """At 2e6 photons: in our own stratified run, in an independent file of another code, and without the plan."""
    source, directions = many(method)
    report = direction_report(source, dependence, uniform_in_zenith_angle(directions, 0.01))
    assert not report
    if dependence is not Dependence.STRATIFIED:
        assert not named(report, "mu^2:").passed
        plan_only.catches(named(report, "share uniform").p_value)


def turned(directions, degrees):
    angle = np.deg2rad(degrees)
    turn = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return (directions @ turn).astype(directions.dtype)


def shuffled_azimuths(directions, seed=0):
    """Zenith angles and azimuths of different photons put together: both margins stay as they are."""
    rng = np.random.default_rng(seed)
    sine = np.hypot(directions[:, 0], directions[:, 1])
    other = rng.permutation(len(directions))
    unit = directions[other, :2] / sine[other, None]
    return np.column_stack([sine[:, None] * unit, directions[:, 2]]).astype(directions.dtype)


DEFECTS = {
    "azimuth from another axis": (lambda d: turned(d, 20.0), ("azimuth:", "mu^2 x azimuth:")),
    "azimuth without the half turn": (lambda d: turned(d, 180.0), ("azimuth:", "mu^2 x azimuth:")),
    "azimuth and zenith angle independent": (shuffled_azimuths, ("mu^2 x azimuth:",)),
    "cosine for its square": (lambda d: uniform_in_zenith_angle(d, 0.15), ("mu^2:", "mu^2 x azimuth:")),
}


@pytest.mark.parametrize("name", DEFECTS)
@pytest.mark.parametrize("dependence", [Dependence.PLAN, Dependence.INDEPENDENT, Dependence.STRATIFIED])
def test_defects_of_zones(plan_only, name, dependence):
    spoil, tests = DEFECTS[name]
    source = scene_of("clear_day", 100_000).source(2, method="iid" if dependence is Dependence.INDEPENDENT else None)
    report = direction_report(source, dependence, spoil(directions_of(source)))
    for beginning in tests:
        check = named(report, beginning)
        if dependence is Dependence.PLAN:
            assert check.found > 10 * check.allowed
        else:
            plan_only.catches(check.p_value)


def edge_off_by_a_tenth(grid, directions, coordinate):
    """Photons of the last tenth of each patch moved into the first one: inside their patch, off by one digit."""
    zenith, azimuth = (np.rad2deg(x) for x in sky.directions.sky_from_travel(directions))
    value, width = (zenith, 90.0 / grid.n_zenith) if coordinate == "mu^2" else (azimuth, 360.0 / grid.n_azimuth)
    step = np.floor(value / width)
    share = value / width - step
    moved = width * (step + np.where(share > 0.95, share - 0.95, share))
    zenith, azimuth = (moved, azimuth) if coordinate == "mu^2" else (zenith, moved)
    return sky.directions.travel_from_sky(zenith, azimuth)


@pytest.mark.parametrize("coordinate", ["mu^2", "azimuth"])
@pytest.mark.parametrize(("dependence", "method"), [(Dependence.PLAN, None), (Dependence.INDEPENDENT, "iid")])
def test_defects_inside_patches(plan_only, coordinate, dependence, method):
    source = scene_of("clear_day", 60_000).source(2, method=method)
    report = direction_report(source, dependence, edge_off_by_a_tenth(source.grid, directions_of(source), coordinate))
    for kind in ("chi", "Kolm"):
        plan_only.catches(named(report, f"inside patches, {coordinate}: {kind}").p_value)


def test_defects_inside_perez_patches(plan_only):
    """Places taken as uniform where the luminance of Perez is asked for: coarse patches show it."""
    grid = sky.PatchGrid.regular(4, 12)
    model = {"sun_zenith_rad": 0.9, "epsilon": 6.0, "delta": 0.1, "grid": grid}
    skies = (sky.PerezSky(within=within, **model) for within in ("exact", "uniform"))
    exact, uniform = (scene(one, 100_000).source(1, method="iid") for one in skies)
    assert direction_report(exact, Dependence.INDEPENDENT)
    report = direction_report(exact, Dependence.INDEPENDENT, directions_of(uniform))
    plan_only.catches(named(report, "inside patches, mu^2: chi").p_value)
    assert direction_report(exact, Dependence.PLAN)
    assert not direction_report(exact, Dependence.PLAN, directions_of(uniform))


CONFIGURATIONS = [
    ("clear_day", None, Dependence.PLAN),
    ("clear_day", "iid", Dependence.PLAN),
    ("clear_day", "iid", Dependence.INDEPENDENT),
    ("clear_day", None, Dependence.STRATIFIED),
    ("perez_sky", None, Dependence.PLAN),
    ("perez_sky", "iid", Dependence.INDEPENDENT),
    ("sparse_sky", "iid", Dependence.INDEPENDENT),
    ("sparse_sky", None, Dependence.PLAN),
    ("night_sky", None, Dependence.PLAN),
    ("night_sky", "iid", Dependence.INDEPENDENT),
    ("night_sky", None, Dependence.STRATIFIED),
    ("atmosphere_sky", "iid", Dependence.INDEPENDENT),
    ("perez_sky", None, Dependence.STRATIFIED),
    ("clear_day", None, Dependence.MIXED),
    ("clear_day", "iid", Dependence.MIXED),
]


SEEDS_OF = [(*one, range(1)) for one in CONFIGURATIONS[:6]]
SEEDS_OF += [pytest.param(*one, range(100, 150), marks=pytest.mark.slow) for one in CONFIGURATIONS]


@pytest.mark.parametrize(("name", "method", "dependence", "seeds"), SEEDS_OF)
def test_correct_photons_pass(name, method, dependence, seeds):
    """None of the seeds fails at the family level."""
    for seed in seeds:
        report = direction_report(scene_of(name, 20_000).source(seed, method=method), dependence, seed=seed)
        assert report, (seed, [check for check in report.checks if not check.passed])


@pytest.mark.slow
def test_power_of_one_percent_over_seeds(plan_only):
    """The same for ten choices of the photons that are spoilt: caught always in our runs, nearly always in theirs."""
    for method, dependence, most in (("stratified", Dependence.PLAN, 0), ("iid", Dependence.INDEPENDENT, 1)):
        source, directions = many(method)
        passed = [direction_report(source, dependence, uniform_in_zenith_angle(directions, 0.01, s)) for s in range(10)]
        assert sum(map(bool, passed)) <= most


@pytest.mark.slow
def test_one_percent_in_stratified_photons_of_unknown_plan():
    source, directions = many("stratified")
    spoilt = uniform_in_zenith_angle(directions, 0.01)
    assert not direction_report(source, Dependence.STRATIFIED, spoilt)
    assert direction_report(source, Dependence.STRATIFIED, directions)
