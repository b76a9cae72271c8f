"""A table of measured radiances on the command line: run, plot, validate and info."""

import json
import re
import shutil

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.fault_rows import command
from tests.support.fields import field_of
from tests.support.shared import INPUTS

SKY = INPUTS / "measured" / "sky.csv"
TRUE = {412: 0.31, 490: 0.27, 555: 0.215, 670: 0.13}  # inputs/make_measured.py


def test_run_at_the_wavelengths_of_the_file(tmp_path, told):
    bands = json.loads(told("run", SKY, "--iterations", "1e4", "--out", tmp_path / "out", "--json").out)["bands"]
    assert [band["wavelength_nm"] for band in bands] == list(TRUE)
    for band in bands:
        assert band["irradiance_W_m2_nm"] == pytest.approx(TRUE[band["wavelength_nm"]], rel=3e-3)
        assert band["launched"] == 10**4
    assert main(["verify", str(tmp_path / "out"), "--scene", str(SKY), "--iterations", "1e4", "--quiet"]) == 0


def test_run_at_other_wavelengths_beside_the_file(tmp_path, told, capsys):
    path = shutil.copy(SKY, tmp_path / "sky.csv")
    assert main(["run", str(path), "--wavelengths", "451", "555", "--iterations", "1000", "--format", "none"]) == 0
    assert (tmp_path / "aomc-sky-out" / "counts.csv").exists()
    out = capsys.readouterr().out
    assert re.search(r"a radiance is off by \d[\d.]* % \(root mean square, weighted by the light\)", out)
    shown = float(re.search(r"1  451 +(0\.\d+)", out)[1])
    assert shown == pytest.approx((TRUE[412] + TRUE[490]) / 2, rel=3e-3)
    scene = ["--scene", str(path), "--iterations", "1000"]
    verify = ["verify", str(tmp_path / "aomc-sky-out"), "--quiet"]
    assert main([*verify, *scene, "--wavelengths", "451", "555"]) == 0
    assert main([*verify, *scene, "--wavelengths", "451", "556"]) == 5
    assert main([*verify, "--wavelengths", "451", "555"]) == 2
    amc = ["--scene", str(INPUTS / "clear_day"), "--wavelengths", "451"]
    assert "choose among them with --waveband 1" in told(*verify, *amc, code=2).err


def test_plot_validate_and_info(tmp_path, told, capsys):
    pytest.importorskip("matplotlib")
    out = tmp_path / "sky.png"
    assert main(["plot", str(SKY), "--waveband", "1", "--size", "300", "--out", str(out)]) == 0
    assert "1 dome of a measured sky, radiance [W m-2 sr-1 nm-1]" in capsys.readouterr().out
    assert out.read_bytes().startswith(b"\x89PNG")
    assert main(["validate", str(SKY)]) == 0
    summary = json.loads(told("info", SKY, "--json").out)
    assert summary["wavebands"] == list(TRUE)
    assert summary["options"]["sun"]["azimuth_deg"] == pytest.approx(135.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--limits", "paper"], "--limits: of the Perez sky, not of the measured sky"),
        (["--sky", "uniform"], "--sky: not used with"),
        (["--disc"], "--disc: used only where something says how bright the beam is"),
        (["--waveband", "5"], "waveband 5"),
        (["--radiance-unit", "lux"], "radiance unit 'lux' is not known"),
    ],
)
def test_what_does_not_go_together_is_refused(arguments, message, told):
    assert re.search(message, told("run", SKY, "--out", "nowhere", *arguments, code=2).err)


def test_a_scene_of_amc_has_no_use_for_its_options(capsys):
    assert main(["run", str(INPUTS / "clear_day"), "--angle-unit", "deg"]) == 2
    assert "--angle-unit is for a measured sky (.csv)" in capsys.readouterr().err


def test_little_of_the_sky_is_a_warning_and_strict_an_error(tmp_path, capsys):
    head = "# azimuth: from north\n# radiance unit: relative\nzenith_deg,azimuth_deg,L_550\n"
    rows = "".join(f"{zenith},{azimuth},1\n" for zenith in (0, 20, 40) for azimuth in range(0, 360, 30))
    (tmp_path / "cap.csv").write_text(head + rows)
    assert main(["validate", str(tmp_path / "cap.csv")]) == 0
    assert "measured sky: 60 % of the light comes from beyond the measured directions" in capsys.readouterr().err
    assert main(["validate", str(tmp_path / "cap.csv"), "--strict"]) == 3


def test_a_measured_sky_with_its_sun(tmp_path, told):
    """The sky in its own units is the diffuse light, and the beam has the share of the irradiances."""
    words = ["run", str(SKY), "--iterations", "1000", "--format", "none", "--json", "--out"]
    both = json.loads(told(*words, tmp_path / "a", "--dni", "800", "--dhi", "120").out)["bands"]
    alone = json.loads(told(*words, tmp_path / "b").out)["bands"]
    ratio = 800 * np.cos(np.radians(40)) / 120
    for one, other in zip(both, alone, strict=True):
        parts, sky = one["component_irradiance_W_m2_nm"], other["irradiance_W_m2_nm"]
        assert (parts["measured"], parts["direct"]) == pytest.approx((sky, ratio * sky), rel=1e-9)


@pytest.fixture
def field_file(tmp_path):
    """A netCDF file: radiance 1 + cos(azimuth - south) sin(zenith), azimuths clockwise from north."""
    zenith, azimuth = np.linspace(2.5, 87.5, 18), np.arange(0.0, 360.0, 10.0)
    radiance = 1 + np.cos(np.deg2rad(azimuth - 180)) * np.sin(np.deg2rad(zenith))[:, None]
    made = field_of(radiance[None], zenith, azimuth, [550.0], azimuth={"azimuth_convention": "north_clockwise"})
    made.to_netcdf(tmp_path / "field.nc", engine="h5netcdf")
    return tmp_path / "field.nc"


def test_run_of_a_radiance_field(field_file, tmp_path, told, capsys):
    out = tmp_path / "out"
    band = json.loads(told("run", field_file, "--iterations", "1e5", "--out", out, "--json").out)["bands"][0]
    assert (band["wavelength_nm"], band["launched"]) == (550.0, 10**5)
    assert band["mean_cosine_exact"] == pytest.approx(2 / 3, abs=1e-4)
    means = np.load(out / "photons-0001.npy").mean(axis=0, dtype=float)
    assert means[:2] == pytest.approx([0.0, 0.25], abs=2e-3)  # the brighter half is the south: photons travel north
    verify = ["verify", str(out), "--scene", str(field_file), "--iterations", "1e5", "--quiet"]
    assert main(verify) == 0
    assert main([*verify, "--azimuth-convention", "enu_from_east"]) == 5
    assert command("run", field_file, "--wavelengths", "440", "550", "--format", "none", "--out", out / "b") == 0
    capsys.readouterr()
    assert main(["run", str(field_file), "--radiance-unit", "mW m-2 nm-1 sr-1", "--out", str(out / "u"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bands"][0]["irradiance_W_m2_nm"] == pytest.approx(np.pi / 1e3, rel=1e-3)
    assert "not used with a field" in told("run", field_file, "--sun-zenith", "30", "--out", out / "c", code=2).err


def test_one_index_of_a_dimension_and_wavelengths_of_a_grey_field(field_file, tmp_path):
    xarray = pytest.importorskip("xarray")
    field = xarray.load_dataarray(field_file).isel(wavelength=0, drop=True)
    (field * xarray.DataArray([1.0, 0.0], dims="stokes")).to_netcdf(tmp_path / "two.nc", engine="h5netcdf")
    words = ["run", str(tmp_path / "two.nc"), "--format", "none", "--out", str(tmp_path / "out"), "-q"]
    assert main([*words, "--wavelengths", "550"]) == 3
    assert main([*words, "--isel", "stokes=0"]) == 2  # no wavelengths
    assert main([*words, "--isel", "stokes=1", "--wavelengths", "550"]) == 3  # no light
    assert main([*words, "--isel", "stokes=0", "--wavelengths", "550"]) == 0
    assert main(["run", str(SKY), "--isel", "stokes=1"]) == 2
    with pytest.raises(SystemExit, match="2"):
        main([*words, "--isel", "stokes"])


def test_a_text_file_and_a_folder_of_tables(tmp_path, told, capsys):
    """The content of a .txt says what it is; a folder with tables alone is validated, and `run` names its table."""
    lines = SKY.read_text().splitlines()[:60]
    (tmp_path / "sky.txt").write_text("\n".join([*lines[:5], *(line.rsplit(",", 3)[0] for line in lines[5:]), ""]))
    (tmp_path / "notes.txt").write_text("the zenith was clear\n")
    (tmp_path / "grass.csv").write_text("wavelength,albedo\n500,0.1\n")
    assert told("validate", tmp_path).out == f"{tmp_path / 'sky.txt'}: ok\n"
    assert main(["run", str(tmp_path / "sky.txt"), "--iterations", "10", "--format", "none", "--quiet"]) == 0
    assert main(["info", str(tmp_path / "sky.txt")]) == 0
    capsys.readouterr()
    assert main(["run", str(SKY.parent), "--out", str(tmp_path / "out")]) == 3
    assert f"there is no amc.inp in this folder; did you mean {SKY}?" in capsys.readouterr().err


@pytest.fixture
def points_file(tmp_path):
    """A netCDF file of scattered radiances: points with a wavelength each."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    rng = np.random.default_rng(1)
    zenith, azimuth = np.rad2deg(np.arccos(rng.uniform(0.1, 1, 120))), rng.uniform(0, 360, 120)
    coordinates = {
        "zenith": ("point", zenith, {"units": "degree"}),
        "azimuth": ("point", azimuth, {"units": "degree"}),
        "wavelength": ("point", np.tile([443.0, 555.0], 60), {"units": "nm"}),
    }
    made = xarray.DataArray(np.full(120, 100.0), dims="point", coords=coordinates, name="L")
    made.assign_attrs(units="mW m-2 nm-1 sr-1").to_netcdf(tmp_path / "points.nc", engine="h5netcdf")
    return tmp_path / "points.nc"


def test_points_in_netcdf_are_run_drawn_and_validated(points_file, tmp_path, told):
    pytest.importorskip("matplotlib")
    sun = ["--sun-zenith", "40", "--sun-azimuth", "60", "--azimuth-convention", "north_clockwise"]
    out = ["--iterations", "10", "--format", "none", "--out", str(tmp_path / "out")]
    bands = json.loads(told("run", points_file, *sun, *out, "--json").out)["bands"]
    assert [band["wavelength_nm"] for band in bands] == [443.0, 555.0]
    assert [band["irradiance_W_m2_nm"] for band in bands] == pytest.approx([0.1 * np.pi] * 2, rel=1e-6)
    assert main(["validate", str(points_file)]) == 0
    assert main(["info", str(points_file)]) == 0
    assert "2 domes" in told("plot", points_file, "--size", "300", "--out", tmp_path / "sky.png").out
