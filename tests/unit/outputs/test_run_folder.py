"""The run folder: claims, atomic files, temporaries of the dead and of the living."""

from __future__ import annotations

from pathlib import Path

import pytest

from aomc_sky.errors import ForeignOutputError, OutputError
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.source.from_files import read_scene
from aomc_sky.source.plan import Plan
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


def test_force_removes_the_files_of_a_run_and_no_others(folder):
    folder.claim(plan_of(1), force=False)
    for name in ("counts.csv", "photons-0001.npy", "weights-0001.npy", "manifest.json", "notes.txt"):
        folder.write(name, b"x")
    folder.claim(plan_of(1), force=True)
    assert {path.name for path in folder.path.iterdir()} == {"plan.npz", "notes.txt"}


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


def test_the_temporary_of_a_living_run_is_spared(folder):
    folder.path.mkdir(parents=True)
    (folder.path / ".aomc-sky-photons-0001.npy.dead").write_bytes(b"half")
    with folder.stream("photons-0001.npy") as file:
        file.write(b"whole")
        folder._remove_leftovers()
        hidden = [path.name for path in folder.path.iterdir()]
        assert len(hidden) == 1
        assert not hidden[0].endswith(".dead")
    assert (folder.path / "photons-0001.npy").read_bytes() == b"whole"


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
