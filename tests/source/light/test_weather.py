"""What a time and a place, or an hour of a weather file, say of sun and sky."""

from __future__ import annotations

import datetime
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats.weather import read_weather
from aomc_sky.source.light.sun_position import sun_position, utc
from aomc_sky.source.light.weather import weather_of
from tests.support.scenes import coarse_atmosphere
from tests.support.shared import DATA, INPUTS

pvlib = pytest.importorskip("pvlib")

EPW = DATA / "weather" / "good" / "invented.epw"
PLACE = {"time": "2026-06-21T09:30:00Z", "latitude_deg": 54.2, "longitude_deg": 7.9}


def changed(tmp_path: Path, old: str, new: str) -> Path:
    path = tmp_path / "changed.epw"
    text = EPW.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    return path


def test_one_moment_in_every_form() -> None:
    zone = datetime.timezone(datetime.timedelta(hours=2))
    forms = (
        "2026-06-21T09:30:00Z",
        "2026-06-21T11:30+02:00",
        datetime.datetime(2026, 6, 21, 11, 30, tzinfo=zone),
        np.datetime64("2026-06-21T09:30:00.0"),
    )
    assert {str(utc(form)) for form in forms} == {"2026-06-21T09:30:00"}
    one = sun_position(forms[0], 54.2, 7.9)
    for form in forms[1:]:
        assert sun_position(form, 54.2, 7.9).zenith_deg == one.zenith_deg


@pytest.mark.parametrize("time", ["2026-06-21T09:30", datetime.datetime(2026, 6, 21), "noon", 12])
def test_a_time_without_zone_is_refused(time: Any) -> None:
    with pytest.raises(sky.UsageError, match=r"time zone|ISO 8601"):
        weather_of({**PLACE, "time": time})


def test_the_sun_is_that_of_pvlib_at_its_height() -> None:
    index = pvlib.solarposition.get_solarposition(PLACE["time"], 54.2, 7.9, altitude=2000.0, temperature=12.0).iloc[0]
    found = weather_of({**PLACE, "altitude_m": 2000.0})
    assert found is not None
    assert found.sun_zenith_deg == pytest.approx(index.apparent_zenith, abs=1e-9)
    assert found.true_zenith_deg == pytest.approx(index.zenith, abs=1e-9)
    assert found.sun_azimuth_deg == pytest.approx((90 - index.azimuth) % 360, abs=1e-9)
    sea = weather_of(PLACE)
    assert sea is not None
    assert 0 < found.sun_zenith_deg - sea.sun_zenith_deg < 0.01  # thinner air lifts the sun less
    assert "altitude_m" not in sea.source


def test_nothing_given_is_no_weather() -> None:
    assert weather_of(None) is None
    assert weather_of({"time": None, "row": None}) is None


def test_a_night_names_the_nearest_row_with_a_sun() -> None:
    with pytest.raises(sky.SceneError, match=r"epw:9: the sun is 14\.0\d degrees below .*; the nearest row .* is 5$"):
        weather_of({"epw": EPW, "row": 1})
    weather_of({"epw": EPW, "row": 5})
    with pytest.raises(sky.SceneError, match="nearest row with a sun is 21"):
        weather_of({"epw": EPW, "row": 24})


@pytest.mark.parametrize("lost", ["ghi", "dni", "dhi"])
def test_a_row_that_lacks_one_is_closed(tmp_path: Path, lost: str) -> None:
    given, row = {"ghi": 498.0, "dni": 789.0, "dhi": 96.0}, 8
    new = "".join(f",{9999 if name == lost else value:.0f}" for name, value in given.items())
    path = changed(tmp_path, ",498,789,96,", f"{new},")
    found = weather_of({"epw": path, "row": row})
    assert found is not None
    cosine = math.cos(math.radians(found.sun_zenith_deg))
    assert found.irradiances["dhi"] == pytest.approx(given["dhi"], abs=1.5)
    assert found.irradiances["dni"] == pytest.approx(given["dni"], abs=1.5 / cosine)
    if lost != "ghi":
        assert found.irradiances["dhi"] + found.irradiances["dni"] * cosine == pytest.approx(given["ghi"], rel=1e-14)


def test_rows_that_say_too_little_or_too_much(tmp_path: Path) -> None:
    for new, words in (
        (",9999,789,9999,", "row 8 has only DNI"),
        (",9999,9999,9999,", "row 8 has none"),
        (",98,9999,498,", r"epw:16: dhi 498 W m-2 is more than ghi 98"),
        (",1900,789,1800,", "epw:16: dhi 1800 W m-2 is more than any sky gives"),
    ):
        path = changed(tmp_path, ",498,789,96,", new)
        with pytest.raises(sky.SceneError, match=words):
            weather_of({"epw": path, "row": 8})
    path = changed(tmp_path, ",498,789,96,", ",300,789,96,")
    with pytest.warns(sky.InputWarning, match=r"epw:16: ghi 300 is not dhi 96 \+ dni 789 cos Z = 4.* of the hour are"):
        found = weather_of({"epw": path, "row": 8})
    assert found is not None
    assert found.irradiances == {"dni": 789.0, "dhi": 96.0}


def test_a_scene_of_an_hour() -> None:
    table = read_weather(EPW, "epw")
    with pytest.warns(sky.InputWarning, match=r"difcol.inp shares the photons, 0.8\d+ of them direct"):
        scene = sky.read_scene(INPUTS / "perez_sky", weather={"epw": EPW, "row": 12})
    sun, perez = scene.options["sun"], scene.options["perez"]
    position = sun_position(table.midpoint[11], table.latitude_deg, table.longitude_deg)
    assert sun["zenith_deg"] == round(float(position.apparent_zenith_deg), 9)
    assert sun["from"] == "invented.epw, row 12"
    assert perez["from"] == "dni 496 and dhi 281 W m-2 (invented.epw, row 12)"
    assert perez["extraterrestrial_normal"] == round(float(position.extraterrestrial_normal), 6)
    assert scene.options["weather"]["row"] == 12
    assert scene.input_files["weather"] == str(EPW)
    assert "not at 32.4 and 121.25 as in sky.toml" in scene.notes[0]
    assert scene.notes[1] == "invented.epw, row 12: its irradiances take the place of [perez] in sky.toml"
    by_hand = sky.read_scene(
        INPUTS / "perez_sky",
        perez={"dni": 496.0, "dhi": 281.0, "extraterrestrial_normal": perez["extraterrestrial_normal"]},
        sun={"zenith_deg": sun["zenith_deg"], "azimuth_deg": sun["azimuth_deg"]},
    )
    assert scene.source(seed=3).plan.sha256 == by_hand.source(seed=3).plan.sha256


def test_a_scene_of_a_time_and_a_place() -> None:
    scene = sky.read_scene(INPUTS / "perez_sky", weather=PLACE, perez={"ghi": 700.0, "dhi": 120.0})
    assert scene.options["weather"]["time"] == "2026-06-21T09:30:00Z"
    assert scene.options["perez"]["from"] == "ghi 700 and dhi 120 W m-2 (options)"
    of_file = sky.read_scene(INPUTS / "perez_sky", weather=PLACE)  # the sun alone
    assert of_file.options["perez"]["from"].endswith("(sky.toml)")
    assert of_file.options["sun"]["zenith_deg"] == scene.options["sun"]["zenith_deg"]
    assert "weather" not in sky.read_scene(INPUTS / "perez_sky").options


def test_rays_of_a_description_come_from_the_true_sun(tmp_path: Path) -> None:
    night = {**PLACE, "time": "2026-06-21T02:40:00Z"}
    found = weather_of(night)
    assert found is not None
    with pytest.raises(sky.SceneError, match="degrees below the horizon there; take an hour of the day"):
        sky.read_scene(INPUTS / "perez_sky", weather=night)
    scene = sky.read_scene(coarse_atmosphere(tmp_path), weather=PLACE)
    assert scene.options["sun"]["zenith_deg"] == scene.options["weather"]["true_zenith_deg"]


@pytest.mark.parametrize(("day", "factor"), [("2026-01-03", 1.0351), ("2026-07-04", 0.9666)])
def test_the_sun_of_a_description_has_its_distance_of_the_day(day: str, factor: float, tmp_path: Path) -> None:
    """1/d^2 with d = 0.98330 and 1.01663 AU, by the algorithm of Reda and Andreas in pvlib: 1.0343, 0.9675."""
    place = {**PLACE, "time": f"{day}T12:00:00Z"}
    amc = coarse_atmosphere(tmp_path)
    dated = sky.read_scene(amc, weather=place)
    sun = {"zenith_deg": dated.options["sun"]["zenith_deg"], "azimuth_deg": dated.options["sun"]["azimuth_deg"]}
    undated = sky.read_scene(amc, sun=sun)
    assert dated.irradiance is not None
    assert undated.irradiance is not None
    ratio = dated.irradiance.of_component / undated.irradiance.of_component
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-9)
    assert ratio[0, 0] == pytest.approx(factor, abs=2e-4)  # Spencer's series is up to 1e-3 off
    assert ratio[0, 0] == pytest.approx({"2026-01-03": 1 / 0.98330**2, "2026-07-04": 1 / 1.01663**2}[day], abs=1.2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"weather": {"epw": EPW, "row": 12}, "perez": {"dni": 1.0, "dhi": 1.0}},
            r'perez\["dni"\] contradicts weather\["epw"\]',
        ),
        (
            {"weather": {"epw": EPW, "row": 12}, "perez": dict.fromkeys("abcde", 1.0)},
            r'perez\["a"\] to perez\["e"\] contradicts',
        ),
        (
            {"weather": {"epw": EPW, "row": 12}, "sun": {"zenith_deg": 1.0}},
            r'sun\["zenith_deg"\] contradicts weather\["epw"\]',
        ),
        ({"weather": PLACE, "sun": {"azimuth_deg": 1.0}}, r'weather\["time"\] says where the sun is'),
        ({"weather": PLACE, "compat": "aomc"}, r'--compat aomc does not use weather\["time"\]'),
        (
            {"weather": {"time": PLACE["time"]}},
            r'weather\["time"\] needs weather\["latitude_deg"\] and weather\["longitude_deg"\]',
        ),
    ],
)
def test_what_a_scene_refuses(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(sky.UsageError, match=message):
        sky.read_scene(INPUTS / "perez_sky", **arguments)


def test_a_sky_file_takes_no_weather() -> None:
    with pytest.raises(sky.UsageError, match=r"all light comes from skydist\.inp"):
        sky.read_scene(INPUTS / "document_example", weather=PLACE)
