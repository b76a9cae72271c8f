"""What takes more than a second says so on a terminal: one line, cleared in the end, and never without a terminal."""

from __future__ import annotations

import io
import logging
import time

import pytest

from aomc_sky.cli import progress
from aomc_sky.cli.main import main
from aomc_sky.cli.terminal import Terminal
from aomc_sky.skies import atmosphere as sky_model
from aomc_sky.steps import STEPS, counted
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

CLEAR = "\r\033[K"


@pytest.fixture
def stream(monkeypatch):
    """What a terminal got, where a hundredth of a second is a long time."""
    stream = io.StringIO()
    terminal = Terminal(stream=stream, width=60, has_colour=False)
    monkeypatch.setattr(progress, "terminal_of", lambda _: terminal)
    monkeypatch.setattr(progress, "_PATIENCE_S", 0.01)
    return stream


def wait_for(stream, text):
    end = time.monotonic() + 10.0
    while text not in stream.getvalue():
        assert time.monotonic() < end, f"no {text!r} in {stream.getvalue()!r}"
        time.sleep(0.002)


def test_the_inner_text_takes_the_place_of_the_outer_one_while_it_lasts(stream):
    with progress.patience("drawing", enabled=True):
        wait_for(stream, "drawing: 0 s")
        with progress.patience("solving", enabled=True):
            wait_for(stream, "solving: 0 s")
            with progress.patience("unseen", enabled=False):
                pass
        stream.truncate(0)
        wait_for(stream, "drawing: 0 s")
    assert stream.getvalue().endswith(CLEAR)
    assert "unseen" not in stream.getvalue()
    assert progress._under_way == []


def test_a_long_loop_says_how_far_it_is(stream):
    done = []
    with progress.patience("drawing", enabled=True):
        for k in counted(range(3), "frame", 3):
            wait_for(stream, f"drawing, frame {k + 1} of 3: 0 s")
            done.append(k)
    assert done == [0, 1, 2]
    assert not STEPS.isEnabledFor(logging.DEBUG)  # nobody pays for texts that nobody sees
    assert list(counted("ab", "part", 2)) == ["a", "b"]


def test_a_bar_takes_the_line_once_it_begins(stream):
    with progress.progress_bar(enabled=True, before="solving") as draw:
        wait_for(stream, "solving: 0 s")
        draw(0, 0)  # nothing to draw yet
        draw(1, 4)
        stream.truncate(0)
        time.sleep(0.1)
        assert "solving" not in stream.getvalue()
    assert stream.getvalue().endswith(CLEAR)
    assert progress._under_way == []


def test_an_error_leaves_a_clean_line_and_no_thread(stream):
    def fail():
        with progress.patience("drawing", enabled=True), progress.progress_bar(enabled=True) as draw:
            draw(1, 2)
            raise ValueError("x")

    with pytest.raises(ValueError, match="x"):
        fail()
    assert stream.getvalue().endswith(CLEAR)
    assert progress._under_way == []


def slowly(monkeypatch, stream, text):
    """Let solving take until the terminal has a text."""
    solve = sky_model.solve_sky

    def solve_slowly(*arguments, **named):
        if text:
            wait_for(stream, text)
        else:
            time.sleep(0.1)
        return solve(*arguments, **named)

    monkeypatch.setattr(sky_model, "solve_sky", solve_slowly)


AIR = str(INPUTS / "atmosphere" / "molecules_only.atmo")


def commands(tmp_path):
    """Commands that solve, and what they say meanwhile."""
    scene = copy_scene("atmosphere_sky", tmp_path)
    toml = scene.with_name("sky.toml")
    few = 'clear.atmo"\nmethod = "order1"\nzenith_bins = 2\nazimuth_bins = 2\n'
    toml.write_text(toml.read_text(encoding="utf-8").replace('clear.atmo"', few), encoding="utf-8")
    out = str(tmp_path / "sky.png")
    return {
        "scene": (["plot", str(scene), "--size", "300", "--out", out], "preparing the scene: 0 s"),
        "model": (["plot", AIR, "--wavelength", "550", "--size", "300", "--out", out], "solving the atmosphere: 0 s"),
        "run": (["run", str(scene), "--iterations", "10", "--out", str(tmp_path / "out")], "preparing the scene: 0 s"),
        "table": (
            [
                "atmosphere",
                AIR,
                "--wavelength",
                "550",
                "--bins",
                "2",
                "2",
                "--no-netcdf",
                "--out-dir",
                str(tmp_path / "t"),
            ],
            "solving: 0 s",
        ),
    }


@pytest.mark.parametrize("name", ["scene", "model", "run", "table"])
def test_a_command_that_solves_says_so_and_clears_the_line(name, tmp_path, stream, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    words, text = commands(tmp_path)[name]
    slowly(monkeypatch, stream, text)
    assert main(words) == 0
    assert stream.getvalue().endswith(CLEAR)
    assert text not in capsys.readouterr().out


@pytest.mark.parametrize("option", ["-q", "--json"])
@pytest.mark.parametrize("name", ["scene", "model", "run", "table"])
def test_a_quiet_command_and_one_for_programs_say_nothing(name, option, tmp_path, stream, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    words, _ = commands(tmp_path)[name]
    slowly(monkeypatch, stream, "")
    assert main([*words, option]) == 0
    assert stream.getvalue() == ""


def test_a_perez_picture_says_what_it_writes(tmp_path, stream, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    words = ["perez", "--sun-zenith", "40", "--dni", "800", "--dhi", "100", "--plot", str(tmp_path / "p.png")]
    assert main(words) == 0
    assert "writing p.png: 0 s" in stream.getvalue()
    assert stream.getvalue().endswith(CLEAR)
