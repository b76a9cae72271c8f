"""Without an extra: what wants it says so in one line with exit code 2, everything else works."""

import importlib
import re

import pytest

from aomc_sky.cli.main import main
from tests.support.extras import (
    DISTRIBUTIONS,
    NIGHT,
    PACKAGES,
    Absent,
    commands_of_core,
    commands_wanting,
    extras_of_project,
    hint,
)
from tests.support.shared import INPUTS, REPOSITORY

SOURCE = REPOSITORY / "src" / "aomc_sky"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("extras")
    words = ["run", str(INPUTS / "clear_day"), "--iterations", "1000", "--format", "none", "-q"]
    assert main([*words, "--out", str(made / "out")]) == 0
    return made


def test_extras_of_the_project():
    extras = extras_of_project()
    assert set(extras) == {*PACKAGES, "test", "dev", "docs", "release", "all"}
    assert extras["all"] == [f"aomc-sky[{','.join(name for name in extras if name in PACKAGES)}]"]
    for extra, packages in PACKAGES.items():
        for name in packages:
            assert DISTRIBUTIONS.get(name, name) in extras[extra]


def test_every_hint_names_an_extra_that_brings_the_package():
    calls = []
    for path in SOURCE.rglob("*.py"):
        module = ".".join(["aomc_sky", *path.relative_to(SOURCE).with_suffix("").parts])
        for name, extra in re.findall(r'optional_module\("(\w+)[\w.]*", extra=("\w+"|EXTRA)\)', path.read_text()):
            calls.append((name, extra.strip('"') if extra != "EXTRA" else importlib.import_module(module).EXTRA))
    assert len(calls) > 15
    assert [call for call in calls if call[0] not in PACKAGES[call[1]]] == []


@pytest.mark.parametrize("extra", sorted(PACKAGES))
def test_what_wants_an_extra_names_it(extra, folder, monkeypatch, capsys):
    Absent(PACKAGES[extra]).hide(monkeypatch)
    for words in commands_wanting(folder)[extra]:
        assert main(list(words)) == 2, words
        said = capsys.readouterr()
        assert said.err.startswith("aomc-sky: error: this needs the package "), words
        assert said.err.endswith(hint(extra))
        assert said.err.count("\n") == 1
        assert said.out == (f"{words[1]}: not read\n" if words[0] == "validate" else "")
    assert not list(folder.glob("new*"))


def test_of_two_extras_the_missing_one_is_named(folder, monkeypatch, capsys):
    pytest.importorskip("h5py")
    Absent(PACKAGES["plot"]).hide(monkeypatch)
    assert main(["plot", NIGHT, "--time", "2026-02-14T21:30:00Z", "--out", str(folder / "new.svg")]) == 2
    assert capsys.readouterr().err.endswith(hint("plot"))


def test_everything_else_works_without_any(folder, monkeypatch, capsys):
    Absent([name for packages in PACKAGES.values() for name in packages]).hide(monkeypatch)
    for words in commands_of_core(folder):
        assert main(list(words)) == 0, words
        assert capsys.readouterr().err == ""
