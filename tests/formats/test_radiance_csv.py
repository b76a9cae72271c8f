"""Tables of measured radiances: names, units and conventions as people write them are one sky."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.formats.radiance_csv import read_radiance_points
from aomc_sky.formats.radiance_words import name_of_column
from tests.support.shared import DATA

ROWS = [(10.0, 20.0, 443.0, 0.05), (40.0, 110.0, 443.0, 0.04), (60.0, 230.0, 443.0, 0.03), (80.0, 350.0, 443.0, 0.02)]


POINTS = [(z, a, v) for z, a, _, v in ROWS]


def write(path, head, rows, delimiter=","):
    path.write_text("\n".join([*head, *(delimiter.join(map(str, row)) for row in rows)]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Zenith angle [deg]", ("zenith", "deg", None)), ("zenith_rad", ("zenith", "rad", None)),
        ("elevation (°)", ("elevation", "°", None)), ("VAA", ("azimuth", "", None)),
        ("relative_azimuth_deg", ("relative azimuth", "deg", None)), ("Wavelength (um)", ("wavelength", "um", None)),
        ("radiance_W_m2_nm_sr", ("radiance", "W m2 nm sr", None)),
        ("radiance (mW/(m2 nm sr))", ("radiance", "mW/(m2 nm sr)", None)), ("L_412.5", ("radiance", "", 412.5)),
        ("412nm", ("radiance", "", 412.0)), ("443", ("radiance", "", 443.0)), ("L (412 nm)", ("radiance", "", 412.0)),
        ("sky_radiance_555 nm", ("radiance", "", 555.0)), ("solar_zenith", None), ("time", None), ("Ed_412", None),
    ],
)  # fmt: skip
def test_names_of_columns(text, name):
    assert name_of_column(text) == name


def test_one_sky_in_many_hands(tmp_path):
    """Degrees or radians, zenith or elevation, from north, east or the sun, long or wide: the same points."""
    north = [(z, (90 - a) % 360, nm, v) for z, a, nm, v in ROWS]
    files = [
        write(tmp_path / "a.csv", ["# azimuth: enu_from_east", "zenith_deg,azimuth_deg,wavelength,L (W m-2 nm-1 sr-1)"],
              ROWS),
        write(tmp_path / "b.csv", ["# azimuth: clockwise from north", "# radiance unit: uW/cm2/nm/sr",
              "nm;radiance;elevation;azimuth;note"],
              [(nm, f"{100 * v:.6g}".replace(".", ","), 90 - z, a, "x") for z, a, nm, v in reversed(north)], ";"),
        write(tmp_path / "c.tsv", ["# unit: mW m-2 nm-1 sr-1", "# sun azimuth: 40 counterclockwise from east",
              "zenith (rad)\trelative azimuth (rad)\tL_443"],
              [(np.deg2rad(z), np.deg2rad(a - 40), 1000 * v) for z, a, _, v in ROWS], "\t"),
        write(tmp_path / "d.csv", ["# azimuth: clockwise from the sun", "# sun azimuth: 50 deg, clockwise from north",
              "# wavelength: 0.443 um", "zenith,azimuth,radiance_W_m2_nm_sr"],
              [(-z if z == 60 else z, 40 - a + 180 * (z == 60), v) for z, a, _, v in ROWS]),
    ]  # fmt: skip
    first, *others = [sky.read_radiance_csv(path) for path in files]
    assert first.is_absolute
    for other in others:
        np.testing.assert_array_equal(other.wavelength_nm, [443.0])
        np.testing.assert_allclose(other.direction[0], first.direction[0], atol=2e-6)
        np.testing.assert_allclose(other.values[0], first.values[0], rtol=1e-12)
    zenith, azimuth = np.deg2rad([10.0, 80.0]), np.deg2rad([20.0, 350.0])
    np.testing.assert_allclose(first.radiance(zenith, azimuth, 443.0), [0.05, 0.02], rtol=2e-3)


@pytest.mark.parametrize(
    ("head", "clockwise"),
    [
        ("zenith,azimuth_north_cw,L", True), ("zenith,azimuth from north,L", True),
        ("zenith,azimuth (deg E of N),L", True), ("zenith,azimuth from north (deg),L", True),
        ("zenith,azimuth_deg_N_of_E,L", False),
        ("# Azimuth clockwise from North\nzenith,azimuth,L", True), ("% azimuth: from north\nzenith,azimuth,L", True),
        ("// site\n; day\n! azimuths are counted from east\nzenith,azimuth,L", False),
        ("# azimuth: from east\n% zenith,azimuth,L", False),
    ],
)  # fmt: skip
def test_azimuths_that_a_name_or_a_comment_explains(tmp_path, head, clockwise):
    points = read_radiance_points(write(tmp_path / "sky.csv", [head], POINTS))
    expected = [(90 - a) % 360 if clockwise else a for _, a, _ in POINTS]
    np.testing.assert_allclose(points["sky_azimuth_deg"], expected)
    assert not any("azimuths count" in remark for remark in points["remarks"])


def test_semicolons_before_empty_columns_and_signs_of_other_encodings(tmp_path):
    rows = [("", *row) for row in ROWS]
    path = write(tmp_path / "sky.csv", ["; a comment", ";zenith;azimuth;wavelength;L"], rows, ";")
    np.testing.assert_allclose(read_radiance_points(path)["sky_zenith_deg"], [10, 40, 60, 80])
    path = write(tmp_path / "sky.csv", ["zenith (°),azimuth (°),radiance (µW cm-2 nm-1 sr-1)"], POINTS)
    text = path.read_text(encoding="utf-8")
    for encoding in ("utf-8", "utf-8-sig", "latin-1", "cp1252"):
        path.write_bytes(text.encode(encoding))
        np.testing.assert_allclose(read_radiance_points(path)["radiance"], [5e-4, 4e-4, 3e-4, 2e-4], rtol=1e-12)
    path.write_bytes(text.encode("utf-16"))
    with pytest.raises(sky.InputFileError, match=r"the file is UTF-16\n") as caught:
        read_radiance_points(path)
    assert len(caught.value.problems) == 1


def test_arguments_win_over_the_file(tmp_path):
    head = ["# azimuth: enu_from_east", "# radiance unit: relative", "zenith,azimuth,L"]
    path = write(tmp_path / "sky.csv", head, POINTS)
    how = {"azimuth_convention": "from_sun", "sun_azimuth_deg": 30.0, "radiance_unit": "mW/m2/nm/sr"}
    points = read_radiance_points(path, **how)
    np.testing.assert_allclose(points["sky_azimuth_deg"], [50.0, 140.0, 260.0, 20.0])
    np.testing.assert_allclose(points["radiance"], [5e-5, 4e-5, 3e-5, 2e-5])
    assert points["is_absolute"]
    with pytest.raises(sky.UsageError, match="radiance unit 'lux' is not known; write --radiance-unit"):
        read_radiance_points(path, radiance_unit="lux")
    with pytest.raises(sky.UsageError, match=r"azimuth_convention: 'south' does not say whether azimuths count clockw"):
        read_radiance_points(path, azimuth_convention="south")


def test_gaps_are_counted_and_said(tmp_path):
    rows = [*ROWS, (50, 50, 443, ""), (51, 50, 443, "nan"), (52, 50, 443, -999), (95, 0, 443, 1), ("", 0, 443, 1)]
    head = ["# azimuth: enu_from_east", "zenith_deg,azimuth_deg,wavelength,radiance"]
    measured = sky.read_radiance_csv(write(tmp_path / "sky.csv", head, rows))
    assert len(measured.values[0]) == 4
    for said in (
        "3 of 8 radiances are gaps",
        "1 of 8 radiances are directions below the horizon",
        "1 radiances without direction or wavelength",
        "no unit of radiance, so its light is relative (--radiance-unit",
    ):
        assert any(said in remark for remark in measured.remarks), said


def table_of(tmp_path, rows, head="zenith_deg,azimuth_deg,radiance (mW m-2 nm-1 sr-1)"):
    text = "\n".join(["# azimuth: from north", "# wavelength: 550 nm", head, *rows, ""])
    (tmp_path / "sky.csv").write_text(text)
    return tmp_path / "sky.csv"


def test_quoted_cells_hold_separators(tmp_path):
    """RFC 4180: commas, semicolons and quotes in quotes, in names and rows; decimal commas there, too."""
    head = 'zenith (deg),"azimuth (deg, clockwise from north)",radiance (mW m-2 nm-1 sr-1),"note; ""a"", b"'
    rows = ['"0,5",0,"100,000","x, y"', '"40,0", "10,25" ,"82,899",', '60,"120,0","0,5","says ""no"""']
    points = read_radiance_points(table_of(tmp_path, rows, head))
    np.testing.assert_allclose(points["sky_zenith_deg"], [0.5, 40.0, 60.0])
    np.testing.assert_allclose(points["sky_azimuth_deg"], [90.0, 79.75, 330.0])
    np.testing.assert_allclose(points["radiance"], [0.1, 0.082899, 0.0005])
    rows[1] = '"40,0",far,"82,899",'
    with pytest.raises(sky.InputFileError) as caught:
        read_radiance_points(table_of(tmp_path, rows, head))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column, problem.width) == (5, 8, 3)
    with pytest.raises(sky.InputFileError, match=r"'82\.899\.' is not a number"):
        read_radiance_points(table_of(tmp_path, ['"40,0",10,"82,899,', *rows], head))


def test_a_column_of_letters_is_no_question_about_units(tmp_path):
    with pytest.raises(sky.InputFileError) as caught:
        read_radiance_points(table_of(tmp_path, ["40,N,1", "50,E,1"], "zenith,azimuth,radiance"))
    assert [(p.code, p.line, p.column) for p in caught.value.problems] == [("E652", 4, 4), ("E652", 5, 4)]


@pytest.mark.parametrize("delimiter", [";", "\t"])
@pytest.mark.parametrize(
    ("values", "read"),
    [
        (["829", "1.050", "2.310"], None), (["829", "1,050", "12,310"], None), (["7", "1.050", "879"], None),
        (["829.0", "1.050", "2.31"], [829.0, 1.05, 2.31]), (["1.050", "2.310", "0.829"], [1.05, 2.31, 0.829]),
        (["0,829", "1,050", "2"], [0.829, 1.05, 2.0]), (["1.050", "2.310", "3.000"], [1.05, 2.31, 3.0]),
        (["1829", "1.050", "2.310"], [1829.0, 1.05, 2.31]), (["829", "1050", "2310"], [829.0, 1050.0, 2310.0]),
    ],
)  # fmt: skip
def test_a_separator_of_thousands_is_a_question(tmp_path, delimiter, values, read):
    """Excel of a German locale: 829 beside 1.050, which is 1050; the column alone can tell."""
    rows = [delimiter.join((str(40 + k), str(100 * k), value)) for k, value in enumerate(values)]
    path = table_of(tmp_path, rows, delimiter.join(("zenith_deg", "azimuth_deg", "radiance (W m-2 nm-1 sr-1)")))
    if read is not None:
        np.testing.assert_allclose(read_radiance_points(path)["radiance"], read)
        return
    with pytest.raises(sky.InputFileError) as caught:
        read_radiance_points(path)
    (problem,) = caught.value.problems
    digits = values[1].replace(".", "").replace(",", "")
    assert problem.message == f"'{values[1]}' beside '{values[0]}' may be {digits}, with a separator of thousands"
    assert (problem.code, problem.line, problem.column) == ("E652", 5, 8)


LINES = {
    "# azimuths increase clockwise from north": None, "# Azimuth (deg): clockwise from north": None,
    "# Azimuth - clockwise from north": None, "# phi: clockwise from north": None, "# All azimuths E of N": None,
    "# Azimuth reference: north, clockwise": None, "# azimuth is not from north": "'not' is not understood",
    "{}zenith angle: 0 = horizon, 90 = zenith": "but this line says '0 = horizon'",
    "{}scale factor: 0.001": "this line says 'scale' besides the unit",
    "{}Radiances multiplied by 1000": "this line says 'multiplied' besides the unit",
    "{}radiance unit: W m-2 nm-1 sr-1": "beside 'mW m-2 nm-1 sr-1' of the column",
    "{}sun zenith: 40\n# sun zenith: 50": "'50' after '40'",
    "{}sun zenith: 40 above the horizon": "does not say where the sun is",
    "{}sun azimuth: 1.5707963268 rad clockwise from south": 180.0, "{}Sun azimuth (deg from N): 200": 250.0,
    "{}sun azimuth 200 clockwise from north": 250.0, "{}sun_azimuth_deg: 200": "'200' does not say where the sun is",
    "{}scale_factor = 0.001": "this line says 'scale' besides the unit",
    "{}values are in units of 10^-3 W": "this line says 'units of 10",
    "{}multiply by 0.001": "this line says 'multiply' besides the unit",
    "{}Radiance [W m-2 nm-1 sr-1]": "beside 'mW m-2 nm-1 sr-1' of the column",
    "{}unit of L: mW/(m2 nm sr)": None,
    "# azimuth: n/a": "does not say clearly",
}  # fmt: skip
"""Lines of a head with azimuths from north, and what is wrong with them, or the azimuth of the sun."""


@pytest.mark.parametrize("head", LINES)
def test_lines_of_a_head(head, tmp_path):
    names = "zenith_deg,azimuth_deg,L_550 (mW m-2 nm-1 sr-1)"
    lines = head.format("# azimuth: clockwise from north\n# ")
    path = write(tmp_path / "t.csv", [lines, names], [(20, 90, 2), (40, 200, 1), (60, 300, 1)])
    if isinstance(LINES[head], str):
        with pytest.raises(sky.InputFileError, match=LINES[head]):
            read_radiance_points(path)
        return
    points = read_radiance_points(path)
    assert points["sky_azimuth_deg"][0] == 0.0
    assert points["radiance"][0] == 0.002
    assert points["sun_azimuth_deg"] == (None if LINES[head] is None else pytest.approx(LINES[head]))
    other = read_radiance_points(path, sun_azimuth_deg=20.0)
    assert other["sun_azimuth_deg"] == 20.0
    assert any("in place of" in remark for remark in other["remarks"]) == (LINES[head] is not None)


def test_a_mark_that_is_no_decimal_point_elsewhere_is_a_question(tmp_path):
    """1,050 beside 829.5; 1.050 beside 829,5; or where the angles have the other mark. Commas leave points alone."""
    points = read_radiance_points(table_of(tmp_path, ["0,0,829", "40,0,1.050", "60,0,2.310"]))
    np.testing.assert_allclose(points["radiance"], [0.829, 0.00105, 0.00231])
    rows = {",": ('"1,050"', "829.5"), ";": ("1.050", "829,5")}
    for delimiter, (grouped, plain) in rows.items():
        for values, angle in (((grouped, plain), "20"), ((grouped, grouped), "20" + plain[-2:])):
            table = [(angle, 0, values[0]), (40, 90, values[1]), (60, 200, values[0])]
            head = ["# wavelength: 550", "# azimuth: E of N", delimiter.join(["zenith_deg", "azimuth_deg", "radiance"])]
            path = write(tmp_path / "t.csv", head, table, delimiter)
            with pytest.raises(sky.InputFileError, match="may be 1050, with a separator of thousands"):
                read_radiance_points(path)


@pytest.mark.parametrize(
    ("zenith", "azimuth", "head", "problem"),
    [
        ([0.0, 0.7, 1.4], [0, 120, 315], "zenith,azimuth", "zenith to 1.4 beside azimuth to 315"),
        ([0, 40, 80], [0.0, 2.1, 5.5], "zenith,azimuth", "azimuth to 5.5 beside zenith to 80"),
        ([0.0, 0.7, 1.4], [0.0, 2.1, 5.5], "zenith,azimuth", "degrees or radians"),
        ([0.0, 0.7, 1.4], [0, 120, 315], "zenith_rad,azimuth", None),
        ([0, 40, 80], [0, 0, 0], "zenith,azimuth", None),
        ([0, 40, 80], [0, 120, 315], "zenith,azimuth", None),
    ],
)
def test_columns_of_two_kinds_of_angles_are_a_question(tmp_path, zenith, azimuth, head, problem):
    rows = [f"{z},{a},{v}" for z, a, v in zip(zenith, azimuth, [3, 2, 1], strict=True)]
    path = table_of(tmp_path, rows, f"{head},radiance (W m-2 nm-1 sr-1)")
    if problem is None:
        points = read_radiance_points(path)
        assert points["sky_zenith_deg"].max() == pytest.approx(80.0, abs=0.3)
        return
    with pytest.raises(sky.InputFileError, match=problem):
        read_radiance_points(path)


def test_fill_values_and_rounded_horizons(tmp_path):
    """A fill value of the netCDF library is a gap; 1.5708 rad is the horizon."""
    rows = ["0,0,5", "1.5708,0,4", "1.2,2.0,3", "1.0,4.0,9.969209968386869e+36"]
    path = table_of(tmp_path, rows, "zenith_rad,azimuth_rad,radiance (W m-2 nm-1 sr-1)")
    measured = sky.read_radiance_csv(path)
    assert len(measured.values[0]) == 3
    assert measured.direction[0][:, 2].min() == 0.0
    assert "1 of 4 radiances are gaps, and left out" in measured.remarks
    assert not any("below the horizon" in remark for remark in measured.remarks)


def test_names_behind_a_comment_sign_and_other_columns():
    measured = sky.read_radiance_csv(DATA / "radiance_csv" / "good" / "savetxt.csv")
    np.testing.assert_array_equal(measured.wavelength_nm, [443.0])
    assert not measured.is_absolute
    wide = sky.read_radiance_csv(DATA / "radiance_csv" / "good" / "wide_semicolons.csv")
    np.testing.assert_array_equal(wide.wavelength_nm, [412.0, 555.0])
    assert wide.sun_deg == pytest.approx((60.0, 225.0))
    assert "columns not used: temp" in wide.remarks
    assert wide.values[0].max() == pytest.approx(0.085)


GOOD = [path.read_text(encoding="utf-8") for path in sorted((DATA / "radiance_csv").glob("*/*.csv"))]


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    text=st.sampled_from(GOOD),
    changes=st.lists(
        st.tuples(
            st.integers(0, 400), st.integers(0, 12), st.sampled_from([*' ,;\t#:=-().0e9"°\n\r', "nan", "sun", "1e400"])
        ),
        max_size=6,
    ),
)
def test_a_mutated_table_is_points_or_a_message(tmp_path, text, changes):
    for place, width, word in changes:
        text = text[: place % len(text)] + word + text[place % len(text) + width :] if text else word
    (tmp_path / "sky.csv").write_text(text, encoding="utf-8", newline="")
    problems = ()
    try:
        points = read_radiance_points(tmp_path / "sky.csv")
    except sky.InputFileError as error:
        problems = error.problems
    assert all(problem.advice for problem in problems)
    if problems:
        return
    assert points["sky_zenith_deg"].shape == points["sky_azimuth_deg"].shape == points["radiance"].shape
    assert np.all(np.isfinite(points["sky_zenith_deg"]) & np.isfinite(points["sky_azimuth_deg"]))
    assert not np.any(points["radiance"] < 0)
