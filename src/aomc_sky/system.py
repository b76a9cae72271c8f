"""What not every operating system offers: each such call stands here with what is done where it is missing.

The rest of the package calls Python's own ``os``, ``signal`` and ``pathlib`` for what Linux, macOS and Windows share;
mypy checks it as on each of them (``mypy --platform win32``). docs/faults.md shows the same list to users.
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
"""Neither waits for a pipe's other end, nor becomes a terminal's process, nor turns the ends of lines."""
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_position = threading.Lock()
"""Held by who moves the position of an open file, where nothing reads and writes without it."""


def open_handle(path: str | Path, access: int, *, follow_links: bool = True) -> int:
    """``os.open`` for bytes, which never waits; without `follow_links` OSError for a symbolic link.

    Where the system has no such word, the link is looked for first, and one that comes in between is followed.
    """
    if not follow_links and not _NO_LINK and os.path.islink(path):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path))
    return os.open(path, access | _PLAIN | (0 if follow_links else _NO_LINK), 0o666)


def write_at(handle: int, data: bytes | memoryview, offset: int) -> int:
    """Write at an offset from any thread; how many bytes were written."""
    if hasattr(os, "pwrite"):
        return os.pwrite(handle, data, offset)
    with _position:
        os.lseek(handle, offset, os.SEEK_SET)
        return os.write(handle, data)


def read_at(handle: int, room: bytearray, offset: int) -> int:
    """Fill a buffer from an offset, from any thread; how many bytes there were."""
    if hasattr(os, "preadv"):
        return os.preadv(handle, [room], offset)
    with _position:
        os.lseek(handle, offset, os.SEEK_SET)
        data = os.read(handle, len(room))
    room[: len(data)] = data
    return len(data)


def sync_file(handle: int) -> None:
    """Force what was written to the disk; nothing where the system cannot be asked."""
    if hasattr(os, "fsync"):
        os.fsync(handle)


def sync_folder(path: Path) -> None:
    """Force the names in a folder to the disk; nothing where a folder cannot be opened."""
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
    """CPUs this process may use, all of the machine where the system does not say."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# the C library


def has_linux_sse_state() -> bool:
    """Whether floating-point states are those of Linux on x86-64, which end with the control word of SSE."""
    return sys.platform == "linux" and os.uname().machine == "x86_64"
