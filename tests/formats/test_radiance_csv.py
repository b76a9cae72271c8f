"""Tables of measured radiances: what they state by names, keys and options is one sky, and the rest is a question."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.formats.radiance_csv import read_radiance_points
from aomc_sky.formats.radiance_words import KEYS, NAMES, Stated
from tests.support.shared import DATA, REPOSITORY

ROWS = [(10.0, 20.0, 443.0, 0.05), (40.0, 110.0, 443.0, 0.04), (60.0, 230.0, 443.0, 0.03), (80.0, 350.0, 443.0, 0.02)]
POINTS = [(z, a, v) for z, a, _, v in ROWS]
NORTH, HEAD = "# azimuth: clockwise from north", "zenith_deg,azimuth_deg,radiance"
UNIT = "# radiance unit: mW m-2 nm-1 sr-1"
GRID = [(zenith, azimuth, 100.0 + zenith) for zenith in (10, 40, 70) for azimuth in (0, 90, 180, 270)]


@pytest.fixture
def write(tmp_path):
    """Writes lines and rows."""

    def written(*lines, rows=POINTS, delimiter=","):
        path = tmp_path / "sky.csv"
        text = "\n".join([*lines, *(delimiter.join(map(str, row)) for row in rows)]) + "\n"
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.fixture
def points(write):
    """Writes and reads."""

    def read(*lines, rows=POINTS, delimiter=",", sun=(None, None), other_sun=(None, None), **stated):
        path = write(*lines, rows=rows, delimiter=delimiter)
        return read_radiance_points(path, Stated(**stated), sun, other_sun)[0]

    return read


def questions(points, *lines, **how):
    with pytest.raises(sky.InputFileError) as caught:
        points(*lines, **how)
    assert all(problem.advice for problem in caught.value.problems)
    return caught.value.problems


def places(points, *lines, **how):
    return [f"{one.line}:{one.column} {one.code}" for one in questions(points, *lines, **how)]


def test_one_sky_in_many_hands(tmp_path, write):
    """Degrees or radians, zenith or elevation, from north, east or the sun, long or wide: the same points."""
    north = [(z, (90 - a) % 360, nm, v) for z, a, nm, v in ROWS]
    hands = [
        (["# azimuth: enu_from_east", "# radiance unit: W/m2/nm/sr", "zenith_deg,azimuth_deg,wavelength_nm,radiance"],
         ROWS, ","),
        ([NORTH, "# radiance unit: uW/cm2/sr/nm", "# decimal: comma", "# angle unit: degrees",
          "wavelength_nm;radiance;elevation;azimuth;note"],
         [[f"{x:.6g}".replace(".", ",") for x in (nm, 100 * v, 90 - z, a, 0)] for z, a, nm, v in reversed(north)], ";"),
        (["# azimuth convention: counterclockwise from the sun", UNIT, "# sun azimuth: 40 counterclockwise from east",
          "zenith_rad\tazimuth_rad\tL_443"],
         [(np.deg2rad(z), np.deg2rad(a - 40), f"{1000 * v:g}") for z, a, _, v in ROWS], "\t"),
        (["# azimuth = clockwise from the sun", "# sun azimuth: 50 deg, clockwise from north", "# wavelength: 0.443 um",
          "# radiance unit: W/(m2 nm sr)", HEAD],
         [(-z if z == 60 else z, 40 - a + 180 * (z == 60), v) for z, a, _, v in ROWS], ","),
    ]  # fmt: skip
    first, *others = [sky.read_radiance_csv(write(*lines, rows=rows, delimiter=mark)) for lines, rows, mark in hands]
    assert first.is_absolute
    for other in others:
        np.testing.assert_array_equal(other.wavelength_nm, [443.0])
        np.testing.assert_allclose(other.direction[0], first.direction[0], atol=2e-6)
        np.testing.assert_allclose(other.values[0], first.values[0], rtol=1e-12)
    zenith, azimuth = np.deg2rad([10.0, 80.0]), np.deg2rad([20.0, 350.0])
    np.testing.assert_allclose(first.radiance(zenith, azimuth, 443.0), [0.05, 0.02], rtol=2e-3)


def test_every_question_has_an_answer_by_option(points):
    """A file that states nothing, and the same with what a caller states: names, units, convention, decimals."""
    rows = [(f"{z:g}", f"{a:g}", "0,443", f"{1000 * v:g},5") for z, a, _, v in ROWS]
    asked = places(points, "vza;vaa;wl;L", rows=rows, delimiter=";")
    assert asked == ["1:1 E651"] * 3
    names = {"zenith": "vza", "azimuth": "vaa", "wavelength": "wl", "variable": "L"}
    asked = places(points, "vza;vaa;wl;L", rows=rows, delimiter=";", **names)
    assert asked[:4] == ["1:1 E651", "1:5 E651", "1:5 E651", "1:9 E651"]
    assert [one[-4:] for one in asked[4:]] == ["E652"] * 8
    units = {"angle_unit": "deg", "wavelength_unit": "um", "radiance_unit": "mW m-2 nm-1 sr-1", "decimal": "comma"}
    how = {**names, **units, "azimuth_convention": "clockwise from north"}
    found = points("vza;vaa;wl;L", rows=rows, delimiter=";", **how)
    np.testing.assert_allclose(found["sky_azimuth_deg"], [(90 - a) % 360 for _, a, _ in POINTS])
    np.testing.assert_allclose(found["wavelength_nm"], 443.0)
    np.testing.assert_allclose(found["radiance"], [v + 0.0005 for *_, v in POINTS])
    elevation = points("el,azimuth_deg,radiance", elevation="el", angle_unit="deg", azimuth_convention="enu_from_east")
    np.testing.assert_allclose(elevation["sky_zenith_deg"], [90 - z for z, *_ in POINTS])


def test_arguments_win_over_the_file_and_say_so(points):
    lines = ["# azimuth: enu_from_east", "# radiance unit: relative", "# sun azimuth: 10 clockwise from north", HEAD]
    how = {"azimuth_convention": "counterclockwise from the sun", "radiance_unit": "mW/m2/nm/sr"}
    found = points(*lines, sun=(None, 30.0), **how)
    np.testing.assert_allclose(found["sky_azimuth_deg"], [50.0, 140.0, 260.0, 20.0])
    np.testing.assert_allclose(found["radiance"], [5e-5, 4e-5, 3e-5, 2e-5])
    assert sum(" in place of " in remark for remark in found["remarks"]) == 3


@pytest.mark.parametrize(
    "stated",
    [
        {"radiance_unit": "lux"}, {"azimuth_convention": "south"}, {"angle_unit": "gon"}, {"wavelength_unit": "cm-1"},
        {"decimal": ","}, {"zenith": "a", "elevation": "b"},
    ],
)  # fmt: skip
def test_words_of_a_caller_are_those_of_the_table(points, stated):
    with pytest.raises(sky.UsageError):
        points(NORTH, HEAD, **stated)


def test_gaps_are_counted_and_said(write):
    rows = [*ROWS, (50, 50, 443, ""), (51, 50, 443, "NaN"), (52, 50, 443, -999), (95, 0, 443, 1), ("", 0, 443, 1)]
    head = ["# azimuth: enu_from_east", "zenith_deg,azimuth_deg,wavelength_nm,radiance"]
    measured = sky.read_radiance_csv(write(*head, rows=rows))
    assert len(measured.values[0]) == 4
    for said in ("3 of 8 radiances are gaps", "1 of 8 radiances are directions", "1 radiances without direction"):
        assert any(said in remark for remark in measured.remarks), said


def test_quoted_cells_hold_separators(points):
    """RFC 4180: commas, semicolons and quotes in quotes, in names and rows; decimal commas there, too."""
    head = ["# decimal: comma", UNIT, NORTH, 'zenith_deg,"azimuth, deg",radiance,"note; ""a"", b"']
    rows = [['"0,5",0,"100,000","x, y"'], ['"40,0", "10,25" ,"82,899",'], ['60,"120,0","0,5","says ""no"""']]
    how = {"azimuth": "azimuth, deg", "angle_unit": "deg"}
    found = points(*head, rows=rows, **how)
    np.testing.assert_allclose(found["sky_zenith_deg"], [0.5, 40.0, 60.0])
    np.testing.assert_allclose(found["sky_azimuth_deg"], [90.0, 79.75, 330.0])
    np.testing.assert_allclose(found["radiance"], [0.1, 0.082899, 0.0005])
    rows[1] = ['"40,0",far,"82,899",']
    (problem,) = questions(points, *head, rows=rows, **how)
    assert (problem.line, problem.column, problem.width) == (6, 8, 3)


@pytest.mark.parametrize("delimiter", [";", "\t", ","])
@pytest.mark.parametrize(
    ("values", "asked", "read"),
    [
        (["829", "1.050", "2.310"], 4, [829.0, 1.05, 2.31]),
        (["1.050", "2.31", "0.829"], 3, [1.05, 2.31, 0.829]),
        (["1.050.000", "2.3", "1"], 3, None),
        (["0.829", "12.31", "0.5"], None, [0.829, 12.31, 0.5]),
        (["829", "1050", "2310"], None, [829.0, 1050.0, 2310.0]),
    ],
)
def test_a_separator_of_thousands_is_a_question(points, delimiter, values, asked, read):
    """Excel of a German locale: 829 beside 1.050, which is 1050; commas between columns leave points alone."""
    rows = [(40 + k, 100 * k, value) for k, value in enumerate(values)]
    how = {"rows": rows, "delimiter": delimiter}
    head = delimiter.join(HEAD.split(","))
    if asked and (delimiter != "," or read is None):
        first = questions(points, NORTH, head, **how)[0]
        assert (first.code, first.line) == ("E652", asked)
    elif not asked:
        np.testing.assert_allclose(points(NORTH, head, **how)["radiance"], read)
    if read is not None:
        np.testing.assert_allclose(points(NORTH, "# decimal: point", head, **how)["radiance"], read)
        np.testing.assert_allclose(points(NORTH, head, decimal="point", **how)["radiance"], read)
    if any("." in value for value in values):
        assert questions(points, NORTH, "# decimal: comma", head, **how)[0].code == "E652"


@pytest.mark.parametrize("cell", ["84,302", "84,302.5", "1,084,302"])
def test_a_comma_of_thousands_is_not_advised_away(points, cell):
    """To follow '--decimal comma' would divide the light by 1000."""
    (problem,) = questions(points, NORTH, HEAD, rows=[(40, 0, f'"{cell}"'), (50, 90, 2), (60, 180, 2)])
    assert problem.advice.startswith(f"write {cell.replace(',', '')}")
    assert ("--decimal comma" in problem.advice) == ("." not in cell)


def test_excel_fills_lines_up_and_quotes_them(points):
    lines = [
        "# azimuth: clockwise from north,,",
        '"# radiance unit: mW m-2 nm-1 sr-1",,',
        "# sun zenith:,40,",
        "# seen,,",
    ]
    found = points(*lines, f"{HEAD},,")
    assert (found["radiance"][0], found["sun_zenith_deg"]) == (5e-5, 40.0)
    assert found["remarks"] == ('the file says "seen" (texts change nothing)',)


@pytest.mark.parametrize("name", ["L_1", "L_0.412", "radiance_250000"])
def test_numbers_in_names_that_are_no_wavelengths_are_a_question(points, name):
    assert places(points, NORTH, f"zenith_deg,azimuth_deg,{name}") == ["2:24 E651"]
    assert places(points, NORTH, "# wavelength unit: um", "zenith_deg,azimuth_deg,L_412") == ["3:24 E651"]


STATED = {
    "# radiance unit: W m-2 nm-1 sr-1\n# radiance unit: mW m-2 nm-1 sr-1": "3:18",
    "# Radiance_Unit = mW/(m2 nm sr)": {"factor": 0.001},
    "# radiance unit: hundredths of W m-2 nm-1 sr-1": "2:18", "# angle unit: rad": "2:15",
    "# angle unit: degree": {},
    "# wavelength: 0.55 um": {"nm": 550.0}, "# wavelength: 5500 angstrom": {"nm": 550.0},
    "# wavelength: 550": "2:15", "# wavelength: 550\n# wavelength unit: nm": {"nm": 550.0},
    "# wavelength: 550 nm\n# wavelength unit: um": "3:20", "# wavelength: 0.55 nm": "2:15",
    "# sun zenith: 40\n# sun zenith: 50": "3:15", "# sun zenith: 40 above the horizon": "2:15",
    "# sun azimuth: 1.5707963268 rad clockwise from south": {"sun": 180.0},
    "# sun azimuth: 200 clockwise from north": {"sun": 250.0}, "% sun azimuth: 200 NORTH_CLOCKWISE": {"sun": 250.0},
    "# sun azimuth: 200": "2:16", "# sun azimuth: 20 clockwise from the sun": "2:16",
    "# decimal: dot": "2:12", "# azimuth: 0 to 360": "2:12",
}  # fmt: skip
"""Lines of a head, and what they state or the place of what is wrong with them."""


@pytest.mark.parametrize("lines", STATED)
def test_lines_of_a_head(points, lines):
    stated = STATED[lines]
    if isinstance(stated, str):
        assert f"{stated} E651" in places(points, NORTH, lines, HEAD)
        return
    found = points(NORTH, lines, HEAD)
    assert found["radiance"][0] == 0.05 * stated.get("factor", 1.0)
    assert found["is_absolute"] == ("factor" in stated)
    assert found["sun_azimuth_deg"] == pytest.approx(stated.get("sun"))
    assert (found["wavelength_nm"] is None) == ("nm" not in stated)
    assert found["wavelength_nm"] is None or found["wavelength_nm"][0] == pytest.approx(stated["nm"], rel=1e-15)


@pytest.mark.parametrize(
    "names",
    [
        "zenith_gon,azimuth_deg,radiance", "mu,azimuth_deg,radiance", "zenith (deg),azimuth_deg,radiance",
        "zenith_deg,azimuth_deg,radiance_upwelling", "zenith_deg,azimuth_deg,L_0.44um", "zenith|azimuth|radiance",
        "zenith_deg,relative_azimuth_deg,radiance", f"Instrument: EKO MS-321LR\n{HEAD}",
    ],
)  # fmt: skip
def test_names_that_are_not_known_are_a_question(points, names):
    assert places(points, NORTH, names, delimiter="|" if "|" in names else ",")[0] == "2:1 E651"


ASKED = {
    "names twice": ("3:1 E652", [HEAD, HEAD], GRID),
    "letters": ("3:4 E652", [HEAD], [(40, "N", 1), (50, "E", 1)]),
    "two names": ("2:24 E651", ["zenith_deg,azimuth_deg,azimuth_rad,radiance"], [(*row[:2], *row[1:]) for row in GRID]),
    "wavenumbers": (
        "3:6 E653",
        ["zenith_deg,azimuth_deg,wavelength_nm,radiance"],
        [(z, a, 181818, v) for z, a, v in GRID],
    ),
    "a fill of netCDF": ("8:7 E652", [HEAD], [*GRID[:5], (40, 90, 9.96921e36), *GRID[6:]]),
    **{f"number {value}": ("3:6 E653", [HEAD], [(10, 0, value), *GRID[1:]]) for value in (1e15, 65535.0)},
    "upwards": ("2:1 E651", [HEAD], [*((180 - z, a, v) for z, a, v in GRID), *((90, a, 1) for a in (0, 120, 240))]),
    "not available": ("3:6 E652", [HEAD], [(10, 0, "NA"), *GRID[1:]]),
}
"""The place and the code of the question, names of columns, and rows."""


@pytest.mark.parametrize("name", ASKED)
def test_names_and_rows_that_are_a_question(points, name):
    place, lines, rows = ASKED[name]
    assert place in places(points, NORTH, *lines, rows=rows)


def test_other_wavelengths_side_by_side_are_read(points):
    rows = [(*row, row[2], row[2]) for row in POINTS]
    found = points(NORTH, "zenith_deg,azimuth_deg,L_412,L_412.5,radiance_413.1", rows=rows)
    assert np.unique(found["wavelength_nm"]).tolist() == [412.0, 412.5, 413.1]
    assert points(NORTH, "zenith_deg,azimuth_deg,L_412.10,L_412,x", rows=rows)["wavelength_nm"].min() == 412.0


def test_what_is_not_used_is_named(points):
    found = points(NORTH, f"{HEAD},radiance_std,temp,a,b,c,d,e", rows=[(*row, *range(7)) for row in POINTS])
    assert "not used: columns radiance_std, temp, a, b, c and 2 more" in found["remarks"]
    assert not any(one.startswith("not used") for one in points(NORTH, HEAD)["remarks"])


def test_a_fill_a_rounded_horizon_and_the_zenith(points):
    """1.5708 rad is the horizon, and overhead all azimuths are one direction."""
    lines = [UNIT, NORTH, "zenith_rad,azimuth_rad,radiance"]
    rows = [(0, "", 5), (1.5708, 0, 4), (1.2, 2.0, 3), (1.0, 4.0, -9999)]
    found = points(*lines, rows=rows)
    measured = sky.RadianceField.from_points(**found)
    assert len(measured.values[0]) == 3
    assert measured.direction[0][:, 2].min() == 0.0
    assert measured.radiance(0.0, 0.0, 550.0) == pytest.approx(0.005)
    assert not any("left out" in remark for remark in found["remarks"])


@pytest.mark.parametrize(
    ("nines", "is_asked"), [("999.9", True), ("9999.0", True), ("9999.99", True), ("99.9", False), ("1000", False)]
)
def test_nines_with_decimals_are_a_question_too(points, nines, is_asked):
    """One direction has the nines, others 110 to 170; at another wavelength radiances are larger than the nines."""
    rows = [*GRID[:5], (40, 90, nines), *GRID[6:]]
    wide = [(*row, 20000 + row[1]) for row in rows]
    long = [(*row[:2], nm, value) for row in wide for nm, value in ((440, row[3]), (550, row[2]))]
    for head, made in (
        (HEAD, rows),
        ("zenith_deg,azimuth_deg,L_550,L_440", wide),
        ("zenith_deg,azimuth_deg,wavelength_nm,radiance", long),
    ):
        if not is_asked:
            points(NORTH, head, rows=made)
            continue
        (problem,) = questions(points, NORTH, head, rows=made)
        assert (problem.code, problem.text[:6]) == ("E653", "40,90,")


def test_a_scan_that_is_repeated_has_its_mean_and_two_channels_are_refused(write):
    again = sky.read_radiance_csv(write(NORTH, HEAD, rows=[*GRID, *((z, a, 1.05 * value) for z, a, value in GRID)]))
    assert any(one.startswith("12 of 12 directions come more than once") for one in again.remarks)
    channels = [(z, a, k, v * k) for z, a, v in GRID for k in (1, 2)]
    with pytest.raises(sky.InputFileError, match="E654"):
        sky.read_radiance_csv(write(NORTH, "zenith_deg,azimuth_deg,channel,radiance", rows=channels))


@pytest.mark.parametrize("comments", [(), ("# written by a program",)])
def test_names_behind_a_comment_sign(points, comments):
    rows = [(k, *row) for k, row in enumerate(GRID)]
    found = points(NORTH, "% point\tzenith_deg\tazimuth_deg\tL_550", *comments, rows=rows, delimiter="\t")
    assert found["wavelength_nm"][0] == 550.0
    np.testing.assert_array_equal(found["radiance"], [row[-1] for row in GRID])
    how = {"zenith": "vza", "azimuth": "vaa", "variable": "L", "angle_unit": "deg"}
    stated = points(NORTH, *comments, "# point\tvza\tvaa\tL", rows=rows, delimiter="\t", **how)
    np.testing.assert_array_equal(stated["radiance"], found["radiance"])
    assert "not used: columns point" in stated["remarks"]


def test_files_of_other_encodings(write):
    path = write(NORTH, "# Messgerät: µ", "# radiance unit: µW cm-2 nm-1 sr-1", HEAD)
    text = path.read_text(encoding="utf-8")
    for encoding in ("utf-8", "utf-8-sig", "latin-1", "cp1252"):
        path.write_bytes(text.encode(encoding))
        found = read_radiance_points(path, Stated())[0]["radiance"]
        np.testing.assert_allclose(found, [5e-4, 4e-4, 3e-4, 2e-4], rtol=1e-12)
    path.write_bytes(text.encode("utf-16"))
    with pytest.raises(sky.InputFileError, match="E101") as caught:
        read_radiance_points(path, Stated())
    assert len(caught.value.problems) == 1


def test_good_files():
    measured = sky.read_radiance_csv(DATA / "radiance_csv" / "good" / "savetxt.csv")
    np.testing.assert_array_equal(measured.wavelength_nm, [443.0])
    assert not measured.is_absolute
    wide = sky.read_radiance_csv(DATA / "radiance_csv" / "good" / "wide_semicolons.csv")
    np.testing.assert_array_equal(wide.wavelength_nm, [412.0, 555.0])
    assert wide.sun_deg == pytest.approx((60.0, 225.0))
    assert "not used: columns temp" in wide.remarks
    assert wide.values[0].max() == pytest.approx(0.085)


def test_the_page_shows_the_vocabulary():
    """Every name of a coordinate and every key stands on the page of measured skies."""
    page = (REPOSITORY / "docs" / "howto" / "measured_sky.md").read_text(encoding="utf-8")
    names = [name for name in NAMES if "_" not in name]
    for word in (*KEYS, *names, "radiance_q", "L_412", "wavelength_um", "azimuth_rad"):
        assert word in page, word


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
        found, _ = read_radiance_points(tmp_path / "sky.csv", Stated())
    except sky.InputFileError as error:
        problems = error.problems
    assert all(problem.advice for problem in problems)
    if problems:
        return
    assert found["sky_zenith_deg"].shape == found["sky_azimuth_deg"].shape == found["radiance"].shape
    assert np.all(np.isfinite(found["sky_zenith_deg"]) & np.isfinite(found["sky_azimuth_deg"]))
    assert not np.any(found["radiance"] < 0)
