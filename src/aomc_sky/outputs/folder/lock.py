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
from dataclasses import dataclass
from pathlib import Path

from aomc_sky.errors import OutputError
from aomc_sky.system import EXCLUSIVE, HAS_LOCKS, NON_BLOCKING, SHARED, flock, open_handle, write_at

LOCK = ".aomc-sky.lock"
"""Stands in a folder while somebody holds it; after a kill -9 it may stay, locked by nobody."""

CLAIM_S = 60.0
"""How long one may wait for another that takes a folder, and removes an old run there. [s]"""
_PAUSE_S = (0.005, 0.02)
_MOST_REFUSALS = 3
"""Others look at a lock, too, and hold it while they look: one refusal alone says nothing."""

_HOLDER = re.compile(rb"plan ([0-9a-f]{64}) process ([0-9]{1,20}) on ([A-Za-z0-9_.-]{1,255})\n")
_TAKEN = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)
_READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Holder:
    """Who holds a lock, or held it when it was killed, as its file says."""

    plan_sha256: str
    process: str
    host: str

    def __str__(self) -> str:
        return f"another run (plan {self.plan_sha256[:16]}, process {self.process} on {self.host})"


@contextlib.contextmanager
def folder_held(
    folder: Path, plan_sha256: str, claim: Callable[[], None], *, exclusive: bool = False
) -> Iterator[None]:
    """Hold a folder for a plan while the block runs; OutputError where another plan holds it.

    Processes with the same plan share the folder, unless `exclusive`: then files of theirs would be removed. `claim`
    refuses a folder of another plan and writes this plan; it is called when no other plan holds the folder.

    A lock is exclusive while one claims and shared from then on, its file removed by the last one to leave. A file that
    was removed between its opening and its lock is no longer that of the folder, and all begins again.
    """
    with _held(folder, plan_sha256, claim, claim, exclusive):
        yield


@contextlib.contextmanager
def folder_joined(folder: Path, plan_sha256: str) -> Iterator[None]:
    """Hold a folder together with the process that gives this one work; OutputError where no such process holds it."""

    def refuse() -> None:
        raise OutputError(f"{folder}: the run of this task has ended")

    with _held(folder, plan_sha256, refuse, lambda: None, exclusive=False):
        yield


@contextlib.contextmanager
def _held(
    folder: Path, plan_sha256: str, claim: Callable[[], None], share: Callable[[], None], exclusive: bool
) -> Iterator[None]:
    handle = _hold(folder, plan_sha256, claim, share, exclusive)
    try:
        yield
    finally:
        if handle is not None:
            _leave(folder, handle)


def _hold(
    folder: Path, plan_sha256: str, claim: Callable[[], None], share: Callable[[], None], exclusive: bool
) -> int | None:
    """A descriptor that holds the lock, None where there are no locks; `share`: the plan is there already."""
    if not HAS_LOCKS:
        share()
        return None
    began, refusals, dead_holder = time.monotonic(), 0, None
    while True:
        handle, is_kept = _opened(folder), False
        try:
            taken = None if handle is None else _taken(handle)
            if handle is None or taken is None:
                if handle is not None and _holder(handle) is None:
                    _remove(folder)
                share()
                return None
            if taken and not _is_current(folder, handle):
                continue
            holder = _holder(handle)
            if taken == EXCLUSIVE and (holder is None or holder == dead_holder):
                is_kept = _claimed(folder, handle, plan_sha256, claim)
            elif taken == EXCLUSIVE:
                dead_holder = holder  # killed, or on its way from exclusive to shared: another look shows
            elif taken == SHARED and holder is not None and holder.plan_sha256 == plan_sha256:
                _refuse_others(folder, holder, exclusive)
                share()
                is_kept = True
            elif taken == SHARED and holder is not None:
                refusals += 1
            if is_kept:
                return handle
            if refusals == _MOST_REFUSALS or time.monotonic() - began > CLAIM_S:
                raise OutputError(
                    f"{folder} is held by {holder or 'another run'}; wait until it ends, or choose another --out"
                )
        finally:
            if handle is not None and not is_kept:
                os.close(handle)
        time.sleep(random.uniform(*_PAUSE_S))


def _refuse_others(folder: Path, holder: _Holder, exclusive: bool) -> None:
    if exclusive:
        raise OutputError(
            f"{folder} is held: process {holder.process} on {holder.host} makes the same run there, and --force would "
            "remove its files; wait until it ends, or leave out --force to share the work"
        )


def _opened(folder: Path) -> int | None:
    """The file of the lock, that of another account for reading alone; None where nothing can be written."""
    path, handle = folder / LOCK, None
    try:
        try:
            handle = open_handle(path, os.O_RDWR | os.O_CREAT, follow_links=False)
        except OSError as error:
            if error.errno not in _READ_ONLY:
                raise
            with contextlib.suppress(OSError):
                handle = open_handle(path, os.O_RDONLY, follow_links=False)
        status = None if handle is None else os.fstat(handle)
        if handle is not None and status and (not stat.S_ISREG(status.st_mode) or status.st_nlink > 1):
            os.close(handle)  # what is written there is no other file's, not even through a hard link
            raise OSError(errno.EINVAL, "it is no regular file, or it has a second name (a hard link)")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    return handle


def _taken(handle: int) -> int | None:
    """`EXCLUSIVE` or `SHARED`, whichever can be had now, 0 where another has it alone, None without locks."""
    for how in (EXCLUSIVE, SHARED):
        try:
            flock(handle, how | NON_BLOCKING)
        except OSError as error:
            if error.errno not in _TAKEN:
                return None
        else:
            return how
    return 0


def _is_current(folder: Path, handle: int) -> bool:
    """Whether an open lock is still that of the folder; opened anew, for network file systems keep old answers."""
    try:
        other = open_handle(folder / LOCK, os.O_RDONLY, follow_links=False)
    except OSError:
        return False
    try:
        return os.path.samestat(os.fstat(handle), os.fstat(other))
    except OSError:
        return False
    finally:
        os.close(other)


def _holder(handle: int) -> _Holder | None:
    """Who says in the lock that it is theirs."""
    os.lseek(handle, 0, os.SEEK_SET)
    match = _HOLDER.fullmatch(os.read(handle, 512))
    if match is None:
        return None
    plan, process, host = (part.decode("ascii") for part in match.groups())
    return _Holder(plan_sha256=plan, process=process, host=host)


def _claimed(folder: Path, handle: int, plan_sha256: str, claim: Callable[[], None]) -> bool:
    """Settle while nobody else is there, then share; False where another was quicker between the two."""
    try:
        write_at(handle, b"", 0)
    except OSError:  # left there by another account: one of our own is made in its place
        _remove(folder)
        return False
    try:
        claim()
        host = re.sub(r"[^A-Za-z0-9_.-]", "-", platform.node())[:255] or "-"
        text = f"plan {plan_sha256} process {os.getpid()} on {host}\n".encode()
        os.ftruncate(handle, 0)
        write_at(handle, text, 0)
        flock(handle, SHARED)
    except OSError as error:
        _remove(folder)
        raise OutputError(f"cannot write {folder / LOCK}: {error.strerror or error}") from error
    except BaseException:
        _remove(folder)
        raise
    holder = _holder(handle)
    return _is_current(folder, handle) and holder is not None and holder.plan_sha256 == plan_sha256


def _remove(folder: Path) -> None:
    with contextlib.suppress(OSError):
        (folder / LOCK).unlink()


def _leave(folder: Path, handle: int) -> None:
    """Close a lock, and remove its file where nobody else holds it."""
    with contextlib.suppress(OSError):
        flock(handle, EXCLUSIVE | NON_BLOCKING)
        if _is_current(folder, handle):
            _remove(folder)
    os.close(handle)
