"""The same weather through `run` and `perez`: a time and a place, an hour of a file, and photons without AMC files."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene, run_bytes
from tests.support.shared import INPUTS

EPW = INPUTS / "weather" / "two_days.epw"
ROW = ("--epw", EPW, "--row", 12)
TIME = ("--time", "2026-06-21T09:30:00Z", "--latitude", 54.18, "--longitude", 7.89)
CLEAR = ("--sun-zenith", 40, "--dni", 850, "--dhi", 95)
SMALL = ("--iterations", 20_000, "--bins", 9, 36)


@pytest.fixture
def amc(tmp_path):
    amc = copy_scene("perez_sky", tmp_path)
    (amc.parent / "difcol.inp").unlink()
    return amc


def test_run_and_perez_see_one_sky(amc, tmp_path, told):
    pytest.importorskip("pvlib")
    for words in (ROW, (*TIME, "--ghi", 700, "--dhi", 120), (*TIME, "--altitude", 900, "--ghi", 700, "--dni", 700)):
        one = json.loads(told("perez", *words, "--json").out)
        other = json.loads(told("run", amc, *words, "--spectrum", "flat", "--dry-run", "--json").out)["options"]
        assert other["sun"]["zenith_deg"] == one["sun_zenith_deg"]
        assert other["sun"]["azimuth_deg"] == one["sun_azimuth_deg"]
        assert other["perez"]["coefficients"] == pytest.approx(list(one["coefficients"].values()), rel=1e-12)
        assert other["perez"]["delta"] == pytest.approx(one["delta"], rel=1e-14)
        assert other["weather"] == one["source"]


def test_a_run_says_what_the_weather_replaced(amc, tmp_path, told):
    pytest.importorskip("pvlib")
    out = tmp_path / "out"
    shown = told("run", amc, *ROW, "--spectrum", "flat", "--iterations", 1000, "--out", out).out
    assert "note: two_days.epw, row 12: the sun at a zenith angle of 29.8841" in shown
    assert "not at 32.4 and 121.25 as in sky.toml" in shown
    assert "its irradiances take the place of [perez] in sky.toml" in shown
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["inputs"]["weather"]["name"] == "two_days.epw"
    assert manifest["options"]["scene"]["weather"]["row"] == 12
    assert command("verify", out, "-q") == 0
    assert command("verify", out, "--scene", amc, *ROW, "--spectrum", "flat", "--iterations", 1000, "-q") == 0
    assert command("validate", amc.parent, *ROW) == 0
    assert command("info", amc, *ROW, "--spectrum", "flat", "--json") == 0
    other = tmp_path / "other"
    assert (
        command("run", amc, "--dni", 850, "--dhi", 95, "--spectrum", "flat", "--iterations", 1000, "--out", other) == 0
    )
    assert "weather" not in json.loads((other / "manifest.json").read_text())["options"]["scene"]


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (("--epw", EPW, "--row", 1), 4, "the nearest row with a sun is 5"),
        (("--epw", EPW, "--row", 49), 2, "rows 1 to 48"),
        (("--epw", EPW), 2, "--epw needs --row N"),
        (("--row", 5), 2, "--row needs a weather file"),
        (("--latitude", 5), 2, "--latitude needs --time"),
        ((*ROW, "--dni", 5), 2, "--dni contradicts --epw, which gives the sun and the sky"),
        ((*ROW, "--time", "2026-06-21T09:30:00Z"), 2, "--time contradicts --epw"),
        ((*TIME, "--sun-zenith", 5), 2, "leave out --sun-zenith"),
        (("--epw", EPW, "--tmy3", EPW, "--row", 1), 2, "not allowed with argument --epw"),
        (("--tmy3", EPW, "--row", 1), 3, "E601"),
        (("--time", "2026-06-21T09:30:00", *TIME[2:]), 2, "time zone"),
        (("--time", "2026-06-21T00:30:00Z", *TIME[2:]), 4, "below the horizon there; take an hour of the day"),
        ((*TIME, "--altitude", 1e5), 2, "altitude must lie within"),
        ((*TIME, "--ghi", 700, "--dhi", 900), 4, "dhi 900 W m-2 is more than ghi 700"),
        ((*TIME, "--ghi", 700), 2, "ghi without dni; add dni (or dhi)"),
    ],
)
def test_bad_weather_in_words(words, code, text, amc, tmp_path, told, monkeypatch):
    pytest.importorskip("pvlib")
    monkeypatch.chdir(tmp_path)
    said = told("run", amc, *words, code=code)
    assert text in said.err
    assert said.out == ""


def test_photons_of_one_sky(tmp_path, told, capsys):
    out = tmp_path / "sky"
    shown = told("perez", *CLEAR, *SMALL, "--seed", 4, "--diffuse-only", "--out", out).out
    assert "dni: 850\ndhi: 95\n" in shown
    assert "20000 photons in 1 wavebands, seed 4" in shown
    manifest = json.loads((out / "manifest.json").read_text())
    assert (manifest["total"], manifest["components"], manifest["seed"]) == (20_000, ["perez"], 4)
    assert manifest["options"]["scene"]["perez"]["dni"] == 850
    photons = np.load(out / "photons-0001.npy")
    model = sky.PerezSky(sun_zenith_rad=float(np.deg2rad(40.0)), dni=850.0, dhi=95.0, grid=sky.PatchGrid.regular(9, 36))
    scene = sky.Scene(wavebands=[550.0], n_photons=20_000, components=model)
    batch = scene.source(seed=4).photons()
    assert np.array_equal(photons, np.stack([batch.ux, batch.uy, batch.uz], axis=-1))
    assert command("verify", out, "-q") == 0
    assert command("info", out, "--json") == 0
    assert command("export", out, "--to", "csv", "--out", tmp_path / "csv") == 0
    assert "finished before" in told("perez", *CLEAR, *SMALL, "--seed", 4, "--diffuse-only", "--out", out).out
    assert command("perez", *CLEAR, *SMALL, "--seed", 5, "--diffuse-only", "--out", out) == 5
    assert command("perez", *CLEAR, *SMALL, "--seed", 5, "--diffuse-only", "--out", out, "--force", "--json") == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["run"]["seed"] == 5


def test_photons_of_sky_and_beam(tmp_path, told, capsys):
    out = tmp_path / "both"
    words = (*CLEAR, *SMALL, "--with-beam", "--sun-azimuth", 70, "--format", "mcpl", "--format", "npy", "--out", out)
    run = json.loads(told("perez", *words, "--json").out)["run"]
    assert not any("missing" in note for note in run["notes"])
    assert command("perez", *CLEAR, *SMALL, "--diffuse-only", "--out", tmp_path / "sky") == 0
    missing = "note: the direct beam of the sun, 0.8727 of the light, is left out (dni 850 and dhi 95 W m-2 (options))"
    assert missing in capsys.readouterr().out.splitlines()
    beam = 850 * np.cos(np.deg2rad(40.0))
    photons = np.load(out / "photons-0001.npy")
    axis = -np.array([np.sin(np.deg2rad(40)) * f(np.deg2rad(70)) for f in (np.cos, np.sin)] + [np.cos(np.deg2rad(40))])
    in_beam = np.count_nonzero(np.abs(photons - axis).max(axis=1) < 1e-6)
    assert in_beam == pytest.approx(20_000 * beam / (beam + 95), abs=1)
    assert run["components"] == ["direct", "perez"]
    assert (out / "photons.mcpl").is_file()
    assert command("verify", out, "-q") == 0


def test_photons_of_an_hour_are_those_of_its_numbers(tmp_path, told):
    pytest.importorskip("pvlib")
    shown = json.loads(told("perez", *ROW, *SMALL, "--with-beam", "--out", tmp_path / "hour", "--json").out)
    manifest = json.loads((tmp_path / "hour" / "manifest.json").read_text())
    assert manifest["inputs"]["weather"]["name"] == "two_days.epw"
    numbers = ("--sun-zenith", repr(shown["sun_zenith_deg"]), "--sun-azimuth", repr(shown["sun_azimuth_deg"]))
    numbers += ("--dni", 496, "--dhi", 281, "--extraterrestrial", repr(shown["extraterrestrial_normal"]))
    assert command("perez", *numbers, *SMALL, "--with-beam", "--out", tmp_path / "numbers", "-q") == 0
    one, two = run_bytes(tmp_path / "hour"), run_bytes(tmp_path / "numbers")
    assert {name for name in one if one[name] != two[name]} == {"manifest.json"}


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ("--coefficients -1 -0.3 10 -3 0.45 --with-beam", 2, "coefficients do not say how bright the beam is"),
        ("--dni 850 --dhi 0", 4, "no light in the sky"),
        ("--dni 850 --dhi 95 --out - --format raw", 2, "perez writes a folder"),
    ],
)
def test_photons_that_cannot_be(words, code, text, tmp_path, told):
    out = [] if "--out" in words else ["--out", tmp_path / "out"]
    assert text in told("perez", "--sun-zenith", 40, *out, *words.split(), code=code).err
    assert list(tmp_path.iterdir()) == []
