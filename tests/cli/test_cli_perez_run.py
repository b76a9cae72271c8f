"""``run``, ``info`` and ``validate`` with a sky.toml and the options of sun and weather."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene, run_bytes


@pytest.fixture
def amc(tmp_path: Path) -> Path:
    return copy_scene("perez_sky", tmp_path)


def run(*words: object) -> int:
    return main(["run", *map(str, words)])


def test_options_and_sky_toml_give_the_same_bytes(amc, tmp_path):
    words = ("--iterations", 20_000, "-q", "--out")
    assert run(amc, *words, tmp_path / "file") == 0
    (amc.parent / "sky.toml").unlink()
    given = ("--dni", 850, "--dhi", 95, "--sun-zenith", 32.4, "--sun-azimuth", 121.25, "--disc")
    assert run(amc, *given, *words, tmp_path / "options") == 0
    one, two = run_bytes(tmp_path / "file"), run_bytes(tmp_path / "options")
    assert set(one) == set(two)
    assert {name for name in one if one[name] != two[name]} == {"manifest.json"}


def test_validate_reads_sky_toml(amc, capsys):
    assert main(["validate", str(amc.parent)]) == 0
    assert "sky.toml: ok" in capsys.readouterr().out
    (amc.parent / "sky.toml").write_text("[perez]\ndni = 850.0\n[sun]\nzenith_deg = 90\n")
    assert main(["validate", str(amc.parent)]) == 3
    shown = capsys.readouterr()
    assert "sky.toml:2:1: error[E705]" in shown.err
    assert "sky.toml:4:14: error[E704]" in shown.err
    copy = amc.parent / "weather.toml"
    shutil.move(amc.parent / "sky.toml", copy)
    assert main(["validate", str(copy)]) == 3
    assert run(amc.parent, "--dry-run", "--sky", "uniform") == 0


def test_run_and_validate_miss_the_same_inputs_and_show_the_lines(amc, capsys):
    for name in ("sky.toml", "difcol.inp"):
        (amc.parent / name).unlink()
    for command in ("run", "validate"):
        assert main([command, str(amc.parent)]) == 3
        shown = capsys.readouterr().err
        assert "difcol.inp: error[E100]" in shown
        assert "[perez]\ndni = 850.0 " in shown
        assert "\ndhi = 95.0 " in shown
    assert run(amc, "--dni", 850, "--dhi", 95, "--dry-run") == 0
    assert "without difcol.inp: direct fraction 0.88" in capsys.readouterr().out
    assert main(["validate", str(amc.parent), "--dni", "850", "--dhi", "95"]) == 0
    assert "difcol" not in capsys.readouterr().out
    assert main(["validate", str(amc.parent), "--dni", "850"]) == 2
    assert main(["validate", str(amc.parent), "--dni", "0", "--dhi", "0"]) == 4
