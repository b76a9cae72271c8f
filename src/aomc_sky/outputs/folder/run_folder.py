"""The folder of one plan: it is claimed, its files appear when they are complete, and only ours are removed."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np

from aomc_sky.errors import AomcSkyError, ForeignOutputError, OutputError, UsageError
from aomc_sky.outputs.folder.lock import folder_held
from aomc_sky.outputs.shard import MANIFEST, PART, PLAN, TEMPORARY, is_run_file, is_temporary_file
from aomc_sky.regular_file import open_regular, regular_status
from aomc_sky.source.plan.plan import Plan
from aomc_sky.system import open_handle, sync_file, sync_folder, write_at

_FEWER_FILES = "--format none writes counts and plan only, from which any photon can be made"


def os_error(action: str, path: Path, error: OSError) -> OutputError:
    """The error that says what could not be done with which file, and why."""
    return OutputError(f"cannot {action} {path}: {error.strerror or error}")


def create_folder(path: Path) -> None:
    """Create a folder and those above it, where they are missing."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise os_error("create the folder", path, error) from error


class RunFolder:
    """A folder that holds the files of one plan; created when a run claims it.

    A file appears under its final name only when it is complete and on the disk. The manifest comes last, so a folder
    without one is not a finished run. No name that a file holds is ever used: names follow from plan and options.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)

    @contextlib.contextmanager
    def held(self, plan: Plan, *, force: bool = False, tidy: Callable[[], None] | None = None) -> Iterator[None]:
        """Hold the folder for a plan while the block runs; processes of one plan share it.

        The folder must be empty or hold a run of ours. `force` replaces that run, whatever its plan. `tidy` is called
        while no other process is in the folder. OutputError where another plan holds it, ForeignOutputError where it
        holds another run, UsageError where it holds files that no run of ours wrote.
        """
        create_folder(self.path)
        claim = partial(self._claim, plan, force, tidy)
        with folder_held(self.path, plan.sha256, claim, is_alone=force):
            yield

    @contextlib.contextmanager
    def joined(self, plan_sha256: str) -> Iterator[None]:
        """Hold the folder together with the process that gives this one work; OutputError where there is none."""

        def refuse(is_alone: bool) -> None:
            if is_alone:
                raise OutputError(f"{self.path}: the run of this task has ended")

        with folder_held(self.path, plan_sha256, refuse):
            yield

    def _claim(self, plan: Plan, force: bool, tidy: Callable[[], None] | None, is_alone: bool) -> None:
        """Write the plan, or make sure that the one there is the same."""
        names = self.names()
        visible = sorted(name for name in names if not name.startswith("."))
        if self.size_of(PLAN) is None and visible:
            raise UsageError(
                f"{self.path} holds {visible[0]}, which no run of aomc-sky wrote there; "
                f"write --out {self.path / 'aomc-sky-out'}"
            )
        if self.size_of(PLAN) is not None and self._settle(plan, force):
            for name in sorted(filter(is_run_file, names), key=lambda name: (name != MANIFEST, name == PLAN)):
                self.remove(name)
        if self.size_of(PLAN) is None:
            self.write(PLAN, plan.to_bytes())
        if is_alone:
            for name in names:
                if is_temporary_file(name):  # of a run that was killed
                    self.remove(name)
            if tidy is not None:
                tidy()

    def _settle(self, plan: Plan, force: bool) -> bool:
        """Whether the run in the folder is to be replaced; raise where it is another one and may not be."""
        if force:
            if not _is_our_plan(self.path / PLAN):
                raise UsageError(
                    f"{self.path / PLAN} is no plan of aomc-sky, so --force keeps it; choose another --out"
                )
            return True
        advice = "choose another --out, or add --force to replace it"
        try:
            is_same = Plan.load(self.path / PLAN).sha256 == plan.sha256
        except AomcSkyError as error:
            raise ForeignOutputError(f"{error}; {advice}") from error
        if not is_same:
            raise ForeignOutputError(f"{self.path} holds another run (another scene, seed or options); {advice}")
        return False

    def names(self) -> list[str]:
        """Names in the folder, in any order."""
        try:
            return os.listdir(self.path)
        except OSError as error:
            raise os_error("list", self.path, error) from error

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        try:
            (self.path / name).unlink(missing_ok=True)
            sync_folder(self.path)
        except OSError as error:
            raise os_error("remove", self.path / name, error) from error

    def require_space(self, n_bytes: int, advice: str = _FEWER_FILES) -> None:
        """Raise before anything is written when the disk cannot hold that much more. [bytes]"""
        try:
            free = shutil.disk_usage(self.path).free
        except OSError as error:
            raise os_error("write to", self.path, error) from error
        if n_bytes > free:
            raise OutputError(
                f"cannot write {self.path}: {n_bytes / 1e9:.3g} GB are needed and {free / 1e9:.3g} GB are free; "
                f"{advice}"
            )

    def size_of(self, name: str) -> int | None:
        """Size of a file, None if there is none; a link or a pipe is none. [bytes]"""
        try:
            return regular_status(self.path / name, follow_links=False).st_size
        except OSError:
            return None

    @contextlib.contextmanager
    def reading(self, name: str) -> Iterator[BinaryIO]:
        """Open a finished file for reading."""
        try:
            with open_regular(self.path / name, follow_links=False) as file:
                yield file
        except OSError as error:
            raise os_error("read", self.path / name, error) from error

    def holds(self, name: str, head: bytes, size: int) -> bool:
        """Whether a finished file is there that begins so and has this length. [bytes]"""
        if self.size_of(name) != size:
            return False
        with self.reading(name) as file:
            return file.read(len(head)) == head

    def write(self, name: str, data: bytes) -> None:
        """Write a file atomically."""
        with self.stream(name) as file:
            file.write(data)

    @contextlib.contextmanager
    def stream(self, name: str) -> Iterator[BinaryIO]:
        """Open a file that gets its final name when the block ends without an error, else vanishes."""
        target = self.path / name
        temporary = self.path / f"{TEMPORARY}{name}.{os.urandom(4).hex()}"
        try:
            with open(temporary, "xb") as file:
                yield file
                file.flush()
                sync_file(file.fileno())
            os.replace(temporary, target)
            sync_folder(self.path)
        except OSError as error:
            raise os_error("write", target, error) from error
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)

    def reserve(self, name: str, head: bytes, size: int) -> None:
        """Make the file that several processes fill; whatever the order, the same file comes of it. [bytes]"""
        try:
            handle = open_handle(self.path / (name + PART), os.O_WRONLY | os.O_CREAT, follow_links=False)
            try:
                os.ftruncate(handle, size)
                write_at(handle, head, 0)
                sync_file(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise os_error("write", self.path / (name + PART), error) from error

    @contextlib.contextmanager
    def filling(self, name: str) -> Iterator[int | None]:
        """Open a reserved file; what was written through its handle is on the disk in the end. None: it is finished."""
        path = self.path / (name + PART)
        try:
            try:
                handle = open_handle(path, os.O_WRONLY, follow_links=False)
            except FileNotFoundError:
                if self.size_of(name) is None:
                    raise
                yield None
                return
            try:
                yield handle
                sync_file(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise os_error("write", path, error) from error

    def finish(self, name: str) -> None:
        """Give a file that is filled its final name; another process may have done so already."""
        try:
            if self.size_of(name) is None:
                os.replace(self.path / (name + PART), self.path / name)
                sync_folder(self.path)
        except OSError as error:
            if self.size_of(name) is None:
                raise os_error("write", self.path / name, error) from error


def _is_our_plan(path: Path) -> bool:
    """Whether a file is a plan of ours, of whatever version of the package."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return str(json.loads(stored["options"].tobytes())["stream"]).startswith("aomc-sky")
    except Exception:  # zipfile, zlib, numpy and json each have their own
        return False
