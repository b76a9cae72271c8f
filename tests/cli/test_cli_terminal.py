"""Tables, warnings and progress: on a real terminal, in a pipe, in a notebook."""

import io
import json
import sys
import termios
import types
import warnings

import pytest

from aomc_sky import progress
from aomc_sky.cli.main import warnings_at_end
from aomc_sky.errors import InputWarning, SceneError
from aomc_sky.progress import progress_bar
from tests.support.processes import resting
from tests.support.pseudo_terminal import pseudo_terminal, screen, start_in
from tests.support.scenes import copy_scene


def test_one_text_is_one_warning_and_stands_before_the_error(capsys):
    def command():
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


def test_json_is_json_on_a_terminal(tmp_path):
    amc = copy_scene("document_example", tmp_path)
    with pseudo_terminal(40) as (slave, seen):
        with start_in(slave, [sys.executable, "-m", "aomc_sky", "info", str(amc), "--json"]) as program:
            program.wait()
        assert seen.wait_for("}")
    assert json.loads("".join(seen.text.split("\r\n")))["wavebands"] == [555.0, 580.0, 640.0]


def test_ctrl_c_leaves_a_sane_terminal(tmp_path):
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
    *_, last, end = screen(seen.text)
    assert last.removesuffix("^C").rstrip() == "aomc-sky: interrupted; run the same command to continue"
    assert end == ""
    assert not any("%" in line for line in screen(seen.text))


def test_only_a_run_that_goes_on_says_so(monkeypatch, told):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("aomc_sky.cli.options.scene_of", interrupt)
    for words, hint in (
        (["run", "a"], True),
        (["run", "a", "--out", "-", "--format", "raw"], False),
        (["info", "a"], False),
    ):
        assert ("run the same command" in told(*words, code=130).err) == hint
