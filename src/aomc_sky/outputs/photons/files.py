"""Photon files while they are made: what a writer says of them, whether they are finished, their bytes and hashes."""

from __future__ import annotations

import contextlib
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks import WHOLE_RUN, Shard
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.source.photons import PhotonBatch

PHOTON_FORMATS = {
    "csv": "aomc_sky.outputs.photons.rows:CsvWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "raw": "aomc_sky.outputs.photons.rows:RawWriter",
}
"""Name of a photon format -> "module:Class"; "none" writes counts and plan only."""


@dataclass(frozen=True, slots=True)
class FileLayout:
    """A photon file as it is once it is complete: known before the first photon is made."""

    name: str
    head: bytes  #: what it begins with
    size: int  #: its length [bytes]


class PhotonWriter(ABC):
    """The files of a source in one format: their layouts, and the bytes of each block; it opens no file.

    `bands` are the wavebands [0-based] that share files: one of the groups that `parts` gives.
    """

    has_rows = False  #: the files hold every bit of the photons, in rows of numbers
    row_dtype: np.dtype  #: of the numbers, where there are rows
    widths: tuple[int, ...]  #: numbers of a row of each file, where there are rows
    shard: Shard = WHOLE_RUN  #: which of the photons the files hold

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: by default every one has its own."""
        return [(band,) for band in bands]

    @abstractmethod
    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files."""

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Names of the files."""
        return tuple(layout.name for layout in self.layouts(bands))

    @abstractmethod
    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file; they outlive its arrays, which are filled again."""

    def recycle(self, chunks: tuple[memoryview, ...]) -> None:  # noqa: B027
        """Take memory back whose bytes are written; by default every chunk has its own."""


def photon_writer(name: str) -> Any:
    """Return the writer class of a photon format."""
    target = PHOTON_FORMATS.get(name)
    if target is None:
        raise UsageError(f"there is no photon format {name!r}; the formats are {', '.join(PHOTON_FORMATS)} and none")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)


class PhotonFiles:
    """The files of one writer for the wavebands that share them, in the order of their photons.

    A context: the files get their names when it ends without an error, and vanish otherwise. The folder is
    looked at once, when the object is made.
    """

    def __init__(self, folder: RunFolder, writer: PhotonWriter, bands: tuple[int, ...], *, name: str = "") -> None:
        self.writer, self.bands = writer, bands
        self._folder = folder
        self.layouts = writer.layouts(bands)
        if name:  # of one file, where a user named it
            self.layouts = tuple(FileLayout(name, layout.head, layout.size) for layout in self.layouts)
        missing = [layout.size for layout in self.layouts if not folder.holds(layout.name, layout.head, layout.size)]
        self.is_finished = not missing  #: whether all files are there: names appear only when files are complete
        self.n_bytes_missing = sum(missing)  #: length of the files that are still to be made [bytes]
        self._stack = contextlib.ExitStack()
        self._streams: list[BinaryIO] = []
        self._digests: list[Any] = []

    def __enter__(self) -> PhotonFiles:
        with contextlib.ExitStack() as stack:
            self._streams = [stack.enter_context(self._folder.stream(layout.name)) for layout in self.layouts]
            self._digests = [hashlib.sha256(layout.head) for layout in self.layouts]
            for stream, layout in zip(self._streams, self.layouts, strict=True):
                stream.write(layout.head)
            self._stack = stack.pop_all()
        return self

    def write(self, chunks: Sequence[memoryview]) -> None:
        """Add what `writer.chunks` made of the next photons."""
        for layout, stream, digest, chunk in zip(self.layouts, self._streams, self._digests, chunks, strict=True):
            try:
                stream.write(chunk)
            except OSError as error:  # reported here, for other files are open around it
                raise os_error("write", self._folder.path / layout.name, error) from error
            digest.update(chunk)

    def __exit__(self, *error: Any) -> bool | None:
        self._streams = []
        return self._stack.__exit__(*error)

    def entries(self) -> dict[str, dict[str, Any]]:
        """Bytes and SHA-256 of every finished file; of files that were there before, from the disk."""
        names = [layout.name for layout in self.layouts]
        digests = [d.hexdigest() for d in self._digests] or [self._folder.sha256_of(name) for name in names]
        return {
            layout.name: {"bytes": layout.size, "sha256": digest}
            for layout, digest in zip(self.layouts, digests, strict=True)
        }


def photon_files(folder: RunFolder, writers: Sequence[PhotonWriter], bands: Sequence[int]) -> list[PhotonFiles]:
    """All photon files of a run."""
    return [PhotonFiles(folder, writer, part) for writer in writers for part in writer.parts(bands)]
