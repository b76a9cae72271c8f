"""Photon files while they are made: which wavebands share one, whether it is finished, its bytes and its hash."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Sequence
from typing import Any, BinaryIO

from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.photons.writer import PhotonWriter


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
