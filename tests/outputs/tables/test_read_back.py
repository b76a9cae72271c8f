"""What we write is read again: the dataset of a run, its netCDF and its skydist.inp, in Python and by `run`."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.outputs.tables.netcdf import write_netcdf
from tests.support.fault_rows import command

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

NM = [450.0, 550.0]
SUN = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 10.0}
GRID = sky.PatchGrid.regular(4, 8)
RISING = np.linspace(1.0, 3.0, 32) + np.array([[0.0], [1.0]])
TABLE = {"wavelength_nm": NM, "values": RISING, "grid": GRID, "weighting": "projected"}
PEREZ = {**SUN, "epsilon": 3.0, "delta": 0.1, "grid": GRID, "polarisation": sky.RayleighPattern(max_degree=0.7)}
STOKES = {"values_q": 0.3 * RISING, "values_u": -0.2 * RISING}
SKIES = {
    "plain": lambda how: sky.TabulatedSky(**TABLE, **how),
    "polarised": lambda how: sky.TabulatedSky(**TABLE, **STOKES, **how),
    "perez": lambda how: sky.PerezSky(**PEREZ, **how),
}
LIGHT = {"shares": {"strength": 1.0}, "irradiances": {"irradiance_W_m2_nm": [0.5, 0.8]}}
MORE = {
    "alone": lambda how: (),
    "beam": lambda how: (sky.DirectBeam(**SUN, **how),),
    "beam and a second sky": lambda how: (sky.DirectBeam(**SUN, **how), sky.OvercastSky(**how)),
}


WAYS = [
    ("plain", "shares", "beam and a second sky"),
    ("plain", "irradiances", "alone"),
    ("polarised", "shares", "alone"),
]
WAYS += [("polarised", "irradiances", "beam"), ("perez", "irradiances", "beam and a second sky")]
WAYS += [("perez", "shares", "beam")]
"""Every pair of two is among them."""


@pytest.fixture(params=WAYS, ids=" ".join, scope="module")
def source(request):
    """A run of a sky on 4 x 8 patches beside other light."""
    name, light, more = request.param
    parts = (SKIES[name](LIGHT[light]), *MORE[more](LIGHT[light]))
    return sky.Scene(wavebands=NM, n_photons=2000, components=parts).source(3)


def shares(component):
    return component.mass / component.mass.sum(axis=1, keepdims=True)


def require_same(model, source):
    """The masses of the first component, and its q and u."""
    (read,), first = model.lower(NM), source.components[0]
    assert read.grid == GRID
    np.testing.assert_allclose(shares(read), shares(first), rtol=1e-12)
    assert (read.stokes is None) == (first.stokes is None)
    if read.stokes is not None:
        np.testing.assert_allclose(read.stokes, np.broadcast_to(first.stokes, read.stokes.shape), atol=1e-12)
    irradiance = source.irradiance(0)
    assert (read.irradiance_W_m2_nm is None) == (irradiance is None)
    if irradiance is not None:
        assert read.irradiance_W_m2_nm[0] == pytest.approx(irradiance[source.components[0].name], rel=1e-12)


DATASETS = {
    "whole": lambda data: data,
    "by wavelength": lambda data: data.swap_dims(waveband="wavelength"),
    "plain variables": lambda data: data.reset_coords(),
    "turned": lambda data: data.transpose(..., "waveband"),
}


@pytest.mark.parametrize("form", DATASETS)
def test_the_dataset_of_a_run_is_read_again(source, form):
    require_same(sky.TabulatedSky.from_xarray(DATASETS[form](sky.to_xarray(source))), source)


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")  # of light beyond the middles of the last patches
def test_its_directions_may_be_stacked(source):
    """`stack` gives an index of several levels; without bounds its directions are scattered ones."""
    flat = sky.to_xarray(source).drop_vars(["zenith_bounds", "azimuth_bounds"]).stack(point=("zenith", "azimuth"))
    read = [sky.TabulatedSky.from_xarray(one, grid=GRID) for one in (flat, flat.reset_index("point"))]
    assert read[0] == read[1]
    assert (read[0].values_q is None) == (source.components[0].stokes is None)


def test_the_file_is_read_again_by_python_and_by_run(source, tmp_path):
    path = tmp_path / "counts.nc"
    write_netcdf(source, path)
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        require_same(sky.TabulatedSky.from_xarray(data), source)
    words = ("run", path, "--wavelengths", "450", "550", "--iterations", 1000, "--out", tmp_path / "again", "-q")
    assert command(*words, "--format", "none") == 0
    again = sky.Plan.load(tmp_path / "again" / "plan.npz")
    assert (again.components[0].stokes is None) == (source.components[0].stokes is None)
