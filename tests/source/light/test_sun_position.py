"""The sun's place: a published reference, compass points in our convention, and what it gives in space."""

import datetime

import numpy as np
import pytest

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.coefficients import EXTRATERRESTRIAL_NORMAL
from aomc_sky.source.light.sun_position import sun_position
from tests.reference.refraction import SCALE_M, beam

pvlib = pytest.importorskip("pvlib")

MORNING = np.datetime64("2026-06-21T02:40:00") + np.arange(0, 345, 5) * np.timedelta64(1, "m")
"""The sun at Heligoland, from below the horizon to 40 degrees above it."""
HELIGOLAND = (54.2, 7.9)


def air(height_m):
    """Of optical depth 1."""
    return float(np.exp(-height_m / SCALE_M)) / SCALE_M


@pytest.mark.parametrize("altitude", [2.0, 5.0, 10.0, 20.0, 45.0])
def test_the_sun_is_seen_where_rays_through_shells_come_from(altitude):
    # the formula has 12 degrees C where the shells have 15 (1 %), and is high by 5 % at 20 degrees and up
    sun = sun_position(MORNING if altitude < 30 else MORNING + np.timedelta64(3, "h"), *HELIGOLAND)
    lift = np.interp(90.0 - altitude, sun.zenith_deg[::-1], (sun.zenith_deg - sun.apparent_zenith_deg)[::-1])
    ray = beam(altitude, air)
    assert lift == pytest.approx(ray.apparent_deg - altitude, rel=0.07)


def test_far_below_the_horizon_both_zenith_angles_are_one():
    sun = sun_position(np.datetime64("2026-06-21T00:00:00"), *HELIGOLAND)
    assert sun.zenith_deg > 95
    assert sun.apparent_zenith_deg == sun.zenith_deg


@pytest.mark.parametrize(("ours", "theirs"), [("kasten-young-1989", "kastenyoung1989"), ("kasten-1966", "kasten1966")])
def test_air_masses_are_those_of_pvlib_for_the_sun_as_it_is_seen(ours, theirs):
    sun = sun_position(MORNING, *HELIGOLAND)
    up = sun.apparent_zenith_deg < 90
    assert 20 < up.sum() < up.size
    seen = sun.apparent_zenith_deg[up]
    expected = pvlib.atmosphere.get_relative_airmass(seen, theirs)
    assert perez.relative_air_mass(np.deg2rad(seen), formula=ours) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(("altitude", "wrong_percent"), [(2.0, 7.7), (5.0, 2.6), (10.0, 0.8), (30.0, 0.08)])
def test_the_formula_follows_the_bent_ray_and_not_the_true_zenith_angle(altitude, wrong_percent):
    ray = beam(altitude, air)
    seen, true = (perez.relative_air_mass(np.deg2rad(90.0 - a)) for a in (ray.apparent_deg, altitude))
    assert seen == pytest.approx(
        ray.depth_bent, rel=0.02
    )  # the formula is of a standard atmosphere, whose air is lower
    assert 100 * (true / seen - 1) == pytest.approx(wrong_percent, rel=0.03)
    assert abs(true - ray.depth_bent) > abs(seen - ray.depth_bent)


def test_the_example_of_reda_and_andreas():
    # 17 October 2003, 12:30:30 at UTC-7: azimuth 194.34024 from north clockwise, zenith angle 50.11162 with refraction
    # of about 0.014 degrees, at 1830 m
    sun = sun_position(np.datetime64("2003-10-17T19:30:30"), 39.742476, -105.1786)
    assert float(sun.azimuth_deg) == pytest.approx(90 + 360 - 194.34024, abs=2e-4)
    assert float(sun.zenith_deg) == pytest.approx(50.11162 + 0.0144, abs=2e-3)


def test_the_earth_is_nearest_in_january():
    times = np.datetime64("2023-01-01") + np.arange(365).astype("m8[D]")
    given = sun_position(times, 0.0, 0.0).extraterrestrial_normal
    assert int(given.argmax()) in range(10)
    assert int(given.argmin()) in range(180, 192)
    angle = 2 * np.pi * np.arange(365) / 365  # the series of Spencer (1971)
    series = 1.00011 + 0.034221 * np.cos(angle) + 0.00128 * np.sin(angle)
    series += 0.000719 * np.cos(2 * angle) + 7.7e-05 * np.sin(2 * angle)
    assert given == pytest.approx(EXTRATERRESTRIAL_NORMAL * series, rel=1e-12)


@pytest.mark.parametrize(
    ("time", "latitude", "longitude"),
    [
        ("2023-01-01", 91.0, 0.0), ("2023-01-01", float("nan"), 0.0), ("2023-01-01", 0.0, 181.0), ("NaT", 0.0, 0.0),
        ("1799-12-31T23:59:59", 0.0, 0.0), ("2200-01-01", 0.0, 0.0),
    ],
)  # fmt: skip
def test_places_and_times_that_do_not_exist(time, latitude, longitude):
    with pytest.raises(UsageError):
        sun_position(np.datetime64(time), latitude, longitude)


@pytest.mark.parametrize("place", [("43.4N", 7.9), (43.4, "7,9"), ([43.4], 7.9), (None, 7.9)])
def test_a_place_is_two_numbers(place):
    with pytest.raises(UsageError, match="must be a number of degrees, north and east positive, got"):
        sun_position("2023-06-01T10:00Z", *place)


@pytest.mark.parametrize(
    ("time", "advice"),
    [
        ("2026-06-21", "write 2026-06-21T00:00Z for UTC"),
        (datetime.datetime(2026, 6, 21, 9, 30, 5), "write 2026-06-21T09:30:05Z for UTC"),
        ("noon", "must be in ISO 8601"),
        ("2026-06-21T12:00 CEST", r"or 2026-06-21T11:30:00\+02:00"),
        ("2016-12-31T23:59:60Z", "leap second, which clocks of computers leave out; write 23:59:59"),
        (object(), "must be in ISO 8601"),
        (["2026-06-21T09:30"], "does not say its time zone"),
        ([datetime.datetime(2026, 6, 21, 9, 30)], "does not say its time zone"),
        (["2026-06-21T09:30Z", "noon"], "must be in ISO 8601"),
        (np.datetime64("NaT"), "is missing"),
        (np.array(["2026-06-21", "NaT"], "M8[s]"), "is missing"),
        (np.datetime64(10**15, "Y"), "known for the years 1800 to 2199"),  # overflows in seconds
        (3, "must be in ISO 8601"),
    ],
)
def test_a_time_that_is_not_clear_says_what_to_write(time, advice):
    with pytest.raises(UsageError, match=advice):
        sun_position(time, 43.4, 7.9)
    if advice.startswith("write"):
        assert sun_position(advice.split()[1], 43.4, 7.9).zenith_deg < 120


def test_lists_and_shapes_of_times_are_those_of_each_time():
    """Texts and datetimes in a list were taken for UTC, whatever their zone."""
    zone = datetime.timezone(datetime.timedelta(hours=2))
    moments = ["2026-06-21T11:30+02:00", datetime.datetime(2026, 6, 21, 11, 30, tzinfo=zone), "2026-06-21T09:30z"]
    found = sun_position([*moments, np.datetime64("2026-06-21T09:30")], 43.4, 7.9)
    alone = sun_position("2026-06-21T09:30Z", 43.4, 7.9)
    assert found.azimuth_deg.tolist() == [alone.azimuth_deg.item()] * 4
    assert sun_position(np.array(moments[:1]), 43.4, 7.9).zenith_deg.item() == alone.zenith_deg.item()
    times = np.datetime64("2023-06-01T10:00:00") + np.arange(6).reshape(2, 3) * np.timedelta64(1, "h")
    sun = sun_position(times, 10.0, 20.0)
    assert sun.zenith_deg.shape == sun.azimuth_deg.shape == sun.extraterrestrial_normal.shape == (2, 3)


def test_times_of_pandas_keep_their_zone_and_masked_ones_are_refused():
    pandas = pytest.importorskip("pandas")
    local = pandas.DatetimeIndex(["2026-06-21T11:30", "2026-01-21T11:30"]).tz_localize("Europe/Paris")
    found = sun_position(local, 43.4, 7.9).zenith_deg
    assert found.tolist() == sun_position(local.tz_convert("UTC").to_numpy("M8[s]"), 43.4, 7.9).zenith_deg.tolist()
    with pytest.raises(UsageError, match="of pandas do not say their time zone"):
        sun_position(local.tz_localize(None), 43.4, 7.9)
    with pytest.raises(UsageError, match="is missing"):
        sun_position(pandas.DatetimeIndex(["2026-06-21T11:30", None]).tz_localize("UTC"), 43.4, 7.9)
    times = np.ma.masked_array(np.array(["2026-06-21T12:00", "1970-01-01"], "M8[s]"), mask=[False, True])
    with pytest.raises(SceneError, match="time has masked values"):
        sun_position(times, 43.4, 7.9)


@pytest.mark.parametrize("year", [1800, 1900, 1970, 2026, 2050, 2100, 2199])
@pytest.mark.parametrize("place", [(90.0, 0.0), (-90.0, 180.0), (54.2, 7.9), (0.0, -180.0)])
def test_the_stated_accuracy_holds_in_all_years(year, place):
    """Against the algorithm with the difference of terrestrial and universal time of that year."""
    times = np.datetime64(f"{year}-01-01T00:30") + np.arange(0, 8760, 7).astype("m8[h]")
    sun = sun_position(times, *place)
    difference = pvlib.spa.calculate_deltat(year, 6)
    seconds = times.astype("M8[s]").astype(np.float64)
    _, zenith, _, _, azimuth, _ = pvlib.spa.solar_position(seconds, *place, 0.0, 1013.25, 12.0, difference, 0.5667)

    def towards(zenith_deg, azimuth_deg):
        z, a = np.deg2rad(zenith_deg), np.deg2rad(azimuth_deg)
        return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)])

    apart = np.linalg.norm(towards(sun.zenith_deg, sun.azimuth_deg) - towards(zenith, 90.0 - azimuth), axis=0)
    most = np.interp(year, [1800, 2050, 2100, 2199], [9e-4, 9e-4, 2e-3, 5e-3])
    assert np.rad2deg(apart).max() < (1e-4 if year == 2026 else most)
