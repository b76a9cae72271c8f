"""Warnings of light that contradicts what was stated: planted defects are found, and right statements are silent."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.directions import to_enu_azimuth_deg
from aomc_sky.formats.azimuth import WORDS
from aomc_sky.skies.witnesses import brightest_note, warn_of_light
from tests.support.shared import DATA

OURS, NORTH = "counterclockwise from east", "clockwise from north"
RINGS, COLUMNS = np.arange(2.5, 90.0, 5.0), np.arange(0.0, 360.0, 10.0)
ZENITH, AZIMUTH = (one.ravel() for one in np.meshgrid(RINGS, COLUMNS, indexing="ij"))
ANGLES, SUN = np.deg2rad([ZENITH, AZIMUTH]), (40.0, 10.0)
POINTS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")
RADIANCES = st.one_of(st.sampled_from([0.0, 1.0, 1e300, 5e-324, np.nan]), st.floats(0.0, 1e6))
PLACES = st.floats(2.0, 88.0), st.floats(0.0, 360.0)


def clear(sun=SUN, zenith=ZENITH, azimuth=AZIMUTH):
    model = sky.PerezSky(sun_zenith_deg=sun[0], sun_azimuth_deg=sun[1], epsilon=5.0, delta=0.2)
    return model.radiance(np.deg2rad(zenith), np.deg2rad(azimuth), 550.0)


def warned_by(run, *what, **how):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run(*what, **how)
    assert all(one.category is sky.InputWarning and " nan" not in str(one.message) for one in found)
    return " ".join(str(one.message) for one in found)


def said(radiance, zenith=ZENITH, azimuth=AZIMUTH, sun=SUN, words=OURS, **stokes):
    return warned_by(warn_of_light, radiance, zenith, azimuth, sun_deg=sun, convention=WORDS[words], **stokes)


def in_file(azimuth, words):
    return WORDS[words].value[1] * (azimuth - to_enu_azimuth_deg(0.0, WORDS[words], SUN[1])) % 360.0


def field_of(words, light=None, zenith=RINGS, azimuth=COLUMNS, **stokes):
    xarray = pytest.importorskip("xarray")
    parts, shape = {"radiance": clear() if light is None else light, **stokes}, (zenith.size, azimuth.size)
    made = xarray.Dataset(coords={"zenith": zenith, "azimuth": azimuth})
    made.zenith.attrs, made.azimuth.attrs = {"units": "deg"}, {"units": "deg", "azimuth_convention": words}
    unit = {"units": "W m-2 nm-1 sr-1"}
    return made.assign({name: (("zenith", "azimuth"), np.reshape(part, shape), unit) for name, part in parts.items()})


@pytest.mark.parametrize("true", WORDS)
def test_a_wrong_convention_is_found_and_both_readings_are_named(true):
    for stated in WORDS:
        wrong, moved = (to_enu_azimuth_deg(in_file(one, true), WORDS[stated], SUN[1]) for one in (AZIMUTH, SUN[1]))
        text = said(clear(), azimuth=wrong, words=stated)
        assert bool(text) == (np.cos(np.deg2rad(moved - SUN[1])) < 0.9)
        assert not text or true in text.partition("and the sun is in the east, at 40; with azimuths")[2]


@pytest.mark.parametrize("words", [NORTH, OURS])
def test_points_tables_and_fields_have_the_witness(words, tmp_path):
    numbers, sun = in_file(AZIMUTH, NORTH), {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 10.0}
    head = f"# azimuth: {words}\n# radiance unit: relative\nzenith_deg,azimuth_deg,radiance"
    np.savetxt(tmp_path / "sky.csv", np.c_[ZENITH, numbers, clear()], delimiter=",", header=head, comments="")
    turned = to_enu_azimuth_deg(numbers, WORDS[words])
    points = sky.RadianceField.from_points(ZENITH, turned, clear(), convention=WORDS[words], **sun)
    for text in (
        warned_by(points.lower, 550.0),
        warned_by(sky.read_radiance_csv(tmp_path / "sky.csv", **sun).lower, 550.0),
        warned_by(sky.TabulatedSky.from_xarray, field_of(words, azimuth=numbers[: COLUMNS.size]), **sun),
    ):
        assert (text == "") == (words == NORTH)
        assert text == "" or "the sun is in the east, at 40; with azimuths clockwise from north" in text


@pytest.mark.parametrize("zenith", [20.0, 30.0, 60.0, 75.0])
def test_elevations_as_zenith_angles(zenith):
    """Not with a sun near 45 degrees: there the brightest sky is at the sun either way."""
    sun = (zenith, 200.0)
    assert said(clear(sun), sun=sun) == said(clear((45.0, 0.0)), 90.0 - ZENITH, sun=(45.0, 0.0)) == ""
    field, how = field_of(OURS, clear(sun), 90.0 - RINGS), {"sun_zenith_deg": zenith, "sun_azimuth_deg": 200.0}
    assert "(--coordinate elevation=NAME)" in warned_by(sky.TabulatedSky.from_xarray, field, **how)
    ring = np.full(COLUMNS.size, zenith)  # says nothing of what is above
    assert said(clear(sun, ring, COLUMNS), 90.0 - ring, COLUMNS, sun) == ""


@pytest.mark.parametrize(("signs", "name"), [((1, 1), ""), ((-1, 1), "Q"), ((1, -1), "U"), ((-1, -1), "Q and U")])
def test_signs_of_neutral_points_and_of_a_vector_code(signs, name):
    """Light along the meridian plane, and light that air scattered many times; U of the code has another sign."""
    for sun in ((20.0, 50.0), (45.0, 150.0), (80.0, 250.0)):
        how = {"sun_zenith_rad": np.deg2rad(sun[0]), "sun_azimuth_rad": np.deg2rad(sun[1])}
        q, u = sky.RayleighPattern(max_degree=0.3).stokes(*ANGLES, **how) * clear(sun)
        text = said(clear(sun), sun=sun, values_q=signs[0] * (q + 0.05 * clear(sun)), values_u=signs[1] * u)
        assert text.partition(":")[0] == name
    modes = np.genfromtxt(DATA / "polarised/rayleigh.csv", delimiter=",", names=True)
    even, odd = np.cos(np.deg2rad(np.outer(range(3), COLUMNS))), np.sin(np.deg2rad(np.outer((1, 2), COLUMNS)))
    i, q = (np.stack([modes[f"{part}{k}"] for k in range(3)], axis=1) @ even for part in "IQ")
    u = np.stack([modes["U1"], modes["U2"]], axis=1) @ odd
    field = field_of("counterclockwise from the sun", i, modes["zenith_deg"], radiance_q=q, radiance_u=u)
    how = {"sun_zenith_deg": 78.46, "sun_azimuth_deg": 35.0, "stokes_signs": (signs[0], -signs[1])}
    assert warned_by(sky.TabulatedSky.from_xarray, field, **how).partition(":")[0] == name


@pytest.mark.parametrize("shift", [0.0, 80.0, 180.0])
def test_skies_that_say_nothing_are_silent(shift):
    turned, few, pixel = AZIMUTH + shift, slice(0, 19 * 34, 34), np.where(np.arange(ZENITH.size) == 100, 50.0, 1.0)
    dim = 1.0 + 0.4 * (clear() > np.quantile(clear(), 0.9))  # below the contrast of 1.5
    for radiance in (dim, np.ones(ZENITH.size), np.zeros(ZENITH.size), pixel, 1e-300 * pixel, 1.0 + RINGS.repeat(36)):
        assert said(radiance, azimuth=turned) == ""
    assert said(clear((0.0, 0.0)), azimuth=turned, sun=(0.0, 0.0)) == said(clear()[few], ZENITH[few], turned[few]) == ""
    assert said(clear((85.0, 10.0)), azimuth=turned, sun=(90.5, 10.0)) == ""
    assert said(clear(), azimuth=turned, sun=(None, 10.0)) == said(clear(), azimuth=turned, sun=(40.0, None)) == ""
    dark = np.where(np.arange(ZENITH.size) % 5 > 0, clear(), 0.0)  # nothing was seen there
    assert bool(said(dark, azimuth=turned)) == (shift > 0.0)
    for k in range(20):  # overcast and noisy
        rng = np.random.default_rng(k)
        (zenith, azimuth), noise = rng.uniform(0.0, [[85.0], [360.0]], (2, 60)), rng.normal(1.0, 0.05, 60)
        assert said((1.0 + 2.0 * np.cos(np.deg2rad(zenith))) * noise, zenith, azimuth, (3.0 * k + 20.0, shift)) == ""


@given(st.lists(st.tuples(RADIANCES, *PLACES), min_size=1, max_size=60), st.tuples(*PLACES), st.sampled_from([*WORDS]))
def test_no_radiances_do_harm_and_right_skies_are_silent(points, sun, words):
    """No NaN, no warning of numpy; silent are fewer than 12 directions, an even sky, a clear one, and a ring of it."""
    radiance, *angles = np.array(points).T
    assert not said(radiance, *angles, sun, words, values_q=0.5 * radiance, values_u=-radiance) or len(points) >= 12
    assert said(np.ones(len(points)), *angles, sun, words) == said(clear(sun), sun=sun) == ""
    ring = np.full(COLUMNS.size, angles[0][0]), COLUMNS
    assert said(clear(sun, *ring), *ring, sun) == ""


@pytest.mark.parametrize(("azimuth", "word"), [(45.0 * k + d, p) for k, p in enumerate(POINTS) for d in (-22, 22)])
def test_the_line_of_the_brightest_sky(azimuth, word):
    two = np.array([1.0, 2.0]), np.array([10.0, 38.04]), np.array([0.0, azimuth])
    place = f"brightest sky: zenith angle 38, azimuth {azimuth % 360:g} ({word})"
    assert brightest_note(*two, 0.5, 2.0, 412.0) == f"{place}; Ed 1 W m-2 nm-1 at 412 nm"
    assert brightest_note(*two, 0.5, 0.0, None) == f"{place}; Ed 0.5 (relative)"


def test_irradiance_of_a_uniform_sky_is_pi_times_its_radiance():
    even, end = np.full(ZENITH.size, 0.2), f"; Ed {0.2 * np.pi:.4g} W m-2 nm-1"
    points = sky.RadianceField.from_points(ZENITH, AZIMUTH, even, is_absolute=True)
    for notes in (sky.TabulatedSky.from_xarray(field_of(OURS, even)).remarks, points.notes(550.0)):
        assert [one.endswith(end) for one in notes if "brightest sky: " in one] == [True]
