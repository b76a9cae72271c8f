"""Status lines, bars, tables and warnings: on a real terminal, in a pipe, in a notebook; cleared in the end."""

import functools
import io
import json
import sys
import termios
import threading
import time
import types
import warnings

import pytest
import tqdm.auto

import aomc_sky as sky
from aomc_sky import progress
from aomc_sky.cli.main import warnings_at_end
from aomc_sky.errors import InputWarning, SceneError
from aomc_sky.progress import counted
from aomc_sky.skies.atmosphere import model as sky_model
from aomc_sky.source.read import solve as directions
from tests.support.processes import resting
from tests.support.pseudo_terminal import pseudo_terminal, screen, start_in
from tests.support.scenes import coarse_atmosphere
from tests.support.shared import INPUTS


class Terminal(io.StringIO):
    """What a terminal got."""

    @property
    def is_clear(self):
        *_, last, end = ["", *self.getvalue().split("\r")]
        return last.strip() == end == ""


@pytest.fixture
def stream(monkeypatch):
    """Standard error of a terminal, where a tenth of a second is a long time."""
    stream = Terminal()
    monkeypatch.setattr(progress, "_stream", lambda: stream)
    monkeypatch.setattr(progress, "_PATIENCE_S", 0.1)
    return stream


def wait_for(stream, text):
    end = time.monotonic() + 10.0
    while text not in stream.getvalue():
        assert time.monotonic() < end, f"no {text!r} in {stream.getvalue()!r}"
        time.sleep(0.002)


def test_what_is_short_shows_nothing(stream, monkeypatch):
    monkeypatch.setattr(progress, "_PATIENCE_S", 600.0)
    with progress.status_line("drawing", enabled=True):
        pass
    assert stream.getvalue() == ""


def test_a_long_loop_says_how_far_it_is(stream):
    done = []
    with progress.status_line("drawing", enabled=True):
        wait_for(stream, "drawing: 00:0")
        for k in counted(range(3), "frame", 3):
            wait_for(stream, f"drawing, frame {k + 1} of 3: 00:0")
            done.append(k)
    assert done == [0, 1, 2]
    assert stream.is_clear
    assert list(counted("ab", "part", 2)) == ["a", "b"]


def test_a_bar_takes_the_line_once_it_begins(stream):
    with progress.progress_bar(enabled=True, before="solving") as draw:
        wait_for(stream, "solving: 00:0")
        for share, text in ((1, " 25%|"), (2, "2.00G/4.00G"), (3, "photons/s]"), (4, "100%")):
            draw(share * 10**9, 4 * 10**9)
            wait_for(stream, text)
    assert "\n" not in stream.getvalue()
    assert stream.is_clear


def test_an_error_leaves_a_clean_line_and_no_thread(stream):
    before = threading.active_count()

    def fail():
        with progress.progress_bar(enabled=True) as draw:
            draw(1, 2)
            wait_for(stream, "50%")
            raise ValueError("x")

    with pytest.raises(ValueError, match="x"):
        fail()
    assert stream.is_clear
    assert threading.active_count() <= before + 1  # tqdm's own


def slowly(monkeypatch, stream, text, module=sky_model, name="solve_sky"):
    """Let solving take until the terminal has a text."""
    solve = getattr(module, name)

    def solve_slowly(*arguments, **named):
        if text:
            wait_for(stream, text)
        else:
            time.sleep(0.3)
        return solve(*arguments, **named)

    monkeypatch.setattr(module, name, solve_slowly)


AIR = str(INPUTS / "atmosphere" / "molecules_only.atmo")


def commands(tmp_path):
    """Commands that solve, and what they say meanwhile."""
    scene = coarse_atmosphere(tmp_path)
    table = f"atmosphere {AIR} --wavelength 550 --bins 2 2 --no-netcdf --out-dir {tmp_path}/t"
    return {
        "scene": (f"plot {scene} --size 300 --out {tmp_path}/sky.png".split(), "preparing the scene"),
        "run": (f"run {scene} --iterations 10 --out {tmp_path}/out".split(), "preparing the scene"),
        "table": (table.split(), "solving"),
    }


@pytest.mark.parametrize(
    ("name", "option"), [("scene", ""), ("run", ""), ("table", ""), ("run", "-q"), ("table", "--json")]
)
def test_a_command_that_solves_says_so_and_clears_the_line(name, option, tmp_path, stream, monkeypatch, told):
    """A quiet command and one for programs say nothing."""
    pytest.importorskip("matplotlib")
    words, text = commands(tmp_path)[name]
    slowly(monkeypatch, stream, "" if option else text)
    assert text not in told(*words, *option.split()).out
    assert stream.getvalue() == "" if option else stream.is_clear


def test_python_shows_it_too(monkeypatch, tmp_path):
    """A run that Python writes and a sky that it solves; not inside something that shows nothing."""
    stream = Terminal()
    monkeypatch.setattr(progress, "_stream", lambda: stream)
    monkeypatch.setattr(progress, "_PATIENCE_S", 0.001)
    # tqdm draws every 0.1 s, and a fast machine needs less for the whole run
    monkeypatch.setattr(tqdm.auto, "tqdm", functools.partial(tqdm.auto.tqdm, mininterval=0.0))
    scene = sky.Scene(wavebands=[500], n_photons=6_000_000, components=sky.UniformSky())
    sky.write_run(scene, tmp_path / "shown")
    assert "/6.00M [" in stream.getvalue()
    shown = len(stream.getvalue())
    with progress.status_line("quiet", enabled=False):
        sky.write_run(scene, tmp_path / "silent")
    assert len(stream.getvalue()) == shown
    slowly(monkeypatch, stream, "solving the atmosphere", directions, "solve")
    angles = {"sun_zenith_deg": 30, "sky_zenith_deg": [0.0], "azimuth_from_sun_deg": [0.0]}
    sky.solve_atmosphere(AIR, wavelength_nm=600, **angles, orders=1)
    assert stream.is_clear


def test_one_text_is_one_warning_and_stands_before_the_error(capsys):
    def command():
        for text in ("old", "new", "old"):
            warnings.warn(text, InputWarning, stacklevel=1)
        assert capsys.readouterr().err == ""
        raise SceneError("dark")

    with pytest.raises(SceneError), warnings_at_end():
        command()
    assert capsys.readouterr().err == "aomc-sky: warning: old\naomc-sky: warning: new\n"


def test_a_notebook_gets_a_bar_a_pipe_and_a_quiet_command_none(monkeypatch):
    """Standard error of a notebook is no terminal; tqdm.auto finds out how to draw there."""
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress.progress_bar(enabled=True) as draw:
        assert draw is None
    monkeypatch.setattr(progress, "_stream", lambda: sys.stderr)
    with progress.progress_bar(enabled=False) as draw:
        assert draw is None
    monkeypatch.undo()
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setitem(sys.modules, "ipykernel", types.ModuleType("ipykernel"))
    with progress.progress_bar(enabled=True) as draw:
        assert draw is not None


def test_json_is_json_on_a_terminal(amc):
    with pseudo_terminal(40) as (slave, seen):
        with start_in(slave, [sys.executable, "-m", "aomc_sky", "info", str(amc), "--json"]) as program:
            program.wait()
        assert seen.wait_for("}")
    assert json.loads("".join(seen.text.split("\r\n")))["wavebands"] == [555.0, 580.0, 640.0]


def test_ctrl_c_leaves_a_sane_terminal(amc, tmp_path):
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
