"""Output files and folders that a user names: only files that aomc-sky wrote are replaced."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable
from pathlib import Path

from aomc_sky.errors import ForeignOutputError, UsageError
from aomc_sky.outputs.counts import COLUMNS
from aomc_sky.system import open_regular

SOFTWARE = "aomc-sky"
"""Our name in each picture and dataset, by which the next command recognises them."""

_LOOKED_AT = 1 << 16
_ALLOWED_INP = "skydist.inp"
_INPUT_SUFFIXES = (".inp", ".toml", ".atmo", ".epw", ".tm2", ".tmy3", ".py", ".c", ".f90")
_PICTURES = (
    (b"\x89PNG\r\n", b"Software\0aomc-sky"),
    (b"<?xml", b"<dc:title>aomc-sky</dc:title>"),
    (b"%PDF-", b"/Creator (aomc-sky)"),
    (b"\x89HDF\r\n", b"aomc-sky "),
)
"""First bytes of a kind of file, and bytes near its beginning or its end if it is ours."""


def check_target(
    path: str | Path, option: str, *, force: bool, inputs: Iterable[object] = (), head: str = "", is_copy: bool = False
) -> None:
    """Refuse to replace a file that aomc-sky did not write.

    `option` is the option that names the file. With `force`, files of others are allowed. One of `inputs`, which the
    command reads, is never allowed. A file with the ending of an input is allowed only if the output `is_copy` of one.
    The text `head` is the beginning of a text of ours that this module does not know.
    """
    target = Path(path)
    if not os.fspath(path):
        raise UsageError(f"{option} is empty; name a file")
    try:
        status = os.stat(target)
    except (OSError, ValueError):
        return  # there is no file, or the writer reports the error
    if stat.S_ISDIR(status.st_mode):
        return
    if not stat.S_ISREG(status.st_mode):
        raise UsageError(f"{option} {path} is a device or a pipe, which a file would replace; name a file")
    own = any(os.path.exists(str(path_read)) and os.path.samefile(str(path_read), target) for path_read in inputs)
    is_input = target.suffix.lower() in _INPUT_SUFFIXES and target.name != _ALLOWED_INP and not is_copy
    if own or is_input:
        raise UsageError(
            f"{option} {path} is an input; inputs are never replaced, even with --force; name another file, "
            f"for example {target.with_name(f'new-{target.name}')}"
        )
    if not force and not is_ours(target, head):
        raise ForeignOutputError(
            f"{path} exists and was not written by aomc-sky; give {option} another name, for example "
            f"{target.with_name(f'new-{target.name}')}, or add --force to replace it"
        )


def is_ours(path: Path, head: str = "") -> bool:
    """Whether aomc-sky wrote a table, a picture or a dataset, judged by its beginning and its end."""
    try:
        with open_regular(path) as file:
            first = file.read(_LOOKED_AT)
            file.seek(max(os.fstat(file.fileno()).st_size - _LOOKED_AT, 0))
            last = file.read(_LOOKED_AT)
    except OSError:
        return False
    if not first or any(first.startswith(start) and mark in first + last for start, mark in _PICTURES):
        return True
    if first.startswith(COLUMNS.encode()) or (head and first.startswith(head.encode())):
        return True
    return last.rstrip(b"\n").rpartition(b"\n")[2].startswith(b"# aomc-sky bins=")


def check_folder(path: str | Path, option: str, *, scene: str | Path | None = None) -> None:
    """Refuse an output folder with an empty name, and the folder of the scene."""
    instead = "aomc-sky-out"
    if not os.fspath(path):
        raise UsageError(f"{option} is empty, which means the current folder; name a folder, for example {instead}")
    try:
        is_scene = scene is not None and os.path.samefile(path, scene)
    except (OSError, ValueError):
        return  # there is no such folder yet
    if is_scene:
        raise UsageError(f"{option} {path} is the folder of the scene itself; write {option} {Path(path) / instead}")
