"""Calls that not every operating system has: what stands for them gives the same, and nothing else asks for one."""

import errno
import os
import re

import pytest

from aomc_sky import system
from tests.support.processes import in_environment
from tests.support.shared import INPUTS, REPOSITORY

_PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
from tests.support.other_system import become
become()
from pathlib import Path
from pkgutil import walk_packages
import aomc_sky
from aomc_sky.cli.main import main

scene, out = sys.argv[2], Path(sys.argv[3])
run = ["run", "-q", scene, "--iterations", "2e5", "--seed", "1"]
assert main([*run, "--out", str(out / "whole")]) == 0
for shard in ("1/2", "2/2"):
    assert main([*run, "--out", str(out / "parts"), "--shard", shard]) == 0
assert main(["verify", "-q", str(out / "parts")]) == 0
assert main([*run, "--format", "mcpl", "--out", str(out / "mcpl")]) == 0
assert main([*run, "--out", str(out / "whole")]) == 0  # finished before
assert main([*run[:-1], "2", "--force", "--out", str(out / "mcpl")]) == 0  # and removed
assert main(["perez", "-q", "--sun-zenith", "40", "--dni", "700", "--dhi", "90", "--out", str(out / "perez")]) == 0
names = [one.name for one in walk_packages(aomc_sky.__path__, "aomc_sky.") if not one.name.endswith("__main__")]
for name in names:
    __import__(name)
print(len(names), "modules")
"""


def test_without_posix_everything_is_imported_and_a_run_has_the_same_bytes(tmp_path):
    """As on Windows, as far as Linux can play it: shards, verify, a run replaced and a Perez sky."""
    amc = INPUTS / "document_example" / "amc.inp"
    said = in_environment(_PROGRAM, REPOSITORY, amc, tmp_path, PYTHONWARNINGS="error")
    assert int(said.split()[-2]) > 200
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert not list(tmp_path.rglob(".aomc*"))
    for path in whole.iterdir():
        assert path.read_bytes() == (parts / path.name).read_bytes()


def test_bytes_at_an_offset_are_the_same_without_the_calls_for_it(tmp_path, monkeypatch):
    results = []
    for is_bare in (False, True):
        if is_bare:
            monkeypatch.delattr(os, "pwrite")
            monkeypatch.delattr(os, "preadv")
        handle = os.open(tmp_path / str(is_bare), os.O_RDWR | os.O_CREAT)
        try:
            assert system.write_at(handle, b"twelve bytes", 0) == 12
            assert system.write_at(handle, b"dozen!", 20) == 6
            room, short = bytearray(8), bytearray(10)
            assert system.read_at(handle, room, 16) == 8
            assert system.read_at(handle, short, 23) == 3
            results.append((room, short))
        finally:
            os.close(handle)
    assert results == [(b"\0\0\0\0doze", b"en!" + bytes(7))] * 2
    files = [(tmp_path / name).read_bytes() for name in ("True", "False")]
    assert files == [b"twelve bytes" + bytes(8) + b"dozen!"] * 2


def test_words_that_a_system_does_not_have(tmp_path, monkeypatch):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    (tmp_path / "file").write_bytes(b"x")
    for word in (os.O_NOFOLLOW, 0):
        monkeypatch.setattr(system, "_NO_LINK", word)
        with pytest.raises(OSError, match=re.escape(os.strerror(errno.ELOOP))):
            system.open_handle(tmp_path / "link", os.O_RDONLY, follow_links=False)
        os.close(system.open_handle(tmp_path / "link", os.O_RDONLY))
    for name in ("sched_getaffinity", "O_DIRECTORY"):
        monkeypatch.delattr(os, name)
    assert system.n_cpus() == os.cpu_count()
    system.sync_folder(tmp_path / "absent")
