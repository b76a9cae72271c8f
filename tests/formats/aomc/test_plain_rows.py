"""Rows of plain numbers: the values of `float`, and nothing where a row is not plain."""

import numpy as np
import pytest

from aomc_sky.formats.aomc import skydist

RNG = np.random.default_rng(19)
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
    given = [form.format(value) for value in RNG.lognormal(sigma=4, size=20_000).tolist()]
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
