"""Photon files: their layouts, the writers that make their bytes, and the threads that fill them.

`ChunkPool.emit` is the one loop over the blocks of a waveband; it serves files, pipes, shards and `verify`.
"""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import accumulate, chain
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeVar

import numpy as np

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.formats.text_file import refuse
from aomc_sky.kernels.backend import announce_photons, use_kernels
from aomc_sky.outputs.counts import COUNTS_FILES, chosen_bands
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, SOURCE, SOURCE_FILE, photon_writer
from aomc_sky.outputs.run_folder import PLAN, RunFolder, os_error
from aomc_sky.outputs.statistics import BlockSums, PhotonSums, photon_sums
from aomc_sky.system import appearing, n_cpus, write_at

if TYPE_CHECKING:
    from aomc_sky.formats.mcpl.header import McplHeader


BLOCK = 65_536
"""Photons that are made, written and summed together. In numpy files they fill whole pages of 4096 bytes."""


def block_spans(start: int, stop: int) -> Iterator[tuple[int, int]]:
    """First photon and end of every block from `start`, which begins a block, to `stop`."""
    return zip(range(start, stop, BLOCK), chain(range(start + BLOCK, stop, BLOCK), (stop,)), strict=False)


@dataclass(frozen=True, slots=True)
class FileLayout:
    """A complete photon file; its size is known before the first photon is made."""

    name: str
    head: bytes
    row_bytes: int  #: of each photon after the head [bytes]
    n_rows: int  #: photons

    @property
    def size(self) -> int:
        """Its length. [bytes]"""
        return len(self.head) + self.n_rows * self.row_bytes


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonRows:
    """A block of photons of one waveband."""

    start: int  #: index of the first photon
    direction: np.ndarray  #: travel directions [shape (n, 3)]
    weight: np.ndarray | None = None  #: if they are not all 1 [shape (n,)]
    #: what else the file says of each, under the names of the format [first axis n]
    others: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonFile:
    """A file of photons and the wavebands of a scene that they belong to."""

    path: Path
    #: photons, block by block, of each waveband [0-based] that has any or that the user names
    rows: Mapping[int, Callable[[], Iterator[PhotonRows]]]
    notes: tuple[str, ...] = ()  #: on photons that were left out
    header: McplHeader | None = None  #: of an MCPL file
    n_of: Mapping[int, int] = field(default_factory=dict)  #: photons of each waveband, where their energies differ


class PhotonWriter(ABC):
    """The files of a source in one format: their layouts, and the bytes of each block. It opens no file.

    `bands` are the wavebands [0-based] that share files: one of the groups of `parts`.
    """

    #: names of its files; the first one always exists; {:04d} is the waveband, from 1
    names: ClassVar[tuple[str, ...]]
    #: first bytes of a file, and size of each photon after them [bytes]
    head, row_bytes = b"", 0

    def __init__(self, source: PhotonSource) -> None:
        self.source = source

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: by default every one has its own."""
        return [(band,) for band in bands]

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The files: by default one for each waveband."""
        name, n = self.names[0].format(bands[0] + 1), self.source.launched[bands[0]]
        return (FileLayout(name, self.head, self.row_bytes, n),)

    @abstractmethod
    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """Bytes that a batch adds to each file."""

    def others(self, batch: PhotonBatch) -> dict[str, np.ndarray]:
        """What a file of this format says of each photon besides direction and weight, as `PhotonRows.others`."""
        return {}

    @staticmethod
    def read(path: Path, wavelength_nm: np.ndarray, bands: tuple[int, ...], weights: str | Path | None) -> PhotonFile:
        """Open a file for `verify`, with the wavelengths of a scene and the wavebands that the user names."""
        raise refuse(path, "photons of this format cannot be read", code="E802", advice="write them as MCPL")


Write = Callable[[int, int, tuple[memoryview, ...]], object]
"""Takes the waveband [0-based] of a block, its first photon, and its bytes for each file."""


class PhotonFiles:
    """The files of one writer for the wavebands that share them."""

    def __init__(self, folder: RunFolder, writer: PhotonWriter, bands: tuple[int, ...]) -> None:
        self.writer, self.bands, self.folder = writer, bands, folder
        self.layouts = writer.layouts(bands)
        self.is_written = False  #: whether `writing` has made them
        rows = accumulate((writer.source.launched[band] for band in bands[:-1]), initial=0)
        self._rows_before = dict(zip(bands, rows, strict=False))

    @cached_property
    def missing(self) -> list[FileLayout]:
        """Files that do not exist. They are looked for once, since a name appears only when its file is complete."""
        return _missing(self.folder, self.layouts)

    def offset(self, layout: FileLayout, band: int, photon: int) -> int:
        """Position of a photon in a file. [bytes]"""
        return len(layout.head) + (self._rows_before[band] + photon) * layout.row_bytes

    @contextlib.contextmanager
    def writing(self) -> Iterator[Write]:
        """Make the files; they get their names if the block ends without an error, and are removed otherwise."""
        with contextlib.ExitStack() as stack:
            handles: list[int | None] = []
            for layout in self.layouts:
                file = stack.enter_context(appearing(self.folder.path / layout.name))
                file.write(layout.head)
                file.flush()
                handles.append(file.fileno())
            yield partial(self._put, handles)
        self.is_written = True

    def reserve(self) -> None:
        """Make the missing files at full size, for shards to fill."""
        for layout in self.missing:
            self.folder.reserve(layout.name, layout.head, layout.size)

    @contextlib.contextmanager
    def filling(self) -> Iterator[Write]:
        """Open reserved files; all bytes are on the disk when the block ends."""
        with contextlib.ExitStack() as stack:
            handles = [stack.enter_context(self.folder.filling(layout.name)) for layout in self.layouts]
            yield partial(self._put, handles)

    def _put(self, handles: list[int | None], band: int, start: int, chunks: tuple[memoryview, ...]) -> None:
        for layout, handle, chunk in zip(self.layouts, handles, chunks, strict=True):
            offset, data = self.offset(layout, band, start), chunk
            try:
                while handle is not None and data:
                    done = write_at(handle, data, offset)
                    data, offset = data[done:], offset + done
            except OSError as error:  # reported here, because several files are open
                raise os_error("write", self.folder.path / layout.name, error) from error


def photon_files(folder: RunFolder, writers: Iterable[PhotonWriter], bands: Sequence[int]) -> list[PhotonFiles]:
    """All photon files of a run."""
    return [PhotonFiles(folder, writer, part) for writer in writers for part in writer.parts(bands)]


def _missing(folder: RunFolder, layouts: Sequence[FileLayout]) -> list[FileLayout]:
    """The files among these that do not exist."""
    sizes = folder.sizes_of([layout.name for layout in layouts])
    return [one for one in layouts if sizes.get(one.name) != one.size or not folder.begins(one.name, one.head)]


def missing_files(files: Sequence[PhotonFiles]) -> list[PhotonFiles]:
    """Those of a folder of which a file does not exist."""
    missing = {file.name for file in _missing(files[0].folder, _layouts(files))} if files else set()
    return [part for part in files if any(layout.name in missing for layout in part.layouts)]


def _layouts(files: Sequence[PhotonFiles]) -> list[FileLayout]:
    return [layout for part in files for layout in part.layouts]


class StoredFile(NamedTuple):
    """A file in a run folder."""

    size: int  #: [bytes]
    format: str = ""  #: of its photons; empty where it holds none


class RunFiles:
    """The photon files of a run in its folder: each writer and each layout is made once.

    `bands` are those of the run unless they are given. [0-based]
    """

    def __init__(self, source: PhotonSource, folder: RunFolder, bands: Sequence[int] | None = None) -> None:
        self.source, self.folder = source, folder
        self.bands = chosen_bands(source) if bands is None else bands
        self._made: dict[str, list[PhotonFiles]] = {}

    def of(self, name: str) -> list[PhotonFiles]:
        """The files of a format, whether they exist or not."""
        if name not in self._made:
            self._made[name] = photon_files(self.folder, [photon_writer(name)(self.source)], self.bands)
        return self._made[name]

    def stored_formats(self) -> list[str]:
        """Formats of which the folder has at least one file now; others are not imported."""
        left, found = {*self.folder.photon_names()}, []
        for name in PHOTON_FORMATS:
            if not left:
                break
            first, *others = (
                {pattern.format(band + 1) for band in self.bands} for pattern in photon_writer(name).names
            )
            if not left.isdisjoint(first):
                found.append(name)
            left.difference_update(first, *others)
        return found

    def stored(self) -> tuple[list[str], dict[str, StoredFile]]:
        """Formats that the folder holds completely now, and all files of the run in it by name.

        Their names follow from the plan. The heads of files that were made here are not read again.
        """
        parts = {name: self.of(name) for name in self.stored_formats()}
        format_of_file = {layout.name: name for name, files in parts.items() for layout in _layouts(files)}
        sizes = self.folder.sizes_of([PLAN, SOURCE_FILE, *COUNTS_FILES, *format_of_file])

        def is_there(part: PhotonFiles) -> bool:
            has_sizes = all(sizes.get(layout.name) == layout.size for layout in part.layouts)
            return has_sizes and (
                part.is_written or all(self.folder.begins(one.name, one.head) for one in part.layouts)
            )

        complete = [name for name, files in parts.items() if all(map(is_there, files))]
        complete += [SOURCE] * (SOURCE_FILE in sizes)
        return complete, {name: StoredFile(size, format_of_file.get(name, "")) for name, size in sizes.items()}


def stacked(batch: PhotonBatch) -> np.ndarray:
    """A row of numbers for each photon: the columns of `columns_of`."""
    columns = [batch.ux, batch.uy, batch.uz, batch.x, batch.y, batch.weight, batch.q, batch.u]
    return np.stack([c for c in columns if c is not None], axis=-1)


_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def in_order(
    executor: ThreadPoolExecutor, n_ahead: int, work: Callable[[_Item], _Result], items: Iterable[_Item]
) -> Generator[_Result, None, None]:
    """Yield `work(item)` for every item, in order, while threads work on the next `n_ahead` items.

    Items are read on the caller's thread. With `n_ahead` 1 the caller's thread does all the work, so that one thread
    means one core, as a worker of a cluster has it.
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
    finally:  # a caller that stops early may close what the work reads
        for future in waiting:
            future.cancel()
        wait(waiting)


Progress = Callable[[int, int], None]
"""Called with photons done and photons in all."""


class Meter:
    """Counts photons and reports the count."""

    def __init__(self, progress: Progress | None = None, total: int = 0) -> None:
        self._progress = progress
        self.done, self.total = 0, total

    def add(self, n_photons: int) -> None:
        """Count more photons as done."""
        self.done += n_photons
        if self._progress:
            self._progress(self.done, self.total)


Target = tuple[PhotonWriter, Write]
"""A writer, and the function that takes the bytes of each block."""


class ChunkPool:
    """Threads that make blocks of photons ahead of the one that is written, in bounded memory; 0 is one per CPU."""

    def __init__(self, source: PhotonSource, threads: int) -> None:
        self.source = source
        self.threads = threads or n_cpus()
        self._executor = ThreadPoolExecutor(max_workers=self.threads, thread_name_prefix="aomc-sky")

    def __enter__(self) -> ChunkPool:
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def emit(
        self,
        band: int,
        targets: Sequence[Target],
        count: Callable[[int], None],
        spans: Iterable[tuple[int, int]] | None = None,
    ) -> PhotonSums:
        """Make the photons of a waveband, give each block to all targets in order, and return the sums over photons.

        `spans` are the blocks, by default all. `count` is called with the photons of each block after it is written.
        """
        sums, writers = PhotonSums(self.source.replicates), [writer for writer, _ in targets]
        chosen = block_spans(0, self.source.launched[band]) if spans is None else spans
        if use_kernels(0) and self.source.launched[band]:
            self._chunk(band, writers, (0, 1))  # compiles here, for the main thread alone hears Ctrl-C
        made = in_order(self._executor, self.threads, partial(self._chunk, band, writers), chosen)
        with contextlib.closing(made):  # if a target fails, threads end before the pool does
            for start, chunks, block, n_photons in made:
                for (_, write), chunk in zip(targets, chunks, strict=True):
                    write(band, start, chunk)
                sums.add(block)
                count(n_photons)
        return sums

    def _chunk(
        self, band: int, writers: Sequence[PhotonWriter], span: tuple[int, int]
    ) -> tuple[int, list[tuple[memoryview, ...]], list[BlockSums], int]:
        batch = self.source.photons(band, *span)
        chunks = [writer.chunks(batch) for writer in writers]
        return batch.start, chunks, photon_sums(self.source, band, batch.start, batch.uz, batch.weight), len(batch)


def total_size(files: Sequence[PhotonFiles]) -> int:
    """Size of all the files. [bytes]"""
    return sum(layout.size for layout in _layouts(files))


def require_space(files: Sequence[PhotonFiles]) -> None:
    """Raise if the disk has no space for the files."""
    if files:
        files[0].folder.require_space(total_size(files))


def emit_photons(
    source: PhotonSource,
    files: Sequence[PhotonFiles],
    bands: Sequence[int],
    threads: int,
    progress: Progress | None = None,
) -> dict[int, PhotonSums]:
    """Make the photons of wavebands, write those that belong to the files, and return the sums of each waveband."""
    sums, meter = {}, Meter(progress, sum(source.launched[band] for band in bands))
    announce_photons(meter.total)
    with ChunkPool(source, threads) as pool, contextlib.ExitStack() as stack:
        shared = [(f.writer, stack.enter_context(f.writing())) for f in files if len(f.bands) > 1]
        for band in bands:
            with contextlib.ExitStack() as band_files:
                own = [(f.writer, band_files.enter_context(f.writing())) for f in files if f.bands == (band,)]
                sums[band] = pool.emit(band, [*own, *shared], meter.add)
    return sums
