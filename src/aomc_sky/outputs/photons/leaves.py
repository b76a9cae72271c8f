"""``blocks-0001.npy``: the leaves of the content hash, one row per block of 65 536 photons of a waveband."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.blocks.content_tree import BLOCK, HASH_BYTES, leaf_hash, tree_root
from aomc_sky.outputs.blocks.shard import WHOLE, Shard
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.npy import npy_header
from aomc_sky.outputs.photons.writer import PhotonWriter
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch


class BlockHashWriter(PhotonWriter):
    """The files of leaves, made as photon files are: hashing happens in the threads that emit."""

    def __init__(self, source: PhotonSource, shard: Shard = WHOLE) -> None:
        self._source, self.shard = source, shard

    def names(self, bands: tuple[int, ...]) -> tuple[str, ...]:
        """The file of a part."""
        return (f"blocks-{bands[0] + 1:04d}{self.shard.suffix}.npy",)

    def headers(self, bands: tuple[int, ...]) -> tuple[bytes, ...]:
        """Bytes that the file starts with."""
        return (npy_header(np.dtype(np.uint8), (self.n_blocks(bands[0]), HASH_BYTES)),)

    def sizes(self, bands: tuple[int, ...]) -> tuple[int, ...]:
        """Length of the finished file. [bytes]"""
        return (len(self.headers(bands)[0]) + self.n_blocks(bands[0]) * HASH_BYTES,)

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
        name, head, size = self.names((band,))[0], self.headers((band,))[0], self.sizes((band,))[0]
        with folder.reading(name) as file:
            data = file.read(size + 1)
        if len(data) != size or not data.startswith(head):
            raise OutputError(f"{folder.path / name} is damaged: it is not the list of {self.n_blocks(band)} hashes")
        return np.frombuffer(data, np.uint8, offset=len(head)).reshape(-1, HASH_BYTES)


def content_hash(folder: RunFolder, source: PhotonSource, bands: Sequence[int]) -> dict[str, Any]:
    """What the manifest says of the photons of a whole run: the root over all, and that of every waveband."""
    writer = BlockHashWriter(source)
    roots = [tree_root(writer.read(folder, band)) for band in bands]
    of_bands = [
        {"waveband": band + 1, "n_blocks": writer.n_blocks(band), "root": root.hex()}
        for band, root in zip(bands, roots, strict=True)
    ]
    return {"block_photons": BLOCK, "root": tree_root(roots).hex(), "bands": of_bands}
