"""A stored plan is loaded and saved again with equal members and hash: of the version before, and of every scene."""

import dataclasses
import io
import json
import zipfile

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.damaged_plans import KINDS, plan_of
from tests.support.shared import INPUTS, REPOSITORY

STORED = sorted((REPOSITORY / "tests" / "data" / "plans").glob("*.npz"))
"""Plans that 0.4 wrote before its plans had records: weights, replicates, irradiances, slopes, lobes, Perez."""

SOLVED = ("eclipse", "twilight")  # their light is computed for ten seconds
SCENES = [
    pytest.param(name, marks=pytest.mark.slow) if name in SOLVED else name
    for name in sorted(path.parent.name for path in INPUTS.glob("*/amc.inp"))
]


def parts(data):
    """Names and bytes of the members; the heads that Python's zipfile writes around them are those of its version."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return [(name, archive.read(name)) for name in archive.namelist()]


def saved_again(path):
    plan = sky.Plan.load(path)
    assert parts(plan.to_bytes()) == parts(path.read_bytes())
    assert sky.Plan.load(path) == plan
    with np.load(path) as stored:
        members = plan.members()
        assert set(stored) == {*members, "options", "sha256"}
        for name, array in members.items():
            assert stored[name].dtype == array.dtype, name
            np.testing.assert_array_equal(stored[name], array, err_msg=name)
        assert json.loads(bytes(stored["options"])) == plan.options
        assert bytes(stored["sha256"]).hex() == plan.sha256


@pytest.mark.parametrize("path", STORED, ids=[path.stem for path in STORED])
def test_a_plan_of_the_version_before(path):
    saved_again(path)


@pytest.mark.parametrize("kind", KINDS)
def test_a_plan_of_every_kind(kind, tmp_path):
    path = tmp_path / "plan.npz"
    plan_of(kind).save(path)
    saved_again(path)
    assert sky.Plan.load(path) == plan_of(kind)


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning", "ignore::aomc_sky.ModelLimitWarning")
@pytest.mark.parametrize("name", SCENES)
def test_a_plan_of_every_scene(name, tmp_path):
    if name == "night_sky":
        pytest.importorskip("h5py")
    plan = sky.read_scene(INPUTS / name, iterations=10_000).source(seed=3, replicates=1).plan
    plan.save(tmp_path / "plan.npz")
    saved_again(tmp_path / "plan.npz")


def test_a_changed_copy_is_checked():
    plan = plan_of("table")
    with pytest.raises(sky.InputFileError, match=r"plan: error\[E954\]: row_of_band"):
        dataclasses.replace(plan, bands=(dataclasses.replace(plan.bands[0], row=7), plan.bands[1]))
    with pytest.raises(sky.InputFileError, match=r"plan: error\[E953\]: cumulative"):
        dataclasses.replace(plan, cumulative=plan.cumulative[:, :-1])
