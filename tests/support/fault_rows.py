"""Rows of the matrix of faults: the files of a small scene, the fault in them, and what the command must answer."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS, csv_rows

AMC = (INPUTS / "document_example" / "amc.inp").read_text()
ROWS = ("1 1 0 10.5", "1 1 1 12.0", "1 2 1 20.0", "2 1 0 8.2", "2 1 1 9.5", "2 2 1 15.3")
"""Rows of skydist.inp of the scene: two wavelengths, two rings, three azimuths."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Answer:
    code: int
    out: str
    err: str
    folder: Path = field(repr=False)


def row_id(row, name):
    """Id of a test of a row; test_all_rows.py looks for one of every row."""
    return f"row-{row:02d}-{name}"


def row(number, *names):
    """Mark a test as one of a row by an argument ``fault`` that holds the name of the case."""
    return pytest.mark.parametrize("fault", names, ids=[row_id(number, name) for name in names])


def sky(*changed, rows=ROWS, head=None, waves="550.0 650.0"):
    """Text of skydist.inp: the third row is replaced by those given."""
    lines = [*rows[:2], *changed, *rows[3:]] if changed else list(rows)
    return "\n".join([head or f"{len(lines)} 2 2 2", waves, *lines, ""])


def amc_line(number, value, *, column=49):
    """Text of amc.inp with the value of one line replaced. [lines and columns from 1]"""
    lines = AMC.splitlines()
    lines[number - 1] = lines[number - 1][:48].ljust(column - 1) + value
    return "\n".join([*lines, ""])


def command(*words):
    """Exit code of a command, the usage errors of argparse included."""
    try:
        return main([str(word) for word in words])
    except SystemExit as leaving:
        return int(leaving.code or 0)


def run_scene(folder, files, options, capsys):
    """Run the small scene with some files replaced, from inside its folder, so that messages hold no path."""
    scene = copy_scene("document_example", folder).parent
    for name, text in files.items():
        (scene / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(scene)
        code = command("run", "amc.inp", "--out", "out", *options)
    said = capsys.readouterr()
    return Answer(code=code, out=said.out, err=said.err, folder=scene / "out")


def check_places(places, said, kind="error"):
    """Each problem has its place, its code and, below its line, what to write; whole messages are golden elsewhere."""
    found = re.findall(rf"^(\S+:\d+:\d+): {kind}\[(E\d{{3}})\]: \S.*\n +\d+ \| .*\n +\| +\^+ \S", said, re.MULTILINE)
    assert [f"{place} {code}" for place, code in found] == list(places), said
    assert len(said.splitlines()) == 3 * len(found), said


def launched(folder):
    """Photons of every waveband that has any, from counts.csv. [wavebands from 1]"""
    totals = {}
    for line in csv_rows(folder / "counts.csv"):
        band = int(line["waveband"])
        totals[band] = totals.get(band, 0) + int(line["photons"])
    return totals


def photons_of_band(folder, band):
    """Photons of every patch of a band, by zenith and azimuth index, from counts.csv. [bands from 1]"""
    rows = [line for line in csv_rows(folder / "counts.csv") if int(line["waveband"]) == band]
    return {(int(line["zenith_index"]), int(line["azimuth_index"])): int(line["photons"]) for line in rows}
