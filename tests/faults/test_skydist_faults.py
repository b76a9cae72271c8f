"""Rows 1 to 21 of the matrix: indices, values, headers, rows, bins and wavelengths of skydist.inp that cannot be."""

import numpy as np
import pytest

from tests.support.fault_rows import ROWS, check_places, command, launched, photons_of_band, row, row_id, run_scene, sky

FIRST, SECOND = {(1, 0): 1050, (1, 1): 1200, (2, 1): 2000}, {(1, 0): 1056, (1, 1): 1224, (2, 1): 1970}
"""Photons of the two skies of the scene, of 4250."""
DARK = sky(rows=[*ROWS[:3], "2 1 0 0.0", "2 1 1 0.0", "2 2 1 0.0"])


BELOW = sky("1 95 1 20.0", head="6 100 2 2")
REFUSED = {
    # name: (row, skydist.inp, options, line, column and code)
    "zenith-index-0-onto-a-free-patch": (1, sky("1 0 2 20.0"), (), "5:3 E301"),
    "wavelength-index-0-onto-a-free-patch": (4, sky("0 2 2 20.0"), (), "5:1 E301"),
    "radiance-beyond-float64": (6, sky("1 2 1 1e999"), (), "5:7 E302"),
    "zenith-95-degrees": (19, BELOW, ("--bins", "degrees"), "5:1 E307"),
    "zenith-95-degrees-of-the-program": (19, BELOW, ("--compat", "aomc"), "5:1 E307"),
    "azimuth-400-degrees": (19, sky("1 2 400 20.0", head="6 2 400 2"), ("--bins", "degrees"), "5:1 E307"),
}
"""The faults of tests/data/skydist/bad are in tests/cli/test_cli_validate.py."""


@pytest.mark.parametrize("name", REFUSED, ids=[row_id(case[0], name) for name, case in REFUSED.items()])
def test_fault(name, tmp_path, capsys):
    _, text, options, place = REFUSED[name]
    answer = run_scene(tmp_path, {"skydist.inp": text}, options, capsys)
    check_places([f"skydist.inp:{place}"], answer.err)
    assert (answer.code, answer.out, answer.folder.exists()) == (3, "", False)


@row(8, "all-zero-band")
def test_a_dark_band(fault, tmp_path, capsys):
    answer = run_scene(tmp_path, {"skydist.inp": DARK}, ["--iterations", "1000"], capsys)
    assert (answer.code, answer.out, answer.folder.exists()) == (4, "", False)
    assert answer.err.startswith("aomc-sky: error: waveband 3 at 640 nm has no light")


@row(20, "unsorted-takes-the-nearest")
def test_wavelengths_in_disorder(fault, tmp_path, capsys):
    """555 and 580 nm are nearest to 550 nm, which is the second sky of the file here, 640 nm to the first."""
    text = sky(rows=[*("2" + line[1:] for line in ROWS[:3]), *("1" + line[1:] for line in ROWS[3:])], waves="650 550")
    answer = run_scene(tmp_path, {"skydist.inp": text}, ["--iterations", 4250], capsys)
    assert (answer.code, answer.err) == (0, "")
    assert "are not in ascending order" in answer.out
    assert photons_of_band(answer.folder, 1) == photons_of_band(answer.folder, 2) == FIRST
    found = photons_of_band(answer.folder, 3)
    assert {patch: abs(n - SECOND[patch]) <= 1 for patch, n in found.items()} == dict.fromkeys(SECOND, True)


@pytest.mark.parametrize("strict", [False, True], ids=[row_id(21, name) for name in ("band-far-outside", "strict")])
def test_a_band_far_outside(strict, tmp_path, capsys):
    options = ["--iterations", 4250, "-q", *(["--strict"] if strict else [])]
    answer = run_scene(tmp_path, {"skydist.inp": sky(waves="1550 1650")}, options, capsys)
    assert (answer.err.count("skydist.inp: warning[E310]: "), answer.out) == (1, "")
    assert "takes 1550 nm, 995 nm away\n" in answer.err
    assert answer.code == (3 if strict else 0)
    assert strict == (not answer.folder.exists())
    assert command("validate", answer.folder.parent, *options[3:]) == answer.code
    if not strict:
        assert photons_of_band(answer.folder, 3) == FIRST


@row(8, "compat-warns-and-launches-none")
def test_a_dark_band_of_the_program(fault, tmp_path, capsys):
    options = ["--compat", "aomc", "--iterations", 1000, "-q"]
    answer = run_scene(tmp_path, {"skydist.inp": DARK}, options, capsys)
    assert answer.code == 0
    assert answer.err.startswith("aomc-sky: warning: all weights are zero")
    assert launched(answer.folder) == {1: 1000, 2: 1000}
    assert np.load(answer.folder / "photons-0003.npy").shape == (0, 3)
