"""The dataset of a run: the counts of the source under the names that users of netCDF expect."""

import io

import numpy as np
import pytest

import aomc_sky
from aomc_sky import DirectBeam, Scene, TabulatedSky, UniformSky
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.tables import netcdf
from aomc_sky.outputs.tables.netcdf import plan_of_netcdf, to_xarray, write_netcdf
from tests.support.shared import INPUTS

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

WAVELENGTHS = np.array([450.0, 550.0])


def table():
    values = np.arange(12.0).reshape(2, 6)
    grid = PatchGrid.regular(2, 3, azimuth_first_index=1)
    return TabulatedSky(wavelength_nm=WAVELENGTHS, values=values, grid=grid, strength=1.0)


@pytest.fixture
def source():
    parts = (DirectBeam(sun_zenith_deg=30, sun_azimuth_deg=200, strength=1.0), table())
    known = {"n_photons": [1000, 2000], "sky_wavelength_nm": np.array([450.0, np.nan])}
    return Scene(wavebands=WAVELENGTHS, components=parts, **known).source(2**64 - 1)


def test_counts_and_masses_are_those_of_the_source(source):
    data = aomc_sky.to_xarray(source)
    counts = source.counts
    assert np.array_equal(data.counts_direct, counts[:, 0])
    assert np.array_equal(data.counts, counts[:, 1:].reshape(2, 2, 3))
    assert data.counts.dtype == np.int64
    for band in (0, 1):
        assert np.array_equal(data.mass[band].values.ravel(), source.mass(band)[1:])
        assert np.array_equal(data.expected[band].values.ravel(), source.expected(band)[1:])
        assert float(data.mass[band].sum() + data.mass_direct[band]) == pytest.approx(1, abs=1e-12)


def test_patches_have_their_places(source):
    data, grid = aomc_sky.to_xarray(source), source.grid
    assert data.counts.dims == ("waveband", "zenith", "azimuth")
    assert np.array_equal(data.zenith_bounds, grid.zenith_bounds_deg)
    assert np.array_equal(data.azimuth_bounds, grid.azimuth_bounds_deg)
    assert data.zenith.values.tolist() == [22.5, 67.5]
    assert data.azimuth_index.values.tolist() == [1, 2, 3]
    assert data.counts.sel(waveband=2, zenith=67.5, azimuth=180).item() == source.counts[1, 5]
    assert data.counts_direct.attrs["zenith_deg"] == pytest.approx(30, abs=1e-9)
    assert data.counts_direct.attrs["azimuth_deg"] == pytest.approx(200, abs=1e-9)


def test_names_units_and_bounds_follow_the_conventions(source):
    data = to_xarray(source)
    assert data.attrs["Conventions"] == "CF-1.11"
    assert data.attrs["seed"] == str(2**64 - 1)
    assert data.attrs["plan_sha256"] == source.plan.sha256
    for name, variable in data.variables.items():
        if name not in ("zenith_bounds", "azimuth_bounds"):
            assert variable.attrs["long_name"], name
    units = {name: data[name].attrs.get("units") for name in ("counts", "mass", "expected", "wavelength", "zenith")}
    assert units == {"counts": "1", "mass": "1", "expected": "1", "wavelength": "nm", "zenith": "degree"}
    for angle in ("zenith", "azimuth"):
        assert data[data[angle].attrs["bounds"]].dims == (angle, "bounds")


def test_a_second_grid_has_dimensions_of_its_own():
    scene = Scene(wavebands=WAVELENGTHS, n_photons=500, components=(table(), UniformSky(strength=1.0)))
    data = to_xarray(scene.source())
    assert data.counts.dims == ("waveband", "zenith", "azimuth")
    assert data.counts_uniform.dims == ("waveband", "zenith_uniform", "azimuth_uniform")
    assert int(data.counts.sum() + data.counts_uniform.sum()) == 1000


def test_the_file_holds_the_dataset(source, tmp_path):
    path = tmp_path / "sky.nc"
    write_netcdf(source, path)
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.load().reset_coords(), to_xarray(source).reset_coords())
    first = path.read_bytes()
    write_netcdf(source, path)
    assert path.read_bytes() == first
    assert [p.name for p in tmp_path.iterdir()] == ["sky.nc"]
    assert plan_of_netcdf(path) == source.plan.sha256


def test_other_files_have_no_plan(tmp_path):
    assert plan_of_netcdf(tmp_path / "none.nc") is None
    (tmp_path / "text.nc").write_text("not netCDF")
    assert plan_of_netcdf(tmp_path / "text.nc") is None


def test_absolute_irradiances_stand_beside_the_counts():
    known = Irradiance(of_component=np.array([[1.0, 0.25], [2.0, 0.0]]))
    parts = (UniformSky(strength=1.0), DirectBeam(sun_zenith_deg=30.0, strength=1.0))
    scenes = [Scene(wavebands=WAVELENGTHS, n_photons=10, components=parts, irradiance=one) for one in (None, known)]
    plain, absolute = (to_xarray(scene.source()) for scene in scenes)
    assert set(absolute.data_vars) - set(plain.data_vars) == {"irradiance", "irradiance_direct"}
    assert absolute.irradiance.to_numpy().tolist() == [1.0, 2.0]
    assert absolute.irradiance_direct.to_numpy().tolist() == [0.25, 0.0]
    assert absolute.irradiance.attrs["units"] == "W m-2 nm-1"


@pytest.mark.parametrize("name", ["clear_day", "perez_sky", "overcast"])
def test_the_file_is_the_dataset(name):
    """Written by h5netcdf alone, it has the types, gaps, coordinates and attributes of `to_xarray`."""
    source = aomc_sky.read_scene(INPUTS / name, iterations=1000).source(1)
    expected = to_xarray(source)
    found = xarray.load_dataset(io.BytesIO(netcdf.netcdf_bytes(netcdf._table(source))), engine="h5netcdf")
    xarray.testing.assert_identical(found, expected)
    assert {k: found[k].dtype for k in found.variables} == {k: expected[k].dtype for k in expected.variables}
