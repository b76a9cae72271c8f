"""PerezSky: what it takes, what it tells, and that its radiance and its masses are the same sky."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.function_sky import FunctionSky
from aomc_sky.skies.model import SkyModel, sky_model
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.sky import PerezSky

limits_are_no_matter = pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
CLEAR = {"sun_zenith_rad": 0.8, "sun_azimuth_rad": 2.0, "dni": 700.0, "dhi": 90.0}
HAND = (1.0, -1.0, 2.0, -2.0, 0.1)


def flux(sky, n=300):
    """Integral of the radiance times cos xi over the hemisphere, by points that ignore the sun."""
    x, w = np.polynomial.legendre.leggauss(n)
    mu, w = (x + 1) / 2, w / 2
    azimuth = (np.arange(4 * n) + 0.5) * 2 * np.pi / (4 * n)
    value = sky.radiance(np.arccos(mu)[:, None], azimuth, 500.0)
    return float(2 * np.pi * np.sum(value.mean(axis=1) * mu * w))


def test_the_three_inputs_are_one_sky():
    sky = PerezSky(**CLEAR)
    assert isinstance(sky, SkyModel)
    assert sky_model("perez") is PerezSky
    assert flux(sky) == pytest.approx(90, rel=1e-6)
    assert sky.clearness == pytest.approx(float(perez.sky_clearness(700, 90, 0.8)))
    assert sky.brightness == pytest.approx(float(perez.sky_brightness(90, 0.8)))
    np.testing.assert_array_equal(sky.model_coefficients, perez.coefficients(sky.clearness, sky.brightness, 0.8))
    integral = float(perez.horizontal_integral(sky.model_coefficients, 0.8))
    assert sky.relative_integral == pytest.approx(integral, rel=1e-11)
    by_weather = PerezSky(**CLEAR)
    sun = {"sun_zenith_rad": 0.8, "sun_azimuth_rad": 2.0}
    by_sky = PerezSky(**sun, epsilon=by_weather.clearness, delta=by_weather.brightness)
    by_hand = PerezSky(**sun, coefficients=by_sky.model_coefficients)
    for other in (by_sky, by_hand):
        np.testing.assert_array_equal(other.lower([500.0])[0].mass, by_weather.lower([500.0])[0].mass)
    assert (by_hand.clearness, by_hand.brightness) == (None, None)
    relative = by_sky.radiance(0.3, 0.1, 500.0)
    assert by_weather.radiance(0.3, 0.1, 500.0) == pytest.approx(float(relative) * 90 / by_sky.relative_integral)
    one, other = (PerezSky(sun_zenith_rad=0.5, coefficients=given) for given in (np.array(HAND), list(HAND)))
    assert one == other
    assert hash(one) == hash(other)


def test_masses_are_the_integrated_radiance():
    sky = PerezSky(**CLEAR)
    mass = sky.patch_mass(PatchGrid.regular(9, 12))
    assert mass.sum() == pytest.approx(1, rel=1e-13)
    (rough,) = FunctionSky(sky.radiance, grid=PatchGrid.regular(180, 240)).lower([500.0])
    share = rough.mass[0].reshape(9, 20, 12, 20).sum(axis=(1, 3)).ravel() / rough.mass.sum()
    np.testing.assert_allclose(mass, share, rtol=2e-5)
    part = PatchGrid(zenith_bounds_deg=np.array([[0.0, 45.0]]), azimuth_bounds_deg=np.array([[0.0, 360.0]]))
    assert sky.patch_mass(part)[0] == pytest.approx(sky.patch_mass(PatchGrid.regular(2, 1))[0], rel=1e-11)
    with pytest.raises(SceneError, match="points or lines"):
        PerezSky(**CLEAR).patch_mass(PatchGrid.lattice(5, 8))


def test_no_diffuse_light():
    with pytest.warns(ModelLimitWarning, match="no diffuse part"):
        sky = PerezSky(sun_zenith_rad=0.5, dni=800.0, dhi=0.0)
    assert sky.is_dark
    assert sky.lower([500.0]) == ()
    np.testing.assert_array_equal(sky.radiance([0.1, 0.2], 0.0, 500.0), [0, 0])
    with pytest.raises(SceneError, match="no diffuse part"):
        sky.patch_mass(PatchGrid.regular(2, 2))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"epsilon": 0.9, "delta": 0.2}, "counts as 1"),
        ({"epsilon": 8.0, "delta": 0.5, "sun_zenith_rad": 1.5}, "b = 0."),
        ({"epsilon": 1.7, "delta": 0.6, "sun_zenith_rad": 0.0}, "negative over"),
        ({"epsilon": 1.1, "delta": 0.05, "sun_zenith_rad": 1.0, "limits": "paper"}, "negative over"),
        ({"coefficients": [0.1, 0.5, 1.0, -1.0, 0.0]}, "b = 0.5"),
        ({"ghi": 0.78, "dhi": 0.14}, "irradiances are in W m-2: write 780 for 0.78 kW m-2"),
    ],
)
def test_what_was_limited_is_told(arguments, words):
    arguments = {"sun_zenith_rad": 0.7, **arguments}
    with pytest.warns(ModelLimitWarning) as told:
        sky = PerezSky(**arguments)
    assert any(words in str(one.message) for one in told)
    assert sky.model_coefficients[1] <= 0
    field = sky.radiance(np.linspace(0, np.pi / 2, 50)[:, None], np.linspace(0, 6, 50), 500.0)
    assert field.min() >= 0
    assert field.max() > 0
    assert sky.patch_mass(PatchGrid.regular(9, 12)).min() >= 0
    for strict in (arguments, {"sun_zenith_rad": 0.5, "dni": 800.0, "dhi": 0.0}):
        with pytest.raises(SceneError, match="strict"):
            PerezSky(**strict, strict=True)


@limits_are_no_matter
@pytest.mark.parametrize("coefficients", [(-2, 0, 0, 0, 0), (0, 0, -5, 0, 0), (-1, 1, 0, 0, 0)])
def test_a_sky_without_light_is_an_error(coefficients):
    with pytest.raises(SceneError, match="nowhere positive"):
        PerezSky(sun_zenith_rad=0.3, coefficients=coefficients)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({}, UsageError, "exactly one"),
        ({"epsilon": 1.0, "delta": 0.2, "dni": 1.0, "dhi": 1.0}, UsageError, "exactly one"),
        ({"coefficients": np.ones(5), "dhi": 100.0}, UsageError, "not several"),
        ({"coefficients": np.ones(4)}, SceneError, "five numbers"),
        ({"coefficients": [1, -1, np.nan, 0, 0]}, SceneError, "finite"),
        ({"coefficients": [1, -1, 1, 400.0, 0]}, SceneError, "finite"),
        ({"coefficients": [0, 0, 1, -200.1, 0]}, SceneError, "d must be -200 or more"),
        ({"epsilon": 1.0, "delta": 10.0, "limits": "paper"}, SceneError, "d must be -200 or more"),
        ({"epsilon": np.nan, "delta": 0.2}, SceneError, "epsilon"),
        ({"dni": 1e9, "dhi": 100.0}, SceneError, "dni must be -5 to 10000 W m-2, got 1000000000.0"),
        ({"ghi": 780, "dhi": "140"}, SceneError, "dhi must be -5 to 10000 W m-2, got '140'"),
        ({"epsilon": 1.0, "delta": 0.2, "sun_zenith_rad": np.pi / 2}, SceneError, "horizon"),
        ({"epsilon": 1.0, "delta": 0.2, "sun_azimuth_rad": np.inf}, SceneError, "azimuth"),
    ],
)
def test_what_is_refused(arguments, error, words):
    with pytest.raises(error, match=words):
        PerezSky(**{"sun_zenith_rad": 0.3, **arguments})


def test_a_scene_without_the_beam_that_its_sky_knows_says_what_is_missing():
    from aomc_sky import DirectBeam, Scene

    def notes(*components):
        return Scene(wavebands=[550.0], n_photons=9, components=list(components)).notes

    weather = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 120.0, "ghi": 780.0, "dhi": 140.0}
    (note,) = notes(PerezSky(**weather))
    assert "strength=0.1795" in note
    assert "sky.DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=120, strength=0.8205)" in note
    for radius in (0.0, 0.2665):
        beam = DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=120, strength=0.8205, radius_deg=radius)
        assert notes(PerezSky(**weather, strength=0.1795), beam) == ()
        assert notes(PerezSky(**weather, strength=0.1795), *beam.lower([550.0])) == ()
    assert notes(PerezSky(sun_zenith_deg=40, dni=0, dhi=140)) == ()
    (note,) = notes(PerezSky(sun_zenith_deg=40, epsilon=3.0, delta=0.2))  # 2 (1 + 1.041 Z^3) parts of dni to one of dhi
    share = 2 * (1 + 1.041 * np.deg2rad(40) ** 3) * np.cos(np.deg2rad(40))
    assert f"add sky.DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=0, strength={share / (1 + share):.4g})" in note


GRID = PatchGrid.regular(3, 4)

zeniths = st.one_of(st.floats(0, np.nextafter(np.pi / 2, 0)), st.sampled_from([0.0, 5e-324, 1e-9, 1.5707963]))
limits = st.sampled_from(["radiance", "paper"])
directions = st.tuples(st.floats(0, np.pi / 2), st.floats(-10, 10))


def checked(arguments, direction):
    """A sky keeps its promises, or the error says that nothing shines or which number is too large."""
    try:
        sky = PerezSky(**arguments)
    except SceneError as error:
        words = str(error)
        assert any(part in words for part in ("nowhere positive", "overflows", "finite", "more than any sky")), words
        return
    value = sky.radiance(*direction, 500.0)
    assert np.isfinite(value)
    assert value >= 0
    if sky.is_dark:
        assert sky.lower([500.0]) == ()
        return
    mass = sky.patch_mass(GRID)
    assert np.all(np.isfinite(mass))
    assert mass.min() >= 0
    assert abs(mass.sum() - 1) < 1e-12
    assert sky.relative_integral > 0


@limits_are_no_matter
@given(zeniths, st.floats(-7, 7), st.floats(0, 1e9), st.floats(0, 2), limits, directions)
def test_any_clearness_and_brightness(zenith, azimuth, epsilon, delta, limit, direction):
    arguments = {"epsilon": epsilon, "delta": delta, "limits": limit}
    checked({"sun_zenith_rad": zenith, "sun_azimuth_rad": azimuth, **arguments}, direction)


@limits_are_no_matter
@given(zeniths, st.floats(0, 1500), st.floats(0, 1500), limits, directions)
def test_any_irradiances(zenith, dni, dhi, limit, direction):
    checked({"sun_zenith_rad": zenith, "dni": dni, "dhi": dhi, "limits": limit}, direction)


@limits_are_no_matter
@given(zeniths, st.tuples(*[st.floats(-50, 50)] * 5), directions)
def test_any_coefficients(zenith, values, direction):
    checked({"sun_zenith_rad": zenith, "coefficients": values}, direction)


@given(st.floats(0, np.pi / 2), st.floats(0, np.pi / 2), st.floats(-10, 10), st.floats(1, 1e6), st.floats(0, 5))
def test_functions_give_numbers(zenith, xi, phi, epsilon, delta):
    values = perez.coefficients(epsilon, delta, zenith, limits="paper")
    assert np.all(np.isfinite(values))
    assert not np.isnan(perez.relative_radiance(xi, phi, zenith, values))
    values[1] = min(values[1], 0)
    assert np.isfinite(perez.relative_radiance(xi, phi, zenith, values))
    assert np.isfinite(perez.horizontal_integral(values, zenith))
