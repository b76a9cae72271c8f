"""The folder of one plan: it is claimed, its files appear when they are complete, and only ours are removed."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import shutil
import zipfile
from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np

from aomc_sky.errors import AomcSkyError, ForeignOutputError, InputFileError, OutputError
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.folder.lock import folder_held
from aomc_sky.outputs.manifest import load_manifest
from aomc_sky.outputs.shard import (
    BEGINNINGS,
    MANIFEST,
    PART,
    PLAN,
    TEMPORARY,
    WHOLE_RUN,
    Shard,
    is_run_file,
    is_temporary_file,
    removal_order,
    shard_of_file,
    shard_of_manifest,
)
from aomc_sky.regular_file import FileKindError, open_regular, regular_status, require_one_name
from aomc_sky.source.plan.plan import Plan
from aomc_sky.system import EXCLUSIVE, NON_BLOCKING, bytes_on_disk, flock, open_handle, sync_file, sync_folder

_FEWER_FILES = "--format none writes counts and plan only, from which any photon can be made"

_MAX_OPTIONS_BYTES = 1 << 20
_SCHEMAS = {True: ("manifest.schema.json",), False: ("shard_manifest.schema.json",)}


def os_error(action: str, path: Path, error: OSError) -> OutputError:
    """The error that says what could not be done with which file, and why."""
    return OutputError(f"cannot {action} {path}: {error.strerror or error}")


def create_folder(path: Path) -> None:
    """Create a folder and those above it, where they are missing."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise os_error("create the folder", path, error) from error


class AnyPlan(Protocol):
    """The plan of a run."""

    @property
    def sha256(self) -> str:
        """What names the plan."""

    def to_bytes(self) -> bytes:
        """The file of the plan."""


class RunFolder:
    """A folder that holds the files of one plan; created when a run claims it.

    A file appears under its final name only when it is complete and on the disk. The manifest comes
    last, so a folder without one is not a finished run. Shards of one plan share a folder; no process
    touches the files of another shard.
    """

    _what, _another = "a run", "another run (another scene, seed or options)"
    _load: Callable[[Path], AnyPlan] = Plan.load  #: reads the plan of such a folder

    def __init__(self, path: Path) -> None:
        self.path = Path(path)

    @contextlib.contextmanager
    def held(self, plan: AnyPlan, *, force: bool, shard: Shard = WHOLE_RUN) -> Iterator[None]:
        """Hold the folder for a plan while the block runs, and `claim` it; processes of one plan share it.

        OutputError where another plan holds it, or `force` would remove files that others of this plan are making.
        """
        create_folder(self.path)
        claim = partial(self.claim, plan, force=force, shard=shard)
        with folder_held(self.path, plan.sha256, claim, exclusive=force and not shard.is_named):
            yield

    def claim(self, plan: AnyPlan, *, force: bool, shard: Shard = WHOLE_RUN) -> None:
        """Create the folder and write the plan, or make sure that the one there is the same.

        `force` removes what is there: all files of a run of ours, or those of the one shard, which replaces no other
        plan. ForeignOutputError where the folder holds another plan and `force` is off, or files under our names that
        no run of ours made.
        """
        create_folder(self.path)
        self.require_regular_files()
        self._remove_leftovers(shard)
        if force and not shard.is_named:
            self.remove_own_files()
        else:
            advice = "" if shard.is_named else ", or add --force to replace it"
            self._refuse_foreign(plan, f"choose another --out{advice}")
        if force and shard.is_named:
            self._remove_shard(shard)
        if self.size_of(PLAN) is None:
            self.write(PLAN, plan.to_bytes())

    def _refuse_foreign(self, plan: AnyPlan, advice: str) -> None:
        """Raise unless the folder holds this plan or nothing that would be replaced."""
        taken = self._taken()
        if self.size_of(PLAN) is None:
            # a plan is written first and was looked for last: such names without one are somebody else's
            if taken is not None:
                raise ForeignOutputError(
                    f"{self.path} holds {taken} but no {PLAN}, so it is not {self._what} of aomc-sky; {advice}"
                )
            return
        try:
            same = self._load(self.path / PLAN).sha256 == plan.sha256
        except AomcSkyError as error:
            raise ForeignOutputError(f"{error}; {advice}") from error
        if not same:
            raise ForeignOutputError(f"{self.path} holds {self._another}; {advice}")

    def _taken(self) -> str | None:
        """A file that a run would replace."""
        return next(filter(is_run_file, sorted(self.names(*BEGINNINGS))), None)

    def require_regular_files(self) -> None:
        """Raise (E961) where a name of ours is that of a link, a pipe or another thing that is no regular file."""
        # the folder says itself what is no file: each of a thousand shards would ask for the files of all
        try:
            with os.scandir(self.path) as entries:
                odd = [entry.name for entry in entries if not entry.is_file(follow_symlinks=False)]
        except (FileNotFoundError, NotADirectoryError):
            return
        except OSError as error:
            raise os_error("list", self.path, error) from error
        for name in sorted(filter(is_run_file, odd)):
            try:
                regular_status(self.path / name, follow_links=False)
            except FileKindError as error:
                advice = "remove it, or name another folder"
                raise refuse(self.path / name, error.reason, code="E961", advice=advice) from None
            except OSError:
                continue  # gone in the meantime

    def _remove_leftovers(self, shard: Shard = WHOLE_RUN) -> None:
        """Remove temporary files of a run that was killed, but not those of one that is alive or of another shard."""
        for leftover in filter(is_temporary_file, self.names(TEMPORARY)):
            if shard.is_named and f"{shard.suffix}." not in leftover:
                continue
            # a file that cannot be opened or removed does no harm: its name is never used again
            with contextlib.suppress(OSError), open_regular(self.path / leftover, follow_links=False) as file:
                flock(file, EXCLUSIVE | NON_BLOCKING)
                (self.path / leftover).unlink(missing_ok=True)

    def names(self, *beginnings: str) -> list[str]:
        """Names in the folder that begin so, in any order."""
        try:
            return [name for name in os.listdir(self.path) if name.startswith(beginnings)]
        except OSError as error:
            raise os_error("list", self.path, error) from error

    def finished_shards(self) -> list[Shard]:
        """Shards whose manifests are here, in order; nothing of them is read."""
        shards = (shard_of_manifest(name) for name in self.names("manifest.k"))
        return sorted((shard for shard in shards if shard is not None), key=lambda shard: (shard.count, shard.index))

    def remove_own_files(self) -> None:
        """Remove the files of a run, the manifest first and the plan last.

        ForeignOutputError, and nothing is removed, where files under names of ours were made by no run of ours.
        """
        names = sorted(filter(is_run_file, self.names(*BEGINNINGS)), key=removal_order)
        foreign = set(names) - own_files(self.path, names)
        if foreign:
            raise ForeignOutputError(
                f"{self.path / min(foreign)} was not made by aomc-sky, so --force does not remove it; choose "
                "another --out, or move the file away"
            )
        for name in names:
            self.remove(name)

    def _remove_shard(self, shard: Shard) -> None:
        """Remove the files of one shard, its manifest first."""
        for name in sorted(self.names(*BEGINNINGS), key=removal_order):
            if shard_of_file(name) == shard:
                self.remove(name)

    def remove(self, name: str) -> None:
        """Remove a finished file, if it is there."""
        try:
            (self.path / name).unlink(missing_ok=True)
            sync_folder(self.path)
        except OSError as error:
            raise os_error("replace", self.path / name, error) from error

    @contextlib.contextmanager
    def removed_on_failure(self) -> Iterator[None]:
        """When the block fails before it finished a file, take the plan and the folders away that it made."""
        had_plan = self.size_of(PLAN) is not None
        made = [path for path in (self.path, *self.path.parents) if not os.path.lexists(path)]
        try:
            yield
        except BaseException:
            with contextlib.suppress(OSError, OutputError):  # the failure counts, and a folder that holds more stays
                if not had_plan and self.names(*BEGINNINGS, TEMPORARY) == [PLAN]:
                    self.remove(PLAN)
                for path in made:
                    path.rmdir()
            raise

    def remove_parts(self) -> None:
        """Remove what a run that is finished now needed on its way, and what processes left there that died."""
        self._remove_leftovers()
        for name in self.names(*BEGINNINGS):
            if PART in name and is_run_file(name):
                self.remove(name)

    def reserve(self, name: str, head: bytes, size: int) -> None:
        """Make a file of this length that begins so and holds nothing else yet. [bytes]"""
        with self.stream(name) as file:
            file.write(head)
            file.truncate(size)

    @contextlib.contextmanager
    def filling(self, name: str) -> Iterator[int]:
        """Open a file that is reserved; what was written at any offset of its descriptor is on the disk in the end."""
        try:
            handle = open_handle(self.path / name, os.O_WRONLY, follow_links=False)
            try:
                require_one_name(handle)
                yield handle
                sync_file(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise os_error("write", self.path / name, error) from error

    def finish(self, part: str, name: str) -> None:
        """Give a file that is filled its final name."""
        try:
            os.replace(self.path / part, self.path / name)
            sync_folder(self.path)
        except OSError as error:
            raise os_error("write", self.path / name, error) from error

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

    def n_bytes_on_disk(self, name: str) -> int:
        """What a file takes on the disk, 0 if there is none. [bytes]"""
        try:
            return bytes_on_disk(regular_status(self.path / name, follow_links=False))
        except OSError:
            return 0

    def size_of(self, name: str) -> int | None:
        """Size of a finished file, None if there is none; a link or a pipe is none."""
        try:
            return regular_status(self.path / name, follow_links=False).st_size
        except OSError:
            return None

    def has_one_name(self, name: str) -> bool:
        """Whether a file has this name and no other, so that changing it changes this folder alone."""
        try:
            return regular_status(self.path / name, follow_links=False).st_nlink == 1
        except OSError:
            return False

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
        return self.size_of(name) == size and self.head_of(name, len(head)) == head

    def head_of(self, name: str, n_bytes: int) -> bytes:
        """The first bytes of a finished file."""
        with self.reading(name) as file:
            return file.read(n_bytes)

    def sha256_of(self, name: str) -> str:
        """SHA-256 of a finished file."""
        digest = hashlib.sha256()
        with self.reading(name) as file:
            while piece := file.read(1 << 20):
                digest.update(piece)
        return digest.hexdigest()

    def entry_of(self, name: str) -> dict[str, Any]:
        """What a manifest says of a finished file: its length and its SHA-256."""
        return {"bytes": self.size_of(name), "sha256": self.sha256_of(name)}

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
            with self._held(temporary) as file:
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

    @staticmethod
    def _held(temporary: Path) -> BinaryIO:
        """Create a temporary file and lock it, so that no other process takes it for that of a dead run."""
        while True:
            file = open(temporary, "xb")  # noqa: SIM115
            with contextlib.suppress(OSError):  # not every network file system knows locks
                flock(file, EXCLUSIVE)
            if temporary.exists():
                return file
            file.close()  # removed by a process that saw it before the lock stood


def own_files(folder: Path, names: Collection[str]) -> set[str]:
    """The names that a run of ours made, among names that are known to be of the kind of ours.

    All of them beside a plan of ours, of whatever version of the package; without one, those that a complete
    manifest lists, that manifest, and a plan that is damaged.
    """
    if PLAN in names and is_our_plan(folder / PLAN):
        return set(names)
    ours = {PLAN} if _is_cut_archive(folder / PLAN) else set()
    for name in names:
        if name.startswith("manifest."):
            listed = _listed(folder / name)
            ours |= listed and {name, *listed}
    return ours & set(names)


def is_our_plan(path: Path) -> bool:
    """Whether a file is a plan of ours, of whatever version, complete or not."""
    try:
        with open_regular(path, follow_links=False) as file, zipfile.ZipFile(file) as members:
            if members.getinfo("options.npy").file_size > _MAX_OPTIONS_BYTES:
                return False
            data = members.read("options.npy")
        text = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False).tobytes()
        return str(json.loads(text)["stream"]).startswith("aomc-sky")
    except Exception:  # zipfile, zlib, numpy and json each have their own
        return False


def _is_cut_archive(path: Path) -> bool:
    """Whether a file begins like an archive and is none: what a failing disk makes of a plan, and nobody by hand."""
    try:
        with open_regular(path, follow_links=False) as file:
            return file.read(2) == b"PK" and not zipfile.is_zipfile(file)
    except OSError:
        return False


def _listed(manifest: Path) -> set[str]:
    """Files that a manifest lists, none where it is no manifest of ours."""
    for schema in _SCHEMAS[manifest.name == MANIFEST]:
        try:
            return set(load_manifest(manifest, schema)["files"])
        except InputFileError:
            continue
    return set()
