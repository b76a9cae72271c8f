"""Files that appear under their names when they are complete, and what killed processes left of them."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

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

    It is locked while it is written, so that `remove_leftovers` of another process leaves it alone.
    """
    unfinished = target.with_name(f"{_BEGIN}{target.name}.{os.urandom(4).hex()}")
    try:
        with open(unfinished, "xb") as file:
            is_locked = _lock(file.fileno())
            yield file
            file.flush()
            os.fsync(file.fileno())
            if not is_locked:
                file.close()  # a system without locks does not rename a file that is open
            os.replace(unfinished, target)
        sync_folder(target.parent)
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink(missing_ok=True)


def _lock(handle: int) -> bool:
    """Whether this process has the lock of a file now; never where the system or the file system knows no locks."""
    try:
        flock(handle, EXCLUSIVE | NON_BLOCKING)
    except OSError:
        return False
    return True


def remove_leftovers(target: Path) -> None:
    """Remove unfinished files of this name that no process writes; nothing where there are no locks."""
    with contextlib.suppress(OSError):
        for name in os.listdir(target.parent):
            found = _UNFINISHED.fullmatch(name)
            if found is not None and found[1] == target.name:
                handle = open_handle(target.parent / name, os.O_RDWR, follow_links=False)
                try:
                    if _lock(handle):
                        (target.parent / name).unlink()
                finally:
                    os.close(handle)
