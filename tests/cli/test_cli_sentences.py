"""Sentences of a first day: they name what was given, what is allowed, and what to write."""

import pytest

from tests.support.shared import INPUTS


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--sky", "overcast", "--wavelengths", "400:700"), 2, "write 400:700:10"),
        (("--sky", "overcast", "--wavelengths", "400-700"), 2, "or 400:700:10"),
        (("--sky", "cie", "--sun-zenith", 40, "--wavelengths", 550), 2, "needs type (1 to 15)"),
        (("--weather", INPUTS / "weather/two_days.epw", "--row", 2, "--wavelengths", 550), 4, "--row 2"),
    ],
)
def test_what_to_write_is_said(words, code, said, told, tmp_path):
    if "--weather" in words:
        pytest.importorskip("pvlib")
    assert said in told("run", *words, "--out", tmp_path / "out", code=code).err


def test_verify_says_that_a_scene_is_another_one(told, tmp_path):
    told("run", INPUTS / "overcast", "--iterations", 1000, "--format", "none", "--out", tmp_path / "run")
    said = told("verify", tmp_path / "run", "--scene", INPUTS / "document_example", code=5).out
    assert "another scene: wavebands 1 (550 nm)" in " ".join(said.split())
    assert "other contents of amc, lambbot, skydist" in " ".join(said.split())
    assert "shape" not in said


def test_ghi_alone_and_a_file_of_photons_say_what_is_missing(told, tmp_path):
    alone = ("--sun-zenith", 40, "--ghi", 700, "--wavelengths", 550, "--out", tmp_path / "out")
    assert "ghi alone does not say how much of it is the beam" in told("run", *alone, code=2).err
    (tmp_path / "mine.npy").write_bytes(b"")
    said = told("verify", tmp_path / "mine.npy", "--sky", "uniform", "--wavelengths", 550, code=2).err
    assert "give a run folder, or --scene" in said


def test_a_run_of_a_time_says_where_the_sun_is(told, tmp_path):
    pytest.importorskip("pvlib")
    place = ("--time", "2026-06-21T10:00Z", "--latitude", 54.18, "--longitude", 7.89, "--spectrum", "spectrl2")
    how = ("--wavelengths", 550, "--iterations", 100, "--format", "none", "--out", tmp_path / "out")
    assert "sun: 35.07 degrees from the zenith, azimuth 307.77 (compass 142.23)" in told("run", *place, *how).out
