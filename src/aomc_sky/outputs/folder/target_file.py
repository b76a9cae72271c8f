"""Files and folders that a user names for output: what is there already is replaced only where we wrote it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable
from pathlib import Path

from aomc_sky.errors import ForeignOutputError, UsageError
from aomc_sky.outputs.counts import COLUMNS
from aomc_sky.system import open_regular

SOFTWARE = "aomc-sky"
"""Stands in every picture and dataset of ours, so that the next command knows them."""

_LOOKED_AT = 1 << 16
_ALLOWED_INP = "skydist.inp"
_INPUT_SUFFIXES = (".inp", ".toml", ".atmo", ".epw", ".tm2", ".tmy3", ".py", ".c", ".f90")
_PICTURES = (
    (b"\x89PNG\r\n", b"Software\0aomc-sky"),
    (b"<?xml", b"<dc:title>aomc-sky</dc:title>"),
    (b"%PDF-", b"/Creator (aomc-sky)"),
    (b"\x89HDF\r\n", b"aomc-sky "),
)
"""How a file begins, and what is near its beginning or its end where it is ours."""


def check_target(
    path: str | Path, option: str, *, force: bool, inputs: Iterable[object] = (), head: str = "", is_copy: bool = False
) -> None:
    """Raise where writing a file would replace something that is not ours.

    `option` names the file, for messages. `force` replaces files of others too, but never one of `inputs`, which the
    command reads, nor one that a scene is made of, unless what is written `is_copy` of an input. `head` is how a
    text of ours begins that this module does not know.
    """
    target = Path(path)
    if not os.fspath(path):
        raise UsageError(f"{option} is empty; name a file")
    try:
        status = os.stat(target)
    except (OSError, ValueError):
        return  # nothing there, or whoever writes says what is wrong
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
    """Whether we wrote a table, a picture or a dataset, by what is near its beginning and its end."""
    try:
        with open_regular(path) as file:
            first = file.read(_LOOKED_AT)
            file.seek(max(os.fstat(file.fileno()).st_size - _LOOKED_AT, 0))
            last = file.read(_LOOKED_AT)
    except OSError:
        return False
    if not first or any(first.startswith(start) and mark in first + last for start, mark in _PICTURES):
        return True
    if first.startswith(tuple(text.encode() for text in (COLUMNS, head) if text)):
        return True
    return last.rstrip(b"\n").rpartition(b"\n")[2].startswith(b"# aomc-sky bins=")


def check_folder(path: str | Path, option: str, *, scene: str | Path | None = None) -> None:
    """Raise a UsageError for an output folder without a name, or that is the folder of the scene."""
    instead = "aomc-sky-out"
    if not os.fspath(path):
        raise UsageError(f"{option} is empty, which means the current folder; name a folder, for example {instead}")
    try:
        is_scene = scene is not None and os.path.samefile(path, scene)
    except (OSError, ValueError):
        return  # there is no such folder yet
    if is_scene:
        raise UsageError(f"{option} {path} is the folder of the scene itself; write {option} {Path(path) / instead}")
