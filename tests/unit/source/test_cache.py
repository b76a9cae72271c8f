"""The folder of kept solutions: what is written is read, anything else is damage, and the folder stays small."""

import os
import stat
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from aomc_sky.cache import Cache, DamagedEntryError

KEY, OTHER = "0" * 64, "1" * 64
CONTENT = bytes(range(256)) * 40


@pytest.fixture
def cache(tmp_path):
    return Cache(folder=tmp_path / "a" / "b", most_bytes=100_000)


def test_what_is_written_is_read(cache):
    assert cache.read(KEY) is None
    cache.write(KEY, CONTENT)
    cache.write(OTHER, b"")
    assert cache.read(KEY) == CONTENT
    assert cache.read(OTHER) == b""
    assert stat.S_IMODE(cache.folder.stat().st_mode) == 0o700
    assert sorted(path.name for path in cache.folder.iterdir()) == [f"{KEY}.entry", f"{OTHER}.entry"]


@pytest.mark.parametrize("at", [0, 16, 40, 90, 150, 5000, -1])
def test_a_flipped_bit_anywhere_is_damage(cache, at):
    cache.write(KEY, CONTENT)
    data = bytearray(cache.path(KEY).read_bytes())
    data[at] ^= 1
    cache.path(KEY).write_bytes(data)
    with pytest.raises(DamagedEntryError):
        cache.read(KEY)


@pytest.mark.parametrize("n", [0, 1, 100, 147, 148, 5000])
def test_a_truncated_entry_is_damage(cache, n):
    cache.write(KEY, CONTENT)
    cache.path(KEY).write_bytes(cache.path(KEY).read_bytes()[:n])
    with pytest.raises(DamagedEntryError):
        cache.read(KEY)


def test_an_entry_that_is_longer_or_of_another_key_is_damage(cache):
    cache.write(KEY, CONTENT)
    cache.path(OTHER).write_bytes(cache.path(KEY).read_bytes())
    with pytest.raises(DamagedEntryError):
        cache.read(OTHER)
    with cache.path(KEY).open("ab") as file:
        file.write(b"\n")
    with pytest.raises(DamagedEntryError):
        cache.read(KEY)


def test_a_link_a_folder_and_a_pipe_are_damage_that_is_never_opened(cache, tmp_path):
    cache.write(OTHER, CONTENT)
    outside = tmp_path / "outside"
    outside.write_bytes(cache.path(OTHER).read_bytes().replace(OTHER.encode(), KEY.encode()))
    for make in (lambda path: path.symlink_to(outside), os.mkfifo, os.mkdir):
        make(cache.path(KEY))
        with pytest.raises(DamagedEntryError):
            cache.read(KEY)
        if not cache.path(KEY).is_dir():  # another name takes the place of a link or a pipe, and follows neither
            cache.write(KEY, CONTENT)
            assert cache.read(KEY) == CONTENT
            assert outside.stat().st_size > len(CONTENT)
            cache.path(KEY).unlink()


def test_an_entry_that_is_too_large_is_neither_written_nor_read(cache):
    cache.write(KEY, bytes(30_000))
    assert cache.read(KEY) is None
    Cache(folder=cache.folder).write(KEY, bytes(30_000))
    with pytest.raises(DamagedEntryError):
        cache.read(KEY)


def test_what_was_used_last_stays(cache):
    keys = [f"{k:064d}" for k in range(6)]
    for age, key in enumerate(keys):
        cache.write(key, bytes(20_000))  # four fit into 100 000 bytes
        if cache.path(key).exists():
            os.utime(cache.path(key), (1000 + age, 1000 + age))
        if age == 3:
            assert cache.read(keys[0]) is not None  # now it is the one that was used last
            os.utime(cache.path(keys[0]), (2000, 2000))
    assert [key for key in keys if cache.path(key).exists()] == [keys[0], keys[3], keys[4], keys[5]]


def test_reading_counts_as_use(cache):
    cache.write(KEY, CONTENT)
    os.utime(cache.path(KEY), (1000, 1000))
    cache.read(KEY)
    assert cache.path(KEY).stat().st_mtime > time.time() - 60


def test_what_a_killed_writer_left_goes_and_what_others_write_stays(cache):
    cache.write(KEY, CONTENT)
    old, new, foreign = (cache.folder / name for name in ("old.part", "new.part", "letter.txt"))
    for path in (old, new, foreign):
        path.write_bytes(b"x")
    os.utime(old, (1000, 1000))
    os.utime(foreign, (1000, 1000))
    cache.write(OTHER, CONTENT)
    assert not old.exists()
    assert new.exists()
    assert foreign.exists()


def _write_often(folder):
    cache = Cache(folder=Path(folder), most_bytes=100_000)
    found = set()
    for _ in range(100):
        cache.write(KEY, CONTENT)
        found.add(cache.read(KEY))
    return found


def test_two_writers_at_once_do_no_harm(cache):
    with ProcessPoolExecutor(2, mp_context=get_context("fork")) as pool:
        found = list(pool.map(_write_often, [str(cache.folder)] * 2))
    assert found == [{CONTENT}] * 2
    assert [path.name for path in cache.folder.iterdir()] == [f"{KEY}.entry"]


def test_a_folder_that_cannot_be_written_keeps_nothing(cache, monkeypatch):
    cache.write(KEY, CONTENT)
    with monkeypatch.context() as patch:  # as on a disk that is read-only, for root too
        for name in ("mkdir", "replace", "utime"):
            patch.setattr(os, name, _refused)
        patch.setattr("tempfile.mkstemp", _refused)
        cache.write(OTHER, CONTENT)
        assert cache.read(OTHER) is None
        assert cache.read(KEY) == CONTENT
    full = Cache(folder=cache.path(KEY) / "below")  # a file stands where the folder would be
    full.write(KEY, CONTENT)
    assert full.read(KEY) is None


def _refused(*arguments, **named):
    raise OSError(30, "Read-only file system")


def test_a_disk_that_fills_up_leaves_nothing_behind(cache, monkeypatch):
    cache.write(KEY, CONTENT)
    monkeypatch.setattr(os, "replace", _refused)
    cache.write(OTHER, CONTENT)
    assert [path.name for path in cache.folder.iterdir()] == [f"{KEY}.entry"]


def test_a_folder_of_another_user_or_open_to_all_is_not_used(cache, monkeypatch):
    cache.write(KEY, CONTENT)
    cache.folder.chmod(0o707)
    assert cache.read(KEY) is None
    cache.folder.chmod(0o700)
    assert cache.read(KEY) == CONTENT
    monkeypatch.setattr(os, "geteuid", lambda: cache.folder.stat().st_uid + 1)
    cache.write(OTHER, CONTENT)
    assert cache.read(KEY) is None
    assert not cache.path(OTHER).exists()
