"""Files of other kinds are named for what they are, whatever options stand beside them."""

import shlex

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

TABLE = "# azimuth: clockwise from north\nzenith_deg,azimuth_deg,L_550\n10,0,1\n40,120,1\n40,240,1\n70,60,1\n"


def said(capsys, *words):
    code = main([str(word) for word in words])
    return code, capsys.readouterr().err


@pytest.mark.parametrize("name", ["sky.png", "scan.alm"])
def test_a_name_that_says_nothing_is_told_what_a_scene_is(name, tmp_path, capsys):
    """A picture and a table of radiances alike: a file is known by its name, not by what it may hold."""
    (tmp_path / name).write_bytes(b"\x89PNG\0" if name == "sky.png" else b"zenith_deg,azimuth_deg,radiance\n10,0,1\n")
    for options in ((), ("--wavelengths", 550)):
        code, text = said(capsys, "run", tmp_path / name, *options)
        assert code == 3
        assert f"{name}: error[E100]: this is not an amc.inp" in text
        assert "a scene is amc.inp or its folder; a table of radiances has a name in .csv, .tsv, .txt or .dat" in text
        assert "lambbot" not in text


@pytest.mark.parametrize("name", ["sky.txt", "sky.dat", "photon_counts.csv"])
def test_a_text_without_a_line_of_amc_inp_is_a_table(name, tmp_path, capsys):
    (tmp_path / name).write_text(TABLE)
    assert said(capsys, "run", tmp_path / name, "--dry-run")[0] == 0
    (tmp_path / name).write_text("zenith,azimuth\n")
    assert "there is no column of radiances among" in said(capsys, "run", tmp_path / name)[1]


def test_amc_inp_may_have_another_name(tmp_path, capsys):
    case = copy_scene("clear_day", tmp_path).rename(tmp_path / "clear_day" / "case.txt")
    assert said(capsys, "run", case, "--dry-run") == (0, "")


def test_a_weather_file_is_told_its_command(tmp_path, capsys):
    pytest.importorskip("pvlib")
    code, text = said(capsys, "run", INPUTS / "weather" / "two_days.epw")
    assert code == 3
    command = text.split("`aomc-sky ")[1].split("`")[0]
    words = shlex.split(command.replace(" N ", " 12 ").replace(" OUT", f" {tmp_path / 'o'}"))
    assert said(capsys, *words, "--iterations", 100, "--spectrum", "spectrl2", "-q") == (0, "")


def test_radiances_in_hdf5_and_numpy_are_told_where_they_go(tmp_path, capsys):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "sky.h5", "w") as file:
        file["radiance"] = np.ones((3, 4))
    np.save(tmp_path / "sky.npy", np.ones((3, 4)))
    (tmp_path / "sky.mcpl").write_bytes(b"MCPL003L")
    (tmp_path / "day.sky").write_bytes(b"AOMC-SKY")
    assert "E971" in said(capsys, "validate", tmp_path / "day.sky")[1]
    for name, advice in (
        ("sky.h5", "a field of radiances has a name in .nc"),
        ("sky.npy", "sky.TabulatedSky"),
        ("sky.mcpl", "`aomc-sky verify --scene AMC_INP"),
        ("day.sky", "day.sky` shows it"),
    ):
        code, text = said(capsys, "run", tmp_path / name, "--wavelengths", 550)
        assert code == 3
        assert advice in text


def test_fortran_is_named_for_its_own_files_alone(tmp_path, capsys):
    (tmp_path / "sky.csv").write_bytes("zenith,azimuth,L".encode("utf-16"))
    (tmp_path / "old.csv").write_bytes(b"zenith,azimuth,L\r1,2,3\r")
    (tmp_path / "amc.inp").write_bytes("1)Iterations".encode("utf-16"))
    for name, is_of_fortran in (("sky.csv", False), ("old.csv", False), ("amc.inp", True)):
        code, text = said(capsys, "run", tmp_path / name)
        assert code == 3
        assert ("Fortran" in text) is is_of_fortran
