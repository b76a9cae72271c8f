"""Rows 37 to 39 of the matrix: descriptions of an atmosphere that reach for other files, run away, or are no such."""

import os
import re

import pytest

from tests.support.fault_rows import check_places, row, row_id
from tests.support.processes import limited
from tests.support.shared import DATA

PLAIN = (DATA / "atmo" / "good" / "plain.atmo").read_text()
SUN = "1.5, 1.9, 1.7, 1.4"
TABLE = b"300,1.0\n900,1.0\n"


def replaced(old, new):
    assert PLAIN.count(old) == 1
    return PLAIN.replace(old, new)


def elsewhere(path):
    """Tables that lie outside of the folder `path`, inside it, and links to what is outside."""
    (path.parent / "secret.csv").write_bytes(TABLE)
    (path / "link.csv").symlink_to(path.parent / "secret.csv")
    (path / "folder").symlink_to(path.parent)
    (path / "zero.csv").symlink_to("/dev/zero")
    (path / "loop.csv").symlink_to("loop.csv")
    (path / "directory.csv").mkdir()
    os.mkfifo(path / "pipe.csv")


REFERENCES = {
    "passwd": "../../../../../../../../etc/passwd", "link-to-outside": "link.csv", "device": "/dev/zero",
    "pipe": "pipe.csv", "folder": "directory.csv", "itself": "x.atmo", "link-to-itself": "loop.csv",
}  # fmt: skip


@pytest.mark.parametrize("name", REFERENCES, ids=[row_id(37, name) for name in REFERENCES])
def test_other_files(name, tmp_path, monkeypatch, told):
    home = tmp_path / "home"
    home.mkdir()
    elsewhere(home)
    (home / "x.atmo").write_text(replaced(SUN, f"file {REFERENCES[name]}"))
    monkeypatch.chdir(home)
    said = told("validate", "x.atmo", code=3)
    assert said.out == "x.atmo: has errors\n"
    check_places(["x.atmo:7:31 E402"], said.err)
    assert ("--allow-path DIR" in said.err) == ("is not below the folder" in said.err)


@row(37, "a-device-and-a-pipe-are-never-opened")
def test_no_device_is_opened(fault, tmp_path):
    """In a process of its own with limits, even where the folder of devices is allowed."""
    elsewhere(tmp_path)
    for k, file in enumerate(("/dev/zero", "pipe.csv", "zero.csv")):
        (tmp_path / f"{k}.atmo").write_text(replaced(SUN, f"file {file}"))
    done = limited(tmp_path, "validate", "0.atmo", "1.atmo", "2.atmo", "--allow-path", "/dev")
    assert done.code == 3
    assert done.err.count("error[E402]") == done.err.count(", not a regular file") == 3
    assert done.peak_mb < 200


BLOCKS = {
    # name: (code, column of the problem from the begin of the code)
    "endless-loop": ("while(true) { } return 1.;", 1),
    "recursion": ("float f(float x) { return f(x); } return f(1.);", 7),
    "include": ("#include </etc/passwd>", 1),
    "array-of-1e9": ("float a[1000000000]; return a[0];", 7),
    "12000-terms": (f"return {'+'.join(['1.'] * 12_000)};", 15_007),
    "200000-brackets": ("return\n" + "(\n" * 200_000 + "1.\n" + ")\n" * 200_000 + ";", -7),  # the block as a whole
    "division-by-0-at-the-ground": ("return 1e25/altitude;", 1),
}


CODE = "return 2.5e25*exp(-altitude/(8*km));"


@row(38, "code-that-runs-away")
def test_code_that_runs_away(fault, tmp_path):
    """All blocks in one process, which the system stops where one has no end."""
    for name, (code, _) in BLOCKS.items():
        (tmp_path / f"{name}.atmo").write_text(replaced(CODE, code))
    answers = limited(tmp_path, "validate", *(f"{name}.atmo" for name in BLOCKS))
    assert answers.code == 3, answers.err[-2000:]
    assert answers.peak_mb < 200
    parts = re.split(r"^(?=\S+\.atmo:)", answers.err, flags=re.MULTILINE)
    for name, (_, column) in BLOCKS.items():
        (problem,) = [part for part in parts if part.startswith(f"{name}.atmo:")]
        check_places([f"{name}.atmo:13:{column + 8} E403"], problem)


FORMS = {
    # name: (description, table t.csv, place and code); more of them have golden messages beside tests/data/atmo/bad
    "missing-unit": (replaced("120 km", "120"), "", "x.atmo:2:20 E401"),
    "unclosed-brace": (PLAIN[: PLAIN.rindex("}")], "", "x.atmo:22:1 E401"),
    "csv-with-nan": (replaced(SUN, "file t.csv"), "300,1\n400,NaN\n900,1\n", "t.csv:2:5 E401"),
}


@pytest.mark.parametrize("name", FORMS, ids=[row_id(39, name) for name in FORMS])
def test_another_form(name, tmp_path, monkeypatch, told):
    text, table, place = FORMS[name]
    (tmp_path / "x.atmo").write_text(text)
    (tmp_path / "t.csv").write_text(table)
    monkeypatch.chdir(tmp_path)
    said = told("validate", "x.atmo", code=3)
    assert said.out == "x.atmo: has errors\n"
    check_places([place], said.err)
