"""AMC's own files: what the readers make of good ones, what --lenient changes, and what is no file."""

from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.aomc.amc import FootprintCode, LightSource, read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.scanner import fixed_value
from tests.support.shared import DATA


def test_amc_values():
    config = read_amc(DATA / "amc/good/thirty_lines.inp")
    assert config.iterations == 5_000_000
    assert config.light_source is LightSource.FILE
    assert (config.direct_azimuth_deg, config.direct_zenith_deg) == (45, 30)
    assert (config.depth_m, config.side_m, config.layer_thickness_m) == (20.0, 1000.0, 2.5)
    assert config.use_polar_cap is None
    assert config.footprint is FootprintCode.POINT
    assert (config.circle_diameter_m, config.rectangle_x_m, config.rectangle_y_m) == (2.0, 1.0, 10.0)
    assert config.log_bottom is True
    assert config.log_side is False
    assert config.n_wavebands == 2


def test_both_layouts_and_spellings_mean_the_same():
    plain = read_amc(DATA / "amc/good/thirty_lines.inp")
    assert replace(read_amc(DATA / "amc/good/older_layout.inp"), use_polar_cap=None) == plain
    assert read_amc(DATA / "amc/good/older_layout.inp").use_polar_cap is True
    assert read_amc(DATA / "amc/good/crlf_bom_and_notes.inp") == plain
    assert read_amc(DATA / "amc/good/exponents.inp") == plain


@pytest.mark.parametrize(
    ("name", "field", "value"),
    [
        ("flag_one_column_right", "light_source", 0), ("flag_two_digits", "log_bottom", True),
        ("real_without_point", "depth_m", 0.2), ("exponent_without_point", "circle_diameter_m", 2e-6),
        ("thirteen_characters", "iterations", 500), ("past_the_field", "iterations", 5),
        ("one_column_left", "depth_m", 0.0), ("blank_inside", "n_wavebands", 12),
        ("lone_point", "circle_diameter_m", 0.0),
    ],
)  # fmt: skip
def test_lenient_takes_what_fortran_reads_and_says_so(name, field, value):
    with pytest.warns(InputWarning, match=r"warning\[E10[3-9]\]"):
        config = read_amc(DATA / f"amc/bad/{name}.inp", lenient=True)
    assert getattr(config, field) == value


@pytest.mark.parametrize("name", ["text_in_field", "truncated", "zenith_90", "value_missing", "nul", "not_a_number"])
def test_lenient_does_not_save_what_the_program_refuses(name):
    with pytest.raises(InputFileError):
        read_amc(DATA / f"amc/bad/{name}.inp", lenient=True)


def test_lambbot_and_difcol_values():
    table = read_lambbot(DATA / "lambbot/good/target_and_words.inp", n_wavebands=2, has_target=True)
    assert table.wavelength_nm.tolist() == [400.0, 500.0]
    assert table.bottom_reflectance.tolist() == [0.1, 0.5]
    assert table.target_specular_fraction is not None
    assert table.target_specular_fraction.tolist() == [0.4, 0.5]
    assert read_lambbot(DATA / "lambbot/good/plain.inp").target_reflectance is None
    difcol = read_difcol(DATA / "difcol/good/plain.inp", n_wavebands=2)
    assert difcol.direct_fraction.tolist() == [0.8, 1.0]
    assert difcol.intensity.tolist() == [1.0, 0.5]
    with pytest.raises(ValueError, match="read-only"):
        difcol.intensity[0] = 2


@pytest.mark.parametrize("kind", ["lambbot", "difcol"])
def test_lenient_takes_the_rows_of_the_count(kind):
    """As the program, which reads no further."""
    read = {"lambbot": read_lambbot, "difcol": read_difcol}[kind]
    with pytest.warns(InputWarning, match=r"more_rows.inp:1:1: warning\[E203\]"):
        table = read(DATA / f"{kind}/bad/more_rows.inp", n_wavebands=2, lenient=True)
    assert (table.wavelength_nm if kind == "lambbot" else table.intensity).size == 2


def test_lenient_does_not_save_values_that_no_scene_can_have():
    for read, name in ((read_lambbot, "lambbot/bad/negative"), (read_difcol, "difcol/bad/fraction_high")):
        with pytest.raises(InputFileError, match="E202"):
            read(DATA / f"{name}.inp", lenient=True)


def test_exponents_of_any_number_of_digits_and_labels_that_are_mistyped(tmp_path):
    for digits, value in (("0" * 5000 + "2", 100.0), ("-" + "9" * 5000, 0.0)):
        (tmp_path / "lambbot.inp").write_text(f"1\n1e{digits} 0 0\n")
        assert read_lambbot(tmp_path / "lambbot.inp").wavelength_nm.tolist() == [value]
    text = (DATA / "amc/good/thirty_lines.inp").read_text()
    assert text.count("\n4)") == 1
    (tmp_path / "amc.inp").write_text(text.replace("\n4)", "\n5)"))
    assert read_amc(tmp_path / "amc.inp") == read_amc(DATA / "amc/good/thirty_lines.inp")


@pytest.mark.parametrize("field", ["", "    ", "  , 5"])
def test_a_blank_field_is_nought(field):
    """A comma ends a field, as in Fortran."""
    assert [fixed_value(field, decimals) for decimals in (None, 0, 2)] == [0, 0.0, 0.0]


@pytest.mark.parametrize("column", range(5))
def test_shares_of_lambbot_are_at_most_one_and_wavelengths_any(column, tmp_path):
    row = np.array([500.0, 1, 1, 1, 1])
    row[column] = np.nextafter(row[column], 1e3)
    path = tmp_path / "lambbot.inp"
    path.write_text(f"2\n400 1 1 1 1\n{' '.join(map(repr, row.tolist()))}\n")
    if column == 0:
        assert read_lambbot(path, has_target=True).wavelength_nm.tolist() == [400.0, row[0]]
        return
    with pytest.raises(InputFileError, match=r"lambbot.inp:3:.* 0 to 1\b"):
        read_lambbot(path, has_target=True)


@pytest.mark.parametrize("extra", ["", "   ", "a remark", "a remark   "])
@pytest.mark.parametrize(("label", "n_kept"), [(2, 30), (3, 30), (17, 30), (17, 29)])
def test_a_line_too_many_is_shown_by_itself(extra, label, n_kept, tmp_path):
    """Before a label that others follow, before one that unnumbered lines come before, and before the last one."""
    lines = (DATA / "amc/good/thirty_lines.inp").read_text().splitlines()[:n_kept]
    at = next(k for k, line in enumerate(lines) if line.startswith(f"{label})"))
    (tmp_path / "amc.inp").write_text("\n".join([*lines[:at], extra, *lines[at:]]))
    with pytest.raises(InputFileError) as caught:
        read_amc(tmp_path / "amc.inp")
    (problem,) = caught.value.problems
    assert problem.message.startswith(f"there is one line too many: label '{label})' is in line {at + 2}")
    assert (problem.line, problem.column, problem.width) == (at + 1, 1, max(1, len(extra.rstrip())))


@pytest.mark.parametrize("changed", [{"2)": "7)"}, {"3)": "7)", "4)": "99)"}])
def test_mistyped_labels_before_lines_without_a_known_one_move_no_line(changed, tmp_path):
    text = (DATA / "amc/good/thirty_lines.inp").read_text()
    for own, typed in changed.items():
        text = text.replace(f"\n{own}", f"\n{typed}")
    (tmp_path / "amc.inp").write_text(text)
    assert read_amc(tmp_path / "amc.inp") == read_amc(DATA / "amc/good/thirty_lines.inp")
