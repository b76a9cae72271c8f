"""Tables, warnings and progress: on a real terminal, in a pipe, in a notebook."""

from __future__ import annotations

import io
import json
import sys
import termios
import types
import warnings
from pathlib import Path

import pytest

from aomc_sky import progress
from aomc_sky.cli.main import main, warnings_at_end
from aomc_sky.cli.terminal import table
from aomc_sky.errors import InputWarning, SceneError
from aomc_sky.progress import progress_bar
from tests.support.processes import resting
from tests.support.pseudo_terminal import pseudo_terminal, screen, start_in
from tests.support.scenes import copy_scene


def test_a_table_is_a_line_for_each_row():
    rows = [("1", "a\x1b[2J"), ("22", "long " * 10)]
    assert table(rows, ("n", "name")).splitlines() == [
        " n  " + "name".rjust(50),
        " 1  " + "a\\x1b[2J".rjust(50),
        "22  " + ("long " * 10).rstrip(),
    ]
    assert table([("a", "1"), ("bb", "22")], ("x", "n"), n_left=1) == "x    n\na    1\nbb  22"
    assert table([], ("x", "n")) == "x  n"


def test_warnings_once_and_last(tmp_path: Path, capsys):
    amc = copy_scene("document_example", tmp_path)
    sky = amc.parent / "skydist.inp"
    sky.write_text(sky.read_text().replace("6 2 2 2", "5 2 2 2"))  # a row more than announced
    words = ["run", str(amc), "--lenient", "--iterations", "100", "--format", "none", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    said = capsys.readouterr()
    warned = [line for line in said.err.splitlines() if "warning[" in line]
    assert len(warned) == len(set(warned)) >= 1
    assert "warning[" not in said.out


def test_one_text_is_one_warning_and_stands_before_the_error(capsys):
    def command() -> None:
        for text in ("old", "new", "old"):
            warnings.warn(text, InputWarning, stacklevel=1)
        assert capsys.readouterr().err == ""
        raise SceneError("dark")

    with pytest.raises(SceneError), warnings_at_end():
        command()
    assert capsys.readouterr().err == "aomc-sky: warning: old\naomc-sky: warning: new\n"


def test_a_pipe_and_a_quiet_command_get_no_bar(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress_bar(enabled=True) as draw:
        assert draw is None
    monkeypatch.setattr(progress, "_stream", lambda: sys.stderr)
    with progress_bar(enabled=False) as draw:
        assert draw is None


def test_a_notebook_gets_a_bar(monkeypatch):
    """Its standard error is no terminal; tqdm.auto finds out how to draw there."""
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setitem(sys.modules, "ipykernel", types.ModuleType("ipykernel"))
    with progress_bar(enabled=True) as draw:
        assert draw is not None


def test_json_is_json_on_a_terminal(tmp_path: Path):
    amc = copy_scene("document_example", tmp_path)
    with pseudo_terminal(40) as (slave, seen):
        with start_in(slave, [sys.executable, "-m", "aomc_sky", "info", str(amc), "--json"]) as program:
            program.wait()
        assert seen.wait_for("}")
    assert json.loads("".join(seen.text.split("\r\n")))["wavebands"] == [555.0, 580.0, 640.0]


def test_ctrl_c_leaves_a_sane_terminal(tmp_path: Path):
    amc = copy_scene("document_example", tmp_path)
    command = resting("run", amc, "--iterations", "2e5", "--out", tmp_path / "out", block=2)
    with pseudo_terminal(80) as (slave, seen):
        before = termios.tcgetattr(slave)
        with start_in(slave, command) as program:
            while program.poll() is None and not seen.wait_for("photons/s", 0.5):
                pass  # kernels may have to be compiled
            seen.type("\x03")
        assert "photons/s" in seen.text, seen.text
        assert program.returncode == 130
        after = termios.tcgetattr(slave)
    assert after == before
    *_, last, end = screen(seen.text, 80)
    assert last.removesuffix("^C").rstrip() == "aomc-sky: interrupted; run the same command to continue"
    assert end == ""
    assert not any("%" in line for line in screen(seen.text, 80))


def test_only_a_run_that_goes_on_says_so(monkeypatch, capsys):
    def interrupt(*_: object, **__: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("aomc_sky.cli.options.scene_of", interrupt)
    for words, hint in (
        (["run", "a"], True),
        (["run", "a", "--out", "-", "--format", "raw"], False),
        (["info", "a"], False),
    ):
        assert main(words) == 130
        assert ("run the same command" in capsys.readouterr().err) == hint
