"""Rows 27 to 30 of the matrix: amc.inp whose columns, points, lines or bytes are not what Fortran wants."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from aomc_sky.formats.aomc.amc import read_amc
from tests.support.fault_rows import AMC, Fault, amc_line, check_refused, faults, row_id, run_scene, sky
from tests.support.processes import limited
from tests.support.scenes import copy_scene, write_amc
from tests.support.shared import INPUTS

LINES = AMC.splitlines()
LABEL = {number: line[:48] for number, line in enumerate(LINES, 1)}


def in_line(number: int, text: str, column: int, code: str, words: str, caret: str) -> str:
    """The answer to one problem of amc.inp."""
    head = f"amc.inp:{number}:{column}: error[{code}]: {words}\n"
    return f"{head}{number:5d} | {text}\n      | {' ' * (column - 1)}{caret}\n"


COLUMNS = [
    Fault(
        row=27,
        name="flag-one-column-right",
        files={"amc.inp": amc_line(2, "1", column=50)},
        answer=in_line(
            2, f"{LABEL[2]} 1", 50, "E103",
            "light source: '1' is not in column 49; Fortran I1 reads it as 0", "^ write 1 in column 49",
        ),
    ),
    Fault(
        row=28,
        name="real-without-point",
        files={"amc.inp": amc_line(6, "100")},
        answer=in_line(
            6, f"{LABEL[6]}100", 49, "E104",
            "depth: '100' has no decimal point; Fortran F12.2 reads it as 1.00", "^^^ write 100.0",
        ),
    ),
    Fault(
        row=29,
        name="line-missing",
        files={"amc.inp": "\n".join([*LINES[:6], *LINES[7:], ""])},
        answer=in_line(
            7, LINES[7], 1, "E105", "there is one line missing: label '6)' is in line 7, but belongs in line 8",
            "^^ 30 lines are needed, in the order of docs/formats/amc.md",
        ),
    ),
    Fault(
        row=29,
        name="line-too-many",
        files={"amc.inp": "\n".join([*LINES[:6], "", *LINES[6:], ""])},
        answer=in_line(
            7, "", 1, "E105", "there is one line too many: label '5)' is in line 8, but belongs in line 7",
            "^ 30 lines are needed, in the order of docs/formats/amc.md",
        ),
    ),
]  # fmt: skip
UTF16 = (
    "error[E101]: the file is UTF-16, which Fortran cannot read\n    1 | \n      | ^ save it as plain text (UTF-8)\n"
)
BYTES = [
    Fault(row=30, name="amc-utf-16", files={"amc.inp": AMC.encode("utf-16")}, answer=f"amc.inp:1:1: {UTF16}"),
    Fault(row=30, name="sky-utf-16", files={"skydist.inp": sky().encode("utf-16")}, answer=f"skydist.inp:1:1: {UTF16}"),
    Fault(
        row=30,
        name="nul-bytes",
        files={"amc.inp": AMC.replace("100.0", "10\0.0")},
        answer=in_line(
            6, f"{LABEL[6]}10\N{REPLACEMENT CHARACTER}.0", 51, "E101", "a NUL byte; this is not a text file",
            "^ save it as plain text (UTF-8)",
        ),
    ),
    Fault(
        row=30,
        name="lone-returns",
        files={"amc.inp": AMC.replace("\n", "\r", 1)},
        answer=in_line(
            1, f"{LINES[0]}\N{REPLACEMENT CHARACTER}{LINES[1]}", len(LINES[0]) + 1, "E101",
            "there is a carriage return inside a line; Fortran ends the line here",
            "^ save the file with LF or CR LF line ends",
        ),
    ),
]  # fmt: skip


@faults([*COLUMNS, *BYTES])
def test_fault(fault, tmp_path, capsys):
    check_refused(fault, tmp_path, capsys)


def older_layout(path: Path) -> bytes:
    """The same scene in the layout with a line more, which asks for a polar cap."""
    write_amc(replace(read_amc(INPUTS / "document_example" / "amc.inp"), use_polar_cap=True), path)
    return path.read_bytes()


SAME = {
    "older-layout-is-read": (29, None),
    "crlf-is-read": (30, AMC.replace("\n", "\r\n").encode()),
    "byte-order-mark-is-read": (30, b"\xef\xbb\xbf" + AMC.encode()),
}


@pytest.mark.parametrize("name", SAME, ids=[row_id(number, name) for name, (number, _) in SAME.items()])
def test_what_is_read_gives_the_same_photons(name, tmp_path, capsys):
    text = SAME[name][1] or older_layout(tmp_path / "amc.inp")
    assert len(text.splitlines()) == (31 if name.startswith("older") else 30)
    files = {"skydist.inp": sky().replace("\n", "\r\n").encode()} if name.startswith("crlf") else {}
    options = ["--iterations", 1000, "--json"]
    answer = run_scene(tmp_path / "a", {"amc.inp": text, **files}, options, capsys)
    plain = run_scene(tmp_path / "b", {}, options, capsys)
    assert (answer.code, answer.err) == (plain.code, plain.err) == (0, "")
    assert json.loads(answer.out)["plan_sha256"] == json.loads(plain.out)["plan_sha256"]


GIGABYTES = ("amc.inp", "lambbot.inp", "skydist.inp")


@pytest.mark.parametrize("name", GIGABYTES, ids=[row_id(30, f"gigabyte-in-one-line-of-{name}") for name in GIGABYTES])
def test_a_gigabyte_in_one_line(name, tmp_path):
    """Refused after the first megabyte, whatever the size; behind the digits is a hole, which costs no disk."""
    scene = copy_scene("document_example", tmp_path).parent
    with (scene / name).open("wb") as file:
        file.write(b"1" * 2_000_000)
        file.truncate(2**30)
    done = limited(scene, "run", "amc.inp")
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"{name}:1:1: error[E101]: the line is longer than 65536 bytes\n")
    assert done.err.rstrip().endswith("^ end every line")
    assert done.peak_mb < 200
