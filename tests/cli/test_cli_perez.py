"""``aomc-sky perez``: one sky from every kind of input, its files, and what is said about bad options."""

import json

import pytest

from aomc_sky.cli.main import main
from aomc_sky.formats.aomc.skydist import Bins, Values, read_skydist
from aomc_sky.formats.weather import read_weather
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky
from tests.support.fault_rows import command
from tests.support.shared import DATA

GOOD = DATA / "weather" / "good"
EPW, TMY2, TMY3 = (str(GOOD / name) for name in ("invented.epw", "invented.tm2", "invented.tmy3.csv"))
CLEAR = ["--sun-zenith", "40", "--dni", "850", "--dhi", "95"]


def shown(capsys, *words):
    assert main(["perez", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("words", "b", "azimuth"), [("-1 -3e-1 10 -3. .45", -0.3, "-9e1"), ("0 0 0 0 -.5", 0.0, "-90.")]
)
def test_negative_numbers_in_every_spelling(words, b, azimuth, capsys):
    found = shown(capsys, "--sun-zenith", "40", "--coefficients", *words.split(), "--sun-azimuth", azimuth)
    assert (found["coefficients"]["b"], found["sun_azimuth_deg"]) == (b, 270.0)


def test_what_is_limited_is_said_and_strict_refuses_it(told):
    words = ["perez", "--sun-zenith", "60", "--epsilon", "1.0", "--delta", "0.9"]
    said = told(*words)
    assert "delta: 0.9\n" in said.out
    assert "delta used: 0.6\n" in said.out
    assert said.err.count("aomc-sky: warning:") == 1
    assert "--strict" in told(*words, "--strict", code=3).err
    assert "delta used: 0.9\n" in told(*words, "--limits", "paper").out


@pytest.mark.parametrize(
    ("time", "latitude", "clearness", "brightness"),
    [("06-21T12:02", 40, 5.0647, 0.0946), ("06-21T12:02", 0, 4.8891, 0.0988), ("12-21T11:58", 0, None, 0.0925)],
)
def test_with_its_constants_and_a_date_the_brightness_is_that_of_gendaylit(
    time, latitude, clearness, brightness, capsys
):
    """gendaylit 2.6 at solar noon, DNI 500, DHI 120; without the factor of the distance it was 3.3 % less in June."""
    pytest.importorskip("pvlib")
    moment = ("--time", f"2026-{time}Z", "--latitude", latitude, "--longitude", 0, "--dni", 500, "--dhi", 120)
    found = shown(capsys, *map(str, moment), "--extraterrestrial", "1367", "--air-mass", "kasten-1966")
    assert found["delta"] == pytest.approx(brightness, abs=1.1e-4)  # the sun's places differ by 0.02 degrees
    assert clearness is None or found["epsilon"] == pytest.approx(clearness, rel=2e-3)
    assert shown(capsys, *map(str, moment))["delta"] == pytest.approx(1.0045 * brightness, rel=2e-3)


@pytest.mark.parametrize(("option", "path"), [("--epw", EPW), ("--tmy2", TMY2), ("--tmy3", TMY3)])
def test_a_row_of_a_weather_file(option, path, told, capsys):
    pytest.importorskip("pvlib")
    table = read_weather(path, option[2:])
    found = shown(capsys, option, path, "--row", "12")
    assert (found["dni"], found["dhi"]) == (table.dni[11], table.dhi[11])
    assert found["source"]["sun_at"] == f"{table.midpoint[11]}Z"
    assert found["source"]["line"] == table.line[11]
    assert found["ghi"] == pytest.approx(table.ghi[11], abs=1.6)  # so the sun is that of the middle of the hour
    again = shown(
        capsys,
        *("--time", found["source"]["sun_at"]),
        *("--latitude", repr(table.latitude_deg), "--longitude", repr(table.longitude_deg)),
        *("--dni", repr(found["dni"]), "--dhi", repr(found["dhi"])),
    )
    assert {k: v for k, v in again.items() if k != "source"} == {k: v for k, v in found.items() if k != "source"}
    assert f"row 12, place {table.station}" in told("perez", option, path, "--row", "12").out


def table_of(folder, *words):
    assert command("perez", *words, "--write-skydist", folder / "skydist.inp", "-q") == 0
    return read_skydist(folder / "skydist.inp")


def test_a_table_read_back_gives_the_same_masses(tmp_path):
    table = table_of(tmp_path, *CLEAR, "--sun-azimuth", "70", "--bins", "9", "36")
    assert (table.declared_bins, table.declared_values) == (Bins.EQUAL, Values.RADIANCE)
    assert table.wavelength_nm.tolist() == [550.0]
    grid = PatchGrid.regular(9, 36)
    sky = PerezSky(sun_zenith_deg=40.0, sun_azimuth_deg=70.0, dni=850.0, dhi=95.0)
    mass = table.radiance[0].ravel() * grid.projected_solid_angle_sr
    assert mass.sum() == pytest.approx(95.0, rel=1e-12)
    assert mass / 95.0 == pytest.approx(sky.patch_mass(grid), rel=1e-12)
    # the sun stands in the patch that holds it
    assert divmod(int(table.radiance[0].argmax()), 36) in {(3, 6), (3, 7), (4, 6), (4, 7)}
