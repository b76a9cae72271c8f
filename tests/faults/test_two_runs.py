"""Row 47 of the matrix: two different runs in one folder at once: one holds it, the other one ends and says so."""

import contextlib
import json
import os
import re
import signal
import sys

import pytest

from aomc_sky.cli.main import main
from aomc_sky.outputs.run_folder import LOCK, RunFolder
from tests.support.fault_rows import row, row_id
from tests.support.forked_commands import SERVER
from tests.support.processes import end_by, stopped
from tests.support.scenes import copy_scene


def _run_at_once(words, ready, ended, other_ended, meets, error_file):
    """Claim the folder when the other process does; with `meets` its holder waits for the end of the other."""
    from aomc_sky.cli.main import main

    held = RunFolder.held

    @contextlib.contextmanager
    def held_together(*arguments, **options):
        ready.wait(60)
        with held(*arguments, **options):
            if meets:
                other_ended.wait(60)
            yield

    RunFolder.held = held_together
    try:
        with open(error_file, "w") as stream, contextlib.redirect_stderr(stream):
            code = main(words)
    finally:
        ended.set()
    sys.exit(code)


def judge_pair(scene, folder, *options, meets=False):
    """Let two runs of two seeds claim one folder at one moment; check that it is one run's, and return exit codes."""
    out, ready, ended = folder / "out", SERVER.Barrier(2), [SERVER.Event(), SERVER.Event()]
    errors = [folder / f"{seed}.txt" for seed in (1, 2)]
    both = []
    for k in range(2):
        words = words_of(scene, out, k + 1, *options)
        given = (words, ready, ended[k], ended[1 - k], meets, str(errors[k]))
        both.append(SERVER.Process(target=_run_at_once, args=given))
    for process in both:
        process.start()
    for process in both:
        process.join(120)
    codes = tuple(process.exitcode for process in both)
    told = [path.read_text() for path in errors]
    assert main(["verify", "-q", str(out)]) == 0, (codes, told)
    assert not (out / LOCK).exists()
    seed = json.loads((out / "manifest.json").read_text())["seed"]
    assert codes[seed - 1] == 0, (codes, told)
    other, said = codes[2 - seed], told[2 - seed]
    if other == 6:
        assert "is held by another run" in said
    elif other == 5:
        assert not options, told
        assert "holds another run" in said
    else:  # --force replaces a run that had ended before
        assert other == 0, (codes, told)
        assert options == ("--force",), told
    assert other == 6 or not meets, (codes, told)
    return codes


SLOW_PAIRS = int(os.environ.get("AOMC_SKY_PAIRS", "10"))


def judge_pairs(scene, folder, n):
    """Without and with --force, in pairs that meet and in pairs of which one may leave as the other comes."""
    for k in range(n):
        (folder / str(k)).mkdir()
        yield judge_pair(scene, folder / str(k), *(["--force"] if k % 2 else []), meets=k % 4 < 2)


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
    told = re.escape(f"{out} is held by another run (plan ") + f"[0-9a-f]{{16}}, process {holder.pid} on .+"
    assert re.search(told, capsys.readouterr().err)
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


@pytest.mark.parametrize(
    "n", [pytest.param(4, id=row_id(47, "two-seeds-at-once")), pytest.param(SLOW_PAIRS, marks=pytest.mark.slow)]
)
def test_two_seeds_started_at_once(n, scene, tmp_path):
    codes = list(judge_pairs(scene, tmp_path, n))
    met = sum(6 in pair for pair in codes)
    print(f"{len(codes)} pairs: {met} met; {sum(pair == (0, 0) for pair in codes)} came one after the other by --force")
