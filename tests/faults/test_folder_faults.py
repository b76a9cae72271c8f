"""Row 41 of the matrix: disks that fill up, folders that refuse, runs that are killed: nothing half is left."""

import json
import os
import resource
import signal
import threading

import pytest

from aomc_sky.cli.main import main
from aomc_sky.outputs import run_folder
from aomc_sky.outputs.run_folder import LOCK
from aomc_sky.system import appearing
from tests.support.fault_rows import command, row, row_id
from tests.support.processes import end_by, start, stopped, whole_files_only
from tests.support.scenes import run_bytes

SIGNALS = {"kill-9": (signal.SIGKILL, -9), "interrupt": (signal.SIGINT, 130)}


@pytest.mark.parametrize(("how", "code"), SIGNALS.values(), ids=[row_id(41, name) for name in SIGNALS])
def test_a_killed_run_is_finished_by_the_same_command(amc, tmp_path, how, code):
    words = ["run", amc, "--iterations", "2e5", "-q", "--out"]
    assert command(*words, tmp_path / "whole") == 0
    whole = run_bytes(tmp_path / "whole")
    out = tmp_path / "out"
    process = stopped(*words, out, block=6)  # of four in each waveband
    err = end_by(process, how)
    assert process.returncode == code
    assert b"Traceback" not in err
    assert not (out / "manifest.json").exists()
    assert not (out / "photons-0003.npy").exists()
    assert whole_files_only(out, whole)
    if how is signal.SIGINT:
        assert not list(out.glob(".aomc-sky-*"))
        assert b"interrupted" in err
    assert command(*words, out) == 0
    assert run_bytes(out) == whole


@row(41, "disk-full")
def test_a_full_disk_leaves_nothing_half(fault, amc, tmp_path):
    words = ["run", amc, "--iterations", "2e5", "-q", "--out", tmp_path / "out"]

    limit = (resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))
    process = start(*words, preexec_fn=lambda: resource.setrlimit(*limit))
    _, err = process.communicate(timeout=60)
    assert process.returncode == 6, err
    assert err.startswith(b"aomc-sky: error: cannot write")
    assert b"photons-0001.npy" in err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"plan.npz", "counts.csv"}
    assert command(*words) == 0


@row(41, "reader-goes-away")
def test_a_reader_that_goes_away_is_exit_6(fault, amc):
    process = start("run", amc, "--iterations", "1e6", "--format", "raw", "--out", "-")
    process.stdout.read(10)
    process.stdout.close()
    err = process.stderr.read()
    process.stderr.close()
    assert process.wait(60) == 6
    assert b"ended before the last photon" in err
    assert b"Traceback" not in err


@row(41, "folder-vanishes")
def test_a_folder_that_vanishes(fault, amc, tmp_path, told, monkeypatch):
    out = tmp_path / "out"
    real = run_folder.RunFolder.write

    def write(self, name, data):
        real(self, name, data)
        if name == "counts.csv":
            os.rename(out, tmp_path / "gone")

    monkeypatch.setattr(run_folder.RunFolder, "write", write)
    assert "cannot" in told("run", amc, "--out", out, "-q", code=6).err
    assert not out.exists()
    left = {path.name for path in (tmp_path / "gone").iterdir()}
    assert left - {LOCK} == {"plan.npz", "counts.csv"}  # the lock goes with the folder, and is held by nobody


CALLS = ("fsync", "replace")


@pytest.mark.parametrize("failing", CALLS, ids=[row_id(41, f"{name}-fails") for name in CALLS])
def test_the_operating_system_refuses_at_the_last_step(amc, tmp_path, told, monkeypatch, failing):
    def refuse(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(run_folder.os, failing, refuse)
    assert "No space left" in told("run", amc, "--out", tmp_path / "out", "-q", code=6).err
    assert not list((tmp_path / "out").iterdir())


@row(41, "disk-known-to-be-too-small")
def test_a_disk_known_to_be_too_small_is_told_before_anything_is_made(fault, amc, tmp_path, told):
    assert "GB are needed" in told("run", amc, "--iterations", "1e15", "--out", tmp_path / "out", "-q", code=6).err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"plan.npz"}


@row(43, "one-name-under-way-twice")
def test_one_name_under_way_twice(fault, tmp_path):
    """Each process has a file of its own until it is whole; the last one to end holds."""
    counts = tmp_path / "counts.csv"
    with appearing(counts) as first:
        first.write(b"1")
        with appearing(counts) as second:
            second.write(b"2")
        assert counts.read_bytes() == b"2"
    assert counts.read_bytes() == b"1"
    assert len(list(tmp_path.iterdir())) == 1


def test_no_thread_outlives_a_run(amc, tmp_path):
    assert main(["run", str(amc), "--out", str(tmp_path / "out"), "--threads", "4", "-q"]) == 0
    assert not [t.name for t in threading.enumerate() if t.name.startswith("aomc-sky")]


def test_an_unfinished_run_is_known_to_info(amc, tmp_path, told):
    out = tmp_path / "out"
    assert main(["run", str(amc), "--iterations", "100", "--out", str(out), "-q"]) == 0
    (out / "manifest.json").unlink()
    assert "unfinished" in told("info", out).out
    shown = json.loads(told("info", out, "--json").out)
    assert (shown["finished"], shown["requested"]) == (False, [100, 100, 100])
