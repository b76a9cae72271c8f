"""Radiance of a scene in any direction, and its map: against the models' own radiance, and their integrals."""

import json
import pickle

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.lobes import lobe_sky
from tests.support.sampled import table_of
from tests.support.shared import INPUTS

FOUR = [(10.25, 20.25), (40.25, 120.25), (60.25, 330.25), (80.25, 250.25)]  # middles of pixels
PIXEL_SR = np.diff(np.sin(np.deg2rad(np.arange(181) / 2)) ** 2) / 2 * np.deg2rad(0.5)
"""Projected solid angles of the pixels of each ring of a map."""
SUN = {"sun_zenith_deg": 32.0, "sun_azimuth_deg": 331.0}


def day():
    pytest.importorskip("pvlib")
    return sky.weather_scene(wavebands=[443.0, 555.0], **SUN, ghi=780, dhi=140, spectrum="spectrl2", n_photons=1000)


def scene_of(components, nm=550.0):
    return sky.Scene(wavebands=[nm], n_photons=10, components=components)


SCENES = {
    "perez": lambda: scene_of(sky.PerezSky(**SUN, epsilon=6.0, delta=0.1)),
    "cie": lambda: scene_of(sky.CIESky(type=12, **SUN)),
    "function": lambda: scene_of(lambda z, a, nm: 1 + np.cos(z) * (1 + np.sin(z) * np.cos(a))),
    "uniform": lambda: scene_of("uniform"),
    "overcast": lambda: scene_of("overcast"),
    "day": day,
    "table": lambda: sky.read_scene(INPUTS / "clear_day"),
    "per solid angle": lambda: sky.read_scene(INPUTS / "clear_day", weighting="solid-angle"),
}


def integral(scene, band=0, n=500):
    """Irradiance by a midpoint rule in mu^2 and azimuth."""
    zenith = np.arccos(np.sqrt((np.arange(n) + 0.5) / n))[:, None]
    azimuth = (np.arange(2 * n) + 0.5) * np.pi / n
    return np.pi * scene.radiance(band, sky_zenith_rad=zenith, sky_azimuth_rad=azimuth).mean()


@pytest.mark.parametrize("name", SCENES)
def test_the_integral_is_the_irradiance(name):
    scene = SCENES[name]()
    beam = sum(c.strength[0] for c in scene.components if c.name == "direct")
    expected = 1 - beam if scene.irradiance is None else scene.irradiance.of_component[0, -1]
    assert integral(scene) == pytest.approx(expected, rel=1e-3 if name == "per solid angle" else 2e-4)


def test_directions_of_models_in_absolute_units():
    scene = day()
    model = sky.PerezSky(**SUN, ghi=780, dhi=140)
    zenith, azimuth = np.deg2rad(np.array([*FOUR, (32.0, 331.0), (90.0, 0.0)])).T
    for band in (0, 1):
        expected = model.radiance(zenith, azimuth, 550.0) * scene.irradiance.of_component[band, 1] / 140
        band_radiance = scene.radiance(band, zenith, azimuth)
        np.testing.assert_allclose(band_radiance, expected, rtol=1e-9)
        one = scene.radiance(band, sky_zenith_deg=FOUR[0][0], sky_azimuth_deg=FOUR[0][1] - 360)
        assert one == pytest.approx(band_radiance[0], rel=1e-12)
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_directions_of_lobes():
    broad = ("ggx", 0.2, 1.0, (1, 0.2, 0, 0)), ("beckmann", 0.3, 0.1, (1, 0, 0.3, 0))
    model = lobe_sky(("hg", 0.9, 0.0, (0.9, 0.3, 0.1, 0)), *broad)
    scene = scene_of(model, 500.0)
    zenith, azimuth = np.deg2rad(np.array(FOUR)).T
    expected = model.radiance(zenith, azimuth, 500.0)
    np.testing.assert_allclose(scene.radiance(0, sky_zenith_rad=zenith, sky_azimuth_rad=azimuth), expected, rtol=1e-9)


def test_edges_of_patches_and_what_is_no_direction():
    model = table_of(np.arange(1.0, 13.0).reshape(3, 4), weighting="projected")
    scene = scene_of(model, 500.0)
    zenith, azimuth = np.array([0.0, 29.999, 30.0, 60.0, 90.0]), np.array([0.0, 90.0, 180.0, 270.0, 359.999])
    expected = model.radiance(np.deg2rad(zenith), np.deg2rad(azimuth), 500.0)
    for angles in (
        {"sky_zenith_deg": zenith, "sky_azimuth_deg": azimuth},
        {"sky_zenith_rad": np.deg2rad(zenith), "sky_azimuth_rad": np.deg2rad(azimuth)},
    ):
        found = scene.radiance(0, **angles)
        np.testing.assert_allclose(found / found[0], [1, 2, 7, 12, 12], rtol=1e-12)
        assert found[0] / expected[0] == pytest.approx(found[4] / expected[4], rel=1e-12)
    scene = SCENES["uniform"]()
    for angles in ({"sky_zenith_deg": 91, "sky_azimuth_deg": 0}, {"sky_zenith_deg": 10, "sky_azimuth_deg": np.nan}):
        with pytest.raises(sky.SceneError, match="0 to 90 degrees and a finite azimuth"):
            scene.radiance(0, **angles)
    with pytest.raises(sky.UsageError, match="give sky_azimuth_deg or sky_azimuth_rad"):
        scene.radiance(0, sky_zenith_deg=10)
    with pytest.raises(IndexError, match="bands run from 0 to 0"):
        scene.radiance(1, sky_zenith_deg=10, sky_azimuth_deg=0)


def test_the_map_of_an_export(tmp_path):
    scene = day()
    sky.write_run(scene, tmp_path / "day")
    assert main(["export", str(tmp_path / "day"), "--to", "envmap", "-q"]) == 0
    found = np.load(tmp_path / "day-envmap" / "envmap.npy")
    axes = json.loads((tmp_path / "day-envmap" / "envmap.json").read_text())
    assert (found.shape, found.dtype) == ((2, 360, 720), np.float32)
    assert not found[:, 180:].any()
    np.testing.assert_allclose(axes["irradiance_of_map"], scene.irradiance.of_component[:, 1], rtol=1e-12)
    for zenith, azimuth in FOUR:
        pixel = found[:, int(2 * zenith), int(2 * azimuth)]
        exact = [scene.radiance(band, sky_zenith_deg=zenith, sky_azimuth_deg=azimuth) for band in (0, 1)]
        np.testing.assert_allclose(pixel, exact, rtol=1e-3)
    assert axes["unit"] == "W m-2 sr-1 nm-1"
    (beam,) = axes["beams"]
    assert [beam[k] for k in ("zenith_deg", "azimuth_deg")] == pytest.approx([32.0, 331.0], abs=1e-9)
    assert beam["irradiance_on_a_horizontal_plane"] == pytest.approx(scene.irradiance.of_component[:, 0])


@pytest.mark.parametrize(("name", "options"), [("clear_day", {}), ("overcast", {"compat": "aomc"}), ("perez_sky", {})])
def test_maps_of_tables_hold_their_light(name, options):
    from aomc_sky.outputs.envmap import axes_of, maps

    source = sky.read_scene(INPUTS / name, **options).source()
    for band, one in enumerate(maps(source, range(source.n_bands))):
        expected = axes_of(source, [band])["irradiance_of_map"]
        assert one[:180].astype(float).sum(axis=1) @ PIXEL_SR == pytest.approx(expected[0], rel=1e-6)


def test_datasets_carry_radiance_and_wavelengths():
    pytest.importorskip("xarray")
    scene = day()
    data = sky.to_xarray(scene.source())
    assert data.radiance.attrs["units"] == "W m-2 sr-1 nm-1"
    one = data.swap_dims(waveband="wavelength").radiance.sel(wavelength=555.0)
    exact = scene.radiance(1, sky_zenith_deg=one.zenith.values[:, None], sky_azimuth_deg=one.azimuth.values)
    np.testing.assert_allclose(one[5:], exact[5:], rtol=1e-2)  # the zenith's ring is all around in one patch
    area = scene.source().grid.projected_solid_angle_sr
    assert one.values.ravel() @ area == pytest.approx(scene.irradiance.of_component[1, 1], rel=1e-9)


def test_functions_have_their_radiance_in_directions_and_pixels():
    """Photons follow a function inside patches, and so does its radiance: to the second order of a patch."""
    from aomc_sky.outputs.envmap import maps

    scene = SCENES["function"]()
    zenith, azimuth = np.deg2rad(np.random.default_rng(1).uniform([1, 0], [89, 360], (200, 2))).T
    exact = 1 + np.cos(zenith) * (1 + np.sin(zenith) * np.cos(azimuth))
    irradiance = np.pi * (1 + 2 / 3)  # the azimuthal part has none
    found = scene.radiance(0, sky_zenith_rad=zenith, sky_azimuth_rad=azimuth)
    np.testing.assert_allclose(found, exact / irradiance, rtol=1e-3)
    (turned,) = scene.radiance(0, sky_zenith_deg=[33.3], sky_azimuth_deg=[[282.3]]).ravel()
    assert scene.radiance(0, sky_zenith_deg=33.3, sky_azimuth_deg=-77.7) == pytest.approx(turned, rel=1e-12)
    (pixels,) = maps(scene.source(), [0])
    at = scene.radiance(0, sky_zenith_deg=np.arange(0.25, 90, 0.5)[:, None], sky_azimuth_deg=np.arange(0.25, 360, 0.5))
    np.testing.assert_allclose(pixels[10:180], at[10:], rtol=2e-3)
