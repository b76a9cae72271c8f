"""Means over bins and luminances, against 50 digits, against numbers by hand, and against what CalcMySky makes."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aomc_sky.errors import InputFileError
from aomc_sky.formats.spectrum_csv import MAX_BYTES, MAX_POINTS, Spectrum, bin_means, read_spectrum_csv
from aomc_sky.skies.atmosphere.description import spectra

EPS = float(np.finfo(float).eps)


def spectrum(x, y):
    return Spectrum(wavelength_nm=np.array(x, float), value=np.array(y, float))


def exact_integral(x, y, low, high):
    """Integral of the piecewise-linear function, segment by segment, in the working precision."""
    total = mpmath.mpf(0)
    for x0, x1, y0, y1 in zip(x[:-1], x[1:], y[:-1], y[1:], strict=True):
        a, b = max(low, mpmath.mpf(x0)), min(high, mpmath.mpf(x1))
        if a < b:
            slope = (mpmath.mpf(y1) - mpmath.mpf(y0)) / (mpmath.mpf(x1) - mpmath.mpf(x0))
            total += (b - a) * (mpmath.mpf(y0) + slope * ((a + b) / 2 - mpmath.mpf(x0)))
    return total


def exact_mean(table, low, high):
    with mpmath.workdps(50):
        a, b = mpmath.mpf(low), mpmath.mpf(high)
        return exact_integral(table.wavelength_nm, table.value, a, b) / (b - a)


def test_a_narrow_line_on_a_large_ground():
    """A difference of running integrals would lose the line; a sum over the bin does not."""
    x = [1e-3, 499.999, 500.0, 500.001, 99_999.0, 100_000.0]
    table, grid = spectrum(x, [1e9, 1e-12, 1.0, 1e-12, 1e-12, 1e9]), np.linspace(400.0, 600.0, 5)
    for w, value in zip(grid, bin_means(table, grid), strict=True):
        wanted = exact_mean(table, w - 25.0, w + 25.0)
        assert abs(value - wanted) <= 4.0 * EPS * abs(wanted), (w, value, wanted)


def test_points_on_the_edges_count_once_and_a_single_wavelength_takes_the_value():
    table = spectrum([400, 450, 550, 650, 700], [1.0, 1.0, 3.0, 3.0, 7.0])
    assert bin_means(table, np.array([400.0, 500.0, 600.0, 700.0])).tolist() == [1.0, 2.0, 3.0, 5.0]
    table = spectrum([400, 500, 600], [1.0, 2.0, 4.0])
    for w, wanted in ((400.0, 1.0), (450.0, 1.5), (500.0, 2.0), (600.0, 4.0)):
        assert bin_means(table, np.array([w])).tolist() == [wanted]


@settings(max_examples=25, deadline=None)
@given(
    steps=st.lists(st.floats(1e-6, 100.0), min_size=1, max_size=12),
    values=st.lists(st.floats(0.0, 1e3), min_size=13, max_size=13),
    ends=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
    n=st.integers(2, 9),
)
def test_means_are_exact_for_any_spectrum(steps, values, ends, n):
    x = 300.0 + np.concatenate(([0.0], np.cumsum(steps)))
    table = spectrum(x, values[: len(x)])
    low, high = (x[0] + (x[-1] - x[0]) * end for end in sorted(ends))
    if high - low < 1e-3:
        return
    grid = np.clip(np.linspace(low, high, n), x[0], x[-1])
    half = (grid[-1] - grid[0]) / (n - 1) / 2
    for w, value in zip(grid, bin_means(table, grid), strict=True):
        a, b = max(w - half, x[0]), min(w + half, x[-1])
        wanted = exact_mean(table, a, b)
        # x of a steep segment is known to 1 ulp only, which the value inherits by its slope
        slope = np.max(np.abs(np.diff(table.value) / np.diff(x)))
        assert abs(value - wanted) <= 4 * EPS * abs(wanted) + 8 * EPS * slope * x[-1] + 1e-300


def test_the_table_of_the_eye_has_the_printed_sum():
    """CIE 15:2004, table T.4, prints the sum of its 81 numbers of six decimals."""
    assert sum((v + 5) // 10 for v in spectra.V_E7) == 21_371_327
    wavelength, v = spectra.photopic_efficiency()
    assert (wavelength[0], wavelength[-1], len(v)) == (380.0, 780.0, 81)
    at = dict(zip(wavelength.tolist(), v.tolist(), strict=True))
    assert (at[555.0], at[510.0], at[610.0], at[400.0], at[700.0]) == (1.0, 0.503, 0.503, 0.000396, 0.004102)


def test_luminance_is_the_integral():
    rng = np.random.default_rng(6)
    x = np.concatenate(([300.0], np.sort(rng.uniform(350.0, 820.0, 40)), [430.0, 900.0]))
    x.sort()
    y = rng.exponential(1e-3, len(x))
    grid, v = spectra.photopic_efficiency()
    with mpmath.workdps(40):
        knots = np.unique(np.concatenate((x, grid)))
        knots = knots[(knots >= 380.0) & (knots <= 780.0)]

        def at(t, xs, ys):
            k = int(np.clip(np.searchsorted(xs, float(t), "right") - 1, 0, len(xs) - 2))
            x0, x1, y0, y1 = (mpmath.mpf(float(q)) for q in (xs[k], xs[k + 1], ys[k], ys[k + 1]))
            return y0 + (y1 - y0) * (t - x0) / (x1 - x0)

        total = mpmath.mpf(0)
        for a, b in pairwise(knots):
            # two Gauss nodes are exact for the product, and lie inside the segment
            middle, half = (mpmath.mpf(a) + mpmath.mpf(b)) / 2, (mpmath.mpf(b) - mpmath.mpf(a)) / 2
            for node in (-1, 1):
                t = middle + node * half / mpmath.sqrt(3)
                total += half * at(t, x, y) * at(t, grid, v)
        wanted = 683 * total
        assert abs(spectra.luminance(x, y) - wanted) <= 1e-14 * wanted


def test_luminance_of_a_stair_and_outside_the_visible():
    stair = spectra.luminance(np.array([380.0, 555.0, 555.0, 780.0]), np.array([1.0, 1.0, 2.0, 2.0]))
    left = spectra.luminance(np.array([380.0, 555.0]), np.array([1.0, 1.0]))
    right = spectra.luminance(np.array([555.0, 780.0]), np.array([2.0, 2.0]))
    assert stair == pytest.approx(left + right, rel=1e-15)
    assert spectra.luminance(np.array([300.0, 900.0]), np.array([1.0, 1.0])) == pytest.approx(683 * 106.8565, rel=1e-4)
    assert spectra.luminance(np.array([800.0, 900.0]), np.array([1.0, 1.0])) == 0.0


def refused(path, content):
    path.write_bytes(content)
    with pytest.raises(InputFileError) as caught:
        read_spectrum_csv(path)
    return [(problem.code, problem.line) for problem in caught.value.problems]


def test_tables_are_read(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(b"\xef\xbb\xbf# head \xe9\r\n\r\n 400 ,\t1e-3 \r\n500,-2\r\n  # end")
    table = read_spectrum_csv(path)
    assert table.wavelength_nm.tolist() == [400.0, 500.0]
    assert table.value.tolist() == [1e-3, -2.0]
    assert not table.value.flags.writeable


@pytest.mark.parametrize(
    ("content", "wanted"),
    [
        (b"", [("E401", 0)]), (b"400,1\n", [("E401", 0)]), (b"400\n500\n", [("E401", 1), ("E401", 2)]),
        (b"400,1,2\n500,1\n", [("E401", 1)]), (b"400;1\n500;1\n", [("E401", 1), ("E401", 2)]),
        (b"400,nan\n500,inf\n", [("E401", 1), ("E401", 2)]), (b"400,1\n400,1\n", [("E401", 2)]),
        (b"400,1\n300,1\n500,1\n", [("E401", 2)]), (b"-1,1\n500,1e31\n", [("E404", 1), ("E404", 2)]),
        (b"1e999999,1\n500,1\n", [("E404", 1)]), (b"400,1 # c\n500,1\n", [("E401", 1)]),
        (b"400,1\n\0", [("E101", 2)]), (b"400,1\r500,1\n", [("E101", 1)]), (b"1," + b"9" * 70_000, [("E101", 1)]),
        (b"\xff\xfe4\0", [("E101", 1)]), (b"x\n" * 1000, [("E401", k + 1) for k in range(200)]),
    ],
)  # fmt: skip
def test_broken_tables_are_refused(content, wanted, tmp_path):
    assert refused(tmp_path / "t.csv", content) == wanted


def test_tables_that_are_too_large_are_refused(tmp_path):
    assert refused(tmp_path / "t.csv", b" " * MAX_BYTES + b"\n") == [("E401", 0)]
    rows = b"".join(b"%d,1\n" % k for k in range(MAX_POINTS + 1))
    assert refused(tmp_path / "t.csv", rows) == [("E401", 0)]
    (tmp_path / "t.csv").write_bytes(rows[: rows.rindex(b"\n", 0, -1) + 1])
    assert len(read_spectrum_csv(tmp_path / "t.csv").value) == MAX_POINTS


def test_the_table_of_the_eye_has_these_sums_to_the_last_digit():
    """Of the numbers, and of the numbers times their places: one digit, or two that change places, would be seen."""
    v = np.rint(1e7 * spectra.photopic_efficiency()[1]).astype(int)
    assert (v.sum(), (v * np.arange(81)).sum()) == (213_713_276, 7_701_878_898)
