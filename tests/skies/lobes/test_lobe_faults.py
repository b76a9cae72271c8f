"""Row 36 of the matrix: lobes at and beyond the ends of their parameters, and times outside the keys."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.background import CURVES, LOBES, plain_file
from tests.support.fault_rows import row, row_id

UP = (1.0, 0.0, 0.0, 0.0)


@row(36, "g-exactly-0")
def test_an_even_lobe(fault):
    m = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.3, -0.4, -0.5]])
    assert sky.lobes.pdf("hg", 0.0, 0.0, m).tolist() == pytest.approx([1 / (4 * np.pi)] * 3, rel=4e-16)
    assert sky.lobes.mass_above_horizon("hg", 0.0, 0.0, UP) == 0.5
    assert sky.henyey_greenstein.sample_mu(0.25, 0.0) == -0.5


OUTSIDE = {
    # name: (member, kind of lobe, value)
    "g-1": ("Param0", 1, 1.0),
    "g-negative": ("Param0", 1, -0.5),
    "alpha-0": ("Param0", 2, 0.0),
    "alpha-negative": ("Param1", 2, -1.0),
    "rotation-of-zeros": ("LocalTransform", 1, (0, 0, 0, 0)),
    "rotation-nan": ("LocalTransform", 1, (1, 0, np.nan, 0)),
}
PLACE = {"Param0": 1, "Param1": 2, "LocalTransform": 4}


@pytest.mark.parametrize("name", OUTSIDE, ids=[row_id(36, name) for name in OUTSIDE])
def test_parameters_outside(name, tmp_path, monkeypatch, told):
    pytest.importorskip("h5py")
    member, kind, value = OUTSIDE[name]
    lobe = list(LOBES[0] if kind == 1 else LOBES[1])
    lobe[0], lobe[PLACE[member]], lobe[5] = kind, value, 0
    plain_file(tmp_path / "x.h5", lobes=[tuple(lobe)], curves=CURVES)
    monkeypatch.chdir(tmp_path)
    said = told("validate", "x.h5", code=3).err
    assert said.startswith(f"x.h5: error[E506]: /LobeAnims/a/Lobes: {member} [0] is ")
    assert "\n      = " in said


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


@row(36, "time-nan", "time-without-zone")
def test_a_time_that_is_none(fault, tmp_path, told):
    pytest.importorskip("h5py")
    answers = {
        "time-nan": ("nan", "is not a date with a time of day"),
        "time-without-zone": ("2026-02-14T21:30:00", "zone"),
    }
    time, words = answers[fault]
    assert words in told("info", plain_file(tmp_path / "x.h5"), "--time", time, code=2).err
