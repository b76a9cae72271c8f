"""Row 41 of the matrix for shards and their merge: disks that fill up, folders that refuse or vanish."""

from __future__ import annotations

import os
import resource
import shutil
from pathlib import Path

import pytest

from aomc_sky.outputs.folder import run_folder
from aomc_sky.outputs.folder.lock import LOCK
from tests.support.fault_rows import command, row
from tests.support.processes import start
from tests.support.scenes import run_bytes
from tests.support.shards import shard_words


def limit() -> None:
    """No file of more than 0.8 MB: room for the photons of a shard with one block, and not for those of two."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (800_000, 800_000))


@row(41, "shard-disk-full")
def test_a_shard_on_a_full_disk(fault, shards, tmp_path):
    out = Path(shutil.copytree(shards, tmp_path / "out"))
    for path in out.glob("*.k3-of-3*"):
        path.unlink()
    neighbours = {path.name: path.read_bytes() for path in out.iterdir()}
    words = shard_words(shards.parent / "document_example", out, 3)
    process = start(*words, preexec_fn=limit)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 6, err
    assert b"cannot write" in err
    assert b"photons-0001.k3-of-3.npy" in err
    assert {path.name: path.read_bytes() for path in out.iterdir()} == neighbours
    assert command(*words) == 0
    assert command("merge", out, "-q") == 0


@row(41, "merge-disk-full")
def test_a_merge_on_a_full_disk(fault, shards, whole, tmp_path):
    before = {path.name: path.read_bytes() for path in shards.iterdir()}
    words = ("merge", shards, "--out", tmp_path / "out", "-q", "--remove-shards")
    process = start(*words, preexec_fn=limit)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 6, err
    assert b"photons-0001.npy" in err
    assert not (tmp_path / "out").exists()
    assert {path.name: path.read_bytes() for path in shards.iterdir()} == before
    assert command(*words[:-1]) == 0
    assert run_bytes(tmp_path / "out") == run_bytes(whole)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a folder that nobody may write to")
@row(41, "shards-and-a-target-that-refuses")
def test_a_target_that_refuses(fault, shards, capsys):
    target = "/proc/self/aomc-sky-out"
    for words in (shard_words(shards.parent / "document_example", target, 1), ("merge", shards, "--out", target, "-q")):
        assert command(*words) == 6
        assert target in capsys.readouterr().err


@row(41, "merge-folder-vanishes")
def test_a_folder_that_vanishes(fault, shards, tmp_path, capsys, monkeypatch):
    out, real = tmp_path / "out", run_folder.RunFolder.require_space

    def vanish(self: run_folder.RunFolder, n_bytes: int) -> None:
        real(self, n_bytes)
        os.rename(out, tmp_path / "gone")

    monkeypatch.setattr(run_folder.RunFolder, "require_space", vanish)
    assert command("merge", shards, "--out", out, "-q", "--remove-shards") == 6
    assert "cannot" in capsys.readouterr().err
    assert not out.exists()
    assert {path.name for path in (tmp_path / "gone").iterdir()} - {LOCK} == {"plan.npz"}
    assert len(list(shards.iterdir())) == 1 + 3 * 7


@row(41, "merge-disk-known-to-be-too-small")
def test_a_disk_known_to_be_too_small(fault, shards, tmp_path, capsys, monkeypatch):
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(run_folder.shutil, "disk_usage", lambda path: usage._replace(free=1_000_000))
    assert command("merge", shards, "--out", tmp_path / "out", "-q") == 6
    assert "GB are needed" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
