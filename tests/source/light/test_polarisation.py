"""Rayleigh's pattern on skies that are named: by keyword, by option and by sky.toml it is that of the model."""

import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.shared import INPUTS

PATTERN = sky.RayleighPattern(max_degree=0.6)
SUN = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 25.0}
NM = [443.0, 555.0]


def plan_of(scene):
    return scene.source(seed=3).plan


def weather(**how):
    return sky.weather_scene(wavebands=NM, n_photons=1000, **how)


def test_a_named_sky_has_the_plan_of_the_sky_that_is_made(tmp_path, capsys):
    epsilon, one = {"epsilon": 5.0, "delta": 0.12, **SUN}, {"wavebands": [555.0], "n_photons": 1000}
    perez = plan_of(sky.weather_scene(**one, **epsilon, diffuse_only=True, polarisation=PATTERN))
    model = sky.PerezSky(**epsilon, polarisation=PATTERN)
    assert perez.sha256 == plan_of(sky.Scene(**one, components=model)).sha256
    named, made = {"sky": "cie", "sky_options": {"type": 12}}, sky.CIESky(**SUN, type=12, polarisation=PATTERN)
    plan = plan_of(weather(**named, **SUN, diffuse_only=True, polarisation=PATTERN))
    assert plan.sha256 == plan_of(sky.Scene(wavebands=NM, n_photons=1000, components=made)).sha256
    light = {"ghi": 780.0, "dhi": 140.0, **SUN}
    with_beam = plan_of(weather(**named, polarisation=PATTERN, **light))
    assert with_beam.sha256 == plan_of(weather(sky=made, **light)).sha256
    assert with_beam.components[0].stokes is None
    assert with_beam.components[1].stokes is not None
    words = "--sky cie --sky-option type=12 --ghi 780 --dhi 140 --sun-zenith 40 --sun-azimuth 25"
    words += " --wavelengths 443 555 --iterations 1000 --seed 3 --format none"
    command = ["run", *words.split()]
    assert main([*command, "--polarisation", "0.6", "-v", "--out", str(tmp_path / "a")]) == 0
    assert sky.Plan.load(tmp_path / "a" / "plan.npz").sha256 == with_beam.sha256
    assert "Rayleigh's pattern, largest degree 0.6, around the sun at a zenith angle of 40" in capsys.readouterr().out
    assert main([*command, "--out", str(tmp_path / "b")]) == 0
    plain = sky.Plan.load(tmp_path / "b" / "plan.npz")
    assert plain.sha256 == plan_of(weather(**named, **light)).sha256
    assert set(with_beam.members()) == {*plain.members(), "stokes_1"}


def folder(tmp_path, toml, scene="sun_and_sky"):
    target = shutil.copytree(INPUTS / scene, tmp_path / "scene", dirs_exist_ok=True)
    (target / "sky.toml").write_text(toml)
    return target


def test_sky_toml_and_keywords_say_the_same(tmp_path):
    path = folder(tmp_path, '[sky]\nmodel = "cie"\ntype = 12\npolarisation = 0.6\n')
    by_toml = sky.read_scene(path)
    keywords = {"sky": "cie", "sky_options": {"type": 12}}
    by_keywords = sky.read_scene(path, **keywords, polarisation=sky.RayleighPattern(max_degree=0.3))
    (path / "sky.toml").unlink()
    plain = sky.read_scene(path, **keywords)
    assert plan_of(by_toml).sha256 == plan_of(sky.read_scene(path, **keywords, polarisation=PATTERN)).sha256
    np.testing.assert_allclose(plan_of(by_keywords).components[1].stokes, plan_of(by_toml).components[1].stokes / 2)
    assert set(plan_of(by_toml).members()) == {*plan_of(plain).members(), "stokes_1"}
    assert by_toml.options["sun"]["polarisation"] == 0.6
    assert "polarisation" not in plain.options["sun"]
    assert len(by_toml.notes) == len(plain.notes) + 1


def test_an_atmosphere(tmp_path):
    text = '[atmosphere]\nfile = "molecules_only.atmo"\nzenith_bins = 6\nazimuth_bins = 12\n[sun]\nzenith_deg = 50.0\n'
    path = folder(tmp_path, f"{text}[sky]\npolarisation = 0.6\n", "atmosphere_sky")
    shutil.copytree(INPUTS / "atmosphere", path, dirs_exist_ok=True)
    scene = sky.read_scene(path)
    azimuth = scene.options["sun"]["azimuth_deg"]
    beam, diffuse = plan_of(scene).components
    assert beam.stokes is None
    grid = sky.PatchGrid.regular(6, 12)
    even = sky.PerezSky(
        epsilon=6.0, delta=0.1, grid=grid, within="uniform", sun_zenith_deg=50.0, sun_azimuth_deg=azimuth,
        polarisation=PATTERN,
    )  # fmt: skip
    np.testing.assert_array_equal(diffuse.stokes, even.lower([550.0])[0].stokes)
    assert any("Rayleigh's pattern" in note for note in scene.notes)


def rayleigh_stokes(batch, sun):
    """The pattern in the direction of each photon."""
    zenith, azimuth = np.arccos(-batch.uz.astype(float)), np.arctan2(-batch.uy.astype(float), -batch.ux.astype(float))
    angles = dict(zip(("sun_zenith_rad", "sun_azimuth_rad"), np.deg2rad(sun), strict=True))
    return np.stack(PATTERN.stokes(zenith, azimuth, **angles)), np.sin(zenith) > 0.07  # at the zenith patches are wide


def test_a_table_and_a_function_have_it_around_the_sun_of_the_scene():
    """Of skydist.inp, of a function and of a model of radiances; an azimuth that is mirrored is far away."""
    by_file = sky.read_scene(INPUTS / "clear_day", iterations=20_000, polarisation=PATTERN)
    radiance = lambda z, a, nm: 1.0 + np.cos(z) ** 2 + 0 * a * nm  # noqa: E731
    light = {"ghi": 780.0, "dhi": 140.0, **SUN, "polarisation": PATTERN, "wavebands": [550.0], "n_photons": 20_000}
    grid = sky.PatchGrid.regular(90, 180)
    even = sky.TabulatedSky(wavelength_nm=[550.0], values=np.ones((1, 16_200)), grid=grid, weighting="projected")
    file_sun = by_file.options["sun"]["zenith_deg"], by_file.options["sun"]["azimuth_deg"]
    for scene, sun in (
        (by_file, file_sun),
        (sky.weather_scene(sky=radiance, **light), (40.0, 25.0)),
        (sky.weather_scene(sky=even, **light), (40.0, 25.0)),
    ):
        source = scene.source(seed=2)
        batch = source.photons()
        is_sky = batch.patch >= source.plan.component_start[len(source.components) - 1]
        wrong = np.stack([batch.q, batch.u]) - (expected := rayleigh_stokes(batch, sun))[0]
        chosen = is_sky & expected[1]
        assert chosen.sum() > 1000
        assert np.abs(wrong[:, chosen]).max() < 0.06
        mirrored = np.stack([batch.q, -batch.u]) - expected[0]
        assert np.abs(mirrored[:, chosen]).max() > 0.5


NO_PATTERN = r"--polarisation \(polarisation=\) is not used: the sky is "
REFUSED = {
    "no sun in it": ({"sky": "overcast", "diffuse_only": True}, NO_PATTERN + "an overcast sky; take a sky with a sun"),
    "a model without a sun": ({"sky": sky.OvercastSky(), **SUN, "ghi": 700.0, "dhi": 100.0}, NO_PATTERN + "the mod"),
    "all light is direct": ({**SUN, "dni": 800.0, "dhi": 0.0}, r"is not used: all light is direct \(dni 800 and dhi 0"),
    "a model with a sun": ({"sky": sky.CIESky(type=3, **SUN), **SUN}, r"write CIESky\(polarisation=...\)"),
    "no sun": ({"sky": "cie", "sky_options": {"type": 3}, "diffuse_only": True}, "where is the sun"),
    "a number": ({**SUN, "epsilon": 5.0, "delta": 0.1, "polarisation": 0.75}, r"RayleighPattern\(max_degree=0.75\)"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_pattern_is_refused_in_one_sentence(name):
    how, text = REFUSED[name]
    with pytest.raises(sky.UsageError, match=text) as raised:
        weather(**{"polarisation": PATTERN, **how})
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("toml", "place", "text"),
    [
        ('[sky]\nmodel = "overcast"\npolarisation = 0.5\n', "3:1: error[E705]", 'model "overcast", which has no sun'),
        ('[sky]\npolarization = 0.5\n', "2:1: error[E702]", "the nearest is polarisation"),
    ],
)  # fmt: skip
def test_lines_of_sky_toml_that_are_wrong(toml, place, text, tmp_path, told):
    path = folder(tmp_path, toml)
    said = told("run", path, "--format", "none", "--out", tmp_path / "out", code=3).err
    assert f"sky.toml:{place}" in said
    assert text in said


def test_an_option_that_takes_another_sky_leaves_a_note(tmp_path):
    path = folder(tmp_path, "[sky]\npolarisation = 0.5\n")
    scene = sky.read_scene(path, sky="overcast")
    assert "sky.toml: polarisation is not used: the sky is an overcast sky" in scene.notes
    assert all(component.stokes is None for component in scene.components)
    with pytest.raises(sky.UsageError, match=r"\(sun_zenith_deg=\) is not used: the scene has no beam"):
        sky.read_scene(path, sky="overcast", sun={"zenith_deg": 30.0}, diffuse_only=True)
