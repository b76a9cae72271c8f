"""Row 41 of the matrix, at random: killed at thirty moments, each time nothing half, and resumed to the same bytes."""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import time

import pytest

from aomc_sky.cli.main import main
from tests.support.fault_rows import row
from tests.support.processes import start, wait_for
from tests.support.scenes import copy_scene, run_bytes

pytestmark = pytest.mark.slow

ENDS = (".npy", ".mcpl", ".csv", ".npz")
WAYS = {
    # name: (options, how often it is killed)
    "random-kills": (["--format", "npy", "--format", "mcpl"], 30),
    "random-kills-of-the-last-shard": (["--shard", "2/3"], 15),
    "random-kills-of-a-cluster": (["--engine", "dask"], 4),
}


@pytest.fixture(scope="module")
def amc(tmp_path_factory):
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


def words(amc, out, *more):
    return ["run", str(amc), "--iterations", "4e5", "--threads", "2", "-q", "--out", str(out), *more]


def killed_after(seconds, command, out):
    """Start the command and kill it, with all that it started, so long after its folder appears.

    How long it went on, and whether the kill came in time.
    """
    process = start(*command, start_new_session=True)
    wait_for(out, "*", process)
    began = time.monotonic()
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=120)
    assert process.returncode in (0, -signal.SIGKILL)
    return time.monotonic() - began, process.returncode != 0


def check_whole(folder, whole):
    """Every file under a final name is the finished one."""
    for path in folder.iterdir():
        if path.name.endswith(ENDS) and not path.name.startswith(".") and ".part" not in path.name:
            assert path.read_bytes() == whole[path.name], path.name


@row(41, *WAYS)
def test_killed_at_random(fault, amc, tmp_path):
    """A cluster is killed with its scheduler and its workers; then another one goes on, every other time threads."""
    more, n_kills = WAYS[fault]
    if "dask" in more:
        pytest.importorskip("distributed")
    out, others, n_killed = tmp_path / "out", tmp_path / "others", 0
    assert main(words(amc, tmp_path / "whole", *more[: 4 * ("npy" in more)])) == 0
    whole, rng = run_bytes(tmp_path / "whole"), random.Random(41)
    for k in (1, 3) if "--shard" in more else ():
        assert main(words(amc, others, "--shard", f"{k}/3")) == 0
    for turn in range(-1, n_kills):
        if others.exists():
            shutil.copytree(others, out)
        if turn < 0:
            lasts, _ = killed_after(120, words(amc, out, *more), out)
        else:
            n_killed += killed_after(rng.uniform(0.0, lasts), words(amc, out, *more), out)[1]
            check_whole(out, whole)
        assert main(words(amc, out, *([] if "dask" in more and turn % 2 else more))) == 0
        assert run_bytes(out) == whole
        shutil.rmtree(out)
    assert n_killed > n_kills // 3
