"""Photon files while they are made: what a writer says of them, whether they are finished, their bytes and hashes."""

from __future__ import annotations

import contextlib
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from importlib import import_module
from typing import Any, BinaryIO

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.blocks import WHOLE, Shard
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.source.photons import PhotonBatch

PHOTON_FORMATS = {
    "csv": "aomc_sky.outputs.photons.rows:CsvWriter",
    "mcpl": "aomc_sky.outputs.photons.mcpl:McplWriter",
    "npy": "aomc_sky.outputs.photons.npy:NpyWriter",
    "raw": "aomc_sky.outputs.photons.rows:RawWriter",
}
"""Name of a photon format -> "module:Class"; "none" writes counts and plan only."""


class PhotonWriter(ABC):
    """The files of a source in one format: their names and lengths, and the bytes of each block; it opens no file.

    `bands` are the wavebands [0-based] that share files: one of the groups that `parts` gives.
    """

    has_rows = False  #: the files hold every bit of the photons, in rows of numbers
    row_dtype: np.dtype  #: of the numbers, where there are rows
    widths: tuple[int, ...]  #: numbers of a row of each file, where there are rows
    shard: Shard = WHOLE  #: which of the photons the files hold

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: by default every one has its own."""
        return [(band,) for band in bands]

    @abstractmethod
    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """Names of the files."""

    @abstractmethod
    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Bytes that each file starts with."""

    @abstractmethod
    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of each finished file. [bytes]"""

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

    A context: the files get their names when it ends without an error, and vanish otherwise.
    """

    def __init__(
        self, folder: RunFolder, writer: PhotonWriter, bands: tuple[int, ...], names: tuple[str, ...] = ()
    ) -> None:
        self.writer, self.bands = writer, bands
        self._folder = folder
        self.names = names or writer.names(bands)
        self._heads, self._sizes = writer.headers(bands), writer.sizes(bands)
        self._stack = contextlib.ExitStack()
        self._streams: list[BinaryIO] = []
        self._digests: list[Any] = []

    @property
    def is_finished(self) -> bool:
        """Whether all files are there; names appear only when files are complete."""
        return all(self._are_there())

    @property
    def n_bytes_missing(self) -> int:
        """Length of the files that are still to be made. [bytes]"""
        return sum(size for size, is_there in zip(self._sizes, self._are_there(), strict=True) if not is_there)

    def _are_there(self) -> list[bool]:
        return [self._is_there(*file) for file in zip(self.names, self._heads, self._sizes, strict=True)]

    def _is_there(self, name: str, head: bytes, size: int) -> bool:
        return self._folder.size_of(name) == size and self._folder.head_of(name, len(head)) == head

    def __enter__(self) -> PhotonFiles:
        with contextlib.ExitStack() as stack:
            self._streams = [stack.enter_context(self._folder.stream(name)) for name in self.names]
            self._digests = [hashlib.sha256(head) for head in self._heads]
            for stream, head in zip(self._streams, self._heads, strict=True):
                stream.write(head)
            self._stack = stack.pop_all()
        return self

    def write(self, chunks: Sequence[memoryview]) -> None:
        """Add what `writer.chunks` made of the next photons."""
        for name, stream, digest, chunk in zip(self.names, self._streams, self._digests, chunks, strict=True):
            try:
                stream.write(chunk)
            except OSError as error:  # reported here, for other files are open around it
                raise os_error("write", self._folder.path / name, error) from error
            digest.update(chunk)

    def __exit__(self, *error: Any) -> bool | None:
        self._streams = []
        return self._stack.__exit__(*error)

    def entries(self) -> dict[str, dict[str, Any]]:
        """Bytes and SHA-256 of every finished file; of files that were there before, from the disk."""
        digests = [d.hexdigest() for d in self._digests] or [self._folder.sha256_of(name) for name in self.names]
        return {
            name: {"bytes": size, "sha256": digest}
            for name, size, digest in zip(self.names, self._sizes, digests, strict=True)
        }


def photon_files(folder: RunFolder, writers: Sequence[PhotonWriter], bands: Sequence[int]) -> list[PhotonFiles]:
    """All photon files of a run."""
    return [PhotonFiles(folder, writer, part) for writer in writers for part in writer.parts(bands)]
