"""``plot`` without a path draws the scene that the options describe, as ``run`` takes them."""

import json

import pytest

import aomc_sky as sky

PLACE = (
    *("--time", "2026-06-21T12:00Z", "--latitude", 43, "--longitude", 7),
    *("--spectrum", "spectrl2", "--wavelengths", 440, 670),
)


def test_it_is_the_picture_of_the_scene_of_those_options(tmp_path, told):
    pytest.importorskip("matplotlib")
    told("plot", "--sky", "overcast", "--wavelengths", 550, "--out", tmp_path / "a.png", "--title", "one")
    scene = sky.Scene(wavebands=[550.0], n_photons=1, components="overcast")
    sky.plot(scene, tmp_path / "b.png", title="one")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_place_and_time_have_a_dome_for_each_waveband(tmp_path, told):
    pytest.importorskip("matplotlib")
    pytest.importorskip("pvlib")
    said = json.loads(told("plot", *PLACE, "--out", tmp_path / "place.png", "--json").out)
    assert len(said["domes"]) == 2
    assert said["quantity"].startswith("radiance")


def test_what_is_missing_is_asked_as_run_asks(told):
    pytest.importorskip("matplotlib")
    for words, missing in (((), "which scene?"), (("--sky", "overcast"), "--wavelengths")):
        assert missing in told("plot", *words, code=2).err
        assert missing in told("run", *words, code=2).err
