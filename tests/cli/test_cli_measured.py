"""A table of measured radiances on the command line: run, plot, validate and info."""

import json
import re
import shutil

import numpy as np
import pytest

from tests.support.fault_rows import command
from tests.support.fields import field_of
from tests.support.shared import INPUTS

SKY = INPUTS / "measured" / "sky.csv"
NM = ("--wavelengths", 451, 555)
TRUE = {412: 0.31, 490: 0.27, 555: 0.215, 670: 0.13}  # inputs/make_measured.py


def test_run_at_the_wavelengths_of_the_file(tmp_path, told):
    bands = json.loads(told("run", SKY, "--iterations", "1e4", "--out", tmp_path / "out", "--json").out)["bands"]
    assert [band["wavelength_nm"] for band in bands] == list(TRUE)
    for band in bands:
        assert band["irradiance_W_m2_nm"] == pytest.approx(TRUE[band["wavelength_nm"]], rel=3e-3)
        assert band["launched"] == 10**4
    assert command("verify", tmp_path / "out", "--scene", SKY, "--iterations", "1e4", "--quiet") == 0


def test_run_at_other_wavelengths_beside_the_file(tmp_path, told):
    path = shutil.copy(SKY, tmp_path / "sky.csv")
    out = told("run", path, *NM, "--iterations", 1000, "--format", "none").out
    assert (tmp_path / "aomc-sky-out" / "counts.csv").exists()
    shown = float(re.search(r"1  451 +(0\.\d+)", out)[1])
    assert shown == pytest.approx((TRUE[412] + TRUE[490]) / 2, rel=3e-3)
    verify = ("verify", tmp_path / "aomc-sky-out", "--quiet")
    scene = ("--scene", path, "--iterations", 1000)
    for words, code in (((*scene, *NM), 0), ((*scene, *NM[:2], 556), 5), (NM, 2)):
        told(*verify, *words, code=code)
    amc = ("--scene", INPUTS / "clear_day", "--wavelengths", 451)
    assert "choose among them with --waveband 1" in told(*verify, *amc, code=2).err


def test_plot_validate_and_info(tmp_path, told):
    pytest.importorskip("matplotlib")
    out = tmp_path / "sky.png"
    assert "1 dome" in told("plot", SKY, "--waveband", 1, "--size", 300, "--out", out).out
    assert out.read_bytes().startswith(b"\x89PNG")
    told("validate", SKY)
    summary = json.loads(told("info", SKY, "--json").out)
    assert summary["wavebands"] == list(TRUE)
    assert json.loads(told("info", SKY, *NM, "--json").out)["wavebands"] == [451.0, 555.0]
    assert summary["options"]["sun"]["azimuth_deg"] == pytest.approx(135.0)


@pytest.fixture
def field_file(tmp_path):
    """A netCDF file: radiance 1 + cos(azimuth - south) sin(zenith), azimuths clockwise from north."""
    zenith, azimuth = np.linspace(2.5, 87.5, 18), np.arange(0.0, 360.0, 10.0)
    radiance = 1 + np.cos(np.deg2rad(azimuth - 180)) * np.sin(np.deg2rad(zenith))[:, None]
    made = field_of(radiance[None], zenith, azimuth, [550.0], azimuth={"azimuth_convention": "north_clockwise"})
    made.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    return tmp_path / "field.nc"


def test_run_of_a_radiance_field(field_file, tmp_path, told):
    out = tmp_path / "out"
    band = json.loads(told("run", field_file, "--iterations", "1e5", "--out", out, "--json").out)["bands"][0]
    assert (band["wavelength_nm"], band["launched"]) == (550.0, 10**5)
    means = np.load(out / "photons-0001.npy").mean(axis=0, dtype=float)
    assert means[:2] == pytest.approx([0.0, 0.25], abs=2e-3)  # the brighter half is the south: photons travel north
    verify = ("verify", out, "--scene", field_file, "--iterations", "1e5", "--quiet")
    told(*verify)
    told(*verify, "--azimuth-convention", "enu_from_east", code=5)
    told("run", field_file, "--wavelengths", 440, 550, "--format", "none", "--out", out / "b")
    units = ("--radiance-unit", "mW m-2 nm-1 sr-1", "--out", out / "u", "--json")
    (band,) = json.loads(told("run", field_file, *units).out)["bands"]
    assert band["irradiance_W_m2_nm"] == pytest.approx(np.pi / 1e3, rel=1e-3)


def test_one_index_of_a_dimension_and_wavelengths_of_a_grey_field(field_file, tmp_path, told):
    xarray = pytest.importorskip("xarray")
    field = xarray.load_dataarray(field_file).isel(wavelength=0, drop=True)
    (field * xarray.DataArray([1.0, 0.0], dims="stokes")).to_netcdf(tmp_path / "two.nc", engine="h5netcdf")
    nm, first = ("--wavelengths", 550), ("--isel", "stokes=0")
    for more, code in (
        (nm, 3),
        (first, 2),  # no wavelengths
        (("--isel", "stokes=1", *nm), 3),  # no light
        (("--isel", "stokes", *nm), 2),
        ((*first, *nm), 0),
    ):
        told("run", tmp_path / "two.nc", "--format", "none", "--out", tmp_path / "out", "-q", *more, code=code)
    told("run", SKY, *first, code=2)


def test_the_only_table_of_a_folder(tmp_path, told):
    """A folder with one table is validated, and `run` names the table; of two none is chosen."""
    path = tmp_path / "sky.tsv"
    path.write_text(
        "# azimuth: clockwise from north\nzenith_deg\tazimuth_deg\tL_550\n10\t0\t1\n40\t120\t1\n40\t240\t1\n70\t60\t1\n"
    )
    assert told("validate", tmp_path).out == f"{path}: ok\n"
    said = told("run", tmp_path, "--out", tmp_path / "out", code=3).err
    assert f"there is no amc.inp in this folder; did you mean {path}?" in said
    (tmp_path / "grass.csv").write_text("wavelength,albedo\n500,0.1\n")
    assert "did you mean" not in told("run", tmp_path, "--out", tmp_path / "out", code=3).err
