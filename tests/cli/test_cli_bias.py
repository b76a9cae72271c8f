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
    assert command("verify", run_folder, "--scene", "inputs/perez_sky", "--iterations", "2000", "-q") == 0
    assert command("verify", "--scene", "inputs/perez_sky", "--iterations", "2000", run_folder / "photons.mcpl") == 0
    assert "chi-square of weights" in " ".join(capsys.readouterr().out.split()).replace("- ", "-")


def test_an_mcpl_file_says_which_cells_belong_to_which_component(run_folder, told):
    said = told("info", run_folder / "photons.mcpl").out
    assert "cells of components: direct 0 to 0, perez 1 to 8100" in " ".join(said.split())


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


def test_the_run_says_what_the_weights_cost_and_warns_of_rare_components(tmp_path, told):
    said = told("run", "inputs/perez_sky", "--iterations", "100", "--bias", "direct=0.001", "--out", tmp_path / "o").out
    assert "photons are shared out otherwise than light: for all light they count as" in said
    assert "the largest weight is 900" in said
    assert "note: waveband 1 expects less than one photon of direct" in said


def test_a_dry_run_and_info_say_it_and_refuse_what_a_run_would(tmp_path, told):
    said = told("run", "inputs/perez_sky", "--bias", "direct=0.2", "--dry-run").out
    assert "photons are shared out otherwise than light" in said
    told("run", "inputs/perez_sky", "--bias", "nobody=0.2", "--dry-run", code=2)
    told("run", "inputs/perez_sky", "--replicates", "0", "--dry-run", code=2)
    scene = copy_scene("perez_sky", tmp_path).parent
    toml = scene / "sky.toml"
    own = toml.read_text()
    toml.write_text(own + "[photons]\nbias = { direct = 0.2 }\n")
    assert "modelled: photons shared out otherwise than light: direct 0.2" in told("info", scene).out
    said = told("run", scene, "--diffuse-only", "--iterations", "100", "--out", tmp_path / "o").out
    assert "note: sky.toml: the bias of direct is not used: the scene has no beam" in said
    toml.write_text(own + "[photons]\nbias = { sun = 0.2 }\n")
    line = own.count("\n") + 2
    for words in (["run", scene, "--dry-run"], ["info", scene], ["validate", scene]):
        said = told(*words, code=3).err
        assert f"sky.toml:{line}:8: error[E704]: bias: there is no component 'sun'" in said
        assert "the components are direct, perez" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--bias", "direct"], "expected NAME=SHARE, for example direct=0.2"),
        (["--bias", "direct=a"], "expected a finite number"),
        (["--bias", "direct=0.2,perez=0.8"], "write the option once for each component"),
        (["--bias", "sun=0.1"], "there is no component 'sun'; the components are direct, perez"),
        (["--bias", "direct=0.1", "--bias", "direct=0.2"], "--bias direct is given twice"),
        (["--bias", "direct=0.1", "--allocation", "largest-remainder"], "take allocation systematic or multinomial"),
    ],
)
def test_what_is_refused(words, said, tmp_path, told):
    assert said in told("run", "inputs/perez_sky", *FEW, *words, "--out", tmp_path / "o", code=2).err


def test_shards_make_the_run(tmp_path, run_folder):
    for part in ("1/2", "2/2"):
        words = ("--bias", "direct=0.2", "--shard", part, "--out", tmp_path / "parts")
        assert command("run", "inputs/perez_sky", *FEW, *words) == 0
    paths = sorted(run_folder.glob("*.npy"))
    assert len({path.name.partition("-")[0] for path in paths}) == 3  # photons, positions, weights
    for path in paths:
        assert path.read_bytes() == (tmp_path / "parts" / path.name).read_bytes()
