"""Rows 19 to 21 of the matrix: bins below the horizon, and wavelengths in disorder or far from the wavebands."""

from __future__ import annotations

import pytest

from tests.support.fault_rows import ROWS, Fault, check_refused, faults, photons_of_band, row, run_scene, sky

BELOW = sky("1 95 1 20.0", head="6 100 2 2")
FAR_AROUND = sky("1 2 400 20.0", head="6 2 400 2")


def beyond(name: str, text: str, options: tuple[str, ...], line: str, index: str, words: str, advice: str) -> Fault:
    """A row whose index, as whole degrees, lies outside the sky."""
    answer = f"skydist.inp:5:1: error[E307]: {index}: {words}\n    5 | {line}\n      | {'^' * len(line)} {advice}\n"
    return Fault(row=19, name=name, files={"skydist.inp": text}, options=options, answer=answer)


EQUAL_BINS = "without --bins degrees indices are numbers of equal bins"
BEYOND = [
    beyond(
        "zenith-95-degrees", BELOW, ("--bins", "degrees"), "1 95 1 20.0", "zenith index 95, azimuth index 1",
        "as whole degrees the zenith index must not go beyond 89", EQUAL_BINS,
    ),
    beyond(
        "zenith-95-degrees-of-the-program", BELOW, ("--compat", "aomc"), "1 95 1 20.0",
        "zenith index 95, azimuth index 1", "as whole degrees the zenith index must not go beyond 90",
        "the program's zenith indices are degrees; correct the index",
    ),
    beyond(
        "azimuth-400-degrees", FAR_AROUND, ("--bins", "degrees"), "1 2 400 20.0", "zenith index 2, azimuth index 400",
        "whole degrees of azimuth run from 0 to 360", EQUAL_BINS,
    ),
]  # fmt: skip


@faults(BEYOND)
def test_fault(fault, tmp_path, capsys):
    check_refused(fault, tmp_path, capsys)


@faults(
    [
        Fault(
            row=20,
            name="wavelength-twice",
            files={"skydist.inp": sky(waves="550.0 550.0")},
            answer="skydist.inp:2:7: error[E308]: wavelengths: 550.0 nm is listed twice, first as number 1\n"
            "    2 | 550.0 550.0\n      |       ^^^^^ list every wavelength once\n",
        )
    ]
)
def test_a_wavelength_twice(fault, tmp_path, capsys):
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


OUTSIDE = (
    "skydist.inp: warning[E310]: 3 of 3 wavebands lie outside the sky's wavelengths 1550 to 1650 nm; "
    "waveband 1 at 555 nm takes 1550 nm, 995 nm away\n"
)


@pytest.mark.parametrize("strict", [False, True], ids=["row-21-band-far-outside", "row-21-band-far-outside-strict"])
def test_a_band_far_outside(strict, tmp_path, capsys):
    options = ["--iterations", 4250, "-q", *(["--strict"] if strict else [])]
    answer = run_scene(tmp_path, {"skydist.inp": sky(waves="1550 1650")}, options, capsys)
    if strict:
        assert (answer.code, answer.err) == (
            3,
            f"{OUTSIDE}aomc-sky: error: --strict turns warnings into errors\n",
        )
        assert not answer.folder.exists()
    else:
        assert (answer.code, answer.err) == (0, OUTSIDE)
        assert photons_of_band(answer.folder, 3) == FIRST
