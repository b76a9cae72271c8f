"""Row 53: files of radiances and weather as other people write them are read right, or refused with what to write."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command, row
from tests.support.shared import DATA

FILES, DAMAGED = DATA / "foreign_files", DATA / "damaged"


@pytest.fixture
def foreign(tmp_path):
    """Runs a file of the reference into a folder of the test."""

    def run_file(name, *options, folder=FILES):
        if name.endswith(".nc"):
            pytest.importorskip("h5netcdf")
        out = tmp_path / f"out{len(list(tmp_path.iterdir()))}"
        code = command("run", folder / name, "--iterations", 50_000, "--out", out, *options)
        if code:
            return code, None, None
        band = json.loads((out / "manifest.json").read_text())["bands"][0]
        ux, uy, _ = np.load(out / "photons-0001.npy").mean(axis=0, dtype=float)
        return code, band, np.rad2deg(np.arctan2(-uy, -ux)) % 360

    return run_file


BANDS = {
    "bounds_hl.nc": ("irradiance_W_m2_nm", 3.23705),
    "valid_range.nc": ("irradiance_W_m2_nm", 0.003142),
    "unit_factor.csv": ("irradiance_W_m2_nm", 0.31416),
    "wl_um_unlabelled.nc": ("wavelength_nm", 440.0, "--wavelength-unit=um"),
    "own_irreg.nc": ("mean_cosine_exact", 0.736201),
    "rad_f4.nc": ("mean_cosine_exact", 2 / 3),
    "closed_f4vals.nc": ("mean_cosine_exact", 2 / 3),
    "image2d_nancorner.nc": ("mean_cosine_exact", 2 / 3, "--wavelength-unit=nm"),
}
"""What the manifest says of the first waveband: units, rings of our own, closed grids, corners without a direction."""
NORTH = "--azimuth-convention=clockwise from north"
EAST = {
    "conv_longname.nc": [(NORTH,)],
    "south_east.csv": [("--azimuth-convention=counterclockwise from south", "--variable=L")],
    "quoted_header_comma.csv": [
        ("--coordinate=zenith=zenith (deg)", "--coordinate=azimuth=azimuth (deg, clockwise from north)",
         "--variable=radiance (mW m-2 nm-1 sr-1)"),
        ("--angle-unit=deg",),
    ],
    "quoted_deccomma.csv": [
        ("--coordinate=zenith=zenith (deg)", "--coordinate=azimuth=azimuth (deg from north cw)",
         "--variable=radiance (mW m-2 nm-1 sr-1)"),
        ("--angle-unit=deg", "--decimal=comma"),
    ],
}  # fmt: skip
"""Skies that are brightest in the east, and the options that the questions name, round after round."""
SUN = ("--coordinate=azimuth=relative_azimuth", "--azimuth-convention=counterclockwise from the sun")
REFUSED = {
    "away.csv": ("E651", "north, east, south, west, the sun or"),
    "thou_mixed_semi_de.csv": ("E651", "'zenith=zenith (deg)'"),
    "rel_az.nc": ("E710", "azimuth=relative_azimuth"),
    "group.nc": ("E710", "open_dataset(path, group='NAME')"),
    "wl_um_unlabelled.nc": ("E710", "--wavelength-unit nm, um"),
    "missing_state.epw": ("E601", "nothing between two commas"),
    "subhourly_says1.epw": ("E602", "means of whole hours"),
    "mixed_zenrad.csv": ("E651", "azimuth_rad"),
}
"""Code, and what to write."""


def asked(foreign, capsys, name, rounds):
    """Runs a file with the options of each round; each is named by the questions of the round before."""
    given = []
    for options in rounds:
        assert foreign(name, *given)[0] == 3
        said = capsys.readouterr().err
        for option in options:
            flag, _, value = option.partition("=")
            assert flag in said
            assert all(word in said for word in value.partition("=")[0].split() if not word.isdigit())
        given += options
    return foreign(name, *given)


@row(53, *(f"band-{name}" for name in BANDS))
def test_bands(fault, foreign, capsys):
    name = fault.removeprefix("band-")
    key, value, *options = BANDS[name]
    _, band, _ = asked(foreign, capsys, name, [options] if options else [])
    assert band[key] == pytest.approx(value, rel=2e-4)


@row(53, *(f"east-{name}" for name in EAST))
def test_brightest_in_the_east(fault, foreign, capsys):
    name = fault.removeprefix("east-")
    _, _, azimuth = asked(foreign, capsys, name, EAST[name])
    assert min(azimuth, 360 - azimuth) < 1.0


@row(53, "sun-rel_az.nc")
def test_azimuths_from_the_sun(fault, foreign, capsys):
    """Brightest at 90 of the file, counterclockwise from the sun, which is at 30: in the north-west at 120."""
    rounds = [("--coordinate=azimuth=relative_azimuth",), ("--azimuth-convention=counterclockwise from the sun",)]
    assert asked(foreign, capsys, "rel_az.nc", [*rounds, ("--sun-azimuth=30",)])[2] == pytest.approx(120, abs=1)
    words = ("--sun-azimuth", "30", SUN[0], "--azimuth-convention=clockwise from the sun")
    assert foreign("rel_az.nc", *words)[2] == pytest.approx(300, abs=1)


@row(53, "thousands")
def test_thousands_are_a_question_and_no_light(fault, foreign, capsys):
    """829 beside 1.050: asked, and refused where commas are decimals; 1.05 only where it is said so."""
    rounds = [*EAST["quoted_deccomma.csv"][:1], ("--angle-unit=deg",)]
    assert asked(foreign, capsys, "thou_mixed_semi_de.csv", rounds)[0] == 3
    assert "'1.000' may be 1000" in capsys.readouterr().err
    assert foreign("thou_mixed_semi_de.csv", *rounds[0], *rounds[1], "--decimal=comma")[0] == 3
    assert "'1.000' has a point" in capsys.readouterr().err


@row(53, *(f"refused-{name}" for name in REFUSED))
def test_refusals(fault, foreign, capsys):
    name = fault.removeprefix("refused-")
    if name.endswith(".epw"):
        assert command("perez", "--epw", FILES / name, "--row", 48) == 3
    else:
        assert foreign(name)[0] == 3
    said = capsys.readouterr().err
    code, advice = REFUSED[name]
    assert f"error[{code}]" in said
    assert advice in said


@row(53, "further-field-in-records-of-lobes")
def test_a_further_text_in_the_records_of_lobes(fault, recwarn):
    """It is ignored without a word: all that is read is there."""
    pytest.importorskip("h5py")
    file = sky.read_background(FILES / "extra.h5")
    assert sky.background_at(file, 0.0).irradiance([550.0]) > 0.0
    assert not [str(one.message) for one in recwarn]


@row(53, "azimuths-that-are-one")
def test_two_azimuths_of_one_direction(fault, foreign, capsys):
    assert foreign("bad_field.nc", folder=DAMAGED)[0] == 3
    assert "error[E710]: azimuths 0 and 8.69169e-310 are one direction" in capsys.readouterr().err
