"""The same weather through `run` and `perez`, photons without AMC files, and skies by name."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene, manifest_of
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


def test_run_and_perez_see_one_sky(amc, told):
    pytest.importorskip("pvlib")
    for words in (ROW, (*TIME, "--ghi", 700, "--dhi", 120), (*TIME, "--altitude", 900, "--ghi", 700, "--dni", 700)):
        one = json.loads(told("perez", *words, "--json").out)
        other = json.loads(told("run", amc, *words, "--spectrum", "flat", "--dry-run", "--json").out)["options"]
        assert other["sun"]["zenith_deg"] == one["sun_zenith_deg"]
        assert other["sun"]["azimuth_deg"] == one["sun_azimuth_deg"]
        assert other["perez"]["coefficients"] == pytest.approx(list(one["coefficients"].values()), rel=1e-12)
        assert other["perez"]["delta"] == pytest.approx(one["delta"], rel=1e-14)
        assert other["weather"] == one["source"]


def test_commands_of_a_scene_take_a_row_of_weather(amc, tmp_path, told):
    pytest.importorskip("pvlib")
    out, words = tmp_path / "out", (*ROW, "--spectrum", "flat")
    told("run", amc, *words, "--iterations", 1000, "--out", out)
    manifest = manifest_of(out)
    assert manifest["inputs"]["weather"]["name"] == "two_days.epw"
    assert manifest["options"]["scene"]["weather"]["row"] == 12
    told("verify", out, "--scene", amc, *words, "--iterations", 1000)
    told("validate", amc.parent, *ROW)
    told("info", amc, *words, "--json")


def test_photons_of_one_sky(tmp_path, told):
    out = tmp_path / "sky"
    words = ("perez", *CLEAR, *SMALL, "--diffuse-only", "--out", out, "--seed")
    shown = told(*words, 4).out
    assert "20000 photons in 1 wavebands, seed 4" in shown
    manifest = manifest_of(out)
    assert (manifest["total"], manifest["components"], manifest["seed"]) == (20_000, ["perez"], 4)
    assert manifest["options"]["scene"]["perez"]["dni"] == 850
    model = sky.PerezSky(sun_zenith_deg=40.0, dni=850.0, dhi=95.0, grid=sky.PatchGrid.regular(9, 36))
    scene = sky.Scene(wavebands=[550.0], n_photons=20_000, components=model)
    assert np.array_equal(np.load(out / "photons-0001.npy"), scene.source(seed=4).photons().directions)
    assert command("verify", out, "-q") == 0
    told(*words, 5, code=5)
    assert json.loads(told(*words, 5, "--force", "--json").out)["run"]["seed"] == 5


def test_photons_of_sky_and_beam(tmp_path, told):
    out = tmp_path / "both"
    words = (*CLEAR, *SMALL, "--with-beam", "--sun-azimuth", 70, "--format", "mcpl", "--format", "npy", "--out", out)
    run = json.loads(told("perez", *words, "--json").out)["run"]
    beam = 850 * np.cos(np.deg2rad(40.0))
    photons = np.load(out / "photons-0001.npy")
    axis = -np.array([np.sin(np.deg2rad(40)) * f(np.deg2rad(70)) for f in (np.cos, np.sin)] + [np.cos(np.deg2rad(40))])
    in_beam = np.count_nonzero(np.abs(photons - axis).max(axis=1) < 1e-6)
    assert in_beam == pytest.approx(20_000 * beam / (beam + 95), abs=1)
    assert run["components"] == ["direct", "perez"]
    assert (out / "photons.mcpl").is_file()
    assert command("verify", out, "-q") == 0


def run(*words):
    return command("run", "--wavelengths", 443, 555, "--iterations", 20_000, *words)


@pytest.mark.parametrize(
    ("words", "is_noted"),
    [
        (["--iterations", "100"], True),
        (["--iterations", "1e6"], False),
        (["--iterations", "100", "--format", "none"], False),
    ],
)
def test_a_rough_scalar_irradiance_is_noted(tmp_path, told, words, is_noted):
    """Ed/Eo of the photons more than 1 % from the exact value."""
    out = told("run", "--sky", "uniform", "--wavelengths", 500, "--out", tmp_path / "out", *words).out
    assert ("near the horizon make its scatter" in out) is is_noted


def test_the_folder_of_a_sky_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("--sky", "overcast", "-q", "--dry-run") == 0
    assert not list(tmp_path.iterdir())
    assert run("--sky", "overcast", "-q") == 0
    assert (tmp_path / "aomc-sky-out" / "manifest.json").is_file()
