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


NAMES = "zenith_deg,azimuth_deg,radiance"
NORTH = "# azimuth: from north"
UNIT = "(mW m-2 nm-1 sr-1)"


def with_row(k, value, column=2, rows=ROWS):
    """The rows with another value in one of them."""
    row = [*rows[k][:column], value, *rows[k][column + 1 :]]
    return [*rows[:k], row, *rows[k + 1 :]]


REFUSED = {
    # lines that change the light
    ("# angles describe the direction of light propagation", HEAD): "E651(?s:.*)those that light goes to",
    ("# zenith: where the photon travels", HEAD): "E651(?s:.*)those that light goes to",
    ("# radiances x 1000", HEAD): "E651(?s:.*)'radiances x 1000' besides the unit",
    ("# values times 10^3", HEAD): r"E651(?s:.*)'values times 10\^' besides the unit",
    ("# log10 of the radiances", HEAD): "E651(?s:.*)are these logarithms",
    ("# Azimut: im Uhrzeigersinn von Nord", HEAD): "E651(?s:.*)'azimut' is not understood",
    ("# 方位角: 北から時計回り", HEAD): "E651(?s:.*)is not understood",
    ("# zenith angles are measured from the horizon", HEAD): "E651(?s:.*)says 'from the horizon'",
    ("# zenith angles are nadir angles", HEAD): "E651(?s:.*)says 'nadir'",
    ("# zenith: elevation of the direction", HEAD): "E651(?s:.*)says 'elevation'",
    ("# zenith angle: 90 is overhead", HEAD): "E651(?s:.*)says '90 is overhead'",
    ("# radiances times cos(theta)", HEAD): "E651(?s:.*)says 'radiances times cos'",
    ("# values are cosine-weighted", HEAD): "E651(?s:.*)says 'cosine-weighted'",
    ("# sky radiance per 10 nm", HEAD): "E651(?s:.*)'radiance per 10 nm' besides the unit",
    ("# x = north, y = east", HEAD): "E651(?s:.*)contradict each other",
    ("# the +x axis points to the north", HEAD): "E651(?s:.*)contradict each other",
    ("# frame: NED", HEAD): "E651(?s:.*)'frame' is not understood",
    ("# mirrored east-west", HEAD): "E651(?s:.*)'mirrored' is not understood",
    ("# angles are in ship coordinates", HEAD): "E651(?s:.*)'ship' is not understood",
    ("# All radiances in mW m-2 nm-1 sr-1, multiplied by 1000", HEAD): "E651(?s:.*)'multiplied' besides the unit",
    # names with more than is read
    ("zenith_deg,azimuth_deg,radiance_upwelling (W m-2 nm-1 sr-1)",): "no column of radiance",
    ("zenith_deg,azimuth_deg,L_4120",): "are these wavelengths angstroms",
    ("zenith_deg,azimuth_deg,L_0.44um",): "no column of radiance",
    (f"zenith_sun (deg),azimuth_deg,radiance {UNIT}",): "no column of zenith angles",
    (f"cos_zenith,azimuth_deg,radiance {UNIT}",): "is no zenith angle",
    (f"nadir angle (deg),azimuth_deg,radiance {UNIT}",): "is no zenith angle",
    # to follow '--angle-unit deg' would read gradians as degrees
    (f"zenith_gon,azimuth_deg,radiance {UNIT}",): "^(?!(?s:.*)--angle-unit)(?s:.*)'gon' is no unit of an angle that",
    # units and lines of names
    ("zenith,azimuth,radiance", "deg,deg,cd/m2"): "'cd/m2' is no unit of spectral radiance",
    (HEAD, HEAD): "'zenith_deg' is not a number",
    # azimuths and angles that are not clear
    ("zenith,azimuth_cw,L",): "'cw' does not say from where azimuths count(?s:.*)--azimuth-convention",
    ("zenith,azimuth of sun,L",): "'of sun' does not say clearly from where(?s:.*)--azimuth-convention",
    ("zenith,azimuth (gon),L",): "'gon' is no unit of an angle(?s:.*)--azimuth-convention",
    ("Instrument: EKO MS-321LR", "Site: Tsukuba, Japan", "", HEAD):
        "the names of the columns are in line 4, with commas(?s:.*)write # before every line above line 4",
}  # fmt: skip
"""Lines of a file above good rows, and what is said."""


@pytest.mark.parametrize("lines", REFUSED)
def test_lines_and_names_that_are_refused(table, lines):
    with pytest.raises(sky.InputFileError, match=REFUSED[lines]) as error:
        table(*lines)
    assert len(error.value.problems) == 1 or not lines[0].startswith("Instrument")


ASKED = {
    "wavenumbers": ("zenith_deg,azimuth_deg,wavenumber,radiance", [(z, a, 18181.8, v) for z, a, v in ROWS],
                    "'wavenumber' is no wavelength"),
    "two channels": ("zenith_deg,azimuth_deg,channel,radiance", [(z, a, k, v * k) for z, a, v in ROWS for k in (1, 2)],
                     "12 of 12 directions come more than once.*up to 50 %"),
    "nines": (HEAD, with_row(5, "9999.0"),
              r"sky\.csv:8:7(?s:.*)1 radiance is 9999, and the next one is 170; is 9999 a gap\?"),
    **{f"number {value}": (HEAD, with_row(0, value), "E653(?s:.*)a gap") for value in (9.999e20, 1e15, 65535.0)},
    "upwards": (HEAD, [*((180 - z, a, v) for z, a, v in ROWS), *((90, a, 1) for a in (0, 120, 240))],
                "no direction is above the horizon"),
    **{f"radians in column {k}": (HEAD, [(*row[:k], f"{np.deg2rad(row[k]):.5f}", *row[k + 1 :])
       for row in [*ROWS, (85, 20, 9.0)]], "degrees; are they radians") for k in (0, 1)},
}  # fmt: skip
"""Names of columns, rows, and the question."""


@pytest.mark.parametrize("name", ASKED)
def test_rows_that_do_not_fit_are_a_question(table, name):
    head, rows, question = ASKED[name]
    with pytest.raises(sky.InputFileError, match=question):
        table(NORTH, head, rows=rows)


@pytest.mark.parametrize(
    "line",
    [
        "# travelled from Kiel to Bergen", "# Direction of travel of the ship: 120 degrees",
        "# Radiance image of 1000 x 1000 pixels", "# radiance values up to max 1000", "# log of station 7",
        "# Azimut (deg)", "# ship log: radiance sensor 5", "# Radiance in the almucantar and the principal plane",
        "# zenith: 0 = overhead, 90 = horizon", "# theta: zenith angle (0 = zenith, 180 = nadir)",
        "# solar zenith angle 40, solar elevation 50", "# station altitude: 30 m; zenith scan",
        "# scan from horizon to zenith", "# error propagation in zenith angle",
        "# multiply scattered light, values are logged each minute", "# bounding box: N=90, S=-90, W=-180, E=180",
        "# position: 54 N, 8 E", "# one value per 5 nm", "# errors are weighted by the light",
        "# mean over the patch, weighted with the cosine of the zenith angle", "# Tucson, AZ, 32.2 N 110.9 W",
        "# other half mirrored at the principal plane", "# position in ship coordinates: 3 m", "# frame 12, x = 3",
    ],
)  # fmt: skip
def test_other_lines_are_not(table, line):
    table(NORTH, line, HEAD)


@pytest.mark.parametrize(
    ("names", "unused"),
    [
        (f"radiance_mean {UNIT},radiance_std {UNIT}", f"radiance_std {UNIT}"),
        ("L(440),L_440_std", "L_440_std"),
    ],
)
def test_a_standard_deviation_beside_the_radiance_is_not_used(table, names, unused):
    measured = table(NORTH, f"zenith_deg,azimuth_deg,{names}", rows=[(*row, 1.5) for row in ROWS])
    assert f"columns not used: {unused}" in measured.remarks
    assert measured.wavelength_nm.tolist() == [440.0 if "440" in names else 550.0]


SAME = [
    ("zenith_deg,azimuth (degrees_true),radiance",),
    *(
        (line, "# azimuth_sense: clockwise", HEAD)
        for line in ("# azimuth_zero: north", "# azimuth reference: north", "# azimuth_origin = north")
    ),
    (NORTH, f"zenith of view (deg),azimuth angle true (deg),radiance {UNIT}"),
    (NORTH, "zenith in deg,azimuth_deg,radiance in mW/(m2 nm sr)"),
    (NORTH, "θ (deg),φ (deg),L (in mW/m2/nm/sr)"),
    (NORTH, "zenith_deg,azimuth_deg,Lsky(550) [mW m^{-2} nm^{-1} sr^{-1}]"),
    (NORTH, "zenith_deg,azimuth_deg,L(550 nm) (mW m$^{-2}$ nm$^{-1}$ sr$^{-1}$)"),
    *(
        (NORTH, "zenith,azimuth,radiance", units)
        for units in ("deg,deg,mW m-2 nm-1 sr-1", f"(deg),(deg),{UNIT}", "[°],[° E of N],[mW/(m2 nm sr)]")
    ),
    *(
        (line, HEAD)
        for line in (
            "# North: 0 deg, East: 90 deg", "# 0°=N, 90°=E, 180°=S, 270°=W", "# phi=0 at N, increasing through E",
            "# az=0 points north", "# AZ 0 NORTH", "# azimuth clockwise from north, radiance in mW m-2 nm-1 sr-1",
            "# Sky radiance data (mW m-2 nm-1 sr-1), azimuth north=0",
        )
    ),
]  # fmt: skip
"""Other words for the same table; a true azimuth is clockwise from north."""


@pytest.mark.parametrize("lines", SAME, ids=" ".join)
def test_other_words_for_the_same_table(table, lines):
    wanted, measured = table(NORTH, HEAD), table(*lines)
    np.testing.assert_array_equal(measured.direction[0], wanted.direction[0])
    assert measured.wavelength_nm == wanted.wavelength_nm
    assert not [one for one in measured.remarks if "does not say" in one]
    assert measured.is_absolute == (lines is not SAME[0])
    if measured.is_absolute:
        np.testing.assert_allclose(measured.values[0], wanted.values[0], rtol=1e-12)


def test_a_scan_that_is_repeated_has_its_mean(table):
    again = table(NORTH, HEAD, rows=[*ROWS, *((z, a, 1.05 * value) for z, a, value in ROWS)])
    said = "12 of 12 directions come more than once, with radiances that differ by up to 4.8 %; they count with their"
    assert any(one.startswith(said) for one in again.remarks)
    equal = table(NORTH, HEAD, rows=[*ROWS, *ROWS])
    assert not [one for one in equal.remarks if "more than once" in one]


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
    measured = table(NORTH, line, NAMES)
    assert measured.is_absolute == (factor > 0)
    assert measured.values[0].max() == pytest.approx(170 * (factor or 1))


@pytest.mark.parametrize(
    ("words", "is_refused"),
    [("azimut ", False), ("ln ", False), ("radiance in W/m .", True), ("radiance x 1", False), ("direction ", False)],
)
def test_long_lines_of_a_stranger_take_no_time(table, words, is_refused):
    """Patterns that look ahead are quadratic in the length of a line: 64 kB would take minutes."""
    line = f"# {words * (60_000 // len(words))}x"
    if is_refused:
        with pytest.raises(sky.InputFileError, match=r"no unit of spectral radiance|beside"):
            table(NORTH, line, HEAD)
    else:
        assert table(NORTH, line, HEAD).is_absolute


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
            table(NORTH, head, rows=made)
            continue
        with pytest.raises(sky.InputFileError, match=f"1 radiance is {nines}, and the next one is 170; is") as error:
            table(NORTH, head, rows=made)
        assert "40,90," in error.value.problems[0].text


def test_bars_between_columns_are_named(table):
    with pytest.raises(sky.InputFileError, match="bars are between the columns"):
        table("zenith|azimuth|radiance", rows=[("|".join(map(str, row)),) for row in ROWS])
    with pytest.raises(sky.InputFileError, match=r"blanks are between the columns(?s:.*)by commas"):
        table("zenith azimuth radiance", rows=[(" ".join(map(str, row)),) for row in ROWS])
    with pytest.raises(sky.InputFileError, match="columns 2 and 3 are both azimuth"):
        table("zenith,azimuth,raa,radiance", rows=[(z, a, a, value) for z, a, value in ROWS])


@pytest.mark.parametrize("gap", ["", "nan", "-999"])
@pytest.mark.parametrize(("name", "overhead"), [("zenith_deg", 0), ("elevation_deg", 90)])
def test_the_zenith_needs_no_azimuth(table, gap, name, overhead):
    rows = [*((abs(90 - z) if overhead else z, a, value) for z, a, value in ROWS), (overhead, gap, 130.0)]
    measured = table(NORTH, f"{name},azimuth_deg,radiance (mW m-2 nm-1 sr-1)", rows=rows)
    assert measured.values[0].size == len(ROWS) + 1
    assert measured.radiance(0.0, 0.0, 550.0) == pytest.approx(0.130)
    assert not [one for one in measured.remarks if "left out" in one]
