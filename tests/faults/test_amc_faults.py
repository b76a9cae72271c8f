"""Rows 27 to 30 of the matrix: amc.inp whose columns, points, lines or bytes are not what Fortran wants."""

import json
from dataclasses import replace

import pytest

from aomc_sky.formats.aomc.amc import read_amc
from tests.support.fault_rows import AMC, Fault, amc_line, check_refused, faults, row_id, run_scene, sky
from tests.support.processes import limited
from tests.support.scenes import copy_scene, write_amc
from tests.support.shared import INPUTS

LINES = AMC.splitlines()


def in_amc(number, name, text, place):
    return Fault(row=number, name=name, files={"amc.inp": text}, places=[f"amc.inp:{place}"])


SKY_UTF16 = {"skydist.inp": sky().encode("utf-16")}
FAULTS = [
    in_amc(27, "flag-one-column-right", amc_line(2, "1", column=50), "2:50 E103"),
    in_amc(28, "real-without-point", amc_line(6, "100"), "6:49 E104"),
    in_amc(29, "line-missing", "\n".join([*LINES[:6], *LINES[7:], ""]), "7:1 E105"),
    in_amc(29, "line-too-many", "\n".join([*LINES[:6], "", *LINES[6:], ""]), "7:1 E105"),
    in_amc(30, "amc-utf-16", AMC.encode("utf-16"), "1:1 E101"),
    Fault(row=30, name="sky-utf-16", files=SKY_UTF16, places=["skydist.inp:1:1 E101"]),
    in_amc(30, "nul-bytes", AMC.replace("100.0", "10\0.0"), "6:51 E101"),
    in_amc(30, "lone-returns", AMC.replace("\n", "\r", 1), f"1:{len(LINES[0]) + 1} E101"),
]


@faults(FAULTS)
def test_fault(fault, tmp_path, capsys):
    check_refused(fault, tmp_path, capsys)


def older_layout(path):
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
