"""The whole light of a place: shares of beam and sky, their spectra, and what cannot be."""

import numpy as np
import pytest

import aomc_sky as sky

NOON = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 30.0, "ghi": 780.0, "dhi": 140.0}
USAGE, SCENE = sky.UsageError, sky.SceneError
NO_LIGHT = {"ghi": None, "dhi": None}


def mean_cosine_of_sky(model):
    """By the midpoint rule over the hemisphere, with none of our quadratures."""
    mu = (np.arange(1500) + 0.5) / 1500
    azimuth = (np.arange(720) + 0.5) / 720 * 2 * np.pi
    radiance = model.radiance(np.arccos(mu)[:, None], azimuth[None, :], 550.0)
    return (radiance * mu[:, None] ** 2).sum() / (radiance * mu[:, None]).sum()


def test_beam_and_sky_share_the_light_of_the_plane():
    scene = sky.weather_scene(wavebands=[443.0, 555.0], n_photons=200_000, **NOON)
    share = (780.0 - 140.0) / 780.0
    beam, diffuse = scene.components
    assert (beam.name, diffuse.name) == ("direct", "perez")
    assert beam.strength[0] / (beam.strength[0] + diffuse.strength[0]) == pytest.approx(share, rel=1e-12)
    model = sky.PerezSky(**NOON)
    expected = share * np.cos(np.deg2rad(40.0)) + (1 - share) * mean_cosine_of_sky(model)
    source = scene.source(seed=3)
    for band in range(2):
        assert source.exact_moments(band).mean_mu == pytest.approx(expected, rel=2e-5)
        assert -source.photons(band).uz.astype(float).mean() == pytest.approx(expected, rel=1e-5)
    assert scene.irradiance is None
    assert any("the beam has 0.8205 of the light" in note for note in scene.notes)


def test_coefficients_do_not_say_how_bright_the_beam_is():
    scene = sky.weather_scene(wavebands=[500.0], sun_zenith_deg=40.0, coefficients=(-1, -0.3, 10, -3, 0.45))
    assert [c.name for c in scene.components] == ["perez"]
    assert any("do not say how bright the beam is" in note for note in scene.notes)
    assert any(note.startswith("Perez sky: coefficients -1, -0.3, 10, -3, 0.45 (") for note in scene.notes)


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"ghi": None}, USAGE, "dhi"),
        ({"wavebands": [0.443]}, SCENE, "wavelengths are in nm, got 0.443 .micrometres.*; write 443"),
        (NO_LIGHT, USAGE, "which sky?"),
        ({"sun_zenith_deg": None}, USAGE, r"where is the sun. .* needs --sun-zenith .*, or --time \(time=\), --la"),
        ({"sun_zenith_deg": 95.0}, SCENE, "above the horizon"),
        ({"ghi": 0.78, "dhi": 0.14}, SCENE, "write 780 for 0.78 kW m-2"),
        ({"epsilon": 2.0, "delta": 0.1}, USAGE, "how bright are sun and sky"),
        ({"coefficients": (1, 2)}, USAGE, "five numbers"),
        ({"time": "2026-06-21T09:30Z"}, USAGE, r"leave out --sun-zenith .* \(sun_azimuth_deg=\)"),
        ({"n_photons": -1}, sky.AomcSkyError, "photons"),
        ({"ghi": float("nan")}, USAGE, "ghi"),
        ({"sky": "overast"}, USAGE, "there is no sky model 'overast'; the nearest is overcast"),
        ({"sky": "x/Field.NC"}, USAGE, "is a file, not the name of a sky; write table = "),
        ({"sky": sky.DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=30)}, USAGE, "is a beam and no diffuse sky"),
        ({"sky": sky.CIESky(type=12, sun_zenith_deg=50.0)}, USAGE, "where is the sun. the model 'CIESky' has it"),
        ({"sky": "cie", "sky_options": [12]}, USAGE, "sky_options are a mapping"),
        ({"clear_sky": 5}, USAGE, "clear_sky must be a ClearSky"),
        ({"clear_sky": sky.ClearSky()}, USAGE, r"aod .clear_sky=.* are not used: the light is that of ghi 780"),
        ({"altitude_m": 3000.0}, USAGE, r"--altitude \(altitude_m=\) is not used: the light is that of ghi 780"),
        (NO_LIGHT | {"sky": "uniform", "diffuse_only": True}, USAGE, r"sun_zenith_deg=.* the scene has no beam"),
        ({"diffuse_only": "no"}, USAGE, "diffuse_only must be True or False"),
        ({"sun_disc": np.ones(2)}, USAGE, "disc: "),
        ({"sky": "cie"}, USAGE, r'needs type .1 to 15.; write .* \(sky_options=\{"type": '),
        ({"sky": "cie", "sky_options": {"kind": 1}}, USAGE, "has no option 'kind'"),
    ],
)
def test_what_cannot_be_is_refused(changed, error, text):
    with pytest.raises(error, match=text):
        sky.weather_scene(**{"wavebands": [500.0], **NOON, **changed})


def test_an_altitude_of_zero_needs_no_time_and_a_low_sun_may_be_faint():
    assert sky.weather_scene(wavebands=[500.0], altitude_m=0.0, **NOON) == sky.weather_scene(wavebands=[500.0], **NOON)
    with pytest.warns(sky.ModelLimitWarning):
        scene = sky.weather_scene(wavebands=[500.0], sun_zenith_deg=89.5, ghi=1.5, dhi=1.4)
    assert scene.source().n_photons(0) == 1_000_000


def test_a_name_of_a_sky():
    scene = sky.Scene(wavebands=[500.0], n_photons=10, components="uniform")
    assert [c.name for c in scene.components] == ["uniform"]
    with pytest.raises(sky.SceneError, match=r"write components=PerezSky\(\.\.\.\), or weather_scene"):
        sky.Scene(wavebands=[500.0], n_photons=10, components="perez")
    with pytest.raises(sky.UsageError, match="there is no sky model 'perz'; the models are"):
        sky.Scene(wavebands=[500.0], n_photons=10, components="perz")


def test_numbers_of_other_libraries_name_a_place():
    from fractions import Fraction

    pytest.importorskip("pvlib")
    light = {"wavebands": [550.0], "n_photons": 10, "time": "2026-06-21T12:00Z", "ghi": 700.0, "dhi": 100.0}
    place = {"latitude_deg": 54.5, "longitude_deg": 8.5, "altitude_m": 10.0}
    ours = sky.weather_scene(**light, **place)
    assert sky.weather_scene(**light, **{k: Fraction(v) for k, v in place.items()}).options == ours.options
    for altitude in ([1.0], [[1.0], [1.0, 2.0]], {}, "10 m"):
        with pytest.raises(sky.UsageError, match="altitude_m must be"):
            sky.weather_scene(**light, **(place | {"altitude_m": altitude}))
