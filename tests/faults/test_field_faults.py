"""Row 40 for netCDF: fields of sky.toml that point elsewhere, lie about their size, are damaged, or hold no sky."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.support import hdf5_damage
from tests.support.fault_rows import command, row, row_id
from tests.support.fields import field_of
from tests.support.hdf5_damage import cut, empty, random_bytes, random_bytes_behind_the_signature
from tests.support.processes import limited
from tests.support.shared import REPOSITORY

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")
h5py = pytest.importorskip("h5py")

DATASET = {"name": "radiance", "shape": (3, 6)}
SPARSE = partial(hdf5_damage.sparse, **DATASET)
BOMB = partial(hdf5_damage.bomb, **DATASET, n_bytes=2**28)
ZENITH, AZIMUTH = np.arange(15.0, 90.0, 30.0), np.arange(0.0, 360.0, 60.0)


def plain(path, engine="h5netcdf", **options):
    field_of(np.ones((3, 6)), ZENITH, AZIMUTH).to_netcdf(path, engine=engine, **options)
    return path


def large_axis(file):
    del file["zenith"]
    file.create_dataset("zenith", shape=(10**12,), dtype="f8", chunks=(1000,))


MADE = {
    "netcdf-external-storage": partial(hdf5_damage.external_storage, **DATASET),
    "netcdf-external-link": partial(hdf5_damage.external_link, **DATASET),
    "netcdf-virtual-dataset": partial(hdf5_damage.virtual, **DATASET),
    "netcdf-sparse-1e15": SPARSE,
    "netcdf-gzip-bomb": BOMB,
    "netcdf-axis-1e12": large_axis,
}


def scene(folder, toml='[sky]\ntable = "x.nc"\n'):
    for path in (REPOSITORY / "inputs" / "document_example").iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "sky.toml").write_text(toml)
    return plain(folder / "x.nc")


@pytest.mark.parametrize("name", [*MADE, *(f"plot-{name}" for name in MADE)], ids=lambda name: row_id(40, name))
def test_fault(name, tmp_path, monkeypatch, told):
    """A picture opens no other file: that of an atmosphere is drawn by its name, and its storage is looked at."""
    monkeypatch.chdir(tmp_path)
    hdf5_damage.write_secrets(DATASET["shape"])
    with h5py.File(scene(tmp_path), "a") as file:
        if name.startswith("plot-"):
            for axis, at in (("zenith", np.arange(0.0, 91.0, 30.0)), ("azimuth", np.arange(0.0, 361.0, 60.0))):
                file[f"{axis}_bounds"] = np.stack([at[:-1], at[1:]], axis=1)
        MADE[name.removeprefix("plot-")](file)
    wrong = ("plot", "x.nc", "--out", "x.png") if name.startswith("plot-") else ("validate", "sky.toml")
    assert "x.nc: error[E553" in told(*wrong, code=3).err
    assert not Path("x.png").exists()


def cut_classic(path):
    plain(path, engine="scipy")
    path.write_bytes(path.read_bytes()[:150])


def classic_of_1e9_rows(path):
    plain(path, engine="scipy")
    data = bytearray(path.read_bytes())
    at = data.index(b"zenith") + 8
    data[at : at + 4] = (10**9).to_bytes(4, "big")
    path.write_bytes(bytes(data))


def a_folder(path):
    path.unlink()
    path.mkdir()


DAMAGES = {one.__name__: one for one in (cut, cut_classic, classic_of_1e9_rows, random_bytes, empty, a_folder)}
DAMAGES |= {"random_bytes_behind_the_signature": random_bytes_behind_the_signature, "missing": Path.unlink}
DAMAGES |= {"a_text": lambda path: path.write_text("zenith azimuth radiance\n" * 30)}


@row(40, *(f"netcdf-{name}" for name in DAMAGES))
def test_damaged(fault, tmp_path, monkeypatch, told):
    monkeypatch.chdir(tmp_path)
    DAMAGES[fault.removeprefix("netcdf-")](scene(tmp_path))
    said = told("run", "amc.inp", "--out", "out", code=3).err
    code = "E551" if fault in ("netcdf-a_folder", "netcdf-missing") else "E55"
    assert f"x.nc: error[{code}" in said, said
    assert not Path("out").exists()


@row(40, "netcdf-flipped-bytes")
def test_flipped_bytes(fault, tmp_path, monkeypatch, capsys):
    """A field with some bytes changed is a sky or an error of a file, never another end."""
    monkeypatch.chdir(tmp_path)
    data = scene(tmp_path).read_bytes()
    rng = np.random.default_rng(40)
    busy = np.flatnonzero(np.frombuffer(data, np.uint8))
    for _ in range(4):
        changed = bytearray(data)
        for at in rng.choice(busy, 6):
            changed[at] = rng.integers(256)
        Path("x.nc").write_bytes(bytes(changed))
        code = command("validate", "sky.toml")
        said = capsys.readouterr().err
        assert code in (0, 3), said


@row(40, "netcdf-memory-of-bombs")
def test_memory(fault, tmp_path):
    """Refused before anything of them is unpacked."""
    for name, change in (("0", BOMB), ("1", SPARSE)):
        (tmp_path / name).mkdir()
        with h5py.File(scene(tmp_path / name), "a") as file:
            change(file)
    done = limited(tmp_path, "validate", "0/sky.toml", "1/sky.toml")
    assert done.code == 3
    assert done.err.count("error[E55") == 2
    assert done.peak_mb < 250  # xarray alone takes 130


WRONG = {
    # name: (what is done to a good field, text behind the table, the span that is named)
    "no zenith": (lambda f: f.rename(zenith="up"), "", "2:9"),
    "name": (lambda f: f, 'zenith = "vza"\n', "3:10"),
    "variable": (lambda f: f, 'variable = "sky"\n', "3:12"),
    "dimension": (lambda f: f, "isel = { stokes = 0 }\n", "3:8"),
    "index": (lambda f: f.expand_dims(s=2), "isel = { s = 2 }\n", "3:8"),
    "no wavelengths": (lambda f: f.expand_dims(wavelength=[5.0]).isel(wavelength=slice(0)), "", "2:9"),
}


@row(40, *(f"netcdf-{name}" for name in WRONG))
def test_a_file_that_is_no_sky_is_an_error_of_the_key(fault, tmp_path, monkeypatch, told):
    change, more, span = WRONG[fault.removeprefix("netcdf-")]
    monkeypatch.chdir(tmp_path)
    path = scene(tmp_path, f'[sky]\ntable = "x.nc"\n{more}')
    made = change(xarray.load_dataarray(path))
    path.unlink()
    made.to_netcdf(path, engine="h5netcdf")
    said = told("run", "amc.inp", "--out", "out", code=3).err
    assert said.startswith(f"sky.toml:{span}: error[E710]: "), said
    assert "^" in said.splitlines()[2]
    for others in (("validate", "sky.toml"), ("info", "amc.inp")):
        said = told(*others, code=3)
        assert "error[E710]" in said.out + said.err


@row(40, "netcdf-outside-the-folder")
def test_a_path_outside_the_folder(fault, tmp_path, monkeypatch, told):
    inside = tmp_path / "scene"
    inside.mkdir()
    scene(inside, '[sky]\ntable = "../x.nc"\n').rename(tmp_path / "x.nc")
    monkeypatch.chdir(inside)
    assert "sky.toml:2:9: error[E707]" in told("run", "amc.inp", "--out", "out", code=3).err
    told("validate", "sky.toml", "--allow-path", "..")
