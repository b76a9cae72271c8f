"""Rows 30 to 33 of the matrix: what lenient takes, what is no file, and lines without an end.

Files out of form or range are those of tests/data; tests/cli/test_cli_validate.py runs them.
"""

import os
from pathlib import Path

import pytest

from tests.support.fault_rows import row, row_id, run_scene
from tests.support.processes import limited

BANDS = "3\n555.0 1.5 0.0\n580.0 0.05 0.0\n640.0 0.05 0.0\n"
"""Of lambbot.inp, whose first reflectance cannot be."""


@row(32, "lenient-keeps-the-reflectance", "strict-refuses-it-again")
def test_a_reflectance_of_the_program(fault, tmp_path, capsys):
    options = ["--lenient", "--iterations", 1000, "-q", *(["--strict"] if fault.startswith("strict") else [])]
    answer = run_scene(tmp_path, {"lambbot.inp": BANDS}, options, capsys)
    assert answer.code == (3 if fault.startswith("strict") else 0)
    assert answer.err.startswith("lambbot.inp:2:7: warning[E202]: ")


SCENE_FILES = ("amc.inp", "lambbot.inp", "skydist.inp")
NO_FILE = "{}: error[E100]: there is no such file"
NO_REGULAR_FILE = "{}: error[E100]: this is not a regular file, expected a text file"
KINDS = {
    # name: (what makes it of a name that is free, exit code, standard error)
    "missing": (str, 3, NO_FILE),
    "a-folder": (Path.mkdir, 3, "{}: error[E100]: this is a folder, expected a text file"),
    "a-pipe": (os.mkfifo, 3, NO_REGULAR_FILE),
    "a-device": (lambda path: path.symlink_to("/dev/zero"), 3, NO_REGULAR_FILE),
    "a-link-to-nowhere": (lambda path: path.symlink_to("nowhere"), 3, NO_FILE),
    "a-link-to-itself": (
        lambda path: path.symlink_to(path.name),
        6,
        "aomc-sky: error: cannot read {}: Too many levels of symbolic links",
    ),
}


@pytest.mark.parametrize("kind", KINDS, ids=[row_id(33, kind) for kind in KINDS])
def test_what_is_no_file(kind, scene):
    """In a process, for a pipe that is opened waits for ever and a device has no end."""
    make, code, words = KINDS[kind]
    name = SCENE_FILES[list(KINDS).index(kind) % len(SCENE_FILES)]
    (scene / name).unlink()
    make(scene / name)
    done = limited(scene, "run", *([scene / "amc.inp"] if name != "amc.inp" else ["amc.inp"]))
    assert done.code == code
    assert done.err.replace(f"{scene}/", "").startswith(words.format(name))
    assert "Traceback" not in done.err
    assert done.peak_mb < 200
    assert not (scene / "aomc-sky-out").exists()


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="needs a file that nobody can read")
@row(33, "a-file-that-cannot-be-read")
def test_a_file_that_cannot_be_read(fault, scene):
    """A regular file to look at, whose first byte nobody may read, root included."""
    (scene / "skydist.inp").unlink()
    (scene / "skydist.inp").symlink_to("/proc/self/mem")
    done = limited(scene, "run", "amc.inp")
    assert (done.code, done.out) == (6, "")
    assert done.err == "aomc-sky: error: cannot read skydist.inp: Input/output error\n"


@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may read everything")
@row(33, "no-permission")
def test_a_file_without_permission(fault, scene):
    (scene / "skydist.inp").chmod(0)
    done = limited(scene, "run", "amc.inp")
    assert (done.code, done.err) == (6, "aomc-sky: error: cannot read skydist.inp: Permission denied\n")


@pytest.mark.parametrize(
    "name", SCENE_FILES, ids=[row_id(30, f"gigabyte-in-one-line-of-{name}") for name in SCENE_FILES]
)
def test_a_gigabyte_in_one_line(name, scene):
    """Refused after the first megabyte, whatever the size; behind the digits is a hole, which costs no disk."""
    with (scene / name).open("wb") as file:
        file.write(b"1" * 2_000_000)
        file.truncate(2**30)
    done = limited(scene, "run", "amc.inp")
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"{name}:1:1: error[E101]: the line is longer than 65536 bytes\n")
    assert done.err.rstrip().endswith("^ end every line")
    assert done.peak_mb < 200
