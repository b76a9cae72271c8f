"""The run folder: claims, atomic files, what a killed run left."""

import os
import shutil

import pytest

from aomc_sky.errors import ForeignOutputError, OutputError
from aomc_sky.outputs.run_folder import LOCK, RunFolder
from aomc_sky.plan.plan import Plan
from aomc_sky.source.read.scene import read_scene
from tests.support.shared import INPUTS


def plan_of(seed):
    return read_scene(INPUTS / "document_example", iterations=10).source(seed=seed).plan


def claim(folder, seed, *, force=False):
    with folder.held(plan_of(seed), force=force):
        pass


def names(folder):
    return {path.name for path in folder.path.iterdir()}


@pytest.fixture
def folder(tmp_path):
    return RunFolder(tmp_path / "deep" / "out")


def test_another_run_is_replaced_by_force_alone(folder, monkeypatch):
    claim(folder, 1)
    own = {"photons-0001.npy", "photons-0002.npy.part", "blocks-0001.npy", "shard-1-of-2.done", "manifest.json"}
    for name in {*own, "notes.txt"}:
        folder.write(name, b"x")
    with pytest.raises(ForeignOutputError, match="another run"):
        claim(folder, 2)
    assert names(folder) == {"plan.npz", "notes.txt", *own}
    removed, remove = [], RunFolder.remove
    monkeypatch.setattr(RunFolder, "remove", lambda self, *some: (removed.extend(some), remove(self, *some)))
    claim(folder, 2, force=True)
    assert (removed[0], removed[-1]) == ("manifest.json", "plan.npz")  # a killed one leaves a run that is not finished
    assert names(folder) == {"plan.npz", "notes.txt"}
    assert Plan.load(folder.path / "plan.npz").sha256 == plan_of(2).sha256


def test_a_disk_without_space_for_the_new_run_keeps_the_old_one(folder, monkeypatch):
    claim(folder, 1)
    folder.write("photons-0001.npy", bytes(8192))
    n_bytes = 1000 + folder.space_of("photons-0001.npy")
    usage = shutil.disk_usage(folder.path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=1000))
    with pytest.raises(OutputError, match="are needed"), folder.held(plan_of(2), force=True, n_bytes=n_bytes + 1):
        pass
    assert names(folder) == {"plan.npz", "photons-0001.npy"}
    with folder.held(plan_of(2), force=True, n_bytes=n_bytes):  # the space of the old run is free, too
        assert names(folder) == {"plan.npz", LOCK}


def test_what_a_killed_run_left_goes_while_nobody_is_there(folder):
    claim(folder, 1)
    left = folder.path / ".aomc-sky-photons-0002.npy.0123abcd"
    left.write_text("half")
    with folder.held(plan_of(1)):
        assert not left.exists()
        left.write_text("under way")
        with RunFolder(folder.path).held(plan_of(1)):
            assert left.read_text() == "under way"


def test_a_file_that_is_filled_from_several_sides(folder):
    folder.path.mkdir(parents=True)
    folder.reserve("a", b"head", 10)
    folder.reserve("a", b"head", 10)  # by another process
    with folder.filling("a") as one, folder.filling("a") as other:
        os.pwrite(one, b"ab", 8)
        os.pwrite(other, b"cdef", 4)
    folder.finish("a")
    folder.finish("a")
    assert (folder.path / "a").read_bytes() == b"headcdefab"
    with folder.filling("a") as handle:
        assert handle is None  # it is finished
    with pytest.raises(OutputError, match=r"b\.part"), folder.filling("b"):
        pass
