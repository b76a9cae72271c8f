"""Leaves of the content hash, one per block: written as photons are, and compared with photons in finished files."""

from __future__ import annotations

import hashlib
from collections.abc import Generator, Iterable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.photons.files import ChunkPool, FileLayout, PhotonWriter
from aomc_sky.outputs.photons.npy import npy_layout
from aomc_sky.outputs.shard import BLOCK, Shard
from aomc_sky.outputs.statistics import BlockSums, photon_sums
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch
from aomc_sky.system import read_at

HASH_BYTES = 32
"""Length of a leaf, of a node and of a root. [bytes]"""

_LEAF, _NODE = b"\x00", b"\x01"
"""What is hashed before a leaf and before a node, so that neither can pass for the other."""


def photon_columns(batch: PhotonBatch) -> list[np.ndarray]:
    """Directions of photons, and their positions and weights where there are any."""
    return [column for column in (batch.directions, batch.positions, batch.weight) if column is not None]


def joined_rows(columns: Sequence[np.ndarray]) -> np.ndarray:
    """All numbers of a photon in one row."""
    parts = [column.reshape(len(column), -1) for column in columns]
    return parts[0] if len(parts) == 1 else np.hstack(parts)


def leaf_hash(*columns: np.ndarray) -> bytes:
    """Hash one block of n photons: SHA-256 of a zero byte and the rows, all numbers of one photon after the other.

    `columns` are travel directions (n, 3), positions (n, 2) where the run has them, weights (n,) where it has
    them, all of one dtype; hashed little-endian.
    """
    rows = joined_rows(columns)
    digest = hashlib.sha256(_LEAF)
    digest.update(np.ascontiguousarray(rows, rows.dtype.newbyteorder("<")).data.cast("B"))
    return digest.digest()


def tree_root(leaves: Iterable[bytes]) -> bytes:
    """Root of the hash tree over leaves, the tree of RFC 6962 (Certificate Transparency), section 2.1.

    Of n leaves the first 2^k, the largest power of two below n, hang from the left branch and the others
    from the right one; a node is SHA-256 of the byte 1, its left and its right branch. One leaf is
    its own root; the root of no leaves is SHA-256 of nothing. Rows of a uint8 array (n, 32) will do for leaves.
    """
    complete: list[tuple[int, bytes]] = []  # subtrees (leaves, root), each larger than the next
    for leaf in leaves:
        size, node = 1, bytes(leaf)
        while complete and complete[-1][0] == size:
            node = _node(complete.pop()[1], node)
            size *= 2
        complete.append((size, node))
    if not complete:
        return hashlib.sha256().digest()
    root = complete.pop()[1]
    while complete:
        root = _node(complete.pop()[1], root)
    return root


def _node(left: bytes, right: bytes) -> bytes:
    return hashlib.sha256(_NODE + left + right).digest()


class BlockHashWriter(PhotonWriter):
    """The files of leaves, made as photon files are: hashing happens in the threads that emit."""

    def layouts(self, bands: tuple[int, ...]) -> tuple[FileLayout, ...]:
        """The file of a waveband."""
        name = f"blocks-{bands[0] + 1:04d}{self.suffix}.npy"
        first, end = self.shard.blocks(self.source.n_photons(bands[0]))
        return (npy_layout(name, np.dtype(np.uint8), (end - first, HASH_BYTES)),)

    def chunks(self, batch: PhotonBatch) -> tuple[memoryview, ...]:
        """The leaf of a block."""
        return (memoryview(leaf_hash(*photon_columns(batch))),)

    def read(self, folder: RunFolder, band: int) -> np.ndarray:
        """Leaves of a waveband from its finished file, uint8 (n_block, 32); OutputError where it is damaged."""
        (layout,) = self.layouts((band,))
        with folder.reading(layout.name) as file:
            data = file.read(layout.size + 1)
        if len(data) != layout.size or not data.startswith(layout.head):
            n_blocks = (layout.size - len(layout.head)) // HASH_BYTES
            raise OutputError(f"{folder.path / layout.name} is damaged: it is not the list of {n_blocks} hashes")
        return np.frombuffer(data, np.uint8, offset=len(layout.head)).reshape(-1, HASH_BYTES)


def content_hash(folder: RunFolder, source: PhotonSource, bands: Sequence[int]) -> dict[str, Any]:
    """What the manifest says of the photons of a whole run: the root over all, and that of every waveband."""
    writer = BlockHashWriter(source)
    roots, of_bands = [], []
    for band in bands:
        leaves = writer.read(folder, band)
        roots.append(tree_root(leaves))
        of_bands.append({"waveband": band + 1, "n_blocks": len(leaves), "root": roots[-1].hex()})
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

    def __init__(self, folder: RunFolder, writer: PhotonWriter, band: int) -> None:
        self._folder, self._source, self._writer, self._band = folder, writer.source, writer, band
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
            done = read_at(self._files[k], data, offset)
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
        StoredPhotons(folder, writer, band) as stored,
        closing(pool.in_order(stored.block, shard.block_spans(pool.source.n_photons(band)))) as blocks,
    ):
        for leaf, block in zip(leaves, blocks, strict=True):
            agrees = block.leaf == leaf.tobytes()
            yield block, agrees
