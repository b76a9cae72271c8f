"""The folder of one run: the names of its files, its lock, and its files, which appear when they are complete.

`check_target` and `check_folder` look at other files and folders that a user names: only files that aomc-sky wrote are
replaced.
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import random
import re
import shutil
import stat
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np

from aomc_sky.errors import AomcSkyError, ForeignOutputError, OutputError, UsageError
from aomc_sky.outputs.counts import table_version
from aomc_sky.outputs.photon_formats import WAVEBAND, formats_of
from aomc_sky.plan.plan import Plan
from aomc_sky.system import (
    EXCLUSIVE,
    HAS_LOCKS,
    NON_BLOCKING,
    SHARED,
    drop_leftovers,
    flock,
    open_handle,
    open_regular,
    read_at,
    sync_folder,
    write_at,
    write_whole,
)

PLAN = "plan.npz"
MANIFEST = "manifest.json"
PART = ".part"
"""Ending of the names of files that several processes fill."""

_OTHERS = re.compile(
    rf"plan\.npz|manifest\.json|counts\.(?:csv|npz)|source\.sky|shard-[0-9]{{1,7}}-of-[0-9]{{1,7}}\.done|blocks-{WAVEBAND}\.npy"
)
"""Files that hold no photons; the last is of version 0.2."""


def run_files_among(names: Iterable[str]) -> set[str]:
    """Those of these names that a file of a run has."""
    given = {*names}
    others = {name for name in given if _OTHERS.fullmatch(name)}
    formats = formats_of(name.removesuffix(PART) for name in given - others)
    filled = {name for name, key in formats.items() if key == "npy"}  # shards are npy
    return others | {name for name in given if name in formats or name.removesuffix(PART) in filled}


def is_run_file(name: str) -> bool:
    """Whether this is the name of a file of a run."""
    return bool(run_files_among([name]))


LOCK = ".aomc-sky.lock"
"""The file that is locked while a process holds the folder. After a kill -9 it may remain, but unlocked."""

_CLAIM_S, _REFUSED_S = 60.0, 0.1
"""Longest wait for a process that removes an old run, and for one that only looks at the lock. [s]"""

_FEWER_FILES = "--format none writes counts and plan only, from which any photon can be made"


def os_error(action: str, path: Path, error: OSError) -> OutputError:
    """The error for an action on a file that the operating system refused."""
    return OutputError(f"cannot {action} {path}: {error.strerror or error}")


@contextlib.contextmanager
def _reported(action: str, path: Path) -> Iterator[None]:
    """Turn an OSError of the block into an error that names action and file."""
    try:
        yield
    except OSError as error:
        raise os_error(action, path, error) from error


def create_folder(path: Path) -> None:
    """Create a folder, and the missing folders above it."""
    with _reported("create the folder", path):
        path.mkdir(parents=True, exist_ok=True)


@contextlib.contextmanager
def folder_held(
    folder: Path, plan_sha256: str, claim: Callable[[bool], None], *, is_alone: bool = False
) -> Iterator[None]:
    """Hold a folder for a plan while the block runs; OutputError if a process with another plan holds it.

    Processes with the same plan share the folder, unless `is_alone`. The first one calls ``claim(True)``, which refuses
    the folder of another plan or writes this plan, under an exclusive lock; after that the lock is shared. The last
    process that leaves removes the file of the lock. A file system without locks gets ``claim(False)``.
    """
    handle = _held_lock(folder, plan_sha256, claim, is_alone)
    try:
        yield
    finally:
        if handle is not None:
            _leave(folder / LOCK, handle)


def _held_lock(folder: Path, plan_sha256: str, claim: Callable[[bool], None], is_alone: bool) -> int | None:
    path, began = folder / LOCK, time.monotonic()
    while HAS_LOCKS:
        with _reported("write", path):
            handle = open_handle(path, os.O_RDWR | os.O_CREAT, follow_links=False)
        is_kept = False
        try:
            how = _locked(handle)
            if how is None:
                if not os.fstat(handle).st_size:
                    path.unlink(missing_ok=True)
                break
            if how == EXCLUSIVE and _is_current(path, handle):
                claim(True)
                with _reported("write", path):
                    os.ftruncate(handle, 0)
                    write_at(handle, f"{plan_sha256} process {os.getpid()} on {platform.node()}".encode(), 0)
                    flock(handle, SHARED)  # another process may be quicker between the two locks
            plan, who = _holder(handle)
            if how and plan == plan_sha256 and _is_current(path, handle):
                if how == SHARED and is_alone:
                    raise OutputError(
                        f"{folder} is held: {who} makes the same run there, and --force would remove its files",
                        "wait until it ends, or leave out --force to share the work",
                    )
                is_kept = True
                return handle
            if time.monotonic() - began > (_REFUSED_S if how == SHARED else _CLAIM_S):
                holder = f"plan {plan[:16]}, {who}" if who else "new"
                raise OutputError(
                    f"{folder} is held by another run ({holder})", "wait until it ends, or choose another --out"
                )
        finally:
            if not is_kept:
                _leave(path, handle)
        time.sleep(random.uniform(0.005, 0.02))
    claim(False)
    return None


def _locked(handle: int) -> int | None:
    """`EXCLUSIVE` or else `SHARED`, if it is free; 0 if another process has the lock alone; None without locks."""
    for how in (EXCLUSIVE, SHARED):
        try:
            flock(handle, how | NON_BLOCKING)
        except BlockingIOError:
            continue
        except OSError:  # some network file systems have no locks
            return None
        return how
    return 0


def _is_current(path: Path, handle: int) -> bool:
    """Whether an open lock is still that of the folder; a process that left may have removed it."""
    with contextlib.suppress(OSError):
        return os.path.samestat(os.fstat(handle), os.stat(path, follow_symlinks=False))
    return False


def _holder(handle: int) -> tuple[str, str]:
    """The plan, and process and host, from the text of a lock; empty for a new lock."""
    text = bytearray(400)
    plan, _, who = ascii(text[: read_at(handle, text, 0)].decode("ascii", "replace"))[1:-1].partition(" ")
    return plan, who


def _leave(path: Path, handle: int) -> None:
    """Close a lock, and remove its file if no other process has it."""
    with contextlib.suppress(OSError):
        flock(handle, EXCLUSIVE | NON_BLOCKING)
        if _is_current(path, handle):
            path.unlink()
    os.close(handle)


class RunFolder:
    """A folder that holds the files of one plan; created when a run claims it.

    A file gets its final name when it is complete and on the disk. The manifest comes last, so a folder without one is
    not a finished run. Names follow from plan and options, never from the contents of a file.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)

    @contextlib.contextmanager
    def held(
        self, plan: Plan, stated: Callable[[], dict[str, str]] | None = None, *, force: bool = False, n_bytes: int = 0
    ) -> Iterator[None]:
        """Hold the folder for a plan while the block runs; processes with the same plan share it.

        A plan that is written says what is `stated` of its scene. `force` replaces any run of ours in the folder,
        unless the disk has no space for the new `n_bytes`. OutputError without it, or if a process with another plan
        holds the folder; ForeignOutputError if it contains another run; UsageError if it contains other files.
        """
        create_folder(self.path)
        with folder_held(self.path, plan.sha256, partial(self._claim, plan, stated, force, n_bytes), is_alone=force):
            yield

    def _claim(
        self, plan: Plan, stated: Callable[[], dict[str, str]] | None, force: bool, n_bytes: int, is_alone: bool
    ) -> None:
        """Write the plan, or check that the stored plan is the same."""
        names, stored = self.names(), self.path / PLAN
        visible = sorted(name for name in names if not name.startswith("."))
        if self.size_of(PLAN) is None and visible:
            raise UsageError(
                f"{self.path} holds {visible[0]}, which no run of aomc-sky wrote there",
                f"write --out {self.path / 'aomc-sky-out'}",
            )
        if self.size_of(PLAN) is not None and not force:
            advice = "choose another --out, or add --force to replace it"
            try:
                is_same = Plan.load(stored).sha256 == plan.sha256
            except AomcSkyError as error:
                raise ForeignOutputError(f"{error}; {advice}") from error
            if not is_same:
                raise ForeignOutputError(f"{self.path} holds another run (another scene, seed or options); {advice}")
        elif self.size_of(PLAN) is not None:
            if not _is_our_plan(stored):
                raise UsageError(f"{stored} is no plan of aomc-sky, so --force keeps it", "choose another --out")
            others = run_files_among(names) - {MANIFEST, PLAN}
            self.require_space(n_bytes - sum(map(self.space_of, others)))
            for part in ([MANIFEST], sorted(others), [PLAN]):  # without its plan no file would be known as ours
                self.remove(*part)
        if self.size_of(PLAN) is None:
            self.write(PLAN, plan.to_bytes(None if stated is None else stated()))
        if is_alone:
            drop_leftovers(self.path, lambda _: True)  # of a run that was killed

    def names(self) -> list[str]:
        """Names in the folder, in any order."""
        with _reported("list", self.path):
            return os.listdir(self.path)

    def photon_names(self) -> list[str]:
        """Names in the folder that may be those of photons."""
        return [name for name in self.names() if not (name.startswith(".") or _OTHERS.fullmatch(name))]

    def remove(self, *names: str) -> None:
        """Remove files that exist. They are gone from the disk too when this returns."""
        for name in names:
            with _reported("remove", self.path / name):
                (self.path / name).unlink(missing_ok=True)
        with _reported("write to", self.path):
            sync_folder(self.path)

    def require_space(self, n_bytes: int, advice: str = _FEWER_FILES) -> None:
        """Raise if the disk has not this much space. [bytes]"""
        with _reported("write to", self.path):
            free = shutil.disk_usage(self.path).free
        if n_bytes > free:
            raise OutputError(
                f"cannot write {self.path}: {n_bytes / 1e9:.3g} GB are needed and {free / 1e9:.3g} GB are free; "
                f"{advice}"
            )

    def size_of(self, name: str) -> int | None:
        """Size of a regular file, or None for no file, a link or a pipe. [bytes]"""
        try:
            status = os.lstat(self.path / name)
        except OSError:
            return None
        return status.st_size if stat.S_ISREG(status.st_mode) else None

    def sizes_of(self, names: Iterable[str]) -> dict[str, int]:
        """`size_of` those of these files that are there. [bytes]"""
        return {name: size for name in names if (size := self.size_of(name)) is not None}

    def space_of(self, name: str) -> int:
        """Space that a file takes on the disk; 0 for no file, and where the system does not tell. [bytes]"""
        with contextlib.suppress(OSError):
            return int(getattr(os.lstat(self.path / name), "st_blocks", 0)) * 512
        return 0

    @contextlib.contextmanager
    def reading(self, name: str) -> Iterator[BinaryIO]:
        """Open a finished file for reading."""
        with _reported("read", self.path / name), open_regular(self.path / name, follow_links=False) as file:
            yield file

    def holds(self, name: str, head: bytes, size: int) -> bool:
        """Whether there is a finished file with this head and this length. [bytes]"""
        return self.size_of(name) == size and self.begins(name, head)

    def begins(self, name: str, head: bytes) -> bool:
        """Whether a finished file begins with these bytes."""
        with self.reading(name) as file:
            return file.read(len(head)) == head

    def write(self, name: str, data: bytes) -> None:
        """Write a file atomically."""
        write_whole(self.path / name, data)

    def reserve(self, name: str, head: bytes, size: int) -> None:
        """Make a file that several processes fill in any order. [bytes]"""
        with self.filling(name, os.O_WRONLY | os.O_CREAT) as handle:
            assert handle is not None, "a file that is created is there"
            os.ftruncate(handle, size)
            write_at(handle, head, 0)

    @contextlib.contextmanager
    def filling(self, name: str, access: int = os.O_WRONLY) -> Iterator[int | None]:
        """Open a reserved file, and flush it to the disk at the end. A finished file gives None."""
        path = self.path / (name + PART)
        with _reported("write", path):
            try:
                handle = open_handle(path, access, follow_links=False)
            except FileNotFoundError:
                if self.size_of(name) is None:
                    raise
                yield None
                return
            try:
                yield handle
                os.fsync(handle)
            finally:
                os.close(handle)

    def finish(self, name: str) -> None:
        """Give a filled file its final name, unless another process has done so."""
        try:
            if self.size_of(name) is None:
                os.replace(self.path / (name + PART), self.path / name)
                sync_folder(self.path)
        except OSError as error:
            if self.size_of(name) is None:
                raise os_error("write", self.path / name, error) from error


def _is_our_plan(path: Path) -> bool:
    """Whether a file is a plan of any version of the package."""
    try:
        with open_regular(path) as file, np.load(file, allow_pickle=False) as stored:
            return str(json.loads(stored["options"].tobytes())["stream"]).startswith("aomc-sky")
    except Exception:  # zipfile, zlib, numpy and json each have their own
        return False


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
    path: str | Path, option: str, *, force: bool, inputs: Iterable[object] = (), is_copy: bool = False
) -> None:
    """Refuse to replace a file that aomc-sky did not write.

    `option` is the option that names the file. With `force`, files of others are allowed. One of `inputs`, which the
    command reads, is never allowed. A file with the ending of an input is allowed only if the output `is_copy` of one.
    """
    target = Path(path)
    if not os.fspath(path):
        raise UsageError(f"{option} is empty", "name a file")
    try:
        status = os.stat(target)
    except (OSError, ValueError):
        return  # there is no file, or the writer reports the error
    if stat.S_ISDIR(status.st_mode):
        return
    if not stat.S_ISREG(status.st_mode):
        raise UsageError(f"{option} {path} is a device or a pipe, which a file would replace", "name a file")
    own = any(os.path.exists(str(path_read)) and os.path.samefile(str(path_read), target) for path_read in inputs)
    is_input = target.suffix.lower() in _INPUT_SUFFIXES and target.name != _ALLOWED_INP and not is_copy
    if own or is_input:
        raise UsageError(
            f"{option} {path} is an input; inputs are never replaced, even with --force",
            f"name another file, for example {target.with_name(f'new-{target.name}')}",
        )
    if not force and not is_ours(target):
        raise ForeignOutputError(
            f"{path} exists and was not written by aomc-sky",
            f"give {option} another name, for example "
            f"{target.with_name(f'new-{target.name}')}, or add --force to replace it",
        )


def is_ours(path: Path, head: str = "") -> bool:
    """Whether aomc-sky wrote a table, a picture or a dataset, judged by its beginning and its end.

    The text `head` is the beginning of a text of ours that this module does not know.
    """
    try:
        with open_regular(path) as file:
            first = file.read(_LOOKED_AT)
            file.seek(max(os.fstat(file.fileno()).st_size - _LOOKED_AT, 0))
            last = file.read(_LOOKED_AT)
    except OSError:
        return False
    if not first or any(first.startswith(start) and mark in first + last for start, mark in _PICTURES):
        return True
    if table_version(first) or (head and first.startswith(head.encode())):
        return True
    return last.rstrip(b"\n").rpartition(b"\n")[2].startswith(b"# aomc-sky bins=")


def check_folder(path: str | Path, option: str, *, scene: str | Path | None = None) -> None:
    """Refuse an output folder with an empty name, and the folder of the scene."""
    instead = "aomc-sky-out"
    if not os.fspath(path):
        raise UsageError(f"{option} is empty, which means the current folder", f"name a folder, for example {instead}")
    try:
        is_scene = scene is not None and os.path.samefile(path, scene)
    except (OSError, ValueError):
        return  # there is no such folder yet
    if is_scene:
        raise UsageError(f"{option} {path} is the folder of the scene itself", f"write {option} {Path(path) / instead}")
