"""Descriptions of an atmosphere: good files say what they say, bad ones get the message beside them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.report import BadValueError
from aomc_sky.skies.atmosphere.description import keys as all_keys
from aomc_sky.skies.atmosphere.description.data import PhaseFunctionType
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.model import AtmosphereSky
from aomc_sky.source.scene import Scene
from tests.support.shared import DATA, REPOSITORY

PLAIN = DATA / "atmo" / "good" / "plain.atmo"


def changed(tmp_path, *changes):
    text = PLAIN.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path / "changed.atmo"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    return path


def codes_of(path, **options):
    with pytest.raises(InputFileError) as caught:
        read_atmo(path, **options)
    return [problem.code for problem in caught.value.problems]


def test_plain_file_word_for_word():
    d = read_atmo(PLAIN)
    assert d.path == str(PLAIN)
    assert (d.atmosphere_height_m, d.earth_radius_m) == (120_000.0, 6_371_000.0)
    assert (d.earth_sun_distance_m, d.earth_moon_distance_m) == (149_597_870_700.0, None)
    assert d.scattering_orders == 4
    assert d.wavelength_nm.tolist() == [400.0, 500.0, 600.0, 700.0]
    assert d.solar_irradiance.tolist() == [1.5, 1.9, 1.7, 1.4]
    assert d.ground_albedo.tolist() == [0.1, 0.1, 0.2, 0.3]
    assert (d.ground_glow, d.glow_luminance_cd_m2) == (None, None)
    assert dict(d.sizes) == {}
    assert (d.textures_are_radiances, d.has_eclipsed_double_scattering_textures) == (False, True)
    assert [part.name for part in d.species] == ["molecules", "ozone"]
    (molecules,), (ozone,) = d.scatterers, d.absorbers
    assert molecules.number_density.text == "        return 2.5e25*exp(-altitude/(8*km));"
    assert (molecules.line, molecules.number_density.line, molecules.phase_function.line) == (9, 13, 17)
    assert molecules.number_density.path == str(PLAIN)
    assert (molecules.cross_section_1um_m2, molecules.angstrom_exponent) == (4e-32, 4.0)
    assert molecules.single_scattering_albedo.tolist() == [1.0, 1.0, 1.0, 1.0]
    assert molecules.phase_function_type is PhaseFunctionType.GENERAL
    assert not molecules.needs_interpolation_guides
    assert ozone.cross_section_m2.tolist() == [1e-27, 1e-25, 5e-25, 1e-25]
    assert (ozone.line, ozone.number_density.text) == (22, "        return 1e18;")


def test_line_ends_a_mark_and_tabs_change_nothing():
    plain, other = read_atmo(PLAIN), read_atmo(PLAIN.with_name("crlf_bom_tabs.atmo"))
    for name in ("wavelength_nm", "solar_irradiance", "ground_albedo"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(other, name))
    assert [part.number_density.text for part in plain.species] == [part.number_density.text for part in other.species]


def test_a_section_without_spectra_may_stand_above_the_wavelengths(tmp_path):
    text = PLAIN.read_text()
    first, last = text.index("Scatterer"), text.index("Absorber")
    path = changed(tmp_path, (text[first:last], ""), ("wavelengths:", f"{text[first:last]}wavelengths:"))
    (air,) = read_atmo(path).scatterers
    assert air.single_scattering_albedo.tolist() == [1.0] * 4
    assert [part.name for part in read_atmo(path).species] == ["molecules", "ozone"]


def test_every_key_is_kept():
    d = read_atmo(PLAIN.with_name("every_key.atmo"))
    assert tuple(d.sizes) == all_keys.SIZES
    assert len(set(d.sizes.values())) >= 18
    assert d.sizes["eclipsed double scattering texture size for sza"] == 17
    assert d.sizes["light pollution angular integration points"] == 200
    assert d.earth_moon_distance_m == 384.4e6
    assert (d.textures_are_radiances, d.has_eclipsed_double_scattering_textures) == (True, False)
    (molecules,) = d.scatterers
    assert molecules.angstrom_exponent == -0.05
    assert molecules.phase_function_type is PhaseFunctionType.SMOOTH
    assert molecules.single_scattering_albedo.tolist() == [1.0, 0.9, 0.8, 0.0]
    assert molecules.needs_interpolation_guides
    assert d.ground_glow is not None
    assert d.glow_luminance_cd_m2 == pytest.approx(1.0, abs=1e-4)


def test_the_pages_name_every_key():
    pages = ("docs/formats/atmo.md", "docs/models/atmosphere_options.md")
    page = "".join((REPOSITORY / name).read_text().lower() for name in pages)
    keys = {*all_keys.TOP_KEYS, *all_keys.SCATTERER_KEYS, *all_keys.ABSORBER_KEYS, *all_keys.DIRECTIVES}
    assert {key for key in (*keys, all_keys.SCATTERER_DIRECTIVE) if f"`{key}`" not in page} == set()


def test_tables_are_summed_by_their_weights():
    d = read_atmo(PLAIN.with_name("files.atmo"))
    # grass: bins [400, 450], [450, 550], [550, 650], [650, 740], cut at its ends; snow falls by 1e-4 per nm, and
    # the last of its bins goes to 750 nm
    last = (40 * (0.15 - 120 * 0.09 / 140) + 50 * (0.06 + 25 * 0.44 / 50)) / 90
    grass = [0.05 + 25 / 1500, 0.05 + 100 / 1500, 0.15 - 50 * 0.09 / 140, last]
    snow = [0.95 - x * 1e-4 for x in (25, 100, 200, 300)]
    wanted = 0.8 * np.array(grass) + 0.2 * np.array(snow)
    np.testing.assert_allclose(d.ground_albedo, wanted, rtol=1e-14)
    assert not any(spectrum.flags.writeable for spectrum in (d.solar_irradiance, d.ground_albedo))


def test_the_glow_is_scaled_to_one_candela(tmp_path):
    def glow(text):
        lines = f"light pollution relative radiance: {text}\nground albedo"
        return read_atmo(changed(tmp_path, ("ground albedo", lines)))

    with pytest.warns(InputWarning, match="not 1; it is divided by that"):
        d = glow("1e-3, 2e-3, 2e-3, 1e-3")
    with pytest.warns(InputWarning, match="E409"):
        twice = glow("2e-3, 4e-3, 4e-3, 2e-3")
    np.testing.assert_allclose(twice.ground_glow, d.ground_glow, rtol=1e-15)
    assert twice.glow_luminance_cd_m2 == pytest.approx(2 * d.glow_luminance_cd_m2, rel=1e-15)
    shown = ", ".join(repr(float(value)) for value in d.ground_glow)
    assert glow(shown).glow_luminance_cd_m2 == pytest.approx(1.0, rel=1e-14)
    assert glow("0, 0, 0, 0").ground_glow is None


def test_warnings_name_what_is_odd(tmp_path):
    path = changed(
        tmp_path,
        ("scattering orders: 4", "scattering orders: 3\nscatering orders: 7\nscattering orders: 5"),
        ("ground albedo: 0.1, 0.1, 0.2, 0.3", ""),
        ("Earth radius: 6371 km", "Earth radius: 1 km"),
        ("    angstrom exponent", "    angstrom exponents: 4\n    angstrom exponent"),
        ("Earth-Sun distance: 1 AU\n", ""),
    )
    with pytest.warns(InputWarning) as caught:
        d = read_atmo(path)
    assert d.scattering_orders == 5
    assert d.ground_albedo.tolist() == [1.0] * 4
    assert d.earth_sun_distance_m == 149_597_870_700.0
    assert len(caught) == 5
    for piece in ("nearest is 'scattering orders'", "nearest is 'angstrom exponent'"):
        assert any(piece in str(warning.message) for warning in caught)


def test_a_link_to_the_description_shows_the_tables_beside_the_link(tmp_path):
    """A path counts from the name that the user gave, as everywhere on a Unix system."""
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "sun.csv").write_text("300,1\n800,1\n")
    changed(tmp_path / "real", ("1.5, 1.9, 1.7, 1.4", "file sun.csv"))
    (tmp_path / "link.atmo").symlink_to("real/changed.atmo")
    assert codes_of(tmp_path / "link.atmo") == ["E402"]


PARTS = ("..", ".", "", "home", "inside", "outside", "out", "in", "up", "t.csv", "s.csv", "link.csv")


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(parts=st.lists(st.sampled_from(PARTS), min_size=1, max_size=6), start=st.sampled_from(("", "/", "ROOT/")))
def test_no_path_reaches_a_table_outside(parts, start, tmp_path):
    home = tmp_path / "home"
    if not home.exists():
        (home / "inside").mkdir(parents=True)
        (tmp_path / "outside").mkdir()
        for folder in (home, home / "inside"):
            (folder / "t.csv").write_text("300,0.5\n900,0.5\n")
        for folder in (tmp_path, tmp_path / "outside"):
            (folder / "t.csv").write_text("300,0.75\n900,0.75\n")
            (folder / "s.csv").write_text("300,0.75\n900,0.75\n")
        (home / "out").symlink_to("../outside")
        (home / "in").symlink_to("inside")
        (home / "inside" / "up").symlink_to("../..")
        (home / "link.csv").symlink_to("inside/../../t.csv")
    given_path = start.replace("ROOT", str(tmp_path)) + "/".join(parts)
    path = changed(home, ("1.5, 1.9, 1.7, 1.4", f"file {given_path}"))
    try:
        found = read_atmo(path)
    except InputFileError:
        assert set(codes_of(path)) <= {"E401", "E402"}
    else:
        assert found.solar_irradiance.tolist() == [0.5] * 4


def test_problems_of_all_places_come_in_one_go(tmp_path):
    (tmp_path / "sun.csv").write_text("300,1\n200,1\nx,1\n")
    path = changed(tmp_path, ("1.5, 1.9, 1.7, 1.4", "file sun.csv"), ("120 km", "120"), ("1e-25, 5e-25", "1e-25"))
    with pytest.raises(InputFileError) as caught:
        read_atmo(path)
    places = [(Path(p.path).name, p.line) for p in caught.value.problems]
    assert places == [("changed.atmo", 2), ("changed.atmo", 28), ("sun.csv", 2), ("sun.csv", 3)]
    assert codes_of(tmp_path / "none.atmo") == ["E100"]
    assert codes_of(tmp_path) == ["E100"]
    assert codes_of(changed(tmp_path, ("1.5, 1.9, 1.7, 1.4", "file "))) == ["E401"]


def test_a_size_is_from_1_to_the_largest_integer():
    assert [all_keys.size_value(text) for text in ("1", "2147483647")] == [1, 2**31 - 1]
    for text in ("0", "2147483648"):
        with pytest.raises(BadValueError, match="outside 1 to 2147483647"):
            all_keys.size_value(text)


KEYS = {"sun": "1.5, 1.9, 1.7, 1.4", "ground": "0.1, 0.1, 0.2, 0.3", "ozone": "1e-27, 1e-25, 5e-25, 1e-25"}


@pytest.mark.parametrize(
    ("table", "found"),
    [
        ("0.3,1\n0.9,1\n", "(?s)E408.*micrometres"),
        ("3000,1\n9000,1\n", "(?s)E408.*angstroms"),
        ("300,1.5\n500,999\n900,1.4\n", "E404.*1 value is 999, and the next one is 1.5; is 999 a gap"),
        ("300,1.5\n501,-1\n900,1.5\n", "(?s)E404.*-1 is below 0.*leave out the rows of gaps"),
    ],
)
def test_numbers_of_another_unit_and_gaps_are_asked_about(tmp_path, table, found):
    (tmp_path / "t.csv").write_text(table)
    with pytest.raises(InputFileError, match=found):
        read_atmo(changed(tmp_path, (KEYS["sun"], "file t.csv")))


@pytest.mark.parametrize(
    "text",
    [
        "wavelength [nm], uW cm-2 nm-1", "values are in mW", "Werte mal 1000", "albédo en %", "альбедо, проценты",
        "cross section (cm2/molecule)", "数值乘以一千", "log10 of m2",
    ],
)  # fmt: skip
def test_comments_of_tables_change_no_light_and_are_quoted_once(tmp_path, text):
    found = []
    for head in ("", f"# {text}\n#\n"):
        (tmp_path / "t.csv").write_text(f"{head}250,0.25\n260,-1e-5\n300,0.1\n900,0.2\n")  # noise below 0
        found.append(read_atmo(changed(tmp_path, *((one, "file t.csv") for one in KEYS.values()))))
    silent, said = found
    assert said == silent
    assert silent.texts == ()
    assert said.texts == (f'the file says "t.csv: {text}" (texts change nothing)',)


def test_the_line_above_the_rows_of_a_long_head_is_quoted_and_reaches_a_scene(tmp_path):
    (tmp_path / "t.csv").write_text("# first line\n" + "# more\n" * 50 + "# last line, mW\n300,0.1\n900,0.2\n")
    path = changed(tmp_path, (KEYS["ground"], "file t.csv"))
    air = AtmosphereSky.from_file(path, wavelength_nm=[500.0], sun_zenith_deg=30.0, method="order1")
    (note,) = Scene(wavebands=[500.0], n_photons=10, components=air).notes
    assert note.startswith('atmosphere: the file says "t.csv: first line more')
    assert note.endswith('more more last line, mW" (texts change nothing)')


def test_code_is_not_evaluated_nor_stripped_of_anything(tmp_path):
    code = '  #include <x> # } : {\n\treturn system("rm"); while(true); \u00e9\n'
    d = read_atmo(changed(tmp_path, ("        return 1e18;\n", code)))
    assert d.absorbers[0].number_density.text == code.rstrip("\n")
