"""Calls that some operating systems lack, each with its substitute.

Everything else uses the common part of ``os``, ``signal`` and ``pathlib``. mypy checks the package as on each system
(``mypy --platform win32``). docs/platforms.md has the same list for users.
"""

from __future__ import annotations

import errno
import os
import sys
import threading
from pathlib import Path
from typing import IO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

# files

_PLAIN = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
"""The opened file never blocks on a pipe, takes no terminal, and keeps line ends as they are."""
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_position = threading.Lock()
"""Held while the position of an open file is moved, on systems without pread and pwrite."""


def open_handle(path: str | Path, access: int, *, follow_links: bool = True) -> int:
    """``os.open`` for bytes, which never waits; without `follow_links` OSError for a symbolic link.

    A system without O_NOFOLLOW checks for a link first, and follows one that appears after that.
    """
    if not follow_links and not _NO_LINK and os.path.islink(path):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path))
    return os.open(path, access | _PLAIN | (0 if follow_links else _NO_LINK), 0o666)


def write_at(handle: int, data: bytes | memoryview, offset: int) -> int:
    """Write at an offset from any thread; returns the number of bytes written."""
    if hasattr(os, "pwrite"):
        return os.pwrite(handle, data, offset)
    with _position:
        os.lseek(handle, offset, os.SEEK_SET)
        return os.write(handle, data)


def read_at(handle: int, room: bytearray, offset: int) -> int:
    """Fill a buffer from an offset, from any thread; returns the number of bytes read."""
    if hasattr(os, "preadv"):
        return os.preadv(handle, [room], offset)
    with _position:
        os.lseek(handle, offset, os.SEEK_SET)
        data = os.read(handle, len(room))
    room[: len(data)] = data
    return len(data)


def sync_file(handle: int) -> None:
    """Force written data to the disk, if the system can."""
    if hasattr(os, "fsync"):
        os.fsync(handle)


def sync_folder(path: Path) -> None:
    """Force the names in a folder to the disk, if the system can open folders."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


# locks

HAS_LOCKS = fcntl is not None
EXCLUSIVE = 0 if fcntl is None else fcntl.LOCK_EX
SHARED = 0 if fcntl is None else fcntl.LOCK_SH
NON_BLOCKING = 0 if fcntl is None else fcntl.LOCK_NB


def flock(file: int | IO[bytes], how: int) -> None:
    """Lock an open file for as long as it is open; killed processes hold nothing.

    OSError where another process holds it, or the system or the file system knows no locks.
    """
    if fcntl is None:
        raise OSError(errno.ENOSYS, "this system knows no locks")
    fcntl.flock(file, how)


# processes


def n_cpus() -> int:
    """CPUs this process may use; all of the machine if the system does not say."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# the C library


def has_linux_sse_state() -> bool:
    """Whether floating-point states are those of Linux on x86-64, which end with the control word of SSE."""
    return sys.platform == "linux" and os.uname().machine == "x86_64"
