"""Rows 36 and 40 of the matrix: lobes beyond the ends of their parameters, and background-sky files made to hurt."""

import zlib
from functools import partial

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import hdf5_damage
from tests.support.background import plain_file
from tests.support.fault_rows import row, row_id
from tests.support.hdf5_damage import cut, empty, random_bytes, random_bytes_behind_the_signature
from tests.support.processes import limited

UP = (1.0, 0.0, 0.0, 0.0)

h5py = pytest.importorskip("h5py")


@row(36, "rotation-of-zeros")
def test_parameters_outside(fault, tmp_path, monkeypatch, told):
    """Other members and values: tests/skies/lobes/file/test_file.py."""
    plain_file(tmp_path / "x.h5", lobes=[(1, 0.5, 0.0, 0.25, (0, 0, 0, 0), 0, 0.0)])
    monkeypatch.chdir(tmp_path)
    said = told("validate", "x.h5", code=3).err
    assert said.startswith("x.h5: error[E506]: /LobeAnims/a/Lobes: LocalTransform [0] is ")
    assert "\n      = " in said


@row(36, "time-nan", "time-without-zone")
def test_a_time_that_is_none(fault, tmp_path, told):
    answers = {
        "time-nan": ("nan", "is not a date with a time of day"),
        "time-without-zone": ("2026-02-14T21:30:00", "zone"),
    }
    time, words = answers[fault]
    assert words in told("info", plain_file(tmp_path / "x.h5"), "--time", time, code=2).err


DATASET = {"name": "SpectralCurves", "shape": (2, 3)}
external_storage = partial(hdf5_damage.external_storage, **DATASET)
virtual = partial(hdf5_damage.virtual, **DATASET)
sparse = partial(hdf5_damage.sparse, **DATASET)
bomb = partial(hdf5_damage.bomb, **DATASET, n_bytes=2**26)


def texts(file):
    del file["SpectralCurves"]
    file["SpectralCurves"] = np.array([[b"a", b"b", b"c"]] * 2)


def declared_bomb(file):
    """What gzip makes of 400 MB of zeros, declared as what it is; the chunks are one and the same."""
    del file["SpectralCurves"]
    data = file.create_dataset("SpectralCurves", (10**5, 1000), "f4", chunks=(1000, 1000), compression="gzip")
    chunk = zlib.compress(bytes(4 * 10**6))
    for k in range(100):
        data.id.write_direct_chunk((1000 * k, 0), chunk)


def other_filter(file):
    del file["SpectralCurves"]
    file.create_dataset("SpectralCurves", data=np.ones((2, 3), "f4"), compression="lzf")


def references(file):
    del file["SpectralSamples"]
    file.create_dataset("SpectralSamples", data=np.array([None] * 3, h5py.ref_dtype), dtype=h5py.ref_dtype)


def ragged(file):
    del file["SpectralSamples"]
    lists = np.empty(3, object)
    lists[:] = [np.arange(3.0)] * 3
    file.create_dataset("SpectralSamples", data=lists, dtype=h5py.vlen_dtype("f4"))


CURVES, SAMPLES = "/SpectralCurves", "/SpectralSamples"
MADE = {
    # name: (what is done to a good file, code, member that is named)
    "external-storage": (external_storage, "E502", CURVES),
    "virtual-dataset": (virtual, "E502", CURVES),
    "sparse-1e15": (sparse, "E503", CURVES),
    "gzip-bomb": (bomb, "E503", CURVES),
    "declared-gzip-bomb": (declared_bomb, "E503", CURVES),
    "another-filter": (other_filter, "E503", CURVES),
    "wrong-dtype": (texts, "E505", CURVES),
    "references": (references, "E505", SAMPLES),
    "object-dtype": (ragged, "E505", SAMPLES),
}


@pytest.mark.parametrize("name", MADE, ids=[row_id(40, name) for name in MADE])
def test_fault(name, tmp_path, monkeypatch, told):
    change, code, member = MADE[name]
    monkeypatch.chdir(tmp_path)
    hdf5_damage.write_secrets(DATASET["shape"])
    plain_file(tmp_path / "x.h5", change=change, libver="latest")
    said = told("validate", "x.h5", code=3).err
    assert f"x.h5: error[{code}]: {member}: " in said
    assert "\n      = " in said  # what to write
    assert "Traceback" not in said


DAMAGES = (cut, random_bytes, random_bytes_behind_the_signature, empty)


@pytest.mark.parametrize("damage", DAMAGES, ids=[row_id(40, one.__name__.replace("_", "-")) for one in DAMAGES])
def test_damaged(damage, tmp_path, monkeypatch, told):
    monkeypatch.chdir(tmp_path)
    damage(plain_file(tmp_path / "x.h5"))
    said = told("validate", "x.h5", code=3).err
    assert said.startswith("x.h5: error[E501]: ")
    assert "\n      = " in said


@row(40, "memory-of-bombs")
def test_memory(fault, tmp_path):
    """Refused before anything of them is unpacked."""
    plain_file(tmp_path / "0.h5", change=bomb)
    plain_file(tmp_path / "1.h5", change=declared_bomb)
    plain_file(tmp_path / "2.h5", change=sparse)
    done = limited(tmp_path, "validate", "0.h5", "1.h5", "2.h5")
    assert done.code == 3
    assert done.err.count("error[E503]") == 3
    assert done.peak_mb < 200


@row(36, "g-exactly-0")
def test_an_even_lobe(fault):
    m = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.3, -0.4, -0.5]])
    assert sky.lobes.pdf("hg", 0.0, 0.0, m).tolist() == pytest.approx([1 / (4 * np.pi)] * 3, rel=4e-16)
    assert sky.lobes.mass_above_horizon("hg", 0.0, 0.0, UP) == 0.5
    assert sky.henyey_greenstein.sample_mu(0.25, 0.0) == -0.5


@row(36, "rotation-not-of-length-1")
def test_a_quaternion_of_any_length(fault):
    """Only its direction counts, so no quaternion is a matrix that is not orthogonal."""
    long = sky.lobes.rotation_matrix((3e200, 4e200, 0.0, 0.0))
    assert np.allclose(long, sky.lobes.rotation_matrix((3.0, 4.0, 0.0, 0.0)), rtol=0, atol=1e-15)
    assert np.allclose(long @ long.T, np.eye(3), rtol=0, atol=1e-15)


@row(36, "time-outside-the-keys")
def test_a_time_outside_the_keys(fault, tmp_path):
    """Before the first key the first one holds, behind the last one the last: no light is made up."""
    pytest.importorskip("h5py")
    lobes = [(1, 0.5, 0.0, 0.25, UP, 0, -1.0), (1, 0.5, 0.0, 1.0, UP, 0, 1.0)]
    night = sky.read_background(plain_file(tmp_path / "x.h5", lobes=lobes, reference=(1, 1_000_000)))
    times = 1_000_000 + 86_400 * np.array([-1e6, -1.0, 1.0, 1e6])
    light = night.irradiance(None, times, 500.0)
    assert light[0] == light[1] > 0
    assert light[2] == light[3] == pytest.approx(4 * light[1], rel=1e-6)
