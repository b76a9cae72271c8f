"""The lock of a run folder: one plan at a time holds it, however many processes make that plan."""

from __future__ import annotations

import contextlib
import errno
import os
import platform
import random
import re
import stat
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from aomc_sky.errors import OutputError
from aomc_sky.system import EXCLUSIVE, HAS_LOCKS, NON_BLOCKING, SHARED, flock, open_handle, write_at

LOCK = ".aomc-sky.lock"
"""Stands in a folder while somebody holds it. After a kill -9 it may stay, locked by nobody."""

_HOLDER = re.compile(
    r"plan (?P<plan>[0-9a-f]{64}) process (?P<process>[0-9]{1,20}) on (?P<host>[A-Za-z0-9_.-]{1,255})\n"
)

CLAIM_S = 60.0
"""How long a process waits for another one that takes the folder and removes an old run there. [s]"""

_PAUSE_S = (0.005, 0.02)
_MOST_REFUSALS = 3
"""Others hold the lock for a moment while they look at it, so one refusal alone says nothing."""


@contextlib.contextmanager
def folder_held(
    folder: Path, plan_sha256: str, claim: Callable[[bool], None], *, is_alone: bool = False
) -> Iterator[None]:
    """Hold a folder for a plan while the block runs; OutputError where another plan holds it.

    Processes with the same plan share the folder, unless `is_alone` asks for it alone. The first of them calls
    ``claim(True)`` while nobody else is there: it refuses the folder of another plan and writes this plan. A file
    system that knows no locks gets ``claim(False)``.

    A lock is exclusive during the claim and shared from then on. The last process that leaves removes its file.
    """
    handle = _acquire(folder, plan_sha256, claim, is_alone)
    try:
        yield
    finally:
        if handle is not None:
            with contextlib.suppress(OSError):
                flock(handle, EXCLUSIVE | NON_BLOCKING)
                _remove(folder, handle)
            os.close(handle)


def _acquire(folder: Path, plan_sha256: str, claim: Callable[[bool], None], is_alone: bool) -> int | None:
    if not HAS_LOCKS:
        claim(False)
        return None
    began, refusals = time.monotonic(), 0
    while True:
        handle = _opened(folder)
        is_kept = False
        try:
            how = _locked(handle)
            if how is None:
                if _holder(handle) is None:
                    _remove(folder, handle)
                claim(False)
                return None
            holder = _holder(handle)
            if how and not _is_current(folder, handle):
                pass  # look again
            elif how == EXCLUSIVE:
                is_kept = _claimed(folder, handle, plan_sha256, claim)
            elif how == SHARED and holder is not None and holder["plan"] == plan_sha256:
                if is_alone:
                    raise OutputError(
                        f"{folder} is held: process {holder['process']} on {holder['host']} makes the same run there, "
                        "and --force would remove its files; wait until it ends, or leave out --force to share the work"
                    )
                is_kept = True
            elif how == SHARED and holder is not None:
                refusals += 1
            if is_kept:
                return handle
            if refusals == _MOST_REFUSALS or time.monotonic() - began > CLAIM_S:
                who = (
                    f"plan {holder['plan'][:16]}, process {holder['process']} on {holder['host']}" if holder else "new"
                )
                raise OutputError(
                    f"{folder} is held by another run ({who}); wait until it ends, or choose another --out"
                )
        finally:
            if not is_kept:
                os.close(handle)
        time.sleep(random.uniform(*_PAUSE_S))


def _opened(folder: Path) -> int:
    try:
        handle = open_handle(folder / LOCK, os.O_RDWR | os.O_CREAT, follow_links=False)
        if stat.S_ISREG(os.fstat(handle).st_mode):
            return handle
        os.close(handle)
        raise OSError(errno.EINVAL, "it is no regular file")
    except OSError as error:
        raise OutputError(f"cannot write {folder / LOCK}: {error.strerror or error}") from error


def _locked(handle: int) -> int | None:
    """`EXCLUSIVE` or `SHARED`, whichever can be had now; 0 where another has it alone; None without locks."""
    for how in (EXCLUSIVE, SHARED):
        try:
            flock(handle, how | NON_BLOCKING)
        except BlockingIOError:
            continue
        except OSError:  # not every network file system knows locks
            return None
        return how
    return 0


def _is_current(folder: Path, handle: int) -> bool:
    """Whether an open lock is still that of the folder: whoever left may have removed it."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(folder / LOCK, follow_symlinks=False))
    except OSError:
        return False


def _holder(handle: int) -> dict[str, str] | None:
    """Plan, process and host as the lock says them; None for a new lock."""
    os.lseek(handle, 0, os.SEEK_SET)
    match = _HOLDER.fullmatch(os.read(handle, 512).decode("ascii", "replace"))
    return None if match is None else match.groupdict()


def _claimed(folder: Path, handle: int, plan_sha256: str, claim: Callable[[bool], None]) -> bool:
    """Settle while nobody else is there, then share; False where another plan came between the two."""
    try:
        claim(True)
        host = re.sub(r"[^A-Za-z0-9_.-]", "-", platform.node())[:255] or "-"
        text = f"plan {plan_sha256} process {os.getpid()} on {host}\n"
        os.ftruncate(handle, 0)
        write_at(handle, text.encode(), 0)
        flock(handle, SHARED)
    except OSError as error:
        _remove(folder, handle)
        raise OutputError(f"cannot write {folder / LOCK}: {error.strerror or error}") from error
    except BaseException:
        _remove(folder, handle)
        raise
    holder = _holder(handle)
    return _is_current(folder, handle) and holder is not None and holder["plan"] == plan_sha256


def _remove(folder: Path, handle: int) -> None:
    with contextlib.suppress(OSError):
        if _is_current(folder, handle):
            (folder / LOCK).unlink()
