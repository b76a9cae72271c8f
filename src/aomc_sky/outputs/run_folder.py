"""A run folder: layout, atomic files, resume. The only place of a run with operating-system calls."""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from aomc_sky.errors import AomcSkyError, ForeignOutputError, OutputError
from aomc_sky.source.plan import Plan

PLAN = "plan.npz"
MANIFEST = "manifest.json"
_TEMPORARY = ".aomc-sky-"


def _os_error(action: str, path: Path, error: OSError) -> OutputError:
    return OutputError(f"cannot {action} {path}: {error.strerror or error}")


class RunFolder:
    """A folder that holds the files of one plan.

    Parameters
    ----------
    path : Path
        The folder; created when a run claims it.

    Notes
    -----
    A file appears under its final name only when it is complete and on the disk. The manifest comes
    last, so a folder without one is not a finished run.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)

    def claim(self, plan: Plan, *, force: bool) -> None:
        """Create the folder and write the plan, or make sure that the one there is the same.

        Raises
        ------
        ForeignOutputError
            The folder holds another plan and `force` is off.
        OutputError
            The operating system refuses.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _os_error("create the folder", self.path, error) from error
        self._remove_leftovers()
        found = self._stored_hash()
        if found is not None and found != plan.sha256:
            if not force:
                raise ForeignOutputError(
                    f"{self.path} holds another run (another scene, seed or options); "
                    "choose another --out, or write --force to replace it"
                )
            self._remove_all()
        elif force:
            self._remove_all()
        if not (self.path / PLAN).exists():
            self.write(PLAN, plan.to_bytes())

    def _stored_hash(self) -> str | None:
        target = self.path / PLAN
        if not target.exists():
            if (self.path / MANIFEST).exists():
                raise ForeignOutputError(f"{self.path} holds a {MANIFEST} but no {PLAN}; it is not a run of ours")
            return None
        try:
            return Plan.load(target).sha256
        except AomcSkyError as error:
            return f"unreadable: {error}"

    def _remove_leftovers(self) -> None:
        """Remove temporary files of a run that was killed."""
        for leftover in self._names(_TEMPORARY):
            (self.path / leftover).unlink(missing_ok=True)

    def _names(self, prefix: str) -> list[str]:
        try:
            return [entry.name for entry in os.scandir(self.path) if entry.name.startswith(prefix)]
        except OSError as error:
            raise _os_error("list", self.path, error) from error

    def _remove_all(self) -> None:
        """Remove the files of a run, the manifest first and the plan last."""
        known = ("manifest.json", "counts.", "photons-", "positions-", "weights-", PLAN)
        try:
            for prefix in known:
                for name in self._names(prefix):
                    (self.path / name).unlink()
        except OSError as error:
            raise _os_error("replace the run in", self.path, error) from error

    def size_of(self, name: str) -> int | None:
        """Size of a finished file, None if there is none."""
        try:
            return (self.path / name).stat().st_size
        except OSError:
            return None

    def sha256_of(self, name: str) -> str:
        """SHA-256 of a finished file."""
        digest = hashlib.sha256()
        try:
            with open(self.path / name, "rb") as file:
                while piece := file.read(1 << 20):
                    digest.update(piece)
        except OSError as error:
            raise _os_error("read", self.path / name, error) from error
        return digest.hexdigest()

    def write(self, name: str, data: bytes) -> None:
        """Write a whole file atomically."""
        with self.stream(name) as file:
            file.write(data)

    @contextlib.contextmanager
    def stream(self, name: str) -> Iterator[BinaryIO]:
        """Open a file that gets its final name when the block ends without an error, else vanishes."""
        target = self.path / name
        temporary = self.path / f"{_TEMPORARY}{name}.{secrets.token_hex(4)}"
        try:
            with open(temporary, "xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, target)
            self._sync_folder()
        except OSError as error:
            raise _os_error("write", target, error) from error
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)

    def _sync_folder(self) -> None:
        handle = os.open(self.path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
