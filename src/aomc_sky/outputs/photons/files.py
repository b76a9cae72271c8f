"""Photon files while they are made: what a writer says of them, their bytes and hashes, and the threads that fill them.

`ChunkPool.emit` is the one loop over the blocks of a waveband: files, pipes and workers of a cluster are its targets.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields
from functools import cached_property, partial
from importlib import import_module
from typing import Any, BinaryIO, TypeVar

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.shard import BLOCK, WHOLE_RUN, Shard
from aomc_sky.outputs.statistics import BlockSums, PhotonSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch
from aomc_sky.system import n_cpus

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

    def __init__(self, source: PhotonSource, shard: Shard = WHOLE_RUN) -> None:
        self.source, self.shard, self.suffix = source, shard, shard.suffix  #: of whose photons which the files hold

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


_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def in_order(
    executor: ThreadPoolExecutor, n_ahead: int, work: Callable[[_Item], _Result], items: Iterable[_Item]
) -> Generator[_Result, None, None]:
    """Yield what `work` makes of every item, in their order, a few ahead of the one that is used.

    Items are read on the caller's thread, `n_ahead` are worked on while one is used. With 1, for a pool of one
    thread, the caller works himself, so that one thread means one core (a worker of a cluster has no more).
    """
    if n_ahead == 1:
        yield from map(work, items)
        return
    waiting: deque[Future[_Result]] = deque()
    try:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > n_ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:  # whoever stops early may close what the work reads
        for future in waiting:
            future.cancel()
        wait(waiting)


Progress = Callable[[int, int], None]
"""Called with photons done and photons in all."""


class Meter:
    """Photons done and photons in all, reported as they change."""

    def __init__(self, progress: Progress | None = None, total: int = 0) -> None:
        self._progress = progress
        self.done, self.total = 0, total

    def add(self, n_photons: int) -> None:
        """So many more are done."""
        self.done += n_photons
        if self._progress:
            self._progress(self.done, self.total)


Target = tuple[PhotonWriter, Callable[[tuple[memoryview, ...]], object]]
"""A writer, and what takes the bytes that it makes of each block."""


class ChunkPool:
    """Threads that make the chunks of a band ahead of the one that is written, in bounded memory.

    `threads` 0 is one per CPU.
    """

    def __init__(self, source: PhotonSource, threads: int, shard: Shard = WHOLE_RUN) -> None:
        self.source, self.shard = source, shard
        self.threads = threads or n_cpus()
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")
        self._free: deque[_Memory] = deque()

    def __enter__(self) -> ChunkPool:
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def in_order(self, work: Callable[[_Item], _Result], items: Iterable[_Item]) -> Generator[_Result, None, None]:
        """What `work` makes of every item, in their order, a few ahead of the one that is used."""
        return in_order(self._executor, self.threads, work, items)

    def n_photons(self, band: int) -> int:
        """Photons of a waveband that belong to the shard."""
        return self.shard.n_photons(self.source.n_photons(band))

    def entries(self, files: Iterable[PhotonFiles]) -> dict[str, dict[str, Any]]:
        """What the manifest says of finished files, by their names."""
        return {
            name: entry for of_files in self.in_order(PhotonFiles.entries, files) for name, entry in of_files.items()
        }

    def emit(self, band: int, targets: Sequence[Target], count: Callable[[int], None]) -> PhotonSums:
        """Make the photons of a waveband: every block goes to all targets, in order; returns the sums of all.

        `count` is called with the photons of each block that is written. Its bytes are good until then, when their
        memory is used again.
        """
        sums, writers = PhotonSums(self.source.replicates), [writer for writer, _ in targets]
        spans = self.shard.block_spans(self.source.n_photons(band))
        for chunks, block, n_photons, memory in self.in_order(partial(self._chunk, band, writers), spans):
            for (writer, write), chunk in zip(targets, chunks, strict=True):
                write(chunk)
                writer.recycle(chunk)
            self._free.append(memory)
            sums.add(block)
            count(n_photons)
        return sums

    def _chunk(
        self, band: int, writers: Sequence[PhotonWriter], span: tuple[int, int]
    ) -> tuple[list[tuple[memoryview, ...]], list[BlockSums], int, _Memory]:
        start, stop = span
        try:
            memory = self._free.popleft()
        except IndexError:
            memory = _Memory(self.source)
        block = memory.block(self.source.photons(band, start, stop, out=memory.batch))
        chunks = [writer.chunks(block) for writer in writers]
        return chunks, photon_sums(self.source, band, start, block.uz, block.weight), stop - start, memory


class _Block(PhotonBatch):
    """A batch of a pool: its rows are made once for all files and leaves, into memory that is used again.

    Fresh memory costs several times what filling it does.
    """

    memory: _Memory

    @cached_property
    def directions(self) -> np.ndarray:
        """Travel directions, shape (n, 3)."""
        return np.stack([self.ux, self.uy, self.uz], axis=-1, out=self.memory.directions[: len(self)])

    @cached_property
    def positions(self) -> np.ndarray | None:
        """Positions, shape (n, 2), or None. [m]"""
        if self.x is None or self.y is None:
            return None
        return np.stack([self.x, self.y], axis=-1, out=self.memory.positions[: len(self)])


class _Memory:
    """What one block takes, touched once: the arrays of its batch and its rows."""

    def __init__(self, source: PhotonSource) -> None:
        dtype = source.dtype
        n_positions = BLOCK if source.has_positions else 0
        self.directions, self.positions = np.empty((BLOCK, 3), dtype), np.empty((n_positions, 2), dtype)
        self.batch = PhotonBatch(
            ux=np.empty(BLOCK, dtype),
            uy=np.empty(BLOCK, dtype),
            uz=np.empty(BLOCK, dtype),
            patch=np.empty(BLOCK, np.int32),
            band=0,
            start=0,
            wavelength_nm=math.nan,
            x=np.empty(BLOCK, dtype) if source.has_positions else None,
            y=np.empty(BLOCK, dtype) if source.has_positions else None,
            weight=np.empty(BLOCK, dtype) if source.has_weights else None,
        )

    def block(self, batch: PhotonBatch) -> _Block:
        """Photons that fill the arrays of `batch`, with memory for their rows."""
        block = _Block(**{field.name: getattr(batch, field.name) for field in fields(batch)})
        block.__dict__["memory"] = self
        return block
