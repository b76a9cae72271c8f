"""Polarised skies on the command line: fields with Q and U, and the files that carry q and u."""

import json
import shutil

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command
from tests.support.fields import FROM_EAST
from tests.support.scenes import flip_bit
from tests.support.shared import INPUTS
from tests.support.stokes import DEFECTS

ZENITH, AZIMUTH, NM = np.arange(0.0, 91.0, 15.0), np.arange(0.0, 360.0, 30.0), [440.0, 550.0]
NAMES = ("radiance", "radiance_q", "radiance_u")


@pytest.fixture(scope="module")
def field():
    """I, Q and U of a pattern around a sun at 40 and 100 degrees, brighter at the longer wavelength."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    zenith, azimuth = np.meshgrid(np.deg2rad(ZENITH), np.deg2rad(AZIMUTH), indexing="ij")
    pattern = sky.RayleighPattern(max_degree=0.7)
    q, u = pattern.stokes(zenith, azimuth, sun_zenith_rad=np.deg2rad(40.0), sun_azimuth_rad=np.deg2rad(100.0))
    light = np.stack([1.0 + np.cos(zenith), 2.0 + np.cos(zenith) + 0.3 * np.sin(zenith) * np.cos(azimuth)])
    coordinates = {
        "wavelength": ("wavelength", NM, {"units": "nm"}),
        "zenith": ("zenith", ZENITH, {"units": "deg"}),
        "azimuth": ("azimuth", AZIMUTH, {"units": "deg", **FROM_EAST}),
    }
    parts = dict(zip(NAMES, (light, light * q, light * u), strict=True))
    return xarray.Dataset({n: (("wavelength", "zenith", "azimuth"), v) for n, v in parts.items()}, coordinates)


def stored(field, path):
    field.to_netcdf(path, engine="h5netcdf")
    return path


def plan_of(*words, folder):
    assert command(*words, "--iterations", 1000, "--format", "none", "--out", folder, "-q") == 0
    return sky.Plan.load(folder / "plan.npz")


def by_python(dataset, **how):
    model = sky.TabulatedSky.from_xarray(dataset, **how)
    return sky.Scene(wavebands=NM, n_photons=1000, components=model).source().plan


def stacked(field, order):
    """As sasktran2 has it: one variable with a dimension."""
    xarray = pytest.importorskip("xarray")
    parts = [field[NAMES["IQU".index(letter)]] for letter in order]
    return xarray.concat(parts, dim="stokes").assign_coords(stokes=list(order))


ODD = ("--variable", "L", "--variable-q", "a", "--variable-u", "b")
SWAPPED = ("--variable-q", "radiance_u", "--variable-u", "radiance_q")


def test_a_field_of_three_is_polarised_as_in_python(field, tmp_path, told):
    """By names, by options, and by the dimension of sasktran2, in both kinds of netCDF; Q and U exchanged are not."""
    plain = stored(field, tmp_path / "field.nc")
    odd = stored(field.rename(dict(zip(NAMES, "Lab", strict=True))), tmp_path / "odd.nc")
    rows = stored(stacked(field, "UIQ").rename("radiance"), tmp_path / "stacked.nc")
    old = tmp_path / "old.nc"
    stacked(field, "UIQ").to_dataset(name="radiance").to_netcdf(old, engine="scipy", format="NETCDF3_64BIT")
    said = told("run", plain, "--dry-run").out
    assert "note: sky field: photons carry q and u of Q and U of the field, of a degree up to" in said
    assert "modelled: linear polarisation of sky" in said
    ways = [(plain,), (odd, *ODD), (rows,), (old,), (plain, "--stokes-signs", 1, -1), (plain, *SWAPPED)]
    found = [plan_of("run", *words, folder=tmp_path / str(k)).sha256 for k, words in enumerate(ways)]
    turned = by_python(field, stokes_signs=(1, -1)).sha256
    assert found[:5] == [by_python(field).sha256] * 4 + [turned]
    assert len(set(found)) == 3
    assert command("verify", tmp_path / "0", "--scene", plain, "--iterations", 1000, "-q") == 0


def test_a_picture_finds_a_field_by_the_words_of_the_run(field, tmp_path, told):
    pytest.importorskip("matplotlib")
    odd = stored(field.rename(dict(zip(NAMES, "Lab", strict=True))), tmp_path / "odd.nc")
    assert "2 domes" in told("plot", odd, *ODD, "--stokes-signs", 1, -1, "--out", tmp_path / "odd.png").out


def scene_folder(folder, toml, made):
    shutil.copytree(INPUTS / "perez_sky", folder, dirs_exist_ok=True)
    (folder / "sky.toml").write_text(toml)
    stored(made, folder / "field.nc")
    return folder


@pytest.mark.filterwarnings("ignore:.*E310")
def test_a_table_of_sky_toml(field, tmp_path):
    """It has the rows of the field in Python, with the names and the signs that are given."""
    scene = sky.read_scene(scene_folder(tmp_path / "a", '[sky]\ntable = "field.nc"\n', field))
    model = sky.TabulatedSky.from_xarray(field)
    expected = model.lower(scene.wavebands.wavelength_nm)[0].stokes
    np.testing.assert_array_equal(scene.components[-1].stokes[scene.row_of_band], expected)
    assert not {"variable_q", "variable_u", "stokes_signs"} & set(scene.options["field"])
    names = '[sky]\ntable = "field.nc"\nvariable = "L"\nvariable_q = "a"\nvariable_u = "b"\nstokes_signs = [1, -1]\n'
    folder = scene_folder(tmp_path / "b", names, field.rename(dict(zip(NAMES, "Lab", strict=True))))
    with pytest.warns(sky.InputWarning, match="^U: another sign than that of Rayleigh's pattern around the sun"):
        scene = sky.read_scene(folder)
    np.testing.assert_array_equal(scene.components[-1].stokes[scene.row_of_band], expected * [1, -1])
    assert scene.options["field"]["stokes_signs"] == (1.0, -1.0)


LINES = {
    "half": ('variable = "radiance"\nvariable_q = "radiance_q"\n', "4:1: error[E705]"),
    "sign": ("stokes_signs = [1, 0]\n", "3:16: error[E704]"),
    "alone": ('variable = "radiance"\nstokes_signs = [1, 1]\n', "4:16: error[E710]"),
    "pattern": ("polarisation = 0.5\n", "3:16: error[E705]"),
}


@pytest.mark.parametrize("name", LINES)
def test_lines_of_sky_toml_that_are_wrong(name, field, tmp_path, told):
    more, place = LINES[name]
    scene_folder(tmp_path / "scene", f'[sky]\ntable = "field.nc"\n{more}', field)
    run = ("run", tmp_path / "scene", "--format", "none", "--out", tmp_path / "out")
    assert f"sky.toml:{place}" in told(*run, code=3).err
    assert f"sky.toml:{place}" in told("validate", tmp_path / "scene", code=3).err


def test_options_that_go_not_with_the_field(field, tmp_path, told):
    path = stored(field, tmp_path / "field.nc")
    assert "E710" in told("run", path, "--variable", "radiance", "--stokes-signs", 1, 1, "--dry-run", code=3).err
    told("run", path, "--variable-q", NAMES[1], "--dry-run", code=2)
    twice = ("--variable-q", NAMES[1], "--variable-u", NAMES[1])
    half = stored(field.drop_vars(NAMES[2]), tmp_path / "half.nc")
    for words in ((path, *twice), (half,)):
        assert "error[E710]" in told("run", *words, "--dry-run", code=3).err
    assert "is polarised already" in told("run", path, "--polarisation", 0.5, "--sun-zenith", 40, code=2).err


RUN = ["run", "--ghi", "780", "--dhi", "140", "--sun-zenith", "40", "--wavelengths", "440", "550", "--seed", "5"]
N = 70_000
PATTERN = ("--iterations", N, "--polarisation", 0.7)


@pytest.fixture(scope="module")
def run_of_all(tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "out"
    formats = [word for name in ("npy", "raw", "mcpl", "source") for word in ("--format", name)]
    assert command(*RUN, *PATTERN, *formats, "--out", out, "-q") == 0
    return out


def test_columns_are_those_of_the_batch(run_of_all, tmp_path, told):
    """npy, raw and csv; columns that are exchanged, turned by 90 degrees or of the other sign are others."""
    source = sky.PhotonSource(sky.Plan.load(run_of_all / "plan.npz"))
    assert command("export", run_of_all, "--to", "csv", "--out", tmp_path / "csv", "-q") == 0
    for band in range(2):
        batch = source.photons(band)
        stokes = np.load(run_of_all / f"stokes-{band + 1:04d}.npy", mmap_mode="r")
        raw = np.fromfile(run_of_all / f"photons-{band + 1:04d}.raw", "<f4").reshape(-1, 5)
        text = np.genfromtxt(tmp_path / "csv" / f"photons-{band + 1:04d}.csv", delimiter=",", names=True, dtype="f4")
        assert (stokes.dtype, stokes.shape) == (np.float32, (N, 2))
        assert text.dtype.names == ("ux", "uy", "uz", "q", "u")
        for q, u in (stokes.T, raw[:, 3:].T, (text["q"], text["u"])):
            np.testing.assert_array_equal(np.stack([q, u]), np.stack([batch.q, batch.u]))
            for defect in DEFECTS.values():
                assert not np.array_equal(np.stack(defect(q, u)), np.stack([batch.q, batch.u]))
        np.testing.assert_array_equal(raw[:, :3], batch.directions)
    manifest = json.loads((run_of_all / "manifest.json").read_text())
    assert "stokes" in manifest["conventions"]
    assert manifest["options"]["scene"]["sun"]["polarisation"] == 0.7
    assert manifest["files"]["stokes-0002.npy"] == {"bytes": 4096 + 8 * N}
    assert "stokes-0001.npy" in told("info", run_of_all).out


def test_verify_finds_a_bit_of_a_stokes_vector(run_of_all, tmp_path, told):
    out = shutil.copytree(run_of_all, tmp_path / "out")
    assert command("verify", out) == 0
    flip_bit(out / "stokes-0001.npy", 4096 + 8 * 11 + 3)
    said = " ".join(told("verify", out, code=1).out.split())
    assert "stokes-0001.npy: 1 of 70000 photons differ from the plan, the first is photon 11" in said
    (out / "stokes-0002.npy").unlink()
    assert "stokes-0002.npy: missing" in told("verify", out, code=1).out
    assert command(*RUN, *PATTERN, "--out", out, "-q") == 0  # the run command makes what is missing
    assert (out / "stokes-0002.npy").read_bytes() == (run_of_all / "stokes-0002.npy").read_bytes()


def test_formats_without_stokes_vectors_say_so(run_of_all, tmp_path, told):
    for name in ("envmap", "aomc"):
        said = told("export", run_of_all, "--to", name, "--out", tmp_path / name).out
        assert f"note: the light is polarised, and {name} has no Stokes vectors" in said


def test_an_exported_netcdf_has_q_and_u_of_the_run(run_of_all, tmp_path, told):
    """As the field that it is has them, too."""
    xarray = pytest.importorskip("xarray")
    path = tmp_path / "sky.nc"
    told("export", run_of_all, "--to", "netcdf", "--out", path, "-q")
    source, data = sky.PhotonSource(sky.Plan.load(run_of_all / "plan.npz")), xarray.load_dataset(path)
    found = np.stack([data["radiance_q"], data["radiance_u"]], axis=-1) / data["radiance"].values[..., None]
    np.testing.assert_allclose(found[1].reshape(-1, 2), source.stokes(1)[1:], atol=1e-12)
    again = plan_of("run", path, "--diffuse-only", folder=tmp_path / "again")
    np.testing.assert_allclose(again.components[-1].stokes[1], source.stokes(1)[1:], atol=1e-9)
