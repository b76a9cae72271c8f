"""`verify` finds a source file that is older than its scene, and wants the run of one."""

from __future__ import annotations

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
