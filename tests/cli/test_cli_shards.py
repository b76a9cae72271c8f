"""``run --shard`` through main(argv): shards write in place, and whoever sees all marks ends the run."""

import dataclasses
import json
import shutil
import signal
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli.main import main
from aomc_sky.plan.plan import Plan
from tests.support.processes import end_by, stopped
from tests.support.scenes import run_bytes, scene_with_circle

BLOCK = 65_536
ITERATIONS = 2 * BLOCK + 77
FILES = {"photons-0002.npy", "positions-0002.npy"}
MARK = "shard-1-of-3.done"
PARTS = {f"{name}.part" for name in FILES}
POLARISED = ("--polarisation", "0.7", "--sky", "harrison-coombes")


@pytest.fixture(scope="module")
def amc(tmp_path_factory):
    return scene_with_circle(tmp_path_factory.mktemp("scene"))


def words(amc, out, *more):
    many = () if "--iterations" in more else ("--iterations", ITERATIONS)
    return [*map(str, ("run", amc, *many, "--waveband", 2, "-q", "--out", out, *more))]


def run(amc, out, *more):
    return main(words(amc, out, *more))


@pytest.fixture(scope="module")
def whole(amc, tmp_path_factory):
    out = tmp_path_factory.mktemp("whole")
    assert run(amc, out) == 0
    return run_bytes(out)


@pytest.fixture(scope="module")
def made(amc, tmp_path_factory):
    """Shards 1 and 3 of 3; tests copy them."""
    out = tmp_path_factory.mktemp("made") / "out"
    for k in (3, 1):
        assert run(amc, out, "--shard", f"{k}/3") == 0
    return out


@pytest.fixture
def out(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "out"))


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_shards_write_in_place_and_the_last_one_ends_the_run(amc, out, whole):
    assert names(out) == {"plan.npz", *PARTS, MARK, "shard-3-of-3.done"}
    for name in FILES:
        assert (out / f"{name}.part").stat().st_size == len(whole[name])
    there = np.frombuffer((out / "photons-0002.npy.part").read_bytes()[4096:], "<f4").reshape(-1, 3)
    is_of_2 = np.arange(ITERATIONS) // BLOCK == 1
    np.testing.assert_array_equal(np.sign(there[:, 2]), np.where(is_of_2, 0, -1))
    assert run(amc, out, "--shard", "2/3") == 0
    assert run_bytes(out) == whole


def test_a_call_after_the_last_one_changes_nothing(amc, out, whole, capsys):
    assert run(amc, out, "--shard", "2/3") == 0
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    capsys.readouterr()
    assert run(amc, out, "--shard", "1/3", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["was_finished"], shown["finished"], shown["missing"]) == (True, True, [])
    assert run(amc, out, "--shard", "1/7") == 0  # of another division
    assert run(amc, out) == 0
    assert {path.name: path.stat().st_mtime_ns for path in out.iterdir()} == before


def test_any_call_that_sees_all_marks_ends_the_run(amc, out, whole):
    """The last shard was killed between its mark and the manifest: a shard that is made already ends the run."""
    mark = (out / MARK).read_bytes()
    (out / MARK).unlink()
    assert run(amc, out, "--shard", "2/3") == 0
    assert "manifest.json" not in names(out)
    (out / MARK).write_bytes(mark)
    assert run(amc, out, "--shard", "3/3") == 0
    assert run_bytes(out) == whole


@pytest.mark.parametrize("calls", [("1/2", "2/2"), ()], ids=["another division", "a run in one go"])
def test_a_folder_of_shards_is_taken_by_other_calls(amc, out, whole, calls):
    for more in [("--shard", shard) for shard in calls] or [()]:
        assert run(amc, out, *more) == 0
    assert run_bytes(out) == whole


SPOILT = {
    "file gone": lambda out: (out / "positions-0002.npy.part").unlink(),
    "file cut": lambda out: (out / "photons-0002.npy.part").write_bytes(b"x"),
}


@pytest.mark.parametrize("name", SPOILT)
def test_what_a_mark_does_not_vouch_for_is_made_again(amc, out, whole, name, capsys):
    SPOILT[name](out)
    assert run(amc, out, "--shard", "2/3", "--json") == 0
    missing = json.loads(capsys.readouterr().out)["missing"]
    assert missing == ["1/3", "3/3"]
    for shard in missing:
        assert run(amc, out, "--shard", shard) == 0
    assert run_bytes(out) == whole


@pytest.mark.parametrize("more", [("--precision", "float64", "--replicates", 3), ("--weights",), POLARISED])
def test_more_shards_than_blocks(amc, tmp_path, more):
    assert run(amc, tmp_path / "whole", *more) == 0
    for k in range(5, 0, -1):
        assert run(amc, tmp_path / "out", "--shard", f"{k}/5", *more) == 0
    assert ("stokes-0002.npy" in names(tmp_path / "out")) == (more == POLARISED)
    assert run_bytes(tmp_path / "out") == run_bytes(tmp_path / "whole")


def test_what_a_shard_prints(amc, tmp_path, told):
    line = ["run", str(amc), "--iterations", "70000", "--shard", "2/3", "--out", str(tmp_path / "out")]
    shown = told(*line).out
    assert "shard 2/3: 70000 photons, seed 0" in shown
    assert "shards that are not made yet: 1/3, 3/3" in shown
    again = json.loads(told(*line, "--json").out)
    assert again["shard"] == {"index": 2, "count": 3, "photons": 70000}
    assert "shards: 2/3\nmissing: 1/3 3/3\n" in told("info", tmp_path / "out").out
    assert again["missing"] == json.loads(told("info", "--json", tmp_path / "out").out)["missing"] == ["1/3", "3/3"]


@pytest.mark.parametrize(("change", "code"), [(2e-16, 0), (1e-9, 5)], ids=["last digit", "another scene"])
@pytest.mark.parametrize("shards", [(), (1, 2)], ids=["whole", "shards"])
def test_a_plan_from_another_processor_is_the_same_run(change, code, shards, whole, amc, tmp_path, capsys):
    """Its masses may differ in the last digit; then the run goes on with the plan in the folder."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "plan.npz").write_bytes(whole["plan.npz"])
    plan = Plan.load(out / "plan.npz")
    (table,) = plan.components
    mass = table.mass.copy()
    mass.flat[np.argmax(mass)] *= 1.0 + change
    other = dataclasses.replace(plan, components=(dataclasses.replace(table, mass=mass),))
    assert other.sha256 != plan.sha256
    other.save(out / "plan.npz")
    for more in [("--shard", f"{k}/{len(shards)}") for k in shards] or [()]:
        assert run(amc, out, *more) == code, capsys.readouterr().err
    assert Plan.load(out / "plan.npz").sha256 == other.sha256
    if code == 0:
        assert main(["verify", "-q", str(out)]) == 0
        assert all((out / name).read_bytes() == whole[name] for name in FILES)


def test_a_killed_shard_is_made_again_and_needs_no_space_for_what_it_has_written(
    amc, whole, tmp_path, monkeypatch, capsys
):
    out = tmp_path / "out"
    process = stopped(*words(amc, out, "--shard", "1/1", "--threads", 1), block=2)
    end_by(process, signal.SIGKILL)
    assert names(out) > PARTS
    assert not [name for name in names(out) if name.endswith((".done", ".npy"))]
    sizes = [path.stat() for path in out.glob("*.part")]
    left = sum(size.st_size - 512 * size.st_blocks for size in sizes)
    assert 0 < left < 20 * ITERATIONS
    usage = shutil.disk_usage(out)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=left - 1))
    assert run(amc, out, "--shard", "1/1") == 6
    assert "run this one again when there is space" in capsys.readouterr().err
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=left))
    assert run(amc, out, "--shard", "1/1") == 0, capsys.readouterr().err
    assert run_bytes(out) == whole
