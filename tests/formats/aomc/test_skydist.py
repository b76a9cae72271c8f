"""skydist.inp: values and lines, what --lenient changes, writing, and the short way for plain rows of a broken file."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning, OutputError
from aomc_sky.formats.aomc import skydist
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, read_skydist, write_skydist
from tests.support.shared import DATA, INPUTS

ROWS = [
    "1 1 0 10.5",
    "  1\t1 1 12.   ",
    "1 2 1 2E1",
    "2 1 0 0.1234567890123456789",
    "2 1 1 1e400",
    "2 2 1 15.3 and words",
    "3 1 0 1",
    "1 0 0 1",
    "1 1 3 1",
    "1 1 0 11",
    "1 2 0 -1",
    "1 2 2 1d2",
    "2*1 2 4",
    "2 2 0,7",
]


def test_skydist_values_and_lines() -> None:
    table = read_skydist(DATA / "skydist/good/plain.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert table.radiance.tolist() == [[[10.5, 0, 0], [0, 0, 20]], [[0, 9.5, 0], [0, 0, 0]]]
    assert table.line[0, 1, 2] == 4
    assert np.count_nonzero(table.line) == 3
    assert table.declared_bins is None
    declared = read_skydist(DATA / "skydist/good/declared.inp")
    assert (declared.declared_bins, declared.declared_values) == (Bins.DEGREES, Values.MASS)


def test_fortran_spellings() -> None:
    table = read_skydist(DATA / "skydist/good/fortran_spellings.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert (table.radiance[0, 0, 1], table.radiance[0, 1, 2], table.radiance[1, 0, 1]) == (10.5, 20.0, 9.5)


@pytest.mark.parametrize(
    ("name", "code"),
    [("more_rows", "E303"), ("fewer_rows", "E303"), ("duplicate_differs", "E309"), ("wavelength_twice", "E308")],
)
def test_what_lenient_downgrades(name: str, code: str) -> None:
    with pytest.warns(InputWarning, match=code):
        table = read_skydist(DATA / f"skydist/bad/{name}.inp", lenient=True)
    if name == "duplicate_differs":
        assert table.radiance[0, 0, 0] == 2.0
    if name == "wavelength_twice":
        with pytest.warns(InputWarning, match=code):
            read_skydist(DATA / f"skydist/bad/{name}.inp", downgrade=frozenset({"E308"}))


def test_any_number_of_warnings_loses_no_row(tmp_path: Path) -> None:
    path = tmp_path / "sky.inp"
    rows = "".join(f"1 1 0 {k}.5\n" for k in range(1000))
    path.write_text(f"1001 1 1 1\n500\n{rows}1 1 1 7.0\n")
    with pytest.warns(InputWarning, match="E309"):
        table = read_skydist(path, lenient=True)
    assert table.radiance[0, 0].tolist() == [999.5, 7.0]
    path.write_text(f"1001 1 1 1\n500\n{rows}1 1 2 7.0\n")
    with pytest.raises(InputFileError, match="E301"):
        read_skydist(path, lenient=True)


def test_skydist_written_and_read(tmp_path: Path) -> None:
    radiance = np.zeros((2, 3, 5))
    radiance[0, 1, 4], radiance[1, 2, 0], radiance[1, 0, 0] = 1 / 3, 5e-324, 1.7976931348623157e308
    table = SkyTable(wavelength_nm=np.array([412.1, 1e3 / 3]), radiance=radiance)
    write_skydist(table, tmp_path / "sky.inp", bins=Bins.DEGREES, values=Values.MASS)
    again = read_skydist(tmp_path / "sky.inp")
    assert np.array_equal(again.radiance, radiance)
    assert np.array_equal(again.wavelength_nm, table.wavelength_nm)
    assert (again.declared_bins, again.declared_values) == (Bins.DEGREES, Values.MASS)


def test_a_failed_write_leaves_nothing(tmp_path: Path) -> None:
    table = read_skydist(INPUTS / "document_example" / "skydist.inp")
    with pytest.raises(OutputError):
        write_skydist(table, tmp_path / "absent" / "skydist.inp")
    assert os.listdir(tmp_path) == []


def problems_of(path: Path) -> list[str]:
    with pytest.raises(InputFileError) as raised:
        read_skydist(path)
    return [str(dataclasses.replace(problem, path="")) for problem in raised.value.problems]


@pytest.mark.parametrize("last", ["2 2 2", "2 2 2 nan", "2 2 2 1"])
def test_same_problems_without_the_short_way(last: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    path.write_text("\n".join([f"{len(ROWS) + 1} 2 2 2", "550.0 650.0", *ROWS, last]) + "\n")
    short = problems_of(path)
    monkeypatch.setattr(skydist, "_take_plain", lambda *_arguments: False)
    assert problems_of(path) == short
    assert len(short) > 4


def test_same_values_and_lines_without_the_short_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    rows = [row for row in ROWS[:6] if "400" not in row]
    path.write_text("\n".join([f"{len(rows)} 2 2 2", "550.0 650.0", "", *rows]) + "\n")
    monkeypatch.setattr("aomc_sky.formats.aomc.skydist.read_rows_fast", lambda *_arguments: None)
    short = read_skydist(path)
    monkeypatch.setattr(skydist, "_take_plain", lambda *_arguments: False)
    long = read_skydist(path)
    assert short.radiance.tobytes() == long.radiance.tobytes()
    assert short.line.tobytes() == long.line.tobytes()


def test_a_big_file_with_one_bad_row_goes_the_short_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "skydist.inp"
    rows = [f"1 {z} {a} 1.5" for z in range(1, 91) for a in range(100)]
    rows[7] = "1 1 7 x"
    path.write_text("\n".join([f"{len(rows)} 90 99 1", "550.0", *rows]) + "\n")
    read: list[int] = []
    slowly = skydist._read_row
    monkeypatch.setattr(skydist, "_read_row", lambda *given: read.append(1) or slowly(*given))
    assert len(problems_of(path)) == 1
    assert len(read) == 1
