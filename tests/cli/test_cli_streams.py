"""Standard streams that are closed or full, and Ctrl-C before the work begins."""

import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from aomc_sky.cli import main as front_door


def in_shell(words, redirection):
    command = shlex.join([sys.executable, "-m", "aomc_sky", *words])
    words = ["sh", "-c", f"{command} {redirection}"]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("redirection", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_are_no_fault(redirection, amc):
    out = amc.parent / "out"
    done = in_shell(["run", str(amc), "--format", "none", "--out", str(out)], redirection)
    assert (done.returncode, done.stderr) == (0, "")
    assert (out / "manifest.json").exists()
    assert (out / "plan.npz").read_bytes()[:2] == b"PK"  # what is printed did not go into a file


@pytest.mark.parametrize("redirection", [">&-", "2>&-", ">&- 2>&-"])
def test_closed_streams_keep_the_exit_code(redirection):
    done = in_shell(["info", "/nowhere/amc.inp"], redirection)
    assert done.returncode in (3, 6)
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize(
    ("words", "is_buffered"),
    [
        *(([word], True) for word in ("--help", "--version")), (["info", "--include-dir"], True),
        (["--version"], False), (["run", "amc.inp", "--out", "-", "--format", "raw"], True),
        (["run", "amc.inp", "--dry-run"], True), (["run", "amc.inp", "--json", "--format", "none"], True),
    ],
)  # fmt: skip
def test_a_full_standard_output_is_reported(words, is_buffered, scene, monkeypatch):
    monkeypatch.chdir(scene)
    monkeypatch.setenv("PYTHONUNBUFFERED", "" if is_buffered else "1")
    done = in_shell(words, "> /dev/full")
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
