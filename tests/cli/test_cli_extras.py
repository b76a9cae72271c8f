"""Without an extra: what wants it says so in one line with exit code 2, everything else works."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.extras import (
    DISTRIBUTIONS,
    PACKAGES,
    Absent,
    commands_of_core,
    commands_wanting,
    commands_wanting_two,
    extras_of_project,
    hint,
)
from tests.support.shared import INPUTS, REPOSITORY

SOURCE = REPOSITORY / "src" / "aomc_sky"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
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


def constants_of(tree: ast.Module) -> dict[str, str]:
    """Texts that a module gives names to, its imports of such names followed."""
    found: dict[str, str] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            found |= {target.id: node.value.value for target in node.targets if isinstance(target, ast.Name)}
        elif isinstance(node, ast.ImportFrom) and "EXTRA" in {alias.name for alias in node.names}:
            path = SOURCE.joinpath(*node.module.split(".")[1:]).with_suffix(".py")
            found |= constants_of(ast.parse(path.read_text()))
    return found


def optional_imports() -> list[tuple[str, str, str]]:
    """File, package and extra of every call of `optional_module` that names both."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        if "optional_module(" not in (text := path.read_text()):
            continue
        tree = ast.parse(text)
        known = constants_of(tree)
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call) or getattr(node.func, "id", "") != "optional_module":
                continue
            name, extra = node.args[0], node.keywords[0].value
            name = name.values[0] if isinstance(name, ast.JoinedStr) else name
            given = extra.value if isinstance(extra, ast.Constant) else known.get(extra.id)
            if isinstance(name, ast.Constant) and given:  # others loop over names, or hand an argument on
                found.append((path.name, str(name.value).partition(".")[0], given))
    return found


def test_every_hint_names_an_extra_that_brings_the_package():
    calls = optional_imports()
    assert len(calls) > 15
    assert [call for call in calls if call[1] not in PACKAGES[call[2]]] == []


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


@pytest.mark.parametrize("pair", [("hdf5", "plot")])
def test_of_two_extras_the_missing_one_is_named(pair, folder, monkeypatch, capsys):
    for name in PACKAGES[pair[0]]:
        pytest.importorskip(name)
    Absent([name for name in PACKAGES[pair[1]] if name not in PACKAGES[pair[0]]]).hide(monkeypatch)
    for words in commands_wanting_two(folder)[pair]:
        assert main(list(words)) == 2
        assert capsys.readouterr().err.endswith(hint(pair[1]))


def test_everything_else_works_without_any(folder, monkeypatch, capsys):
    Absent([name for packages in PACKAGES.values() for name in packages]).hide(monkeypatch)
    for words in commands_of_core(folder):
        assert main(list(words)) == 0, words
        assert capsys.readouterr().err == ""
