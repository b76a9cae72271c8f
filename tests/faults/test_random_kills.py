"""Row 41 of the matrix, at random: killed at forty moments, each time nothing half, and resumed to the same root."""

from __future__ import annotations

import json
import random
import shutil
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from aomc_sky.cli.main import main
from tests.support.fault_rows import row_id
from tests.support.processes import start, wait_for
from tests.support.scenes import copy_scene, run_bytes

pytestmark = pytest.mark.slow

KILLS = 40
"""Of a run; shards and merges, which are made of the same steps, are killed half as often."""

ITERATIONS = "4e5"
ENDS = (".npy", ".mcpl", ".csv", ".npz")


@pytest.fixture(scope="module")
def amc(tmp_path_factory) -> Path:
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def shards(amc, tmp_path_factory) -> Path:
    """Shards 1 and 3 of 3, and 2: what merging reads."""
    out = tmp_path_factory.mktemp("shards") / "out"
    for k in (1, 2, 3):
        assert main([*run_words(amc, out), "--shard", f"{k}/3"]) == 0
    return out


def run_words(amc: Path, out: Path) -> list[str]:
    return ["run", str(amc), "--iterations", ITERATIONS, "--threads", "2", "-q", "--out", str(out)]


def root_of(folder: Path) -> str:
    return json.loads((folder / "manifest.json").read_text())["content"]["root"]


def moments(words: list[str], out: Path, seed: int, n_kills: int = KILLS // 2) -> Iterator[float]:
    """Random times after the folder appears, over the time that the command takes; the last ones come too late."""
    process = start(*words)
    wait_for(out, "*", process)
    began = time.monotonic()
    process.communicate(timeout=120)
    assert process.returncode == 0
    lasts = time.monotonic() - began
    rng = random.Random(seed)
    return (rng.uniform(0.0, 1.05 * lasts) for _ in range(n_kills))


def kill_after(words: list[str], out: Path, moment: float) -> int:
    """Start the command, kill it so many seconds after the folder appears, return how it ended."""
    process = start(*words)
    wait_for(out, "*", process)
    time.sleep(moment)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=120)
    return process.returncode


def check_whole(folder: Path, whole: dict[str, bytes]) -> None:
    """Every file under a final name is the finished one."""
    for path in folder.iterdir():
        if path.name.endswith(ENDS) and not path.name.startswith("."):
            assert path.read_bytes() == whole[path.name], path.name


@pytest.mark.parametrize("formats", [("npy",), ("npy", "mcpl")], ids=[row_id(41, f"random-kills-{n}") for n in (1, 2)])
def test_a_run(amc, tmp_path, formats):
    chosen = [word for name in formats for word in ("--format", name)]
    words = [*run_words(amc, tmp_path / "whole"), *chosen]
    times = moments(words, tmp_path / "whole", seed=41, n_kills=KILLS)
    whole, root = run_bytes(tmp_path / "whole"), root_of(tmp_path / "whole")
    out, ends = tmp_path / "out", []
    words = [*run_words(amc, out), *chosen]
    for moment in times:
        ends.append(kill_after(words, out, moment))
        check_whole(out, whole)
        assert main(words) == 0
        assert root_of(out) == root
        assert run_bytes(out) == whole
        shutil.rmtree(out)
    assert ends.count(-signal.SIGKILL) > len(ends) // 2, ends


def test_a_shard(amc, shards, tmp_path):
    whole = {path.name: path.read_bytes() for path in shards.iterdir() if ".k1-" not in path.name}
    words = [*run_words(amc, tmp_path / "whole"), "--shard", "2/3"]
    times = moments(words, tmp_path / "whole", seed=42)
    out, ends = tmp_path / "out", []
    words = [*run_words(amc, out), "--shard", "2/3"]
    for moment in times:
        ends.append(kill_after(words, out, moment))
        check_whole(out, whole)
        assert main(words) == 0
        check_whole(out, whole)
        left = {path.name for path in out.iterdir() if not path.name.startswith(".aomc-sky-plan.npz.")}
        assert left == {path.name for path in (tmp_path / "whole").iterdir()}  # half a plan may be any shard's
        shutil.rmtree(out)
    assert ends.count(-signal.SIGKILL) > len(ends) // 2, ends


def test_a_merge(amc, shards, tmp_path):
    assert main(run_words(amc, tmp_path / "one")) == 0
    whole = run_bytes(tmp_path / "one")
    words = ["merge", str(shards), "--threads", "2", "-q", "--out"]
    times = moments([*words, str(tmp_path / "whole")], tmp_path / "whole", seed=43)
    ends = []
    for moment in times:
        out = tmp_path / "out"
        ends.append(kill_after([*words, str(out)], out, moment))
        check_whole(out, whole)
        assert main([*words, str(out)]) == 0
        assert run_bytes(out) == whole
        shutil.rmtree(out)
    assert ends.count(-signal.SIGKILL) > len(ends) // 2, ends


def test_removing_shards(amc, shards, tmp_path):
    """Killed while the shards go away: the run stands, and the same command removes the rest."""
    assert main(run_words(amc, tmp_path / "one")) == 0
    whole, out = run_bytes(tmp_path / "one"), tmp_path / "out"
    for turn in range(KILLS // 4):
        shutil.copytree(shards, out)
        process = start("merge", out, "-q", "--remove-shards")
        wait_for(out, "manifest.json", process)
        time.sleep(0.0005 * turn)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=120)
        check_whole(out, whole | {path.name: path.read_bytes() for path in shards.iterdir()})
        assert main(["merge", str(out), "-q", "--remove-shards"]) == 0
        assert run_bytes(out) == whole
        shutil.rmtree(out)
