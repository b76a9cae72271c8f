"""The pattern of light scattered once, against dipoles as vectors in space; and the means of patches."""

import dataclasses
from functools import partial

import numpy as np
import pytest
from scipy.integrate import dblquad

import aomc_sky as sky
from tests.support.shared import INPUTS
from tests.support.stokes import DEFECTS, frame_of, scattered_once, travel_of

SUNS = [(0.0, 0.0), (0.3, 0.0), (0.9, 2.0), (1.5, -1.0), (np.pi / 2, 4.0)]
FULL = sky.RayleighPattern(max_degree=1.0)
MOLECULES = INPUTS / "atmosphere" / "molecules_only.atmo"


def directions(n=4000):
    rng = np.random.default_rng(8)
    return np.arccos(rng.uniform(0, 1, n)), rng.uniform(0, 2 * np.pi, n)


def pattern(zenith, azimuth, sun, model=FULL):
    return np.stack(model.stokes(zenith, azimuth, sun_zenith_rad=sun[0], sun_azimuth_rad=sun[1]))


@pytest.mark.parametrize("sun", SUNS)
def test_the_pattern_is_that_of_dipoles(sun):
    zenith, azimuth = directions()
    expected = np.stack(scattered_once(travel_of(zenith, azimuth), sun))
    np.testing.assert_allclose(pattern(zenith, azimuth, sun), expected, atol=2e-14)
    less = pattern(zenith, azimuth, sun, sky.RayleighPattern(max_degree=0.6))
    np.testing.assert_allclose(less, 0.6 * expected, atol=2e-14)


@pytest.mark.parametrize("sun", SUNS[1:])
def test_planted_defects_are_far_from_dipoles(sun):
    zenith, azimuth = directions()
    expected = np.stack(scattered_once(travel_of(zenith, azimuth), sun))
    defects = [np.stack(defect(*pattern(zenith, azimuth, sun))) for defect in DEFECTS.values()]
    for wrong in (*defects, pattern(zenith, 2 * sun[1] - azimuth, sun)):
        assert np.abs(wrong - expected).max() > 0.5


def test_degree_and_edges():
    """Nothing is NaN or above the largest degree at zenith, horizon, sun and the point opposite it."""
    zenith = np.array([0.0, 5e-324, 1e-200, 1e-9, 0.7, np.pi / 2 - 1e-16, np.pi / 2])
    azimuth = np.array([0.0, 1.1, np.pi, -np.pi, 1e9])
    for sun in [*SUNS, (0.7, 1.1), (np.pi / 2, 0.0)]:
        q, u = pattern(*np.meshgrid(zenith, azimuth), sun, sky.RayleighPattern())
        assert np.hypot(q, u).max() <= 0.75 * (1 + 4e-16)  # no NaN either
    assert np.abs(pattern(0.7, 1.1, (0.7, 1.1))).max() < 1e-30
    assert np.abs(pattern(np.pi / 2, np.pi, (np.pi / 2, 0.0))).max() < 1e-15
    np.testing.assert_allclose(pattern(0.7 + 1e-6, 1.1, (0.7, 1.1)), [-0.5e-12, 0.0], rtol=1e-8, atol=1e-25)
    with pytest.raises(sky.UsageError, match="RayleighPattern"):
        sky.PerezSky(sun_zenith_deg=40.0, epsilon=6.0, delta=0.1, polarisation="rayleigh").lower([550.0])


@pytest.mark.parametrize("degree", [-0.1, 1.1, np.nan])
def test_degrees_that_are_none_are_refused(degree):
    with pytest.raises(sky.SceneError, match="max_degree"):
        sky.RayleighPattern(max_degree=degree)


POINTS = [one.ravel() for one in np.meshgrid(np.linspace(0, 89.9, 10), np.arange(0.0, 360.0, 15.0))]


MODELS = {
    "perez": partial(sky.PerezSky, epsilon=6.0, delta=0.1),
    "perez, uniform": partial(sky.PerezSky, epsilon=6.0, delta=0.1, within="uniform"),
    "cie": partial(sky.CIESky, type=12),
    "harrison-coombes": sky.HarrisonCoombesSky,
    "under clouds": partial(sky.HarrisonCoombesSky, cloud_cover=0.5),
    "measured": partial(sky.RadianceField.from_points, *POINTS, 1 + np.cos(np.deg2rad(POINTS[0])), 550.0),
}


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow if one == "under clouds" else ()) for one in MODELS]
)
def test_photons_of_every_sky_with_a_sun_have_its_pattern(name, monkeypatch):
    """The flux-weighted mean of a million photons, and the patch of each, against the pattern in its direction."""
    coarse = partial(sky.FunctionSky, grid=sky.PatchGrid.regular(45, 90))
    monkeypatch.setattr("aomc_sky.skies.harrison_coombes.FunctionSky", coarse)  # patches of one degree take seconds
    model = MODELS[name](sun_zenith_deg=40.0, sun_azimuth_deg=25.0, polarisation=sky.RayleighPattern())
    source = sky.Scene(wavebands=[550.0], n_photons=200_000, components=model).source(seed=4)
    batch = source.photons()
    assert batch.q.dtype == batch.u.dtype == np.float32
    zenith, azimuth = np.arccos(-batch.uz.astype(float)), np.arctan2(-batch.uy.astype(float), -batch.ux.astype(float))
    expected = pattern(zenith, azimuth, (np.deg2rad(40), np.deg2rad(25)), sky.RayleighPattern())
    wrong = np.stack([batch.q, batch.u]) - expected
    away = np.sin(zenith) > np.sin(np.deg2rad(4))  # at the zenith a patch has all azimuths
    assert np.abs(wrong[:, away]).max() < (0.04 if source.grid.n_zenith < 90 else 0.02)
    assert np.abs(wrong.mean(axis=1)).max() < 5 * expected.std() / np.sqrt(len(batch))
    np.testing.assert_array_equal(np.stack([batch.q, batch.u]), source.stokes()[batch.patch].T.astype(np.float32))


def test_the_mean_of_a_patch_is_weighted_by_flux():
    grid = sky.PatchGrid(zenith_bounds_deg=[[30, 50]], azimuth_bounds_deg=[[10, 40]])
    model = sky.PerezSky(sun_zenith_deg=70.0, epsilon=6.0, delta=0.1, grid=grid, polarisation=FULL)
    (component,) = model.lower([550.0])
    sun, box = (np.deg2rad(70.0), 0.0), np.deg2rad([10, 40, 30, 50])

    def mean(weight):
        flux = dblquad(weight, *box)[0]
        return [dblquad(lambda z, a, k=k: weight(z, a) * pattern(z, a, sun)[k], *box)[0] / flux for k in (0, 1)]

    by_flux = mean(lambda z, a: float(model.radiance(z, a, 550.0)) * np.sin(2 * z))
    by_area = mean(lambda z, a: np.sin(z))
    np.testing.assert_allclose(component.stokes[0, 0], by_flux, atol=2e-6)
    assert np.abs(np.subtract(by_flux, by_area)).max() > 1e-3


def test_rows_of_wavelengths():
    """A sky of one row keeps one; a measured sky of two has a row for each."""
    values = [np.ones(POINTS[0].size), 2 + np.cos(np.deg2rad(POINTS[1]))]
    sun = {"sun_zenith_deg": 50.0, "sun_azimuth_deg": 0.0, "polarisation": FULL, "grid": sky.PatchGrid.regular(4, 4)}
    field = sky.RadianceField.from_points(*POINTS, values, [450.0, 550.0], **sun)
    assert field.lower([450.0, 550.0, 500.0])[0].stokes.shape == (3, 16, 2)
    assert sky.CIESky(type=3, sun_zenith_deg=50.0, polarisation=FULL).lower([450.0, 550.0])[0].stokes.shape[0] == 1
    source = sky.Scene(wavebands=[450.0, 550.0], n_photons=[100, 0], components=field).source()
    assert np.abs(source.stokes(0) - source.stokes(1)).max() > 1e-3
    with pytest.raises(sky.SceneError, match="where the sun is"):
        dataclasses.replace(field, sun=None)


def test_rotation_to_the_scattering_plane():
    """By the formulas of docs/conventions.md single scattering has q' = -degree and u' = 0 there, whatever the sun."""
    zenith, azimuth = directions()
    sun = (0.8, 1.3)
    travel, incident = travel_of(zenith, azimuth), travel_of(np.array(sun[0]), np.array(sun[1]))
    l_axis, r_axis = frame_of(travel)
    other = incident - (travel @ incident)[:, None] * travel
    other /= np.linalg.norm(other, axis=1, keepdims=True)
    cosine, sine = (l_axis * other).sum(axis=1), (r_axis * other).sum(axis=1)
    twice = cosine**2 - sine**2, 2 * sine * cosine
    q, u = pattern(zenith, azimuth, sun)
    cosine = travel @ incident
    degree = (1 - cosine**2) / (1 + cosine**2)
    np.testing.assert_allclose(q * twice[0] + u * twice[1], -degree, atol=1e-12)
    np.testing.assert_allclose(u * twice[0] - q * twice[1], 0.0, atol=1e-12)


def test_light_of_a_glowing_ground_is_not_polarised_around_the_sun():
    """It thins the pattern of the sun's light; where the sun gives none, the pattern is refused."""
    how = {"wavelength_nm": [450.0, 550.0], "grid": sky.PatchGrid.regular(3, 4), "n_orders": 2, "n_paths": 64}
    how |= {"polarisation": FULL}
    dark = sky.AtmosphereSky.from_file(MOLECULES, sun_zenith_deg=50.0, **how)
    lit = sky.AtmosphereSky.from_file(MOLECULES, sun_zenith_deg=50.0, ground_radiance=np.array([0.05, 0.2]), **how)
    (one,), (other,) = dark.lower([450.0, 550.0]), lit.lower([450.0, 550.0])
    share = one.mass / other.mass
    assert share.max() < 0.97
    np.testing.assert_allclose(other.stokes, share[..., None] * one.stokes, atol=1e-12)
    with pytest.raises(sky.errors.SceneError, match="40 degrees below the horizon and the ground alone"):
        sky.AtmosphereSky.from_file(MOLECULES, sun_zenith_deg=130.0, ground_radiance=np.ones(2), **how)


def test_an_atmosphere_has_one_row_and_even_weights():
    """Its photons are even inside patches, so the row does not depend on the wavelength, and costs no radiance."""
    how = {"sun_zenith_deg": 50.0, "sun_azimuth_deg": 20.0, "grid": sky.PatchGrid.regular(6, 12)}
    how |= {"polarisation": sky.RayleighPattern()}
    made = sky.AtmosphereSky.from_file(MOLECULES, wavelength_nm=[550.0], **how)
    (component,) = made.lower([450.0, 550.0])
    assert component.stokes.shape == (1, 72, 2)
    even = sky.PerezSky(epsilon=6.0, delta=0.1, within="uniform", **how)
    np.testing.assert_array_equal(component.stokes, even.lower([550.0])[0].stokes)
