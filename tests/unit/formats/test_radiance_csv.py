"""Tables of measured radiances: names, units and conventions as people write them are one sky."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.formats.radiance_csv import read_radiance_points
from aomc_sky.formats.radiance_words import convention_of, name_of_column, radiance_factor
from tests.support.shared import DATA

ROWS = [(10.0, 20.0, 443.0, 0.05), (40.0, 110.0, 443.0, 0.04), (60.0, 230.0, 443.0, 0.03), (80.0, 350.0, 443.0, 0.02)]


def write(path, head, rows, delimiter=","):
    path.write_text("\n".join([*head, *(delimiter.join(map(str, row)) for row in rows)]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("W m-2 nm-1 sr-1", 1.0), ("W/(m^2 nm sr)", 1.0), ("W/m²/sr/nm", 1.0), ("W m**-2 sr**-1 nm**-1", 1.0),
        ("mW m-2 nm-1 sr-1", 1e-3), ("mW m⁻² nm⁻¹ sr⁻¹", 1e-3), ("uW cm-2 nm-1 sr-1", 1e-2), ("µW/cm2/sr/nm", 1e-2),
        ("W m-2 um-1 sr-1", 1e-3), ("W_m2_nm_sr", 1.0), ("kW per m2 per sr per nm", 1e3), ("relative", 0.0),
        ("counts", 0.0), ("W m-2 nm-1", None), ("W m-2 sr-1", None), ("cd m-2", None), ("umol m-2 s-1", None),
        ("W m-2 nm-1 sr-1 s", None), ("W W m2 nm sr", None),
    ],
)  # fmt: skip
def test_units_of_radiance(unit, factor):
    assert radiance_factor(unit) == (factor if factor is None else pytest.approx(factor, rel=1e-15))


@pytest.mark.parametrize(
    ("text", "convention"),
    [
        ("clockwise from north", "north_clockwise"), ("from north, clockwise", "north_clockwise"),
        ("north_clockwise", "north_clockwise"), ("from north", "north_clockwise"), ("enu_from_east", "enu_from_east"),
        ("counter-clockwise from east", "enu_from_east"), ("anticlockwise from the east", "enu_from_east"),
        ("west of south", "west_of_south"), ("from the sun", "from_sun"), ("relative to the sun", "from_sun"),
        ("from_sun_clockwise", "from_sun_clockwise"), ("clockwise from the sun", "from_sun_clockwise"),
        ("counterclockwise from sun", "from_sun"), ("clockwise from east", None), ("", None), ("measured", None),
        ("counterclockwise from north", None), ("E of N", "north_clockwise"), ("north of east", "enu_from_east"),
        ("n of w", None), ("north cw", "north_clockwise"), ("ccw from x", "enu_from_east"), ("cw", None),
        ("from north towards east", "north_clockwise"), ("from east to north", "enu_from_east"),
    ],
)  # fmt: skip
def test_words_for_azimuths(text, convention):
    assert convention_of(text) == convention


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Zenith angle [deg]", ("zenith", "deg", None)), ("zenith_rad", ("zenith", "rad", None)),
        ("elevation (°)", ("elevation", "°", None)), ("VAA", ("azimuth", "", None)),
        ("relative_azimuth_deg", ("relative azimuth", "deg", None)), ("Wavelength (um)", ("wavelength", "um", None)),
        ("radiance_W_m2_nm_sr", ("radiance", "w m2 nm sr", None)),
        ("radiance (mW/(m2 nm sr))", ("radiance", "mW/(m2 nm sr", None)), ("L_412.5", ("radiance", "", 412.5)),
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
    path = write(tmp_path / "sky.csv", [head], [(z, a, v) for z, a, _, v in ROWS])
    points = read_radiance_points(path)
    expected = [(90 - a) % 360 if clockwise else a for _, a, _, _ in ROWS]
    np.testing.assert_allclose(points["sky_azimuth_deg"], expected)
    assert not any("azimuths count" in remark for remark in points["remarks"])


def test_a_semicolon_before_an_empty_column_is_no_comment(tmp_path):
    rows = [("", *row) for row in ROWS]
    path = write(tmp_path / "sky.csv", ["; a comment", ";zenith;azimuth;wavelength;L"], rows, ";")
    np.testing.assert_allclose(read_radiance_points(path)["sky_zenith_deg"], [10, 40, 60, 80])


def test_signs_of_other_encodings(tmp_path):
    text = "zenith (°),azimuth (°),radiance (µW cm-2 nm-1 sr-1)\n" + "".join(f"{z},{a},{v}\n" for z, a, _, v in ROWS)
    read = []
    for encoding in ("utf-8", "utf-8-sig", "latin-1", "cp1252"):
        (tmp_path / "sky.csv").write_bytes(text.encode(encoding))
        read.append(read_radiance_points(tmp_path / "sky.csv")["radiance"])
        np.testing.assert_array_equal(read[-1], read[0])
    assert read[0][0] == pytest.approx(5e-4)
    (tmp_path / "sky.csv").write_bytes(text.encode("utf-16"))
    with pytest.raises(sky.InputFileError, match=r"the file is UTF-16\n") as caught:
        read_radiance_points(tmp_path / "sky.csv")
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    ("head", "delimiter", "message"),
    [
        ("zenith azimuth radiance", " ", "blanks are between the columns(.|\n)*separate the columns by commas"),
        ("zenith,azimuth_cw,L", ",", "'cw' does not say from where azimuths count(.|\n)*--azimuth-convention"),
        ("zenith,azimuth of sun,L", ",", "'of sun' is no unit of an angle(.|\\n)*--azimuth-convention"),
        ("zenith,azimuth (gon),L", ",", "'gon' is no unit of an angle(.|\n)*--azimuth-convention"),
    ],
)
def test_what_is_not_clear_is_one_sentence(tmp_path, head, delimiter, message):
    with pytest.raises(sky.InputFileError, match=message) as caught:
        read_radiance_points(write(tmp_path / "sky.csv", [head], [(z, a, v) for z, a, _, v in ROWS], delimiter))
    assert len(caught.value.problems) == 1


def test_arguments_win_over_the_file(tmp_path):
    head = ["# azimuth: enu_from_east", "# radiance unit: relative", "zenith,azimuth,L"]
    path = write(tmp_path / "sky.csv", head, [(z, a, v) for z, a, _, v in ROWS])
    points = read_radiance_points(
        path, azimuth_convention="from_sun", sun_azimuth_deg=30.0, radiance_unit="mW/m2/nm/sr"
    )
    np.testing.assert_allclose(points["sky_azimuth_deg"], [50.0, 140.0, 260.0, 20.0])
    np.testing.assert_allclose(points["radiance"], [5e-5, 4e-5, 3e-5, 2e-5])
    assert points["is_absolute"]
    with pytest.raises(sky.UsageError, match="radiance unit 'lux' is not known; write 'W m-2 nm-1 sr-1'"):
        read_radiance_points(path, radiance_unit="lux")
    with pytest.raises(sky.UsageError, match=r"azimuth_convention must be one of 'north_clockwise'.*got 'south'"):
        read_radiance_points(path, azimuth_convention="south")


def test_gaps_are_counted_and_said(tmp_path):
    rows = [*ROWS, (50, 50, 443, ""), (51, 50, 443, "nan"), (52, 50, 443, -999), (95, 0, 443, 1), ("", 0, 443, 1)]
    head = ["# azimuth: enu_from_east", "zenith_deg,azimuth_deg,wavelength,radiance"]
    measured = sky.read_radiance_csv(write(tmp_path / "sky.csv", head, rows))
    assert len(measured.values[0]) == 4
    assert any("3 of 8 radiances are gaps" in remark for remark in measured.remarks)
    assert any("1 of 8 radiances are directions below the horizon" in remark for remark in measured.remarks)
    assert any("1 radiances without direction or wavelength" in remark for remark in measured.remarks)
    assert any(
        "no unit of radiance, so its light is relative (--radiance-unit" in remark for remark in measured.remarks
    )


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
    try:
        points = read_radiance_points(tmp_path / "sky.csv")
    except sky.InputFileError as error:
        problems = error.problems
    else:
        problems = ()
    assert all(problem.advice for problem in problems)
    if problems:
        return
    assert points["sky_zenith_deg"].shape == points["sky_azimuth_deg"].shape == points["radiance"].shape
    assert np.all(np.isfinite(points["sky_zenith_deg"]) & np.isfinite(points["sky_azimuth_deg"]))
    assert not np.any(points["radiance"] < 0)
