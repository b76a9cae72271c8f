"""Row 51 of the matrix: dates beyond the calendar, little memory, a low recursion limit: one sentence each."""

import errno
import os
import resource
import subprocess
import sys

import pytest

from aomc_sky.cli import main as cli
from tests.support.fault_rows import row, row_id
from tests.support.scenes import copy_scene

DATES = ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59-12:00")
MB = 1 << 20


def is_one_sentence(err):
    return "Traceback" not in err and err.startswith("aomc-sky: error: ") and err.count("\n") == 1


def ended(program, *words, **how):
    """A Python program that has ended."""
    command_line = [sys.executable, "-c", program, *map(str, words)]
    return subprocess.run(command_line, capture_output=True, text=True, timeout=120, check=False, **how)


def assert_says(done, words):
    assert done.returncode == 6, done.stderr
    assert is_one_sentence(done.stderr), done.stderr
    assert words in done.stderr


@pytest.mark.parametrize("date", DATES, ids=[row_id(51, f"date-{name}") for name in ("year-0", "year-10000")])
def test_dates_outside_the_calendar(date, tmp_path, told):
    pytest.importorskip("h5py")
    scene = copy_scene("night_sky", tmp_path).parent
    lines = (scene / "sky.toml").read_text().splitlines()
    changed = [f"time = {date}" if line.startswith("time") else line for line in lines]
    assert changed != lines
    (scene / "sky.toml").write_text("\n".join(changed))
    err = told("run", scene, "-q", code=3).err
    assert "error[E704]" in err
    assert "is outside the years 1 to 9999 in UTC" in err
    for words in (["info", scene / "night.h5"], ["plot", scene / "night.h5", "--out", tmp_path / "x.png"]):
        assert "is outside the years 1 to 9999 in UTC" in told(*words, "--time", date, code=2).err


@row(51, "perez-time")
def test_a_time_of_a_perez_sky(fault, told):
    pytest.importorskip("pvlib")
    place = ["--latitude", 10, "--longitude", 10]
    for date in (*DATES, "0000-01-01T00:00:00Z", "10000-01-01T00:00:00Z", "1500-06-21T12:00:00Z"):
        assert is_one_sentence(told("perez", "--dni", 500, "--dhi", 100, "--time", date, *place, code=2).err)


SMALL = """
import resource, sys
from aomc_sky.cli.main import main
import numpy, numpy.linalg, aomc_sky.source.read.scene, aomc_sky.emission.photon_source
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + int(sys.argv[1]), used + int(sys.argv[1])))
sys.exit(main(sys.argv[2:]))
"""


@row(51, "1-MB-to-spare")
def test_little_memory(fault, scene, tmp_path):
    """Python and numpy have started; what a scene of a hundred thousand patches needs is not there."""
    rows = "".join(f"1 {z + 1} {a} 1.5\n" for z in range(250) for a in range(400))
    (scene / "skydist.inp").write_text(f"100000 250 399 1\n550\n{rows}")
    done = ended(SMALL, MB, "run", scene, "--threads", 1, "-q", "--out", tmp_path / "out")
    assert_says(done, "there is not enough memory for this process")
    assert not (tmp_path / "out" / "manifest.json").exists()


@row(51, "address-space-of-150-MB")
def test_a_small_address_space_from_the_start(fault, scene, tmp_path):
    """Where Python and numpy just start; libraries that do not fit any more are told as lack of memory."""
    words = ("run", scene, "--threads", 1, "--iterations", "3e6", "-q", "--out", tmp_path / "out")
    for size in (130, 145, 160, 200):  # each ends elsewhere: OpenBLAS, numpy, our modules, numba's LLVM

        def limit(size=size * MB):
            resource.setrlimit(resource.RLIMIT_AS, (size, size))

        program = "import runpy; runpy.run_module('aomc_sky', run_name='__main__')"
        done = ended(program, *words, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"}, preexec_fn=limit)
        if done.returncode:
            assert_says(done, "there is not enough memory for this process")
        assert "Traceback" not in done.stderr, size


LOW = """
import sys
from aomc_sky.cli.main import main
sys.setrecursionlimit(int(sys.argv[1]))
sys.exit(main(sys.argv[2:]))
"""


@row(51, "recursion-limit-60")
def test_a_low_recursion_limit(fault, scene):
    assert_says(ended(LOW, 60, "validate", scene), "the recursion limit of this Python, 60, is too low")


NO_MEMORY = "is not enough memory for this process"
LAST = (
    (MemoryError("Unable to allocate 3 GiB"), 6, f"{NO_MEMORY} (Unable to allocate 3 GiB); "),
    (OverflowError("int too large"), 3, "a number is too large to be computed with (int too large)"),
    (RuntimeError("can't start new thread"), 6, f"{NO_MEMORY} (can't start new thread); "),
    (ImportError("x.so: failed to map segment from shared object"), 6, f"{NO_MEMORY} (x.so: failed"),
    (OSError(errno.ENOMEM, "Cannot allocate memory", "numba/np"), 6, f"{NO_MEMORY} ([Errno 12] Cannot allocate"),
)


def fail_with(error, monkeypatch):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("aomc_sky.source.read.scene.scene_of_files", fail)


@pytest.mark.parametrize(
    ("error", "code", "words"), LAST, ids=[row_id(51, f"last-line-{k}") for k, _ in enumerate(LAST)]
)
def test_the_last_line_of_the_command(error, code, words, scene, monkeypatch, told):
    fail_with(error, monkeypatch)
    err = told("run", scene, "-q", code=code).err
    assert is_one_sentence(err)
    assert words in err


@pytest.mark.parametrize("error", [RuntimeError("a bug"), ImportError("no module")], ids=["runtime", "import"])
def test_other_errors_are_bugs_and_keep_their_traceback(error, scene, monkeypatch):
    fail_with(error, monkeypatch)
    with pytest.raises(type(error)):
        cli.main(["run", str(scene), "-q"])
