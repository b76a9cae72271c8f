"""Files that appear under their names when they are complete, and what killed processes left of them."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from aomc_sky.errors import OutputError
from aomc_sky.system import EXCLUSIVE, NON_BLOCKING, flock, open_handle, sync_folder

_BEGIN = ".aomc-sky-"
_UNFINISHED = re.compile(r"\.aomc-sky-(.+)\.[0-9a-f]{8}", re.DOTALL)
"""Names of unfinished files: the name that they will have, and eight random hexadecimal digits."""


def is_unfinished(name: str) -> bool:
    """Whether this is the name of an unfinished file."""
    return _UNFINISHED.fullmatch(name) is not None


@contextlib.contextmanager
def appearing(target: Path) -> Iterator[BinaryIO]:
    """Open a file that gets the name `target` if the block ends without an error, and is removed otherwise. OSError.

    It is locked while it is written, so that `prepare_target` of another process leaves it alone.
    """
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
