"""The run folder: claims, atomic files, temporaries of the dead and of the living."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from aomc_sky.errors import ForeignOutputError, OutputError
from aomc_sky.outputs.folder import run_folder
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.shard import Shard
from aomc_sky.source.plan.plan import Plan
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS


def plan_of(seed: int) -> Plan:
    return read_scene(INPUTS / "document_example", iterations=10).source(seed=seed).plan


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return RunFolder(tmp_path / "deep" / "out")


def test_a_claim_writes_the_plan_once(folder):
    folder.claim(plan_of(1), force=False)
    before = (folder.path / "plan.npz").stat().st_ino
    folder.claim(plan_of(1), force=False)
    assert (folder.path / "plan.npz").stat().st_ino == before
    assert Plan.load(folder.path / "plan.npz").sha256 == plan_of(1).sha256


def test_another_plan_or_a_damaged_one_is_foreign(folder):
    folder.claim(plan_of(1), force=False)
    with pytest.raises(ForeignOutputError, match="another run"):
        folder.claim(plan_of(2), force=False)
    (folder.path / "plan.npz").write_bytes(b"PK")
    with pytest.raises(ForeignOutputError, match="--force"):
        folder.claim(plan_of(1), force=False)
    folder.claim(plan_of(2), force=True)
    assert Plan.load(folder.path / "plan.npz").sha256 == plan_of(2).sha256


def test_an_error_inside_leaves_neither_file_nor_temporary(folder):
    folder.path.mkdir(parents=True)
    folder.write("a", b"old")

    def fail() -> None:
        with folder.stream("a") as file:
            file.write(b"half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert [path.name for path in folder.path.iterdir()] == ["a"]
    assert (folder.path / "a").read_bytes() == b"old"


def test_a_temporary_that_is_cleared_away_before_its_lock_is_made_again(folder, monkeypatch):
    """Another process may see it between its creation and its lock, and take it for that of a dead run."""
    folder.path.mkdir(parents=True)
    seen = []

    def flock(file: object, how: int) -> None:
        seen.append(file.name)
        if len(seen) == 1:
            os.unlink(file.name)

    monkeypatch.setattr(run_folder, "flock", flock)
    folder.write("a", b"whole")
    assert len(seen) == 2
    assert (folder.path / "a").read_bytes() == b"whole"
    assert [path.name for path in folder.path.iterdir()] == ["a"]


def test_a_plan_that_appears_during_a_claim_is_no_stranger(folder, monkeypatch):
    """Another shard writes the plan and its first file just before the names are listed."""
    plan, real = plan_of(1), RunFolder.names

    def names(self: RunFolder, *beginnings: str) -> list[str]:
        if "manifest." in beginnings and self.size_of("plan.npz") is None:
            self.write("plan.npz", plan.to_bytes())
            self.write("photons-0001.k1-of-2.npy", b"x")
        return real(self, *beginnings)

    monkeypatch.setattr(RunFolder, "names", names)
    folder.claim(plan, force=False, shard=Shard(index=2, count=2))
    assert {path.name for path in folder.path.iterdir()} == {"plan.npz", "photons-0001.k1-of-2.npy"}


def test_a_shard_leaves_the_files_of_others_alone(folder):
    plan = plan_of(1)
    folder.claim(plan, force=False)
    for name in ("photons-0001.k1-of-2.npy", "photons-0001.k2-of-2.npy", "photons-0001.npy"):
        folder.write(name, b"x")
        (folder.path / f".aomc-sky-{name}.dead").write_bytes(b"half")
    folder.claim(plan, force=True, shard=Shard(index=2, count=2))
    left = {"photons-0001.k1-of-2.npy", "photons-0001.npy"}
    assert {path.name for path in folder.path.iterdir()} == {"plan.npz", *left, *(f".aomc-sky-{n}.dead" for n in left)}
    with pytest.raises(ForeignOutputError, match="another run"):
        folder.claim(plan_of(2), force=True, shard=Shard(index=2, count=2))


def test_sizes_hashes_and_missing_files(folder):
    folder.path.mkdir(parents=True)
    folder.write("a", b"abc")
    assert folder.size_of("a") == 3
    assert folder.sha256_of("a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    folder.remove("a")
    folder.remove("a")
    assert folder.size_of("a") is None
    with pytest.raises(OutputError, match="cannot read"):
        folder.sha256_of("a")
    folder.require_space(0)
    with pytest.raises(OutputError, match="needed"):
        folder.require_space(1 << 62)
