"""A description becomes a medium, with the Moon before the sun and the glow of the ground."""

import dataclasses
import math

import numpy as np
import pytest

import aomc_sky
from aomc_sky.errors import InputFileError, InputWarning, SceneError, SourceText, UsageError
from aomc_sky.formats.sky_toml.sections import MoonDirection
from aomc_sky.skies.atmosphere.description import data
from aomc_sky.skies.atmosphere.description.medium import (
    NEGLIGIBLE_SHARE,
    MediumReport,
    glow_of_luminance,
    moon_of_direction,
    read_medium,
)
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from tests.skies.atmosphere.language.test_values import MOLECULES, OZONE, PEAKED, RAYLEIGH
from tests.support import atmospheres
from tests.support.atmospheres import molecules_only
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

AU_M = 149_597_870_700.0
GRID_NM = np.linspace(400.0, 700.0, 7)


def source(text, line=20):
    return SourceText(text=text, path="sky.atmo", line=line)


def air(**changes):
    one = data.ScattererDescription(
        name="molecules",
        line=18,
        number_density=source(MOLECULES),
        phase_function=source(RAYLEIGH, 30),
        cross_section_1um_m2=0.04022e-30,
        angstrom_exponent=4.0,
        single_scattering_albedo=np.ones(7),
    )
    return dataclasses.replace(one, **changes)


def aerosol(**changes):
    given = {
        "name": "aerosol",
        "number_density": source("return 1.03333e8*exp(-altitude/(1.2*km));", 40),
        "phase_function": source(PEAKED, 50),
        "cross_section_1um_m2": 0.042968e-12,
        "angstrom_exponent": 0.0,
    }
    return air(**(given | changes))


def ozone(**changes):
    one = data.AbsorberDescription(
        name="ozone", line=60, number_density=source(OZONE, 62), cross_section_m2=np.linspace(1e-26, 4e-25, 7)
    )
    return dataclasses.replace(one, **changes)


def description(*species, **changes):
    one = data.AtmosphereDescription(
        path="sky.atmo",
        atmosphere_height_m=120e3,
        earth_radius_m=6.371e6,
        earth_sun_distance_m=AU_M,
        earth_moon_distance_m=None,
        scattering_orders=7,
        wavelength_nm=GRID_NM,
        solar_irradiance=np.linspace(1.5, 1.9, 7),
        ground_albedo=np.linspace(0.1, 0.4, 7),
        ground_glow=None,
        glow_luminance_cd_m2=None,
        species=species,
        sizes={},
        textures_are_radiances=False,
        has_eclipsed_double_scattering_textures=True,
    )
    return dataclasses.replace(one, **changes)


def test_a_medium_is_the_one_that_was_built_by_hand():
    medium, report = read_medium(description(air(), aerosol(), ozone()))
    by_hand = atmospheres.medium_of(
        [atmospheres.molecules(GRID_NM), atmospheres.aerosol(GRID_NM), atmospheres.ozone(GRID_NM, np.zeros(7))], GRID_NM
    )
    altitude, mu = np.linspace(0.0, 120e3, 301), np.cos(np.linspace(0.0, np.pi, 181))
    for found, wanted in zip(medium.constituents, by_hand.constituents, strict=True):
        # two texts of one exponential: exponents up to 100, each rounded twice, and two exponentials of 2 ulp
        rounding = (100 * 4 + 8) * 2.0**-53
        np.testing.assert_allclose(found.number_density(altitude), wanted.number_density(altitude), rtol=rounding)
        np.testing.assert_array_equal(found.kink_altitude_m, wanted.kink_altitude_m)
        np.testing.assert_allclose(found.scattering_m2, wanted.scattering_m2, rtol=1e-15)
        if wanted.phase_function is not None:
            np.testing.assert_allclose(found.phase_function(mu, 5), wanted.phase_function(mu, 5), rtol=1e-8)
    np.testing.assert_array_equal(medium.constituents[2].absorption_m2, np.linspace(1e-26, 4e-25, 7))
    np.testing.assert_allclose(report.phase_norm["aerosol"], atmospheres.PEAK_NORM, rtol=1e-8)
    assert medium.constituents[2].phase_function is None
    assert (medium.earth_radius_m, medium.top_m, medium.n_orders) == (6.371e6, 120e3, 7)
    assert medium.sun_angular_radius_rad == 6.9635e8 / AU_M
    assert report.dropped == ()
    albedo = np.linspace(0.0, 1.0, 7)
    medium, _ = read_medium(description(air(single_scattering_albedo=albedo, angstrom_exponent=-1.5)))
    extinction = 0.04022e-30 * (GRID_NM / 1000.0) ** 1.5
    (one,) = medium.constituents
    np.testing.assert_allclose(one.scattering_m2, extinction * albedo, rtol=1e-15)
    np.testing.assert_allclose(one.scattering_m2 + one.absorption_m2, extinction, rtol=1e-15)
    medium, _ = read_medium(description(air(), aerosol(single_scattering_albedo=np.zeros(7))))
    assert [one.phase_function is None for one in medium.constituents] == [False, True]


TAKEN = [(550.0, [3]), ([700, 400, 401], [0, 6]), ([449.0], [1]), ([501.0, 500.0], [2]), ([399, 701], [0, 6])]


@pytest.mark.parametrize(("wanted", "index"), [(None, list(range(7))), *TAKEN])
def test_wavelengths_of_the_file_are_taken_once_and_rise(wanted, index):
    medium, _ = read_medium(description(air(), ozone()), wanted)
    np.testing.assert_array_equal(medium.wavelength_nm, GRID_NM[index])
    np.testing.assert_array_equal(medium.toa_irradiance, np.linspace(1.5, 1.9, 7)[index])
    np.testing.assert_array_equal(medium.ground_albedo, np.linspace(0.1, 0.4, 7)[index])
    np.testing.assert_array_equal(medium.constituents[1].absorption_m2, np.linspace(1e-26, 4e-25, 7)[index])


def test_other_wavelengths_are_interpolated():
    """Logarithms of positive spectra; a wavelength of the file is itself to the bit, one 1 nm away takes it."""
    medium, _ = read_medium(description(air(), ozone()), [475.0, 499.5, 500.0, 612.5])
    assert medium.wavelength_nm.tolist() == [475.0, 500.0, 612.5]
    sun = np.linspace(1.5, 1.9, 7)
    half, quarter = np.sqrt(sun[1] * sun[2]), np.exp(0.75 * np.log(sun[4]) + 0.25 * np.log(sun[5]))
    np.testing.assert_allclose(medium.toa_irradiance, [half, sun[2], quarter], rtol=1e-14)
    assert medium.toa_irradiance[1] == sun[2]
    ratio = medium.constituents[0].scattering_m2[0] / medium.constituents[0].scattering_m2[1]
    np.testing.assert_allclose(ratio, (475 / 500) ** -description(air()).scatterers[0].angstrom_exponent, rtol=1e-13)
    dark = dataclasses.replace(description(air()), ground_albedo=np.array([0.0, 0.0, 0.2, 0.4, 0.4, 0.4, 0.4]))
    medium, _ = read_medium(dark, [475.0, 425.0])
    np.testing.assert_allclose(medium.ground_albedo, [0.0, 0.1], atol=1e-15)
    coloured = description(air(phase_function=source("return vec4(1. + 0.*wlSetIndex)/(4*PI);")))
    read_medium(coloured, [400.0, 550.0])
    with pytest.raises(SceneError, match="reads wlSetIndex, so it is known at the wavelengths of the"):
        read_medium(coloured, 475.0)


@pytest.mark.parametrize("path", sorted((INPUTS / "atmosphere").glob("*.atmo")), ids=lambda path: path.stem)
def test_the_stated_error_of_interpolation(path):
    """A description thinned to every second wavelength against itself: optical depths, and the sun's irradiance."""
    whole = read_atmo(path)
    if whole.wavelength_nm.size < 12:
        return
    some = slice(None, None, 2)
    between = whole.wavelength_nm[1:-1:2][: whole.wavelength_nm[some].size - 1]
    species = tuple(
        dataclasses.replace(one, cross_section_m2=one.cross_section_m2[some])
        if isinstance(one, data.AbsorberDescription)
        else dataclasses.replace(one, single_scattering_albedo=one.single_scattering_albedo[some])
        for one in whole.species
    )
    spectra = {name: getattr(whole, name)[some] for name in ("wavelength_nm", "solar_irradiance", "ground_albedo")}
    glow = None if whole.ground_glow is None else whole.ground_glow[some]
    thinned = dataclasses.replace(whole, species=species, ground_glow=glow, **spectra)
    (ours, depth), (theirs, expected) = read_medium(thinned, between), read_medium(whole, between)
    total, right = (sum(report.optical_depth.values()) for report in (depth, expected))
    assert np.abs(np.exp(-total) / np.exp(-right) - 1).max() < 0.01
    assert np.abs(ours.toa_irradiance / theirs.toa_irradiance - 1).max() < 0.075


@pytest.mark.parametrize("wanted", [[], [0.0], [np.nan], [[400.0]], 398.9, [550.0, 701.1]])
def test_wavelengths_that_are_none_or_beyond_the_ends_are_refused(wanted):
    with pytest.raises(SceneError, match=r"positive numbers in nm|(398.9|701.1) nm lies beyond"):
        read_medium(description(air()), wanted)


def test_a_phase_function_sees_the_sets_of_four_of_its_file():
    """Every row is that of its own set, whichever wavelengths are asked for; the last set repeats its last one."""
    text = "return (wavelengths/100. + 10.*wlSetIndex + vec4(0, .1, .2, .3))*(1.5 + dotViewSun/1e3)/(4*PI);"
    coloured = air(phase_function=source(text))
    for wanted, rows in ((None, range(7)), ([400, 550, 600, 700], [0, 3, 4, 6]), ([650], [5])):
        with pytest.warns(InputWarning, match="was divided by it"):
            _, report = read_medium(description(coloured), wanted)
        rows = np.array(rows)
        value = 1.5 * (GRID_NM[rows] / 100.0 + 10.0 * (rows // 4) + (rows % 4) / 10.0)
        np.testing.assert_allclose(report.phase_norm["molecules"], value, rtol=1e-13)


def test_blocks_read_the_names_of_the_format():
    density = """return 1e18*(earthRadius + atmosphereHeight + moonRadius + km + dobsonUnit/1e15 - earthCenter.z
        + sunAngularRadius);"""
    phase = """vec4 x = scatteringCrossSection_molecules/scatteringCrossSection_aerosol.x;
        x += groundAlbedo + solarIrradianceAtTOA + lightPollutionRelativeRadiance; return x/x/(4*PI);"""
    odd = air(number_density=source(density), phase_function=source(phase))
    medium, report = read_medium(description(odd, aerosol()))
    value = medium.constituents[0].number_density(np.zeros(1))
    total = 2 * 6.371e6 + 120e3 + 1.7371e6 + 1000 + 2.687e5 + 6.9635e8 / AU_M
    assert value[0] / 1e18 == pytest.approx(total, rel=1e-15)
    np.testing.assert_allclose(report.phase_norm["molecules"], 1.0, rtol=1e-14)


def test_species_that_do_not_count_are_dropped_and_told():
    def share(factor):
        small = ozone(number_density=source(f"return {factor!r}*3.08458e25*exp(-altitude/(8*km));"))
        same = dataclasses.replace(small, cross_section_m2=0.04022e-30 * (GRID_NM / 1000) ** -4)
        medium, report = read_medium(description(air(), same))
        return report.dropped, len(medium.constituents)

    assert share(0.9 * NEGLIGIBLE_SHARE) == (("ozone",), 1)
    assert share(1.1 * NEGLIGIBLE_SHARE) == ((), 2)
    # one wavelength at which it counts keeps it
    sodium = np.where(np.arange(7) == 4, 1e-25, 0.0)
    assert read_medium(description(air(), ozone(cross_section_m2=sodium)))[1].dropped == ()
    assert read_medium(description(air(), ozone(cross_section_m2=sodium)), 400.0)[1].dropped == ("ozone",)
    assert read_medium(description(air(), ozone(number_density=source("return 0.;"))))[1].dropped == ("ozone",)


def test_norms_and_colours_that_are_odd_are_told():
    read_medium(description(air(phase_function=source("return vec4(1.009/(4*PI));"))))
    with pytest.warns(InputWarning, match=r'sky.atmo:33: the phase function of "molecules" has the integral 0.98 '):
        medium, _ = read_medium(description(air(phase_function=source("return vec4(0.98/(4*PI));", 33))))
    np.testing.assert_allclose(medium.constituents[0].phase_function(np.array([0.3]), 0), 1 / (4 * np.pi), rtol=1e-12)
    grey = air(phase_function_type=data.PhaseFunctionType.ACHROMATIC)
    read_medium(description(grey))
    text = "return vec4(1)*(1 + wavelengths/1e4*dotViewSun)/(4*PI);"
    with pytest.warns(InputWarning, match="is called achromatic and depends on the wavelength"):
        read_medium(description(dataclasses.replace(grey, phase_function=source(text))))
    bright = 100 * description(air()).solar_irradiance
    with pytest.warns(InputWarning, match=r"the solar irradiance at .* times that of the sun: a unit may be wrong"):
        read_medium(description(air(), solar_irradiance=bright))


def test_the_problems_of_all_blocks_come_together():
    bad = (
        air(number_density=source("return altitude - 5.;", 20), phase_function=source("return 1.;", 30)),
        aerosol(number_density=source("return dotViewSun;", 40)),
        ozone(number_density=source("return wavelengths.x;\nfloat x", 62)),
    )
    with pytest.raises(InputFileError) as caught:
        read_medium(description(*bad))
    found = [(one.line, one.field.split()[-1]) for one in caught.value.problems]
    assert found == [(20, '"molecules"'), (30, '"molecules"'), (40, '"aerosol"'), (62, '"ozone"'), (63, '"ozone"')]
    assert "a number density depends on altitude alone" in str(caught.value)


def report(**more):
    return MediumReport(optical_depth={}, phase_norm={}, dropped=(), **more)


def placed(direction, **of_report):
    """The Moon there, before a sun at 45 degrees."""
    return moon_of_direction(MoonDirection(**direction), molecules_only(550.0, 0.1), report(**of_report), 45.0, 0.0)


def test_options_win_angle_by_angle():
    assert MoonDirection(zenith_deg=50.0).angles(40.0, 90.0) == (50.0, 0.0)
    assert MoonDirection(zenith_offset_deg=-0.5, azimuth_offset_deg=0.25).angles(40.0, 90.0) == (39.5, 0.25)
    assert MoonDirection(azimuth_deg=100.0).angles(40.0, 90.0) == (40.0, 10.0)
    file = MoonDirection(zenith_offset_deg=0.1, azimuth_deg=20.0, distance_km=4e5)
    both = MoonDirection(zenith_deg=30.0, azimuth_deg=20.0, distance_km=4e5)
    assert file.under(MoonDirection(zenith_deg=30.0)) == both
    assert file.under(MoonDirection()) == file
    assert file.under(MoonDirection(azimuth_offset_deg=0.0)).azimuth_deg is None


@pytest.mark.parametrize("zenith", [0.0, 60.0, 90.0, 120.0])
def test_distance_between_the_centres_becomes_that_of_the_observer(zenith):
    moon = placed({"zenith_deg": zenith}, moon_distance_m=3.844e8)
    assert np.linalg.norm(moon.centre_m(6.371e6)) == pytest.approx(3.844e8, rel=1e-12)
    assert placed({"zenith_deg": zenith, "distance_km": 365e3}).distance_m == 3.65e8


def test_no_moon_and_no_glow_without_their_numbers():
    assert placed({}) is None
    for of_report, message in (({}, "distance of the Moon is missing"), ({"moon_distance_m": 6e6}, "inside the earth")):
        with pytest.raises(SceneError, match=message):
            placed({"zenith_deg": 1.0}, **of_report)
    spectrum = np.array([2e-5, 1e-6])
    np.testing.assert_array_equal(glow_of_luminance(0.5, report(ground_glow=spectrum), "a"), 0.5 * spectrum)
    assert glow_of_luminance(0.0, report(), "a") is None
    for bad in (-1.0, math.nan, "bright", 1.0):  # the last one without a spectrum
        with pytest.raises(SceneError):
            glow_of_luminance(bad, report(), "a")


@pytest.mark.parametrize(
    "moon", [{}, 3, {"zenith": 1.0}, {"zenith_deg": 1.0, "zenith_offset_deg": 1.0}, {"zenith_deg": 181.0}]
)
def test_wrong_moons(moon):
    with pytest.raises(UsageError, match=r"[mM]oon"):
        aomc_sky.solve_atmosphere(
            INPUTS / "light_polluted" / "air.atmo", wavelength_nm=450.0, sun_zenith_deg=40.0, sky_zenith_deg=[20.0],
            azimuth_from_sun_deg=[0.0], orders=1, moon=moon,
        )  # fmt: skip


def night_scene(folder, more):
    """The scene `eclipse` in a folder, with order 1 alone, few patches, and other lines in sky.toml."""
    folder.mkdir(exist_ok=True)
    amc = copy_scene("eclipse", folder)
    keys = 'file = "air.atmo"\norders = 1\nzenith_bins = 6\nazimuth_bins = 12\n'
    (amc.parent / "sky.toml").write_text(f"[atmosphere]\n{keys}{more}")
    return amc


SUN = "[sun]\nzenith_deg = 55\nazimuth_deg = 90\n"


def test_a_scene_says_that_the_moon_hides_nothing(tmp_path):
    scene = aomc_sky.read_scene(night_scene(tmp_path, f"moon_zenith_deg = 20\n{SUN}"))
    assert any("hides no part" in note for note in scene.notes)
    assert scene.options["atmosphere"]["eclipse"] is None


@pytest.mark.slow
def test_an_eclipse_of_the_file_is_that_of_the_options(tmp_path):
    moon = "moon_zenith_offset_deg = 0.1\nmoon_azimuth_deg = 90.2\n"
    file = aomc_sky.read_scene(night_scene(tmp_path / "a", moon + SUN))
    given = {"moon_zenith_deg": 55.1, "moon_azimuth_offset_deg": 0.2}
    clear = night_scene(tmp_path / "b", SUN)
    options, whole = aomc_sky.read_scene(clear, atmosphere=given), aomc_sky.read_scene(clear)
    for one, other in zip(file.components, options.components, strict=True):
        np.testing.assert_allclose(one.mass, other.mass, rtol=1e-6)
    share = file.options["atmosphere"]["eclipse"]["visible_share"]
    assert 0.05 < share < 0.95
    np.testing.assert_allclose(file.components[0].strength, share * whole.components[0].strength, rtol=1e-13)
    sky = file.components[1].mass_of(0).reshape(6, 12)
    assert np.abs(sky[:, 2] / sky[:, 3] - 1.0).max() > 1e-3  # on both sides of the sun, which stands between them
    plain = whole.components[1].mass_of(0).reshape(6, 12)
    np.testing.assert_allclose(plain[:, 2], plain[:, 3], rtol=1e-12)
