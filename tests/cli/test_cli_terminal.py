"""Tables, progress and warnings on a real terminal, with and without rich, and plain text everywhere else."""

from __future__ import annotations

import json
import os
import re
import sys
import termios
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from aomc_sky.cli.progress import progress_bar
from aomc_sky.cli.terminal import table, terminal_of, warnings_at_end
from aomc_sky.errors import InputWarning, SceneError
from tests.support.pseudo_terminal import pseudo_terminal, screen, set_width, start_in
from tests.support.scenes import copy_scene

WIDTHS = (40, 80, 200)
COLOUR = "\x1b["
LONG_NAME = "the-glow-of-a-town-beyond-the-hills-in-the-north-east-of-the-station"

SENTENCES = ("run folder ", "note: ", "counts.csv: ", "plan.npz: ", "irradiance of ", "components: ", "... ")

FORMS = [
    "plain",
    pytest.param("rich", marks=pytest.mark.skipif(find_spec("rich") is None, reason="rich is not installed")),
]


@pytest.fixture(autouse=True)
def usual_terminal(monkeypatch):
    monkeypatch.setenv("TERM", "xterm-256color")
    for name in ("CI", "NO_COLOR", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def choose(form: str, monkeypatch) -> None:
    """Take rich away for the plain form."""
    if form == "plain":
        monkeypatch.setitem(sys.modules, "rich", None)


class Shown:
    """What a block writes to standard output and standard error, both the same terminal."""

    def __init__(self, width: int, monkeypatch) -> None:
        self._width = width
        self._monkeypatch = monkeypatch

    def __enter__(self) -> Shown:
        self._terminal = pseudo_terminal(self._width)
        slave, self.seen = self._terminal.__enter__()
        self._stream = open(os.dup(slave), "w", encoding="utf-8", buffering=1)
        self._patch = self._monkeypatch.context()
        patch = self._patch.__enter__()
        patch.setattr(sys, "stdout", self._stream)
        patch.setattr(sys, "stderr", self._stream)
        return self

    def __exit__(self, *error: object) -> None:
        self._patch.__exit__(*error)
        self._stream.close()
        self._terminal.__exit__(None, None, None)

    @property
    def text(self) -> str:
        return self.seen.text

    @property
    def lines(self) -> list[str]:
        return screen(self.text, self._width)


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory) -> Path:
    """A run of 100 wavebands with a component of a long name, made from one of three."""
    folder = tmp_path_factory.mktemp("terminal")
    amc = copy_scene("document_example", folder)
    assert main(["run", str(amc), "--iterations", "1000", "--out", str(folder / "out"), "--format", "none", "-q"]) == 0
    path = folder / "out" / "manifest.json"
    manifest = json.loads(path.read_text())
    band = manifest["bands"][0]
    light = {"irradiance_W_m2_nm": 1.25, "component_irradiance_W_m2_nm": {"sun": 1.0, LONG_NAME: 0.25}}
    manifest["bands"] = [{**band, **light, "waveband": k + 1, "wavelength_nm": 400.0 + k} for k in range(100)]
    path.write_text(json.dumps(manifest))
    (folder / "out" / "plan.npz").unlink()  # it knows three wavebands
    return folder / "out"


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("width", WIDTHS)
def test_a_table_fits_or_folds(form, width, run_folder, monkeypatch):
    choose(form, monkeypatch)
    with Shown(width, monkeypatch) as shown:
        assert main(["info", str(run_folder)]) == 0
    whole = re.sub(r"\x1b\[[0-9;]*m", "", shown.text).splitlines()
    assert all(line.startswith(SENTENCES) for line in whole if len(line) > width)
    words = " ".join(whole).split()
    assert words.count("requested") == words.count("launched") == words.count("residual") == 1
    assert words.count("(photons)") == 2
    heads = [line for line in whole if line.split()[:2] == ["band", "nm"]]
    assert len(heads) == {40: 6, 80: 3, 200: 2}[width]
    assert sum(line.split()[:2] == ["40", "439"] for line in whole) == len(heads)  # the last row shown, in every fold
    assert not any(line.split()[-1:] == ["cosine"] for line in heads)  # its error is beside it
    assert (LONG_NAME in words) == (width == 200)
    assert LONG_NAME[-9:] in "".join(words)
    assert "... and 60 more wavebands (manifest.json has all)" in whole
    assert (COLOUR in shown.text) == (form == "rich")


@pytest.mark.parametrize("form", FORMS)
def test_no_colour_where_none_is_wanted(form, run_folder, monkeypatch):
    choose(form, monkeypatch)
    monkeypatch.setenv("NO_COLOR", "1")
    with Shown(80, monkeypatch) as shown:
        assert main(["info", str(run_folder)]) == 0
        with progress_bar(enabled=True) as draw:
            draw(50, 100)
            draw(100, 100)
    bars = [part for part in shown.text.split("\x1b[K") if "%" in part]
    assert bars[0].index("%") == 45
    assert bars[0].count(bars[0][1]) == pytest.approx(20, abs=2)  # half of the bar is drawn
    assert set(re.findall(r"\x1b\[[0-9;]*[a-zA-Z]", shown.text)) == {"\x1b[K"}


@pytest.mark.parametrize(("name", "value"), [("TERM", "dumb"), ("TERM", ""), ("CI", "true"), ("CI", "1")])
def test_plain_text_where_nothing_can_be_drawn_over(name, value, run_folder, monkeypatch, capsys):
    assert main(["info", str(run_folder)]) == 0
    piped = capsys.readouterr().out
    monkeypatch.setenv(name, value)
    with Shown(40, monkeypatch) as shown:
        assert main(["info", str(run_folder)]) == 0
        with progress_bar(enabled=True) as draw:
            assert draw is None
    assert shown.text.replace("\r\n", "\n") == piped


def test_a_pipe_gets_what_it_always_got(capsys):
    rows = [("1", "a\x1b[2J"), ("22", "long " * 40)]
    assert table(rows, ("n", "name")).splitlines() == [
        " n  " + "name".rjust(200),
        " 1  " + "a\N{REPLACEMENT CHARACTER}[2J".rjust(200),
        "22  " + "long " * 40,
    ]
    assert table([("a", "1"), ("bb", "22")], ("x", "n"), n_left=1) == "x    n\na    1\nbb  22"
    assert table([], ("x", "n")) == "x  n"


@pytest.mark.parametrize("form", FORMS)
def test_json_is_json_on_a_terminal(form, run_folder, monkeypatch):
    choose(form, monkeypatch)
    with Shown(40, monkeypatch) as shown:
        assert main(["info", str(run_folder), "--json"]) == 0
    assert json.loads(shown.text) == json.loads((run_folder / "manifest.json").read_text())


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("width", [20, *WIDTHS])
def test_a_bar_of_any_width_is_one_line_and_goes(form, width, monkeypatch):
    choose(form, monkeypatch)
    monkeypatch.setattr("aomc_sky.cli.progress._INTERVAL_S", 0.0)
    with Shown(width, monkeypatch) as shown, progress_bar(enabled=True) as draw:
        for done in (0, 1, 3 * 10**9, 4 * 10**9):
            draw(done, 4 * 10**9)
        seen = shown.lines if shown.seen.wait_for("100 %") else []
    assert len(seen) == 1
    assert "100 %" in seen[0]
    assert ("million photons/s" in seen[0]) == (width > 40)
    assert "0 s left" in seen[0]
    assert (seen[0][0] in "[\N{BOX DRAWINGS HEAVY HORIZONTAL}") == (width > 20)
    assert shown.lines == [""]
    assert "\n" not in shown.text


@pytest.mark.parametrize("form", FORMS)
def test_a_bar_follows_the_window(form, monkeypatch):
    choose(form, monkeypatch)
    monkeypatch.setattr("aomc_sky.cli.progress._INTERVAL_S", 0.0)
    with Shown(80, monkeypatch) as shown, progress_bar(enabled=True) as draw:
        draw(1, 4)
        set_width(sys.stderr.fileno(), 40)
        draw(2, 4)
        set_width(sys.stderr.fileno(), 80)
        draw(3, 4)
    lines = [screen(part, 80) for part in shown.text.split("\r\x1b[K") if "%" in part]
    assert [len(line) for line in lines] == [1, 1, 1]
    assert len(lines[1][0]) < 40 < min(len(lines[0][0]), len(lines[2][0]))


def test_nothing_to_do_draws_nothing(monkeypatch):
    with Shown(80, monkeypatch) as shown, progress_bar(enabled=True) as draw:
        draw(0, 0)
    assert shown.text == "\r\x1b[K"


@pytest.mark.parametrize("form", FORMS)
def test_warnings_once_and_last(form, tmp_path, monkeypatch):
    choose(form, monkeypatch)
    amc = copy_scene("document_example", tmp_path)
    sky = amc.parent / "skydist.inp"
    sky.write_text(sky.read_text().replace("6 2 2 2", "5 2 2 2"))  # a row more than announced
    words = ["run", str(amc), "--lenient", "--iterations", "100", "--format", "none", "--out", str(tmp_path / "out")]
    with Shown(200, monkeypatch) as shown:
        assert main(words) == 0
    warned = [k for k, line in enumerate(shown.lines) if "warning[" in line]
    assert len(warned) >= 1
    assert warned[0] > next(k for k, line in enumerate(shown.lines) if line.startswith("plan "))
    assert len({shown.lines[k] for k in warned}) == len(warned)


def test_one_text_is_one_warning_and_stands_before_the_error(capsys):
    def command() -> None:
        for text in ("old", "new", "old"):
            warnings.warn(text, InputWarning, stacklevel=1)
        assert capsys.readouterr().err == ""
        raise SceneError("dark")

    with pytest.raises(SceneError), warnings_at_end():
        command()
    assert capsys.readouterr().err == "aomc-sky: warning: old\naomc-sky: warning: new\n"


def test_the_width_is_that_of_the_terminal_or_of_the_environment(monkeypatch):
    for given, told, width in ((0, "", 80), (5, "", 20), (132, "", 132), (132, "60", 60), (132, "wide", 132)):
        monkeypatch.setenv("COLUMNS", told)
        with Shown(given, monkeypatch):
            found = terminal_of(sys.stdout).width
        assert found == width


WITHOUT_RICH = (
    "import sys; sys.modules['rich'] = None; from aomc_sky.cli.main import main; sys.exit(main(sys.argv[1:]))"
)


@pytest.mark.parametrize("form", FORMS)
def test_ctrl_c_leaves_a_sane_terminal(form, tmp_path):
    amc = copy_scene("document_example", tmp_path)
    start = ["-c", WITHOUT_RICH] if form == "plain" else ["-m", "aomc_sky"]
    words = ["run", str(amc), "--iterations", "1e9", "--threads", "1", "--out", str(tmp_path / "out")]
    with pseudo_terminal(80) as (slave, seen):
        before = termios.tcgetattr(slave)
        command = [sys.executable, *start, *words]
        with start_in(slave, command) as program:
            while program.poll() is None and not seen.wait_for(" left", 0.5):
                pass  # kernels may have to be compiled
            seen.type("\x03")
        assert " left" in seen.text, seen.text
        assert program.returncode == 130
        after = termios.tcgetattr(slave)
    assert after == before
    assert screen(seen.text, 80)[-2:] == ["aomc-sky: interrupted; run the same command to continue", ""]
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
