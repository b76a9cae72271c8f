"""Usage mistakes: what is wrong comes first, then what was meant; with --json one object of a published schema."""

import json
import re
import shlex
import shutil
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import pytest

from aomc_sky.cli import commands
from aomc_sky.cli.usage import COMMANDS
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS, REPOSITORY


def make_folder(folder):
    """A scene, a run of it, a scene whose sky.toml has an unknown key, an atmosphere, and a program."""
    from aomc_sky.cli.main import main

    copy_scene("document_example", folder).parent.rename(folder / "scene")
    words = ["run", str(folder / "scene"), "--iterations", "100", "-q", "--out"]
    assert main([*words, str(folder / "out")]) == 0
    shutil.copytree(INPUTS / "perez_sky", folder / "misspelt")
    (folder / "misspelt" / "sky.toml").write_text("[perez]\ndni = 850.0\ndiffuse = 95.0\n")
    shutil.copy(INPUTS / "atmosphere" / "molecules_only.atmo", folder / "air.atmo")
    (folder / "my_sky.py").write_text("import aomc_sky\n")
    (folder / "scan.alm").write_text(
        "AERONET Version 3\nAlmucantar,Level 1.5\nDate,Wavelength,-6,-5\n01:01:2020,0.44,1,2\n"
    )
    (folder / "scan.dat").write_text("10 20 0.3\n10 30 0.4\n")


PAGES = (REPOSITORY / "docs" / "errors.md", Path(__file__).with_name("mistakes.md"))
ROWS = [row for page in PAGES for row in re.findall(r"(?m)^\| `aomc-sky ?(.*?)` \| `(.*)` \|$", page.read_text())]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("mistakes")
    make_folder(made)
    return made


def test_first_lines_are_those_of_the_pages(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert len(ROWS) == 44
    for words, line in ROWS:
        status = command(*shlex.split(words))
        said = capsys.readouterr()
        assert (status in (2, 3), said.out) == (True, ""), words
        shown = said.err.splitlines()
        assert shown[0] == line.replace("\\|", "|"), words
        assert len(shown) <= 3


@pytest.mark.parametrize("words", [[], ["fly"], ["validate"], ["run", "a", "b"]])
def test_the_second_line_names_the_help(words, told):
    first, second = told(*words, code=2).err.splitlines()
    assert first.startswith("aomc-sky: error: ")
    assert re.fullmatch(r"      = help: aomc-sky (\w+ )?--help", second)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_without_a_word_says_what_it_needs(name, told):
    assert 1 <= len(told(name, code=2).err.splitlines()) <= 2


def test_json_stands_behind_the_command(told):
    (problem,) = json.loads(told("--json", "info", "x", code=2).out)["error"]["problems"]
    assert "--json stands before the command; write aomc-sky COMMAND ... --json" in problem["message"]


def test_errors_of_every_kind_are_one_object(folder, tmp_path, monkeypatch, capsys):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((files("aomc_sky") / "cli" / "error.schema.json").read_text())
    validator = jsonschema.Draft7Validator(schema)  # what is used of 2020-12 is the same there
    monkeypatch.chdir(folder)
    broken = tmp_path / "skydist.inp"
    broken.write_text((folder / "scene" / "skydist.inp").read_text().replace("20.0", "nan"))
    expected = {
        "run scene --ordre patch": (2, "usage", None),
        "run scene --replicates 2 --format npy --format none": (2, "usage", None),
        "run misspelt": (3, "E702", 3),
        "run out": (3, "E100", None),
        "run scene --iterations 9e18": (4, "scene", None),
        "run scene --seed 2 --out out": (5, "foreign-output", None),
        "run scene --out /dev/null/x": (6, "output", None),
        f"plot {broken} --out {tmp_path}/x.png": (3, "E302", 5),
        "info none.h5 --time 0": (3, "E500", None),
    }
    for line, (status, code, at) in expected.items():
        needed = {"plot": "matplotlib", "info": "h5py"}.get(line.split()[0])
        if needed and find_spec(needed) is None:
            status, code, at = 2, "missing-extra", None
        assert command(*line.split(), "--json") == status, line
        said = capsys.readouterr()
        assert said.err == "", line
        answer = json.loads(said.out)
        assert list(validator.iter_errors(answer)) == []
        problem = answer["error"]["problems"][0]
        assert (answer["error"]["exit_status"], problem["code"], problem["line"]) == (status, code, at), line


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_short_and_says_where_the_rest_is(name, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    shown = {}
    for flag in ("--help", "--help-all"):
        assert command(name, flag) == 0 or flag == "--help-all"
        shown[flag] = capsys.readouterr().out
    short = shown["--help"]
    assert sum(1 + max(len(line) - 1, 0) // 80 for line in short.splitlines()) <= 60
    assert short.startswith(f"usage: aomc-sky {name} ")
    if "--help-all" in short:
        n_hidden = int(re.search(r"(\d+) more options with --help-all", short)[1])
        listed = {key: set(re.findall(r"(?m)^  (?:-\w, )?(--[a-z0-9-]+)", text)) for key, text in shown.items()}
        assert listed["--help"] < listed["--help-all"]
        assert len(listed["--help-all"] - listed["--help"]) == n_hidden
    assert commands.__doc__.count(f"aomc-sky {name}`") == 1
