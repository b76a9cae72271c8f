"""skydist.inp: values and lines, what --lenient changes, writing, and the short way for plain rows."""

import dataclasses

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.aomc import skydist
from aomc_sky.formats.aomc.skydist import Bins, Values, read_skydist
from tests.support.shared import DATA

ROWS = [
    "1 1 0 10.5", "  1\t1 1 12.   ", "1 2 1 2E1", "2 1 0 0.1234567890123456789", "2 1 1 1e400", "2 2 1 15.3 and words",
    "3 1 0 1", "1 0 0 1", "1 1 3 1", "1 1 0 11", "1 2 0 -1", "1 2 2 1d2", "2*1 2 4", "2 2 0,7",
]  # fmt: skip


def test_values_lines_and_spellings():
    table = read_skydist(DATA / "skydist/good/plain.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert table.radiance.tolist() == [[[10.5, 0, 0], [0, 0, 20]], [[0, 9.5, 0], [0, 0, 0]]]
    assert table.line[0, 1, 2] == 4
    assert np.count_nonzero(table.line) == 3
    assert table.declared_bins is None
    declared = read_skydist(DATA / "skydist/good/declared.inp")
    assert (declared.declared_bins, declared.declared_values) == (Bins.DEGREES, Values.MASS)
    table = read_skydist(DATA / "skydist/good/fortran_spellings.inp")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
    assert (table.radiance[0, 0, 1], table.radiance[0, 1, 2], table.radiance[1, 0, 1]) == (10.5, 20.0, 9.5)


@pytest.mark.parametrize(
    ("name", "code", "first", "last"),
    [
        ("fewer_rows", "E303", 1.0, 0.0), ("more_rows", "E303", 1.0, 0.0), ("duplicate_differs", "E309", 2.0, 0.0),
        ("wavelength_twice", "E308", 1.0, 0.0),
    ],
)  # fmt: skip
def test_what_lenient_downgrades(name, code, first, last):
    """As the program: rows beyond the count are not read, and of two values the last one holds."""
    with pytest.warns(InputWarning, match=code):
        table = read_skydist(DATA / f"skydist/bad/{name}.inp", lenient=True)
    assert (table.radiance[0, 0, 0], table.radiance[1, 0, 2]) == (first, last)


@pytest.mark.parametrize("rows", ["1 1 0 10.5\n1 2\n2 20", "2*1 0 10.5\n1 2 2 20", "1 1 0 10.5\n1 2 2 20.0 / north"])
def test_rows_that_fortran_reads(rows, tmp_path):
    """The rest of a row on the next line, a repeat count, a slash behind the values."""
    (tmp_path / "sky.inp").write_text(f"2 2 2 1\n550\n{rows}\n")
    table = read_skydist(tmp_path / "sky.inp")
    assert (table.radiance[0, 0, 0], table.radiance[0, 1, 2]) == (10.5, 20.0)


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


VALUES = [
    "0", "1", "12345678", "123456789", "0.5", "5.", ".5", "00.10", "1e5", "1E-5", "1.5e+05", "2.5E10", "1e-300",
    "1e400", "1e-400", "0e999", "1.e3", "12345678.12345678", "0.1234567890123456789012", "3.14159265358979323846264338",
    "9007199254740993", "900719925474099.35", "0.000012345678901234567", "99999999.999999999999999999", "1e0005",
    "+1.5", "-2", "8" * 40, "0." + "0" * 30 + "7", "1.7976931348623157e308", "4.9e-324",
]  # fmt: skip


def plain_rows(text):
    """Indices and values, or None where a row is not plain."""
    rows, end = skydist.plain_rows(text)
    return (rows[:, :3].T, rows[:, 3]) if len(rows) and end == len(text) else None


def rows_text(values, end="\n"):
    return "".join(f"{k + 1} {k % 90} {k % 360} {value}{end}" for k, value in enumerate(values)).encode()


@pytest.mark.parametrize("end", ["\n", "\r\n", " \t\n"], ids=["lf", "crlf", "blanks"])
def test_values_are_those_of_float(end):
    index, value = plain_rows(rows_text(VALUES, end))
    np.testing.assert_array_equal(value, [float(text) for text in VALUES])
    np.testing.assert_array_equal(index.T, [[k + 1, k % 90, k % 360] for k in range(len(VALUES))])


@pytest.mark.parametrize("form", ["{!r}", "{:.5g}", "{:.4e}", "{:.8E}", "{:.17g}", "{:.12f}"])
def test_values_of_many_forms(form):
    given = [form.format(value) for value in np.random.default_rng(19).lognormal(sigma=4, size=20_000).tolist()]
    np.testing.assert_array_equal(plain_rows(rows_text(given))[1], [float(text) for text in given])


def test_blanks_before_and_a_last_line_without_an_end():
    index, value = plain_rows(b"  1\t2   3 4.5\n12345678 0 7 8")
    np.testing.assert_array_equal(index, [[1, 12345678], [2, 0], [3, 7]])
    np.testing.assert_array_equal(value, [4.5, 8.0])


@pytest.mark.parametrize(
    "text",
    [
        "", "\n", "1 2 3\n", "1 2 3 4 5\n", "1 2 3\n4 5 6 7 8\n", "1 2\n3 4\n", "\n1 2 3 4\n", "1 2 3 4\n\n",
        "1 2 3 4\n ", "1.0 2 3 4\n", "1 -2 3 4\n", "1 2 3e0 4\n", "123456789 2 3 4\n", "1 2 3 4..5\n", "1 2 3 e4\n",
        "1 2 3 4e\n", "1 2 3 .\n", "1 2 3 4e5.5\n", "1 2 3 4-5\n", "1 2 3 4..5\n1 2 3 6\n", "1 2 3 4e5e6\n1 2 3 6\n",
    ],
)  # fmt: skip
def test_what_is_not_plain_is_left_to_the_slow_reader(text):
    assert plain_rows(text.encode()) is None
