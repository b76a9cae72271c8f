"""The readings of the real program: every value it understood, every file it should not have taken."""

from collections import defaultdict

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.aomc.amc import fields_of_layout, read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import read_skydist
from tests.support.shared import AOMC, csv_rows

_UNDERSTOOD = """
    plain crlf trailing_notes iterations_right_justified_in_field iterations_limit iterations_overflow
    zenith_plus_sign thickness_minus_one diameter_d_exponent diameter_signed_exponent_no_letter
"""
UNDERSTOOD = set(_UNDERSTOOD.split())
_SKY_FINE = """
    plain above_float32_max azimuth_0_and_360 bang_comment_after blank_lines byte_order_mark crlf d_exponent
    denormal_float32 extra_words header_on_two_lines repeat_count semicolons wavelengths_on_two_lines wide_blank
    zenith_120
"""
SKY_FINE = set(_SKY_FINE.split())
SKY_WRONG = {
    (4, "E301"): "azimuth_negative wave_index_above", (5, "E301"): "azimuth_above_header",
    (6, "E301"): "zenith_above_header", (4, "E302"): "nan_value inf_value negative_large", (6, "E302"): "negative_last",
    (1, "E303"): "header_count_too_large header_count_too_small two_elements_per_line", (1, "E305"): "empty",
    (2, "E303"): "too_few_wavelengths", (4, "E305"): "fraction_index real_index short_line word_for_radiance",
    (4, "E306"): "null_between_commas",
}  # fmt: skip
"""Line and code of the first problem of every other file."""
SKY_WRONG = {case: first for first, cases in SKY_WRONG.items() for case in cases.split()}


def parsed_by_case():
    found: dict[str, list[str]] = defaultdict(list)
    for row in csv_rows(AOMC / "amc_variants/parsed.csv"):
        found[row["case"]].append(row["value"])
    return found


def accepted():
    table = csv_rows(AOMC / "amc_variants/outcomes.csv")
    return [row["case"] for row in table if row["outcome"] == "accepted"]


def assert_same(config, values):
    fields = fields_of_layout(config.use_polar_cap is not None)
    assert len(fields) == len(values)
    for field, text in zip(fields, values, strict=True):
        got = getattr(config, field.name)
        if field.decimals is None:
            assert int(got) == int(text), field.name
        else:
            assert np.float32(got) == np.float32(text), field.name


@pytest.mark.parametrize("case", accepted())
def test_lenient_takes_the_program_s_values(case):
    path = AOMC / f"amc_variants/{case}.inp"
    if case == "diameter_nan":
        with pytest.raises(InputFileError, match="E107"):
            read_amc(path, lenient=True)
        return
    if case in UNDERSTOOD:
        assert_same(read_amc(path), parsed_by_case()[case])
    else:
        with pytest.raises(InputFileError, match=r"E10[3-9]"):
            read_amc(path)
        with pytest.warns(InputWarning):
            assert_same(read_amc(path, lenient=True), parsed_by_case()[case])


@pytest.mark.parametrize("case", sorted(set(parsed_by_case()) - set(accepted()) - UNDERSTOOD))
@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
def test_what_the_program_refuses_stays_refused(case):
    for lenient in (False, True):
        with pytest.raises(InputFileError) as caught:
            read_amc(AOMC / f"amc_variants/{case}.inp", lenient=lenient)
        assert all(problem.line >= 1 and problem.column >= 1 for problem in caught.value.problems)


@pytest.mark.parametrize("case", sorted(SKY_FINE))
def test_sky_files_that_are_fine(case):
    table = read_skydist(AOMC / f"skydist_variants/{case}.inp")
    assert np.count_nonzero(table.line) > 0
    assert np.all(np.isfinite(table.radiance))


@pytest.mark.parametrize("case", sorted(SKY_WRONG))
def test_sky_files_that_are_wrong(case):
    with pytest.raises(InputFileError) as caught:
        read_skydist(AOMC / f"skydist_variants/{case}.inp")
    first = caught.value.problems[0]
    assert (first.line, first.code) == SKY_WRONG[case]


def test_every_sky_file_is_judged():
    assert {path.stem for path in (AOMC / "skydist_variants").glob("*.inp")} == SKY_FINE | set(SKY_WRONG)


@pytest.mark.parametrize("name", ["mobley1", "multiband", "simple_relationship", "older_layout"])
@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
def test_published_input_files(name):
    folder = AOMC / "program_inputs" / name
    config = read_amc(folder / "amc.inp", lenient=True)
    assert_same(config, [row["value"] for row in csv_rows(folder / "parsed_amc.csv") if row["name"] != "range_error"])
    if not (folder / "parsed_bands.csv").exists():
        return
    bands = csv_rows(folder / "parsed_bands.csv")
    has_target = config.bottom_target
    lambbot = read_lambbot(folder / "lambbot.inp", n_wavebands=config.n_wavebands, has_target=has_target, lenient=True)
    difcol = read_difcol(folder / "difcol.inp", n_wavebands=config.n_wavebands)
    columns = {
        "wavelength": lambbot.wavelength_nm,
        "bottom_reflectance": lambbot.bottom_reflectance,
        "bottom_specular": lambbot.bottom_specular_fraction,
        "target_reflectance": lambbot.target_reflectance,
        "target_specular": lambbot.target_specular_fraction,
        "direct": difcol.direct_fraction,
        "intensity": difcol.intensity,
    }
    assert len(bands) == config.n_wavebands
    for column, values in columns.items():
        wanted = [row[column] for row in bands]
        if values is None:
            assert set(wanted) == {""}
        elif set(wanted) != {""}:
            assert np.array_equal(np.float32(values), np.array(wanted, dtype=np.float32)), column


_FORMATS = """
    I12 I1 I8 I8 I8 F12.2 F12.2 I8 F12.4 I8 I8 I1 I1 I1 I1 I1 I8 I8 I8 F12.6 I1 I1 F12.6 F12.6 F12.6 I1 F12.6 F12.6 I1
    I8
"""
FORMATS = _FORMATS.split()
"""The program's format of each line, from column 49 on."""


@pytest.mark.parametrize("line", range(30))
@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
def test_every_field_ends_where_the_program_s_format_ends(line, tmp_path):
    """Leading zeros fill the field up to its last column; the 9 after it is read by nobody."""
    kind, width = FORMATS[line][0], int(FORMATS[line][1:].partition(".")[0])
    number = ("1.5" if kind == "F" else "1").zfill(width)
    lines = (AOMC / "amc_variants/plain.inp").read_text().splitlines()
    lines[line] = f"{lines[line][:48]:48}{number}9"
    (tmp_path / "amc.inp").write_text("\n".join(lines) + "\n")
    config = read_amc(tmp_path / "amc.inp", lenient=True)
    assert getattr(config, fields_of_layout(False)[line].name) == float(number)
