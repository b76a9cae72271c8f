"""Standard streams: closed or full, as a pipe of photons, with control characters; Ctrl-C before the work begins."""

import io
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from aomc_sky import read_scene
from aomc_sky.cli import main as front_door
from aomc_sky.cli.main import VisibleStream, main, visible_streams
from aomc_sky.errors import Problem, visible


def in_shell(words, redirection):
    command = shlex.join([sys.executable, "-m", "aomc_sky", *words])
    words = ["sh", "-c", f"{command} {redirection}"]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("redirection", [">&-", "<&- >&- 2>&-"])
def test_closed_streams_are_no_fault(redirection, amc):
    out = amc.parent / "out"
    done = in_shell(["run", str(amc), "--format", "none", "--out", str(out)], redirection)
    assert (done.returncode, done.stderr) == (0, "")
    assert (out / "manifest.json").exists()
    assert (out / "plan.npz").read_bytes()[:2] == b"PK"  # what is printed did not go into a file


def test_closed_streams_keep_the_exit_code():
    done = in_shell(["info", "/nowhere/amc.inp"], ">&- 2>&-")
    assert done.returncode in (3, 6)
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize(
    ("words", "is_buffered"),
    [("--help", True), ("--version", False), ("run amc.inp --out - --format raw", True), ("run amc.inp --json", True)],
)
def test_a_full_standard_output_is_reported(words, is_buffered, scene, monkeypatch):
    monkeypatch.chdir(scene)
    monkeypatch.setenv("PYTHONUNBUFFERED", "" if is_buffered else "1")
    done = in_shell(words.split(), "> /dev/full")
    assert done.returncode == 6
    assert re.match("aomc-sky: error: .*standard output: ", done.stderr)
    assert done.stderr.count("\n") == 1


@pytest.fixture
def _hears_interrupts():
    """As at a terminal; a shell has SIGINT ignored in what it starts in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def as_numpy_does(names):
    """C code may answer an interrupt with another error."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("could not import module 'datetime'") from None


@pytest.mark.usefixtures("_hears_interrupts")
@pytest.mark.parametrize("build", [lambda names: signal.raise_signal(signal.SIGINT), as_numpy_does])
def test_interrupted_while_the_parser_is_made(build, monkeypatch, capsys):
    monkeypatch.setattr(front_door, "build_parser", build)
    assert front_door.main(["info", "x"]) == 130
    assert capsys.readouterr().err == "aomc-sky: interrupted\n"
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_errors_without_an_interrupt_stay_what_they_are(monkeypatch):
    def fails(names):
        raise ImportError("really")

    monkeypatch.setattr(front_door, "build_parser", fails)
    with pytest.raises(ImportError, match="really"):
        front_door.main(["info", "x"])


def test_another_program_reads_the_photons(amc):
    words = ["--iterations", "2e5", "--seed", "7", "--threads", "3", "--format", "raw", "--out", "-"]
    command = [sys.executable, "-m", "aomc_sky", "run", str(amc), *words]
    done = subprocess.run(command, capture_output=True, timeout=120, check=True)
    source = read_scene(amc, iterations=200_000).source(7)
    expected = np.concatenate([source.photons(band).directions for band in range(source.n_bands)])
    np.testing.assert_array_equal(np.frombuffer(done.stdout, "<f4").reshape(-1, 3), expected)
    assert ", 3 threads, " in done.stderr.decode()


HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eevil\u2066\x08\x7f"
UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def assert_tame(shown):
    assert not UNSEEN.search(shown.out)
    assert not UNSEEN.search(shown.err)


def test_every_control_character_is_escaped_and_nothing_else():
    for code in range(0x3000):
        shown = visible(chr(code))
        assert (shown != chr(code)) == (UNSEEN.match(chr(code)) is not None or chr(code) in "\n\t"), hex(code)
        assert shown.isprintable() or shown == chr(code)
    assert visible("a\tb\n", keep_lines=True) == "a\tb\n"
    assert visible("naïve Ωλ 北") == "naïve Ωλ 北"
    problem = Problem(
        path=f"x{HOSTILE}", line=1, column=1, code="E1", field=HOSTILE, message=HOSTILE, advice=HOSTILE, text=HOSTILE
    )
    assert not UNSEEN.search(problem.render())
    assert "\\x1b[2J" in problem.render()
    assert problem.render().count("\n") == 2


def test_names_of_files(scene, tmp_path, capsys):
    for words in (["run", f"{tmp_path}/{HOSTILE}"], ["info", f"{tmp_path}/{HOSTILE}"], ["validate", HOSTILE]):
        assert main(words) == 3
        assert_tame(capsys.readouterr())
    with pytest.raises(SystemExit):
        main(["run", str(scene), f"--{HOSTILE}"])
    assert_tame(capsys.readouterr())


def test_streams_escape_what_a_file_says():
    stream = io.StringIO()
    before, sys.stdout = sys.stdout, stream
    try:
        with visible_streams():
            print("\x1b[31mfile\x1b[0m\tof\nlines")
    finally:
        sys.stdout = before
    assert stream.getvalue() == "\\x1b[31mfile\\x1b[0m\tof\nlines\n"
    assert not isinstance(sys.stdout, VisibleStream)
