"""Files of other kinds are named for what they are, whatever options stand beside them."""

import gzip
import shlex

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.shared import INPUTS


def said(capsys, *words):
    code = main([str(word) for word in words])
    return code, capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "start", "what"),
    [
        ("sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "a picture (Radiance)"),
        ("sky.exr", b"\x76\x2f\x31\x01", "a picture (OpenEXR)"), ("sky.png", b"\x89PNG\r\n\x1a\n", "a picture (PNG)"),
        ("sky.jpg", b"\xff\xd8\xff\xe0", "a picture (JPEG)"), ("sky.tif", b"II*\0", "a picture (TIFF)"),
        ("sky.xlsx", b"PK\x03\x04", "a zip archive"), ("sky.grib", b"GRIB", "a file of GRIB"),
    ],
)  # fmt: skip
def test_binary_files_are_no_text_with_a_nul(name, start, what, tmp_path, capsys):
    (tmp_path / name).write_bytes(start + bytes(range(256)))
    for options in ((), ("--wavelengths", 550)):
        code, text = said(capsys, "run", tmp_path / name, *options)
        assert code == 3
        assert f"this seems to be {what}" in text
        assert "a table of radiances (.csv)" in text
        assert "lambbot" not in text


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


@pytest.mark.parametrize(
    ("data", "what", "advice"),
    [
        (gzip.compress(b"CDF\x01" + bytes(100), mtime=0), "a file packed by gzip", "unpack it"),
        (b"<html>404 Not Found</html>", "a page of the web, or XML", "write the field as netCDF-4"),
        (b"CDF\x05" + bytes(100), "netCDF with 64 bits (CDF-5)", "write the field as netCDF-4"),
        (b"GRIB" + bytes(100), "a file of GRIB", "write the field as netCDF-4"),
    ],
)
def test_what_is_no_netcdf_file(data, what, advice, tmp_path, capsys):
    pytest.importorskip("h5netcdf")
    (tmp_path / "field.nc").write_bytes(data)
    code, text = said(capsys, "run", tmp_path / "field.nc")
    assert code == 3
    assert f"seems to be {what}" in text
    assert advice in text


def test_fortran_is_named_for_its_own_files_alone(tmp_path, capsys):
    (tmp_path / "sky.csv").write_bytes("zenith,azimuth,L".encode("utf-16"))
    (tmp_path / "old.csv").write_bytes(b"zenith,azimuth,L\r1,2,3\r")
    (tmp_path / "amc.inp").write_bytes("1)Iterations".encode("utf-16"))
    for name, is_of_fortran in (("sky.csv", False), ("old.csv", False), ("amc.inp", True)):
        code, text = said(capsys, "run", tmp_path / name)
        assert code == 3
        assert ("Fortran" in text) is is_of_fortran


def test_a_table_whose_name_ends_as_a_file_of_a_run_is_a_table(tmp_path, capsys):
    path = tmp_path / "photon_counts.csv"
    path.write_text("zenith_deg,azimuth_deg,L_550\n10,0,1\n40,120,1\n40,240,1\n70,60,1\n")
    assert said(capsys, "run", path, "--dry-run")[0] == 0
