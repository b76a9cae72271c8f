"""Row 47 of the matrix: two different runs in one folder at once: one holds it, the other one ends and says so."""

import json
import re
import signal

import pytest

from aomc_sky.cli.main import main
from aomc_sky.outputs.run_folder import LOCK
from tests.support.fault_rows import row
from tests.support.processes import end_by, stopped
from tests.support.scenes import copy_scene


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


def words_of(scene, out, seed, *options):
    words = ["run", scene, "--iterations", "2e5", "--threads", 1, "-q", "--seed", seed, "--out", out, *options]
    return [str(word) for word in words]


@pytest.fixture
def holder(scene, tmp_path):
    """A run of seed 1 into ``out`` that is stopped in its midst, and alive."""
    process = stopped(*words_of(scene, tmp_path / "out", 1), block=6)
    yield process
    process.kill()
    process.communicate(timeout=60)


def goes_on(process):
    process.send_signal(signal.SIGCONT)
    process.communicate(timeout=120)
    return process.returncode


@pytest.mark.parametrize("options", [(), ("--force",)], ids=["plain", "force"])
@row(47, "another-seed-while-one-runs")
def test_another_plan_is_refused_while_one_holds_the_folder(fault, options, holder, scene, tmp_path, capsys):
    out = tmp_path / "out"
    before = {path.name for path in out.iterdir()}
    assert main(words_of(scene, out, 2, *options)) == 6
    held = rf"is held by another run \(plan [0-9a-f]{{16}}, process {holder.pid} on .+"
    assert re.search(held, capsys.readouterr().err)
    assert {path.name for path in out.iterdir()} == before
    assert goes_on(holder) == 0
    assert main(["verify", str(out)]) == 0
    assert not (out / LOCK).exists()
    assert json.loads((out / "manifest.json").read_text())["seed"] == 1
    assert main(words_of(scene, out, 2)) == 5
    assert main(words_of(scene, out, 2, "--force")) == 0
    assert main(["verify", str(out)]) == 0


@row(47, "force-while-the-same-run-goes-on")
def test_force_takes_no_living_run_apart(fault, holder, scene, tmp_path, told):
    same = words_of(scene, tmp_path / "out", 1)
    assert f"process {holder.pid} on" in told(*same, "--force", code=6).err
    assert main(same) == 0  # without it the work is shared
    assert goes_on(holder) == 0
    assert main(["verify", str(tmp_path / "out")]) == 0


@row(47, "shards-of-one-plan-share-the-folder")
def test_shards_of_one_plan_share_a_folder(fault, scene, tmp_path, told):
    out = tmp_path / "out"
    shard = words_of(scene, out, 1, "--shard")
    process = stopped(*shard, "1/2", block=5)
    try:
        assert main([*shard, "2/2"]) == 0
        assert main([*shard, "1/2"]) == 0  # which the stopped process makes, too
        assert "is held by another run" in told(*words_of(scene, out, 2, "--shard", "2/2"), code=6).err
        assert goes_on(process) == 0
    finally:
        process.kill()
        process.communicate(timeout=60)
    assert main(["verify", str(out)]) == 0
    assert not [path.name for path in out.iterdir() if path.name.endswith((".part", ".done"))]


@row(47, "killed-holder")
def test_a_killed_holder_blocks_nobody(fault, holder, scene, tmp_path):
    out = tmp_path / "out"
    end_by(holder, signal.SIGKILL)
    assert (out / LOCK).exists()
    assert main(words_of(scene, out, 2)) == 5
    assert main(words_of(scene, out, 2, "--force")) == 0
    assert main(["verify", str(out)]) == 0
    assert not (out / LOCK).exists()
