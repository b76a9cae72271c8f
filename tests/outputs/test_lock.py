"""One plan at a time holds a folder: threads stand for processes, for each opening of the lock has an owner."""

import errno
import fcntl
import os
import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from aomc_sky.errors import ForeignOutputError, OutputError
from aomc_sky.outputs import run_folder
from aomc_sky.outputs.run_folder import LOCK, flock, folder_held

ONE, OTHER = "1" * 64, "2" * 64


def held(folder, plan):
    return folder_held(folder, plan, lambda is_alone: None)


def is_refused(folder, plan, words=None):
    with pytest.raises(OutputError, match=words), held(folder, plan):
        pass


def test_one_plan_shares_it_and_the_last_one_takes_the_lock_away(tmp_path):
    with held(tmp_path, ONE):
        with held(tmp_path, ONE):
            assert (tmp_path / LOCK).exists()
        assert (tmp_path / LOCK).exists()
        is_refused(tmp_path, OTHER, "held")
    assert list(tmp_path.iterdir()) == []


def test_a_refusal_while_it_is_settled_leaves_nothing(tmp_path):
    def refuse(is_alone):
        raise ForeignOutputError("another run")

    with pytest.raises(ForeignOutputError), folder_held(tmp_path, ONE, refuse):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "plan", f"plan {ONE} process 1 on gone\n", "\x1b[2J\n"])
def test_what_the_dead_left_blocks_nobody(text, tmp_path):
    (tmp_path / LOCK).write_text(text)
    with held(tmp_path, OTHER):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["fifo", "folder", "link"])
def test_a_lock_that_is_no_file_is_refused_and_never_opened(kind, tmp_path):
    folder, victim = tmp_path / "out", tmp_path / "victim"
    folder.mkdir()
    victim.write_text("kept")
    {"fifo": os.mkfifo, "folder": os.mkdir, "link": partial(os.symlink, victim)}[kind](folder / LOCK)
    is_refused(folder, ONE, "cannot write")
    assert victim.read_text() == "kept"


@pytest.mark.parametrize("error", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_without_locks_nobody_is_kept_out(error, tmp_path, monkeypatch):
    def refuse(file, how):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr(run_folder, "flock", refuse)
    with held(tmp_path, ONE), held(tmp_path, OTHER):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_lock_removed_between_opening_and_locking_is_not_held(tmp_path, monkeypatch):
    """The last holder removes the file when the next one has opened it: both would hold, each its own file."""
    real, calls = run_folder._locked, []

    def taken(handle):
        if not calls:
            (tmp_path / LOCK).unlink()
            calls.append(handle)
        return real(handle)

    monkeypatch.setattr(run_folder, "_locked", taken)
    with held(tmp_path, ONE):
        assert (tmp_path / LOCK).exists()
        is_refused(tmp_path, OTHER)


def test_one_who_is_quicker_between_settling_and_sharing_has_it(tmp_path, monkeypatch):
    """A lock cannot be turned from alone to shared in one step; another plan that comes between the two holds."""
    quick = []

    def shared_late(handle, how):
        if how == run_folder.SHARED and not quick:
            flock(handle, fcntl.LOCK_UN)
            (tmp_path / LOCK).unlink()
            quick.append(held(tmp_path, OTHER))
            quick[0].__enter__()
        flock(handle, how)

    monkeypatch.setattr(run_folder, "flock", shared_late)
    is_refused(tmp_path, ONE, f"plan {OTHER[:16]}")
    quick[0].__exit__(None, None, None)


def test_never_two_plans_at_once(tmp_path):
    """Sixteen threads, three plans, held for random times: all who hold at any moment hold for one plan."""
    inside = []
    guard, outcomes = threading.Lock(), []

    def work(k):
        rng = random.Random(k)
        for _ in range(12):
            plan = str(rng.randrange(3)) * 64
            try:
                with held(tmp_path, plan):
                    with guard:
                        inside.append(plan)
                        outcomes.append(set(inside))
                    time.sleep(rng.uniform(0, 0.004))
                    with guard:
                        inside.remove(plan)
                outcomes.append(None)
            except OutputError:
                outcomes.append(set())
            time.sleep(rng.uniform(0, 0.004))

    with ThreadPoolExecutor(16) as executor:
        for future in [executor.submit(work, k) for k in range(16)]:
            future.result()
    assert max(len(seen) for seen in outcomes if seen is not None) == 1
    assert None in outcomes  # held, and not only refused
    assert list(tmp_path.iterdir()) == []
