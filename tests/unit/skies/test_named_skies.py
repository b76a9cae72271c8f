"""Skies that optics knows by name: their laws against numbers of other hands."""

import numpy as np
import pytest
from scipy.integrate import dblquad

import aomc_sky as sky
from tests.support.scenes import copy_scene


def test_the_overcast_sky_has_the_mean_cosine_five_sevenths():
    # mean of mu by hand: (1/3 + 2/4) / (1/2 + 2/3)
    scene = sky.Scene(wavebands=[550.0], n_photons=1_000_000, components=sky.OvercastSky())
    source = scene.source(seed=2)
    assert source.exact_moments(0).mean_mu == pytest.approx(5 / 7, abs=2e-7)
    assert -source.photons(0).uz.astype(float).mean() == pytest.approx(5 / 7, abs=3e-6)
    # Eo / Ed by hand: (1 + 1) / (1/2 + 2/3)
    assert source.exact_moments(0).mean_inverse_mu == pytest.approx(12 / 7, abs=2e-5)


def test_the_overcast_sky_is_that_of_moon_and_spencer():
    zenith = np.deg2rad([0.0, 30.0, 60.0, 90.0])
    table = [1.0, (1 + np.sqrt(3)) / 3, 2 / 3, 1 / 3]
    np.testing.assert_allclose(sky.OvercastSky().radiance(zenith, 0.0, 550.0), table, rtol=1e-15)


def harrison_coombes(zenith, azimuth, sun_zenith, sun_azimuth):
    """The formula as the paper prints it, from a vector product and not from our angles."""
    element = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])
    sun = np.array(
        [np.sin(sun_zenith) * np.cos(sun_azimuth), np.sin(sun_zenith) * np.sin(sun_azimuth), np.cos(sun_zenith)]
    )
    p = np.arctan2(np.linalg.norm(np.cross(element, sun)), element @ sun)
    about_sun = 1.63 + 53.7 * np.exp(-5.49 * p) + 2.04 * np.cos(p) ** 2 * np.cos(sun_zenith)
    return about_sun * -np.expm1(-0.19 / np.cos(zenith))


@pytest.mark.parametrize("sun_zenith_deg", [0.0, 35.0, 70.0, 85.0])
def test_the_clear_sky_of_harrison_and_coombes(sun_zenith_deg):
    model = sky.HarrisonCoombesSky(sun_zenith_deg=sun_zenith_deg, sun_azimuth_deg=60.0)
    sun = np.deg2rad([sun_zenith_deg, 60.0])
    directions = np.deg2rad([[3.0, 10.0], [35.0, 60.0], [50.0, 200.0], [80.0, 300.0], [89.0, 61.0]])
    ours = np.array([float(model.radiance(*direction, 550.0)) for direction in directions])
    theirs = np.array([harrison_coombes(*direction, *sun) for direction in directions])
    np.testing.assert_allclose(ours / ours[0], theirs / theirs[0], rtol=1e-12)
    flux, cosine = (
        dblquad(
            lambda azimuth, mu, power=power: harrison_coombes(np.arccos(mu), azimuth, *sun) * mu**power,
            *(1e-9, 1.0),
            *(sun[1], sun[1] + np.pi),
            epsrel=1e-6,
        )[0]
        for power in (1, 2)
    )
    source = sky.Scene(wavebands=[550.0], n_photons=100_000, components=model).source(seed=3)
    assert source.exact_moments(0).mean_mu == pytest.approx(cosine / flux, rel=2e-6)
    assert -source.photons(0).uz.astype(float).mean() == pytest.approx(cosine / flux, rel=3e-4)


@pytest.mark.parametrize("name", ["overcast", "cardioidal", "harrison-coombes"])
def test_a_scene_of_files_takes_them_by_name(name, tmp_path):
    amc = copy_scene("sun_and_sky", tmp_path)
    scene = sky.read_scene(amc, sky=name)
    assert [c.name for c in scene.components] == ["direct", name]
    (tmp_path / "toml").mkdir()
    other = copy_scene("sun_and_sky", tmp_path / "toml")
    (other.parent / "sky.toml").write_text(f'[sky]\nmodel = "{name}"\n')
    assert sky.read_scene(other).components[1] == scene.components[1]


def test_what_they_refuse():
    with pytest.raises(sky.AomcSkyError):
        sky.HarrisonCoombesSky(sun_zenith_deg=95.0, sun_azimuth_deg=0.0)
    with pytest.raises(sky.UsageError, match="sun_zenith"):
        sky.HarrisonCoombesSky(sun_azimuth_deg=0.0)
    assert sky.Scene(wavebands=[500.0], n_photons=1, components="overcast").components[0].name == "overcast"
    with pytest.raises(sky.SceneError, match=r"HarrisonCoombesSky\("):
        sky.Scene(wavebands=[500.0], n_photons=1, components="harrison-coombes")
