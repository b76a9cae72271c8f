"""A folder of what took long to work out, kept from one command to the next: bounded in size, and never believed.

An entry is one file under the hash of everything that it follows from. Its first line has the name of the format, that
hash and the SHA-256 of the rest. It is written under another name and renamed, so two writers do no harm: both have
the same content, and a reader sees the one or the other. A folder that cannot be written to keeps nothing.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from aomc_sky.regular_file import FileKindError, read_regular
from aomc_sky.system import belongs_to_user

MOST_BYTES = 2**28
"""Of all entries together."""

_SHARE_OF_ENTRY = 4  # an entry takes at most a quarter of all
_MAGIC = b"aomc-sky cache 1"
_SUFFIX, _UNFINISHED = ".entry", ".part"
_STALE_S = 3600.0  # what a killed writer left behind


class DamagedEntryError(Exception):
    """What stands under a key is not what was written there."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Cache:
    """Entries of one folder, which is made when the first one is written."""

    folder: Path
    most_bytes: int = MOST_BYTES

    def path(self, key: str) -> Path:
        """Where the entry of a key stands."""
        return self.folder / f"{key}{_SUFFIX}"

    def read(self, key: str) -> bytes | None:
        """The content under a key, None where there is none; DamagedEntryError for anything else than was written."""
        path = self.path(key)
        try:
            if not belongs_to_user(os.stat(self.folder)):
                return None
            data = read_regular(path, self._most_of_entry() + len(_head(key, b"")), follow_links=False)
        except OSError as error:
            if isinstance(error, FileKindError) or error.errno == errno.EFBIG:
                raise DamagedEntryError(error.strerror) from error
            return None
        with contextlib.suppress(OSError):
            os.utime(path)  # used last
        head, _, content = data.partition(b"\n")
        if head + b"\n" != _head(key, content):
            raise DamagedEntryError("its bytes have changed")
        return content

    def write(self, key: str, content: bytes) -> None:
        """Keep content under a key, in place of whatever is there; nothing where the folder or the disk forbids it."""
        if len(content) > self._most_of_entry():
            return
        temporary = ""
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not belongs_to_user(os.stat(self.folder)):
                return
            handle, temporary = tempfile.mkstemp(prefix=f"{key[:16]}-", suffix=_UNFINISHED, dir=self.folder)
            with os.fdopen(handle, "wb") as file:
                file.write(_head(key, content) + content)
            os.replace(temporary, self.path(key))
            self._prune()
        except OSError:
            with contextlib.suppress(OSError):
                if temporary:
                    os.unlink(temporary)

    def _most_of_entry(self) -> int:
        return self.most_bytes // _SHARE_OF_ENTRY

    def _prune(self) -> None:
        """Remove entries that were not used for longest until the others fit, and what killed writers left."""
        entries = []
        for item in os.scandir(self.folder):
            with contextlib.suppress(OSError):  # another process has removed it
                status = item.stat(follow_symlinks=False)
                if item.name.endswith(_SUFFIX):
                    entries.append((status.st_mtime_ns, status.st_size, item.path))
                elif item.name.endswith(_UNFINISHED) and status.st_mtime < time.time() - _STALE_S:
                    os.unlink(item.path)
        total = sum(size for _, size, _ in entries)
        for _, size, path in sorted(entries):
            if total <= self.most_bytes:
                break
            with contextlib.suppress(OSError):
                os.unlink(path)
            total -= size


def _head(key: str, content: bytes) -> bytes:
    return b"%s %s %s\n" % (_MAGIC, key.encode("ascii"), hashlib.sha256(content).hexdigest().encode("ascii"))
