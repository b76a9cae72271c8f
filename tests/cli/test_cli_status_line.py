"""What takes more than a second says so on a terminal: one line, cleared in the end, and never without a terminal."""

import functools
import io
import threading
import time

import pytest
import tqdm.auto

import aomc_sky as sky
from aomc_sky import progress
from aomc_sky.cli.main import main
from aomc_sky.progress import counted
from aomc_sky.skies.atmosphere import model as sky_model
from aomc_sky.source.read import solve as directions
from tests.support.scenes import coarse_atmosphere
from tests.support.shared import INPUTS


class Terminal(io.StringIO):
    """What a terminal got."""

    @property
    def is_clear(self):
        """Whether the line is empty, and the cursor at its begin."""
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


@pytest.mark.parametrize("name", ["scene", "run", "table"])
def test_a_command_that_solves_says_so_and_clears_the_line(name, tmp_path, stream, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    words, text = commands(tmp_path)[name]
    slowly(monkeypatch, stream, text)
    assert main(words) == 0
    assert stream.is_clear
    assert text not in capsys.readouterr().out


@pytest.mark.parametrize(("name", "option"), [("scene", "--json"), ("run", "-q"), ("table", "--json")])
def test_a_quiet_command_and_one_for_programs_say_nothing(name, option, tmp_path, stream, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    words, _ = commands(tmp_path)[name]
    slowly(monkeypatch, stream, "")
    assert main([*words, option]) == 0
    assert stream.getvalue() == ""


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
