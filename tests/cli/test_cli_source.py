"""Files of a source: what `info` says of them, and that `verify` finds one that is not of its run."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.shared import INPUTS

SCENE = INPUTS / "perez_sky"


@pytest.fixture
def day(tmp_path: Path) -> Path:
    """A run whose photons are a source file."""
    assert (
        main(["run", str(SCENE), "--iterations", "1e4", "--format", "source", "--out", str(tmp_path / "day"), "-q"])
        == 0
    )
    return tmp_path / "day"


def test_info_names_the_plan(day, capsys):
    plan = json.loads((day / "manifest.json").read_text())["plan_sha256"]
    assert main(["info", str(day / "source.sky")]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"source file {day / 'source.sky'}, ")
    assert f"plan sha256: {plan}" in said
    assert main(["info", str(day / "source.sky"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [band["photons"] for band in said["bands"]] == [7200, 9400, 10000, 8800]
    assert said["plan_sha256"] == plan


def test_verify_makes_the_file_again(day, capsys):
    assert main(["verify", str(day)]) == 0
    assert "source.sky agrees with the plan, byte for byte" in capsys.readouterr().out
    data = bytearray((day / "source.sky").read_bytes())
    data[9000] ^= 1
    (day / "source.sky").write_bytes(bytes(data))
    assert main(["verify", str(day), "-q"]) != 0
    assert "source.sky differs from the plan" in capsys.readouterr().out
    assert main(["info", str(day / "source.sky")]) == 3
    assert "E971" in capsys.readouterr().err


def test_verify_finds_a_file_that_is_older_than_its_scene(day, tmp_path, capsys):
    shutil.copytree(SCENE, tmp_path / "scene")
    words = ["verify", str(day), "-q", "--scene", str(tmp_path / "scene"), "--iterations", "1e4"]
    assert main(words) == 0
    toml = tmp_path / "scene" / "sky.toml"
    toml.write_text(toml.read_text().replace("dhi = 95.0", "dhi = 94.0"))
    capsys.readouterr()
    assert main(words) == 5
    assert "scene: plan" in capsys.readouterr().out


@pytest.mark.parametrize("words", [[], ["--scene", str(SCENE)]])
def test_verify_wants_the_run_of_a_file(day, capsys, words):
    assert main(["verify", str(day / "source.sky"), *words]) == 2
    assert "give the folder of its run" in capsys.readouterr().err
