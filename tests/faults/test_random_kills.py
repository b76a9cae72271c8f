"""Row 41 of the matrix, at random: killed at thirty moments, each time nothing half, and resumed to the same bytes."""

import os
import random
import shutil
import signal
import time

import pytest

from aomc_sky.cli.main import main
from tests.support.fault_rows import row
from tests.support.forked_commands import ForkedCommand
from tests.support.processes import start, wait_for
from tests.support.scenes import copy_scene, run_bytes

pytestmark = pytest.mark.slow

KILLS = 30
"""Of a run; shards, which are made of the same steps, are killed half as often."""

ITERATIONS = "4e5"
ENDS = (".npy", ".mcpl", ".csv", ".npz")


@pytest.fixture(scope="module")
def amc(tmp_path_factory):
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


def run_words(amc, out):
    return ["run", str(amc), "--iterations", ITERATIONS, "--threads", "2", "-q", "--out", str(out)]


def killed(words, out, n_kills, seed):
    """Start the command and kill it at a random moment after its folder appears, until that came in time so often."""
    rng, lasts, n = random.Random(seed), time_of(words, out), 0
    while n < n_kills:
        process = ForkedCommand(*words)
        wait_for(out, "*", process)
        time.sleep(rng.uniform(0.0, lasts))
        process.kill()
        if process.wait(120) == -signal.SIGKILL:
            n += 1
        else:
            assert process.returncode == 0
            lasts *= 0.9  # the machine was slower when it was measured
        yield
        shutil.rmtree(out)


def time_of(words, out):
    """How long the command goes on after its folder appears; the folder is removed. [s]"""
    process = ForkedCommand(*words)
    wait_for(out, "*", process)
    began = time.monotonic()
    assert process.wait(120) == 0
    lasts = time.monotonic() - began
    shutil.rmtree(out)
    return lasts


def check_whole(folder, whole):
    """Every file under a final name is the finished one."""
    for path in folder.iterdir():
        if path.name.endswith(ENDS) and not path.name.startswith(".") and ".part" not in path.name:
            assert path.read_bytes() == whole[path.name], path.name


@row(41, "random-kills")
def test_a_run(fault, amc, tmp_path):
    chosen = ["--format", "npy", "--format", "mcpl"]
    assert main([*run_words(amc, tmp_path / "whole"), *chosen]) == 0
    whole = run_bytes(tmp_path / "whole")
    out = tmp_path / "out"
    words = [*run_words(amc, out), *chosen]
    for _ in killed(words, out, KILLS, seed=41):
        check_whole(out, whole)
        assert main(words) == 0
        assert run_bytes(out) == whole


def test_a_shard(amc, tmp_path):
    """The last one of three, which ends the run."""
    assert main(run_words(amc, tmp_path / "whole")) == 0
    whole, out = run_bytes(tmp_path / "whole"), tmp_path / "out"
    words = [*run_words(amc, out), "--shard", "2/3"]
    for k in (1, 3):
        assert main([*run_words(amc, tmp_path / "others"), "--shard", f"{k}/3"]) == 0
    rng = random.Random(42)
    for _ in range(KILLS // 2):
        shutil.copytree(tmp_path / "others", out)
        process = ForkedCommand(*words)
        time.sleep(rng.uniform(0.0, 1.0))
        process.kill()
        process.wait(120)
        check_whole(out, whole)
        assert main(words) == 0
        assert run_bytes(out) == whole
        shutil.rmtree(out)


@row(41, "random-kills-of-a-cluster")
def test_a_run_of_a_cluster(fault, amc, tmp_path):
    """Client, scheduler and workers are killed at once; then another cluster goes on, every other time threads."""
    pytest.importorskip("distributed")
    assert main(run_words(amc, tmp_path / "whole")) == 0
    whole, out, rng = run_bytes(tmp_path / "whole"), tmp_path / "out", random.Random(44)
    words, more = run_words(amc, out), ["--engine", "dask"]
    for turn in range(KILLS // 7):
        process = start(*words, *more, start_new_session=True)
        wait_for(out, "photons-*", process)
        time.sleep(rng.uniform(0.0, 4.0))  # a cluster starts in two or three seconds, and makes these photons in one
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate(timeout=120)
        check_whole(out, whole)
        assert main([*words, *more[: 2 * (turn % 2)]]) == 0
        assert run_bytes(out) == whole
        shutil.rmtree(out)
