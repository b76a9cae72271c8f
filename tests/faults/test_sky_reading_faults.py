"""Rows 19 to 21 of the matrix: bins below the horizon, and wavelengths in disorder or far from the wavebands."""

import pytest

from tests.support.fault_rows import ROWS, Fault, check_refused, faults, photons_of_band, row, run_scene, sky

BELOW = sky("1 95 1 20.0", head="6 100 2 2")
FAR_AROUND = sky("1 2 400 20.0", head="6 2 400 2")


def in_sky(number, name, text, place, *options):
    places = [f"skydist.inp:{place}"]
    return Fault(row=number, name=name, files={"skydist.inp": text}, options=options, places=places)


FAULTS = [
    in_sky(19, "zenith-95-degrees", BELOW, "5:1 E307", "--bins", "degrees"),
    in_sky(19, "zenith-95-degrees-of-the-program", BELOW, "5:1 E307", "--compat", "aomc"),
    in_sky(19, "azimuth-400-degrees", FAR_AROUND, "5:1 E307", "--bins", "degrees"),
    in_sky(20, "wavelength-twice", sky(waves="550.0 550.0"), "2:7 E308"),
]


@faults(FAULTS)
def test_fault(fault, tmp_path, capsys):
    check_refused(fault, tmp_path, capsys)


FIRST, SECOND = {(1, 0): 1050, (1, 1): 1200, (2, 1): 2000}, {(1, 0): 1056, (1, 1): 1224, (2, 1): 1970}


@row(20, "unsorted-takes-the-nearest")
def test_wavelengths_in_disorder(fault, tmp_path, capsys):
    """555 and 580 nm are nearest to 550 nm, which is the second sky of the file here, 640 nm to the first."""
    text = sky(rows=[*("2" + line[1:] for line in ROWS[:3]), *("1" + line[1:] for line in ROWS[3:])], waves="650 550")
    answer = run_scene(tmp_path, {"skydist.inp": text}, ["--iterations", 4250], capsys)
    assert (answer.code, answer.err) == (0, "")
    assert "the wavelengths of skydist.inp are not in ascending order: bands take the nearest one" in answer.out
    assert photons_of_band(answer.folder, 1) == photons_of_band(answer.folder, 2) == FIRST
    found = photons_of_band(answer.folder, 3)
    assert {patch: abs(n - SECOND[patch]) <= 1 for patch, n in found.items()} == dict.fromkeys(SECOND, True)


OUTSIDE = "skydist.inp: warning[E310]: 3 of 3 wavebands lie outside"


@pytest.mark.parametrize("strict", [False, True], ids=["row-21-band-far-outside", "row-21-band-far-outside-strict"])
def test_a_band_far_outside(strict, tmp_path, capsys):
    options = ["--iterations", 4250, "-q", *(["--strict"] if strict else [])]
    answer = run_scene(tmp_path, {"skydist.inp": sky(waves="1550 1650")}, options, capsys)
    assert answer.err.startswith(OUTSIDE)
    assert (answer.err.count("warning[E310]"), answer.out) == (1, "")
    assert "waveband 1 at 555 nm takes 1550 nm, 995 nm away\n" in answer.err
    assert answer.code == (3 if strict else 0)
    assert ("--strict turns warnings into errors" in answer.err) == strict == (not answer.folder.exists())
    if not strict:
        assert photons_of_band(answer.folder, 3) == FIRST
