"""Pages that a reader follows: everything they say to type is typed, and what they show comes out."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.pages import Command, SavedFile, carry_out, steps


def test_tutorial(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert carry_out("tutorial.md", tmp_path) == 10


def test_page_of_aomc_users(tmp_path: Path) -> None:
    assert carry_out("howto/from_aomc.md", tmp_path) == 6


def test_page_of_libradtran_users(tmp_path: Path) -> None:
    assert carry_out("howto/from_libradtran.md", tmp_path) == 4


def test_page_of_own_skies(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    assert carry_out("howto/own_sky.md", tmp_path) == 5


def test_page_of_weather(tmp_path: Path) -> None:
    pytest.importorskip("pvlib")
    assert carry_out("howto/weather.md", tmp_path) == 6


def test_page_of_mcpl_codes(tmp_path: Path) -> None:
    pytest.importorskip("mcpl")
    assert carry_out("howto/to_mcpl_codes.md", tmp_path) == 3


def test_steps_are_files_and_commands_in_order() -> None:
    page = "```sh\npip\n```\n```python\n# a.py\nprint(1)\n```\n```console\n$ python a.py\n1\n$ ls\n```\n"
    assert list(steps(page)) == [
        SavedFile("a.py", "# a.py\nprint(1)\n"),
        Command("python a.py", "1\n"),
        Command("ls", ""),
    ]


@pytest.mark.parametrize(
    "page",
    ["```console\n$ echo 1\n2\n```\n", "```console\n$ false\n```\n", "```python\nprint(1)\n```\n"],
    ids=["other output", "failed command", "file without a name"],
)
def test_wrong_page_is_noticed(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    docs = tmp_path / "repository" / "docs"
    (tmp_path / "repository" / "inputs").mkdir(parents=True)
    docs.mkdir()
    (docs / "wrong.md").write_text(page)
    (tmp_path / "work").mkdir()
    monkeypatch.setattr("tests.support.pages.REPOSITORY", tmp_path / "repository")
    with pytest.raises(AssertionError):
        carry_out("wrong.md", tmp_path / "work")
