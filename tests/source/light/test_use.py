"""What a scene cannot use is refused by both names of the input, and nothing of the light is dropped without a word."""

import shutil

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

AMOUNTS = {"ghi": 780.0, "dhi": 140.0}


def test_a_sky_of_a_file_says_that_there_is_no_beam_to_leave_out():
    leaves = "--diffuse-only (diffuse_only=True) leaves nothing out: no beam is asked for beside skydist.inp"
    assert leaves in sky.read_scene(INPUTS / "clear_day", diffuse_only=True).notes
    amounts = {"perez": {"dni": 800.0, "dhi": 100.0, "spectrum": "flat"}}
    scene = sky.read_scene(INPUTS / "clear_day", diffuse_only=True, **amounts)
    assert leaves not in scene.notes  # a beam is asked for
    assert [c.name for c in scene.components] == ["sky"]
    low = sky.read_scene(INPUTS / "clear_day", diffuse_only=True, **amounts, sun={"zenith_deg": 80.0})
    shares = [800 * np.cos(np.radians(z)) / (800 * np.cos(np.radians(z)) + 100) for z in (35, 80)]  # 35 of amc.inp
    for one, share in zip((scene, low), shares, strict=True):
        assert f"the direct beam of the sun, {share:.4g} of the light, is left out" in one.notes[0]
    no_beam = r"--sun-zenith \(sun_zenith_deg=\) is not used: the scene has no beam; leave it out$"
    for name in (None, "uniform"):
        with pytest.raises(sky.UsageError, match=no_beam):
            sky.read_scene(INPUTS / "clear_day", sky=name, diffuse_only=True, sun={"zenith_deg": 40.0})


def test_a_waveband_that_has_only_the_beam_is_dark_without_it(tmp_path):
    with pytest.raises(sky.SceneError, match="all light is direct"):
        sky.weather_scene(wavebands=[443.0], sun_zenith_deg=40.0, dni=800, dhi=0, sky="overcast", diffuse_only=True)
    amc = copy_scene("sun_and_sky", tmp_path)
    (amc.parent / "difcol.inp").write_text("5\n1 1\n.5 1\n.5 1\n.5 1\n.5 1\n")
    (amc.parent / "sky.toml").write_text("[perez]\ndni = 800.0\ndhi = 100.0\n")
    with pytest.raises(sky.SceneError, match="waveband 1 at 400 nm has no light"):
        sky.read_scene(amc, diffuse_only=True)
    assert len(sky.read_scene(amc, diffuse_only=True, wavebands=[2]).components) == 1


def test_a_perez_sky_of_a_cloudless_day_has_the_sun_of_the_day():
    pytest.importorskip("pvlib")
    place = {"time": "2026-01-03T12:00Z", "latitude_deg": 20.0, "longitude_deg": 0.0}
    cloudless = sky.weather_scene(wavebands=[443.0, 555.0], **place, spectrum="spectrl2").options["perez"]
    amounts = {name: cloudless[name] for name in ("dni", "dhi")}
    given = sky.weather_scene(wavebands=[443.0, 555.0], **place, **amounts).options["perez"]
    assert cloudless["extraterrestrial_normal"] == given["extraterrestrial_normal"] == pytest.approx(1408.84, abs=0.01)
    assert cloudless["delta"] == pytest.approx(given["delta"], rel=1e-12)
    kasten = sky.weather_scene(wavebands=[443.0], **place, spectrum="spectrl2", air_mass="kasten-1966").options["perez"]
    assert kasten["delta"] != cloudless["delta"]


@pytest.fixture
def measured(tmp_path):
    """The scene perez_sky with a measured table as its sky."""
    pytest.importorskip("pvlib")
    amc = copy_scene("perez_sky", tmp_path)
    (amc.parent / "difcol.inp").unlink()
    shutil.copy(INPUTS / "measured" / "sky.csv", amc.parent / "sky.csv")
    (amc.parent / "sky.toml").write_text('[perez]\nghi = 780\ndhi = 140\n[sky]\ntable = "sky.csv"\n')
    return amc


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")  # wavebands beyond those of the file
def test_the_sun_of_a_measured_sky_comes_before_that_of_amc_inp(measured):
    scene = sky.read_scene(measured)
    with pytest.raises(sky.UsageError, match=r"\(spectrum=\"flat\"\) gives .* the sky is in W m-2 nm-1 .*spectrl2"):
        sky.read_scene(measured, perez={"spectrum": "flat"})
    sun = scene.options["sun"]
    assert (sun["zenith_deg"], sun["azimuth_deg"], sun["from"]) == (40.0, pytest.approx(135.0), "sky.csv")
    alone = sky.read_radiance_csv(INPUTS / "measured" / "sky.csv")
    notes = alone.notes(scene.wavebands.wavelength_nm)
    assert next(note for note in notes if "is off by" in note) in scene.notes


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")
def test_one_angle_of_the_sun_that_is_asked_for_leaves_the_other_to_the_table(measured):
    """Both serve the interpolation, too."""
    table = measured.parent / "sky.csv"
    for angle in ({"zenith_deg": 30.0}, {"azimuth_deg": 100.0}):
        scene = sky.read_scene(measured, sun=angle)
        expected = {"zenith_deg": 40.0, "azimuth_deg": 135.0} | angle
        assert {name: pytest.approx(scene.options["sun"][name]) for name in expected} == expected
        model = sky.read_radiance_csv(table, **{f"sun_{name}": value for name, value in angle.items()})
        rows = model.lower(scene.wavebands.wavelength_nm)[0]
        np.testing.assert_allclose(scene.components[-1].mass[scene.row_of_band], rows.mass, rtol=1e-12)


def test_the_manifest_has_the_sun_of_the_beam():
    from aomc_sky.formats.sky_toml.sections import FieldSection
    from aomc_sky.source.light.said import said_by_caller
    from aomc_sky.source.read.radiance_scene import measured_scene

    pytest.importorskip("pvlib")
    given = said_by_caller(sun={"zenith_deg": 30.0, "disc": True}, perez={"dni": 700.0, "dhi": 120.0})
    scene = measured_scene(FieldSection(file=str(INPUTS / "measured" / "sky.csv")), given)
    assert scene.components[0].law.name == "DISC"
    sun = scene.options["sun"]
    assert (sun["zenith_deg"], sun["azimuth_deg"], sun["disc"]) == (30.0, pytest.approx(135.0), True)
    assert sun["from"] == "options and measured sky"


def test_a_model_with_one_row_serves_all_wavebands():
    class OneRow:
        name = "one-row"

        def radiance(self, zenith, azimuth, nm):
            return 1.0 + 0.0 * zenith

        irradiance = 0.3

        def lower(self, nm):
            return sky.UniformSky(irradiance_W_m2_nm=[self.irradiance]).lower([550.0])

    pytest.importorskip("pvlib")
    light = {"wavebands": [443.0, 555.0], "sun_zenith_deg": 40.0, **AMOUNTS}
    scene = sky.weather_scene(**light, sky=OneRow())
    spectra = sky.weather_scene(**light, sky="uniform", spectrum="spectrl2").irradiance.of_component
    np.testing.assert_allclose(scene.irradiance.of_component[:, 0], spectra[:, 0], rtol=1e-12)
    np.testing.assert_allclose(scene.irradiance.of_component[:, 1], [0.3, 0.3], rtol=1e-12)
    OneRow.irradiance = 0.9
    ratio = np.mean(0.9 / spectra[:, 1])
    with pytest.warns(
        sky.InputWarning, match=f"diffuse irradiance of the sky is {ratio:.3g} times that of ghi 780 and dhi 140"
    ):
        bright = sky.weather_scene(**light, sky=OneRow())
    np.testing.assert_allclose(bright.irradiance.of_component, [[beam, 0.9] for beam in spectra[:, 0]], rtol=1e-12)
