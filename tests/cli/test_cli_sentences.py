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
