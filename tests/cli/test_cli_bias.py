"""Runs whose photons are shared out otherwise than light: files, verify, sky.toml, export, what is printed."""

import json

import numpy as np
import pytest

from tests.support.fault_rows import command
from tests.support.scenes import copy_scene

FEW = ("--iterations", "2000", "-q")


@pytest.fixture
def run_folder(tmp_path):
    out = tmp_path / "out"
    formats = [word for name in ("npy", "raw", "mcpl") for word in ("--format", name)]
    assert command("run", "inputs/perez_sky", "--bias", "direct=0.2", *FEW, *formats, "--out", out) == 0
    return out


def test_weights_are_in_every_file_and_verify_makes_them_again(run_folder, capsys):
    weights = np.load(run_folder / "weights-0001.npy")
    records = np.fromfile(run_folder / "photons-0001.raw", "<f4").reshape(len(weights), -1)
    np.testing.assert_array_equal(records[:, -1], weights)
    head, *lines = (run_folder / "counts.csv").read_text().splitlines()
    assert head.endswith("mass,expected,photons,weight")
    band, *_, mass, expected, photons, weight = lines[0].split(",")
    assert band == "1"
    assert float(mass) / float(weight) == pytest.approx(0.2)
    assert float(expected) == pytest.approx(0.2 * len(weights))
    assert abs(int(photons) - float(expected)) < 1
    manifest = json.loads((run_folder / "manifest.json").read_text())
    assert manifest["options"]["sampling"]["bias"] == {"direct": 0.2}
    assert manifest["bands"][0]["mean_cosine_photons"] == pytest.approx(
        manifest["bands"][0]["mean_cosine_exact"], abs=1e-3
    )
    assert command("verify", run_folder, "--statistics") == 0
    assert command("info", run_folder / "photons.mcpl") == 0
    assert "cells of components: direct 0 to 0, perez 1 to 8100" in " ".join(capsys.readouterr().out.split())
    assert command("verify", run_folder, "--scene", "inputs/perez_sky", "--iterations", "2000", "-q") == 0
    assert command("verify", "--scene", "inputs/perez_sky", "--iterations", "2000", run_folder / "photons.mcpl") == 0
    assert "chi-square of weights" in " ".join(capsys.readouterr().out.split()).replace("- ", "-")


def test_a_changed_weight_is_found(run_folder):
    weights = np.load(run_folder / "weights-0001.npy")
    weights[3] = np.nextafter(weights[3], 9, dtype=weights.dtype)
    path = run_folder / "weights-0001.npy"
    data = bytearray(path.read_bytes())
    data[-weights.nbytes :] = weights.tobytes()
    path.write_bytes(data)
    assert command("verify", run_folder, "-q") in (1, 5)


def test_sky_toml_says_the_same_and_the_option_wins(tmp_path, run_folder):
    scene = copy_scene("perez_sky", tmp_path).parent
    toml = scene / "sky.toml"
    toml.write_text(toml.read_text() + "[photons]\nbias = { direct = 0.2 }\n")
    assert command("run", scene, *FEW, "--out", tmp_path / "by_file") == 0
    for name in ("photons-0001.npy", "weights-0001.npy"):
        assert (tmp_path / "by_file" / name).read_bytes() == (run_folder / name).read_bytes()
    assert command("run", scene, *FEW, "--bias", "direct=0.4", "--out", tmp_path / "by_option") == 0
    assert "800.0,800," in (tmp_path / "by_option/counts.csv").read_text()


def test_a_bias_of_sky_toml_is_told_or_refused_at_its_line(tmp_path, told):
    scene = copy_scene("perez_sky", tmp_path).parent
    toml = scene / "sky.toml"
    own = toml.read_text()
    toml.write_text(own + "[photons]\nbias = { direct = 0.001 }\n")
    run = ("run", scene, "--iterations", 100, "--out", tmp_path / "o")
    said = told(*run).out
    assert "the largest weight is 900" in said
    assert "note: waveband 1 expects less than one photon of direct" in said
    assert "otherwise than light: direct 0.001" in told("info", scene).out
    assert "the bias of direct is not used" in told(*run, "--diffuse-only", "--force").out
    toml.write_text(own + "[photons]\nbias = { sun = 0.2 }\n")
    place = f"sky.toml:{own.count(chr(10)) + 2}:8: error[E704]"
    for words in (["run", scene, "--dry-run"], ["info", scene], ["validate", scene]):
        assert place in told(*words, code=3).err
