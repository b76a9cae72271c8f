"""Files as the operating system has them, and calls that some systems lack, each with its substitute.

Everything else uses the common part of ``os``, ``signal`` and ``pathlib``. mypy checks the package as on each system
(``mypy --platform win32``). CONTRIBUTING.md has the same list.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import re
import signal
import stat
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import IO, BinaryIO

from aomc_sky.errors import OutputError

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
    """``os.open`` for bytes, which never waits.

    Without `follow_links` OSError for a symbolic link, and FileKindError to write into a file that has a second name. A
    system without O_NOFOLLOW checks for a link first, and follows one that appears after that.
    """
    if not follow_links and not _NO_LINK and os.path.islink(path):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path))
    handle = os.open(path, access | _PLAIN | (0 if follow_links else _NO_LINK), 0o666)
    if not follow_links and access & (os.O_WRONLY | os.O_RDWR) and os.fstat(handle).st_nlink > 1:
        os.close(handle)
        raise FileKindError(path, "a hard link to another file")
    return handle


# Only regular files are opened for reading. A pipe, a terminal or a device could block or never end, and each input is
# read twice, the second time for its hash. The path ``/dev/stdin`` is fine if the shell opened a regular file for it
# (``< scene/skydist.inp``).
_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFLNK: "a symbolic link",
}


class FileKindError(OSError):
    """The path is not a regular file; `kind` names it: ``a pipe``, ``a folder``."""

    def __init__(self, path: str | Path, kind: str) -> None:
        self.kind, self.reason = kind, f"this is {kind}" + ", not a regular file" * ("link to" not in kind)
        super().__init__(errno.EINVAL, self.reason, os.fspath(path))


def regular_status(path: str | Path, *, follow_links: bool = True) -> os.stat_result:
    """Look at a file without opening it; FileKindError for anything but a regular file.

    Without `follow_links` a symbolic link is refused too. That is for names inside our own folders, never for a path of
    the user.
    """
    try:
        status = os.stat(path, follow_symlinks=follow_links)
    except ValueError as error:
        raise OSError(errno.EINVAL, f"no file can have this name ({error})", repr(path)) from error
    _require_regular(path, status)
    return status


def open_regular(path: str | Path, *, follow_links: bool = True) -> io.BufferedReader:
    """Open a regular file for reading, without ever waiting. See `regular_status`."""
    regular_status(path, follow_links=follow_links)  # first: opening a device may do something
    handle = open_handle(path, os.O_RDONLY, follow_links=follow_links)
    try:
        _require_regular(path, os.fstat(handle))  # and again: another file may have taken the name
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def read_regular(path: str | Path, max_bytes: int, *, follow_links: bool = True) -> bytes:
    """Read a whole regular file, OSError for more than `max_bytes` actual bytes; see `regular_status`."""
    with open_regular(path, follow_links=follow_links) as file:
        data = file.read(max_bytes + 1) if os.fstat(file.fileno()).st_size <= max_bytes else None
    if data is None or len(data) > max_bytes:
        raise OSError(errno.EFBIG, f"the file is larger than {max_bytes} bytes", os.fspath(path))
    return data


def _require_regular(path: str | Path, status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise FileKindError(path, _KINDS.get(stat.S_IFMT(status.st_mode), "something else"))


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


# files that appear under their names when they are complete, and what killed processes left of them

_BEGIN = ".aomc-sky-"
_UNFINISHED = re.compile(r"\.aomc-sky-(.+)\.[0-9a-f]{8}", re.DOTALL)
"""Names of unfinished files: the name that they will have, and eight random hexadecimal digits."""


@contextlib.contextmanager
def appearing(target: Path) -> Iterator[BinaryIO]:
    """Open a file that gets the name `target` if the block ends without an error, and is removed otherwise.

    It is locked while it is written, so that `prepare_target` of another process leaves it alone. OutputError where the
    system refuses to write it.
    """
    try:
        file, unfinished, has_lock = _new_file(target)
        try:
            with file:
                yield file
                file.flush()
                os.fsync(file.fileno())
                if not has_lock:
                    file.close()  # a system without locks does not rename a file that is open
                os.replace(unfinished, target)
            sync_folder(target.parent)
        finally:
            with contextlib.suppress(OSError):
                unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {target}: {error.strerror or error}") from error


def write_whole(target: Path, data: bytes) -> None:
    """Write a file that appears when it is complete, as `appearing` does."""
    with appearing(target) as file:
        file.write(data)


def _new_file(target: Path) -> tuple[BinaryIO, Path, bool]:
    """An unfinished file, open, and whether it is locked."""
    while True:
        unfinished = target.with_name(f"{_BEGIN}{target.name}.{os.urandom(4).hex()}")
        file = open(unfinished, "xb")  # noqa: SIM115 - the caller closes it
        has_lock = _lock(file.fileno())
        if has_lock is None or (has_lock and unfinished.exists()):
            return file, unfinished, has_lock is not None
        file.close()  # another process took it for a leftover between the two calls


def _lock(handle: int) -> bool | None:
    """Whether this process has the lock of a file now; None where the system or the file system knows no locks."""
    try:
        flock(handle, EXCLUSIVE | NON_BLOCKING)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def prepare_target(target: Path) -> None:
    """Remove unfinished files of a name that no process writes, nothing where there are no locks.

    OutputError for a device or a pipe, which a file would replace.
    """
    if "\0" in str(target):
        raise OutputError(f"cannot write {str(target)!r}: no file can have this name (embedded null byte)")
    if os.path.lexists(target) and not (target.is_symlink() or target.is_file() or target.is_dir()):
        raise OutputError(f"cannot write {target}: this is a device or a pipe")
    drop_leftovers(target.parent, lambda name: name == target.name)


def drop_leftovers(folder: Path, is_meant: Callable[[str], bool]) -> None:
    """Remove the unfinished files of these names that no process writes, nothing where there are no locks."""
    with contextlib.suppress(OSError):
        found = [(folder / name, _UNFINISHED.fullmatch(name)) for name in os.listdir(folder)]
        for path in [path for path, match in found if match is not None and is_meant(match[1])]:
            with contextlib.suppress(OSError):
                handle = open_handle(path, os.O_RDWR, follow_links=False)
                try:
                    if _lock(handle):
                        path.unlink()
                finally:
                    os.close(handle)


# processes


def n_cpus() -> int:
    """CPUs this process may use; all of the machine if the system does not say."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def signal_pipe() -> tuple[int, int] | None:
    """Both ends of a pipe into which signals write without waiting; None where `select` hears sockets alone."""
    if sys.platform == "win32":
        return None
    heard, told = os.pipe()
    os.set_blocking(told, False)
    return heard, told


_tidying = 0
_listeners: list[Callable[[], None]] = []


@contextlib.contextmanager
def deafness_told(listen: Callable[[], None]) -> Iterator[None]:
    """Within the block, call `listen` before each `interrupts_held`."""
    _listeners.append(listen)
    try:
        yield
    finally:
        _listeners.remove(listen)


@contextlib.contextmanager
def tidying() -> Iterator[None]:
    """While the block runs, the process must not end at once: it has processes of its own to end."""
    global _tidying  # noqa: PLW0603
    _tidying += 1
    try:
        yield
    finally:
        _tidying -= 1


def is_tidying() -> bool:
    """Whether a `tidying` block runs."""
    return _tidying > 0


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Let Ctrl-C wait until the block has ended; other threads than the main one never see it."""
    for listen in _listeners:
        listen()
    pressed: list[tuple[int, FrameType | None]] = []
    before = signal.getsignal(signal.SIGINT)
    is_held = callable(before) and threading.current_thread() is threading.main_thread()
    if is_held:
        signal.signal(signal.SIGINT, lambda *given: pressed.append(given))
    try:
        yield
    finally:
        if is_held:
            signal.signal(signal.SIGINT, before)
            if pressed and callable(before):
                before(*pressed[0])


# the C library


def has_linux_sse_state() -> bool:
    """Whether floating-point states are those of Linux on x86-64, which end with the control word of SSE."""
    return sys.platform == "linux" and os.uname().machine == "x86_64"
