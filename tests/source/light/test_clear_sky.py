"""A cloudless sky without a measurement: the wiring of SPCTRL2, the day, and every entrance."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.options import CLEAR_SKY
from aomc_sky.source.light.spectral_split import AEROSOLS
from tests.support.scenes import copy_scene

pvlib = pytest.importorskip("pvlib")

NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0, 765.0, 865.0])
AIR = {"aod_500nm": 0.23, "water_cm": 2.0, "ozone_cm": 0.25, "pressure_hPa": 980.0}


def spectrl2(sun_zenith_deg, day, air, **aerosol):
    """Beam and sky on a horizontal plane by pvlib itself. [W m-2 nm-1]"""
    zenith = np.array([sun_zenith_deg])
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=0.06,
        surface_pressure=100 * air["pressure_hPa"], precipitable_water=air["water_cm"], ozone=air["ozone_cm"],
        relative_airmass=pvlib.atmosphere.get_relative_airmass(sun_zenith_deg, model="kastenyoung1989"),
        aerosol_turbidity_500nm=air["aod_500nm"], dayofyear=day, **aerosol,
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


def test_every_entrance_has_it(tmp_path):
    """The same light and aerosol by the command line alone, by options beside amc.inp, by sky.toml and in Python."""
    amc = copy_scene("perez_sky", tmp_path)
    (amc.parent / "difcol.inp").unlink()
    (amc.parent / "sky.toml").unlink()
    sun = ["--sun-zenith", "40", "--sun-azimuth", "10"]
    air = ["--spectrum", "spectrl2", "--aod", "0.3", "--aerosol", "maritime", "--sky", "harrison-coombes"]
    nm = [f"{one:g}" for one in sky.read_scene(amc, perez={"spectrum": "spectrl2"}).wavebands.wavelength_nm]
    common = ["--iterations", "1000", "--format", "none", "-q"]
    assert main(["run", *sun, *air, "--wavelengths", *nm, *common, "--out", str(tmp_path / "alone")]) == 0
    assert main(["run", str(amc), *sun, *air, *common, "--out", str(tmp_path / "options")]) == 0
    (amc.parent / "sky.toml").write_text(
        '[perez]\nspectrum = "spectrl2"\n[clear_sky]\naod_500nm = 0.3\naerosol = "maritime"\n'
        '[sky]\nmodel = "harrison-coombes"\n[sun]\nzenith_deg = 40\nazimuth_deg = 10\n'
    )
    assert main(["run", str(amc), *common, "--out", str(tmp_path / "toml")]) == 0
    manifests = [json.loads((tmp_path / name / "manifest.json").read_text()) for name in ("alone", "options", "toml")]
    scene = sky.weather_scene(
        wavebands=list(map(float, nm)), sun_zenith_deg=40.0, sun_azimuth_deg=10.0, spectrum="spectrl2",
        sky="harrison-coombes", clear_sky=sky.ClearSky(aod_500nm=0.3, aerosol="maritime"),
    )  # fmt: skip
    for manifest in manifests:
        assert '"aerosol": "maritime"' in json.dumps(manifest)
        ed = [band["irradiance_W_m2_nm"] for band in manifest["bands"]]
        np.testing.assert_allclose(ed, scene.irradiance.of_component.sum(axis=1), rtol=1e-12)


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


def light_of(zenith, nm=NM, **air):
    """Beam and sky of a cloudless sky at the sun's mean distance. [W m-2 nm-1]"""
    light = {"sun_zenith_deg": zenith, "spectrum": "spectrl2", "sky": "harrison-coombes"}
    return sky.weather_scene(wavebands=nm, clear_sky=sky.ClearSky(**air), **light).irradiance.of_component.T


RURAL = {
    0.0: [[1.0932695924123592, 1.5202549630019242, 1.3254101382461918],
          [0.32598859758764076, 0.20230134699807598, 0.11536828175380827]],
    40.0: [[0.7309576651123914, 1.0918757584036944, 0.9748318056887335],
           [0.2923167148876086, 0.18562896159630554, 0.10727314431126643]],
}  # fmt: skip
"""Beam and sky at 412, 555 and 670 nm of release 0.4.0."""


@pytest.mark.parametrize("zenith", RURAL)
def test_rural_air_is_that_of_0_4(zenith):
    nm = [412.0, 555.0, 670.0]
    numbers = sky.Aerosol(angstrom_exponent=1.14, albedo_400nm=0.945, albedo_variation=0.095, asymmetry=0.65)
    for air in ({}, {"aerosol": "rural"}, {"aerosol": numbers}, {"pressure_hPa": 1013.25}):
        assert light_of(zenith, nm, **air).tolist() == RURAL[zenith]


DUST = {"angstrom_exponent": 0.1, "albedo_400nm": 0.9, "albedo_variation": 0.05, "asymmetry": 0.7}


@pytest.mark.parametrize(
    ("aerosol", "numbers"), [("maritime", (0.3, 0.98, 0.0, 0.75)), (sky.Aerosol(**DUST), tuple(DUST.values()))]
)
def test_an_aerosol_reaches_spectrl2(aerosol, numbers):
    names = ("alpha", "scattering_albedo_400nm", "wavelength_variation_factor", "aerosol_asymmetry_factor")
    distance = pvlib.irradiance.get_extra_radiation(200, solar_constant=1.0, method="spencer")
    expected = np.array(spectrl2(50.0, 200, AIR, **dict(zip(names, numbers, strict=True)))) / distance
    np.testing.assert_allclose(light_of(50.0, aerosol=aerosol, **AIR), expected, rtol=2e-6)
    scene = sky.weather_scene(  # the same by a mapping
        wavebands=NM, sun_zenith_deg=50.0, spectrum="spectrl2", sky="uniform", clear_sky={**AIR, "aerosol": aerosol}
    )
    np.testing.assert_array_equal(scene.irradiance.of_component.T, light_of(50.0, aerosol=aerosol, **AIR))


def test_words_of_an_aerosol_are_those_of_the_option():
    assert tuple(AEROSOLS) == CLEAR_SKY["aerosol"].words


def test_what_a_person_reads_of_the_air():
    dust = sky.Aerosol(**DUST)
    shown = {air: str(sky.ClearSky(aerosol=air)).partition(" 0.1 at 500 nm")[0] for air in ("rural", "maritime", dust)}
    assert shown == {
        "rural": "aerosol",
        "maritime": "maritime aerosol",
        dust: "aerosol (exponent 0.1, albedo 0.9 at 400 nm, its variation 0.05, asymmetry 0.7)",
    }
    light = {"wavebands": [443.0], "sun_zenith_deg": 40.0, "spectrum": "spectrl2", "sky": "uniform"}
    options = {
        air: sky.weather_scene(clear_sky=sky.ClearSky(aerosol=air), **light).options["spectrum"] for air in shown
    }
    assert "aerosol" not in options["rural"]  # manifests keep their shape
    assert (options["maritime"]["aerosol"], options[dust]["aerosol"]) == ("maritime", DUST)
    assert {one["pressure_hPa"] for one in options.values()} == {1013.25}


@pytest.mark.parametrize(
    ("air", "message"),
    [
        ({"aod_500nm": -1.0}, "aod_500nm"), ({"water_cm": float("nan")}, "water_cm"),
        ({"pressure_hPa": "high"}, "pressure_hPa"),
        ({"aerosol": "foggy"}, 'aerosol: .foggy. is not .* write "rural" or "maritime", or give an A'),
        ({"aerosol": 3}, r"aerosol: 3\.0 is not a word"), ({"aerosol": {"haze": 1}}, "aerosol has no input 'haze'"),
        ({"aerosol": {"asymmetry": 0.7}}, "angstrom_exponent, albedo_400nm and asymmetry are needed"),
        ({"aerosol": DUST | {"asymmetry": 1}}, r"asymmetry: 1\.0 is outside the range 0 to 0\.95"),
        ({"aerosol": DUST | {"albedo_400nm": "high"}}, "albedo_400nm: 'high' is not a number"),
        ({"aerosol": sky.ClearSky()}, r"aerosol must be a word or an Aerosol\(\.\.\.\), got ClearSky"),
    ],
)  # fmt: skip
def test_air_that_is_none_is_refused(air, message):
    with pytest.raises(sky.UsageError, match=message):
        sky.ClearSky(**air)
    with pytest.raises(sky.UsageError, match=message):
        sky.weather_scene(wavebands=[443.0], sun_zenith_deg=40.0, spectrum="spectrl2", sky="uniform", clear_sky=air)


@pytest.mark.parametrize(("altitude_m", "percent"), [(3000.0, -13.9), (4500.0, -19.7)])
def test_pressure_is_that_of_the_altitude(altitude_m, percent):
    """The light of a sky that keeps the pressure of the sea there is 16 and 25 % too bright."""
    air = sky.ClearSky().at(altitude_m)
    assert air.pressure_hPa == pytest.approx(pvlib.atmosphere.alt2pres(altitude_m) / 100, abs=0.005)
    above, below = (spectrl2(0.0, 200, {**AIR, "aod_500nm": 0.1, "pressure_hPa": one})[1][0]
                    for one in (air.pressure_hPa, 1013.25))  # fmt: skip
    assert 100 * (above / below - 1) == pytest.approx(percent, abs=0.3)
    found = light_of(0.0, pressure_hPa=air.pressure_hPa)[1][0] / light_of(0.0)[1][0]
    assert 100 * (found - 1) == pytest.approx(percent, abs=0.3)


def test_a_pressure_that_is_given_stays():
    assert sky.ClearSky(pressure_hPa=990).at(3000) == sky.ClearSky(pressure_hPa=990)
    assert sky.ClearSky(aerosol="maritime").at(0) == sky.ClearSky(aerosol="maritime", pressure_hPa=1013.25)
    for bad in (9001, "high", None, float("nan")):
        with pytest.raises(sky.UsageError, match="altitude_m: "):
            sky.ClearSky().at(bad)


VISIBLE_NM = [412.0, 443.0, 490.0, 555.0, 670.0]
# fmt: off
DISORT = {
    ("rural", 0.05, 30): [0.9534, 1.165, 1.284, 1.343, 1.172, 0.2953, 0.2705, 0.207, 0.1447, 0.07441],
    ("rural", 0.05, 50): [0.6074, 0.7684, 0.8747, 0.933, 0.8369, 0.2661, 0.2475, 0.1916, 0.1341, 0.06973],
    ("rural", 0.05, 70): [0.1919, 0.2736, 0.3478, 0.3963, 0.3906, 0.198, 0.1931, 0.1555, 0.1095, 0.05905],
    ("rural", 0.05, 80): [0.0331, 0.06045, 0.09678, 0.1274, 0.1523, 0.1226, 0.1292, 0.1117, 0.08022, 0.04701],
    ("rural", 0.1, 30): [0.8872, 1.09, 1.21, 1.276, 1.125, 0.3452, 0.3282, 0.265, 0.1981, 0.1123],
    ("rural", 0.1, 50): [0.5513, 0.7028, 0.8078, 0.8708, 0.7916, 0.3054, 0.2947, 0.241, 0.1807, 0.1037],
    ("rural", 0.1, 70): [0.16, 0.2314, 0.2995, 0.3481, 0.3518, 0.2161, 0.2185, 0.1857, 0.1403, 0.08397],
    ("rural", 0.1, 80): [0.02311, 0.04344, 0.07208, 0.09864, 0.1239, 0.1257, 0.1365, 0.124, 0.09554, 0.06249],
    ("rural", 0.3, 30): [0.6652, 0.8361, 0.9554, 1.04, 0.9533, 0.5025, 0.5137, 0.4563, 0.379, 0.2443],
    ("rural", 0.3, 50): [0.374, 0.4917, 0.5875, 0.6606, 0.6334, 0.4183, 0.4351, 0.3928, 0.329, 0.2166],
    ("rural", 0.3, 70): [0.07715, 0.1182, 0.1646, 0.2071, 0.2314, 0.2526, 0.2749, 0.2592, 0.2213, 0.1552],
    ("rural", 0.3, 80): [0.005497, 0.01158, 0.02218, 0.03548, 0.05429, 0.1242, 0.142, 0.1409, 0.1224, 0.09551],
    ("maritime", 0.05, 30): [0.9638, 1.172, 1.285, 1.337, 1.159, 0.2932, 0.2712, 0.2127, 0.1565, 0.0913],
    ("maritime", 0.05, 50): [0.6163, 0.7751, 0.8759, 0.9272, 0.824, 0.2653, 0.2491, 0.1976, 0.1456, 0.08592],
    ("maritime", 0.05, 70): [0.1973, 0.2781, 0.3487, 0.3916, 0.3794, 0.199, 0.1955, 0.1608, 0.1188, 0.07249],
    ("maritime", 0.05, 80): [0.03493, 0.06242, 0.09726, 0.1244, 0.1438, 0.1237, 0.1309, 0.1148, 0.0857, 0.056],
    ("maritime", 0.1, 30): [0.9066, 1.104, 1.212, 1.264, 1.099, 0.3423, 0.3304, 0.2764, 0.2211, 0.1448],
    ("maritime", 0.1, 50): [0.5676, 0.715, 0.81, 0.8598, 0.7674, 0.3053, 0.2989, 0.253, 0.2027, 0.1345],
    ("maritime", 0.1, 70): [0.1689, 0.239, 0.301, 0.3399, 0.3319, 0.219, 0.2238, 0.1959, 0.1573, 0.1081],
    ("maritime", 0.1, 80): [0.02574, 0.0463, 0.0728, 0.09412, 0.1104, 0.1285, 0.1401, 0.1297, 0.1047, 0.0771],
    ("maritime", 0.3, 30): [0.7098, 0.8689, 0.9611, 1.011, 0.8896, 0.5069, 0.5297, 0.4923, 0.4413, 0.3286],
    ("maritime", 0.3, 50): [0.4081, 0.5178, 0.5923, 0.636, 0.5771, 0.4299, 0.4556, 0.4287, 0.3856, 0.2917],
    ("maritime", 0.3, 70): [0.09091, 0.1303, 0.1671, 0.1928, 0.1942, 0.2677, 0.2943, 0.2854, 0.2577, 0.2036],
    ("maritime", 0.3, 80): [0.007596, 0.01403, 0.02285, 0.03083, 0.03845, 0.1335, 0.1529, 0.1533, 0.1373, 0.1162],
}
# fmt: on
"""Aerosol, its optical depth at 500 nm and the sun's zenith angle -> beam at `VISIBLE_NM`, and sky. [W m-2 nm-1]

Multiple scattering by PythonicDISORT 1.8, with the sun and the gases of SPCTRL2: python bench/clear_sky.py literals.
"""


def errors(aerosol, depth, zenith, air):
    """Direct, diffuse and global light less that of DISORT for an `air`, in per cent."""
    ours = light_of(zenith, VISIBLE_NM, aod_500nm=depth, aerosol=aerosol)
    exact = np.reshape(DISORT[air, depth, zenith], (2, -1))
    return [100 * (one / other - 1) for one, other in zip((*ours, ours.sum(0)), (*exact, exact.sum(0)), strict=True)]


@pytest.mark.parametrize(("aerosol", "depth", "zenith"), DISORT)
def test_errors_are_those_of_the_docstring(aerosol, depth, zenith):
    direct, diffuse, both = errors(aerosol, depth, zenith, aerosol)
    lowest, highest = {"rural": (-15, 1), "maritime": (-16, 0)}[aerosol]
    most = 0.5
    if zenith == 80:
        lowest, highest, most = -13, 1, 11
    rounding = 0.5  # of the sentences
    assert np.abs(direct).max() < most + 0.1
    assert lowest - rounding < diffuse.min()
    assert diffuse.max() < highest + rounding
    assert -12 - rounding < both.min()
    assert both.max() < 0.5


@pytest.mark.parametrize("depth", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("zenith", [30, 50, 70])
def test_rural_air_at_sea_has_too_little_red_sky(depth, zenith):
    _, diffuse, _ = errors("rural", depth, zenith, "maritime")
    assert -26.5 < diffuse[-1] < -19.5
    _, diffuse, _ = errors("maritime", depth, zenith, "maritime")
    assert -5.5 < diffuse[-1] < 0.1
