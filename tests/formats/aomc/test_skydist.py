"""skydist.inp: values and lines, what --lenient changes, writing, and the short way for plain rows of a broken file."""

import dataclasses

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.aomc import skydist
from aomc_sky.formats.aomc.skydist import Bins, SkyTable, Values, read_skydist, write_skydist
from tests.support.shared import DATA

ROWS = [
    "1 1 0 10.5", "  1\t1 1 12.   ", "1 2 1 2E1", "2 1 0 0.1234567890123456789", "2 1 1 1e400", "2 2 1 15.3 and words",
    "3 1 0 1", "1 0 0 1", "1 1 3 1", "1 1 0 11", "1 2 0 -1", "1 2 2 1d2", "2*1 2 4", "2 2 0,7",
]  # fmt: skip


def test_skydist_values_and_lines():
    table = read_skydist(DATA / "skydist/good/plain.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert table.radiance.tolist() == [[[10.5, 0, 0], [0, 0, 20]], [[0, 9.5, 0], [0, 0, 0]]]
    assert table.line[0, 1, 2] == 4
    assert np.count_nonzero(table.line) == 3
    assert table.declared_bins is None
    declared = read_skydist(DATA / "skydist/good/declared.inp")
    assert (declared.declared_bins, declared.declared_values) == (Bins.DEGREES, Values.MASS)


def test_fortran_spellings():
    table = read_skydist(DATA / "skydist/good/fortran_spellings.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert (table.radiance[0, 0, 1], table.radiance[0, 1, 2], table.radiance[1, 0, 1]) == (10.5, 20.0, 9.5)


def test_what_lenient_downgrades():
    """More rows and values that differ are in tests/faults."""
    for name, code in (("fewer_rows", "E303"), ("wavelength_twice", "E308")):
        with pytest.warns(InputWarning, match=code):
            read_skydist(DATA / f"skydist/bad/{name}.inp", lenient=True)
    with pytest.warns(InputWarning, match="E308"):
        read_skydist(DATA / "skydist/bad/wavelength_twice.inp", downgrade=frozenset({"E308"}))


def test_any_number_of_warnings_loses_no_row(tmp_path):
    path = tmp_path / "sky.inp"
    rows = "".join(f"1 1 0 {k}.5\n" for k in range(1000))
    path.write_text(f"1001 1 1 1\n500\n{rows}1 1 1 7.0\n")
    with pytest.warns(InputWarning, match="E309"):
        table = read_skydist(path, lenient=True)
    assert table.radiance[0, 0].tolist() == [999.5, 7.0]
    path.write_text(f"1001 1 1 1\n500\n{rows}1 1 2 7.0\n")
    with pytest.raises(InputFileError, match="E301"):
        read_skydist(path, lenient=True)


def test_skydist_written_and_read(tmp_path):
    radiance = np.zeros((2, 3, 5))
    radiance[0, 1, 4], radiance[1, 2, 0], radiance[1, 0, 0] = 1 / 3, 5e-324, 1.7976931348623157e308
    table = SkyTable(wavelength_nm=np.array([412.1, 1e3 / 3]), radiance=radiance)
    write_skydist(table, tmp_path / "sky.inp", bins=Bins.DEGREES, values=Values.MASS)
    again = read_skydist(tmp_path / "sky.inp")
    assert np.array_equal(again.radiance, radiance)
    assert np.array_equal(again.wavelength_nm, table.wavelength_nm)
    assert (again.declared_bins, again.declared_values) == (Bins.DEGREES, Values.MASS)


def problems_of(path):
    with pytest.raises(InputFileError) as raised:
        read_skydist(path)
    return [str(dataclasses.replace(problem, path="")) for problem in raised.value.problems]


@pytest.mark.parametrize("last", ["2 2 2", "2 2 2 nan", "2 2 2 1"])
def test_same_problems_without_the_short_way(last, tmp_path, monkeypatch):
    path = tmp_path / "skydist.inp"
    path.write_text("\n".join([f"{len(ROWS) + 1} 2 2 2", "550.0 650.0", *ROWS, last]) + "\n")
    short = problems_of(path)
    monkeypatch.setattr(skydist, "_take_plain", lambda *_arguments: False)
    assert problems_of(path) == short
    assert len(short) > 4
