"""``validate``: it refuses what ``run`` refuses, in the same words, and nothing else; and every file of a folder."""

import json
import re
import shutil
from pathlib import Path

import pytest

import aomc_sky
from aomc_sky.cli.main import main
from tests.support.fault_rows import ROWS, command, row_id, sky
from tests.support.scenes import copy_scene
from tests.support.shared import DATA, INPUTS

BASE = {"amc": "document_example", "skydist": "document_example", "lambbot": "perez_sky", "difcol": "sun_and_sky"}
BASE |= {"sky_toml": "perez_sky"}
NAMES = {kind: "sky.toml" if kind == "sky_toml" else f"{kind}.inp" for kind in BASE}
FILES = [(kind, path.with_suffix("")) for kind in BASE for path in sorted((DATA / kind / "bad").glob("*.expected"))]
ROWS_OF_FAULTS = {
    "skydist": {
        2: "zenith_above", 3: "azimuth_above azimuth_negative", 4: "wave_above", 5: "nan", 6: "inf", 7: "negative",
        9: "fewer_rows", 10: "more_rows", 11: "header_huge", 12: "header_1e18", 13: "header_negative",
        14: "duplicate_differs", 15: "short_row", 16: "word real_index", 17: "slash null", 18: "decimal_comma",
        20: "wavelength_twice",
    },
    "amc": {
        26: "iterations_zero", 27: "flag_one_column_right", 28: "real_without_point", 29: "line_missing line_too_many",
        30: "utf16 nul lone_return",
    },
    "lambbot": {31: "count", 32: "reflectance_high negative not_finite"},
    "difcol": {31: "count", 32: "fraction_high"},
}  # fmt: skip
"""Bad files of the rows of tests/faults/README.md."""


def id_of_file(kind, path):
    rows = [row for row, names in ROWS_OF_FAULTS.get(kind, {}).items() if path.name in names.split()]
    return row_id(rows[0], f"{kind}-{path.name}") if rows else f"{kind}-{path.name}"


ZERO = sky(rows=[f"{row.rpartition(' ')[0]} 0.0" for row in ROWS])
BACKGROUND = '[[background]]\nfile = "no.h5"\ntime = 2026-06-21T23:30:00Z\n'
UNIFORM = '[sky]\nmodel = "uniform"\n'
NO_WEATHER = {"sky.toml": None, "difcol.inp": None}
BROKEN = {
    # name: (scene, files replaced; None: removed; options, exit code)
    "a-sky-of-zeros": ("document_example", {"skydist.inp": ZERO}, [], 4),
    "degrees-below-the-horizon": ("document_example", {"skydist.inp": sky("1 2 1 20.0")}, ["--bins", "degrees"], 0),
    "weighting-without-degrees": ("document_example", {}, ["--weighting", "aomc"], 2),
    "options-beside-a-table": ("document_example", {}, ["--aod", "0.2"], 2),
    "too-little-memory": ("clear_day", {}, ["--max-memory", "17M"], 2),
    "no-lambbot": ("document_example", {"lambbot.inp": None}, [], 3),
    "no-skydist": ("document_example", {"skydist.inp": None}, [], 3),
    "no-weather": ("perez_sky", NO_WEATHER, [], 3),
    "weather-in-options": ("perez_sky", NO_WEATHER, ["--dni", "850", "--dhi", "95"], 0),
    "weather-without-light": ("perez_sky", NO_WEATHER, ["--dni", "0", "--dhi", "0"], 4),
    "two-files": ("document_example", {"skydist.inp": sky("1 9 9 -1"), "lambbot.inp": "x\n"}, [], 3),
    "night-without-light": ("perez_sky", {}, ["--sky", "none"], 2),
    "unknown-table": ("document_example", {"sky.toml": '[sky]\nmodel = "nonesuch"\n'}, [], 3),
    "background-that-is-missing": ("document_example", {"sky.toml": BACKGROUND}, [], 3),
    "nothing-wrong": ("document_example", {}, [], 0),
    "a-sky-by-name-in-place-of-skydist": ("document_example", {"skydist.inp": None, "sky.toml": UNIFORM}, [], 0),
}


def errors_of(text):
    return {line for line in text.splitlines() if "error[" in line or line.startswith("aomc-sky: error")}


def code_of_both(folder, options, capsys):
    """The exit code of ``run`` and of ``validate``, whose errors are the same; and these."""
    words = (folder, "--iterations", "1000", *options)
    ran = command("run", *words, "--format", "none", "-q", "--out", folder.parent / "o")
    told = capsys.readouterr().err
    validated = command("validate", *words, "--json")
    files = json.loads(capsys.readouterr().out)["files"]
    found = "\n".join("\n".join(one["problems"]) for one in files)
    assert validated == ran, (told, found)
    assert bool(errors_of(told)) == (ran != 0)
    assert errors_of(told) <= errors_of(found)
    assert errors_of(told) == errors_of(found) or "more problem" in told + found
    return ran, found


@pytest.mark.parametrize("name", BROKEN)
def test_scenes_that_no_single_file_gives_away(name, tmp_path, capsys):
    if name.startswith("background"):
        pytest.importorskip("h5py")
    scene, files, options, code = BROKEN[name]
    folder = copy_scene(scene, tmp_path).parent
    for file, text in files.items():
        (folder / file).unlink(missing_ok=True)
        if text is not None:
            (folder / file).write_text(text)
    assert code_of_both(folder, options, capsys)[0] == code


@pytest.mark.parametrize(("kind", "path"), FILES, ids=[id_of_file(*file) for file in FILES])
def test_scenes_with_one_bad_file(kind, path, tmp_path, capsys):
    """Places and codes are those of the golden messages, and nothing is written."""
    folder = copy_scene(BASE[kind], tmp_path).parent
    shutil.copy(path.with_suffix(Path(NAMES[kind]).suffix), folder / NAMES[kind])
    code, said = code_of_both(folder, [], capsys)
    golden = errors_of(path.with_suffix(".expected").read_text())
    assert golden
    missing = [line for line in golden if re.search(r":\d+:\d+: error\[E\d+\]", line)[0] not in said]
    assert code == 3, (missing, said)
    assert missing == [], said
    assert not (tmp_path / "o").exists()


def test_the_light_of_an_atmosphere_is_not_solved(monkeypatch):
    def solve(*_, **__):
        raise AssertionError("solved")

    monkeypatch.setattr("aomc_sky.source.read.atmosphere.atmosphere_light", solve)
    assert main(["validate", str(INPUTS / "twilight")]) == 0


def test_files_of_a_folder_by_their_names(tmp_path, told):
    """Each is read by the reader of its name, and what has no name of ours is left alone."""
    found = json.loads(told("validate", INPUTS / "bad", "--json", code=3).out)["files"]
    wanted = sorted(path.name for path in (INPUTS / "bad").iterdir() if path.suffix in (".inp", ".toml"))
    assert sorted(Path(file["path"]).name for file in found) == wanted
    assert all(file["problems"] for file in found)
    shutil.copytree(INPUTS / "atmosphere", tmp_path / "air")
    for other in ("notes.txt", "skydist.png", "pyproject.toml"):
        (tmp_path / "air" / other).write_text("not for us")
    shutil.copy(DATA / "weather" / "good" / "invented.tm2", tmp_path / "air")
    lines = told("validate", tmp_path / "air", tmp_path / "air" / "invented.tm2").out.splitlines()
    assert len(lines) == 1 + len(list((tmp_path / "air").glob("*.atmo")))
    assert all(line.endswith(": ok") for line in lines)


def test_a_problem_of_a_file_that_sky_toml_names_is_told_once(tmp_path, told):
    folder = copy_scene("atmosphere_sky", tmp_path).parent
    atmo = folder / "clear.atmo"
    atmo.write_text(atmo.read_text().replace(":", ";", 1))
    said = told("validate", folder, code=3)
    assert said.err.count("clear.atmo:1:1: error[") == 1
    assert said.out.count("has errors") == 2


def test_of_a_source_file_head_and_checksum_are_checked(tmp_path, told):
    path = tmp_path / "x.sky"
    aomc_sky.write_source(aomc_sky.Scene(wavebands=[550.0], n_photons=100, components="uniform").source(1), path)
    assert told("validate", path).out == f"{path}: head and checksum are ok\n"
    (found,) = json.loads(told("validate", path, "--json").out)["files"]
    assert found["checked"] == "head and checksum"
    path.write_bytes(path.read_bytes()[:-64])
    assert f"{path}: has errors" in told("validate", path, code=3).out
