"""One field through a function, an array, netCDF and skydist.inp: the same masses, the same photons to the bit."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.outputs.tables.netcdf import write_netcdf
from tests.support.fault_rows import command
from tests.support.fields import field_of
from tests.support.scenes import change_config, copy_scene
from tests.support.shared import INPUTS

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

N_ZENITH, N_AZIMUTH, N_PHOTONS = 9, 24, 20_000
NM = np.array([440.0, 550.0])
GRID = sky.PatchGrid.regular(N_ZENITH, N_AZIMUTH)
VALUES = np.random.default_rng(18).lognormal(sigma=2.0, size=(2, N_ZENITH, N_AZIMUTH))


def constant_in_patches(sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
    """The radiance of the patch that a direction lies in."""
    zenith, azimuth, wavelength = np.broadcast_arrays(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
    ring = np.minimum((zenith / (np.pi / 2) * N_ZENITH).astype(int), N_ZENITH - 1)
    column = (np.mod(azimuth, 2 * np.pi) / (2 * np.pi) * N_AZIMUTH).astype(int) % N_AZIMUTH
    return VALUES[np.searchsorted(NM, wavelength), ring, column]


def middles(bounds):
    return bounds.mean(axis=1)


def as_field(values=VALUES, grid=GRID, *, are_means=True):
    zenith, azimuth = ({"bounds": f"{name}_bounds"} if are_means else {} for name in ("zenith", "azimuth"))
    middle = middles(grid.zenith_bounds_deg), middles(grid.azimuth_bounds_deg)
    return field_of(values, *middle, NM, zenith=zenith, azimuth=azimuth)


def write_field(path):
    bounds = {
        "zenith_bounds": (("zenith", "ends"), GRID.zenith_bounds_deg),
        "azimuth_bounds": (("azimuth", "ends"), GRID.azimuth_bounds_deg),
    }
    as_field().to_dataset().assign(bounds).to_netcdf(path, engine="h5netcdf")


def scene_of(model):
    return sky.Scene(wavebands=NM, n_photons=N_PHOTONS, components=model)


def scene_of_files(tmp_path):
    """amc.inp with the light of a file (flag 1), and two wavebands."""
    path = copy_scene("document_example", tmp_path)
    (path.parent / "lambbot.inp").write_text("2\n440 0.1 0\n550 0.1 0\n")
    change_config(path, n_wavebands=2)
    return path, lambda: sky.read_scene(path, iterations=N_PHOTONS)


def masses(scene):
    (component,) = scene.components
    shares = component.mass / component.mass.sum(axis=1, keepdims=True)
    return shares[scene.row_of_band]


def by_skydist(tmp_path):
    path, read = scene_of_files(tmp_path)
    sky.files.write_skydist(sky.files.SkyTable(wavelength_nm=NM, radiance=VALUES), path.parent / "skydist.inp")
    return read()


def by_toml(tmp_path):
    path, read = scene_of_files(tmp_path)
    write_field(path.parent / "field.nc")
    (path.parent / "sky.toml").write_text('[sky]\ntable = "field.nc"\n')
    return read()


def by_file(tmp_path):
    write_field(tmp_path / "field.nc")
    return scene_of(sky.TabulatedSky.from_xarray(xarray.load_dataset(tmp_path / "field.nc")))


def by_array(values=VALUES):
    return scene_of(sky.TabulatedSky(wavelength_nm=NM, values=values, grid=GRID, weighting="projected"))


WAYS = {
    "function": lambda tmp_path: scene_of(sky.FunctionSky(constant_in_patches, grid=GRID)),
    "from_xarray": lambda tmp_path: scene_of(sky.TabulatedSky.from_xarray(as_field())),
    "netCDF file": by_file,
    "sky.toml": by_toml,
    "skydist.inp": by_skydist,
}


@pytest.mark.parametrize("way", WAYS)
def test_one_field_is_one_sky(way, tmp_path):
    expected, found = by_array(), WAYS[way](tmp_path)
    np.testing.assert_allclose(masses(found), masses(expected), rtol=0, atol=1e-12)
    one, other = expected.source(seed=7), found.source(seed=7)
    np.testing.assert_array_equal(one.counts, other.counts)
    for band in range(2):
        a, b = one.photons(band), other.photons(band)
        for name in ("ux", "uy", "uz", "patch"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_a_defect_of_one_bin_is_seen():
    turned = by_array(np.roll(VALUES, 1, axis=2))
    assert np.abs(masses(turned) - masses(by_array())).max() > 1e-3
    assert not np.array_equal(turned.source(seed=7).counts, by_array().source(seed=7).counts)


def smooth(sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
    """Brighter towards azimuth 1, at the horizon and in the blue."""
    return 2 + np.sin(sky_zenith_rad) * np.cos(np.asarray(sky_azimuth_rad) - 1) + 440 / np.asarray(wavelength_nm)


@pytest.mark.parametrize(("are_means", "order"), [(True, 2), (False, 3)])
def test_a_smooth_field_differs_in_some_order_of_its_patches(are_means, order):
    """The function's own masses against values at the middles of patches: as means, and as samples."""
    differences = []
    for factor in (1, 2, 4):
        grid = sky.PatchGrid.regular(9 * factor, 24 * factor)
        model = sky.FunctionSky(smooth, grid=grid)
        zenith = np.deg2rad(middles(grid.zenith_bounds_deg))[:, None]
        azimuth = np.deg2rad(middles(grid.azimuth_bounds_deg))
        at_middles = smooth(zenith, azimuth, NM[:, None, None])
        table = sky.TabulatedSky.from_xarray(as_field(at_middles, grid, are_means=are_means))
        difference = 0.5 * np.abs(masses(scene_of(table)) - masses(scene_of(model))).sum(axis=1)
        differences.append(difference.max())
    np.testing.assert_allclose(np.divide(differences[:-1], differences[1:]), 2.0**order, rtol=0.2)


PEREZ = {"epsilon": 3.0, "delta": 0.2, "sun_zenith_deg": 40.0, "sun_azimuth_deg": 100.0}


def an_atmosphere(path):
    """Means of patches of a sky under one sun of two."""
    words = ["--sun-zenith", "40,60", "--sun-azimuth", 25, "--bins", 6, 12, "--orders", 1, "--wavelength", "500,680"]
    assert command("atmosphere", INPUTS / "atmosphere_sky" / "clear.atmo", "--out", path, *words, "-q") == 0
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        return data.radiance[1].values, data.zenith_bounds.values


def a_run(path, **how):
    scene = sky.Scene(wavebands=NM, n_photons=1000, components=sky.PerezSky(**PEREZ, **how))
    write_netcdf(scene.source(seed=3), path)
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        return data.radiance.values, data.zenith_bounds.values


OWN = {
    "a run": a_run,
    "in absolute units": lambda path: a_run(path, irradiance_W_m2_nm=[0.4, 0.2]),
    "polarised": lambda path: a_run(path, polarisation=sky.RayleighPattern(max_degree=0.6)),
    "an atmosphere": an_atmosphere,
}


@pytest.mark.parametrize("name", OWN)
def test_what_the_package_writes_reads_back_without_a_question(name, tmp_path, told):
    """By all doors, with the same radiances and bounds, and nothing of it is quoted."""
    values, rings = OWN[name](tmp_path / "own.nc")
    isel = {"sun_zenith": 1} if name == "an atmosphere" else {}
    data = xarray.load_dataset(tmp_path / "own.nc", engine="h5netcdf").isel(isel)
    table = sky.TabulatedSky.from_xarray(data)
    words = [word for dim, k in isel.items() for word in ("--isel", f"{dim}={k}")]
    said = told("run", tmp_path / "own.nc", *words, "--iterations", 10, "--diffuse-only", "--out", tmp_path / "out").out
    assert "the file says" not in said
    assert "not used" not in said
    assert "brightest sky" in said
    np.testing.assert_array_equal(table.values, values.reshape(len(values), -1))
    np.testing.assert_array_equal(table.grid.zenith_bounds_deg, rings)
    assert (table.values_q is not None) == (name == "polarised")
    assert table.radiance_unit == (1.0 if name in ("in absolute units", "an atmosphere") else 0.0)
    model = sky.Scene(wavebands=table.wavelength_nm, n_photons=10, components=table)
    assert sky.Plan.load(tmp_path / "out" / "plan.npz") == model.source().plan


def test_a_second_sky_of_a_run_is_not_left_out_without_a_word(tmp_path, told):
    """88 % of the light were."""
    grey = sky.TabulatedSky(wavelength_nm=NM, values=VALUES**0 / 2, grid=GRID, weighting="projected", radiance_unit=1.0)
    perez = sky.PerezSky(**PEREZ, irradiance_W_m2_nm=[0.2, 0.1])
    scene = sky.Scene(wavebands=NM, n_photons=1000, components=(perez, grey))
    write_netcdf(scene.source(seed=3), tmp_path / "own.nc")
    shown = told("run", tmp_path / "own.nc", "--dry-run")
    assert "(mass_sky" in shown.err or "radiance_sky" in shown.out
