"""Irradiances of many times are those of the scenes of each time; zones, nights, and inputs that change with time."""

import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import InputWarning, SceneError, UsageError
from aomc_sky.source.irradiances import Irradiances

pytest.importorskip("pvlib")
PLACE = {"latitude_deg": 54.18, "longitude_deg": 7.89}
DAY = np.arange("2026-06-21T00", "2026-06-22T00", dtype="datetime64[h]")
NM = np.array([412.0, 443.0, 555.0, 670.0])
HOUR = np.arange(24)
MU = np.maximum(np.cos(np.deg2rad(sky.sun_position(DAY, **PLACE).zenith_deg)), 0.0)
DHI, DNI = 20.0 + 90.0 * MU, np.round(700.0 * MU)
ABSOLUTE = sky.TabulatedSky(
    grid=sky.PatchGrid.regular(4, 8), wavelength_nm=NM, values=np.ones((4, 4, 8)), weighting="projected",
    irradiance_W_m2_nm=0.25,
)  # fmt: skip


def of_scenes(spectrum="spectrl2", by_time=None, **fixed):
    """Beam and sky by a scene for each hour; 0 at night."""
    found = np.zeros((2, DAY.size, NM.size))
    for k, time in enumerate(DAY):
        if sky.sun_position(time, **PLACE).apparent_zenith_deg >= 90:
            continue
        given = {name: float(values[k]) for name, values in (by_time or {}).items()}
        scene = sky.weather_scene(wavebands=NM, n_photons=1, time=time, spectrum=spectrum, **PLACE, **given, **fixed)
        for name, one in zip(scene.irradiance.component_names, scene.irradiance.of_component.T, strict=True):
            found[int(name != "direct"), k] += one
    return found


CASES = {
    "a cloudless sky": {},
    "haze at sea": {"clear_sky": sky.ClearSky(aod_500nm=0.4, aerosol="maritime"), "altitude_m": 30.0},
    "two irradiances of each hour": {"by_time": {"dni": DNI, "dhi": DHI}},
    "ghi and dhi": {"by_time": {"ghi": DHI + DNI * MU, "dhi": DHI}},
    "clearness and brightness": {"by_time": {"epsilon": 1.0 + HOUR / 6, "delta": 0.1 + HOUR / 100}},
    "an overcast sky": {"by_time": {"dni": 0.0 * DNI, "dhi": DHI}, "sky": "overcast"},
    "another sky": {"sky": "cie", "sky_options": {"type": 12}},
    "a sky in W m-2 nm-1 and the beam": {"sky": ABSOLUTE, "by_time": {"dni": DNI, "dhi": DHI}},
    "a sky in W m-2 nm-1 alone": {"sky": ABSOLUTE, "spectrum": None},
    "without the beam": {"diffuse_only": True},
    "another sun": {"by_time": {"dni": DNI, "dhi": DHI}, "extraterrestrial_normal": 1400.0},
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning", "ignore::aomc_sky.errors.InputWarning")
def test_each_hour_is_that_of_its_scene(name):
    given = dict(CASES[name])
    by_time = given.pop("by_time", {})
    found = sky.irradiances(DAY, *PLACE.values(), wavebands=NM, **by_time, **given)
    expected = of_scenes(by_time=by_time, **given)
    np.testing.assert_array_equal(found.direct_W_m2_nm, expected[0])
    np.testing.assert_array_equal(found.diffuse_W_m2_nm, expected[1])
    np.testing.assert_array_equal(found.total_W_m2_nm, expected.sum(axis=0))
    night = found.sun_zenith_deg >= 90
    assert 4 < night.sum() < 12
    assert not found.total_W_m2_nm[night].any()
    assert found.total_W_m2_nm[~night].all()


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
def test_air_that_changes_with_time():
    depths = np.linspace(0.05, 0.4, 24)
    found = sky.irradiances(DAY, *PLACE.values(), wavebands=NM, clear_sky={"aod_500nm": depths, "aerosol": "maritime"})
    air = sky.ClearSky(aod_500nm=depths[12], aerosol="maritime")
    one = sky.irradiances(DAY[12:13], *PLACE.values(), wavebands=NM, clear_sky=air)
    np.testing.assert_array_equal(found.direct_W_m2_nm[12], one.direct_W_m2_nm[0])


def test_times_say_their_zone_in_every_form():
    expected = sky.irradiances(["2026-06-21T09:30Z"], *PLACE.values(), wavebands=NM)
    for times in ("2026-06-21T11:30+02:00", np.datetime64("2026-06-21T09:30"), ["2026-06-21T09:30Z"]):
        assert sky.irradiances(times, *PLACE.values(), wavebands=NM) == expected
    pandas = pytest.importorskip("pandas")
    local = pandas.DatetimeIndex(["2026-06-21T11:30"]).tz_localize("Europe/Berlin")
    for times in (local, pandas.Series(local), list(local)):
        assert sky.irradiances(times, *PLACE.values(), wavebands=NM) == expected
    for times in (local.tz_localize(None), pandas.Series(local.tz_localize(None))):
        with pytest.raises(UsageError, match=r"do not say their time zone; write times\.tz_localize\('UTC'\)"):
            sky.irradiances(times, *PLACE.values(), wavebands=NM)


def test_parts_and_labels():
    found = sky.irradiances(DAY[10:12], *PLACE.values(), wavebands=NM)
    beam, diffuse = found
    assert beam is found.direct_W_m2_nm
    assert diffuse is found.diffuse_W_m2_nm
    with pytest.raises(ValueError, match="read-only"):
        beam[0] = 0.0
    pytest.importorskip("xarray")
    data = found.to_xarray()
    assert dict(data.sizes) == {"time": 2, "wavelength": 4}
    np.testing.assert_array_equal(data.total.sel(time="2026-06-21T11:00", wavelength=555.0), found.total_W_m2_nm[1, 2])
    assert data.direct.attrs["units"] == "W m-2 nm-1"


def test_no_times_and_nights_give_zeros_and_no_error():
    assert sky.irradiances(DAY[:0], *PLACE.values(), wavebands=NM).direct_W_m2_nm.shape == (0, 4)
    night = sky.irradiances(DAY[:2], *PLACE.values(), wavebands=NM, dni=[np.nan, -1.0], dhi=0.0)
    assert not night.total_W_m2_nm.any()
    dusk = sky.irradiances(DAY[11:12], *PLACE.values(), wavebands=NM, ghi=-2.0, dhi=0.0)
    assert not dusk.total_W_m2_nm.any()
    assert isinstance(dusk, Irradiances)


def test_light_at_night_is_a_question_of_the_zone():
    with pytest.warns(InputWarning, match=r"at 2026-06-21T00:00:00Z and once more the sun is .* below .* ghi is 700"):
        sky.irradiances(DAY[:2], *PLACE.values(), wavebands=NM, ghi=700.0, dhi=100.0)


def test_a_warning_is_given_once_and_names_its_first_time():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sky.irradiances(DAY[12:18], *PLACE.values(), wavebands=NM, dni=900.0, dhi=2.0)
    assert [str(one.message).partition(": ")[0] for one in caught] == ["at 2026-06-21T12:00:00Z and at 5 more times"]
    assert caught[0].filename == __file__


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        ({"dni": [1.0, 2.0], "dhi": 3.0}, UsageError, r"dni is one number, or one for each of 24 times; .*\(2,\)"),
        ({"dni": np.full(24, 1600.0), "dhi": 3.0}, SceneError, "at 2026-06-21T03:00:00Z: dni 1600 W m-2 is more than"),
        ({"dni": 5.0}, UsageError, "at 2026-06-21T03:00:00Z: how bright are sun and sky"),
        ({"spectrum": "flat", "dni": 500.0, "dhi": 80.0}, UsageError, "spectrum must be .*'spectrl2', got 'flat'"),
        ({"spectrum": None, "epsilon": 5.0, "delta": 0.1}, UsageError, "no irradiances in W m-2 nm-1; write"),
        ({"sky": "overast"}, UsageError, "there is no sky model 'overast'"),
        ({"clear_sky": {"aod_500nm": [0.1, 0.2]}}, UsageError, "aod_500nm is one number, or one for each of 24"),
    ],
)
def test_what_does_not_fit_says_the_time_and_what_to_write(given, error, text):
    with pytest.raises(error, match=text):
        sky.irradiances(DAY, *PLACE.values(), wavebands=NM, **given)


def test_times_are_in_one_row():
    with pytest.raises(UsageError, match=r"of shape \(n_time,\); got the shape \(2, 12\)"):
        sky.irradiances(DAY.reshape(2, 12), *PLACE.values(), wavebands=NM)
