"""Row 36 of the matrix: lobes at and beyond the ends of their parameters, and times outside the keys."""

import pytest

from tests.support.background import plain_file
from tests.support.fault_rows import row


@row(36, "rotation-of-zeros")
def test_parameters_outside(fault, tmp_path, monkeypatch, told):
    """Other members and values: tests/skies/lobes/file/test_file.py."""
    pytest.importorskip("h5py")
    plain_file(tmp_path / "x.h5", lobes=[(1, 0.5, 0.0, 0.25, (0, 0, 0, 0), 0, 0.0)])
    monkeypatch.chdir(tmp_path)
    said = told("validate", "x.h5", code=3).err
    assert said.startswith("x.h5: error[E506]: /LobeAnims/a/Lobes: LocalTransform [0] is ")
    assert "\n      = " in said


@row(36, "time-nan", "time-without-zone")
def test_a_time_that_is_none(fault, tmp_path, told):
    pytest.importorskip("h5py")
    answers = {
        "time-nan": ("nan", "is not a date with a time of day"),
        "time-without-zone": ("2026-02-14T21:30:00", "zone"),
    }
    time, words = answers[fault]
    assert words in told("info", plain_file(tmp_path / "x.h5"), "--time", time, code=2).err
