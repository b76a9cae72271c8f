"""Rows 37 to 39 of the matrix: descriptions of an atmosphere that reach for other files, run away, or are no such."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.support.fault_rows import command, row, row_id
from tests.support.processes import Ended, limited
from tests.support.shared import DATA

PLAIN = (DATA / "atmo" / "good" / "plain.atmo").read_text()
SUN = "1.5, 1.9, 1.7, 1.4"
TABLE = b"300,1.0\n900,1.0\n"


def replaced(old: str, new: str) -> str:
    assert PLAIN.count(old) == 1
    return PLAIN.replace(old, new)


def elsewhere(path: Path) -> None:
    """Tables that lie outside of the folder `path`, inside it, and links to what is outside."""
    (path.parent / "secret.csv").write_bytes(TABLE)
    (path / "link.csv").symlink_to(path.parent / "secret.csv")
    (path / "folder").symlink_to(path.parent)
    (path / "zero.csv").symlink_to("/dev/zero")
    (path / "loop.csv").symlink_to("loop.csv")
    (path / "directory.csv").mkdir()
    os.mkfifo(path / "pipe.csv")


READ_A_TABLE = "name a table of wavelength and value"
MOVE = "move the file there, or give --allow-path DIR"
BELOW = "'{}' is not below the folder of this file"
REFERENCES = {
    # name: (file, message, what to write)
    "passwd": ("../../../../../../../../etc/passwd", BELOW, MOVE),
    "beside-the-folder": ("../secret.csv", BELOW, MOVE),
    "absolute": ("/etc/passwd", BELOW, MOVE),
    "link-to-outside": ("link.csv", BELOW, MOVE),
    "linked-folder": ("folder/secret.csv", BELOW, MOVE),
    "device": ("/dev/zero", BELOW, MOVE),
    "link-to-a-device": ("zero.csv", BELOW, MOVE),
    "pipe": ("pipe.csv", "'{}' is not a regular file", READ_A_TABLE),
    "folder": ("directory.csv", "'{}' is a folder", READ_A_TABLE),
    "itself": ("x.atmo", "'{}' is this file itself", READ_A_TABLE),
    "link-to-itself": ("loop.csv", "'{}' cannot be read: Too many levels of symbolic links", "name a readable file"),
    "missing": ("absent.csv", "there is no file '{}'", "paths are relative to the folder of this file"),
}


@pytest.mark.parametrize("name", REFERENCES, ids=[row_id(37, name) for name in REFERENCES])
def test_other_files(name, tmp_path, monkeypatch, capsys):
    home = tmp_path / "home"
    home.mkdir()
    elsewhere(home)
    file, words, advice = REFERENCES[name]
    (home / "x.atmo").write_text(replaced(SUN, f"file {file}"))
    monkeypatch.chdir(home)
    assert command("validate", "x.atmo") == 3
    said = capsys.readouterr()
    assert said.out == "x.atmo: has errors\n"
    assert said.err == (
        f"x.atmo:7:31: error[E402]: solar irradiance at toa: {words.format(file)}\n"
        f"    7 | solar irradiance at TOA: file {file}\n"
        f"      | {' ' * 30}{'^' * len(file)} {advice}\n"
    )


@row(37, "a-device-and-a-pipe-are-never-opened")
def test_no_device_is_opened(fault, tmp_path):
    """In a process of its own with limits, even where the folder of devices is allowed."""
    elsewhere(tmp_path)
    for k, file in enumerate(("/dev/zero", "pipe.csv", "zero.csv")):
        (tmp_path / f"{k}.atmo").write_text(replaced(SUN, f"file {file}"))
    done = limited(tmp_path, "validate", "0.atmo", "1.atmo", "2.atmo", "--allow-path", "/dev")
    assert done.code == 3
    assert done.err.count("error[E402]") == done.err.count("is not a regular file") == 3
    assert done.peak_mb < 200


ADVICE_ON_DEPTH = "put parts of it into variables"
BLOCKS = {
    # name: (code, column from the begin of the code, message, what to write)
    "endless-loop": (
        "while(true) { } return 1.;", 1, "while cannot stand here",
        "there are no loops; write the terms one by one",
    ),
    "recursion": (
        "float f(float x) { return f(x); } return f(1.);", 7, "a block cannot define functions",
        "write the code where you need it",
    ),
    "include": (
        "#include </etc/passwd>", 1, "a code block has no preprocessor", "write a comment after //",
    ),
    "array-of-1e9": ("float a[1000000000]; return a[0];", 7, "there are no arrays here", "use vec2, vec3 or vec4"),
    "200-brackets": (
        f"return {'(' * 200}1.{')' * 200};", 107,
        "brackets, operators and statements are nested more than 100 deep here", ADVICE_ON_DEPTH,
    ),
    "12000-terms": (
        f"return {'+'.join(['1.'] * 12_000)};", 15_007, "the block has more than 10000 numbers, names and operators",
        "write less",
    ),
    "pow-overflow": (
        "return pow(10., 400.);", 1, "a density is finite and not negative; it is inf, altitude 0 m",
        "write what is finite there",
    ),
    "division-by-0-at-the-ground": (
        "return 1e25/altitude;", 1, "a density is finite and not negative; it is inf, altitude 0 m",
        "write what is finite there",
    ),
    "0-by-0-at-the-ground": (
        "return altitude/altitude;", 8, "0 / 0 has no defined value, altitude 0 m",
        "take another value there, by if or ?:",
    ),
}  # fmt: skip
CODE = "return 2.5e25*exp(-altitude/(8*km));"


BRACKETS = {
    # name: (code, what the message holds, what to write)
    "200000-brackets-in-one-line": (
        f"return {'(' * 200_000}1.{')' * 200_000};", ":1: error[E101]: the line is longer than 65536 bytes",
        "end every line",
    ),
    "200000-brackets": (
        "return\n" + "(\n" * 200_000 + "1.\n" + ")\n" * 200_000 + ";", "the block has 800019 bytes, more than 65536",
        "write less",
    ),
    "15000-brackets": ("return\n" + "(\n" * 15_000 + "1.\n" + ")\n" * 15_000 + ";", "100 deep", ADVICE_ON_DEPTH),
}  # fmt: skip


@pytest.fixture(scope="module")
def answers(tmp_path_factory) -> Ended:
    """The command on all blocks: in one process, which the system stops where one has no end."""
    folder = tmp_path_factory.mktemp("blocks")
    codes = {name: code for name, (code, *_) in (BLOCKS | BRACKETS).items()}
    for name, code in codes.items():
        (folder / f"{name}.atmo").write_text(replaced(CODE, code))
    return limited(folder, "validate", *(f"{name}.atmo" for name in codes))


def said_of(name: str, answers: Ended) -> list[str]:
    """Lines that the command says of one block."""
    assert answers.code == 3, answers.err[-2000:]
    assert answers.peak_mb < 200
    parts = re.split(r"^(?=\S+\.atmo:)", answers.err, flags=re.MULTILINE)
    problems = [part for part in parts if part.startswith(f"{name}.atmo:")]
    assert len(problems) == 1, f"{len(problems)} problems are told of {name}.atmo"
    return problems[0].splitlines()


@pytest.mark.parametrize("name", BLOCKS, ids=[row_id(38, name) for name in BLOCKS])
def test_code_that_runs_away(name, answers):
    _, column, words, advice = BLOCKS[name]
    said = said_of(name, answers)
    assert said[0] == f'{name}.atmo:13:{column + 8}: error[E403]: number density of "molecules": {words}'
    assert said[1].strip()[:4] == "13 |"
    assert said[2].strip(" |").lstrip("^").strip() == advice
    assert len(said) == 3


@pytest.mark.parametrize("name", BRACKETS, ids=[row_id(38, name) for name in BRACKETS])
def test_brackets_without_end(name, answers):
    """Beyond the longest line of any file, beyond the longest block, and beyond the depth."""
    _, words, advice = BRACKETS[name]
    said = said_of(name, answers)
    assert said[0].startswith(f"{name}.atmo:")
    assert words in said[0]
    assert said[2].split("^ ")[-1] == advice
    assert len(said) == 3


def height(value: str) -> str:
    return replaced("120 km", value)


def in_height(value: str, place: int, words: str, caret: str) -> str:
    """The answer to a height of the atmosphere that is none."""
    head = f"x.atmo:2:{place}: error[E401]: atmosphere height: {words}\n"
    return f"{head}    2 | atmosphere height: {value}\n      | {' ' * (place - 1)}{caret}\n"


LENGTHS = "nm, um, mm, m, km, Mm, Gm, AU"
FORMS = {
    # name: (description, table t.csv, answer)
    "exponent-where-none-is-allowed": (
        height("1e3 km"), "",
        in_height("1e3 km", 20, "'1e3 km' has an exponent", "^^^^^^ write all digits, such as 120 km"),
    ),
    "unknown-unit": (
        height("5 kmm"), "",
        in_height("5 kmm", 22, "'kmm' is not a unit; expected a length", f"^^^ write one of {LENGTHS}"),
    ),
    "missing-unit": (height("120"), "", in_height("120", 20, "'120' has no unit", f"^^^ add one of {LENGTHS}")),
    "wrong-dimension": (
        height("5 km^-1"), "",
        in_height(
            "5 km^-1", 22, "'km^-1' is a unit of reciprocal length; expected a length", f"^^^^^ write one of {LENGTHS}"
        ),
    ),
    "unclosed-brace": (
        PLAIN[: PLAIN.rindex("}")], "",
        'x.atmo:22:1: error[E401]: the section has no closing brace\n   22 | Absorber "ozone":\n'
        "      | ^^^^^^^^^^^^^^^^ write } alone in the line after it\n",
    ),
    "csv-with-one-column": (
        replaced(SUN, "file t.csv"), "300,1\n600\n900,1\n",
        "t.csv:2:1: error[E401]: a row of 1 columns where two are expected\n    2 | 600\n"
        "      | ^^^ write wavelength in nm, comma, value\n",
    ),
    "csv-unsorted": (
        replaced(SUN, "file t.csv"), "300,1\n900,1\n400,1\n",
        "t.csv:3:1: error[E401]: wavelength 400 is not above 900\n    3 | 400,1\n      | ^^^ sort the rows\n",
    ),
    "csv-with-nan": (
        replaced(SUN, "file t.csv"), "300,1\n400,NaN\n900,1\n",
        "t.csv:2:5: error[E401]: 'NaN' is not a number\n    2 | 400,NaN\n"
        "      |     ^^^ write a number such as 0.25 or 2.5e-1\n",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMS, ids=[row_id(39, name) for name in FORMS])
def test_another_form(name, tmp_path, monkeypatch, capsys):
    text, table, answer = FORMS[name]
    (tmp_path / "x.atmo").write_text(text)
    (tmp_path / "t.csv").write_text(table)
    monkeypatch.chdir(tmp_path)
    assert command("validate", "x.atmo") == 3
    said = capsys.readouterr()
    assert (said.out, said.err) == ("x.atmo: has errors\n", answer)
