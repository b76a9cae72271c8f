"""The one opener: regular files only, through links or not, and never a wait."""

import os
import socket
from pathlib import Path

import pytest

from aomc_sky.system import FileKindError, open_regular, read_regular, regular_status

READERS = {
    "status": regular_status,
    "open": lambda path, **how: open_regular(path, **how).close(),
    "read": lambda path, **how: read_regular(path, 100, **how),
}
each_reader = pytest.mark.parametrize("read", READERS.values(), ids=READERS)


@pytest.fixture
def regular(tmp_path):
    path = tmp_path / "regular"
    path.write_bytes(b"twelve bytes")
    return path


def test_a_link_is_followed_and_a_limit_holds(regular, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(regular)
    assert read_regular(link, 12) == b"twelve bytes"
    for read in READERS.values():
        with pytest.raises(FileKindError, match="a symbolic link"):
            read(link, follow_links=False)
    with pytest.raises(OSError, match="larger than 11 bytes"):
        read_regular(regular, 11)
    endless = Path("/proc/self/environ")  # claims to be empty
    if endless.exists() and endless.read_bytes():
        with pytest.raises(OSError, match="larger than 0 bytes"):
            read_regular(endless, 0)


@each_reader
@pytest.mark.parametrize("follow", [True, False])
def test_nothing_else_is_opened(read, follow, tmp_path):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as one:
        here = os.getcwd()
        os.chdir(tmp_path)  # the name of a socket has at most 107 bytes
        try:
            one.bind("socket")
        finally:
            os.chdir(here)
        kinds = {"folder": "a folder", "pipe": "a pipe", "socket": "a socket"}
        for name, kind in kinds.items():
            with pytest.raises(FileKindError) as seen:
                read(tmp_path / name, follow_links=follow)
            assert seen.value.kind == kind
    with pytest.raises(FileKindError, match="a device"):
        read("/dev/zero", follow_links=follow)


@each_reader
def test_a_name_that_no_file_can_have(read):
    with pytest.raises(OSError, match="no file can have this name"):
        read("a\0b")


def test_a_link_put_there_after_the_look_is_not_followed(regular, tmp_path, monkeypatch):
    """Between looking and opening another process may have put a link, or a pipe, under the name."""
    link = tmp_path / "link"
    link.symlink_to(regular)
    looked = os.stat(regular)
    monkeypatch.setattr(os, "stat", lambda *_, **__: looked)
    with pytest.raises(OSError, match="symbolic link"):
        open_regular(link, follow_links=False)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileKindError, match="a pipe"):
        open_regular(tmp_path / "pipe")


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="nobody says which descriptors are open")
def test_no_descriptor_is_left(tmp_path):
    before = len(os.listdir("/proc/self/fd"))
    os.mkfifo(tmp_path / "pipe")
    for _ in range(20):
        for read in READERS.values():
            with pytest.raises(FileKindError):
                read(tmp_path / "pipe")
    assert len(os.listdir("/proc/self/fd")) == before
