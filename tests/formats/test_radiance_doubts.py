"""What a table of radiances says besides its columns is read or asked about, and so are radiances that do not fit."""

import numpy as np
import pytest

import aomc_sky as sky

HEAD = "zenith_deg,azimuth_deg,radiance (mW m-2 nm-1 sr-1)"
ROWS = [(zenith, azimuth, 100.0 + zenith) for zenith in (10, 40, 70) for azimuth in (0, 90, 180, 270)]


@pytest.fixture
def table(tmp_path):
    """Writes lines and rows, and reads them."""

    def read(*lines, rows=ROWS, **options):
        path = tmp_path / "sky.csv"
        path.write_text("\n".join([*lines, *(",".join(map(str, row)) for row in rows)]) + "\n", encoding="utf-8")
        return sky.read_radiance_csv(path, **options)

    return read


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("# angles describe the direction of light propagation", "those that light goes to"),
        ("# zenith: where the photon travels", "those that light goes to"),
        ("# directions of travel of light, seen from the ship", "those that light goes to"),
        ("# radiances x 1000", "'radiances x 1000' besides the unit"),
        ("# values times 10^3", "'values times 10^' besides the unit"),
        ("# log10 of the radiances", "are these logarithms"),
        ("# Azimut: im Uhrzeigersinn von Nord", "'azimut' is not understood"),
        ("# azimut compté depuis le nord, sens horaire", "'azimut' is not understood"),
        ("# Azimut regnet fra nord mod øst", "'azimut' is not understood"),
        ("# 方位角: 北から時計回り", "is not understood"),
        ("# zenith angles are measured from the horizon", "says 'from the horizon'"),
        ("# zenith angles are nadir angles", "says 'nadir'"),
        ("# zenith: elevation of the direction", "says 'elevation'"),
        ("# zenith angle: 90 is overhead", "says '90 is overhead'"),
        ("# values are logarithms", "are these logarithms"),
        ("# All radiances in mW m-2 nm-1 sr-1, multiplied by 1000", "'multiplied' besides the unit"),
        ("# phi towards N of the ship", "'ship' is not understood"),
        ("# radiances times cos(theta)", "says 'radiances times cos'"),
        ("# values are cosine-weighted", "says 'cosine-weighted'"),
        ("# sky radiance per 10 nm", "'radiance per 10 nm' besides the unit"),
        ("# x = north, y = east", "contradict each other"),
        ("# the +x axis points to the north", "contradict each other"),
        ("# azimuths: x is towards north", "contradict each other"),
        ("# frame: NED", "'frame' is not understood"),
        ("# azimuth NED", "'ned' is not understood"),
        ("# mirrored east-west", "'mirrored' is not understood"),
        ("# angles are in ship coordinates", "'ship' is not understood"),
    ],
)
def test_lines_that_change_the_light_are_refused(table, line, why):
    with pytest.raises(sky.InputFileError, match="E651") as error:
        table(line, HEAD)
    assert why in str(error.value)


@pytest.mark.parametrize(
    "line",
    [
        "# travelled from Kiel to Bergen",
        "# Direction of travel of the ship: 120 degrees",
        "# Radiance image of 1000 x 1000 pixels",
        "# radiance values up to max 1000",
        "# log of station 7",
        "# Azimut (deg)",
        "# ship log: radiance sensor 5",
        "# Radiance in the almucantar and the principal plane",
        "# zenith: 0 = overhead, 90 = horizon",
        "# theta: zenith angle (0 = zenith, 180 = nadir)",
        "# solar zenith angle 40, solar elevation 50",
        "# station altitude: 30 m; zenith scan",
        "# scan from horizon to zenith",
        "# error propagation in zenith angle",
        "# multiply scattered light, values are logged each minute",
        "# bounding box: N=90, S=-90, W=-180, E=180",
        "# position: 54 N, 8 E",
        "# one value per 5 nm",
        "# errors are weighted by the light",
        "# mean over the patch, weighted with the cosine of the zenith angle",
        "# Tucson, AZ, 32.2 N 110.9 W",
        "# other half mirrored at the principal plane",
        "# position in ship coordinates: 3 m",
        "# frame 12, x = 3",
    ],
)
def test_other_lines_are_not(table, line):
    table("# azimuth: from north", line, HEAD)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("L_w (mW m-2 nm-1 sr-1)", "no column of radiance"), ("radiance_upwelling (W m-2 nm-1 sr-1)", "no column of"),
        ("L_4120", "are these wavelengths angstroms"), ("L_0.44um", "no column of radiance"),
    ],
)  # fmt: skip
def test_names_with_more_than_is_read(table, name, why):
    with pytest.raises(sky.InputFileError) as error:
        table(f"zenith_deg,azimuth_deg,{name}")
    assert why in str(error.value)


def test_a_standard_deviation_beside_the_radiance_is_not_used(table):
    head = "zenith_deg,azimuth_deg,radiance_mean (mW m-2 nm-1 sr-1),radiance_std (mW m-2 nm-1 sr-1)"
    measured = table("# azimuth: from north", head, rows=[(*row, 1.5) for row in ROWS])
    assert "columns not used: radiance_std (mW m-2 nm-1 sr-1)" in measured.remarks


def test_a_column_of_wavenumbers_is_no_remark(table):
    rows = [(zenith, azimuth, 18181.8, value) for zenith, azimuth, value in ROWS]
    with pytest.raises(sky.InputFileError, match="'wavenumber' is no wavelength"):
        table("zenith_deg,azimuth_deg,wavenumber,radiance", rows=rows)


def test_a_true_azimuth_is_clockwise_from_north(table):
    words = table("zenith_deg,azimuth (degrees_true),radiance")
    north = table("# azimuth: clockwise from north", "zenith_deg,azimuth_deg,radiance")
    np.testing.assert_array_equal(words.direction[0], north.direction[0])
    assert not [one for one in words.remarks if "does not say" in one]


def test_nines_far_beyond_all_other_radiances_are_a_question(table):
    rows = [*ROWS[:5], (40, 90, "9999.0"), *ROWS[6:]]
    with pytest.raises(sky.InputFileError) as error:
        table("# azimuth: from north", HEAD, rows=rows)
    assert "sky.csv:8:7" in str(error.value)
    assert "1 radiance is 9999, and the next one is 170; is 9999 a gap?" in str(error.value)
    assert table("# azimuth: from north", HEAD, rows=[*ROWS[:5], (40, 90, 1e20), *ROWS[6:]]).values[0].max() == 0.17


def test_directions_of_several_skies_have_no_mean(table):
    """Two channels, or two times, without a wavelength; a repeated scan has its mean, with a remark."""
    rows = [(*row[:2], channel, row[2] * channel) for row in ROWS for channel in (1, 2)]
    with pytest.raises(sky.InputFileError, match=r"12 of 12 directions come more than once.*up to 50 %"):
        table("# azimuth: from north", "zenith_deg,azimuth_deg,channel,radiance", rows=rows)
    again = table("# azimuth: from north", HEAD, rows=[*ROWS, *((z, a, 1.05 * value) for z, a, value in ROWS)])
    said = (
        "12 of 12 directions come more than once, with radiances that differ by up to 4.8 %; they count with their mean"
    )
    assert said in again.remarks
    equal = table("# azimuth: from north", HEAD, rows=[*ROWS, *ROWS])
    assert not [one for one in equal.remarks if "more than once" in one]


@pytest.mark.parametrize("column", [0, 1])
def test_radians_under_a_name_of_degrees_are_a_question(table, column):
    rows = [(*row[:column], f"{np.deg2rad(row[column]):.5f}", *row[column + 1 :]) for row in [*ROWS, (85, 20, 9.0)]]
    with pytest.raises(sky.InputFileError, match="degrees; are they radians"):
        table("# azimuth: from north", HEAD, rows=rows)


@pytest.mark.parametrize("line", ["# azimuth_zero: north", "# azimuth reference: north", "# azimuth_origin = north"])
def test_where_azimuths_begin_has_other_keys(table, line):
    north = table("# azimuth: clockwise from north", HEAD)
    np.testing.assert_array_equal(table(line, "# azimuth_sense: clockwise", HEAD).direction[0], north.direction[0])


@pytest.mark.parametrize(
    "units", ["deg,deg,mW m-2 nm-1 sr-1", "(deg),(deg),(mW m-2 nm-1 sr-1)", "[°],[° E of N],[mW/(m2 nm sr)]"]
)
def test_a_row_of_units_below_the_names(table, units):
    wanted = table("# azimuth: from north", HEAD)
    measured = table("# azimuth: from north", "zenith,azimuth,radiance", units)
    assert measured.is_absolute
    np.testing.assert_allclose(measured.values[0], wanted.values[0], rtol=1e-12)
    np.testing.assert_array_equal(measured.direction[0], wanted.direction[0])
    with pytest.raises(sky.InputFileError, match="'cd/m2' is no unit of spectral radiance"):
        table("zenith,azimuth,radiance", "deg,deg,cd/m2")
    with pytest.raises(sky.InputFileError, match="'zenith_deg' is not a number"):
        table(HEAD, HEAD)


def test_lines_above_the_names_are_comments(table):
    with pytest.raises(sky.InputFileError, match=r"the names of the columns are in line 4, with commas") as error:
        table("Instrument: EKO MS-321LR", "Site: Tsukuba, Japan", "", HEAD)
    assert "write # before every line above line 4" in str(error.value)
    assert len(error.value.problems) == 1


@pytest.mark.parametrize(
    ("line", "factor"),
    [
        ("# Radiance in mW m-2 nm-1 sr-1", 1e-3),
        ("# radiance values are given in 10^-2 W m-2 nm-1 sr-1.", 1e-2),
        ("# Radiance units are mW/m2/nm/sr", 1e-3),
        ("# All sky radiances are in mW/(m2 nm sr) at the sea", 0.0),
        ("# All sky radiances are in uW/(cm2 nm sr), without the sun", 1e-2),
        ("# L is in W m-2 um-1 sr-1 (spectral radiance)", 1e-3),
        ("# Radiance uncertainty in mW m-2 nm-1 sr-1: 2", 0.0),
    ],
)
def test_a_unit_in_a_sentence(table, line, factor):
    measured = table("# azimuth: from north", line, "zenith_deg,azimuth_deg,radiance")
    assert measured.is_absolute == (factor > 0)
    assert measured.values[0].max() == pytest.approx(170 * (factor or 1))
    with pytest.raises(sky.InputFileError, match="is no unit of spectral radiance"):
        table("# Radiance in cd m-2", "zenith_deg,azimuth_deg,radiance")


def test_more_words_in_names_of_angles(table):
    wanted = table("# azimuth: from north", HEAD)
    measured = table(
        "# azimuth: from north", "zenith of view (deg),azimuth angle true (deg),radiance (mW m-2 nm-1 sr-1)"
    )
    np.testing.assert_array_equal(measured.direction[0], wanted.direction[0])
    with pytest.raises(sky.InputFileError, match="no column of zenith angles"):
        table("zenith_sun (deg),azimuth_deg,radiance (mW m-2 nm-1 sr-1)")


@pytest.mark.parametrize(
    ("words", "is_refused"),
    [("azimut ", False), ("ln ", False), ("radiance in W/m .", True), ("radiance x 1", False), ("direction ", False)],
)
def test_long_lines_of_a_stranger_take_no_time(table, words, is_refused):
    """Patterns that look ahead are quadratic in the length of a line: 64 kB would take minutes."""
    line = f"# {words * (60_000 // len(words))}x"
    if is_refused:
        with pytest.raises(sky.InputFileError, match=r"no unit of spectral radiance|beside"):
            table("# azimuth: from north", line, HEAD)
    else:
        assert table("# azimuth: from north", line, HEAD).is_absolute


@pytest.mark.parametrize("name", ["mu", "cos_zenith", "nadir angle (deg)"])
def test_other_angles_than_zenith_angles_are_named(table, name):
    with pytest.raises(sky.InputFileError, match="is no zenith angle"):
        table(f"{name},azimuth_deg,radiance (mW m-2 nm-1 sr-1)")


def test_angles_in_another_unit_are_not_called_degrees(table):
    """To follow '--angle-unit deg' would read gradians as degrees."""
    with pytest.raises(sky.InputFileError, match="'gon' is no unit of an angle that is read") as error:
        table("zenith_gon,azimuth_deg,radiance (mW m-2 nm-1 sr-1)")
    assert "--angle-unit" not in str(error.value)


@pytest.mark.parametrize("value", [9.999e20, 1e15, 65535.0])
def test_numbers_far_beyond_all_others_are_a_question(table, value):
    with pytest.raises(sky.InputFileError, match="a gap") as error:
        table("# azimuth: from north", HEAD, rows=[*ROWS[1:], (*ROWS[0][:2], value)])
    assert "E653" in str(error.value)


def test_directions_that_light_goes_to_are_asked_about(table):
    rows = [(180 - zenith, azimuth, value) for zenith, azimuth, value in ROWS]
    with pytest.raises(sky.InputFileError, match="no direction is above the horizon"):
        table("# azimuth: from north", HEAD, rows=[*rows, (90, 0, 1), (90, 120, 1), (90, 240, 1)])


@pytest.mark.parametrize(
    "head", ["zenith in deg,azimuth_deg,radiance in mW/(m2 nm sr)", "θ (deg),φ (deg),L (in mW/m2/nm/sr)"]
)
def test_units_behind_the_word_in_and_greek_letters(table, head):
    assert table("# azimuth: from north", head).is_absolute


def test_a_column_of_the_deviation_at_a_wavelength_is_not_used(table):
    measured = table(
        "# azimuth: from north", "zenith_deg,azimuth_deg,L(440),L_440_std", rows=[(*row, 1) for row in ROWS]
    )
    assert measured.wavelength_nm.tolist() == [440.0]
    assert "columns not used: L_440_std" in measured.remarks


@pytest.mark.parametrize(
    "line",
    [
        "# North: 0 deg, East: 90 deg",
        "# 0°=N, 90°=E, 180°=S, 270°=W",
        "# phi=0 at N, increasing through E",
        "# az=0 points north",
        "# AZ 0 NORTH",
        "# azimuth clockwise from north, radiance in mW m-2 nm-1 sr-1",
        "# Sky radiance data (mW m-2 nm-1 sr-1), azimuth north=0",
    ],
)
def test_where_azimuths_begin_without_the_usual_words(table, line):
    expected, measured = table("# azimuth: clockwise from north", HEAD), table(line, HEAD)
    np.testing.assert_array_equal(measured.direction[0], expected.direction[0])
    assert not [one for one in measured.remarks if "does not say" in one]


@pytest.mark.parametrize("comments", [(), ("# azimuth: clockwise from north", "# written by a program")])
def test_names_behind_a_comment_sign_have_more_comments_below(table, comments):
    rows = [("\t".join(map(str, (k, *row))),) for k, row in enumerate(ROWS)]
    measured = table("# point\tzenith\tazimuth\tL_550", *comments, rows=rows)
    expected = table(*comments, "zenith,azimuth,L_550")
    assert measured.wavelength_nm == 550.0
    np.testing.assert_array_equal(measured.direction[0], expected.direction[0])
    np.testing.assert_array_equal(measured.values[0], expected.values[0])


@pytest.mark.parametrize(("nines", "is_asked"), [("999.9", True), ("9999.99", True), ("99.9", False), ("1000", False)])
def test_nines_with_decimals_are_a_question_too(table, nines, is_asked):
    """One direction has the nines, others 110 to 170; at another wavelength radiances are larger than the nines."""
    rows = [*ROWS[:5], (40, 90, nines), *ROWS[6:]]
    wide = [(*row, 20000 + row[1]) for row in rows]
    long = [(*row[:2], nm, value) for row in wide for nm, value in ((440, row[3]), (550, row[2]))]
    for head, made in (
        (HEAD, rows),
        ("zenith_deg,azimuth_deg,L_550,L_440", wide),
        ("zenith_deg,azimuth_deg,wavelength,radiance", long),
    ):
        if not is_asked:
            table("# azimuth: from north", head, rows=made)
            continue
        with pytest.raises(sky.InputFileError, match=f"1 radiance is {nines}, and the next one is 170; is") as error:
            table("# azimuth: from north", head, rows=made)
        assert "40,90," in error.value.problems[0].text


@pytest.mark.parametrize(
    "name", ["Lsky(550) [mW m^{-2} nm^{-1} sr^{-1}]", "L(550 nm) (mW m$^{-2}$ nm$^{-1}$ sr$^{-1}$)"]
)
def test_a_wavelength_and_a_unit_in_brackets(table, name):
    measured = table("# azimuth: from north", f"zenith_deg,azimuth_deg,{name}")
    assert measured.wavelength_nm == 550.0
    assert measured.values[0].max() == pytest.approx(0.17)


def test_bars_between_columns_are_named(table):
    with pytest.raises(sky.InputFileError, match="bars are between the columns"):
        table("zenith|azimuth|radiance", rows=[("|".join(map(str, row)),) for row in ROWS])
    with pytest.raises(sky.InputFileError, match="columns 2 and 3 are both azimuth"):
        table("zenith,azimuth,raa,radiance", rows=[(z, a, a, value) for z, a, value in ROWS])


@pytest.mark.parametrize("gap", ["", "nan", "-999"])
@pytest.mark.parametrize(("name", "overhead"), [("zenith_deg", 0), ("elevation_deg", 90)])
def test_the_zenith_needs_no_azimuth(table, gap, name, overhead):
    rows = [*((abs(90 - z) if overhead else z, a, value) for z, a, value in ROWS), (overhead, gap, 130.0)]
    measured = table("# azimuth: from north", f"{name},azimuth_deg,radiance (mW m-2 nm-1 sr-1)", rows=rows)
    assert measured.values[0].size == len(ROWS) + 1
    assert measured.radiance(0.0, 0.0, 550.0) == pytest.approx(0.130)
    assert not [one for one in measured.remarks if "left out" in one]
