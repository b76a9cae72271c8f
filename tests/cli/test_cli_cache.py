"""Solved atmospheres are kept for the next command, unless somebody does not want it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.atmospheres import counted_solutions
from tests.support.scenes import copy_scene

FEW = "zenith_bins = 4\nazimuth_bins = 6\npaths = 16\n"


@pytest.fixture
def scene(tmp_path):
    amc = Path(copy_scene("twilight", tmp_path))
    toml = amc.with_name("sky.toml")
    lines = [line for line in toml.read_text(encoding="utf-8").splitlines() if "_bins" not in line]
    toml.write_text("\n".join(lines).replace("[sun]", f"{FEW}\n[sun]") + "\n", encoding="utf-8")
    return amc


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("AOMC_SKY_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture
def solutions(monkeypatch):
    return counted_solutions(monkeypatch)


def answer(capsys, *words):
    assert main(list(map(str, words))) == 0
    out, err = capsys.readouterr()
    return json.loads(out), err


def test_all_commands_of_a_scene_share_one_solution(scene, kept, solutions, tmp_path, capsys):
    answer(capsys, "run", scene, "--iterations", "1e3", "--out", tmp_path / "one", "--json")
    for words in (
        ["run", scene, "--iterations", "1e3", "--out", tmp_path / "two"],
        ["run", scene, "--iterations", "1e3", "--dry-run"],
        ["validate", scene],
        ["info", scene],
        ["verify", tmp_path / "one", "--scene", scene, "--iterations", "1e3"],
    ):
        answer(capsys, *words, "--json")
    assert len(solutions) == 1
    assert len(list(kept.iterdir())) == 1
    for name in ("plan.npz", "photons-0001.npy", "counts.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_without_a_cache_nothing_is_read_or_written(scene, kept, solutions, capsys):
    for n in (1, 2):
        answer(capsys, "run", scene, "--dry-run", "--json", "--no-cache")
        assert len(solutions) == n
        assert not kept.exists()


def test_a_scene_in_python_uses_it_unless_told_otherwise(scene, kept, solutions):
    scenes = [sky.read_scene(scene, sun={"zenith_deg": 40.0}, cache=cache) for cache in (True, True, False)]
    assert len(solutions) == 2
    masses = [one.components[-1].mass.tobytes() for one in scenes]
    assert masses[0] == masses[1] == masses[2]


def test_a_damaged_entry_is_a_warning_also_of_a_strict_command(scene, kept, solutions, capsys):
    words = ["run", scene, "--dry-run", "--json", "--strict", "--sun-zenith", "40"]
    before, err = answer(capsys, *words)
    assert err == ""
    (entry,) = kept.iterdir()
    entry.write_bytes(entry.read_bytes()[:-1])
    after, err = answer(capsys, *words)
    assert after == before
    assert (
        err == f"aomc-sky: warning: {entry}: this kept solution of an atmosphere is damaged (its bytes have "
        "changed); it is solved anew\n"
    )
    assert len(solutions) == 2


def test_the_table_and_the_picture_of_a_description_are_kept_too(kept, solutions, tmp_path, capsys, scene):
    pytest.importorskip("matplotlib")
    air = scene.with_name("air.atmo")
    words = ["atmosphere", air, "--sun-zenith", "40,50", "--orders", "1", "--bins", "3", "4", "--no-netcdf", "--json"]
    reports = [answer(capsys, *words, "--out-dir", tmp_path / "table")[0] for _ in range(2)]
    assert len(solutions) == 2
    tables = [[sun["diffuse_irradiance"] for sun in report["suns"]] for report in reports]
    assert tables[0] == tables[1]
    answer(capsys, *words, "--out-dir", tmp_path / "table", "--no-cache")
    assert len(solutions) == 4
    for n in (5, 5):
        answer(capsys, "plot", air, "--wavelength", "450", "--size", "300", "--out", tmp_path / "a.png", "--json")
        assert len(solutions) == n


def test_the_option_is_refused_where_nothing_is_solved(tmp_path, capsys):
    path = tmp_path / "skydist.inp"
    path.write_text("1 1 0 1\n500\n1 1 0 1.0\n")
    assert main(["plot", str(path), "--no-cache"]) == 2
    assert "--no-cache is for a scene or an atmosphere" in capsys.readouterr().err
