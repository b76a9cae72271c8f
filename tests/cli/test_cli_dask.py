"""``run --engine dask`` on a real cluster of two processes: the bytes of one process, also when a worker is killed."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.engine import cluster as dask_run
from aomc_sky.engine.run import JobOptions
from aomc_sky.engine.shards import run_shard
from tests.support.processes import UNFINISHED
from tests.support.scenes import copy_scene, run_bytes

KILLED_WRITER = """
import os, signal, sys
from pathlib import Path
from aomc_sky.system import appearing
with appearing(Path(sys.argv[1]) / "shard-1-of-2.done") as file:
    os.kill(os.getpid(), signal.SIGKILL)
"""

BLOCK = 65_536
ITERATIONS = 6 * BLOCK + 77
"""Of each of three wavebands."""


@pytest.fixture(autouse=True)
def _small_tasks(monkeypatch):
    monkeypatch.setattr("aomc_sky.engine.cluster.TASK_PHOTONS", 2 * BLOCK)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    distributed = pytest.importorskip("distributed")
    scratch = tmp_path_factory.mktemp("dask")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # that of Dask may be another suite's
        local_directory=str(scratch),
        silence_logs=50,
    ) as cluster:
        yield cluster


@pytest.fixture
def run_on(cluster, amc, tmp_path):
    """Runs the scene into `out` of the test, and tells of its progress."""

    def call(progress=None):
        scene = sky.read_scene(amc, iterations=ITERATIONS)
        how = {"scheduler": cluster.scheduler_address, "progress": progress}
        return dask_run.run_on_dask(scene.source(0), scene, tmp_path / "out", JobOptions(), **how)

    return call


@pytest.fixture(scope="module")
def amc(tmp_path_factory):
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


def words(amc, out, *more):
    many = () if "--iterations" in more else ("--iterations", ITERATIONS)
    return [*map(str, ("run", amc, *many, "--out", out, "-q", *more))]


def on(cluster):
    return ("--engine", "dask", "--scheduler", cluster.scheduler_address)


@pytest.fixture(scope="module")
def whole(amc, tmp_path_factory):
    out = tmp_path_factory.mktemp("whole")
    assert main(words(amc, out)) == 0
    return run_bytes(out)


def test_cluster_writes_the_bytes_of_one_process(cluster, amc, whole, tmp_path):
    assert main(words(amc, tmp_path / "out", *on(cluster))) == 0
    assert run_bytes(tmp_path / "out") == whole


def test_worker_killed_in_mid_run_costs_only_its_tasks(cluster, run_on, whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.Client(cluster.scheduler_address) as client:
        processes = client.run(os.getpid)
        killed: list[int] = []

        def kill_one(done, total):
            if not killed and 0 < done < total:
                killed.append(next(iter(processes.values())))
                os.kill(killed[0], signal.SIGKILL)

        result = run_on(kill_one)
        assert killed
        client.wait_for_workers(2)
    assert 0 < result.emitted <= result.manifest["total"]  # the killed worker's last range may stand whole already
    assert run_bytes(tmp_path / "out") == whole


def test_task_of_a_finished_run_leaves_nothing(amc, whole, tmp_path):
    """A scheduler gives it to a worker when another one died after its result."""
    assert main(words(amc, tmp_path / "out")) == 0
    source = sky.read_scene(amc, iterations=ITERATIONS).source(0)
    for task in dask_run.tasks_of(source):
        assert dask_run._make_shard(str(tmp_path / "out"), source.plan.sha256, task)
        assert run_bytes(tmp_path / "out") == whole


def test_run_goes_on_from_the_marks(run_on, amc, whole, tmp_path):
    """Its tasks are shards, whoever made them."""
    scene = sky.read_scene(amc, iterations=ITERATIONS)
    source, folder = scene.source(0), tmp_path / "out"
    there = sum(run_shard(source, scene, folder, JobOptions(), task).emitted for task in dask_run.tasks_of(source)[1:4])
    assert 0 < there == source.total - run_on().emitted
    assert run_bytes(folder) == whole


def test_another_run_in_the_folder_is_refused(cluster, amc, tmp_path):
    assert main(words(amc, tmp_path / "out", "--format", "none")) == 0
    assert main(words(amc, tmp_path / "out", "--seed", 1, *on(cluster))) == 5


def test_worker_that_does_not_see_the_folder_says_so(cluster, amc, tmp_path, monkeypatch, capsys):
    """The folder of the client has another name where the workers are."""
    real = dask_run._make_shard
    monkeypatch.setattr(dask_run, "_make_shard", lambda folder, *rest: real(str(tmp_path / "elsewhere"), *rest))
    assert main(words(amc, tmp_path / "out", *on(cluster))) == 6
    assert "put the run folder on a file system that all workers share" in capsys.readouterr().err


def test_no_scheduler_is_exit_6(amc, tmp_path, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.setattr("aomc_sky.engine.cluster.CONNECT_SECONDS", 0.5)
    with socket.socket() as bound:  # bound and not listening: nobody answers there
        bound.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{bound.getsockname()[1]}"
        assert main(words(amc, tmp_path / "out", "--engine", "dask", "--scheduler", address)) == 6
    assert f"no Dask scheduler answers at {address}" in capsys.readouterr().err


SLOW_TASKS = """
import sys, time
from aomc_sky.cli.main import main
from aomc_sky.engine import cluster
make = cluster._make_shard

def make_slowly(*arguments):
    time.sleep(1.0)
    return make(*arguments)

cluster._make_shard = make_slowly
sys.exit(main())
"""
"""Of twenty tasks on two workers; the signal comes 0.05 s after the first of them."""


@pytest.mark.slow
def test_interrupt_of_a_terminal_is_one_line(amc, tmp_path):
    """A terminal sends SIGINT to the workers too; they print nothing, and the ranges made so far stay."""
    pytest.importorskip("distributed")
    more = ["--iterations", 20_000_000, "--waveband", 1, "--threads", 2, "-q"]
    command = [sys.executable, "-c", SLOW_TASKS, *words(amc, tmp_path / "run", *more, "--engine", "dask")]
    # a shell that runs this in the background has SIGINT ignored, which children inherit
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # by another process
            taken.bind(("", 8787))
        run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
        signal.signal(signal.SIGINT, before)
        while run.poll() is None and not list(tmp_path.glob("run/shard-*.done")):
            time.sleep(0.05)
        os.killpg(run.pid, signal.SIGINT)
        _, said = run.communicate()
    assert run.returncode == 130
    assert said == "aomc-sky: interrupted; run the same command to continue\n"


def test_what_a_killed_worker_was_writing_is_removed(run_on, whole, tmp_path):
    left: list[str] = []

    def kill_a_writer(done, total):
        if done and not left:
            subprocess.run([sys.executable, "-c", KILLED_WRITER, str(tmp_path / "out")], check=False)
            names = filter(UNFINISHED.fullmatch, os.listdir(tmp_path / "out"))
            left.extend(name for name in names if "shard-1-of-2.done" in name)  # others write, too

    run_on(kill_a_writer)
    assert len(left) == 1
    assert run_bytes(tmp_path / "out") == whole
