"""Skies that optics knows by name: their laws against numbers of other hands."""

from functools import partial

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.scenes import copy_scene


def test_the_overcast_sky():
    # mean of mu by hand: (1/3 + 2/4) / (1/2 + 2/3)
    source = sky.Scene(wavebands=[550.0], n_photons=1_000_000, components=sky.OvercastSky()).source(seed=2)
    assert source.exact_moments(0).mean_mu == pytest.approx(5 / 7, abs=2e-7)
    assert -source.photons(0).uz.astype(float).mean() == pytest.approx(5 / 7, abs=3e-6)
    # Eo / Ed by hand: (1 + 1) / (1/2 + 2/3)
    assert source.exact_moments(0).mean_inverse_mu == pytest.approx(12 / 7, abs=2e-5)
    zenith = np.deg2rad([0.0, 30.0, 60.0, 90.0])
    table = [1.0, (1 + np.sqrt(3)) / 3, 2 / 3, 1 / 3]
    np.testing.assert_allclose(sky.OvercastSky().radiance(zenith, 0.0, 550.0), table, rtol=1e-15)


def angle_to_sun(zenith, azimuth, sun_zenith, sun_azimuth):
    """From a vector product, and not from our angles."""
    vectors = [
        np.stack(np.broadcast_arrays(np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)), axis=-1)
        for z, a in ((zenith, azimuth), (sun_zenith, sun_azimuth))
    ]
    return np.arctan2(np.linalg.norm(np.cross(*vectors), axis=-1), np.sum(vectors[0] * vectors[1], axis=-1))


def mean_cosine(law, sun_zenith, sun_azimuth):
    """Mean cosine of the flux of a sky with a cusp at the sun: Gauss points on both sides of it, within 1e-7."""
    x, w = np.polynomial.legendre.leggauss(400)
    top = np.cos(sun_zenith)
    mu = np.concatenate([x * top / 2 + top / 2, x * (1 - top) / 2 + (1 + top) / 2])
    weight = np.concatenate([w * top, w * (1 - top)]) / 2
    azimuth = sun_azimuth + np.pi / 2 * (1 + x) ** 2 / 2
    flux = np.sum(law(np.arccos(mu)[:, None], azimuth) * (1 + x) * w, axis=1) * weight * mu
    return np.sum(flux * mu) / np.sum(flux)


def harrison_coombes(zenith, azimuth, sun_zenith, sun_azimuth, cloud=0.0):
    """The formula as the paper prints it."""
    p = angle_to_sun(zenith, azimuth, sun_zenith, sun_azimuth)
    about_sun = 1.63 + 53.7 * np.exp(-5.49 * p) + 2.04 * np.cos(p) ** 2 * np.cos(sun_zenith)
    clear = about_sun * -np.expm1(-0.19 / np.cos(zenith)) * -np.expm1(-0.53 / np.cos(sun_zenith))
    cloudy = 0.45 + 0.12 * sun_zenith + 0.43 * np.cos(zenith) + 0.72 * np.exp(-1.88 * p)
    return cloud * cloudy + (1 - cloud) * clear


@pytest.mark.parametrize(("sun_zenith_deg", "cloud"), [(0.0, 0.0), (35.0, 0.0), (70.0, 0.0), (85.0, 0.0), (50.0, 0.6)])
def test_the_sky_of_harrison_and_coombes(sun_zenith_deg, cloud, monkeypatch):
    """Under clouds in patches of ten degrees, since those of one degree take ten seconds."""
    coarse = partial(sky.FunctionSky, grid=sky.PatchGrid.regular(9, 18))
    monkeypatch.setattr("aomc_sky.skies.harrison_coombes.FunctionSky", coarse)
    model = sky.HarrisonCoombesSky(sun_zenith_deg=sun_zenith_deg, sun_azimuth_deg=60.0, cloud_cover=cloud)
    sun = np.deg2rad([sun_zenith_deg, 60.0])
    directions = np.deg2rad([[3.0, 10.0], [35.0, 60.0], [50.0, 200.0], [80.0, 300.0], [89.0, 61.0]])
    ours, theirs = model.radiance(*directions.T, 550.0), harrison_coombes(*directions.T, *sun, cloud)
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    expected = mean_cosine(lambda *direction: harrison_coombes(*direction, *sun, cloud), *sun)
    source = sky.Scene(wavebands=[550.0], n_photons=100_000, components=model).source(seed=3)
    assert source.exact_moments(0).mean_mu == pytest.approx(expected, rel=2e-6 if cloud == 0 else 1e-5)
    assert -source.photons(0).uz.astype(float).mean() == pytest.approx(expected, rel=3e-4)


# Darula and Kittler, Proc. eSim (2002), table 1: gradations I to VI (a, b), indicatrices 1 to 6 (c, d, e), and both of
# each type
GRADATION = {"I": (4, -0.7), "II": (1.1, -0.8), "III": (0, -1), "IV": (-1, -0.55), "V": (-1, -0.32), "VI": (-1, -0.15)}
INDICATRIX = {
    1: (0, -1, 0), 2: (2, -1.5, 0.15), 3: (5, -2.5, 0.3), 4: (10, -3, 0.45), 5: (16, -3, 0.3), 6: (24, -2.8, 0.15)
}  # fmt: skip
GROUPS = ["I1", "I2", "II1", "II2", "III1", "III2", "III3", "III4", "IV2", "IV3", "IV4", "V4", "V5", "VI5", "VI6"]


def cie(number, zenith, azimuth, sun_zenith, sun_azimuth):
    """Luminance over that of the zenith as the standard prints it."""
    group = GROUPS[number - 1]
    (a, b), (c, d, e) = GRADATION[group[:-1]], INDICATRIX[int(group[-1])]

    def phi(z):
        return 1 + a * np.exp(b / np.cos(z))

    def f(chi):
        return 1 + c * (np.exp(d * chi) - np.exp(d * np.pi / 2)) + e * np.cos(chi) ** 2

    chi = angle_to_sun(zenith, azimuth, sun_zenith, sun_azimuth)
    return f(chi) * phi(zenith) / (f(sun_zenith) * phi(0.0))


@pytest.mark.parametrize("number", range(1, 16))
def test_the_general_skies_of_the_cie(number):
    sun = np.deg2rad([50.0, 60.0])
    model = sky.CIESky(type=number, sun_zenith_deg=50.0, sun_azimuth_deg=60.0)
    directions = np.deg2rad([[0.0, 0.0], [35.0, 61.0], [50.0, 60.0], [80.0, 300.0], [89.9, 61.0]]).T
    np.testing.assert_allclose(model.radiance(*directions, 550.0), cie(number, *directions, *sun), rtol=1e-12)
    expected = mean_cosine(lambda *direction: cie(number, *direction, *sun), *sun)
    source = sky.Scene(wavebands=[550.0], n_photons=100_000, components=model).source(seed=3)
    assert source.exact_moments(0).mean_mu == pytest.approx(expected, rel=2e-6)
    assert -source.photons(0).uz.astype(float).mean() == pytest.approx(expected, rel=3e-4)


def test_a_cie_sky_of_a_scene_of_files_has_a_type(tmp_path):
    amc = copy_scene("sun_and_sky", tmp_path)
    by_option = sky.read_scene(amc, sky="cie", sky_options={"type": 8})
    (amc.parent / "sky.toml").write_text('[sky]\nmodel = "cie"\ntype = 8\n')
    assert sky.read_scene(amc).components == by_option.components
    (amc.parent / "sky.toml").write_text('[sky]\nmodel = "cie"\ntype = 16\n')
    with pytest.raises(sky.InputFileError, match=r"sky\.toml:3:8.*whole number from 1 to 15, got 16"):
        sky.read_scene(amc)


def test_defaults_and_refusals():
    by_radians = sky.CIESky(type=12, sun_zenith_rad=np.deg2rad(40.0), sun_azimuth_deg=0)
    assert sky.CIESky(type=12, sun_zenith_deg=40.0) == by_radians
    assert sky.HarrisonCoombesSky(sun_zenith_deg=40.0).sun_azimuth_rad == 0.0
    assert sky.CardioidalSky() == sky.OvercastSky()
    for number in (0, 16, 3.5, "12", True):
        with pytest.raises(sky.SceneError, match="whole number from 1 to 15"):
            sky.CIESky(type=number, sun_zenith_deg=40.0, sun_azimuth_deg=0.0)
    with pytest.raises(sky.SceneError, match=r"0 to 1, got 1\.5"):
        sky.HarrisonCoombesSky(sun_zenith_deg=40.0, sun_azimuth_deg=0.0, cloud_cover=1.5)
    with pytest.raises(sky.UsageError, match="sun_zenith"):
        sky.HarrisonCoombesSky(sun_azimuth_deg=0.0)
    assert sky.Scene(wavebands=[500.0], n_photons=1, components="overcast").components[0].name == "overcast"
    with pytest.raises(sky.SceneError, match=r"HarrisonCoombesSky\("):
        sky.Scene(wavebands=[500.0], n_photons=1, components="harrison-coombes")
