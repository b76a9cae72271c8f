"""``aomc-sky validate`` of folders: all that it knows, and what a run would miss."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene

INPUTS = Path(__file__).parents[2] / "inputs"
BAD = sorted(path.name for path in (INPUTS / "bad").iterdir() if path.suffix in (".inp", ".toml"))


def validated(path: Path, capsys) -> tuple[int, dict[str, list[str]]]:
    """Exit code of ``validate --json``, and the problems of every file under its name."""
    code = main(["validate", str(path), "--json"])
    files = json.loads(capsys.readouterr().out)["files"]
    return code, {Path(file["path"]).name: file["problems"] for file in files}


@pytest.mark.parametrize("name", ["lambbot.inp", "skydist.inp"])
def test_a_scene_without_a_file_that_run_wants(name, tmp_path, capsys):
    folder = copy_scene("document_example", tmp_path).parent
    (folder / name).unlink()
    code, problems = validated(folder, capsys)
    assert code == 3
    assert "error[E100]: there is no such file" in problems[name][0]
    assert main(["run", str(folder), "--dry-run"]) == 3  # as validate foretold


def test_a_sky_that_sky_toml_names_needs_no_skydist(tmp_path, capsys):
    folder = copy_scene("document_example", tmp_path).parent
    (folder / "skydist.inp").unlink()
    (folder / "sky.toml").write_text('[sky]\nmodel = "uniform"\n')
    code, problems = validated(folder, capsys)
    assert (code, set(problems)) == (0, {"amc.inp", "lambbot.inp", "sky.toml"})
    assert main(["run", str(folder), "--dry-run"]) == 0


def test_every_file_of_a_folder_is_read_by_the_reader_of_its_name(capsys):
    code, problems = validated(INPUTS / "bad", capsys)
    assert code == 3
    assert sorted(problems) == BAD
    assert all(problems.values())
    assert "error[E302]" in problems["nan_radiance.skydist.inp"][0]
    assert "error[E203]" in problems["ends_early.lambbot.inp"][0]
    assert "error[E202]" in problems["direct_fraction_above_one.difcol.inp"][0]


def test_files_with_names_of_their_own(tmp_path, capsys):
    shutil.copytree(INPUTS / "atmosphere", tmp_path / "air")
    for other in ("notes.txt", "skydist.png", "pyproject.toml"):
        (tmp_path / "air" / other).write_text("not for us")
    code, problems = validated(tmp_path / "air", capsys)
    assert (code, problems) == (0, {p.name: [] for p in (tmp_path / "air").glob("*.atmo")})


def test_a_problem_of_a_file_that_sky_toml_names_is_told_once(tmp_path, capsys):
    folder = copy_scene("atmosphere_sky", tmp_path).parent
    atmo = folder / "clear.atmo"
    atmo.write_text(atmo.read_text().replace(":", ";", 1))
    assert main(["validate", str(folder)]) == 3
    told = capsys.readouterr()
    assert told.err.count("clear.atmo:1:1: error[") == 1
    assert told.out.count("has errors") == 2
