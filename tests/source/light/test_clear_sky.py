"""A cloudless sky without a measurement: the wiring of SPCTRL2, the day, and every entrance."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene

pvlib = pytest.importorskip("pvlib")

NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0, 765.0, 865.0])
AIR = {"aod_500nm": 0.23, "water_cm": 2.0, "ozone_cm": 0.25, "pressure_hPa": 980.0}


def spectrl2(sun_zenith_deg, day, air):
    """Beam and sky on a horizontal plane by pvlib itself. [W m-2 nm-1]"""
    zenith = np.array([sun_zenith_deg])
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=0.06,
        surface_pressure=100 * air["pressure_hPa"], precipitable_water=air["water_cm"], ozone=air["ozone_cm"],
        relative_airmass=pvlib.atmosphere.get_relative_airmass(sun_zenith_deg, model="kastenyoung1989"),
        aerosol_turbidity_500nm=air["aod_500nm"], dayofyear=day,
    )  # fmt: skip
    nm, beam = np.ravel(found["wavelength"]), found["dni"][:, 0] * np.cos(np.radians(sun_zenith_deg))
    return np.interp(NM, nm, beam), np.interp(NM, nm, found["dhi"][:, 0])


@pytest.mark.parametrize("hour", range(5, 17))
def test_the_light_is_that_of_spectrl2_on_the_day(hour):
    """Twelve suns in January, when the sun is 1.7 % nearer than on average."""
    time = f"2026-01-0{1 + hour % 9}T{hour:02d}:00Z"
    place = {"latitude_deg": -34.0, "longitude_deg": 18.4}
    zenith = float(sky.sun_position(time, **place).apparent_zenith_deg)
    scene = sky.weather_scene(
        wavebands=NM, time=time, **place, spectrum="spectrl2", sky="harrison-coombes", clear_sky=sky.ClearSky(**AIR)
    )
    beam, diffuse = scene.irradiance.of_component.T
    expected = spectrl2(zenith, 1 + hour % 9, AIR)
    np.testing.assert_allclose(beam, expected[0], rtol=2e-6)  # rounded to nine digits, fraction to nine decimals
    np.testing.assert_allclose(diffuse, expected[1], rtol=2e-6)
    assert [c.name for c in scene.components] == ["direct", "harrison-coombes"]
    assert "on that day" in scene.notes[0]


def test_without_a_date_the_sun_has_its_mean_distance():
    scene = sky.weather_scene(wavebands=NM, sun_zenith_deg=40.0, spectrum="spectrl2", sky="uniform")
    distance = pvlib.irradiance.get_extra_radiation(200, solar_constant=1.0, method="spencer")
    expected = np.sum(spectrl2(40.0, 200, {**AIR, "aod_500nm": 0.1, "water_cm": 1.4, "ozone_cm": 0.3,
                                           "pressure_hPa": 1013.25}), axis=0) / distance  # fmt: skip
    np.testing.assert_allclose(scene.irradiance.of_component.sum(axis=1), expected, rtol=1e-7)
    assert "at the sun's mean distance" in scene.notes[0]


def test_every_entrance_has_it(tmp_path):
    """The same light by the command line alone, by options beside amc.inp, by sky.toml and in Python."""
    amc = copy_scene("perez_sky", tmp_path)
    (amc.parent / "difcol.inp").unlink()
    (amc.parent / "sky.toml").unlink()
    sun = ["--sun-zenith", "40", "--sun-azimuth", "10"]
    air = ["--spectrum", "spectrl2", "--aod", "0.3", "--sky", "harrison-coombes"]
    nm = [f"{one:g}" for one in sky.read_scene(amc, perez={"spectrum": "spectrl2"}).wavebands.wavelength_nm]
    common = ["--iterations", "1000", "--format", "none", "-q"]
    assert main(["run", *sun, *air, "--wavelengths", *nm, *common, "--out", str(tmp_path / "alone")]) == 0
    assert main(["run", str(amc), *sun, *air, *common, "--out", str(tmp_path / "options")]) == 0
    (amc.parent / "sky.toml").write_text(
        '[perez]\nspectrum = "spectrl2"\n[clear_sky]\naod_500nm = 0.3\n[sky]\nmodel = "harrison-coombes"\n'
        "[sun]\nzenith_deg = 40\nazimuth_deg = 10\n"
    )
    assert main(["run", str(amc), *common, "--out", str(tmp_path / "toml")]) == 0
    bands = [
        json.loads((tmp_path / name / "manifest.json").read_text())["bands"] for name in ("alone", "options", "toml")
    ]
    scene = sky.weather_scene(
        wavebands=list(map(float, nm)), sun_zenith_deg=40.0, sun_azimuth_deg=10.0, spectrum="spectrl2",
        sky="harrison-coombes", clear_sky=sky.ClearSky(aod_500nm=0.3),
    )  # fmt: skip
    for found in bands:
        ed = [band["irradiance_W_m2_nm"] for band in found]
        np.testing.assert_allclose(ed, scene.irradiance.of_component.sum(axis=1), rtol=1e-12)


@pytest.mark.parametrize("bad", [{"aod_500nm": -1.0}, {"water_cm": float("nan")}, {"pressure_hPa": "high"}])
def test_air_that_is_none_is_refused(bad):
    with pytest.raises(sky.UsageError, match=next(iter(bad))):
        sky.ClearSky(**bad)
    with pytest.raises(sky.UsageError, match=next(iter(bad))):
        sky.weather_scene(wavebands=[443.0], sun_zenith_deg=40.0, spectrum="spectrl2", clear_sky=bad)


def test_difcol_makes_it_idle(tmp_path):
    amc = copy_scene("perez_sky", tmp_path)
    toml = amc.parent / "sky.toml"
    text = toml.read_text().replace("[perez]\n", '[perez]\nspectrum = "spectrl2"\n')
    toml.write_text(text + "\n[clear_sky]\naod_500nm = 0.2\n")
    notes = sky.read_scene(amc).notes
    assert any("[clear_sky] is not used" in note for note in notes)
    assert any("spectrum is not used" in note for note in notes)


@pytest.mark.parametrize(("zenith", "percent"), [(80.0, 1.0), (85.0, -4.0), (88.0, -25.0), (89.0, -50.0)])
def test_a_low_sun_is_warned_of(zenith, percent):
    """Against an atmosphere of molecules alone, over black ground: all light over the sun's above the air."""
    light = {"sun_zenith_deg": zenith, "spectrum": "spectrl2", "sky": "harrison-coombes"}
    air = sky.ClearSky(aod_500nm=0.0, water_cm=0.0, ozone_cm=0.0)
    nm = [443.0, 555.0]
    if zenith > 85:
        with pytest.warns(sky.ModelLimitWarning, match="cloudless sky goes to 0 at the horizon"):
            scene = sky.weather_scene(wavebands=nm, clear_sky=air, **light)
    else:
        scene = sky.weather_scene(wavebands=nm, clear_sky=air, **light)
    solved = sky.solve_atmosphere(
        "inputs/atmosphere/molecules_only.atmo", wavelength_nm=nm, sun_zenith_deg=zenith, sky_zenith_deg=[0.0],
        azimuth_from_sun_deg=[0.0], method="mc", paths=2000,
    )  # fmt: skip
    outside = np.array([1.61523984, 1.82853695]) / np.array([1.8874, 1.879])  # of the description, of SPCTRL2
    ours = scene.irradiance.of_component.sum(axis=1) * outside
    found = 100.0 * (ours / (solved.direct_irradiance + solved.diffuse_irradiance) - 1.0)
    assert found == pytest.approx([percent] * 2, abs=3.0)
