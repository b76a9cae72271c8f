"""Leaves of the content hash, one per block: written as photons are, and compared with photons in finished files."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.blocks import BLOCK, HASH_BYTES, WHOLE_RUN, ChunkPool, Shard, leaf_hash, tree_root
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.photons.files import FileLayout, PhotonWriter
from aomc_sky.outputs.photons.npy import npy_layout
from aomc_sky.outputs.statistics import BlockSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch


class BlockHashWriter(PhotonWriter):
    """The files of leaves, made as photon files are: hashing happens in the threads that emit."""

    def __init__(self, source: PhotonSource, shard: Shard = WHOLE_RUN) -> None:
        self._source, self.shard = source, shard

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The file of a waveband."""
        name = f"blocks-{bands[0] + 1:04d}{self.shard.suffix}.npy"
        return (npy_layout(name, np.dtype(np.uint8), (self.n_blocks(bands[0]), HASH_BYTES)),)

    def n_blocks(self, band: int) -> int:
        """Blocks of a waveband."""
        first, end = self.shard.blocks(self._source.n_photons(band))
        return end - first

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """The leaf of a block."""
        columns = (batch.directions, batch.positions, batch.weight)
        return (memoryview(leaf_hash(*(column for column in columns if column is not None))),)

    def read(self, folder: RunFolder, band: int) -> np.ndarray:
        """Leaves of a waveband from its finished file, uint8 (n_block, 32); OutputError where it is damaged."""
        (layout,) = self.layouts((band,))
        with folder.reading(layout.name) as file:
            data = file.read(layout.size + 1)
        if len(data) != layout.size or not data.startswith(layout.head):
            what = f"it is not the list of {self.n_blocks(band)} hashes"
            raise OutputError(f"{folder.path / layout.name} is damaged: {what}")
        return np.frombuffer(data, np.uint8, offset=len(layout.head)).reshape(-1, HASH_BYTES)


def content_hash(folder: RunFolder, source: PhotonSource, bands: Sequence[int]) -> dict[str, Any]:
    """What the manifest says of the photons of a whole run: the root over all, and that of every waveband."""
    writer = BlockHashWriter(source)
    roots = [tree_root(writer.read(folder, band)) for band in bands]
    of_bands = [
        {"waveband": band + 1, "n_blocks": writer.n_blocks(band), "root": root.hex()}
        for band, root in zip(bands, roots, strict=True)
    ]
    return {"block_photons": BLOCK, "root": tree_root(roots).hex(), "bands": of_bands}


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredBlock:
    """One block of a waveband."""

    start: int  #: its first photon
    rows: tuple[np.ndarray, ...]  #: numbers of its photons, of each file (n, k)
    leaf: bytes  #: their hash
    sums: list[BlockSums]  #: their sums

    @property
    def n_photons(self) -> int:
        """Photons of the block."""
        return len(self.rows[0])

    @property
    def chunks(self) -> tuple[memoryview, ...]:
        """Its bytes in each file."""
        return tuple(rows.data.cast("B") for rows in self.rows)


class StoredPhotons:
    """The finished files of one waveband and writer, one that `has_rows`, open for reading from any thread.

    A context: the files are open inside it.
    """

    def __init__(self, folder: RunFolder, source: PhotonSource, writer: PhotonWriter, band: int) -> None:
        self._folder, self._source, self._writer, self._band = folder, source, writer, band
        self._layouts = writer.layouts((band,))
        self._stack = ExitStack()
        self._files: list[int] = []

    def __enter__(self) -> StoredPhotons:
        with ExitStack() as stack:
            self._files = [stack.enter_context(self._folder.reading(layout.name)).fileno() for layout in self._layouts]
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *error: Any) -> bool | None:
        self._files = []
        return self._stack.__exit__(*error)

    def block(self, span: tuple[int, int]) -> StoredBlock:
        """Photons [start, stop) of the waveband, which are one block of it."""
        start, stop = span
        rows = self.rows(start, stop)
        native = self._source.dtype
        uz = rows[0][:, 2].astype(native)
        weight = rows[-1][:, -1].astype(native) if self._source.has_weights else None
        sums = photon_sums(self._source, self._band, start, uz, weight)
        return StoredBlock(start=start, rows=rows, leaf=leaf_hash(*rows), sums=sums)

    def rows(self, start: int, stop: int) -> tuple[np.ndarray, ...]:
        """Numbers of photons [start, stop) of the waveband, of each file (n, k), little-endian."""
        first = self._writer.shard.photons(self._source.n_photons(self._band))[0]
        return tuple(self._read(k, start - first, stop - start) for k in range(len(self._files)))

    def _read(self, k: int, skipped: int, n: int) -> np.ndarray:
        dtype, width = self._writer.row_dtype, self._writer.widths[k]
        n_bytes = n * width * dtype.itemsize
        data = bytearray(n_bytes)
        try:
            offset = len(self._layouts[k].head) + skipped * width * dtype.itemsize
            done = os.preadv(self._files[k], [data], offset)
        except OSError as error:
            raise os_error("read", self._folder.path / self._layouts[k].name, error) from error
        if done != n_bytes:
            raise OutputError(f"{self._folder.path / self._layouts[k].name} became shorter while it was read")
        return np.frombuffer(data, dtype).reshape(n, width)


def compared_blocks(
    pool: ChunkPool, folder: RunFolder, writer: PhotonWriter, band: int, shard: Shard, leaves: Iterable[np.ndarray]
) -> Generator[tuple[StoredBlock, bool], None, None]:
    """Yield the blocks of a shard from finished files, and whether each agrees with its leaf.

    A run that goes on, a merge and a worker of a cluster decide by it what they keep.
    """
    with (
        StoredPhotons(folder, pool.source, writer, band) as stored,
        closing(pool.in_order(stored.block, shard.block_spans(pool.source.n_photons(band)))) as blocks,
    ):
        for leaf, block in zip(leaves, blocks, strict=True):
            agrees = block.leaf == leaf.tobytes()
            yield block, agrees
