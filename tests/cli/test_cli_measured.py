"""A table of measured radiances on the command line: run, plot, validate and info."""

import json
import re
import shutil

import numpy as np
import pytest

from tests.support.fault_rows import command
from tests.support.fields import FROM_EAST, field_of
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
    assert re.search(r"a radiance is off by \d[\d.]* % \(root mean square, weighted by the light\)", out)
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
    said = told("plot", SKY, "--waveband", 1, "--size", 300, "--out", out).out
    assert "1 dome of a measured sky, radiance [W m-2 sr-1 nm-1]" in said
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
    assert band["mean_cosine_exact"] == pytest.approx(2 / 3, abs=1e-4)
    means = np.load(out / "photons-0001.npy").mean(axis=0, dtype=float)
    assert means[:2] == pytest.approx([0.0, 0.25], abs=2e-3)  # the brighter half is the south: photons travel north
    verify = ("verify", out, "--scene", field_file, "--iterations", "1e5", "--quiet")
    told(*verify)
    told(*verify, "--azimuth-convention", "enu_from_east", code=5)
    told("run", field_file, "--wavelengths", 440, 550, "--format", "none", "--out", out / "b")
    units = ("--radiance-unit", "mW m-2 nm-1 sr-1", "--out", out / "u", "--json")
    (band,) = json.loads(told("run", field_file, *units).out)["bands"]
    assert band["irradiance_W_m2_nm"] == pytest.approx(np.pi / 1e3, rel=1e-3)
    sun = ("--sun-zenith", 60, "--sun-azimuth", -90)
    told("run", field_file, *sun, "--dry-run")
    said = told("run", field_file, *sun, "--azimuth-convention", "clockwise from south", "--dry-run").err
    assert "aomc-sky: warning: the brightest sky is in the north" in said
    assert "clockwise from north" in said


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


@pytest.fixture
def points_file(tmp_path):
    """A netCDF file of scattered radiances: points with a wavelength each."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    rng = np.random.default_rng(1)
    zenith, azimuth = np.rad2deg(np.arccos(rng.uniform(0.1, 1, 120))), rng.uniform(0, 360, 120)
    coordinates = {
        "zenith": ("point", zenith, {"units": "degree"}),
        "azimuth": ("point", azimuth, {"units": "degree", **FROM_EAST}),
        "wavelength": ("point", np.tile([443.0, 555.0], 60), {"units": "nm"}),
    }
    made = xarray.DataArray(np.full(120, 100.0), dims="point", coords=coordinates, name="L")
    made.assign_attrs(units="mW m-2 nm-1 sr-1").to_netcdf(tmp_path / "points.nc", engine="h5netcdf")
    return tmp_path / "points.nc"


def test_points_in_netcdf_are_run_drawn_and_validated(points_file, tmp_path, told):
    pytest.importorskip("matplotlib")
    sun = ["--sun-zenith", "40", "--sun-azimuth", "60", "--azimuth-convention", "clockwise from north"]
    out = ["--iterations", "10", "--format", "none", "--out", str(tmp_path / "out")]
    bands = json.loads(told("run", points_file, *sun, *out, "--json").out)["bands"]
    assert [band["wavelength_nm"] for band in bands] == [443.0, 555.0]
    assert [band["irradiance_W_m2_nm"] for band in bands] == pytest.approx([0.1 * np.pi] * 2, rel=1e-6)
    told("validate", points_file)
    told("info", points_file)
    assert "2 domes" in told("plot", points_file, "--size", "300", "--out", tmp_path / "sky.png").out
