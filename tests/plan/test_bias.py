"""Photons shared out otherwise than light: launch = mass x bias, weight = 1 / bias, and the light stays exact."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.errors import InputFileError
from aomc_sky.plan.plan import npz_bytes, read_npz, sha256_of

SUN = {"sun_zenith_deg": 40.0, "dni": 850.0, "dhi": 95.0}
BIAS = {"direct": 0.2}


def weather(n=100_000, **how):
    return sky.weather_scene(wavebands=[440.0, 550.0], n_photons=n, **SUN | how)


def towards_horizon(zenith, azimuth):
    return 1.0 + 9.0 * np.sin(zenith) ** 2 + 0.0 * azimuth


CASES = {
    "component": {"bias": BIAS},
    "all components": {"bias": {"direct": 0.25, "perez": 0.75}},
    "importance": {"importance": {"perez": towards_horizon}},
    "table": {"importance": {"perez": np.linspace(1.0, 4.0, 45)[:, None]}},
    "both": {"bias": BIAS, "importance": {"perez": towards_horizon}},
}


@pytest.mark.parametrize("case", CASES)
def test_launch_is_mass_times_bias_and_light_is_exact(case):
    scene = weather()
    plain, source = scene.source(1), scene.source(1, **CASES[case])
    assert source.plan.sha256 != plain.plan.sha256
    for band in range(2):
        mass, launch, weights = source.mass(band), source.launch(band), source.weights(band)
        np.testing.assert_array_equal(mass, plain.mass(band))
        assert source.exact_moments(band) == plain.exact_moments(band)
        assert math.fsum(launch) == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(launch * weights, mass, rtol=4e-16)
        np.testing.assert_array_equal(source.expected(band), 1e5 * launch)
        assert source.counts[band].sum() == 100_000
        assert np.abs(source.counts[band] - source.expected(band)).max() < 1.0
        batch = source.photons(band)
        np.testing.assert_array_equal(batch.weight, weights.astype(np.float32)[batch.patch])
        share = np.bincount(source.component_of(batch.patch), minlength=2) / 1e5
        shares = CASES[case].get("bias", {"direct": mass[0]})
        assert share[0] == pytest.approx(shares["direct"], abs=2e-5)
    same = scene.source(1)
    assert same.plan.sha256 == plain.plan.sha256
    assert same.photons().weight is None


@settings(max_examples=60, deadline=None)
@given(
    n=st.integers(1, 3000),
    share=st.floats(0.01, 0.99),
    scale=st.floats(1e-3, 1e3),
    seed=st.integers(0, 2**32),
)
def test_the_mean_weight_of_a_run_is_bounded(n, share, scale, seed):
    """|mean w - 1| <= (1 / N) sum |w_k - w_(k+1)|, for systematic allocation in the order of the cells."""
    grid = sky.PatchGrid.regular(1, 12)  # one ring keeps the order of its cells
    table = sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=np.arange(1.0, 13.0).reshape(1, 1, 12))
    beam = sky.DirectBeam(sun_zenith_deg=30.0, strength=1.0)
    scene = sky.Scene(wavebands=[550.0], n_photons=n, components=[*beam.lower([550.0]), *named(table, 2.0)])
    importance = {"tabulated": 1.0 + (scale - 1.0) * np.arange(12.0)[None] / 11.0}
    source = scene.source(seed, bias={"direct": share}, importance=importance)
    counts, weight = source.counts[0], source.weights(0)
    bound = np.abs(np.diff(weight)).sum() / n
    assert abs(float(counts @ weight) / n - 1.0) <= bound * (1 + 1e-12) + 1e-12


def named(model, strength):
    import dataclasses

    return [dataclasses.replace(c, name="tabulated", strength=np.array([strength])) for c in model.lower([550.0])]


@pytest.mark.parametrize("allocation", ["systematic", "multinomial"])
def test_light_of_every_cell_is_right_on_average_where_most_runs_have_no_photon(allocation):
    """E[n_k] w_k = N p_k: a pooled z over cells that expect 0.05 photons, and the planted unweighted one."""
    n, seeds = 50, range(600)
    scene = weather(n, grid=sky.PatchGrid.regular(6, 24))
    sources = [scene.source(seed, bias={"direct": 0.9}, allocation=allocation) for seed in seeds]
    counts = np.array([source.counts[0] for source in sources])
    weight, light = sources[0].weights(0), n * sources[0].mass(0)
    expected = sources[0].expected(0)
    rare = np.flatnonzero((expected > 0.02) & (expected < 0.2))
    assert rare.size > 80
    assert np.mean(counts[:, rare] == 0) > 0.8
    error = counts[:, rare].std(axis=0, ddof=1) / np.sqrt(len(counts))
    of_light = (counts[:, rare].mean(axis=0) * weight[rare] - light[rare]) / (error * weight[rare])
    assert abs(of_light.sum()) / np.sqrt(rare.size) < 5.5
    assert np.abs(of_light).max() < 6.5
    planted = (counts[:, rare].mean(axis=0) - light[rare]) / error  # mass in the place of launch
    assert abs(planted.sum()) / np.sqrt(rare.size) > 8


def test_tallies_of_the_light_do_not_change():
    """Every tally by weights is that of the light: cosines of the sky and of all, within the scatter of replicates."""
    scene = weather(200_000)
    plain, biased = (scene.source(3, precision="float64", **how) for how in ({}, {"bias": {"direct": 0.1}}))
    for tally in (lambda b: -b.uz, lambda b: (-b.uz > 0.5) * 1.0, lambda b: np.sqrt(-b.uz)):
        sums = []
        for source in (plain, biased):
            batch = source.photons()
            weight = 1.0 if batch.weight is None else batch.weight
            sums.append(float(np.mean(weight * tally(batch))))
        assert sums[0] == pytest.approx(sums[1], abs=2e-4)


REFUSED = {
    "bias: there is no component 'sun'; the components are direct, perez": {"bias": {"sun": 0.2}},
    "the share of 'direct' is 0; write more than 0": {"bias": {"direct": 0.0}},
    "the share of 'direct' is nan": {"bias": {"direct": math.nan}},
    "leave no photon to 'perez'; write smaller shares": {"bias": {"direct": 1.0}},
    "sum to 1.1; write shares that sum to 1": {"bias": {"direct": 0.5, "perez": 0.6}},
    "allocation 'largest-remainder' makes the light wrong": {"bias": BIAS, "allocation": "largest-remainder"},
    "importance: 'direct' has no patches; write bias=": {"importance": {"direct": 1.0}},
    "importance: there is no component 'sky'": {"importance": {"sky": 1.0}},
    "not positive and finite": {"importance": {"perez": np.zeros((45, 180))}},
    "has the shape .7,.; give .45, 180.": {"importance": {"perez": np.ones(7)}},
    "weights from 8.73e.07 to 8.73e.07; 1e-30 to 1e.06": {"bias": {"direct": 1e-8}},
    "1e-30 to 1e.06 are allowed": {"importance": {"perez": np.geomspace(1e-38, 1.0, 45)[:, None]}},
    "bias is a mapping": {"bias": 0.2},
    "importance is a mapping": {"importance": 0.2},
    "the share of 'direct' is no number": {"bias": {"direct": "much"}},
}


@pytest.mark.parametrize("words", REFUSED)
def test_refusals(words):
    with pytest.raises(sky.UsageError, match=words):
        weather().source(1, **REFUSED[words])


def test_a_bias_goes_not_with_weights_of_solid_angle():
    grid = sky.PatchGrid.regular(3, 4)
    values, how = np.ones((1, 3, 4)), {"weighting": sky.Weighting.SOLID_ANGLE}
    table = sky.TabulatedSky(grid=grid, wavelength_nm=[550.0], values=values, **how)
    scene = sky.Scene(wavebands=[550.0], n_photons=100, components=table)
    assert scene.source(weights=True).has_weights
    name = scene.components[0].name
    with pytest.raises(sky.UsageError, match="leave one of them out"):
        scene.source(weights=True, importance={name: 1.0})


def test_a_component_that_is_dark_in_a_band_has_no_photons_there(tmp_path):
    components = [
        *sky.DirectBeam(sun_zenith_deg=30.0, strength=[0.0, 1.0]).lower([440.0, 550.0]),
        *sky.UniformSky(strength=[1.0, 1.0]).lower([440.0, 550.0]),
    ]
    scene = sky.Scene(wavebands=[440.0, 550.0], n_photons=1000, components=components)
    for bias in ({"direct": 0.2}, {"direct": 0.2, "uniform": 0.8}):
        counts = scene.source(bias=bias).counts
        assert counts[0, 0] == 0
        assert counts[1, 0] == 200
        assert counts.sum(axis=1).tolist() == [1000, 1000]


def test_a_stored_plan_keeps_its_bias_and_refuses_a_damaged_one(tmp_path):
    plan = weather().source(1, **CASES["both"]).plan
    plan.save(tmp_path / "plan.npz")
    again = sky.Plan.load(tmp_path / "plan.npz")
    assert again == plan
    one, other = (sky.PhotonSource(each).photons(1) for each in (again, plan))
    for name in ("ux", "uy", "uz", "patch", "weight"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    members, options = read_npz(tmp_path / "plan.npz")
    others = {name: value for name, value in options.items() if name not in ("bias", "importance")}
    rest = {name: array for name, array in members.items() if name != "bias"}
    damaged = {
        "mass times bias sums to 1": (members | {"bias": members["bias"] * 1.001}, options),
        "factors from 1e-06 to 1e.30": (members | {"bias": -members["bias"]}, options),
        "bias: found float64 of shape": (members | {"bias": members["bias"][:, :-1]}, options),
        "array and the option bias go": (rest, options),
        "the array and the option bias go": (members, others),
        "shares of components": (members, options | {"bias": {"moon": 0.2}}),
        "and components with an importance": (members, options | {"importance": "perez"}),
        "a bias needs systematic": (members, options | {"allocation": "largest-remainder"}),
    }
    for words, (arrays, chosen) in damaged.items():
        (tmp_path / "bad.npz").write_bytes(npz_bytes(arrays, chosen, sha256_of(arrays, chosen)))
        with pytest.raises(InputFileError, match=words):
            sky.Plan.load(tmp_path / "bad.npz")


def test_a_scene_has_a_bias_of_its_own_that_a_caller_can_lay_off():
    scene = sky.Scene(
        wavebands=[550.0],
        n_photons=1000,
        components=[sky.DirectBeam(sun_zenith_deg=30.0, strength=1.0), sky.UniformSky(strength=1.0)],
        bias={"direct": 0.1},
    )
    assert scene.source().counts[0, 0] == 100
    assert scene.source(bias={"direct": 0.3}).counts[0, 0] == 300
    assert scene.source(bias={}).photons().weight is None


def test_effective_photons_are_those_of_the_weights():
    source = weather().source(1, bias={"direct": 0.2})
    weight = source.photons(0).weight.astype(np.float64)
    expected = weight.sum() ** 2 / (weight**2).sum()
    assert source.effective_photons(0) == pytest.approx(expected, rel=1e-6)
    assert weather().source(1).effective_photons(0) == 100_000.0


def test_shares_are_numbers_of_any_library():
    expected = weather().source(1, bias={"direct": 0.25}).plan
    for share in (np.float64(0.25), np.float32(0.25), Fraction(1, 4)):
        assert weather().source(1, bias={"direct": share}).plan == expected
