"""Opening a file that a person or another file named: one way for all readers, which never hangs.

Only regular files are opened. A pipe, a terminal or a device could block or never end. Every input is also read twice,
the second time for its hash, and a pipe can be read only once. ``/dev/stdin`` is fine if the shell opened a regular
file for it (``< scene/skydist.inp``).
"""

from __future__ import annotations

import errno
import io
import os
import stat
from pathlib import Path

from aomc_sky.system import open_handle

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
        self.kind, self.reason = kind, f"this is {kind}, not a regular file"
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
